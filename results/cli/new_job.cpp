#include "results/cli/new_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "core/mechanism/profile.hpp"
#include "core/response/path/error_estimate.hpp"
#include "core/response/response.hpp"
#include "core/response/room_taken.hpp"
#include "core/spec/fault_list.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/describe.hpp"
#include "designs/parametric_design.hpp"
#include "optim/job/job_sections.hpp"

namespace flexopt {

namespace {

/// A design that a job begins with: at its defaults and examples, of steel, or as a run found it.
struct StartDesign {
  explicit StartDesign(DesignSpec spec) : design(std::move(spec)) {
    if (!design.material.allowable_stress)
      design.material.allowable_stress =
          design.material.yield_strength.value_or(*materials().front().material.allowable_stress);
    mechanism = make(design.parameters);
  }

  DesignSpec design;    ///< resolved, its material with an allowable stress
  Mechanism mechanism;  ///< without payload

  const Family& family() const { return design.resolved->family(); }
  Mechanism make(const ParameterValues& of) const {
    return design.resolved->build(complete_parameters(design, of), design.material, {});
  }
};

OrderedJson design_of(const StartDesign& start, const nlohmann::json& source) {
  OrderedJson design = OrderedJson::parse(source.dump());
  OrderedJson& parameters = design["parameters"] = OrderedJson::object();
  for (const Parameter& p : start.family().parameters)
    parameters[p.name] = readable(start.design.parameters.at(p.name), p.unit);
  for (const FamilyOption& option : start.family().options)
    design[option.name] = start.design.choices.at(option.name);
  design["material"] = start.design.material.name;
  return design;
}

// A block of aluminium, some thirty times as heavy as the leaves; without leaves half as long as
// the largest elastic body.
OrderedJson payload_for(const StartDesign& start) {
  constexpr double density = 2700;  // [kg/m³]
  const double half = 0.5 * longest_leaf(start.mechanism),
               mass = round_below(start.mechanism.leaves.empty() ? density * half * half * half
                                                                 : 30 * leaf_mass(start.mechanism)),
               edge = std::cbrt(mass / density);
  const OrderedJson inertia = readable(round_below(mass * edge * edge / 6), "kg m^2");
  return {{"mass", readable(mass, "kg")}, {"inertia", {inertia, inertia, inertia}}};
}

// Whether the leaves are wires, or too thick for thin plates, as notches are at their ends.
bool wants_beams(const StartDesign& start) {
  constexpr double thin = 5;  // length over the largest thickness
  return start.family().is_of_wires(start.design.choices) ||
         std::ranges::any_of(start.mechanism.leaves, [](const LeafSpring& leaf) {
           const double thickest = leaf.thickness * profile_range(leaf.thickness_profile).largest;
           return leaf.section != Section::circular && !leaf.fold && leaf.length < thin * thickest;
         });
}

OrderedJson model_for(const StartDesign& start, bool beams) {
  OrderedJson model = OrderedJson::object();
  if (beams) model["flexure"] = "beam";
  double tolerance = 0.003;
  for (const LeafSpring& leaf : start.mechanism.leaves) {
    if (beams || leaf.section == Section::circular) continue;
    // plates that are short for their thickness converge slowly next to their corners
    if (leaf.length < 20 * leaf.thickness) tolerance = 0.01;
  }
  if (!start.family().has_end_effector(start.design.choices) ||
      !start.mechanism.elastic_bodies.empty() ||
      profile_error(start.mechanism).translation > tolerance) {
    // the stiffness of a point in the plane of its plate has no limit on ever finer meshes, what
    // the theory of notches is off by no mesh lessens, and that of elastic bodies is the design's
    model["accuracy"] = "full";
    return model;
  }
  model["accuracy"] = "auto";
  model["tolerance"] = tolerance;
  return model;
}

double two_digits(double value) { return std::stod(fmt::format("{:.2g}", value)); }

struct Range {
  double min = 0, max = 0;
};

// About the start, in two digits of degrees or SI, and inside of what the design allows.
Range range_about(const Parameter& p, double value, double factor) {
  const bool angle = p.unit == "rad";
  const double unit = angle ? std::numbers::pi / 180 : 1, at = value / unit;
  Range range;
  if (angle)
    range = {std::round(at - 17 * (factor - 1)), std::round(at + 17 * (factor - 1))};
  else
    range = {two_digits(std::min(at * factor, at / factor)),
             two_digits(std::max(at * factor, at / factor))};
  range = {unit * range.min, unit * range.max};
  const auto inside = [&](double limit) { return value + 0.9 * (limit - value); };
  if (range.min < p.min || (p.open_min && range.min == p.min))
    range.min = p.open_min ? inside(p.min) : p.min;
  if (range.max > p.max || (p.open_max && range.max == p.max))
    range.max = p.open_max ? inside(p.max) : p.max;
  return range;
}

std::vector<Parameter> variables_of(const StartDesign& start) {
  std::vector<Parameter> variables;
  for (const Parameter& p : start.family().parameters) {
    const auto& counts = start.family().counts;
    const bool count = std::ranges::find(counts, p.name) != counts.end();
    if (!count && p.unit != "kg" && !start.design.expressions.contains(p.name) &&
        start.design.parameters.at(p.name) != 0)
      variables.push_back(p);
  }
  return variables;
}

bool is_sound(const StartDesign& start, const ParameterValues& values) {
  try {
    (void)start.make(values);
    return true;
  } catch (const SpecError&) {
    return false;
  }
}

// Whether the design is sound at every corner of the ranges; of many variables, at the corners of
// the first ten.
bool is_sound_everywhere(const StartDesign& start, const std::vector<Parameter>& variables,
                         const std::vector<Range>& ranges) {
  constexpr std::size_t most = 10;
  const std::size_t varied = std::min(variables.size(), most);
  for (std::size_t corner = 0; corner < std::size_t{1} << varied; ++corner) {
    ParameterValues values = start.design.parameters;
    for (std::size_t k = 0; k < varied; ++k)
      values[variables[k].name] = (corner >> k & 1) != 0 ? ranges[k].max : ranges[k].min;
    if (!is_sound(start, values)) return false;
  }
  for (std::size_t k = varied; k < variables.size(); ++k)
    for (const double value : {ranges[k].min, ranges[k].max}) {
      ParameterValues values = start.design.parameters;
      values[variables[k].name] = value;
      if (!is_sound(start, values)) return false;
    }
  return true;
}

OrderedJson box_about(const StartDesign& start) {
  const std::vector<Parameter> variables = variables_of(start);
  std::vector<Range> ranges;
  for (const double factor : {2.0, 1.5, 1.2, 1.1, 1.05}) {
    ranges.clear();
    for (const Parameter& p : variables)
      ranges.push_back(range_about(p, start.design.parameters.at(p.name), factor));
    if (is_sound_everywhere(start, variables, ranges)) break;
  }
  OrderedJson box = OrderedJson::array();
  for (std::size_t k = 0; k < variables.size(); ++k) {
    if (ranges[k].min >= ranges[k].max) continue;
    box.push_back({{"parameter", variables[k].name},
                   {"min", readable(ranges[k].min, variables[k].unit)},
                   {"max", readable(ranges[k].max, variables[k].unit)}});
  }
  return box;
}

OrderedJson constraints_on(const StartDesign& start) {
  OrderedJson constraints = OrderedJson::array();
  constraints.push_back({{"quantity", "max_stress"},
                         {"over_stroke", "max"},
                         {"max", readable(*start.design.material.allowable_stress, "Pa")}});
  const Solids solids = Solids::undeflected(start.mechanism);
  if (solids.count() == 0) return constraints;  // a notch alone
  const Extents extents = extents_of(solids);
  const Vector3d room = envelope_of({&extents}).box;
  for (int k = 0; k < 3; ++k) {
    if (room[k] < 0.1 * room.maxCoeff()) continue;  // a leaf's thickness is no room
    constraints.push_back({{"quantity", std::string("envelope.") + "xyz"[k]},
                           {"max", readable(two_digits(1.1 * room[k]), "m")}});
  }
  return constraints;
}

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
    const auto& drives = start.family().drives.items;
    request.points.push_back(stroke_in_si(drives.front(), number));
    if (drives.size() == 1) continue;
    VectorXd& strokes = request.strokes.emplace_back(static_cast<Eigen::Index>(drives.size()));
    for (std::size_t k = 0; k < drives.size(); ++k) strokes[k] = stroke_in_si(drives[k], number);
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

/// Design to start from, read and checked as new_job does; throws as new_job does.
StartDesign start_design(const nlohmann::json& design, const std::string& folder) {
  FaultList faults;
  const std::shared_ptr<const Family> family = design_source({{"design", design}}, folder, faults);
  faults.raise();
  if (family->drives.items.empty())
    throw SpecError("/drive", "nothing", "a new job prescribes the stroke of a drive");
  DesignSpec spec;
  spec.parameters = usual_values(*family);
  spec.choices = default_choices(*family);
  spec.material = materials().front().material;
  spec.resolved = std::make_shared<const ParametricDesign>(family, spec.choices,
                                                           std::map<std::string, std::string>());
  return StartDesign(std::move(spec));
}

/// "stroke" of a new job: from rest to the largest of 1, 2, 5, 10 … mm or deg, of all drives alike,
/// up to which the path is stable and the stress stays below `allowed` [Pa], on a coarse mesh by
/// this model. Throws SpecError where not even a thousandth can be followed.
OrderedJson first_stroke(const StartDesign& start, const ModelOptions& model, double allowed) {
  constexpr int points = 6;
  const double largest = largest_stroke(start, model, allowed);
  const DriveList& drives = start.family().drives;
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

/// "optimise" of a new job: the highest parasitic frequency over the stroke, at no more than the
/// allowable stress and in a tenth more room than the start takes. Sizes, angles and ratios vary
/// between half and twice the start (angles by 17°), or less, so that the design is sound at the
/// corners of their box; counts and masses do not.
OrderedJson first_goals(const StartDesign& start) {
  return {{"variables", box_about(start)},
          {"objective", {{"maximise", "parasitic_frequency"}, {"over_stroke", "min"}}},
          {"constraints", constraints_on(start)},
          {"algorithm", {{"library", "nlopt"}, {"name", "LD_SLSQP"}}},
          {"starts", 3},
          {"seed", 1}};
}

}  // namespace

OrderedJson new_job(const nlohmann::json& design, const std::string& folder, bool optimise) {
  const StartDesign start = start_design(design, folder);
  const bool beams = wants_beams(start);
  ModelOptions model;
  if (beams) model.flexure = Flexure::beam;

  OrderedJson job = {{"flexopt", 1},
                     {"name", start.family().name},
                     {"job", optimise ? "optimise" : "evaluate"},
                     {"design", design_of(start, design)}};
  if (start.family().has_end_effector(start.design.choices))
    job["end_effector"] = payload_for(start);
  job["stroke"] = first_stroke(start, model, 0.5 * *start.design.material.allowable_stress);
  job["frequencies"] = 6;
  job["model"] = model_for(start, beams);
  if (optimise) job["optimise"] = first_goals(start);
  return job;
}

NextJob next_job(const FoundDesign& found, bool optimise) {
  NextJob next{moved_job(parse_job(found.job), found.parameters), {}};
  for (const char* section : {"expect", "optimise", "samples", "models", "quantities", "maps",
                              "tolerances", "tolerance_samples", "assembly_tolerances"}) {
    next.job.erase(section);
    if (found.job.contains(section) && !found.job[section].empty())
      next.left_out.emplace_back(section);
  }
  next.job["job"] = "evaluate";
  if (!optimise) return next;
  next.job["optimise"] = first_goals(StartDesign(parse_job(next.job).design));
  next.job["job"] = "optimise";
  if (next.job.value("frequencies", 0) == 0) next.job["frequencies"] = 6;
  parse_job(next.job);  // throws where there is nothing to vary
  return next;
}

double round_below(double value) {
  constexpr double rounding = 1e-9;
  const double power = std::pow(10.0, std::floor(std::log10(value) + rounding));
  double best = power;
  for (const double digit : {2.0, 5.0})
    if (digit * power <= value * (1 + rounding)) best = digit * power;
  return best;
}

OrderedJson readable(double value, const std::string& unit) {
  struct Shown {
    const char *si, *unit;
    double factor, from;  ///< least value that is shown in this unit
  };
  static constexpr std::array shown{Shown{"m", "m", 1, 1},
                                    Shown{"m", "mm", 1e3, 1e-5},
                                    Shown{"m", "um", 1e6, 0},
                                    Shown{"kg", "kg", 1, 0.1},
                                    Shown{"kg", "g", 1e3, 0},
                                    Shown{"Pa", "MPa", 1e-6, 0},
                                    Shown{"kg m^2", "kg mm^2", 1e6, 0},
                                    Shown{"rad", "deg", 180 / std::numbers::pi, 0}};
  if (unit == "1" || value == 0) return std::stod(fmt::format("{:.10g}", value));
  const auto fits = std::ranges::find_if(
      shown, [&](const Shown& of) { return unit == of.si && std::abs(value) >= of.from; });
  return fits == shown.end() ? fmt::format("{:.10g} {}", value, unit)
                             : fmt::format("{:.10g} {}", value * fits->factor, fits->unit);
}

}  // namespace flexopt
