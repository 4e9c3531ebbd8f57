#pragma once
// What tests of whole mechanisms ask for: mechanisms, their leaves, models and requests, equilibria
// and responses that they go on with.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/rotation.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/response.hpp"
#include "support/models.hpp"
#include "support/one_stroke.hpp"

namespace flexopt::test {

/// The response, which has to be there.
inline StrokeResponse evaluated(const Mechanism& mechanism, const ModelOptions& model,
                                const StrokeRequest& request) {
  StrokeResponse response = evaluate_stroke(mechanism, model, request);
  INFO(response.message);
  REQUIRE(response.status == Status::ok);
  return response;
}

inline ModelOptions full(ModelOptions model = {}) {
  model.accuracy = Accuracy::full;
  return model;
}

/// All numbers but the stress.
inline Outputs without_stress() { return Outputs::numbers().remove(Output::stress); }

/// The largest relative difference of the support stiffness at a point.
inline double support_error(const PathPoint& found, const PathPoint& truth) {
  double worst = 0;
  for (std::size_t d = 0; d < 6; ++d)
    if (truth.support_stiffness[d])
      worst =
          std::max(worst, std::abs(*found.support_stiffness[d] / *truth.support_stiffness[d] - 1));
  return worst;
}

/// The largest relative difference of natural frequencies.
inline double frequency_error(const std::vector<double>& found, const std::vector<double>& truth) {
  REQUIRE(found.size() == truth.size());
  double worst = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    worst = std::max(worst, std::abs(found[i] / truth[i] - 1));
  return worst;
}

/// The same of all points of a path, their drive free and locked.
inline double frequency_error(const StrokeResponse& found, const StrokeResponse& truth) {
  double worst = 0;
  for (std::size_t k = 0; k < truth.path.size(); ++k)
    for (const auto list : {&PathPoint::frequencies_free, &PathPoint::frequencies_locked})
      worst = std::max(worst, frequency_error(found.path[k].*list, truth.path[k].*list));
  return worst;
}

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
  for (ElasticBody& body : m.elastic_bodies) {
    body.place = R * body.place + shift;
    body.axes = R * body.axes;
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
