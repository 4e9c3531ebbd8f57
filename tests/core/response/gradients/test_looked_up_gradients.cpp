// Exact derivatives of mechanisms on looked-up leaves: against differences of these leaves, and
// against the derivatives of full ones.
#include "core/response/modes/full_modes.hpp"
#include "support/gradient_checks.hpp"
#include "support/small_atlas.hpp"

using namespace flexopt;

namespace {

AtlasSettings box() {
  AtlasSettings s = test::small_settings();
  s.mesh = {6, 2};
  s.width = {0.2, 0.5};
  s.thickness = {1.0 / 240, 1.0 / 150};
  s.points = {5, 4};
  s.rays = {-1, 1};  // those of symmetric hinges and guides
  s.sigmas = {0, 0.05, 0.25};
  s.dynamics = true;
  s.stress_samples = 20;
  return s;
}

ModelOptions with_atlas(const std::string& name, const AtlasSettings& s) {
  return {.mesh = s.mesh, .atlas = test::kept_atlas(name, s, test::unchecked())};
}

const ModelOptions& looked_up() {
  static const ModelOptions model = with_atlas("symmetric", box());
  return model;
}

// Three leaves that cross in their middles, or beside them by a share of the length; the outer ones
// are equal. `turned`: the other edges are called the bases.
test::Family hinge(double beside_middle = 0, bool turned = false) {
  const auto make = [turned](const test::Values& p) {
    Mechanism m{.bodies = {models::body({p[8], 0, 0}, p[7], p[7] * 1e-3)},
                .drives = {make_drive(Direction::rz)}};
    const double length = p[0], outer = p[2], inner = p[3], gap = p[5];
    const double beside = 0.5 * (outer + inner) + gap;
    const auto add = [&](double side, double z, double width) {
      const Vector3d along(std::cos(p[4]), side * std::sin(p[4]), 0);
      m.leaves.push_back(
          models::leaf(Vector3d(0, 0, z) - p[11] * length * along, along, length, width, p[1]));
      Material& material = m.leaves.back().material;
      material.youngs_modulus = p[6];
      material.poissons_ratio = p[9];
      material.density = p[10];
      material.ultimate_strength = 1700e6;
      material.endurance_limit = 500e6;
      material.s_n_curve.emplace().basquin = Basquin{2100e6, -0.09};
      if (turned) m.leaves.back() = models::turned(m.leaves.back());
    };
    add(1, beside, outer);
    add(-1, 0, inner);
    add(1, -beside, outer);
    return m;
  };
  return {make,
          {{"length", 0.08},
           {"thickness", 4e-4},
           {"outer width", 0.02},
           {"inner width", 0.032},
           {"half angle", 0.75},
           {"gap", 2e-3},
           {"E", 210e9},
           {"mass", 0.3},
           {"x of the body", 5e-3},
           {"nu", 0.3},
           {"rho", 7800},
           {"crossing", 0.5 - beside_middle}},
          {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10},
          0.3};
}

StrokeRequest sweep() {
  StrokeRequest request{
      .points = {0, 0.12, -0.17},
      .outputs = {Output::equilibrium, Output::stiffness, Output::frequencies_free,
                  Output::frequencies_locked, Output::stress, Output::dynamics},
      .frequencies = 5,
      .dynamics =
          DynamicsRule{0.02, TransmissibilityRule{Direction::ux, 20, 200, DriveState::free}},
      .stress_peaks = 4};
  request.stress.fatigue = request.stress.life = true;
  return request;
}

}  // namespace

