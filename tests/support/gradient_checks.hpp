#pragma once
// Exact derivatives of everything a mechanism answers against extrapolated differences of the whole
// path, for mechanisms made from a list of numbers.
#include <catch2/catch.hpp>
#include <functional>
#include <iomanip>
#include <vector>

#include "core/math/ridders.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt::test {

struct Number {
  const char* name;
  double value;
};
using Values = std::vector<double>;

struct Family {
  std::function<Mechanism(const Values&)> make;
  std::vector<Number> numbers;
  std::vector<std::size_t> along;  ///< which of them to differentiate
  double load;  ///< size of a drive load, for those that are zero but for rounding
};

inline Values values_of(const std::vector<Number>& numbers) {
  Values values;
  for (const Number& n : numbers) values.push_back(n.value);
  return values;
}

/// Every number that may move, to write its rate in its place.
inline std::vector<double*> places(Mechanism& m) {
  std::vector<double*> all;
  const auto vector = [&all](auto& v) {
    for (Eigen::Index i = 0; i < v.size(); ++i) all.push_back(v.data() + i);
  };
  for (LeafSpring& l : m.leaves) {
    vector(l.origin);
    vector(l.axes);
    for (double* x : {&l.length, &l.width, &l.thickness, &l.material.youngs_modulus,
                      &l.material.poissons_ratio, &l.material.density})
      all.push_back(x);
    if (l.point) all.insert(all.end(), {&l.point->along, &l.point->across});
  }
  for (RigidBody& b : m.bodies) {
    vector(b.reference);
    vector(b.center_of_mass);
    all.push_back(&b.mass);
    vector(b.inertia);
  }
  for (Joint& j : m.joints) {
    vector(j.place);
    vector(j.axis);
  }
  return all;
}

/// Derivative of a mechanism along its number k.
inline MechanismDirection direction(const Family& family, std::size_t k) {
  const Values p = values_of(family.numbers);
  const Derivatives d = ridders(
      [&](double x) {
        Values moved = p;
        moved[k] = x;
        Mechanism m = family.make(moved);
        Values out;
        for (const double* n : places(m)) out.push_back(*n);
        return out;
      },
      p[k], 0.05 * p[k]);
  MechanismDirection result{family.numbers[k].name, family.make(p)};
  const std::vector<double*> rates = places(result.rate);
  for (std::size_t i = 0; i < rates.size(); ++i) *rates[i] = d.value[i];
  return result;
}

/// Compares every derivative there is; how many.
inline int check_gradients(const Family& family, const ModelOptions& model, StrokeRequest request,
                           double step = 0.02) {
  request.frequency_derivatives = false;
  request.exact = true;
  request.newton.tolerance = 1e-11;
  const Values p = values_of(family.numbers);
  std::vector<MechanismDirection> directions;
  for (const std::size_t k : family.along) directions.push_back(direction(family, k));
  const Mechanism mechanism = family.make(p);
  REQUIRE_FALSE(broken_rule(mechanism));
  const StrokeSensitivity exact = evaluate_stroke_gradients(mechanism, directions, model, request);
  INFO(exact.message << " " << exact.response.message);
  REQUIRE(exact.gradients);
  REQUIRE(exact.response.status == Status::ok);

  const std::vector<Quantity> all = quantities(mechanism.drive);
  const auto values = [&](const StrokeResponse& r) {
    Values v;
    for (const PathPoint& point : r.path)
      for (const Quantity& q : all) v.push_back(value_of(point, q.name).value_or(0));
    return v;
  };
  const Values here = values(exact.response);
  int compared = 0, near = 0;
  for (std::size_t d = 0; d < family.along.size(); ++d) {
    const std::size_t k = family.along[d];
    const Derivatives differences = ridders(
        [&](double x) {
          Values moved = p;
          moved[k] = x;
          const StrokeResponse response = evaluate_stroke(family.make(moved), model, request);
          REQUIRE(response.status == Status::ok);
          return values(response);
        },
        p[k], step * p[k], 5);
    std::size_t n = 0;
    for (const PointGradients& point : exact.gradients->path)
      for (const Quantity& q : all) {
        const std::size_t i = n++;
        const auto gradient = gradient_of(point, q.name);
        if (!gradient) continue;
        ++compared;
        // values that are zero but for rounding count as 1e-2 of what the stroke makes of them
        const double floor = q.name.starts_with("displacement") ? 1e-2 * 0.02
                             : q.name.starts_with("rotation")   ? 1e-2 * 0.4
                             : q.name == "drive_load"           ? 1e-2 * family.load
                                                                : 0.0;
        const double size = std::max(std::abs(differences.value[i]),
                                     0.1 * std::max(std::abs(here[i]), floor) / p[k]);
        const double known = differences.error[i] / size;
        CAPTURE(here[i]);
        INFO(std::setprecision(12)
             << family.numbers[k].name << ": " << q.name << " at point " << i / all.size() << ", "
             << (*gradient)[static_cast<Eigen::Index>(d)] << " not " << differences.value[i]
             << ", known to " << known);
        const double error =
            std::abs((*gradient)[static_cast<Eigen::Index>(d)] - differences.value[i]) / size;
        CHECK(error <= 1e-7 + 5 * known);
        near += error <= 1e-8 + 5 * known;
        CHECK(known <= 1e-4);
      }
  }
  CHECK(near >= 0.97 * compared);
  return compared;
}

}  // namespace flexopt::test
