#include "optim/job/job_tables.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>

#include "designs/s_n_curve_json.hpp"
#include "optim/job/job_tolerances.hpp"

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

template <>
void read_member(const json& read, std::optional<Vector3d>& member) {
  read_member(read, member.emplace());
}

template <>
json written_member(const std::optional<Vector3d>& member) {
  return member ? written_member(*member) : json();
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

namespace {

const EnumNames<OverStroke> over_stroke_names{{"min", OverStroke::min},
                                              {"max", OverStroke::max},
                                              {"max_abs", OverStroke::max_abs},
                                              {"first", OverStroke::first},
                                              {"last", OverStroke::last}};

const EnumNames<Reduction> reduction_names{
    {"mixed_potential", Reduction::mixed_potential},
    {"linear_craig_bampton", Reduction::linear_craig_bampton},
    {"modal_derivatives", Reduction::modal_derivatives},
    {"quadratic_manifold", Reduction::quadratic_manifold}};

const EnumNames<SampleMethod> sample_method_names{
    {"sobol", SampleMethod::sobol},
    {"latin_hypercube", SampleMethod::latin_hypercube},
    {"grid", SampleMethod::grid},
    {"list", SampleMethod::list}};

template <class Enum>
std::string name_of(const EnumNames<Enum>& names, Enum wanted) {
  return std::ranges::find(names, wanted, &std::pair<const char*, Enum>::second)->first;
}

/// Leads to a member of a ModelChoice's model.
template <class Member>
auto in_model(Member ModelOptions::*member) {
  return [member](auto& choice) -> auto& { return choice.model.*member; };
}

Shape seed_shape() { return integer(0, 4294967295.0); }

constexpr const char* over_stroke_meaning =
    "how a quantity's values over the stroke become one; default: the worst";
constexpr const char* case_meaning = "the load case that counts; default: the worst of all";

}  // namespace

std::string name_in_job(Reduction method) { return name_of(reduction_names, method); }
std::string name_in_job(OverStroke over) { return name_of(over_stroke_names, over); }
std::string name_in_job(SampleMethod method) { return name_of(sample_method_names, method); }

Shape vector3(const std::string& unit, double largest) {
  return list(quantity(unit, -largest, largest), 3, 3);
}

const RecordTable<Job>& head_table() {
  static const auto table =
      RecordTable<Job>()
          .row(shape::with_default("name", text(200), "job", "for the report"), &Job::name)
          .choice<JobKind>("job",
                           {{"evaluate", JobKind::evaluate},
                            {"optimise", JobKind::optimise},
                            {"compare", JobKind::compare}},
                           &Job::kind, "what to do")
          .row(
              shape::with_default("frequencies", integer(0, 100), 6,
                                  "how many, drive free and drive locked each"),
              [](auto& job) -> auto& { return job.request.frequencies; });
  return table;
}

const RecordTable<Material>& material_table() {
  const auto read_ratio = [](const json& read, Material& m) { m.poissons_ratio = read; };
  const auto written_ratio = [](const Material& m) {
    return m.poissons_ratio <= 0.5 ? json(m.poissons_ratio) : json();
  };
  const auto read_shear = [](const json& read, Material& m) {
    const double implied = m.youngs_modulus / (2 * read.get<double>()) - 1;
    // what a plate cannot be made of, a beam can: check_leaf_model tells
    m.poissons_ratio = implied < 0.5 + 1e-9 ? std::min(implied, 0.5) : implied;
  };
  const auto written_shear = [](const Material& m) {
    return m.poissons_ratio <= 0.5 ? json() : json(m.shear_modulus());
  };
  static const auto table =
      RecordTable<Material>()
          .optional("name", text(), &Material::name, "for the report")
          .required("youngs_modulus", quantity("Pa", 0, largest_number * 10, true),
                    &Material::youngs_modulus, "Young's modulus E")
          .row(shape::optional("poissons_ratio", quantity("1", -1, 0.5, true),
                               "Poisson's ratio; or give shear_modulus"),
               read_ratio, written_ratio)
          .row(shape::optional("shear_modulus", quantity("Pa", 0, largest_number * 10, true),
                               "shear modulus G = E / (2 (1 + nu)); or give poissons_ratio"),
               read_shear, written_shear)
          .required("density", quantity("kg/m^3", 0, 1e5, true), &Material::density, "density")
          .optional("allowable_stress", quantity("Pa", 0, largest_number, true),
                    &Material::allowable_stress, "von Mises stress a leaf may see; for the report")
          .optional("yield_strength", quantity("Pa", 0, largest_number, true),
                    &Material::yield_strength,
                    "stress at which it yields (Rp0.2), for yield_safety")
          .optional("ultimate_strength", quantity("Pa", 0, largest_number, true),
                    &Material::ultimate_strength, "tensile strength (Rm), for fatigue_safety")
          .optional("endurance_limit", quantity("Pa", 0, largest_number, true),
                    &Material::endurance_limit,
                    "stress amplitude at mean zero that the leaf endures, "
                    "with surface and size as made; for fatigue_safety")
          .row(
              s_n_curve_field(),
              [](const json& read, Material& m) {
                m.s_n_curve = s_n_curve_of(read, JsonPointer("/design/material/s_n_curve"));
              },
              [](const Material& m) {
                return m.s_n_curve ? written_s_n_curve(*m.s_n_curve) : json();
              })
          .optional("thermal_expansion", quantity("1/K", -1e-3, 1e-3), &Material::thermal_expansion,
                    "linear coefficient of thermal expansion, for temperature");
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
              "about its centre of mass, global axes: three principal values or a symmetric "
              "3x3")
          .with_default("center_of_mass", vector3("m", 1e3), &EndEffector::center_of_mass,
                        "relative to O");
  return table;
}

