#include "optim/compare/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>

#include "core/spec/spec_error.hpp"

namespace flexopt {
namespace {

ComparedPoint compared_point(const PathPoint& p) {
  ComparedPoint c;
  c.stroke = p.stroke;
  c.converged = p.status == PointStatus::converged;
  if (!c.converged) return c;
  c.stable = p.stable;
  c.fallback = std::any_of(p.leaves.begin(), p.leaves.end(),
                           [](const LeafReport& leaf) { return leaf.replaced; });
  c.drive_load = p.drive_load;
  if (p.drive_loads.size() > 1)
    c.other_drive_loads.assign(p.drive_loads.begin() + 1, p.drive_loads.end());
  c.displacement = p.displacement;
  c.support_stiffness = p.support_stiffness;
  c.frequencies_free = p.frequencies_free;
  c.frequencies_locked = p.frequencies_locked;
  c.parasitic_frequency = p.parasitic_frequency;
  if (p.max_stress) c.max_stress = p.max_stress->value;
  return c;
}

/// Compares one number over the path, with the floor that its largest value gives.
class OneNumber {
 public:
  using Value = std::function<std::optional<double>(const ComparedPoint&)>;

  OneNumber(const ComparedPath& model, const ComparedPath& full, std::vector<PointError>& errors)
      : model_(model), full_(full), errors_(errors) {}

  void add(Compared quantity, int direction, const Value& value) {
    constexpr double nothing = 1e-6;  // of the largest: rounding of what is zero by symmetry
    double largest = 0;
    for (const ComparedPoint& p : full_.points)
      if (p.converged) largest = std::max(largest, std::abs(value(p).value_or(0)));
    const double floor = nothing * largest;
    for (std::size_t i = 0; i < std::min(full_.points.size(), model_.points.size()); ++i) {
      if (!full_.points[i].converged || !model_.points[i].converged) continue;
      const std::optional<double> f = value(full_.points[i]), m = value(model_.points[i]);
      if (!f || !m || (std::abs(*f) <= floor && std::abs(*m) <= floor)) continue;
      errors_.push_back({quantity, direction, model_.design, static_cast<int>(i),
                         std::abs(*m - *f) / std::max(std::abs(*f), floor)});
    }
  }

  void add_displacement() {
    double largest = 0;
    for (const ComparedPoint& p : full_.points)
      if (p.converged) largest = std::max(largest, p.displacement.norm());
    if (largest == 0) return;
    for (std::size_t i = 0; i < std::min(full_.points.size(), model_.points.size()); ++i) {
      const ComparedPoint &f = full_.points[i], &m = model_.points[i];
      if (!f.converged || !m.converged) continue;
      if (f.displacement.norm() <= 1e-6 * largest && m.displacement.norm() <= 1e-6 * largest)
        continue;
      errors_.push_back({Compared::displacement, -1, model_.design, static_cast<int>(i),
                         (m.displacement - f.displacement).norm() / largest});
    }
  }

