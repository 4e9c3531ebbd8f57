#include "optim/check_gradients.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/math/ridders.hpp"
#include "core/response/frequency_derivatives.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/expression.hpp"
#include "optim/goals.hpp"
#include "optim/job_numbers.hpp"
#include "optim/parallel.hpp"
#include "optim/stroke_sensitivity.hpp"

namespace flexopt {
namespace {

// The job with one of its numbers changed, to where no real body may have it.
Job moved(const Job& job, const std::string& name, double value) {
  Job other = job;
  if (find_job_number(name))
    set_number(other.design.material, other.end_effector, name, value);
  else
    other.design.parameters[name] = value;
  return other;
}

double present(const Job& job, const std::string& name) {
  if (!find_job_number(name)) return job.design.parameters.at(name);
  return numbers_of(job.design.material, job.end_effector).at(name);
}

// What a number that is zero is moved by.
double unit(const Job& job, const std::string& name) {
  double length = 0;
  for (const LeafSpring& l : make_mechanism(job, job.design.parameters).leaves)
    length = std::max(length, l.length);
  if (name.starts_with("end_effector.center_of_mass")) return 0.1 * length;
  if (name.starts_with("end_effector.inertia"))
    return std::max(1e-2 * job.end_effector.mass * length * length,
                    0.1 * job.end_effector.inertia.diagonal().cwiseAbs().maxCoeff());
  if (name == "end_effector.mass") return 1e-2;
  return 0.1 * length;
}

using Numbers = std::vector<std::optional<double>>;

// Runs of frequencies that may meet within a step of the differences: their ranks may change
// places, the mean of their squares is smooth.
using Group = std::vector<std::size_t>;  // of quantities, at one point

std::vector<Group> groups_of(const std::vector<Quantity>& names, const Numbers& here,
                             const Numbers& slopes, std::size_t first, double step) {
  std::vector<Group> groups;
  double reach = 0;
  std::string list;
  for (std::size_t q = 0; q < names.size(); ++q) {
    if (!names[q].name.starts_with("frequencies.")) continue;
    const std::string of = names[q].name.substr(0, names[q].name.rfind('.'));
    if (!here[first + q] || !slopes[first + q]) continue;
    const double f = *here[first + q], by = 2 * step * std::abs(*slopes[first + q]) + 1e-6 * f;
    if (of != list || f - by > reach) groups.emplace_back();
    reach = of != list ? f + by : std::max(reach, f + by);
    list = of;
    groups.back().push_back(first + q);
  }
  std::erase_if(groups, [](const Group& g) { return g.size() < 2; });
  return groups;
}

void average_values(const std::vector<Group>& groups, std::vector<double>& values) {
  for (const Group& g : groups) {
    double squares = 0;
    for (const std::size_t i : g) squares += values[i] * values[i];
    for (const std::size_t i : g) values[i] = std::sqrt(squares / static_cast<double>(g.size()));
  }
}

// Standard deviation of every number by rounding, from designs that differ by nothing else.
template <class Evaluate>
std::vector<double> rounding_of(const Evaluate& numbers) {
  constexpr int samples = 6;
  std::vector<double> sum, squares;
  const std::vector<double> first = numbers(0);
  sum.assign(first.size(), 0);
  squares.assign(first.size(), 0);
  for (int k = 1; k < samples; ++k) {
    const std::vector<double> other = numbers(1e-14 * k);
    for (std::size_t i = 0; i < first.size(); ++i) {
      sum[i] += other[i] - first[i];
      squares[i] += (other[i] - first[i]) * (other[i] - first[i]);
    }
  }
  for (std::size_t i = 0; i < first.size(); ++i)
    squares[i] = std::sqrt(std::max(0.0, squares[i] - sum[i] * sum[i] / samples) / (samples - 1));
  return squares;
}

constexpr const char* screening = "parasitic_frequency_screening";

// At each point the mode that the screening frequency is of; nothing where an equal one is beside
// it.
std::vector<std::optional<std::size_t>> screening_modes(const StrokeResponse& response,
                                                        const StrokeRequest& request) {
  const std::vector<FrequencyDerivatives>& all = response.frequency_derivatives;
  const auto equal = [&](std::size_t a, std::size_t b) {
    return b < all.size() && std::abs(all[a].omega2 - all[b].omega2) < 1e-6 * all[a].omega2;
  };
  std::vector<std::optional<std::size_t>> modes;
  for (const PathPoint& point : response.path) {
    modes.emplace_back();
    const auto found = screening_frequencies(all, request, point.stroke);
    if (found.empty()) continue;
    const std::size_t k = found.front().mode;
    if (!equal(k, k + 1) && !equal(k, k - 1)) modes.back() = k;
  }
  return modes;
}

void average_slopes(const std::vector<Group>& groups, const Numbers& here, Numbers& slopes) {
  for (const Group& g : groups) {
    double squares = 0, change = 0;
    for (const std::size_t i : g) {
      squares += *here[i] * *here[i];
      change += *here[i] * *slopes[i];
    }
    for (const std::size_t i : g)
      slopes[i] = change / std::sqrt(squares * static_cast<double>(g.size()));
  }
}

}  // namespace

GradientReport check_gradients(const Job& job, double tolerance, int threads) {
  GradientReport report;
  if (const auto reason = without_exact_gradients(job)) {
    report.message = *reason;
    return report;
  }
  StrokeRequest request = job.optimise ? request_of_goals(job, make_goals(job)) : job.request;
  request.exact = true;
  request.path = true;
  request.shapes = false;
  request.newton.tolerance = std::min(request.newton.tolerance, 1e-12);
  // the last of a list may change places with one that is not listed
  const int listed = request.frequencies;
  if (listed > 0) request.frequencies += 2;

  const std::vector<std::string> parameters = differentiable_parameters(job);
  std::vector<std::string> columns = parameters;  // then the parameters that are formulas
  std::vector<VectorXd> chain(parameters.size());
  for (const auto& [name, formula] : job.design.expressions) {
    columns.push_back(name);
    std::vector<std::string> given;
    for (const auto& [other, value] : job.design.parameters)
      if (!job.design.expressions.contains(other)) given.push_back(other);
    const Expression expression(formula, given, "/design/parameters/" + name + "/expression");
    const std::optional<VectorXd> slope = expression.gradient(job.design.parameters);
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      const auto at = std::ranges::find(expression.names(), parameters[p]);
      chain[p].conservativeResize(chain[p].size() + 1);
      chain[p][chain[p].size() - 1] =
          slope && at != expression.names().end() ? (*slope)[at - expression.names().begin()] : 0;
    }
  }
  const auto total_slope = [&](const VectorXd& gradient, int p) {
    const VectorXd& of_formulas = chain[static_cast<std::size_t>(p)];
    return gradient[p] + of_formulas.dot(gradient.tail(of_formulas.size()));
  };
  const StrokeSensitivity exact =
      stroke_sensitivity(job, job.design.parameters, columns, job.model, request);
  if (exact.response.status != Status::ok || !exact.gradients) {
    report.message = exact.response.message;
    return report;
  }
  const std::vector<Quantity> names =
      quantities(find_family(job.design.family, "/design/family").drive);
  const std::vector<PointGradients>& points = exact.gradients->path;
  // the lowest of the screening frequencies has kinks: that of the mode which is the lowest here
  const std::vector<std::optional<std::size_t>> screened = screening_modes(exact.response, request);
  const auto values = [&](const StrokeResponse& response) {
    Numbers all;
    for (std::size_t k = 0; k < response.path.size(); ++k)
      for (const Quantity& q : names) {
        if (q.name != screening)
          all.push_back(value_of(response.path[k], q.name));
        else if (screened[k] && *screened[k] < response.frequency_derivatives.size())
          all.push_back(screening_frequency(response.frequency_derivatives[*screened[k]],
                                            response.path[k].stroke));
        else
          all.push_back(std::nullopt);
      }
    return all;
  };
  const Numbers here = values(exact.response);
  const auto plain = [&](const std::string& parameter, double value) {
    const Job other = moved(job, parameter, value);
    const StrokeResponse response =
        evaluate_stroke(make_mechanism(other, other.design.parameters), job.model, request);
    if (response.status != Status::ok)
      throw SpecError("/design", fmt::format("{} = {:g}", parameter, value), response.message);
    std::vector<double> numbers;
    for (const auto& v : values(response)) numbers.push_back(v.value_or(0));
    return numbers;
  };
  std::vector<double> noise;
  try {
    noise = rounding_of([&](double by) {
      return plain(parameters.front(), present(job, parameters.front()) * (1 + by));
    });
  } catch (const SpecError& error) {
    report.message = fmt::format("no differences: {}", error.what());
    return report;
  }
  const bool turns = is_rotation(find_family(job.design.family, "/design/family").drive);
  double stroke = 0;
  for (const PathPoint& point : exact.response.path)
    stroke =
        std::max(stroke, request.load_path ? (turns ? point.rotation : point.displacement).norm()
                                           : std::abs(point.stroke));
  double leaf_length = 0;
  for (const LeafSpring& l : make_mechanism(job, job.design.parameters).leaves)
    leaf_length = std::max(leaf_length, l.length);
  std::vector<double> largest(names.size(), 0.0);  // of each quantity along the path
  for (std::size_t i = 0; i < here.size(); ++i)
    largest[i % names.size()] = std::max(largest[i % names.size()], std::abs(here[i].value_or(0)));