TEST_CASE("modes of looked-up leaves are those of the linearised mechanism", "[slow]") {
  const test::Family family = hinge();
  const Mechanism m = family.make(test::values_of(family.numbers));
  System system(m, make_reduced_leaves(m, looked_up(), 0.2));
  for (int i = 0; i < system.leaves(); ++i) system.leaf(i).expect_dynamics(2);
  for (const double stroke : {0.0, 0.15}) {
    REQUIRE(step_to(system, stroke, {}).converged);
    const auto factor = MechanismFactor::of(system);
    REQUIRE(factor);
    const auto both = full_modes(*factor, 6, 5), locked = full_modes(*factor, 0, 5);
    REQUIRE((both && locked));
    CHECK((both->locked.lambda - locked->locked.lambda).norm() <=
          1e-11 * locked->locked.lambda.norm());
    for (const FullModes* list : {&both->free, &both->locked}) {
      const bool held = list == &both->locked;
      REQUIRE(list->modes.size() == (held ? 5u : 6u));
      const MatrixXd& phi = list->phi;
      const MatrixXd M_phi = factor->mass(phi), unit = phi.transpose() * M_phi;
      CHECK((unit - MatrixXd::Identity(unit.rows(), unit.cols())).norm() < 1e-9);
      const MatrixXd b = M_phi * list->lambda.asDiagonal(),
                     off = (held ? factor->solve_locked(b) : factor->solve(b)) - phi;
      CHECK(off.cwiseProduct(factor->mass(off)).colwise().sum().maxCoeff() < 1e-18);
    }
  }
}

TEST_CASE("derivatives of all numbers of a hinge on looked-up leaves agree with differences",
          "[slow]") {
  StrokeRequest request = sweep();
  request.values = PathValues::differentiable;
  const test::Family family = hinge();
  const StrokeResponse here =
      evaluate_stroke(family.make(test::values_of(family.numbers)), looked_up(), request);
  for (const PathPoint& point : here.path)
    for (const LeafReport& leaf : point.leaves) {
      INFO(leaf.reason);
      CHECK(leaf.model == "tube");
    }
  // stresses of looked-up leaves, of which fatigue and life are made, are known less well
  const int compared = test::check_gradients(family, looked_up(), request, 0.02, 0.95);
  CHECK(compared >= 3 * 20 * static_cast<int>(family.along.size()));
}

TEST_CASE("derivatives of narrow looked-up leaves, whose mesh lines move, agree with differences",
          "[slow]") {
  AtlasSettings s = box();
  s.width = {0.045, 0.12};
  test::Family family = hinge();
  family.numbers[2].value = 0.0052;
  family.numbers[3].value = 0.0064;
  family.along = {0, 2, 3};
  test::check_gradients(family, with_atlas("narrow", s), sweep(), 0.02, 0.95);
}

TEST_CASE("derivatives of looked-up leaves are those of full ones within the error of the leaves",
          "[slow]") {
  const test::Family family = hinge();
  const test::Values p = test::values_of(family.numbers);
  const std::vector<MechanismDirection> directions = test::directions_of(family);
  const StrokeSensitivity a = evaluate_stroke_gradients(family.make(p), directions, looked_up(),
                                                        sweep()),
                          b = evaluate_stroke_gradients(family.make(p), directions,
                                                        test::full(looked_up()), sweep());
  REQUIRE(a.gradients);
  REQUIRE(b.gradients);
  int compared = 0;
  for (std::size_t k = 0; k < sweep().points.size(); ++k)
    for (const std::string name :
         {"parasitic_frequency", "frequencies.drive_locked.2", "frequencies.drive_free.0",
          "transmissibility", "max_stress", "drive_load"}) {
      const auto of_a = gradient_of(a.response.path[k], a.gradients->path[k], name),
                 of_b = gradient_of(b.response.path[k], b.gradients->path[k], name);
      const double value = value_of(b.response.path[k], name).value_or(0);
      if (!of_a || !of_b || (k == 0 && (name == "max_stress" || name == "drive_load"))) continue;
      const double error = name == "max_stress" ? 1e-2 : 3e-3;  // of this coarse atlas
      for (std::size_t j = 0; j < family.along.size(); ++j) {
        const double by = p[family.along[j]] / value;
        INFO(name << " along " << family.numbers[family.along[j]].name << " at point " << k);
        CHECK(by * (*of_a)[static_cast<Eigen::Index>(j)] ==
              Approx(by * (*of_b)[static_cast<Eigen::Index>(j)]).margin(error));
        ++compared;
      }
    }
  CHECK(compared >= 15 * static_cast<int>(family.along.size()));
}

