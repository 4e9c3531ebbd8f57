// Exact derivatives of every quantity at every point against extrapolated differences of the whole
// path, with respect to geometry, material and payload: (S6)–(S10).
#include "support/gradient_checks.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

// Guide or hinge without symmetry, so that every term of the chain counts.
const std::vector<Number> parameters{{"length", 0.1},   {"width", 0.03},  {"thickness", 0.5e-3},
                                     {"modulus", 2e11}, {"poisson", 0.3}, {"density", 7800},
                                     {"mass", 0.4},     {"centre", 0.01}, {"inertia", 3e-4},
                                     {"angle", 0.7},    {"shift", 0.004}};

Mechanism skew(bool hinge, const Values& p) {
  const Material material{"steel", p[3], p[4], p[5], {}};
  Mechanism m{.bodies = {hinge ? models::body({0.001, 0, 0}, p[6], p[8])
                               : models::body({p[0], 0.001, 0.002}, p[6], p[8])},
              .drives = {make_drive(hinge ? Direction::rz : Direction::uy)}};
  m.bodies[0].center_of_mass += Vector3d(p[7], 0.5 * p[7], 0);
  if (hinge) {
    const double z = 0.8 * p[1];
    for (const models::Crossing& c :
         {models::Crossing{1, z, 0.5 * p[1]}, {-1, 0, p[1]}, {1, -z - p[10], 0.5 * p[1]}}) {
      const Vector3d along(std::cos(p[9]), c.side * std::sin(p[9]), 0);
      m.leaves.push_back(models::leaf(Vector3d(0, 0, c.z) - 0.45 * p[0] * along, along, p[0],
                                      c.width, p[2], material));
    }
  } else {
    for (const double y : {0.03, -0.03}) {
      const Vector3d along(std::cos(0.1 * (p[9] - 0.7)), std::sin(0.1 * (p[9] - 0.7)), 0);
      m.leaves.push_back(models::leaf({0, y + p[10] * y, 0}, along, p[0], p[1], p[2], material));
    }
  }
  return m;
}

/// The guide, along its length and its thickness.
const test::Family guide{[](const Values& p) { return skew(false, p); }, parameters, {0, 2}, 0};

struct Case {
  const char* what;
  bool hinge;
  Flexure flexure;
  double stroke;
  std::vector<std::size_t> along;  ///< parameters
  Accuracy accuracy = Accuracy::full;
  int leaf_modes = 2;
};

void check(const Case& c) {
  CAPTURE(c.what);
  ModelOptions model = models::coarse(c.flexure, c.accuracy);
  model.leaf_modes = c.leaf_modes;
  const DeadLoad load{.force = {1, c.hinge ? 0.5 : 0, -2},
                      .moment = {0.01, 0.02, c.hinge ? 0 : -0.01}};
  const Family family{[&](const Values& p) { return skew(c.hinge, p); }, parameters, c.along,
                      c.hinge ? 0.1 : 10.0};
  const int compared = check_gradients(
      family, model, {.points = {0, c.stroke}, .loads = {.constant = {load}}, .frequencies = 4});
  CHECK(compared >= 2 * 22 * static_cast<int>(c.along.size()));
}

}  // namespace

TEST_CASE("exact derivatives of beam guides and hinges agree with differences") {
  check({"guide driven the other way", false, Flexure::beam, -0.015, {0, 1, 2, 4, 5, 9}});
  check({"hinge", true, Flexure::beam, 0.5, {0, 1, 2, 8, 9, 10}});
}

TEST_CASE("exact derivatives of plate guides and hinges agree with differences", "[slow]") {
  const Flexure plate = Flexure::plate;
  check({"guide", false, plate, 0.02, {0, 1, 2, 4, 7, 10}});
  check({"hinge", true, plate, 0.4, {0, 1, 2, 3, 6, 9}});
  check({"reduced leaves lead to the state", true, plate, -0.3, {0, 2, 10}, Accuracy::reduced});
  check({"leaves follow by their static shapes alone",
         false,
         plate,
         0.02,
         {0, 2, 5, 6, 9},
         Accuracy::full,
         0});
}

TEST_CASE("methods kept for comparison have no exact derivatives, and say so") {
  StrokeRequest request{.points = {0, 0.01}};
  for (const Reduction method : {Reduction::linear_craig_bampton, Reduction::modal_derivatives,
                                 Reduction::quadratic_manifold}) {
    ModelOptions model{.mesh = {6, 2}, .method = method};
    const Mechanism m = guide.make(values_of(parameters));
    const StrokeSensitivity s = evaluate_stroke_gradients(m, {direction(guide, 0)}, model, request);
    CHECK_FALSE(s.gradients);
    CHECK_FALSE(s.message.empty());
    request.values = PathValues::differentiable;  // their own numbers, not those of full leaves
    const StrokeResponse own = evaluate_stroke(m, model, request);
    CHECK(s.response.path[1].drive_load == own.path[1].drive_load);
    CHECK(own.path[1].leaves[0].reason.empty());
  }
}

TEST_CASE("where nothing is stressed the stress has no slope") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam}) {
    const StrokeSensitivity s = evaluate_stroke_gradients(
        guide.make(values_of(parameters)), directions_of(guide), {.flexure = flexure}, {});
    REQUIRE(s.gradients);
    REQUIRE(s.response.path[0].max_stress->value < 1);
    CHECK(s.gradients->path[0].max_stress->allFinite());
  }
}

