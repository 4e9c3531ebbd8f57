// Mechanisms moved, turned and mirrored as a whole.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "core/mechanism/mobility.hpp"
#include "core/response/path/error_estimate.hpp"
#include "core/response/response.hpp"
#include "support/bearable_loads.hpp"
#include "support/mechanism_laws.hpp"

namespace flexopt::laws {

using nlohmann::json;

namespace {

// Turned, and mirrored where det Q = −1: then axial vectors keep their sign along the mirror.
struct Turn {
  Matrix3d Q;
  Vector3d polar(const Vector3d& v) const { return Q * v; }
  Vector3d axial(const Vector3d& v) const { return Q.determinant() * (Q * v); }
  Matrix6d both() const {
    Matrix6d T = Matrix6d::Zero();
    T.topLeftCorner<3, 3>() = Q;
    T.bottomRightCorner<3, 3>() = Q.determinant() * Q;
    return T;
  }
};

std::string inner_name(const std::string& name) {
  return name.starts_with("all/") ? name.substr(4) : name;
}

LoadCase turned(const LoadCase& loads, const Mechanism& from, const Mechanism& to,
                const Turn& turn) {
  std::map<std::string, int> index;
  for (std::size_t b = 0; b < to.bodies.size(); ++b)
    index[inner_name(to.bodies[b].name)] = static_cast<int>(b);
  LoadCase result = loads;
  for (DeadLoad& load : result.constant) {
    load.force = turn.polar(load.force);
    load.moment = turn.axial(load.moment);
    load.arm = turn.polar(load.arm);
    load.body = index.at(from.bodies[static_cast<std::size_t>(*load.body)].name);
  }
  return result;
}

StrokeResponse respond(const Mechanism& mechanism, const ModelOptions& model, const LoadCase& loads,
                       double stroke) {
  StrokeRequest request{.points = {0, stroke}, .loads = loads, .frequencies = 4};
  request.outputs.remove(Output::frequency_derivatives);
  request.newton.tolerance = 1e-12;
  return evaluate_stroke(mechanism, model, request);
}

// How far the answers of `there` are from the moved ones of `here`; its stroke has this sign.
void add_differences(const Mechanism& here, const StrokeResponse& a, const Mechanism& there,
                     const StrokeResponse& b, const Turn& turn, double sign, double stroke,
                     Deviation& worst) {
  const double length = longest_leaf(here);
  const Matrix6d T = turn.both();
  for (std::size_t k = 0; k < a.path.size(); ++k) {
    const PathPoint &p = a.path[k], &q = b.path[k];
    const auto at = [&](const std::string& name) { return fmt::format("{} at point {}", name, k); };
    const double load = std::abs(p.drive_stiffness) * stroke;
    worst.add(p.drive_load - sign * q.drive_load, std::max(std::abs(p.drive_load), load),
              at("drive load"));
    worst.add(p.drive_stiffness - q.drive_stiffness, std::abs(p.drive_stiffness),
              at("drive stiffness"));
    worst.add((turn.polar(p.displacement) - q.displacement).norm(),
              std::max(1e-3 * length, p.displacement.norm()), at("displacement"));
    worst.add((turn.axial(p.rotation) - q.rotation).norm(), std::max(1e-3, p.rotation.norm()),
              at("rotation"));
    worst.add(p.negative_pivots - q.negative_pivots, 1, at("negative pivots"));
    for (const auto& [C, D, name] : {std::tuple{p.compliance_free, q.compliance_free, "free"},
                                     {p.compliance_locked, q.compliance_locked, "locked"}}) {
      const Matrix6d expected = T * C * T.transpose();
      const Vector6d size = expected.diagonal().cwiseAbs().cwiseSqrt();
      const double largest =
          size.cwiseProduct(Vector6d(1, 1, 1, length, length, length)).maxCoeff();
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j)
          worst.add(expected(i, j) - D(i, j),
                    largest * largest / (i < 3 ? 1 : length) / (j < 3 ? 1 : length),
                    at(fmt::format("compliance {} ({}, {})", name, i, j)));
    }
    for (const auto& [f, g, name] : {std::tuple{p.frequencies_free, q.frequencies_free, "free"},
                                     {p.frequencies_locked, q.frequencies_locked, "locked"}}) {
      worst.add(static_cast<double>(f.size()) - static_cast<double>(g.size()), 1,
                at("number of frequencies"));
      for (std::size_t i = 0; i < std::min(f.size(), g.size()); ++i)
        worst.add(f[i] - g[i], std::abs(f[i]), at(fmt::format("frequency {} {}", name, i)));
    }
    if (p.max_stress)
      worst.add(p.max_stress->value - q.max_stress->value, p.max_stress->value, at("stress"));
    std::map<std::string, const BodyMotion*> motions;
    for (std::size_t c = 0; c < there.bodies.size(); ++c)
      motions[inner_name(there.bodies[c].name)] = &q.bodies[c];
    for (std::size_t c = 0; c < here.bodies.size(); ++c) {
      const BodyMotion& other = *motions.at(here.bodies[c].name);
      worst.add((turn.polar(p.bodies[c].displacement) - other.displacement).norm(),
                std::max(1e-3 * length, p.displacement.norm()), at(here.bodies[c].name));
      worst.add((turn.axial(p.bodies[c].rotation) - other.rotation).norm(),
                std::max(1e-3, p.bodies[c].rotation.norm()), at(here.bodies[c].name));
    }
  }
}

// The mechanism with every number rounded otherwise: by some units of its last place, of a place
// by those of the largest.
Mechanism rounded_otherwise(const Mechanism& mechanism, RandomNumbers& random) {
  constexpr double unit = 2 * std::numeric_limits<double>::epsilon();
  double length = 0;
  for (const LeafSpring& leaf : mechanism.leaves)
    length = std::max(length, leaf.origin.norm() + leaf.length);
  Mechanism other = mechanism;
  for (LeafSpring& leaf : other.leaves) {
    for (double& x : leaf.origin) x += unit * length * random.between(-1, 1);
    for (double& x : leaf.axes.reshaped()) x += unit * random.between(-1, 1);
    leaf.length *= 1 + unit * random.between(-1, 1);
  }
  for (RigidBody& body : other.bodies)
    for (double& x : body.reference) x += unit * length * random.between(-1, 1);
  return other;
}

}  // namespace

