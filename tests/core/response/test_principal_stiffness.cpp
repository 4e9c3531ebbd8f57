// The softest translation with the drive held: its law, its place among the supports, its gradient.
#include "core/response/principal_stiffness.hpp"

#include "core/math/ridders.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/response/quantities.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

PathPoint point_of(const Mechanism& mechanism, double stroke) {
  StrokeRequest request{.points = {stroke}, .newton = {.tolerance = 1e-12}};
  const ModelOptions beams{.accuracy = Accuracy::full, .flexure = Flexure::beam, .mesh = {8, 1}};
  const StrokeResponse r = test::evaluated(mechanism, beams, request);
  return r.path[0];
}

}  // namespace

TEST_CASE("a mechanism turned about its drive keeps its principal stiffness, in its axes") {
  struct Case {
    Mechanism mechanism;
    double stroke;
    Vector3d about;
  };
  for (const Case& c : {Case{models::guide(0.1, 0.03, 5e-4), 0.01, Vector3d::UnitY()},
                        Case{models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.03}}),
                             0.3, Vector3d::UnitZ()}}) {
    const PathPoint here = point_of(c.mechanism, c.stroke);
    const auto softest = principal_stiffness(here);
    REQUIRE(softest);
    for (const double angle : {0.3, 1.0, 2.5}) {
      const Matrix3d R = Eigen::AngleAxisd(angle, c.about).toRotationMatrix();
      Mechanism turned = test::moved_as_a_whole(c.mechanism, R);
      turned.drives = c.mechanism.drives;
      const auto other = principal_stiffness(point_of(turned, c.stroke));
      REQUIRE(other);
      CHECK(other->value == Approx(softest->value).epsilon(1e-8));
      CHECK(std::abs(other->direction.dot(R * softest->direction)) ==
            Approx(1).epsilon(0).margin(1e-10));
    }
  }
}

TEST_CASE("no translation is softer than the principal one") {
  for (const double stroke : {0.0, 0.3}) {
    const PathPoint p =
        point_of(models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.03}}), stroke);
    const auto softest = principal_stiffness(p);
    REQUIRE(softest);
    const Matrix3d C = p.compliance_locked.topLeftCorner<3, 3>();
    const Vector3d& v = softest->direction;
    CHECK(v.norm() == Approx(1).epsilon(1e-14));
    CHECK(v.maxCoeff() == v.cwiseAbs().maxCoeff());
    CHECK((C * v * softest->value - v).norm() < 1e-10);
    for (int d = 0; d < 3; ++d) CHECK(softest->value <= *p.support_stiffness[d] * (1 + 1e-12));
    for (int k = 0; k < 50; ++k) {
      const Vector3d u = Vector3d::Random().normalized();
      CHECK(softest->value <= 1 / u.dot(C * u) * (1 + 1e-12));
    }
  }
}

TEST_CASE("directions that are held have no part in the principal stiffness") {
  PathPoint p;
  p.status = PointStatus::converged;
  CHECK_FALSE(principal_stiffness(p));
  CHECK_FALSE(principal_stiffness_gradient(p, {}));
  p.compliance_locked(2, 2) = -0.5;  // unstable, and alone
  p.support_stiffness[2] = -2;
  p.support_stiffness[4] = 1;  // a rotation
  REQUIRE(principal_stiffness(p));
  CHECK(principal_stiffness(p)->value == -2);
  CHECK(principal_stiffness(p)->direction == Vector3d::UnitZ());
  CHECK(value_of(p, "principal_stiffness") == -2.0);
}

TEST_CASE("equally stiff translations have the derivatives of their branches") {
  // C(p) = (1 + p0) 1 + p1 diag(1, −1): the stiffness of the branches is 1/(1 + p0 ± p1)
  PathPoint p;
  p.compliance_locked(0, 0) = p.compliance_locked(1, 1) = 1;
  p.compliance_locked(2, 2) = 0.25;
  for (int d = 0; d < 3; ++d) p.support_stiffness[static_cast<std::size_t>(d)] = 1;
  PointGradients g;
  const Matrix3d turn = Eigen::AngleAxisd(0.4, Vector3d::UnitZ()).toRotationMatrix();
  g.translation_compliance = {Vector3d(1, 1, 7).asDiagonal(),
                              turn * Vector3d(1, -1, 0).asDiagonal() * turn.transpose()};
  const auto gradient = principal_stiffness_gradient(p, g);
  REQUIRE(gradient);
  CHECK((*gradient)[0] == Approx(-1).epsilon(1e-12));
  CHECK(std::abs((*gradient)[1]) == Approx(1).epsilon(1e-12));
}

TEST_CASE("the gradient of the principal stiffness is that of its differences") {
  const ModelOptions beams{.accuracy = Accuracy::full, .flexure = Flexure::beam, .mesh = {8, 1}};
  StrokeRequest request{.points = {0, 0.3},
                        .outputs = {Output::stiffness},
                        .values = PathValues::differentiable,
                        .newton = {.tolerance = 1e-12}};
  const auto hinge = [](double thickness) {
    Mechanism m = models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.03}});
    m.leaves[0].thickness = thickness;
    return m;
  };
  MechanismDirection thicker{"thickness", zero_rate(hinge(3.5e-4))};
  thicker.rate.leaves[0].thickness = 1;
  const StrokeSensitivity s = evaluate_stroke_gradients(hinge(3.5e-4), {thicker}, beams, request);
  REQUIRE(s.gradients);
  const Derivatives d = ridders(
      [&](double t) {
        std::vector<double> values;
        for (const PathPoint& p : evaluate_stroke(hinge(t), beams, request).path)
          values.push_back(value_of(p, "principal_stiffness").value());
        return values;
      },
      3.5e-4, 5e-6, 5);
  for (std::size_t k = 0; k < 2; ++k) {
    const auto g = gradient_of(s.response.path[k], s.gradients->path[k], "principal_stiffness");
    REQUIRE(g);
    CHECK((*g)[0] != 0);
    CHECK((*g)[0] == Approx(d.value[k]).epsilon(1e-7).margin(5 * d.error[k]));
  }
}

TEST_CASE("principal directions are normal to each other and their compliances make up the block") {
  const PathPoint p =
      point_of(models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.03}}), 0.3);
  for (const bool rotations : {false, true}) {
    const auto all = principal_stiffnesses(p, rotations);
    REQUIRE(all.size() == (rotations ? 2u : 3u));  // the drive turns about z
    Matrix3d sum = Matrix3d::Zero();
    for (std::size_t i = 0; i < all.size(); ++i) {
      sum += all[i].direction * all[i].direction.transpose() / all[i].value;
      if (i > 0) CHECK(all[i].value >= all[i - 1].value);
      for (std::size_t j = 0; j < i; ++j)
        CHECK(std::abs(all[i].direction.dot(all[j].direction)) < 1e-10);
    }
    const int first = rotations ? 3 : 0;
    const Matrix3d block = p.compliance_locked.block<3, 3>(first, first);
    // the drive holds the turn about its axis as a body holds it that has tilted a little
    CHECK((sum - block).norm() < (rotations ? 1e-4 : 1e-10) * block.norm());
  }
  CHECK(principal_stiffness(p)->value == principal_stiffnesses(p, false).front().value);
}
