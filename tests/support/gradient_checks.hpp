#pragma once
// Exact derivatives of everything a mechanism answers against extrapolated differences of the whole
// path, for mechanisms made from a list of numbers.
#include <catch2/catch.hpp>
#include <functional>
#include <iomanip>
#include <optional>
#include <string>
#include <vector>

#include "core/math/ridders.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/response/quantities.hpp"
#include "support/models.hpp"
#include "support/nightly.hpp"
#include "support/strokes.hpp"

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
  each_number(m, [&](double& x) { all.push_back(&x); });
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

/// Along all numbers that a family is differentiated along.
inline std::vector<MechanismDirection> directions_of(const Family& family) {
  std::vector<MechanismDirection> all;
  for (const std::size_t k : family.along) all.push_back(direction(family, k));
  return all;
}

/// Differences of an answer of mechanisms along number k of their family.
template <class Answer>
Derivatives differences_along(const Family& family, std::size_t k, double share,
                              const Answer& answer) {
  Values moved = values_of(family.numbers);
  const double here = moved[k];
  return ridders(
      [&](double x) {
        moved[k] = x;
        return answer(family.make(moved));
      },
      here, share * here);
}

/// One number that has a derivative, and the least size that its errors count against.
struct Compared {
  std::string name;
  double value, floor;
  std::optional<VectorXd> gradient;
};

/// Every quantity of every point, then what the frequencies do along the stroke.
inline std::vector<Compared> compared_numbers(const Mechanism& mechanism,
                                              const StrokeSensitivity& exact, double load) {
  std::vector<Compared> all;
  for (std::size_t i = 0; i < exact.response.path.size(); ++i) {
    DriveList names(mechanism);
    names.numbers = exact.response.path[i].numbers;
    for (const Quantity& q : quantities(names)) {
      // values that are zero but for rounding count as 1e-2 of what the stroke makes of them
      const double floor = q.name.starts_with("displacement") ? 1e-2 * 0.02
                           : q.name.starts_with("rotation")   ? 1e-2 * 0.4
                           : q.row->name == "drive_load"      ? 1e-2 * load
                           : q.row->needs.has(Output::gain)
                               ? 1e-2 * std::max(1.0, 1 / mechanism.leaves[0].length)
                               : 0.0;
      all.push_back({q.name + " at point " + std::to_string(i),
                     q.value(exact.response.path[i]).value_or(0), floor,
                     exact.gradients ? q.gradient(exact.response.path[i], exact.gradients->path[i])
                                     : std::nullopt});
    }
  }
  const double unit = is_rotation(drive_direction(mechanism)) ? 1 : mechanism.leaves[0].length;
  for (std::size_t k = 0; k < exact.response.frequency_derivatives.size(); ++k) {
    const FrequencyDerivatives& d = exact.response.frequency_derivatives[k];
    const std::string mode = " of mode " + std::to_string(k);
    std::optional<VectorXd> g[3];
    if (exact.gradients) {
      const FrequencyDerivativeGradients& of = exact.gradients->frequency_derivatives.at(k);
      g[0] = of.omega2, g[1] = of.d_omega2, g[2] = of.d2_omega2;
    }
    all.push_back({"omega2" + mode, d.omega2, 0, g[0]});
    all.push_back({"d_omega2" + mode, d.d_omega2, d.omega2 / unit, g[1]});
    all.push_back({"d2_omega2" + mode, d.d2_omega2, d.omega2 / (unit * unit), g[2]});
  }
  return all;
}

/// Ways through the numbers of a family, as relative changes of those that it is differentiated
/// along: nightly each by itself, else one along all of them, unlike in size and sign.
inline std::vector<Values> ways_along(const Family& family) {
  const std::size_t n = family.along.size();
  std::vector<Values> ways(nightly() ? n : 1, Values(n, 0.0));
  if (nightly())
    for (std::size_t d = 0; d < n; ++d) ways[d][d] = 1;
  else
    for (std::size_t d = 0; d < n; ++d) ways[0][d] = (d % 2 ? -1 : 1) * (1 - 0.4 * d / n);
  return ways;
}