 private:
  const ComparedPath &model_, &full_;
  std::vector<PointError>& errors_;
};

/// Linear between the sorted values, as most statistics programs have it.
double percentile(const std::vector<double>& sorted, double fraction) {
  const double place = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

void describe(const Job& job, ComparedDesign& design) try {
  if (!design.sample.refused.empty()) return;
  for (const LeafSpring& leaf : make_mechanism(job, design.sample).leaves) {
    const double wide = leaf.width * leaf.width / (leaf.length * leaf.thickness);
    if (wide <= design.width2_over_length_thickness) continue;
    design.width2_over_length_thickness = wide;
    design.length_over_width = leaf.length / leaf.width;
    design.thickness_over_length = leaf.thickness / leaf.length;
  }
} catch (const SpecError&) {
  return;  // there is no such mechanism; the path says why
}

}  // namespace

int ComparedPath::converged() const {
  return static_cast<int>(std::count_if(points.begin(), points.end(),
                                        [](const ComparedPoint& p) { return p.converged; }));
}

int ComparedPath::fallbacks() const {
  return static_cast<int>(std::count_if(points.begin(), points.end(),
                                        [](const ComparedPoint& p) { return p.fallback; }));
}

ComparedPath compared_path(int design, int model, const StrokeResponse& response) {
  ComparedPath path;
  path.design = design;
  path.model = model;
  for (const PathPoint& p : response.path) {
    path.points.push_back(compared_point(p));
    for (const LeafReport& leaf : p.leaves)
      if (path.fallback_reason.empty() && leaf.replaced) path.fallback_reason = leaf.reason;
  }
  const int missing = static_cast<int>(path.points.size()) - path.converged();
  if (missing > 0 || response.status != Status::ok)
    path.message =
        response.message.empty() ? fmt::format("{} points not reached", missing) : response.message;
  return path;
}

ComparedPath failed_path(int design, int model, std::string message) {
  assert(!message.empty());
  ComparedPath path;
  path.design = design;
  path.model = model;
  path.message = std::move(message);
  return path;
}

std::vector<PointError> errors_of(const ComparedPath& model, const ComparedPath& full) {
  assert(model.design == full.design);
  std::vector<PointError> errors;
  OneNumber number(model, full, errors);
  using Optional = std::optional<double>;
  number.add(Compared::drive_load, -1,
             [](const ComparedPoint& p) -> Optional { return p.drive_load; });
  std::size_t others = 0;
  for (const ComparedPoint& p : full.points) others = std::max(others, p.other_drive_loads.size());
  for (std::size_t k = 0; k < others; ++k)
    number.add(Compared::drive_load, -1, [k](const ComparedPoint& p) -> Optional {
      return k < p.other_drive_loads.size() ? Optional(p.other_drive_loads[k]) : std::nullopt;
    });
  for (int d = 0; d < 6; ++d)
    number.add(Compared::support_stiffness, d, [d](const ComparedPoint& p) {
      return p.support_stiffness[static_cast<std::size_t>(d)];
    });
  number.add_displacement();
  for (const auto list : {&ComparedPoint::frequencies_free, &ComparedPoint::frequencies_locked}) {
    std::size_t most = 0;
    for (const ComparedPoint& p : full.points) most = std::max(most, (p.*list).size());
    for (std::size_t k = 0; k < most; ++k)
      number.add(Compared::frequencies, -1, [list, k](const ComparedPoint& p) -> Optional {
        return k < (p.*list).size() ? Optional((p.*list)[k]) : std::nullopt;
      });
  }
  number.add(Compared::parasitic_frequency, -1,
             [](const ComparedPoint& p) { return p.parasitic_frequency; });
  number.add(Compared::max_stress, -1, [](const ComparedPoint& p) { return p.max_stress; });
  return errors;
}

std::optional<ErrorFigures> error_figures(const std::vector<PointError>& errors, Compared quantity,
                                          std::optional<int> direction) {
  std::vector<double> values;
  ErrorFigures figures;
  for (const PointError& e : errors) {
    if (e.quantity != quantity || (direction && e.direction != *direction)) continue;
    if (values.empty() || e.value > figures.worst) {
      figures.worst = e.value;
      figures.worst_design = e.design;
      figures.worst_point = e.point;
    }
    values.push_back(e.value);
  }
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  figures.count = static_cast<int>(values.size());
  figures.p99 = percentile(values, 0.99);
  figures.median = percentile(values, 0.5);
  return figures;
}

Comparison make_comparison(const Job& job, const std::vector<std::optional<ComparedPath>>& paths,
                           const std::vector<std::optional<EvaluationSeconds>>& seconds) {
  assert(job.compare && paths.size() == seconds.size());
  const std::size_t width = job.compare->models.size() + 1;
  Comparison result;
  result.evaluations = static_cast<int>(paths.size());
  for (const auto& path : paths)
    if (path) ++result.evaluated;
  for (Sample& sample : make_samples(job)) {
    ComparedDesign design;
    design.sample = std::move(sample);
    describe(job, design);
    result.designs.push_back(std::move(design));
  }
  assert(paths.size() == width * result.designs.size());
  for (std::size_t d = 0; d < result.designs.size(); ++d) {
    const auto& full = paths[d * width];
    ComparedDesign& design = result.designs[d];
    if (!full) continue;
    design.failed = !full->whole();
    design.message = full->message;
    design.points = full->converged();
    for (const ComparedPoint& p : full->points)
      if (p.converged && !p.stable) ++design.unstable_points;
    if (design.failed) ++result.failed_designs;
  }
  for (std::size_t m = 1; m < width; ++m) {
    ModelComparison model;
    model.name = job.compare->models[m - 1].name;
    EvaluationSeconds full_seconds, own_seconds;
    for (std::size_t d = 0; d < result.designs.size(); ++d) {
      const auto &full = paths[d * width], &path = paths[d * width + m];
      ModelDesign& design = model.designs.emplace_back();
      if (!full || !path) continue;
      design.points = path->converged();
      design.fallback_points = path->fallbacks();
      design.fallback_reason = path->fallback_reason;
      design.message = path->message;
      design.failed = design.points < full->converged();
      if (design.failed) ++model.failures;
      if (design.fallback_points > 0) ++model.fallback_designs;
      model.fallback_points += design.fallback_points;
      for (PointError& e : errors_of(*path, *full)) model.errors.push_back(e);
      const auto &full_time = seconds[d * width], &own_time = seconds[d * width + m];
      if (full->whole() && path->whole() && full_time && own_time) {
        full_seconds.path += full_time->path;
        full_seconds.total += full_time->total;
        own_seconds.path += own_time->path;
        own_seconds.total += own_time->total;
      }
    }
    if (own_seconds.path > 0) model.speed_up = full_seconds.path / own_seconds.path;
    if (own_seconds.total > 0)
      model.speed_up_with_reduction = full_seconds.total / own_seconds.total;
    result.models.push_back(std::move(model));
  }
  return result;
}

}  // namespace flexopt