Shape stroke_place(Direction direction) {
  constexpr double farthest = 100;  // [m]
  if (is_rotation(direction))
    return quantity("rad", -std::numbers::pi, std::numbers::pi, true, true);
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
                "the points one by one, instead of from, to, points");
}

const RecordTable<LoadSpec>& load_table() {
  static const auto table =
      RecordTable<LoadSpec>()
          .optional("name", text(100), &LoadSpec::name, "for the job's other sections")
          .optional("body", text(100), &LoadSpec::body,
                    "on which it acts; default the end-effector")
          .optional("at", vector3("m", 1e3), &LoadSpec::at,
                    "place on that body, undeflected, global axes; default its reference point")
          .with_default("force", vector3("N", largest_number), &LoadSpec::force,
                        "dead force; keeps its direction")
          .with_default("moment", vector3("N m", largest_number), &LoadSpec::moment, "dead moment");
  return table;
}

const RecordTable<LoadSpec>& load_path_table() {
  static const auto table = RecordTable<LoadSpec>()
                                .with_default("force", vector3("N", largest_number),
                                              &LoadSpec::force, "dead force at O at its end")
                                .with_default("moment", vector3("N m", largest_number),
                                              &LoadSpec::moment, "dead moment at O at its end")
                                .with_default("points", integer(2, 10001), &LoadSpec::points,
                                              "how many, zero and the whole load included");
  return table;
}

const RecordTable<AssemblySpec>& assembly_table() {
  static const auto table =
      RecordTable<AssemblySpec>()
          .required("leaf", text(100), &AssemblySpec::leaf, "whose edge it is")
          .row(
              shape::required("end", choice({"base", "tip"}), "which of its edges"),
              [](const json& read, AssemblySpec& error) { error.end = read == "tip" ? 1 : 0; },
              [](const AssemblySpec& error) -> json { return error.end == 1 ? "tip" : "base"; })
          .with_default("move", vector3("m", 1), &AssemblySpec::move,
                        "of the edge's middle relative to the body that holds it, global axes")
          .with_default("turn", vector3("rad", 1), &AssemblySpec::turn,
                        "rotation vector of the edge about its middle, global axes");
  return table;
}

