#include "optim/job/job_tables.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace flexopt {

using nlohmann::json;
using namespace shape;

template <>
void read_member(const json& read, Vector3d& member) {
  for (int i = 0; i < 3; ++i) member[i] = read[static_cast<std::size_t>(i)].get<double>();
}

template <>
json written_member(const Vector3d& member) {
  return {member[0], member[1], member[2]};
}

/// Three principal values or three rows.
template <>
void read_member(const json& read, Matrix3d& member) {
  member.setZero();
  for (int i = 0; i < 3; ++i) {
    const json& item = read[static_cast<std::size_t>(i)];
    if (item.is_array())
      for (int j = 0; j < 3; ++j) member(i, j) = item[static_cast<std::size_t>(j)].get<double>();
    else
      member(i, i) = item.get<double>();
  }
}

template <>
json written_member(const Matrix3d& member) {
  if (member.isDiagonal(0)) return written_member<Vector3d>(member.diagonal());
  json rows = json::array();
  for (int i = 0; i < 3; ++i) rows.push_back(written_member<Vector3d>(member.row(i)));
  return rows;
}

Shape vector3(const std::string& unit, double largest) {
  return list(quantity(unit, -largest, largest), 3, 3);
}

namespace {

const EnumNames<JobKind> kind_names{{"evaluate", JobKind::evaluate},
                                    {"optimise", JobKind::optimise},
                                    {"compare", JobKind::compare}};

}  // namespace

std::string name_of(JobKind kind) { return name_of(kind_names, kind); }

const RecordTable<Job>& head_table() {
  static const auto table =
      RecordTable<Job>()
          .row(shape::with_default("name", text(200), "job", "for the report"), &Job::name)
          .choice<JobKind>("job", kind_names, &Job::kind, "what to do")
          .row(
              shape::with_default("frequencies", integer(0, 100), 6,
                                  "how many, drive free and drive locked each"),
              [](auto& job) -> auto& { return job.request.frequencies; });
  return table;
}

const RecordTable<EndEffector>& end_effector_table() {
  const Shape principal = quantity("kg m^2", 0, largest_number);
  const Shape any = quantity("kg m^2", -largest_number, largest_number);
  static const auto table =
      RecordTable<EndEffector>()
          .with_default("mass", quantity("kg", 0, largest_number), &EndEffector::mass,
                        "mass of the rigid end-effector")
          .with_default(
              "inertia", one_of({list(principal, 3, 3), list(list(any, 3, 3), 3, 3)}),
              &EndEffector::inertia,
              "about its centre of mass, global axes: three principal values or a symmetric 3x3")
          .with_default("center_of_mass", vector3("m", 1e3), &EndEffector::center_of_mass,
                        "relative to O");
  return table;
}

Shape stroke_place(Direction direction) {
  constexpr double farthest = 100, most_radians = 100;  // [m], [rad]
  if (is_rotation(direction)) return quantity("rad", -most_radians, most_radians);
  return quantity("m", -farthest, farthest);
}

RecordTable<StrokeSpec> stroke_table(std::optional<Direction> drive) {
  const Shape place = drive ? stroke_place(*drive) : quantity("");
  return RecordTable<StrokeSpec>()
      .optional("from", place, &StrokeSpec::from, "first point of the stroke; default 0")
      .optional("to", place, &StrokeSpec::to, "last point of the stroke")
      .optional("points", integer(1, 10001), &StrokeSpec::points,
                "how many, both ends included; default 11")
      .optional("at", list(place, 1, 10001), &StrokeSpec::at,
                "the points one by one, instead of from, to, points")
      .with_default("in_order", boolean(), &StrokeSpec::in_order, in_order_meaning);
}

Field follows_field() {
  return shape::optional("follows", choice({"body"}),
                         "what force and moment turn with; default nothing: they keep their "
                         "direction");
}

void read_follows(const json&, LoadSpec& load) { load.follows = true; }

const RecordTable<LoadSpec>& load_table() {
  static const auto table =
      RecordTable<LoadSpec>()
          .row(follows_field(), read_follows)
          .optional("name", text(100), &LoadSpec::name, "for the job's other sections")
          .optional("body", text(100), &LoadSpec::body,
                    "on which it acts; default the end-effector")
          .optional("at", vector3("m", 1e3), &LoadSpec::at,
                    "place on that body, undeflected, global axes; default its reference point")
          .with_default("force", vector3("N", largest_number), &LoadSpec::force,
                        "at the undeflected place; keeps its direction, or that in its body")
          .with_default("moment", vector3("N m", largest_number), &LoadSpec::moment, "likewise");
  return table;
}

const RecordTable<LoadSpec>& load_path_table() {
  static const auto table = RecordTable<LoadSpec>()
                                .row(follows_field(), read_follows)
                                .with_default("force", vector3("N", largest_number),
                                              &LoadSpec::force, "force at O at its end")
                                .with_default("moment", vector3("N m", largest_number),
                                              &LoadSpec::moment, "moment at O at its end")
                                .with_default("points", integer(2, 10001), &LoadSpec::points,
                                              "how many, zero and the whole load included");
  return table;
}

