#include "core/response/path/stroke_capacity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/math/work_limit.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/response/path/branch_walk.hpp"
#include "core/response/quantities.hpp"
#include "core/response/stress_safety.hpp"

namespace flexopt {
namespace {

constexpr int search_steps = 16;     // to the end of the search
constexpr double precision = 1e-11;  // of (S37)
constexpr double halving = 1e-6;     // distance to a limit without a measure, over the stroke
constexpr int most_trials = 80;      // for a limit

const QuantityRow& row_named(std::string_view name) {
  return *std::ranges::find(quantity_rows(), name, &QuantityRow::name);
}

// A number of the table, with what bounds it.
struct BoundedNumber {
  StrokeLimit limit;
  const QuantityRow* row;
  int component;
  double bound;
  bool least;            // it must not fall below the bound, else its size not rise above it
  bool of_rest = false;  // the bound is a share of the number at rest

  // (S37): below zero within the bound, smooth in the number.
  double over(double number) const {
    if (!least) return std::abs(number) / bound - 1;
    return number > bound / 2 ? bound / number - 1 : 3 - 4 * number / bound;
  }
};

std::vector<BoundedNumber> bounded_numbers(const StrokeCapacityRule& rule,
                                           const StressRules& stress) {
  std::vector<BoundedNumber> all;
  const auto add = [&](StrokeLimit limit, const char* name, int component, double bound, bool least,
                       bool of_rest = false) {
    all.push_back({limit, &row_named(name), component, bound, least, of_rest});
  };
  if (rule.stress)
    add(StrokeLimit::stress, stress.fillet ? "notch_stress" : "max_stress", 0, *rule.stress, false);
  if (stress.yield) add(StrokeLimit::yield, "yield_safety", 0, 1, true);
  if (stress.fatigue) add(StrokeLimit::fatigue, "fatigue_safety", 0, 1, true);
  for (int d = 0; d < 6; ++d)
    if (rule.stiffness_share > 0 && rule.supports[d])
      add(StrokeLimit::stiffness, "support_stiffness", d, rule.stiffness_share, true, true);
  if (rule.clearance) add(StrokeLimit::clearance, "clearance", 0, *rule.clearance, true);
  if (rule.drive_load)
    add(StrokeLimit::drive_load, "drive_load", rule.drive, *rule.drive_load, false);
  return all;
}

// The request at the trial strokes. Fatigue counts the cycle from rest to the stroke, or the one
// of the stated ratio.
StrokeRequest trial_request(const Mechanism& mechanism, const StrokeCapacityRule& rule,
                            StrokeRequest request) {
  request.outputs = {Output::equilibrium};
  request.loads.growing.clear();
  request.branch = BranchChoice::primary;
  request.in_order = false;
  request.named_points.clear();
  request.frequencies = request.stress_peaks = 0;
  StressRules& stress = request.stress;
  stress.life = false;
  stress.yield = !rule.stress && knows_yield(mechanism);
  stress.fatigue = !rule.stress && knows_fatigue(mechanism, stress.fatigue_rule);
  for (const BoundedNumber& number : bounded_numbers(rule, stress))
    request.outputs.add(number.row->needs);
  return request;
}

// A stroke that was looked at.
struct Trial {
  double stroke = 0;
  PathPoint point;
  // (S37); nothing: no equilibrium, an unstable one, or no numbers
  std::optional<double> over = {};
  const BoundedNumber* number = nullptr;  // which is largest

  bool inside() const { return over && *over < 0; }
};

// The stress that a number is made of, with its place.
std::optional<StressPeak> peak_of(const BoundedNumber& number, const PathPoint& point) {
  if (number.limit == StrokeLimit::yield) return point.yield_safety->stress;
  if (number.limit == StrokeLimit::fatigue) return point.fatigue_safety->stress;
  if (number.limit != StrokeLimit::stress) return std::nullopt;
  return point.notch_stress ? point.notch_stress : point.max_stress;
}

// The ways of one drive from rest.
class StrokeSearch {
 public:
  StrokeSearch(const Mechanism& mechanism, const ModelOptions& model, const StrokeRequest& request,
               const StrokeCapacityRule& rule, DifferentiablePath* differentiable);