TEST_CASE("a constant mass leaves the derivatives of all but the frequencies") {
  ModelOptions model{.mesh = {6, 2}};
  StrokeRequest request{.points = {0, 0.01}, .frequencies = 4};
  request.outputs.remove(Output::frequency_derivatives);
  const std::vector<MechanismDirection> along = directions_of(guide);
  const Mechanism m = guide.make(values_of(parameters));
  const StrokeSensitivity consistent = evaluate_stroke_gradients(m, along, model, request);
  model.mass = LeafMass::constant;
  const StrokeSensitivity constant = evaluate_stroke_gradients(m, along, model, request);
  REQUIRE(constant.gradients);
  const PointGradients &a = consistent.gradients->path[1], &b = constant.gradients->path[1];
  CHECK(a.drive_stiffness == b.drive_stiffness);
  CHECK(*a.support_stiffness[0] == *b.support_stiffness[0]);
  CHECK(*a.max_stress == *b.max_stress);
  CHECK(a.parasitic_frequency);
  CHECK_FALSE(b.parasitic_frequency);
  CHECK(b.frequencies_locked.rows() == 0);
  const PathPoint& point = constant.response.path[1];
  REQUIRE(point.frequencies_locked.size() == 4);
  CHECK(point.frequencies_locked[3] != consistent.response.path[1].frequencies_locked[3]);
  request.values = PathValues::as_modelled;
  CHECK(point.frequencies_locked[3] ==
        Approx(evaluate_stroke(m, model, request).path[1].frequencies_locked[3]).epsilon(1e-4));
}

TEST_CASE("every place of large stress has its derivative, whichever model the leaf is", "[slow]") {
  const auto [flexure, accuracy] =
      GENERATE(std::pair{Flexure::plate, Accuracy::reduced},
               std::pair{Flexure::plate, Accuracy::full}, std::pair{Flexure::beam, Accuracy::full});
  const ModelOptions model{
      .accuracy = accuracy, .flexure = flexure, .mesh = {8, flexure == Flexure::plate ? 2 : 1}};
  StrokeRequest request{.points = {0.015},
                        .values = PathValues::differentiable,
                        .frequencies = 0,
                        .stress_peaks = 5,
                        .newton = {.tolerance = 1e-11}};
  const StrokeSensitivity here = evaluate_stroke_gradients(guide.make(values_of(parameters)),
                                                           directions_of(guide), model, request);
  REQUIRE(here.gradients);
  const std::vector<StressPeak>& peaks = here.response.path[0].stress_peaks;
  const MatrixXd& slopes = here.gradients->path[0].stress_peaks;
  REQUIRE(peaks.size() >= 3);
  REQUIRE(slopes.rows() == static_cast<Eigen::Index>(peaks.size()));
  CHECK(peaks[0].value == here.response.path[0].max_stress->value);
  StrokeRequest all = request;
  all.stress_peaks = 30;
  const Derivatives d = differences_along(guide, 2, 1e-3, [&](const Mechanism& moved) {
    const StrokeResponse there = evaluate_stroke(moved, model, all);
    Values values;
    for (const StressPeak& peak : peaks)
      for (const StressPeak& q : there.path[0].stress_peaks)
        if (q.leaf == peak.leaf && q.on_positive_normal == peak.on_positive_normal &&
            std::abs(q.along - peak.along) + std::abs(q.across - peak.across) < 1e-9) {
          values.push_back(q.value);
          break;
        }
    REQUIRE(values.size() == peaks.size());
    return values;
  });
  for (std::size_t k = 0; k < peaks.size(); ++k) {
    INFO(peaks[k].leaf << ", " << peaks[k].along << ", " << peaks[k].across);
    CHECK(peaks[k].value <= peaks[0].value * (1 + 1e-9));
    CHECK(slopes(static_cast<Eigen::Index>(k), 1) == Approx(d.value[k]).epsilon(1e-6));
  }
}

TEST_CASE("equal leaves: derivatives of double frequencies are those of their cluster") {
  // a light end-effector between four equal leaves: leaf modes come in groups
  Mechanism m = models::guide(0.1, 0.03, 0.5e-3, 0.06, 2.0, 1e-2);
  ModelOptions model{.accuracy = Accuracy::full, .mesh = {6, 2}};
  StrokeRequest request{.frequencies = 10};
  request.outputs.remove(Output::frequency_derivatives);
  request.outputs.remove(Output::stress);
  MechanismDirection thicker{"thickness", zero_rate(m)};
  for (LeafSpring& l : thicker.rate.leaves) l.thickness = 1;
  const StrokeSensitivity s = evaluate_stroke_gradients(m, {thicker}, model, request);
  REQUIRE(s.gradients);
  const PointGradients& g = s.gradients->path[0];
  // bending of the leaves in one plane has an even and an odd combination, all but equal
  CHECK(g.frequencies_locked.rows() == 10);
  const Derivatives d = ridders(
      [&](double t) {
        Mechanism moved = m;
        for (LeafSpring& l : moved.leaves) l.thickness = t;
        StrokeRequest exact = request;
        exact.values = PathValues::differentiable;
        return evaluate_stroke(moved, model, exact).path[0].frequencies_locked;
      },
      0.5e-3, 1e-5, 4);
  for (int k = 0; k < 10; ++k)
    CHECK(g.frequencies_locked(k, 0) == Approx(d.value[k]).epsilon(1e-6).margin(5 * d.error[k]));
}