  report.checks.resize(parameters.size() * names.size());
  std::vector<std::string> failed(parameters.size());
  parallel_for(static_cast<int>(parameters.size()), threads, [&](int index) {
    const auto p = static_cast<std::size_t>(index);
    const std::string& name = parameters[p];
    const double x = present(job, name), size_of_x = x != 0 ? std::abs(x) : unit(job, name);
    const double step = 0.02 * size_of_x;
    Numbers slopes;
    for (const PointGradients& point : points)
      for (const Quantity& q : names) {
        const auto g = gradient_of(point, q.name);
        slopes.push_back(g ? std::optional(total_slope(*g, index)) : std::nullopt);
      }
    for (std::size_t i = 0; i < slopes.size(); ++i) {  // a stress that is nothing but rounding
      const std::size_t q = i % names.size();
      if (names[q].name == "max_stress" && here[i].value_or(0) < 1e-6 * largest[q])
        slopes[i].reset();
    }
    std::vector<Group> groups;
    for (std::size_t k = 0; k < points.size(); ++k)
      for (Group& g : groups_of(names, here, slopes, k * names.size(), step)) {
        for (std::size_t q = 0; q < names.size(); ++q)  // the lowest of a group has kinks
          for (const std::size_t i : g)
            if (names[q].name == "parasitic_frequency" && here[i] == here[k * names.size() + q])
              slopes[k * names.size() + q].reset();
        groups.push_back(std::move(g));
      }
    average_slopes(groups, here, slopes);
    const auto beyond = [&](std::size_t q) {
      const std::string& of = names[q].name;
      return of.starts_with("frequencies.") && std::stoi(of.substr(of.rfind('.') + 1)) >= listed;
    };
    for (const Group& g : groups)
      if (std::ranges::any_of(g, [&](std::size_t i) {
            return std::stoi(names[i % names.size()].name.substr(
                       names[i % names.size()].name.rfind('.') + 1)) +
                       1 ==
                   request.frequencies;
          }))
        for (const std::size_t i : g) slopes[i].reset();
    for (std::size_t i = 0; i < slopes.size(); ++i)
      if (beyond(i % names.size())) slopes[i].reset();
    const auto numbers_at = [&](double value) {
      std::vector<double> numbers = plain(name, value);
      average_values(groups, numbers);
      return numbers;
    };
    Derivatives differences;
    try {
      const bool at_edge = x == 0 && name == "end_effector.mass";  // none is negative
      differences = ridders(numbers_at, x, step, 5, noise, at_edge);
    } catch (const SpecError& error) {
      failed[p] = fmt::format("{}: no differences: {}", name, error.what());
      return;
    }
    for (std::size_t q = 0; q < names.size(); ++q) {
      GradientCheck& check = report.checks[p * names.size() + q];
      double steepest = 0;
      for (std::size_t k = 0; k < points.size(); ++k)
        steepest = std::max(steepest, std::abs(differences.value[k * names.size() + q]));
      for (std::size_t k = 0; k < points.size(); ++k) {
        const std::size_t i = k * names.size() + q;
        if (!slopes[i] || !here[i]) continue;
        const double motion = names[q].unit == "m"     ? stroke * (turns ? leaf_length : 1.0)
                              : names[q].unit == "rad" ? stroke / (turns ? 1.0 : leaf_length)
                                                       : 0.0;
        const double floor = std::max(1e-2 * largest[q], 0.1 * motion);
        const double size =
            std::max({std::abs(differences.value[i]), 1e-2 * steepest,
                      0.1 * std::max(std::abs(*here[i]), floor) / size_of_x, 1e-300});
        GradientCheck c{names[q].name,
                        name,
                        static_cast<int>(k),
                        *slopes[i],
                        differences.value[i],
                        std::abs(*slopes[i] - differences.value[i]) / size,
                        differences.error[i] / size,
                        false};
        c.agrees = c.error <= std::max(tolerance, 5 * c.known_to);
        // where a stress peak jumps from leaf to leaf there is a derivative on each side
        const auto accept = [&](double d, double known) {
          c.difference = d;
          c.error = std::abs(c.exact - d) / size;
          c.known_to = known / size;
          c.agrees = true;
        };
        const auto one_sided = [&](double d, double known) {
          if (c.agrees || std::abs(d - differences.value[i]) < 20 * known) return;
          if (std::abs(c.exact - d) <= std::max(tolerance * size, 5 * known)) accept(d, known);
        };
        one_sided(differences.forward[i], differences.forward_error[i]);
        one_sided(differences.backward[i], differences.backward_error[i]);
        // a material point on a line of the mesh: the second derivative jumps
        if (!c.agrees && std::abs(c.exact - differences.rough[i]) <= 5 * differences.rough_error[i])
          accept(differences.rough[i], differences.rough_error[i]);
        if (check.quantity.empty() || (check.agrees && !c.agrees) ||
            (check.agrees == c.agrees && c.error > check.error))
          check = c;
      }
    }
  });
  std::erase_if(report.checks, [](const GradientCheck& c) { return c.quantity.empty(); });
  int wrong = 0;
  double worst = 0;
  for (const GradientCheck& c : report.checks) {
    wrong += !c.agrees;
    worst = std::max(worst, c.error);
  }
  std::erase(failed, "");
  report.ok = wrong == 0 && failed.empty() && !report.checks.empty();
  report.message = fmt::format("{} of {} derivatives agree, largest difference {:.1e}",
                               report.checks.size() - static_cast<std::size_t>(wrong),
                               report.checks.size(), worst);
  for (const std::string& f : failed) report.message += "; " + f;
  return report;
}

}  // namespace flexopt