TEST_CASE("so are those of the stress where a design turns the rays of its leaves", "[slow]") {
  const test::Family family = hinge();
  const Mechanism m = family.make(test::values_of(family.numbers));
  const std::vector<MechanismDirection> directions{test::direction(family, 11)};  // the crossing
  StrokeRequest request{.points = {}};
  for (int k = 1; k <= 8; ++k) request.points.push_back(0.04 * k);
  request.outputs = {Output::equilibrium, Output::stress};
  const StrokeSensitivity a = evaluate_stroke_gradients(m, directions, looked_up(), request),
                          b = evaluate_stroke_gradients(m, directions, test::full(looked_up()),
                                                        request);
  REQUIRE(a.gradients);
  REQUIRE(b.gradients);
  for (std::size_t k = 0; k < request.points.size(); ++k) {
    const double value = b.response.path[k].max_stress->value;
    const auto of_a = gradient_of(a.response.path[k], a.gradients->path[k], "max_stress"),
               of_b = gradient_of(b.response.path[k], b.gradients->path[k], "max_stress");
    REQUIRE((of_a && of_b));
    INFO("at point " << k);
    CHECK(std::abs((*of_b)[0]) > value);
    CHECK(0.5 * (*of_a)[0] / value == Approx(0.5 * (*of_b)[0] / value).margin(1.5e-3));
  }
}

TEST_CASE("where the tables of a leaf do not hold, full leaves take over and say why", "[slow]") {
  StrokeRequest request = sweep();
  request.values = PathValues::differentiable;
  const Mechanism m = hinge().make(test::values_of(hinge().numbers));
  request.frequencies = 40;  // beyond the modes that the tables have
  const StrokeResponse many = evaluate_stroke(m, looked_up(), request);
  for (const LeafReport& leaf : many.path[0].leaves) {
    CHECK(leaf.model == "full");
    CHECK_THAT(leaf.reason, Catch::StartsWith("exact: leaf 0: its tables have "));
  }
  const StrokeResponse truth = evaluate_stroke(m, test::full(looked_up()), request);
  CHECK(test::frequency_error(many.path[1].frequencies_locked, truth.path[1].frequencies_locked) <
        1e-7);
}

TEST_CASE("derivatives of looked-up leaves are the same whichever edge is called the base",
          "[slow]") {
  AtlasSettings s = box();
  s.rays = {-1, 0, 1};
  s.points = {4, 3};
  const ModelOptions model = with_atlas("rays", s);
  std::vector<std::vector<test::Compared>> both;
  for (const bool turned : {false, true}) {
    const test::Family family = hinge(0.15, turned);
    const std::vector<MechanismDirection> directions = test::directions_of(family);
    const Mechanism m = family.make(test::values_of(family.numbers));
    const StrokeSensitivity found = evaluate_stroke_gradients(m, directions, model, sweep());
    REQUIRE(found.gradients);
    for (const PathPoint& point : found.response.path)
      for (const LeafReport& leaf : point.leaves) {
        INFO(leaf.reason);
        CHECK(leaf.model == "tube");
      }
    both.push_back(test::compared_numbers(m, found, family.load));
  }
  REQUIRE(both[0].size() == both[1].size());
  for (std::size_t i = 0; i < both[0].size(); ++i) {
    const test::Compared &a = both[0][i], &b = both[1][i];
    if (!a.gradient || a.name == "max_stress at point 0") continue;
    INFO(a.name);
    REQUIRE(b.gradient);
    const VectorXd scale = VectorXd::Map(test::values_of(hinge().numbers).data(), 11);
    const double size = std::max(std::abs(a.value), a.floor) + 1e-6;
    CHECK((*a.gradient - *b.gradient).cwiseProduct(scale).cwiseAbs().maxCoeff() < 1e-6 * size);
  }
}