namespace {

/// Three sizes of an edge, each a number or a formula of parameters.
Shape edge_sizes(const std::string& unit) {
  return list(
      shape::one_of(
          {quantity(unit, -largest_edge_size, largest_edge_size),
           shape::record({shape::required("expression", text(), "a formula of parameters")})}),
      3, 3);
}

void read_sizes(const json& read, int first_axis, Vector3d& sizes, AssemblySpec& error) {
  for (int i = 0; i < 3; ++i) {
    const json& size = read[static_cast<std::size_t>(i)];
    if (size.is_object())
      error.formulas[first_axis + i] = size["expression"];
    else
      sizes[i] = size;
  }
}

}  // namespace

const RecordTable<AssemblySpec>& assembly_table() {
  const json zero{0, 0, 0};
  static const auto table =
      RecordTable<AssemblySpec>()
          .required("leaf", text(100), &AssemblySpec::leaf, "whose edge it is")
          .row(shape::required("end", choice({"base", "tip"}), "which of its edges"),
               [](const json& read, AssemblySpec& error) { error.end = read == "tip" ? 1 : 0; })
          .row(shape::with_default(
                   "move", edge_sizes("m"), zero,
                   "of the edge's middle relative to the body that holds it, global axes"),
               [](const json& read, AssemblySpec& e) { read_sizes(read, 0, e.move, e); })
          .row(shape::with_default("turn", edge_sizes("rad"), zero,
                                   "rotation vector of the edge about its middle, global axes"),
               [](const json& read, AssemblySpec& e) { read_sizes(read, 3, e.turn, e); });
  return table;
}

Shape temperature_shape() {
  constexpr double largest = 1e4;  // [K]
  const Shape change = quantity("K", -largest, largest);
  return record(
      {shape::with_default("change", change, 0.0, "of all leaves, since assembly"),
       shape::with_default("leaves", map(change), json::object(),
                           "of single leaves by their names, instead of that of all"),
       shape::with_default(
           "bodies", map(change), json::object(),
           "of bodies by their names, \"ground\" among them; others stay as they are, but "
           "for pieces of leaves (reinforcements, rigid folds), which are as warm as these"),
       shape::optional("thermal_expansion", quantity("1/K", -1e-3, 1e-3),
                       "of the bodies; default: that of the leaves")});
}

const RecordTable<NamedPointSpec>& named_point_table() {
  const auto read_direction = [](const json& read, NamedPointSpec& point) {
    Vector6d along = Vector6d::Zero();
    if (read.is_string())
      along[std::ranges::find(direction_names, read.get_ref<const std::string&>()) -
            direction_names.begin()] = 1;
    else
      for (int k = 0; k < 3; ++k) along[k] = read[static_cast<std::size_t>(k)];
    point.direction = along.normalized();
  };
  static const auto table =
      RecordTable<NamedPointSpec>()
          .required("name", text(100), &NamedPointSpec::name, "in the results")
          .optional("body", text(100), &NamedPointSpec::body,
                    "to which it is fixed; default: it is the material point of the leaf that is "
                    "there, or fixed to the end-effector where none is")
          .optional("at", vector3("m", 1e3), &NamedPointSpec::at,
                    "its place, undeflected, global axes; on a leaf its foot on the mid-surface; "
                    "default: the reference point of the body that is named")
          .row(shape::optional(
                   "direction",
                   one_of({choice({direction_names.begin(), direction_names.end()}),
                           vector3("1", 1e6)}),
                   "along which it moves and is loaded, global axes, which do not turn with the "
                   "body; a rotation is that of the body; default: along x, y and z"),
               read_direction);
  return table;
}

const RecordTable<Expectation>& expectation_table() {
  static const auto table =
      RecordTable<Expectation>()
          .required("pointer", text(), &Expectation::pointer, "into the result")
          .required("value", quantity("1"), &Expectation::value, "expected, SI")
          .required("tolerance", quantity("1", 0, Shape::infinity), &Expectation::tolerance,
                    "largest difference, SI")
          .row(shape::with_default("source", text(2000), "unnamed", "where the value comes from"),
               &Expectation::source);
  return table;
}

const RecordTable<WorkLimits>& limits_table() {
  constexpr double longest = 1e7;  // some months
  static const auto table =
      RecordTable<WorkLimits>()
          .optional("seconds", quantity("s", 0, longest, true), &WorkLimits::seconds,
                    "by the clock: what is beyond depends on the machine and its load")
          .optional("iterations", integer(1, 1e9), &WorkLimits::iterations,
                    "Newton iterations, those that make reduced leaves among them: the same on "
                    "every machine");
  return table;
}

}  // namespace flexopt
