#include <nlohmann/json.hpp>

#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using namespace shape;
using Pointer = json::json_pointer;

namespace {

constexpr int most_points = 10001;

/// `points` from `from` to `to`, both included.
std::vector<double> evenly(double from, double to, int points) {
  std::vector<double> all;
  for (int i = 0; i < points; ++i)
    all.push_back(i + 1 == points ? to : from + (to - from) * i / (points - 1));
  return all;
}

void check_ends(double from, double to, int points, const Pointer& at) {
  if (points == 1 && from != to)
    throw SpecError(at / "points", "1",
                    "both ends are included: expected at least 2 points between different ends");
}

std::vector<double> read_one(json& read, const json& as_written, Direction drive) {
  const Pointer at("/stroke");
  const RecordTable<StrokeSpec> table = stroke_table(drive);
  StrokeSpec spec = table.read(read);
  if (!spec.at.empty()) {
    for (const char* key : {"from", "to", "points"})
      if (read.contains(key))
        throw SpecError(at / key, shown(as_written[key]),
                        "the stroke is given by 'at', or by from, to and points, not by both");
    return spec.at;
  }
  if (!spec.to)
    throw SpecError(at / "to", "nothing",
                    "it is required: the last point of the stroke (or give 'at')");
  spec.from = spec.from.value_or(0);
  spec.points = spec.points.value_or(11);
  check_ends(*spec.from, *spec.to, *spec.points, at);
  read = table.write(spec);
  return evenly(*spec.from, *spec.to, *spec.points);
}

/// Schema of the strokes of drives with names.
Shape named_shape(const DriveList& drives) {
  std::vector<Field> point, axes;
  for (const DriveList::Item& drive : drives.items) {
    const Shape place = stroke_place(drive.direction);
    point.push_back(with_default(drive.name, place, 0.0, "stroke of " + drive.name));
    axes.push_back(optional(
        drive.name,
        record(
            {with_default("from", place, 0.0, "first stroke"), required("to", place, "last stroke"),
             with_default("points", integer(1, most_points), 11, "how many, both ends included")}),
        "strokes of " + drive.name + "; without them it stays at 0"));
  }
  return record({optional("at", list(record(std::move(point)), 1, most_points),
                          "the points one by one, each with the strokes of the drives by name"),
                 optional("grid", record(std::move(axes)),
                          "or every combination of the drives' strokes, the last of them fastest"),
                 with_default("in_order", boolean(), false, in_order_meaning)});
}

std::vector<VectorXd> read_named(const json& read, const json& as_written,
                                 const DriveList& drives) {
  const Pointer at("/stroke");
  if (read.contains("at") == read.contains("grid"))
    throw SpecError(at, shown(as_written),
                    "the strokes are given by 'at' or by 'grid', one of the two");
  const auto count = static_cast<Eigen::Index>(drives.items.size());
  std::vector<VectorXd> points;
  if (read.contains("at")) {
    for (const json& point : read["at"]) {
      VectorXd strokes(count);
      for (Eigen::Index k = 0; k < count; ++k)
        strokes[k] = point[drives.items[static_cast<std::size_t>(k)].name];
      points.push_back(std::move(strokes));
    }
    return points;
  }
  points.push_back(VectorXd::Zero(count));
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::string& name = drives.items[static_cast<std::size_t>(k)].name;
    if (!read["grid"].contains(name)) continue;
    const json& axis = read["grid"][name];
    check_ends(axis["from"], axis["to"], axis["points"], at / "grid" / name);
    std::vector<VectorXd> more;
    for (const VectorXd& point : points)
      for (const double stroke : evenly(axis["from"], axis["to"], axis["points"])) {
        more.push_back(point);
        more.back()[k] = stroke;
      }
    if (more.size() > most_points)
      throw SpecError(at / "grid", shown(as_written["grid"]), "it has more than 10001 points");
    points = std::move(more);
  }
  return points;
}

}  // namespace

Shape stroke_shape(const DriveList* drives) {
  if (!drives) return stroke_table(std::nullopt).shape();
  return drives->named() ? named_shape(*drives) : stroke_table(drives->first()).shape();
}

void read_stroke(json& read, const json& as_written, const DriveList& drives,
                 StrokeRequest& request) {
  if (drives.items.empty())
    throw SpecError("/stroke", shown(as_written), "the design has no drive; leave it out");
  if (!drives.named()) {
    request.points = read_one(read, as_written, drives.first());
    request.in_order = read.value("in_order", false);
    return;
  }
  request.strokes = read_named(read, as_written, drives);
  request.in_order = read.value("in_order", false);
  request.points.clear();
  for (const VectorXd& strokes : request.strokes) request.points.push_back(strokes[0]);
}

}  // namespace flexopt