Deviation motion_of_the_whole(const RandomDesign& design, unsigned long long seed,
                              const std::string& mirror, const ModelOptions& model) {
  RandomNumbers random(seed);
  json frame{
      {"at", {random.between(-0.1, 0.1), random.between(-0.1, 0.1), random.between(-0.1, 0.1)}},
      {"turn", json::array()}};
  Matrix3d R = Matrix3d::Identity();
  for (int k = 0; k < 3; ++k) {
    const int axis = random.whole(0, 2);
    const double angle = random.between(-3, 3);
    frame["turn"].push_back({std::string(1, "xyz"[axis]), angle});
    R = R * Eigen::AngleAxisd(angle, Vector3d(Vector3d::Unit(axis))).toRotationMatrix();
  }
  Turn turn{R};
  if (!mirror.empty()) {
    Matrix3d reflection = Matrix3d::Identity();
    reflection(mirror[0] - 'x', mirror[0] - 'x') = -1;
    turn.Q = R * reflection;
  }
  const Mechanism here = design.make();
  const auto family = read_document(wrapped(design, frame, mirror), design.folder);
  EndEffector payload = random_payload();
  payload.inertia = (turn.Q * payload.inertia * turn.Q.transpose()).eval();
  payload.center_of_mass = turn.polar(payload.center_of_mass);
  const Mechanism there = family->make(default_values(*family), default_choices(*family),
                                       materials().front().material, payload);

  const auto [stroke, rounding] = at_rest(here, model);
  // the drive keeps its direction in the frame; the motion along it may be the mirrored one
  double sign = 1;
  if (!mirror.empty()) {
    const bool along = design.direction[1] == mirror[0];
    sign = is_rotation(here.drives[0].direction) == along ? 1 : -1;
  }
  const LoadCase loads = bearable_loads(here, model);
  const StrokeResponse a = respond(here, model, loads, stroke),
                       b = respond(there, model, turned(loads, here, there, turn), sign * stroke);
  Deviation worst;
  worst.rounding = rounding;
  if (a.status != b.status) {
    worst.add(1, 1,
              fmt::format("status: \"{}\" ({}) and \"{}\" ({})", a.message, a.path[0].message,
                          b.message, b.path[0].message));
    return worst;
  }
  if (a.status != Status::ok) throw std::runtime_error(a.message);

  const Mobility m = mobility(here), n = mobility(there);
  worst.add(m.degrees_of_freedom - n.degrees_of_freedom, 1, "degrees of freedom");
  worst.add(m.overconstraints - n.overconstraints, 1, "overconstraints");
  add_differences(here, a, there, b, turn, sign, stroke, worst);
  if (worst.size <= 1e3 * worst.rounding) return worst;
  // a bound on the condition may be too low: what rounding its numbers otherwise does to it
  for (int k = 0; k < 6; ++k) {
    const Mechanism near = rounded_otherwise(here, random);
    const StrokeResponse c = respond(near, model, loads, stroke);
    if (c.status != Status::ok) continue;
    Deviation rounded;
    add_differences(here, a, near, c, {Matrix3d::Identity()}, 1, stroke, rounded);
    worst.rounding = std::max(worst.rounding, 0.01 * rounded.size);
  }
  return worst;
}

}  // namespace flexopt::laws
