#pragma once
// Strokes that are found to their end, and the models that tests ask for.
#include <array>
#include <catch2/catch.hpp>

#include "support/evaluated.hpp"

namespace flexopt::test {

/// The mechanism turned by R about the origin, then shifted.
inline Mechanism moved_as_a_whole(Mechanism m, const Matrix3d& R,
                                  const Vector3d& shift = Vector3d::Zero()) {
  for (RigidBody& body : m.bodies) {
    body.reference = R * body.reference + shift;
    body.center_of_mass = R * body.center_of_mass + shift;
    body.inertia = R * body.inertia * R.transpose();
  }
  for (LeafSpring& leaf : m.leaves) {
    leaf.origin = R * leaf.origin + shift;
    leaf.axes = R * leaf.axes;
  }
  for (Drive& drive : m.drives) drive.axes = R * drive.axes;
  return m;
}

inline double difference(const MatrixXd& a, const MatrixXd& b) { return (a - b).norm() / b.norm(); }

/// How near answers are: their loads, compliances and frequencies, relative.
struct Nearness {
  double load, compliance, frequency;
};

/// A point of a mechanism against that of another one, turned by R.
inline void check_same(const PathPoint& found, const PathPoint& expected, const Nearness& within,
                       const Matrix3d& R = Matrix3d::Identity()) {
  INFO("stroke " << expected.stroke);
  Matrix6d T = Matrix6d::Zero();
  T.topLeftCorner<3, 3>() = T.bottomRightCorner<3, 3>() = R;
  CHECK(found.drive_load == Approx(expected.drive_load).epsilon(within.load).margin(1e-9));
  CHECK((found.displacement - R * expected.displacement).norm() < 1e-10);
  CHECK((found.rotation - R * expected.rotation).norm() < 1e-9);
  CHECK(difference(found.compliance_free, T * expected.compliance_free * T.transpose()) <
        within.compliance);
  CHECK(difference(found.compliance_locked, T * expected.compliance_locked * T.transpose()) <
        within.compliance);
  CHECK(found.negative_pivots == expected.negative_pivots);
  REQUIRE(found.frequencies_free.size() == expected.frequencies_free.size());
  for (std::size_t i = 0; i < found.frequencies_free.size(); ++i) {
    const auto near = [&](double hertz) { return Approx(hertz).epsilon(within.frequency); };
    CHECK(found.frequencies_free[i] == near(expected.frequencies_free[i]));
    CHECK(found.frequencies_locked[i] == near(expected.frequencies_locked[i]));
    CHECK(found.modes_free[i].kind == expected.modes_free[i].kind);
  }
}

}  // namespace flexopt::test

namespace flexopt::models {

/// Full leaves, of plates or beams.
inline ModelOptions full(Flexure flexure = Flexure::plate, std::array<int, 2> mesh = default_mesh) {
  return {.accuracy = Accuracy::full, .flexure = flexure, .mesh = mesh};
}

inline ModelOptions beams(int elements) { return full(Flexure::beam, {elements, 1}); }

/// Few elements: what is compared is one mesh with itself.
inline ModelOptions coarse(Flexure flexure, Accuracy accuracy = Accuracy::full) {
  return {.accuracy = accuracy,
          .flexure = flexure,
          .mesh = flexure == Flexure::plate ? std::array{6, 2} : std::array{8, 1}};
}

}  // namespace flexopt::models
