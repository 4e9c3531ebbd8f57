#include "support/fixture.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/math/rotation.hpp"
#include "core/response/gain.hpp"
#include "support/models.hpp"

namespace flexopt::test {

namespace {

constexpr double length = 0.08, width = 0.03, thickness = 0.35e-3, gap = 1e-3;
constexpr double youngs_modulus = 210e9, degree = std::numbers::pi / 180;

Material steel() { return {"steel", youngs_modulus, 0.3, 7800, 600e6}; }

LeafSpring leaf(const std::string& name, double side) {
  LeafSpring made;
  const double a = side * 45 * degree;
  made.name = name;
  made.axes.col(0) << std::cos(a), std::sin(a), 0;
  made.axes.col(1) << 0, 0, 1;
  made.axes.col(2) = made.axes.col(0).cross(made.axes.col(1));
  made.origin = -0.5 * length * made.axes.col(0) + Vector3d(0, 0, side * (width + gap) / 2);
  made.length = length;
  made.width = width;
  made.thickness = thickness;
  made.material = steel();
  return made;
}

Mechanism hinge() {
  Mechanism mechanism;
  RigidBody body;
  body.name = "shuttle";
  body.mass = 1;
  body.reference.setZero();
  body.center_of_mass.setZero();
  body.inertia = 1e-3 * Matrix3d::Identity();
  mechanism.bodies = {body};
  mechanism.leaves = {leaf("leaf 1", 1), leaf("leaf 2", -1)};
  mechanism.drives = {make_drive(Direction::rz)};
  return mechanism;
}

/// Cubic between the clamped base and the tip that turned about the origin.
LeafShape turned(const LeafSpring& leaf, double angle, double stress) {
  LeafShape shape;
  shape.points_along = 9;
  shape.points_across = 4;
  const Matrix3d R = rotation_exp({0, 0, angle});
  const Vector3d tip = R * leaf.tip_middle(), t0 = leaf.axes.col(0), t1 = R * t0;
  for (int j = 0; j < shape.points_across; ++j)
    for (int i = 0; i < shape.points_along; ++i) {
      const double s = i / 8.0, v = (j / 3.0 - 0.5) * leaf.width;
      const Vector3d across = v * leaf.axes.col(1);
      shape.undeflected.push_back(leaf.origin + s * leaf.length * t0 + across);
      shape.deflected.push_back(
          (1 + 2 * s) * (1 - s) * (1 - s) * leaf.origin + s * s * (3 - 2 * s) * tip +
          s * (1 - s) * (1 - s) * leaf.length * t0 + s * s * (s - 1) * leaf.length * t1 + across);
      shape.von_mises.push_back(stress * (0.55 + 0.45 * std::abs(2 * s - 1)));
    }
  return shape;
}

PathPoint point_at(double stroke, const Mechanism& mechanism) {
  // Crossed pivot: K = E ΣI / L at crossing ½, σ = E t θ / L, shift L θ² |9λ²−9λ+1| / (15 cos α).
  const double inertia = 2 * width * std::pow(thickness, 3) / 12;
  const double drive = youngs_modulus * inertia / length, q = stroke * stroke;
  PathPoint p;
  p.stroke = stroke;
  p.status = PointStatus::converged;
  p.newton_iterations = 4;
  p.drive_load = drive * stroke;
  p.displacement << -length * q * 1.25 / (15 * std::cos(45 * degree)), 2e-5 * stroke, 0;
  p.rotation << 0, 0, stroke;
  p.bodies = {{p.displacement, p.rotation}};
  const double at_rest[6]{2.7e7, 2.7e7, 3.1e6, 2.2e3, 2.4e3, 0};
  const double loss[6]{110, 160, 30, 12, 45, 0};
  for (int d = 0; d < 5; ++d) {
    const double compliance = (1 + loss[d] * q) / at_rest[d];
    p.compliance_locked(d, d) = p.compliance_free(d, d) = compliance;
    p.support_stiffness[static_cast<std::size_t>(d)] = 1 / compliance;
  }
  p.compliance_free(0, 5) = p.compliance_free(5, 0) = 1e-4 * stroke;
  p.compliance_free(5, 5) = 1 / drive;
  p.drive_stiffness = drive;
  set_gain(mechanism, p.compliance_free.col(5) * drive, p);
  const double f1 = 214 / std::sqrt(1 + 8 * q), leaf_mode = 290 - 60 * q;
  const double driven = std::sqrt(drive / 1e-3) / (2 * std::numbers::pi);
  p.modes_locked = {{f1, 0, ModeKind::end_effector, 0, 0.98, 0, 0.02},
                    {leaf_mode, 0, ModeKind::leaf, 0, 0.01, 0, 0.99},
                    {leaf_mode + 12, 0, ModeKind::leaf, 0, 0.01, 0, 0.99}};
  p.modes_free = p.modes_locked;
  p.modes_free.insert(p.modes_free.begin(), {driven, 0, ModeKind::drive, 0.99, 0, 0, 0.01});
  for (const Mode& mode : p.modes_free) p.frequencies_free.push_back(mode.frequency);
  for (const Mode& mode : p.modes_locked) p.frequencies_locked.push_back(mode.frequency);
  p.parasitic_frequency = f1;
  const double stress = youngs_modulus * thickness * std::abs(stroke) / length;
  p.clearance = Clearance{1e-3};
  p.max_stress = StressPeak{stress, 1, 0, 0.5, mechanism.leaves[1].origin, true};
  p.leaves = {{"tube", "", 2e-6}, {"full", "off-ray bending 0.021 > 0.02", 0}};
  for (const LeafSpring& leaf : mechanism.leaves) p.shapes.push_back(turned(leaf, stroke, stress));
  return p;
}

Job hinge_job() {
  Job job;
  job.name = "hinge </script> & <b>bold</b>";  // text of a user must not become markup
  job.design.family = "cross_hinge";
  job.design.parameters = {{"length", length},         {"width", width},
                           {"thickness", thickness},   {"half_angle", 45 * degree},
                           {"crossing_fraction", 0.5}, {"gap", gap}};
  job.design.material = steel();
  job.end_effector = {1, 1e-3 * Matrix3d::Identity(), Vector3d::Zero()};
  job.request.points = {-20 * degree, -10 * degree, 0, 10 * degree, 20 * degree};
  const nlohmann::json document = {
      {"flexopt", 1},
      {"name", job.name},
      {"job", "evaluate"},
      {"design",
       {{"family", "cross_hinge"}, {"parameters", job.design.parameters}, {"material", "steel"}}},
      {"end_effector", {{"mass", 1.0}, {"inertia", {1e-3, 1e-3, 1e-3}}}},
      {"model", {{"flexure", "plate"}, {"accuracy", "reduced"}, {"mesh", {8, 4}}}}};
  job.as_read = std::make_shared<const nlohmann::json>(document);
  return job;
}

EvaluationRecord trial(int start, int number, double thickness, double half_angle) {
  EvaluationRecord record;
  record.start = start;
  record.number = number;
  record.variables = {{"thickness", thickness}, {"half_angle", half_angle}};
  record.ok = number != 3;
  if (!record.ok) {
    record.message = "no equilibrium at 0.2, |r| = 3.1e-2 N \"stuck\"";
    return record;
  }
  record.objective = 4e5 * thickness + 20 * half_angle;
  record.constraints = {youngs_modulus * thickness * 20 * degree / length, 1e3 * thickness};
  record.violation = std::max(0.0, record.constraints[0] / 450e6 - 1);
  return record;
}

}  // namespace

RunRecord evaluated_hinge() {
  RunRecord record;
  record.job = hinge_job();
  record.mechanism = hinge();
  for (const double stroke : record.job.request.points)
    record.response.path.push_back(point_at(stroke, record.mechanism));
  record.timings = {{"total", 0.125}};
  conclude(record);
  return record;
}

RunRecord optimised_hinge() {
  RunRecord record = evaluated_hinge();
  Job& job = record.job;
  job.kind = JobKind::optimise;
  nlohmann::json document = *job.as_read;
  document["job"] = "optimise";
  job.as_read = std::make_shared<const nlohmann::json>(std::move(document));
  OptimiseSpec spec;
  spec.variables = {{"thickness", 1e-4, 1e-3, {}}, {"half_angle", 30 * degree, 60 * degree, {}}};
  spec.objective.quantity = "parasitic_frequency";
  spec.constraints = {{"max_stress", "", OverStroke::max, {}, 450e6, "max_stress max over stroke"},
                      {"drive_load", "", OverStroke::max_abs, -1.0, 1.0, "drive_load, max abs"}};
  job.optimise = spec;

  Optimum optimum;
  optimum.status = OptimumStatus::optimal;
  optimum.stop_reason = "relative step 3e-6 < 1e-5";
  optimum.gradients = "central differences";
  optimum.parameters = job.design.parameters;
  optimum.objective = 169.2;
  optimum.constraints = {{"max_stress max over stroke", 449.99e6, {}, 450e6, 1e4, true, 3.1e-7},
                         {"drive_load, max abs", 0.41, -1.0, 1.0, 0.59, false, {}}};
  optimum.evaluations = 32;
  optimum.failed_evaluations = 2;
  for (int start = 0; start < 2; ++start) {
    StartSummary summary;
    summary.index = start;
    summary.from = {{"thickness", 2e-4}, {"half_angle", 0.7}};
    summary.to = {{"thickness", 3.5e-4}, {"half_angle", 0.785}};
    summary.objective = 169.2 - 0.3 * start;
    summary.feasible = true;
    summary.status = "converged";
    summary.stop_reason = "step below tolerance";
    summary.evaluations = 16;
    optimum.starts.push_back(summary);
    for (int n = 1; n <= 16; ++n)
      optimum.history.push_back(
          trial(start, n, 4.9e-4 - 1e-5 * start + 2e-4 * std::cos(1.1 * n) / n, 0.8));
  }
  optimum.response = record.response;
  record.response = {};
  Verification verified;
  verified.response = optimum.response;
  for (PathPoint& p : verified.response.path) {
    p.drive_load *= 1.0002;
    for (auto& k : p.support_stiffness)
      if (k) *k *= 0.996;
    *p.parasitic_frequency *= 0.9985;
  }
  verified.objective = 168.9;
  verified.constraints = {450.4e6, 0.4101};
  verified.objective_difference = 169.2 / 168.9 - 1;
  verified.constraint_differences = {-9e-4, -2e-4};
  optimum.verified = verified;
  optimum.sensitivities = {{"parasitic_frequency", "thickness", 3.9e5},
                           {"max_stress max over stroke", "thickness", 9.2e11}};
  record.optimum = optimum;
  conclude(record);
  return record;
}

}  // namespace flexopt::test
