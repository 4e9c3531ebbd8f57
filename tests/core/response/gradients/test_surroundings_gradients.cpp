// Exact derivatives with respect to the design of mechanisms whose edges sit other than designed,
// whose leaves are warm, and that are heavy: against differences of the whole path.
#include "support/gradient_checks.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

const std::vector<Number> numbers{
    {"length", 0.1},   {"width", 0.02}, {"thickness", 0.5e-3}, {"modulus", 2e11}, {"poisson", 0.3},
    {"density", 7800}, {"mass", 0.4},   {"tilt", 0.2},         {"reach", 0.012},  {"curve", 0.5}};

/// A guide of two unlike leaves that are not parallel to the axes, one held by the ground and one
/// by a body in between; its base stands on a third one.
Mechanism skew_guide(const Values& p, bool curved) {
  const Material material{"m", p[3], p[4], p[5], {}, 1.2e-5};
  Mechanism m{.bodies = {models::body({p[0], 0.001, 0.002}, p[6], 3e-4)},
              .drives = {make_drive(Direction::uy)}};
  m.bodies[0].center_of_mass += Vector3d(0.01, p[8], -0.005);
  for (const double side : {1.0, -1.0}) {
    LeafSpring l = models::leaf({0, 0.03 * side, 0}, {1, p[7] * side, 0}, p[0], p[1],
                                (1 + 0.1 * side) * p[2], material);
    if (curved) {
      l.curve = side * p[9];
      l.length = p[0] / sine_ratio(0.5 * p[9]);
    }
    m.leaves.push_back(l);
  }
  return m;
}

/// Ground, leaf, body 1, leaf, end-effector.
Mechanism row_of_two(const Values& p) {
  Mechanism m{.bodies = {models::body({2.1 * p[0], 0, 0}, 0.3, 1e-4),
                         models::intermediate({1.05 * p[0], 0.002, 0}, p[6], 5e-5)},
              .drives = {make_drive(Direction::uy)}};
  const Material material{"m", p[3], p[4], p[5], {}, 1.2e-5};
  m.leaves = {
      models::between(ground, 1, models::leaf({0, 0, 0}, {1, p[7], 0}, p[0], p[1], p[2], material)),
      models::between(1, 0,
                      models::leaf({1.1 * p[0], 0, 0}, {1, 0, 0}, p[0], p[1], p[2], material))};
  return m;
}

/// Clamped at both ends, O a point of it.
Mechanism clamped(const Values& p) {
  return models::clamped_at_both(
      models::single_leaf(p[0], p[1], p[2], Direction::uy, {"m", p[3], p[4], p[5], {}, 1.2e-5}),
      0.4, 0.6, 0.02);
}

StrokeRequest request_with(LoadCase loads, std::vector<double> points) {
  return {.points = std::move(points), .loads = std::move(loads), .frequencies = 3};
}

LoadCase crooked() {
  return {.assembly = {{0, 0, {2e-5, 5e-5, 1e-4}, {1e-3, 1.5e-3, -2e-3}},
                       {1, 1, {-1e-5, 3e-5, -5e-5}, {-5e-4, 5e-4, 1e-3}}}};
}

/// All numbers of a mechanism along errors of assembly (unit: 1e-4 m and 1e-3 rad) against
/// differences; how many.
int check_along_errors(const Mechanism& mechanism, const ModelOptions& model,
                       const LoadCase& loads) {
  StrokeRequest request = request_with(loads, {0, 0.004});
  request.values = PathValues::differentiable;
  request.newton.tolerance = 1e-11;
  request.outputs.remove(Output::frequency_derivatives);
  const AssemblyError rates[] = {{0, 0, {1e-4, 0, 0}, Vector3d::Zero()},
                                 {0, 0, Vector3d::Zero(), {0, 1e-3, 0}},
                                 {0, 1, {0, 0.5e-4, 1e-4}, {1e-3, 0, -5e-4}},
                                 {1, 1, {0, 1e-4, 0}, {0, 0, 1e-3}}};
  std::vector<MechanismDirection> directions;
  for (const AssemblyError& rate : rates)
    directions.push_back(assembly_direction("error", mechanism, rate));
  const StrokeSensitivity exact = evaluate_stroke_gradients(mechanism, directions, model, request);
  INFO(exact.message << " " << exact.response.message);
  REQUIRE(exact.gradients);
  const std::vector<Compared> here = compared_numbers(mechanism, exact, 10);
  int compared = 0, unknown = 0;
  for (std::size_t d = 0; d < std::size(rates); ++d) {
    const auto values = [&](double x) {
      StrokeRequest moved = request;
      std::vector<AssemblyError>& errors = moved.loads.assembly;
      const auto own = std::ranges::find_if(errors, [&](const AssemblyError& e) {
        return e.leaf == rates[d].leaf && e.end == rates[d].end;
      });
      if (own == errors.end()) {
        errors.push_back({rates[d].leaf, rates[d].end, x * rates[d].move, x * rates[d].turn});
      } else {
        own->move += x * rates[d].move;
        own->turn += x * rates[d].turn;
      }
      const StrokeResponse response = evaluated(mechanism, model, moved);
      Values all;
      for (const Compared& c : compared_numbers(mechanism, {response, {}, {}}, 0))
        all.push_back(c.value);
      return all;
    };
    const Derivatives differences = ridders(values, 0, 0.2, 5);
    for (std::size_t i = 0; i < here.size(); ++i) {
      if (!here[i].gradient) continue;
      ++compared;
      const double size = std::max(std::abs(differences.value[i]),
                                   1e-2 * std::max(std::abs(here[i].value), here[i].floor)),
                   found = (*here[i].gradient)[static_cast<Eigen::Index>(d)];
      INFO("error " << d << ": " << here[i].name << " (" << here[i].value << "), " << found
                    << " not " << differences.value[i] << ", known to "
                    << differences.error[i] / size);
      const double known = differences.error[i] / size;
      if (known > 0.1) ++unknown;  // a kink within the steps
      if (known > 0.1) continue;
      double error = std::abs(found - differences.value[i]) / size;
      // where another place takes over there is a derivative on either side
      const std::string& name = here[i].name;
      if (name.starts_with("envelope") || name.starts_with("clearance") ||
          name.starts_with("max_stress")) {
        const auto [low, high] = std::minmax(differences.forward[i], differences.backward[i]);
        const double with =
            1e-6 * size + 5 * std::max(differences.forward_error[i], differences.backward_error[i]);
        if (found >= low - with && found <= high + with) error = 0;
      }
      // 5e-9 of a value that does not change: what Newton's tolerance leaves of the differences
      CHECK(error <= 5e-7 + 5 * known);
    }
  }
  CHECK(unknown <= 0.02 * compared);
  return compared;
}

}  // namespace

