#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "core/response/response.hpp"
#include "core/spec/spec_error.hpp"
#include "results/cli/start_design.hpp"

namespace flexopt {
namespace {

constexpr double milli = 1e-3, degree = std::numbers::pi / 180;

// `number` of mm or deg.
double stroke_in_si(const DriveList::Item& drive, double number) {
  return number * (is_rotation(drive.direction) ? degree : milli);
}

StrokeResponse moved(const StartDesign& start, ModelOptions model,
                     const std::vector<double>& numbers) {
  model.mesh = {6, 3};
  StrokeRequest request;
  request.outputs = {Output::equilibrium, Output::stress};
  request.points.clear();
  for (const double number : numbers) {
    const auto& drives = start.family->drives.items;
    request.points.push_back(stroke_in_si(drives.front(), number));
    if (drives.size() == 1) continue;
    VectorXd& strokes = request.strokes.emplace_back(static_cast<Eigen::Index>(drives.size()));
    for (std::size_t k = 0; k < drives.size(); ++k)
      strokes[static_cast<Eigen::Index>(k)] = stroke_in_si(drives[k], number);
  }
  return evaluate_stroke(start.mechanism, model, request);
}

// Largest stress at a point [Pa]; nothing where the point was not reached.
std::optional<double> stress_at(const PathPoint& point) {
  if (point.status != PointStatus::converged || !point.stable || !point.max_stress)
    return std::nullopt;
  return point.max_stress->value;
}

double largest_stroke(const StartDesign& start, const ModelOptions& model, double allowed) {
  constexpr double small = milli;
  const StrokeResponse little = moved(start, model, {small});
  const std::optional<double> first = stress_at(little.path.front());
  if (!first || *first <= 0)
    throw SpecError(
        "/drive", fmt::format("a stroke of {:g} mm or deg", small),
        "it cannot be followed, so that no stroke is known to begin with: " + little.message);
  // about where stresses that grow with the stroke reach it
  const double about = small * allowed / *first;
  std::vector<double> numbers;
  for (double power = std::pow(10.0, std::floor(std::log10(about)) - 1); power <= 2 * about;
       power *= 10)
    for (const double digit : {1.0, 2.0, 5.0})
      if (digit * power <= 2 * about) numbers.push_back(digit * power);
  const StrokeResponse path = moved(start, model, numbers);
  double largest = round_below(numbers.front());
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const std::optional<double> stress = stress_at(path.path[k]);
    if (!stress || *stress > allowed) break;
    largest = numbers[k];
  }
  return largest;
}

OrderedJson place(const DriveList::Item& drive, double number) {
  return readable(stroke_in_si(drive, number), is_rotation(drive.direction) ? "rad" : "m");
}

}  // namespace

OrderedJson first_stroke(const StartDesign& start, const ModelOptions& model, double allowed) {
  constexpr int points = 6;
  const double largest = largest_stroke(start, model, allowed);
  const DriveList& drives = start.family->drives;
  if (!drives.named())
    return {{"from", 0}, {"to", place(drives.items.front(), largest)}, {"points", points}};
  OrderedJson stroke = {{"at", OrderedJson::array()}};
  for (int k = 0; k < points; ++k) {
    OrderedJson point = OrderedJson::object();
    for (const DriveList::Item& drive : drives.items)
      point[drive.name] = place(drive, largest * k / (points - 1));
    stroke["at"].push_back(std::move(point));
  }
  return stroke;
}

}  // namespace flexopt