  // `sign`: of the strokes. Where a limit of work ends it, it has no limit, with the reason.
  StrokeCapacity find(double sign);
  // Derivatives of the capacity that was found last; nothing where it has none.
  std::optional<VectorXd> gradient(double sign);
  bool cut_short() const { return cut_short_; }

 private:
  void go_to(double stroke);
  void visit(double stroke);
  Trial look(double stroke);
  void add_cycle(PathPoint& point, PointGradients* gradients) const;
  bool search(double sign);
  void refine();
  std::string what_happens(const PathPoint& point) const;
  StrokeCapacity beyond_end() const;
  PointGradients gradients_at(double stroke);
  Eigen::Index parameters() const { return own_ ? std::ssize(own_->design.list) - 1 : -1; }
  const Trial& end() const {
    const bool near = beyond_.over && std::abs(*beyond_.over) < std::abs(*inside_.over);
    return near ? beyond_ : inside_;
  }

  const Mechanism& mechanism_;
  const StrokeCapacityRule& rule_;
  StrokeRequest request_;
  StrokeResponse response_;
  std::optional<DifferentiablePath> own_;  // its last direction is the stroke
  BranchWalk walk_;
  std::vector<BoundedNumber> numbers_;
  bool astray_ = true;  // the walk does not stand on the way of stable equilibria
  bool cut_short_ = false;
  std::optional<PathPoint> rest_;
  PointGradients rest_gradients_;
  Trial inside_, beyond_;  // on either side of the limit
};

StrokeSearch::StrokeSearch(const Mechanism& mechanism, const ModelOptions& model,
                           const StrokeRequest& request, const StrokeCapacityRule& rule,
                           DifferentiablePath* differentiable)
    : mechanism_(mechanism),
      rule_(rule),
      request_(trial_request(mechanism, rule, request)),
      own_(differentiable ? std::make_optional<DifferentiablePath>() : std::nullopt),
      walk_(mechanism, model, request_, 1, own_ ? &*own_ : nullptr, response_),
      numbers_(bounded_numbers(rule, request_.stress)) {
  if (!gradients_of(differentiable)) return;
  std::vector<Mechanism> directions = differentiable->design.list;
  directions.push_back(zero_rate(mechanism));
  own_->design = DesignDirections(mechanism, std::move(directions));
}

void StrokeSearch::go_to(double stroke) {
  VectorXd strokes = VectorXd::Zero(std::ssize(mechanism_.drives));
  strokes[rule_.drive] = stroke;
  response_.path.assign(1, PathPoint());
  PathPoint& point = response_.path.front();
  point.stroke = strokes[0];
  request_.points = {strokes[0]};
  request_.strokes = {std::move(strokes)};
}

void StrokeSearch::visit(double stroke) {
  if (astray_) {
    go_to(rule_.up_to / search_steps);  // leaves are made for strokes of this size
    walk_.begin();
    // mounting may have left the drives elsewhere
    if (stroke != 0 && !request_.loads.mounting.empty() && walk_.lost().empty()) {
      go_to(0);
      walk_.visit(0);
    }
    walk_.count_from_rest();
  }
  astray_ = false;
  go_to(stroke);
  if (walk_.lost().empty()) {
    walk_.visit(0);
    if (stroke == 0) walk_.count_from_rest();
    return;
  }
  response_.path[0].status = PointStatus::no_equilibrium;
  response_.path[0].message = walk_.lost();
}

// Fatigue of the cycle between rest and a point. The sections of both stay where they are kept.
void StrokeSearch::add_cycle(PathPoint& point, PointGradients* gradients) const {
  if (!request_.stress.need_history()) return;
  StrokeResponse cycle;
  cycle.path = {*rest_, point};
  cycle.stress_places = response_.stress_places;
  StrokeGradients rates;
  if (gradients) rates.path = {rest_gradients_, *gradients};
  add_fatigue(mechanism_, request_.stress, gradients ? &own_->design.list : nullptr, cycle,
              gradients ? &rates : nullptr);
  point.fatigue_safety = cycle.path[1].fatigue_safety;
  point.fatigue_fault = cycle.path[1].fatigue_fault;
  if (gradients) gradients->fatigue_safety = rates.path[1].fatigue_safety;
}

// The first one is at rest.
Trial StrokeSearch::look(double stroke) {
  visit(stroke);
  Trial trial{stroke, response_.path[0]};
  PathPoint& point = trial.point;
  astray_ = point.status != PointStatus::converged || !point.stable ||
            (stroke != 0 && point.bifurcation_passed);
  if (astray_) return trial;
  if (!rest_) {
    rest_ = point;
    for (BoundedNumber& number : numbers_)
      if (number.of_rest) number.bound *= number.row->value(point, number.component).value_or(0);
  }
  add_cycle(point, nullptr);
  if (!point.fillet_fault.empty() || !point.fatigue_fault.empty()) return trial;
  trial.over = -1;
  for (const BoundedNumber& number : numbers_)
    if (const auto value = number.row->value(point, number.component))
      if (const double over = number.over(*value); over > *trial.over) {
        trial.over = over;
        trial.number = &number;
      }
  return trial;
}

// Whether there is a limit; it is then between inside_ and beyond_.
bool StrokeSearch::search(double sign) {
  inside_ = look(0);
  if (!inside_.inside()) {
    beyond_ = inside_;
    return true;
  }
  if (parameters() >= 0 && rest_gradients_.drive_loads.size() == 0)
    rest_gradients_ = gradients_at(0);
  for (int k = 1; k <= search_steps; ++k) {
    beyond_ = look(sign * rule_.up_to * k / search_steps);
    if (!beyond_.inside()) {
      refine();
      return true;
    }
    inside_ = beyond_;
  }
  return false;
}

// Regula falsi (Illinois), or halving where what is beyond has no measure.
void StrokeSearch::refine() {
  double low = *inside_.over, high = beyond_.over.value_or(0);
  int side = 0;
  for (int k = 0; k < most_trials; ++k) {
    const bool measured = beyond_.over.has_value();
    const double gap = beyond_.stroke - inside_.stroke;
    if (std::abs(gap) <= (measured ? precision : halving) * std::abs(beyond_.stroke)) return;
    Trial next = look(inside_.stroke + (measured ? low / (low - high) : 0.5) * gap);
    const bool found = next.over && std::abs(*next.over) <= precision;
    if (next.inside()) {
      if (side > 0) high /= 2;
      side = 1;
      low = *next.over;
      inside_ = std::move(next);
    } else {
      if (side < 0) low /= 2;
      side = -1;
      if (!measured) low = *inside_.over;
      high = next.over.value_or(0);
      beyond_ = std::move(next);
    }
    if (found) return;
  }
}

std::string StrokeSearch::what_happens(const PathPoint& point) const {
  const BoundedNumber& number = *beyond_.number;
  const auto part = [&] { return *part_of(*peak_of(number, point), mechanism_).name; };
  switch (number.limit) {
    case StrokeLimit::stress:
      return fmt::format("the stress of {} reaches {:.4g} MPa", part(), number.bound / 1e6);
    case StrokeLimit::yield:
      return fmt::format("the stress of {} reaches its yield strength", part());
    case StrokeLimit::fatigue:
      return fmt::format("the safety of {} against fatigue falls to 1", part());
    case StrokeLimit::stiffness:
      return fmt::format("the support stiffness {} falls to {:g} of that at rest",
                         direction_names[number.component], rule_.stiffness_share);
    case StrokeLimit::clearance:
      return fmt::format("{} and {} come as near as {:.4g} mm", point.clearance->names[0],
                         point.clearance->names[1], number.bound * 1e3);
    default:
      return fmt::format("the drive load reaches {:.4g} {}", number.bound,
                         load_unit(mechanism_.drives[rule_.drive].direction));
  }
}

// The capacity where a limit without a measure ends it.
StrokeCapacity StrokeSearch::beyond_end() const {
  const PathPoint& point = beyond_.point;
  if (point.status != PointStatus::converged)
    return {.limit = StrokeLimit::no_equilibrium, .reason = point.message};
  if (!point.fillet_fault.empty())
    return {.limit = StrokeLimit::none, .reason = point.fillet_fault};
  if (!point.fatigue_fault.empty())
    return {.limit = StrokeLimit::fatigue, .reason = point.fatigue_fault};
  return {.limit = StrokeLimit::instability,
          .reason = point.stable ? point.message : "the equilibrium is unstable"};
}

StrokeCapacity StrokeSearch::find(double sign) {
  StrokeCapacity capacity;
  astray_ = true;
  inside_ = beyond_ = {};
  try {
    if (!search(sign)) {
      capacity.reason = "no limit up to the stroke where the search ends";
    } else if (beyond_.number) {
      capacity = {.limit = beyond_.number->limit, .reason = what_happens(beyond_.point)};
      const BoundedNumber& number = *beyond_.number;
      const bool here = number.row->value(end().point, number.component).has_value();
      capacity.stress = peak_of(number, here ? end().point : beyond_.point);
    } else {
      capacity = beyond_end();
    }
  } catch (const WorkLimitReached& reached) {
    cut_short_ = true;
    beyond_ = {};
    capacity.reason = reached.what();
  }
  const Trial& at = end();
  capacity.value = std::abs(at.stroke);
  if (!at.point.drive_loads.empty()) capacity.drive_load = at.point.drive_loads[rule_.drive];
  if (capacity.value == 0 && capacity.limit != StrokeLimit::none)
    capacity.reason = "it is so at rest: " + capacity.reason;
  return capacity;
}

// At an equilibrium of the way. At rest the stroke stays.
PointGradients StrokeSearch::gradients_at(double stroke) {
  MatrixXd& strokes = own_->design.strokes;
  strokes = MatrixXd::Zero(std::ssize(mechanism_.drives), parameters() + 1);
  if (stroke != 0) strokes(rule_.drive, parameters()) = 1;
  own_->gradients.path.resize(1);
  visit(stroke);
  PointGradients found = std::move(own_->gradients.path[0]);
  own_->gradients.path.clear();
  if (stroke != 0) add_cycle(response_.path[0], &found);
  return found;
}

std::optional<VectorXd> StrokeSearch::gradient(double sign) try {
  const Eigen::Index count = parameters();
  if (count < 0 || !beyond_.number) return std::nullopt;
  if (end().stroke == 0) return VectorXd(VectorXd::Zero(count));
  const BoundedNumber& number = *beyond_.number;
  const PointGradients found = gradients_at(end().stroke);
  const auto of = number.row->gradient(response_.path[0], found, number.component);
  if (!of || (*of)[count] == 0) return std::nullopt;
  VectorXd rates = of->head(count);
  if (number.of_rest) {
    const auto at_rest = number.row->gradient(*rest_, rest_gradients_, number.component);
    if (!at_rest) return std::nullopt;
    rates -= rule_.stiffness_share * at_rest->head(count);
  }
  return VectorXd(-sign / (*of)[count] * rates);  // (S38)
} catch (const WorkLimitReached&) {
  cut_short_ = true;
  return std::nullopt;
}

}  // namespace

bool add_stroke_capacities(const Mechanism& mechanism, const ModelOptions& model,
                           const StrokeRequest& request, DifferentiablePath* differentiable,
                           StrokeResponse& response) {
  PathPoint found;
  PointGradients rates;
  StrokeGradients* gradients = gradients_of(differentiable);
  found.stroke_capacity.resize(2 * mechanism.drives.size());
  rates.stroke_capacity.resize(2 * mechanism.drives.size());
  bool cut_short = false;
  for (const StrokeCapacityRule& rule : request.stroke_capacity) {
    StrokeSearch search(mechanism, model, request, rule, differentiable);
    for (const int way : {0, 1}) {
      if (!rule.ways[way]) continue;
      const auto at = static_cast<std::size_t>(2 * rule.drive + way);
      const double sign = way == 0 ? 1 : -1;
      found.stroke_capacity[at] = search.find(sign);
      if (gradients && !search.cut_short()) rates.stroke_capacity[at] = search.gradient(sign);
    }
    cut_short |= search.cut_short();
  }
  for (std::size_t k = 0; k < response.path.size(); ++k) {
    response.path[k].stroke_capacity = found.stroke_capacity;
    if (gradients) gradients->path[k].stroke_capacity = rates.stroke_capacity;
  }
  return cut_short;
}

}  // namespace flexopt
