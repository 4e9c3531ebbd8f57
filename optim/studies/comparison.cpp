#include "optim/studies/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>

#include "core/spec/spec_error.hpp"

namespace flexopt {
namespace {

ComparedPoint compared_point(const std::vector<ComparedQuantity>& quantities, const PathPoint& p) {
  ComparedPoint c;
  c.stroke = p.stroke;
  c.converged = p.status == PointStatus::converged;
  if (!c.converged) return c;
  c.stable = p.stable;
  c.fallback = std::ranges::any_of(p.leaves, &LeafReport::replaced);
  for (const ComparedQuantity& quantity : quantities) {
    auto& numbers = c.numbers.emplace_back();
    auto& reasons = c.reasons.emplace_back();
    for (const ComparedQuantity::Number& number : quantity.numbers) {
      numbers.push_back(number.row->value(p, number.component));
      reasons.push_back(numbers.back() ? "" : why_missing(p, *number.row, number.component));
    }
  }
  return c;
}

/// Size of rounding of a number at rest without loads, where it should be zero [m, rad, N, N m,
/// Pa], and of ratios of motions.
double rounding_of(const QuantityRow& row) {
  if (row.error == ErrorKind::motion) return 1e-15;
  if (row.error == ErrorKind::load) return 1e-11;
  if (row.needs.has(Output::gain)) return 1e-9;
  return row.name.ends_with("_stress") ? 1 : 0;
}

/// Compares two paths, quantity by quantity, with the floor that the largest value gives.
class TwoPaths {
 public:
  TwoPaths(const ComparedPath& model, const ComparedPath& full, PathErrors& found)
      : model_(model), full_(full), found_(found) {
    for (std::size_t i = 0; i < std::min(full.points.size(), model.points.size()); ++i)
      if (full.points[i].converged && model.points[i].converged) both_.push_back(i);
  }

  void add_number(const ComparedQuantity& of, std::size_t quantity, std::size_t k) {
    const auto value = [&](const ComparedPoint& p) { return p.numbers[quantity][k]; };
    double largest = 0;
    for (const ComparedPoint& p : full_.points)
      if (p.converged) largest = std::max(largest, std::abs(value(p).value_or(0)));
    const double floor = std::max(nothing * largest, rounding_of(*of.numbers[k].row));
    const int q = static_cast<int>(quantity), part = of.numbers[k].part;
    for (const std::size_t i : both_) {
      const std::optional<double> f = value(full_.points[i]), m = value(model_.points[i]);
      const int point = static_cast<int>(i);
      if (f.has_value() != m.has_value())
        found_.missing.push_back({q, part, model_.design, point, !m,
                                  (m ? full_ : model_).points[i].reasons[quantity][k]});
      if (!f || !m || (std::abs(*f) <= floor && std::abs(*m) <= floor)) continue;
      found_.errors.push_back(
          {q, part, model_.design, point, std::abs(*m - *f) / std::max(std::abs(*f), floor)});
      if (of.of_design) return;
    }
  }

  void add_motion(const ComparedQuantity& of, std::size_t quantity) {
    const auto vector = [&](const ComparedPoint& p) {
      Vector3d u;
      for (std::size_t k = 0; k < 3; ++k) u[k] = p.numbers[quantity][k].value_or(0);
      return u;
    };
    double largest = 0;
    for (const ComparedPoint& p : full_.points)
      if (p.converged) largest = std::max(largest, vector(p).norm());
    if (largest <= rounding_of(*of.numbers.front().row)) return;
    for (const std::size_t i : both_) {
      const Vector3d f = vector(full_.points[i]), m = vector(model_.points[i]);
      if (f.norm() <= nothing * largest && m.norm() <= nothing * largest) continue;
      found_.errors.push_back({static_cast<int>(quantity), -1, model_.design, static_cast<int>(i),
                               (m - f).norm() / largest});
    }
  }

 private:
  static constexpr double nothing = 1e-6;  // rounding over the largest, of what is zero by symmetry
  const ComparedPath &model_, &full_;
  PathErrors& found_;
  std::vector<std::size_t> both_;
};

/// Percentile, linear between the sorted values, as in most statistics programs.
double percentile(const std::vector<double>& sorted, double fraction) {
  const double place = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

void describe(const Job& job, ComparedDesign& design) try {
  if (!design.sample.refused.empty()) return;
  for (const LeafSpring& leaf : make_mechanism(job, design.sample.parameters).leaves) {
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
  return std::ranges::count(points, true, &ComparedPoint::converged);
}

int ComparedPath::fallbacks() const {
  return std::ranges::count(points, true, &ComparedPoint::fallback);
}

ComparedPath compared_path(int design, int model, const std::vector<ComparedQuantity>& quantities,
                           const StrokeResponse& response) {
  ComparedPath path;
  path.design = design;
  path.model = model;
  for (const PathPoint& p : response.path) {
    path.points.push_back(compared_point(quantities, p));
    for (const LeafReport& leaf : p.leaves)
      if (path.fallback_reason.empty() && leaf.replaced) path.fallback_reason = leaf.reason;
  }
  const int missing = static_cast<int>(path.points.size()) - path.converged();
  if (missing > 0 || response.status != Status::ok)
    path.message =
        response.message.empty() ? fmt::format("{} points not reached", missing) : response.message;
  return path;
}

PathErrors errors_of(const std::vector<ComparedQuantity>& quantities, const ComparedPath& model,
                     const ComparedPath& full) {
  assert(model.design == full.design);
  PathErrors found;
  TwoPaths paths(model, full, found);
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    if (quantities[q].motion)
      paths.add_motion(quantities[q], q);
    else
      for (std::size_t k = 0; k < quantities[q].numbers.size(); ++k)
        paths.add_number(quantities[q], q, k);
  }
  return found;
}

std::optional<ErrorFigures> error_figures(const std::vector<PointError>& errors, int quantity,
                                          std::optional<int> part) {
  std::vector<double> values;
  ErrorFigures figures;
  for (const PointError& e : errors) {
    if (e.quantity != quantity || (part && e.part != *part)) continue;
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
  result.quantities = compared_quantities(job);
  result.evaluated = std::ranges::count_if(paths, [](const auto& path) { return bool(path); });
  std::vector<Sample> samples = make_samples(job);
  assert(paths.size() == width * samples.size());
  for (std::size_t d = 0; d < samples.size(); ++d) {
    ComparedDesign& design = result.designs.emplace_back();
    design.sample = std::move(samples[d]);
    describe(job, design);
    const auto& full = paths[d * width];
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
      PathErrors found = errors_of(result.quantities, *path, *full);
      std::ranges::move(found.errors, std::back_inserter(model.errors));
      std::ranges::move(found.missing, std::back_inserter(model.missing));
      const auto &full_time = seconds[d * width], &own_time = seconds[d * width + m];
      if (full->whole() && path->whole() && full_time && own_time) {
        full_seconds += *full_time;
        own_seconds += *own_time;
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
