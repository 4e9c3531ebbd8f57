#include "optim/check_gradients.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/math/ridders.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/goals.hpp"
#include "optim/parallel.hpp"
#include "optim/stroke_sensitivity.hpp"

namespace flexopt {
namespace {

// The job with one of its numbers changed.
Job moved(const Job& job, const std::string& name, double value) {
  Job other = job;
  const auto after = [&](const std::string& prefix) {
    return name.starts_with(prefix) ? name.substr(prefix.size()) : std::string();
  };
  if (const std::string of = after("material."); !of.empty()) {
    Material& m = other.design.material;
    (of == "youngs_modulus"   ? m.youngs_modulus
     : of == "poissons_ratio" ? m.poissons_ratio
                              : m.density) = value;
  } else if (const std::string of = after("end_effector."); !of.empty()) {
    EndEffector& e = other.end_effector;
    const auto axis = [&](std::size_t i) { return of[of.size() - i] - 'x'; };
    if (of == "mass")
      e.mass = value;
    else if (of.starts_with("center_of_mass"))
      e.center_of_mass[axis(1)] = value;
    else
      e.inertia(axis(2), axis(1)) = e.inertia(axis(1), axis(2)) = value;
  } else {
    other.design.parameters[name] = value;
  }
  return other;
}

double present(const Job& job, const std::string& name) {
  const auto& e = job.end_effector;
  if (name == "material.youngs_modulus") return job.design.material.youngs_modulus;
  if (name == "material.poissons_ratio") return job.design.material.poissons_ratio;
  if (name == "material.density") return job.design.material.density;
  if (name == "end_effector.mass") return e.mass;
  const char last = name.back(), before = name[name.size() - 2];
  if (name.starts_with("end_effector.center_of_mass")) return e.center_of_mass[last - 'x'];
  if (name.starts_with("end_effector.inertia")) return e.inertia(before - 'x', last - 'x');
  return job.design.parameters.at(name);
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

// Values (or derivatives along one parameter) of all quantities at all points, where there are any;
// members of a cluster replaced by their mean.
using Numbers = std::vector<std::optional<double>>;

void average_clusters(const std::vector<FrequencyCluster>& clusters, const char* list,
                      const std::vector<Quantity>& names, std::size_t first, Numbers& numbers) {
  for (const FrequencyCluster& c : clusters) {
    double sum = 0;
    std::vector<std::size_t> members;
    for (int k = c.first; k < c.first + c.size; ++k)
      for (std::size_t q = 0; q < names.size(); ++q)
        if (names[q].name == fmt::format("frequencies.{}.{}", list, k) && numbers[first + q]) {
          sum += *numbers[first + q];
          members.push_back(first + q);
        }
    const bool whole = static_cast<int>(members.size()) == c.size;  // else it has no mean
    for (const std::size_t i : members) {
      if (whole)
        numbers[i] = sum / c.size;
      else
        numbers[i].reset();
    }
  }
}

bool in_cluster(const PointGradients& point, const StrokeRequest& request) {
  const auto& clusters =
      request.parasitic_with_drive_locked ? point.clusters_locked : point.clusters_free;
  const MatrixXd& rows =
      request.parasitic_with_drive_locked ? point.frequencies_locked : point.frequencies_free;
  for (const FrequencyCluster& c : clusters)
    for (int k = c.first; k < std::min<int>(c.first + c.size, static_cast<int>(rows.rows())); ++k)
      if (point.parasitic_frequency && rows.row(k).transpose() == *point.parasitic_frequency)
        return true;
  return false;
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
  request.frequency_derivatives = false;
  request.path = true;
  request.shapes = false;
  request.newton.tolerance = std::min(request.newton.tolerance, 1e-11);

  const std::vector<std::string> parameters = differentiable_parameters(job);
  const StrokeSensitivity exact =
      stroke_sensitivity(job, job.design.parameters, parameters, job.model, request);
  if (exact.response.status != Status::ok || !exact.gradients) {
    report.message = exact.response.message;
    return report;
  }
  const std::vector<Quantity> names =
      quantities(find_family(job.design.family, "/design/family").drive);
  const std::vector<PointGradients>& points = exact.gradients->path;
  const auto values = [&](const StrokeResponse& response) {
    Numbers all;
    for (std::size_t k = 0; k < response.path.size(); ++k) {
      const std::size_t first = all.size();
      for (const Quantity& q : names) all.push_back(value_of(response.path[k], q.name));
      average_clusters(points[k].clusters_free, "drive_free", names, first, all);
      average_clusters(points[k].clusters_locked, "drive_locked", names, first, all);
    }
    return all;
  };
  const Numbers here = values(exact.response);
  double stroke = 0;
  for (const double s : request.points) stroke = std::max(stroke, std::abs(s));
  double load = 0;
  for (const PathPoint& p : exact.response.path) load = std::max(load, std::abs(p.drive_load));

  report.checks.resize(parameters.size() * names.size());
  std::vector<std::string> failed(parameters.size());
  parallel_for(static_cast<int>(parameters.size()), threads, [&](int index) {
    const auto p = static_cast<std::size_t>(index);
    const std::string& name = parameters[p];
    const double x = present(job, name), size_of_x = x != 0 ? std::abs(x) : unit(job, name);
    Derivatives differences;
    try {
      differences = ridders(
          [&](double value) {
            const Job other = moved(job, name, value);
            const StrokeResponse response =
                evaluate_stroke(make_mechanism(other, other.design.parameters), job.model, request);
            if (response.status != Status::ok)
              throw SpecError("/design", fmt::format("{} = {:g}", name, value), response.message);
            std::vector<double> numbers;
            for (const auto& v : values(response)) numbers.push_back(v.value_or(0));
            return numbers;
          },
          x, 0.02 * size_of_x, 5);
    } catch (const SpecError& error) {
      failed[p] = fmt::format("{}: no differences: {}", name, error.what());
      return;
    }
    Numbers slopes;  // of the family's parameters, formulas following
    for (std::size_t k = 0; k < points.size(); ++k) {
      const std::size_t first = slopes.size();
      for (const Quantity& q : names) {
        const auto g = gradient_of(points[k], q.name);
        slopes.push_back(g ? std::optional((*g)[index]) : std::nullopt);
        if (q.name == "parasitic_frequency" && in_cluster(points[k], request))
          slopes.back().reset();  // the lowest of a cluster has a kink
      }
      average_clusters(points[k].clusters_free, "drive_free", names, first, slopes);
      average_clusters(points[k].clusters_locked, "drive_locked", names, first, slopes);
    }
    for (std::size_t q = 0; q < names.size(); ++q) {
      GradientCheck& check = report.checks[p * names.size() + q];
      for (std::size_t k = 0; k < points.size(); ++k) {
        const std::size_t i = k * names.size() + q;
        if (!slopes[i] || !here[i]) continue;
        const double floor = names[q].unit == "m"            ? 1e-3 * stroke
                             : names[q].unit == "rad"        ? 1e-3 * stroke
                             : names[q].name == "drive_load" ? 1e-3 * load
                                                             : 0.0;
        const double size =
            std::max({std::abs(differences.value[i]),
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
