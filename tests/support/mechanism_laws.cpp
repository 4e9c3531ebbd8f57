#include "support/mechanism_laws.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>

#include "core/equilibrium/free_motions.hpp"
#include "core/equilibrium/stroke_path.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/ridders.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/response/mobility/mobility.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/path/stiffness.hpp"
#include "core/response/response.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/expand.hpp"

namespace flexopt::laws {

using nlohmann::json;

void Deviation::add(double difference, double scale, const std::string& name) {
  const double relative = difference == 0 ? 0 : std::abs(difference) / scale;
  if (std::isfinite(relative) && relative <= size) return;
  size = std::isfinite(relative) ? relative : 1e300;
  what = name;
}

namespace {

struct AtRest {
  double stroke;    ///< that neither buckles nor tears: of 1 N or 20 mN m, 1 mm or 0.02 rad
  double rounding;  ///< of answers to forces, relative
};

AtRest at_rest(const Mechanism& mechanism, const ModelOptions& model) {
  System system(mechanism, make_full_leaves(mechanism, model));
  system.assemble();
  const double stiffness = std::abs(end_effector_compliance(system).drive_stiffness[0]);
  const MatrixXd K = system.tangent_stiffness();
  const FreeMotions motions(system, false);
  const MatrixXd free = motions.basis().transpose() * K * motions.basis();
  const VectorXd unit = free.diagonal().cwiseAbs().cwiseSqrt().cwiseInverse();
  const VectorXd values = symmetric_eigenvalues(unit.asDiagonal() * free * unit.asDiagonal());
  const double condition = values.cwiseAbs().maxCoeff() / values.cwiseAbs().minCoeff();
  // places are rounded to their distance from the origin; a leaf is that much stiffer along than
  // across
  double slender = 0;
  for (const LeafSpring& leaf : mechanism.leaves)
    slender = std::max(slender, 12 * leaf.length * (leaf.origin.norm() + leaf.length) /
                                    (leaf.thickness * leaf.thickness));
  return {is_rotation(mechanism.drives[0].direction) ? std::min(0.02, 0.02 / stiffness)
                                                     : std::min(1e-3, 1 / stiffness),
          std::numeric_limits<double>::epsilon() * (condition + slender)};
}

// A small dead load on every body.
LoadCase loads_of(const Mechanism& mechanism) {
  LoadCase loads;
  for (int b = 0; b < static_cast<int>(mechanism.bodies.size()); ++b) {
    const double k = static_cast<double>(mechanism.bodies[static_cast<std::size_t>(b)].name.size());
    DeadLoad load;
    load.force = 0.05 * Vector3d(std::sin(k), std::cos(2 * k), std::sin(3 * k));
    load.moment = 5e-4 * Vector3d(std::cos(k), std::sin(2 * k), std::cos(3 * k));
    load.body = b;
    load.arm = 0.01 * Vector3d(std::sin(5 * k), std::cos(7 * k), std::sin(2 * k));
    const auto& held = mechanism.bodies[static_cast<std::size_t>(b)].held;
    if (held[3] && held[4] && held[5]) {  // a material point: forces act at its place
      load.moment.setZero();
      load.arm.setZero();
    }
    loads.constant.push_back(load);
  }
  return loads;
}

// These loads, or half of those at which the mechanism has a limit point: its tangent becomes
// singular there, and no equilibrium is behind it. A step that fails elsewhere is a fault.
LoadCase bearable_loads(const Mechanism& mechanism, const ModelOptions& model) {
  LoadCase loads = loads_of(mechanism);
  System system(mechanism, make_full_leaves(mechanism, model), loads);
  const auto softest = [&] {  // lengths over the longest leaf
    system.assemble();
    const MatrixXd basis = FreeMotions(system, true).basis();
    return symmetric_eigenvalues(basis.transpose() * system.tangent_stiffness() * basis).minCoeff();
  };
  const double at_rest = softest();
  double reached = 0, failed = 1;
  System::Snapshot state = system.save();
  if (step_load(system, {.constant = 1}, {}).converged) return loads;
  for (int k = 0; k < 10; ++k) {
    const double middle = 0.5 * (reached + failed);
    system.restore(state);
    if (step_load(system, {.constant = middle}, {}).converged) {
      state = system.save();
      reached = middle;
    } else {
      failed = middle;
    }
  }
  system.restore(state);
  if (!(softest() < 0.1 * at_rest)) throw std::runtime_error("no equilibrium under small loads");
  for (DeadLoad& load : loads.constant) {
    load.force *= 0.5 * reached;
    load.moment *= 0.5 * reached;
  }
  return loads;
}

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
  StrokeRequest request;
  request.points = {0, stroke};
  request.loads = loads;
  request.frequencies = 4;
  request.outputs.remove(Output::frequency_derivatives);
  request.newton.tolerance = 1e-12;
  return evaluate_stroke(mechanism, model, request);
}

// How far the answers of `there` are from the moved ones of `here`; its stroke has this sign.
void add_differences(const Mechanism& here, const StrokeResponse& a, const Mechanism& there,
                     const StrokeResponse& b, const Turn& turn, double sign, double stroke,
                     Deviation& worst) {
  double length = 0;
  for (const LeafSpring& leaf : here.leaves) length = std::max(length, leaf.length);
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

Deviation energy(const RandomDesign& design, unsigned long long seed, const ModelOptions& model) {
  const Mechanism mechanism = design.make();
  const LoadCase loads = bearable_loads(mechanism, model);
  const double stroke = at_rest(mechanism, model).stroke;
  System system(mechanism, make_full_leaves(mechanism, model), loads);
  if (const Equilibrium e = step_load(system, {.constant = 1}, {}); !e.converged)
    throw std::runtime_error(e.message);
  if (const Equilibrium e = step_to(system, stroke, {}); !e.converged)
    throw std::runtime_error(e.message);
  const System::Snapshot state = system.save();
  const int n = system.size();
  RandomNumbers random(seed);
  double length = 0;
  for (const LeafSpring& leaf : mechanism.leaves) length = std::max(length, leaf.length);
  VectorXd along(n);
  for (int k = 0; k < n; ++k)
    along[k] = system.is_held(k) ? 0 : random.between(-1, 1) * (k % 6 < 3 ? length : 1);
  // dead moments have no energy: their work along the straight line is left out on both sides; the
  // moment of the load is that of its force on its arm
  system.assemble();
  VectorXd moments = VectorXd::Zero(n);
  for (const BodyLoad& load : system.acting()) {
    moments.segment<3>(6 * load.body + 3) += load.moment;
  }
  for (const int k : system.held()) moments[k] = 0;
  const auto move_to = [&](double s) {
    system.restore(state);
    system.move(s * along);
    system.assemble();
    for (int k = 0; k < 20 && system.correction() > 1e-13; ++k) {  // the leaves' interiors follow
      system.move(VectorXd::Zero(n));
      system.assemble();
    }
    return system.correction() <= 1e-12;
  };
  const auto energy_at = [&](double s) {
    move_to(s);
    return system.energy() + system.load_energy();
  };
  const auto force_along = [&] {
    return (system.internal_force() - system.load() + moments).dot(along);
  };
  // the forces that do no work: of joints and drive conditions, the same at every s
  const VectorXd multipliers = system.multipliers();
  // leaves must not buckle on the way, nor come near it: up to twice as far they stay stable, and
  // the force grows evenly
  const auto unstable = [&] {
    int negative = 0;
    for (int i = 0; i < system.leaves(); ++i)
      negative += system.leaf(i).evaluation().negative_pivots;
    return negative;
  };
  double h = 6e-5;
  move_to(0);
  const double here = force_along();
  const int at_rest_unstable = unstable();
  const auto even = [&](double way) {
    std::array<double, 2> force{};
    for (const int side : {0, 1}) {
      if (!move_to(side == 0 ? way : -way) || unstable() != at_rest_unstable) return false;
      force[static_cast<std::size_t>(side)] = force_along();
    }
    return std::abs(force[0] + force[1] - 2 * here) <= 0.01 * std::abs(force[0] - force[1]);
  };
  while (h > 1e-6 && !even(2 * h)) h *= 0.5;
  const auto potential = [&](double s) {
    const double value = energy_at(s);
    return value + (multipliers.size() > 0 ? multipliers.dot(system.constraints().value()) : 0);
  };
  const auto first = ridders([&](double s) { return std::vector<double>{potential(s)}; }, 0, h, 4);
  system.restore(state);
  system.assemble();
  const VectorXd gradient = system.internal_force() - system.load() + moments;
  const double curvature = along.dot((system.tangent() * along).col(0));
  const double scale =
      along.cwiseAbs().dot(system.internal_force().cwiseAbs()) + 1e-4 * std::abs(curvature);
  Deviation worst;
  // bending energies are differences of large numbers: what is left of the potential without its
  // slope on a way that is much shorter
  const double slope = gradient.dot(along), middle = potential(0);
  double noise = 0;
  for (const double s : {-3e-9, -2e-9, -1e-9, 1e-9, 2e-9, 3e-9})
    noise = std::max(noise, std::abs(potential(s) - middle - s * (slope + 0.5 * s * curvature)));
  worst.rounding = 1e-2 * noise / (h * scale);
  worst.add(std::max(0.0, std::abs(slope - first.value[0]) - 10 * first.error[0]), scale,
            "gradient of the energy");
  const auto second = ridders(
      [&](double s) {
        energy_at(s);
        // along the same straight line of rotation vectors: exp(s hat δ) turns about one axis, and
        // the spin of the way is δ all along
        return std::vector<double>{force_along()};
      },
      0, h, 4);
  worst.add(std::max(0.0, std::abs(curvature - second.value[0]) - 10 * second.error[0]),
            std::abs(curvature), "Hessian of the energy");
  return worst;
}

namespace {

std::vector<double> numbers_of(const Mechanism& mechanism) {
  std::vector<double> numbers;
  each_number(mechanism, [&](double x) { numbers.push_back(x); });
  return numbers;
}

// What number k of a mechanism is.
std::string label(const Mechanism& mechanism, std::size_t k) {
  std::string last = "a body";
  std::size_t count = 0;
  const auto entered = [&](const std::string& name, std::size_t numbers) {
    if (k >= count && k < count + numbers) last = fmt::format("{} ({})", name, k - count);
    count += numbers;
  };
  for (const RigidBody& b : mechanism.bodies) entered(b.name, b.box ? 28 : 16);
  for (const LeafSpring& l : mechanism.leaves)
    entered(l.name, 18 + l.width_profile.size() + l.thickness_profile.size() + (l.point ? 2 : 0) +
                        (l.curve ? 1 : 0) + (l.fold ? 2 : 0));
  for (const Joint& j : mechanism.joints) entered(j.name, 6);
  for (const Spring& s : mechanism.springs) entered(s.name, s.matrix ? 39 : 8);
  entered("drive", 9 * mechanism.drives.size());
  return last;
}

std::string names_of(const Mechanism& mechanism) {
  std::string names;
  for (const RigidBody& body : mechanism.bodies) {
    names += body.name + "|";
    for (const bool held : body.held) names += held ? '1' : '0';
  }
  for (const LeafSpring& leaf : mechanism.leaves)
    names += fmt::format("|{} {} {}", leaf.name, leaf.base, leaf.tip);
  for (const Joint& joint : mechanism.joints)
    names += fmt::format("|{} {} {} {}", joint.name, static_cast<int>(joint.type), joint.body,
                         joint.other);
  for (const Spring& spring : mechanism.springs)
    names += fmt::format("|{} {} {}", spring.name, spring.body, spring.other);
  return names;
}

void compare_bits(const Mechanism& a, const Mechanism& b, const std::string& how,
                  Deviation& worst) {
  if (names_of(a) != names_of(b)) worst.add(1, 1, how + ": names");
  const std::vector<double> x = numbers_of(a), y = numbers_of(b);
  for (std::size_t k = 0; k < x.size() && k < y.size(); ++k)
    if (x[k] != y[k])
      worst.add(1, 1, fmt::format("{}: {}, {:.17g} and {:.17g}", how, label(a, k), x[k], y[k]));
  if (x.size() != y.size()) worst.add(1, 1, how + ": how many numbers");
}

}  // namespace

Deviation ways_of_writing(const RandomDesign& design) {
  Deviation worst;
  const Mechanism here = design.make();
  const Material& material = materials().front().material;
  const auto flat =
      expanded(*design.family, design.values, default_choices(*design.family), material);
  const auto flat_family = read_document(json::parse(flat.dump()), design.folder);
  const Mechanism of_flat = flat_family->make({}, {}, material, random_payload());
  compare_bits(here, of_flat, "flat", worst);
  if (expanded(*flat_family, {}, {}, material).dump() != flat.dump())
    worst.add(1, 1, "expanded again");
  const auto written = read_document(without_repeats(design.document), design.folder);
  compare_bits(here,
               written->make(design.values, default_choices(*written), material, random_payload()),
               "without repeats", worst);
  return worst;
}

namespace {

// What every number of a mechanism is compared with: places with the longest leaf, entries of a
// matrix with its largest.
std::vector<double> scales_of(const Mechanism& mechanism) {
  double length = 0;
  for (const LeafSpring& leaf : mechanism.leaves) length = std::max(length, leaf.length);
  std::vector<double> scales;
  const auto put = [&](std::size_t count, double scale) {
    scales.insert(scales.end(), count, scale);
  };
  for (const RigidBody& body : mechanism.bodies) {
    put(3, length);
    put(1, body.mass);
    put(3, length);
    put(9, body.inertia.cwiseAbs().maxCoeff());
    if (body.box) {
      put(3, length);
      put(9, body.box->half_edges.cwiseAbs().maxCoeff());
    }
  }
  for (const LeafSpring& leaf : mechanism.leaves) {
    put(3, length);
    put(9, 1);
    for (const double own : {leaf.length, leaf.width, leaf.thickness}) put(1, own);
    if (leaf.curve) put(1, 1);
    if (leaf.fold) put(2, 1);
    put(leaf.width_profile.size() + leaf.thickness_profile.size(), 1);
    for (const double own :
         {leaf.material.youngs_modulus, leaf.material.poissons_ratio, leaf.material.density})
      put(1, own);
    if (leaf.point) put(2, 1);
  }
  for (std::size_t k = 0; k < mechanism.joints.size(); ++k) {
    put(3, length);
    put(3, 1);
  }
  for (const Spring& spring : mechanism.springs) {
    put(3, length);
    if (spring.matrix) {
      put(36, spring.matrix->cwiseAbs().maxCoeff());
    } else {
      put(3, length);
      put(1, spring.stiffness);
      put(1, spring.free_length);
    }
  }
  put(9 * mechanism.drives.size(), 1);
  return scales;
}

// Which numbers are a choice that may jump: the direction of a wire's width is any, across the axis
// that the wire is least along.
std::vector<bool> free_choices(const Mechanism& mechanism) {
  std::vector<bool> free;
  for (const RigidBody& body : mechanism.bodies) free.insert(free.end(), body.box ? 28 : 16, false);
  for (const LeafSpring& leaf : mechanism.leaves) {
    const auto first = static_cast<std::ptrdiff_t>(free.size());
    free.insert(free.end(),
                18 + leaf.width_profile.size() + leaf.thickness_profile.size() +
                    (leaf.point ? 2 : 0) + (leaf.curve ? 1 : 0) + (leaf.fold ? 2 : 0),
                false);
    if (leaf.section == Section::circular)
      std::fill(free.begin() + first + 6, free.begin() + first + 12, true);
  }
  std::size_t all = 0;
  each_number(mechanism, [&](double) { ++all; });
  free.resize(all, false);
  return free;
}

}  // namespace

Deviation derivatives(const RandomDesign& design) {
  Deviation worst;
  const Mechanism mechanism = design.make();
  const std::vector<double> scales = scales_of(mechanism);
  const std::vector<bool> free_choice = free_choices(mechanism);
  std::vector<std::string> names;
  for (const Parameter& p : design.family->parameters) names.push_back(p.name);
  const std::vector<MechanismDirection> exact =
      design.family->directions(design.values, default_choices(*design.family),
                                materials().front().material, random_payload(), names);
  for (const MechanismDirection& direction : exact) {
    const double p = design.values.at(direction.parameter);
    const auto at = [&](double x) {
      ParameterValues near = design.values;
      near[direction.parameter] = x;
      return numbers_of(design.make(near));
    };
    // some leaf may cross another at a parameter nearby: then within shorter steps
    std::optional<Derivatives> near;
    for (double step = 2e-3 * p; !near; step /= 4) try {
        near = ridders(at, p, step, 4);
      } catch (const SpecError& error) {
        const bool crosses = std::string(error.what()).find("intersect") != std::string::npos;
        if (!crosses || step < 2e-5 * p) throw;
      }
    const Derivatives& d = *near;
    const std::vector<double> rate = numbers_of(direction.rate);
    for (std::size_t k = 0; k < rate.size(); ++k) {
      if (free_choice[k] && d.error[k] > 1e-3 * scales[k] / p) continue;
      worst.add(rate[k] - d.value[k], std::max(std::abs(rate[k]), scales[k] / p),
                fmt::format("{} along {}: {:.12g} and {:.12g}", label(direction.rate, k),
                            direction.parameter, rate[k], d.value[k]));
    }
  }
  return worst;
}

}  // namespace flexopt::laws