/// Compares every derivative there is with differences along `ways_along`; how many. `near_share`:
/// those that agree to 1e-8, the others to 1e-7.
inline int check_gradients(const Family& family, const ModelOptions& model, StrokeRequest request,
                           double step = 0.02, double near_share = 0.97) {
  request.values = PathValues::differentiable;
  request.newton.tolerance = 1e-11;
  const Values p = values_of(family.numbers);
  const std::vector<MechanismDirection> directions = directions_of(family);
  const Mechanism mechanism = family.make(p);
  REQUIRE(check_rules(mechanism));
  const StrokeSensitivity exact = evaluate_stroke_gradients(mechanism, directions, model, request);
  INFO(exact.message << " " << exact.response.message);
  REQUIRE(exact.gradients);
  REQUIRE(exact.response.status == Status::ok);

  const std::vector<Compared> here = compared_numbers(mechanism, exact, family.load);
  const auto moved = [&](const Values& way, double t) {
    Values there = p;
    for (std::size_t d = 0; d < way.size(); ++d) there[family.along[d]] *= 1 + way[d] * t;
    return there;
  };
  const auto values = [&](const Values& way, double t) {
    const Mechanism m = family.make(moved(way, t));
    const StrokeResponse response = evaluate_stroke(m, model, request);
    REQUIRE(response.status == Status::ok);
    Values all;
    for (const Compared& c : compared_numbers(m, {response, {}, {}}, 0)) all.push_back(c.value);
    return all;
  };
  // the values' rounding, from designs that are equal but for rounding
  Values any(family.along.size(), 0.0);
  any[0] = 3e-14;
  std::vector<double> noise(here.size(), 0.0);
  for (int i = 1; i <= 6; ++i) {
    const Values near_by = values(any, i);
    for (std::size_t n = 0; n < noise.size(); ++n)
      noise[n] = std::max(noise[n], std::abs(near_by[n] - here[n].value));
  }
  // and that of the derivatives: loads that all but cancel leave some that are rounding alone
  std::vector<VectorXd> own_noise;
  for (const Compared& c : here)
    own_noise.push_back(
        VectorXd::Zero(static_cast<Eigen::Index>(c.gradient ? c.gradient->size() : 0)));
  for (int i = 1; i <= 3; ++i) {
    const std::vector<Compared> there = compared_numbers(
        mechanism,
        evaluate_stroke_gradients(family.make(moved(any, i)), directions, model, request),
        family.load);
    for (std::size_t n = 0; n < here.size(); ++n)
      if (here[n].gradient && there[n].gradient)
        own_noise[n] = own_noise[n].cwiseMax((*there[n].gradient - *here[n].gradient).cwiseAbs());
  }
  int compared = 0, near = 0, known_well = 0;
  for (const Values& way : ways_along(family)) {
    const Derivatives differences =
        ridders([&](double t) { return values(way, t); }, 0, step, 5, noise);
    VectorXd rate(static_cast<Eigen::Index>(way.size()));  // of the numbers, along t
    std::string along;
    int derivatives = 0;
    for (std::size_t d = 0; d < way.size(); ++d) {
      rate[static_cast<Eigen::Index>(d)] = way[d] * p[family.along[d]];
      if (way[d] == 0) continue;
      along += std::string(derivatives++ ? ", " : "") + family.numbers[family.along[d]].name;
    }
    for (std::size_t i = 0; i < here.size(); ++i) {
      const Compared& c = here[i];
      if (!c.gradient) continue;
      compared += derivatives;
      const double size = std::max(std::abs(differences.value[i]),
                                   0.1 * std::max(std::abs(c.value), c.floor)),
                   known = (differences.error[i] + own_noise[i].dot(rate.cwiseAbs())) / size,
                   found = c.gradient->dot(rate);
      INFO(std::setprecision(12) << along << ": " << c.name << " (" << c.value << "), " << found
                                 << " not " << differences.value[i] << ", known to " << known);
      double error = std::abs(found - differences.value[i]) / size;
      // where two points of a symmetric mechanism reach equally far there is one on each side,
      // and a size between two such points may take one end from either; the largest stress of two
      // places that are stressed alike is that of one or the other
      bool one_sided = false;
      if (c.name.starts_with("envelope") || c.name.starts_with("clearance")) {
        const auto [low, high] = std::minmax(differences.forward[i], differences.backward[i]);
        const double with =
            1e-7 * size + 5 * std::max(differences.forward_error[i], differences.backward_error[i]);
        one_sided = found >= low - with && found <= high + with;
      }
      if (c.name.starts_with("max_stress")) {
        const bool ahead = differences.forward_error[i] < differences.backward_error[i];
        const double side = ahead ? differences.forward[i] : differences.backward[i],
                     with = ahead ? differences.forward_error[i] : differences.backward_error[i];
        one_sided = with < 1e-5 * size && std::abs(found - side) <= 1e-7 * size + 5 * with;
      }
      if (one_sided) error = std::min(error, 1e-8);
      // a power of the stress, whose tables have single precision
      const double rounding = c.name.starts_with("fatigue") ? 2e-7 : 1e-7;
      CHECK(error <= rounding + 5 * known);
      near += (error <= 1e-8 + 5 * known) * derivatives;
      known_well += (known <= 1e-4) * derivatives;
    }
  }
  CHECK(near >= near_share * compared);
  // along all numbers at once a kink along any of them is one
  CHECK(known_well >= (nightly() ? 0.98 : 0.95) * compared);
  return compared;
}

/// All outputs of a guide under a dead load at O, at rest and at a stroke, follow these numbers as
/// their differences do.
inline void check_loaded_guide(const Family& family, Flexure flexure, Accuracy accuracy,
                               double stroke) {
  StrokeRequest request{
      .points = {0, stroke},
      .loads = {.constant = {{.force = {1, 0, -2}, .moment = {0.01, 0.02, -0.01}}}},
      .frequencies = 3};
  const int compared = check_gradients(family, models::coarse(flexure, accuracy), request);
  CHECK(compared >= 2 * 15 * static_cast<int>(family.along.size()));
}

/// All outputs of a leaf between two grounds that is driven at a place on it.
inline void check_driven_point(const Family& family) {
  for (const Flexure flexure : {Flexure::beam, Flexure::plate})
    CHECK(check_gradients(family, models::coarse(flexure), {.points = {0.5e-3}, .frequencies = 2}) >
          20);
}

/// Such a leaf, O at a share of its length and of its width.
inline Mechanism driven_point(LeafSpring leaf, double along, double across, const Vector3d& place) {
  leaf.point = LeafPoint{.body = 0, .along = along, .across = across};
  return {.bodies = {models::follower(place)},
          .leaves = {models::between(ground, ground, std::move(leaf))},
          .drives = {make_drive(Direction::uy)}};
}

}  // namespace flexopt::test