Shape temperature_shape() {
  constexpr double largest = 1e4;  // [K]
  const Shape change = quantity("K", -largest, largest);
  return record({shape::with_default("change", change, 0.0, "of all leaves, since assembly"),
                 shape::with_default("leaves", map(change), json::object(),
                                     "of single leaves by their names, instead of that of all"),
                 shape::with_default(
                     "bodies", map(change), json::object(),
                     "of bodies by their names, \"ground\" among them; others stay as they are"),
                 shape::optional("thermal_expansion", quantity("1/K", -1e-3, 1e-3),
                                 "of the bodies; default: that of the leaves' material")});
}

const RecordTable<BucklingSpec>& buckling_table() {
  static const auto table = RecordTable<BucklingSpec>().required(
      "load", text(100), &BucklingSpec::load,
      "name of the dead load that grows, all else kept, until the tangent is singular");
  return table;
}

const RecordTable<ProbeSpec>& probe_table() {
  static const auto table =
      RecordTable<ProbeSpec>()
          .required("name", text(100), &ProbeSpec::name, "in the results")
          .required("at", vector3("m", 1e3), &ProbeSpec::at,
                    "place on an undeflected leaf; its foot on the mid-surface");
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

const RecordTable<ModelChoice>& model_table() {
  const auto read_superelements = [](const json& read, ModelChoice& choice) {
    if (read.is_array())
      read_member(read, choice.model.superelements);
    else
      choice.model.superelements = {read.get<int>(), 0};
  };
  const auto written_superelements = [](const ModelChoice& choice) {
    const std::array<int, 2>& cut = choice.model.superelements;
    return cut[1] == 0 ? json(cut[0]) : json(cut);
  };
  const auto read_accuracy = [](const json& read, ModelChoice& choice) {
    choice.model.accuracy = read == "full" ? Accuracy::full : Accuracy::reduced;
    choice.accuracy.automatic = read == "auto";
  };
  const auto written_accuracy = [](const ModelChoice& choice) -> json {
    if (choice.accuracy.automatic) return "auto";
    return choice.model.accuracy == Accuracy::full ? "full" : "reduced";
  };
  static const auto table =
      RecordTable<ModelChoice>()
          .choice<Flexure>(
              "flexure", {{"plate", Flexure::plate}, {"beam", Flexure::beam}},
              in_model(&ModelOptions::flexure),
              "kinematics of a leaf: a thin plate, or a beam with straight lines across")
          .choice<Warping>("warping", {{"clamped", Warping::clamped}, {"free", Warping::free}},
                           in_model(&ModelOptions::warping),
                           "whether the ends of a beam hold the warping of its section")
          .row(shape::with_default(
                   "accuracy", shape::choice({"reduced", "full", "auto"}), "reduced",
                   "superelements, or the discretisation they were made from; auto: that and the "
                   "mesh are chosen so that estimated errors are below the tolerance"),
               read_accuracy, written_accuracy)
          .with_default(
              "estimate", boolean(), [](auto& choice) -> auto& { return choice.accuracy.estimate; },
              "estimated errors beside the numbers; auto has them anyway")
          .choice<Reduction>("method", reduction_names, in_model(&ModelOptions::method),
                             "the reduction")
          .optional_choice<ModalDerivativeSet>(
              "modal_derivatives",
              {{"bending", ModalDerivativeSet::bending},
               {"all", ModalDerivativeSet::all},
               {"third_order", ModalDerivativeSet::third_order}},
              in_model(&ModelOptions::modal_derivatives),
              "of the method modal_derivatives, the fields beside the boundary modes: derivatives "
              "of the bending modes, of all modes, or third-order fields too; default all")
          .row(shape::optional("superelements",
                               one_of({integer(1, 100), list(integer(1, 100), 2, 2)}),
                               "n of two edges along a leaf, between rigid lines; of "
                               "linear_craig_bampton also [along, across] of four nodes; default "
                               "1, as mixed_potential has it"),
               read_superelements, written_superelements)
          .with_default("mesh", list(integer(2, 128), 2, 2), in_model(&ModelOptions::mesh),
                        "elements of a leaf, [along, across]")
          .with_default(
              "free_edge_torsion", boolean(), in_model(&ModelOptions::free_edge_torsion),
              "the three-dimensional torsion layer of the free edges; off: the thin-shell "
              "limit")
          .with_default("transverse_shear", boolean(), in_model(&ModelOptions::transverse_shear),
                        "of leaves and wires; off: thin plates and slender beams")
          .with_default("degree", integer(5, 7), in_model(&ModelOptions::degree),
                        "of the reduced potential: 5 or 7")
          .choice<LeafMass>(
              "mass", {{"consistent", LeafMass::consistent}, {"constant", LeafMass::constant}},
              in_model(&ModelOptions::mass),
              "of the leaves in the frequencies: of the deflected leaf; or of the undeflected "
              "one, turned with its chord")
          .choice<AtlasUse>("atlas",
                            {{"off", AtlasUse::off},
                             {"auto", AtlasUse::automatic},
                             {"required", AtlasUse::required}},
                            in_model(&ModelOptions::atlas_use),
                            "whether the coefficients of reduced leaves are looked up in the atlas "
                            "that flexopt atlas makes: never; where there is one; or the job is "
                            "wrong without it")
          .with_default(
              "leaf_modes", integer(0, 40), in_model(&ModelOptions::leaf_modes),
              "modes of a leaf between fixed edges kept for the frequencies, at least; 0: "
              "leaves move only as their edges make them")
          .with_default(
              "tolerance", quantity("1", 0, 1e-3, true),
              [](auto& choice) -> auto& { return choice.newton.tolerance; },
              "Newton's largest last correction, lengths divided by the leaf length; of "
              "\"accuracy\": "
              "\"auto\" the largest estimated error");
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

const RecordTable<OptimiseSpec>& search_table() {
  static const auto table =
      RecordTable<OptimiseSpec>()
          .choice<SearchKind>("search",
                              {{"starts", SearchKind::starts}, {"global", SearchKind::global}},
                              &OptimiseSpec::search,
                              "where the starts are from: the job's values and a spread over the "
                              "box, or the best of the clusters of many screened designs")
          .optional("screened_designs", integer(2, 1000000), &OptimiseSpec::screened_designs,
                    "of a global search, on reduced leaves, before the starts; default: 2000 for "
                    "each variable, rounded up to a power of two, at most 65536")
          .optional("starts", integer(1, 1000), &OptimiseSpec::starts,
                    "starts: the first at the job's values, the others spread over the box; of a "
                    "global search, from as many clusters; default 1, of a global search 8")
          .choice<Spread>("spread",
                          {{"sobol", Spread::sobol}, {"latin_hypercube", Spread::latin_hypercube}},
                          &OptimiseSpec::spread, "how the starts but the first are spread")
          .with_default("seed", seed_shape(), &OptimiseSpec::seed, "of the spread of the starts")
          .with_default("max_evaluations", integer(1, 1000000), &OptimiseSpec::max_evaluations,
                        "for each start")
          .with_default("tolerance", quantity("1", 0, 0.1, true), &OptimiseSpec::tolerance,
                        "relative change of scaled variables and objective that ends a start")
          .with_default("constraint_tolerance", quantity("1", 0, 0.1, true),
                        &OptimiseSpec::constraint_tolerance,
                        "allowed violation, relative to the bound");
  return table;
}

const RecordTable<Objective>& objective_table() {
  static const auto table =
      RecordTable<Objective>()
          .other(shape::optional("maximise", text(),
                                 "a quantity of a path point, or a formula of the parameters"))
          .other(shape::optional("minimise", text(), "the same, to be made small"))
          .optional_choice<OverStroke>(
              "over_stroke", over_stroke_names, &Objective::over_stroke,
              "how its values over the stroke become one; default: the worst")
          .optional("case", text(100), &Objective::load_case, case_meaning)
          .other(under_field())
          .other(margin_field());
  return table;
}

const RecordTable<Constraint>& constraint_table() {
  static const auto table =
      RecordTable<Constraint>()
          .optional("quantity", text(), &Constraint::quantity, "a quantity of a path point")
          .optional("expression", text(), &Constraint::expression,
                    "or a formula of the parameters, in SI")
          .optional_choice<OverStroke>("over_stroke", over_stroke_names, &Constraint::over_stroke,
                                       over_stroke_meaning)
          .optional("case", text(100), &Constraint::load_case, case_meaning)
          .other(under_field())
          .other(margin_field())
          .other(shape::optional("min", shape::quantity(""), "lower bound"))
          .other(shape::optional("max", shape::quantity(""), "upper bound"));
  return table;
}

const RecordTable<Algorithm>& algorithm_table() {
  static const auto table =
      RecordTable<Algorithm>()
          .with_default("library", shape::choice({"nlopt", "ipopt"}), &Algorithm::library,
                        "optimiser")
          .optional("name", text(), &Algorithm::name,
                    "NLopt's name of the algorithm; default " + Algorithm().name)
          .optional("local", text(), &Algorithm::local,
                    "what runs inside AUGLAG or MLSL, by NLopt's name");
  return table;
}

const RecordTable<VerifySpec>& verify_table() {
  static const auto table =
      RecordTable<VerifySpec>()
          .with_default(
              "tolerance", quantity("1", 0, 0.1, true), &VerifySpec::tolerance,
              "largest difference to full accuracy, relative, of objective and constraints")
          .with_default("max_full_evaluations", integer(1, 1000), &VerifySpec::max_full_evaluations,
                        "evaluations at full accuracy");
  return table;
}

const RecordTable<ParetoSpec>& pareto_table() {
  static const auto table =
      RecordTable<ParetoSpec>()
          .optional("quantity", text(), &ParetoSpec::quantity, "a quantity of a path point")
          .optional("expression", text(), &ParetoSpec::expression, "or a formula of the parameters")
          .optional_choice<OverStroke>("over_stroke", over_stroke_names, &ParetoSpec::over_stroke,
                                       over_stroke_meaning)
          .optional("case", text(100), &ParetoSpec::load_case, case_meaning)
          .other(under_field())
          .other(margin_field())
          .choice<bool>("sense", {{"minimise", false}, {"maximise", true}}, &ParetoSpec::maximise,
                        "which way is better")
          .with_default("points", integer(2, 200), &ParetoSpec::points,
                        "designs on the front, both ends included");
  return table;
}

const RecordTable<MapSpec>& map_table() {
  static const auto table = RecordTable<MapSpec>().with_default(
      "points", list(integer(2, 1000), 2, 2), &MapSpec::points, "values of each, ends included");
  return table;
}

const RecordTable<SamplesSpec>& samples_table() {
  static const auto table =
      RecordTable<SamplesSpec>()
          .choice<SampleMethod>("method", sample_method_names, &SamplesSpec::method,
                                "how the designs spread over their box, or a list of designs")
          .optional("count", integer(1, 100000), &SamplesSpec::count,
                    "designs; default 64; not of a grid or list")
          .optional("seed", seed_shape(), &SamplesSpec::seed,
                    "of the spread; default 1; not of a grid or list");
  return table;
}

const RecordTable<SampleRange>& range_table() {
  static const auto table =
      RecordTable<SampleRange>()
          .optional_choice<bool>("scale", {{"linear", false}, {"log", true}},
                                 &SampleRange::logarithmic,
                                 "even in the value (default) or its logarithm")
          .optional("points", integer(1, 1000), &SampleRange::points,
                    "of a grid, instead of samples.points");
  return table;
}

}  // namespace flexopt
