#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/spec/spec_error.hpp"
#include "optim/job/expression.hpp"
#include "optim/solvers/unit_points.hpp"
#include "optim/studies/comparison.hpp"

namespace flexopt {
namespace {

std::vector<VectorXd> unit_points(const SamplesSpec& spec) {
  const int n = static_cast<int>(spec.ranges.size());
  switch (spec.method) {
    case SampleMethod::sobol:
      return sobol_points(n, spec.count, spec.seed);
    case SampleMethod::latin_hypercube:
      return latin_hypercube_points(n, spec.count, spec.seed);
    case SampleMethod::grid: {
      std::vector<int> counts;
      for (const SampleRange& range : spec.ranges) counts.push_back(range.points);
      return grid_points(counts);
    }
    case SampleMethod::list:
      break;
  }
  assert(false);
  return {};
}

double value_in(const SampleRange& range, double u) {
  const double value = range.logarithmic ? range.min * std::pow(range.max / range.min, u)
                                         : range.min + u * (range.max - range.min);
  return std::clamp(value, range.min, range.max);
}

/// Parameters and symbols together, as formulas see them.
ParameterValues all_values(const Sample& sample) {
  ParameterValues all = sample.parameters;
  all.insert(sample.symbols.begin(), sample.symbols.end());
  return all;
}

double value_of(const Expression& formula, const Sample& sample) {
  const std::optional<double> value = formula.value(all_values(sample));
  if (!value) throw SpecError(formula.pointer(), formula.text(), "it has no finite value here");
  return *value;
}

}  // namespace

std::vector<Sample> make_samples(const Job& job) {
  assert(job.compare);
  const SamplesSpec& spec = job.compare->samples;
  std::vector<Sample> samples;
  if (spec.method == SampleMethod::list) {
    for (const ParameterValues& listed : spec.designs) samples.push_back({listed, {}, {}, {}, {}});
  } else {
    for (const VectorXd& u : unit_points(spec)) {
      Sample sample;
      for (std::size_t j = 0; j < spec.ranges.size(); ++j) {
        const SampleRange& range = spec.ranges[j];
        (range.symbol ? sample.symbols : sample.parameters)[range.name] = value_in(range, u[j]);
      }
      samples.push_back(std::move(sample));
    }
  }

  std::vector<Expression> formulas;
  for (const SampleFormula& f : spec.formulas)
    formulas.emplace_back(f.formula, f.may_use, f.pointer);
  std::optional<Expression> largest_stroke;
  if (!spec.largest_stroke.formula.empty())
    largest_stroke.emplace(spec.largest_stroke.formula, spec.largest_stroke.may_use,
                           spec.largest_stroke.pointer);
  double furthest = 0;
  std::vector<double> points;  // points of all load cases
  std::vector<VectorXd> strokes;
  for (const JobCase& one : cases_of(job)) {
    points.insert(points.end(), one.request.points.begin(), one.request.points.end());
    strokes.insert(strokes.end(), one.request.strokes.begin(), one.request.strokes.end());
  }
  for (const double s : points) furthest = std::max(furthest, std::abs(s));

  for (Sample& sample : samples) try {
      const ParameterValues sampled = sample.parameters;
      ParameterValues own = job.design.parameters;
      sample.parameters.insert(own.begin(), own.end());  // keeps the sampled ones
      for (std::size_t i = 0; i < formulas.size(); ++i)
        sample.parameters[spec.formulas[i].parameter] = value_of(formulas[i], sample);
      sample.parameters = complete_parameters(job.design, sample.parameters);
      sample.stroke = points;
      sample.strokes = strokes;
      if (largest_stroke) {
        const double largest = value_of(*largest_stroke, sample);
        for (double& s : sample.stroke) s *= largest / furthest;
      }
    } catch (const SpecError& error) {
      sample.refused = error.what();
    }
  return samples;
}

}  // namespace flexopt