TEST_CASE("derivatives of crooked, heavy and warm mechanisms agree with differences", "[slow]") {
  using Numbers = std::vector<std::size_t>;
  struct Case {
    const char* what;
    LoadCase loads;
    Numbers straight, curved;  ///< numbers of the design
  };
  const Case c =
      GENERATE(Case{"crooked", crooked(), {0, 1, 2, 7}, {0, 2, 7, 9}},
               Case{"heavy", {.gravity = {8, -30, 50}}, {0, 1, 2, 4, 5, 6, 7, 8}, {2, 5, 9}},
               Case{"warm", {.temperature = {12, -7}}, {0, 1, 2, 3, 4, 7}, {1, 2, 9}},
               Case{"warm bodies",
                    {.temperature = {12, -7}, .body_expansion = {3e-4, -1e-4}},
                    {0, 1, 2, 4, 7},
                    {0, 1, 9}});
  const Flexure flexure = GENERATE(Flexure::plate, Flexure::beam);
  const bool curved = GENERATE(false, true);
  CAPTURE(c.what, curved);
  const Family family{[=](const Values& p) { return skew_guide(p, curved); }, numbers,
                      curved ? c.curved : c.straight, 10.0};
  CHECK(check_gradients(family, models::coarse(flexure), request_with(c.loads, {0, 0.004})) > 100);
}

TEST_CASE("derivatives know all of them at once on bodies in a row", "[slow]") {
  LoadCase all = crooked();
  all.gravity = {3, -2, 4};
  all.temperature = {12, -7};
  all.body_expansion = {2e-4, -3e-4, 1e-4};
  const Family family{row_of_two, numbers, {0, 1, 2, 5, 6, 7}, 1.0};
  CHECK(check_gradients(family, models::coarse(Flexure::plate), request_with(all, {0, 0.01})) >
        100);
}

TEST_CASE("derivatives know a warm and crooked leaf whose point is driven") {
  LoadCase all{.assembly = {{0, 1, {0, 2e-5, 0}, {5e-4, 0, 1e-3}}},
               .temperature = {-6},
               .gravity = {1, 20, 5}};
  const Flexure flexure = GENERATE(Flexure::plate, Flexure::beam);
  const Family family{clamped, numbers, {0, 1, 2, 5}, 10.0};
  CHECK(check_gradients(family, models::coarse(flexure), request_with(all, {0, 4e-4})) > 50);
}

TEST_CASE("derivatives of reduced crooked mechanisms agree with differences", "[slow]") {
  const Family family{
      [](const Values& p) { return skew_guide(p, false); }, numbers, {0, 2, 7}, 10.0};
  StrokeRequest request = request_with(crooked(), {0, 0.004});
  request.outputs.remove(Output::frequency_derivatives);
  CHECK(check_gradients(family, {.mesh = {6, 2}}, request) > 80);
}

TEST_CASE("derivatives along errors of assembly agree with differences", "[slow]") {
  const Values p = values_of(numbers);
  const bool at_rest = GENERATE(true, false);  // no errors yet, or some
  const LoadCase loads = at_rest ? LoadCase() : crooked();
  SECTION("plates") {
    CHECK(check_along_errors(skew_guide(p, false), models::coarse(Flexure::plate), loads) > 100);
  }
  SECTION("curved beams between bodies, with warm clamps") {
    LoadCase warmer = loads;
    warmer.temperature = {12, -7};
    warmer.body_expansion = {3e-4, -1e-4};
    CHECK(check_along_errors(skew_guide(p, true), models::coarse(Flexure::beam), warmer) > 100);
  }
  SECTION("bodies in a row") {
    CHECK(check_along_errors(row_of_two(p), models::coarse(Flexure::beam), loads) > 100);
  }
  SECTION("reduced leaves") {
    ModelOptions model{.mesh = {6, 2}};
    CHECK(check_along_errors(skew_guide(p, false), model, loads) > 80);
  }
}
