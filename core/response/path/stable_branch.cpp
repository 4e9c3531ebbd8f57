
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/equilibrium/free_motions.hpp"
#include "core/math/decompositions.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/path/branch.hpp"

namespace flexopt {
namespace {

// Amplitudes of the mode that the extra loads would have at rest, lengths over the longest leaf:
// those that lead around the bifurcation, the larger the wider, one after the other; what is left
// of them from solution to solution; and where there are none any more.
constexpr double first_amplitudes[] = {0.02, 0.04, 0.1, 0.2, 0.4};
constexpr int more_halvings = 6;  // where the bodies move much by little load
constexpr double left = 0.3, least_amplitude = 1e-5;

// (displacement, spin) of the bodies along the lowest eigenvalue of the tangent, its largest entry
// positive, of norm 1 where lengths count over the longest leaf. Nothing where it is not negative.
std::optional<Push> push_of_bodies(const System& system, DriveHold held) {
  const FreeMotions motions(system, held);
  const MatrixXd& Z = motions.basis();
  if (Z.cols() == 0) return std::nullopt;
  const MatrixXd K = Z.transpose() * (system.tangent() * Z);
  const SymmetricEigen eigen(0.5 * (K + K.transpose()));
  if (!(eigen.eigenvalues()[0] < 0)) return std::nullopt;
  const VectorXd motion = Z * eigen.eigenvectors().col(0),
                 counted = motion.cwiseQuotient(system.units());
  Eigen::Index largest = 0;
  counted.cwiseAbs().maxCoeff(&largest);
  return Push{motion / (counted[largest] > 0 ? counted.norm() : -counted.norm())};
}

// Along the normals of the leaves that buckle between their edges, if they have mass: a uniform
// load q bends a clamped strip by q L⁴/(384 E I). Normals of opposite leaves count as one.
std::optional<Push> push_of_leaves(const System& system) {
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (int i = 0; i < system.leaves(); ++i) {
    const LeafSpring& leaf = system.mechanism().leaves[i];
    if (system.leaf(i).evaluation().negative_pivots == 0 || leaf.material.density == 0) continue;
    const double L = leaf.length, t = leaf.thickness;
    const Vector3d own = 32 * leaf.material.youngs_modulus * t * t /
                         (leaf.material.density * L * L * L) * leaf.edge_axes(0).col(2);
    sum += sum.dot(own) < 0 ? Vector3d(-own) : own;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return Push{VectorXd::Zero(system.size()), sum / count};
}

// Dead loads along the motion, of so much work on it [J], and weight of leaves alone.
void add_push(const Push& push, double amplitude, double stiffness, const System& system,
              LoadCase& loads) {
  const double length = system.length();
  const Mechanism& mechanism = system.mechanism();
  const Vector3d acceleration = amplitude * push.acceleration;
  const double work = amplitude * stiffness;
  loads.gravity += acceleration;
  for (int b = 0; 6 * b < push.motion.size(); ++b) {
    const RigidBody& body = mechanism.bodies[b];
    loads.constant.push_back({.force = work / (length * length) * push.motion.segment<3>(6 * b),
                              .moment = work * push.motion.segment<3>(6 * b + 3),
                              .body = b});
    if (!acceleration.isZero(0))
      loads.constant.push_back({.force = -body.mass * acceleration,
                                .body = b,
                                .arm = body.center_of_mass - body.reference,
                                .step = loads.gravity_step});
  }
  for (int k = 0; k < system.elastic_bodies().count() && !acceleration.isZero(0); ++k) {
    const ElasticBody& body = system.elastic_bodies().body(k);
    const ElasticModel& model = system.elastic_bodies().model(k);
    const auto holder =
        std::ranges::find_if(body.interfaces, [](const auto& i) { return i.body != ground; });
    if (model.total_mass > 0)
      loads.constant.push_back({.force = -model.total_mass * acceleration,
                                .body = holder->body,
                                .arm = body.place +
                                       body.axes * model.mass_moment / model.total_mass -
                                       mechanism.bodies[holder->body].reference,
                                .step = loads.gravity_step});
  }
}

constexpr const char* why = "the stable branch";

// From rest with extra loads, which are then taken away. `stiffness`: of the mechanism at rest
// against the motion of the push.
Answer<StableBranch> around(System& unstable, const Push& push, double stiffness, double first,
                            const ModelOptions& model, StrokeRequest request, std::size_t point) {
  StableBranch found;
  request.newton.max_halvings += more_halvings;
  const Mechanism& mechanism = unstable.mechanism();
  std::optional<VectorXd> strokes;
  if (request.loads.driven()) strokes = request.strokes_at(point, mechanism.drives.size());
  for (double amplitude = first;; amplitude *= left) {
    if (amplitude < least_amplitude) amplitude = 0;
    LoadCase loads = unstable.loads();
    if (amplitude > 0) add_push(push, amplitude, stiffness, unstable, loads);
    if (!found.system) {
      found.system = std::make_unique<System>(mechanism, make_full_leaves(mechanism, model, why),
                                              std::move(loads));
      found.equilibrium = step_from_rest(*found.system, request, point);
    } else {
      found.system = found.system->on_full_leaves(std::move(loads));
      found.equilibrium = solve_equilibrium(*found.system, strokes, request.newton);
    }
    const bool stable = found.equilibrium.converged &&
                        negative_pivots(*found.system, request.loads.stable_with_all_held()) == 0;
    if (stable && amplitude == 0) return found;
    if (stable) continue;
    return Because(found.equilibrium.converged ? "beside it the mechanism is unstable, too"
                                               : found.equilibrium.message);
  }
}

}  // namespace

namespace {

// Nothing where no push leads away.
std::optional<Push> push_of(const System& unstable, DriveHold held) {
  std::optional<Push> push = push_of_bodies(unstable, held);
  return push ? push : push_of_leaves(unstable);
}

StableState state_of(const System& system) {
  const JointBody& pose = system.pose(system.mechanism().end_effector);
  return {system.energy() + system.load_energy(), {pose.position - pose.reference, pose.turn}};
}

// Places and rotations of bodies and places of leaves, lengths over the longest leaf.
VectorXd places_of(System& system) {
  std::vector<double> all;
  const auto add = [&](const auto& numbers, double unit) {
    for (const double x : numbers.reshaped()) all.push_back(x / unit);
  };
  for (const JointBody& pose : system.poses()) {
    add(pose.position, system.length());
    add(pose.rotation, 1);
  }
  for (int i = 0; i < system.leaves(); ++i)
    for (const Vector3d& place : system.leaf(i).material_points({{0.25, 0}, {0.5, 0}, {0.75, 0}}))
      add(place, system.length());
  return VectorXd::Map(all.data(), std::ssize(all));
}

// States as near are one: solve_equilibrium() ends at steps below 1e-6.
constexpr double same_place = 1e-5;

}  // namespace

std::vector<StableState> stable_states(System& system, const std::optional<Push>& push,
                                       const ModelOptions& model, const StrokeRequest& request,
                                       std::size_t point) {
  std::vector<StableState> states;
  std::vector<VectorXd> places;
  const auto add = [&](System& stable) {
    VectorXd here = places_of(stable);
    if (std::ranges::any_of(places, [&](const VectorXd& other) {
          return (here - other).cwiseAbs().maxCoeff() < same_place;
        }))
      return;
    places.push_back(std::move(here));
    states.push_back(state_of(stable));
  };
  const bool all_held = request.loads.stable_with_all_held();
  std::vector<Push> pushes;
  const auto add_opposite = [&](const Push& one) {
    pushes.push_back({-one.motion, -one.acceleration});
  };
  if (negative_pivots(system, all_held) == 0) {
    add(system);
    if (push) add_opposite(*push);
  } else if (const auto own = system.analyses() ? std::nullopt : push_of(system, all_held)) {
    pushes.push_back(*own);
    add_opposite(*own);
  }
  for (const Push& one : pushes)
    if (const auto found = lead_to_stable_branch(system, one, model, request, point))
      add(*found->system);
  std::ranges::stable_sort(states, {}, &StableState::energy);
  return states;
}

Answer<StableBranch> find_stable_branch(System& unstable, const ModelOptions& model,
                                        const StrokeRequest& request, std::size_t point) {
  if (unstable.analyses())
    return Because("a mechanism of so many bodies is not led to its stable branch");
  const std::optional<Push> push = push_of(unstable, request.loads.stable_with_all_held());
  if (push) return lead_to_stable_branch(unstable, *push, model, request, point);
  return Because("what is unstable lies inside leaves without mass and moves no body");
}

Answer<StableBranch> lead_to_stable_branch(System& system, const Push& push,
                                           const ModelOptions& model, const StrokeRequest& request,
                                           std::size_t point) {
  System at_rest(system.mechanism(), make_full_leaves(system.mechanism(), model, why), {});
  at_rest.assemble();
  const double stiffness = push.motion.dot(VectorXd(at_rest.tangent() * push.motion));
  Answer<StableBranch> found;
  for (const double first : first_amplitudes) {
    found = around(system, push, stiffness, first, model, request, point);
    if (found) break;
  }
  if (found) found->push = push;
  return found;
}

Check leave_branch(System& system, std::unique_ptr<System>& away, const ModelOptions& model,
                   const StrokeRequest& request, std::size_t point, Equilibrium& equilibrium,
                   std::optional<Push>& push) {
  Equilibrium here = equilibrium;
  std::unique_ptr<System> whole =
      finish_on_full_leaves(system, model, request, point, check_full(system), here);
  if (!here.converged) return Because(here.message);
  // reduced leaves alone were unstable
  if (whole && negative_pivots(*whole, request.loads.stable_with_all_held()) == 0) {
    away = std::move(whole);
    equilibrium = here;
    return {};
  }
  Answer<StableBranch> found = find_stable_branch(whole ? *whole : system, model, request, point);
  if (!found) return Because(found.error());
  away = std::move(found->system);
  equilibrium = found->equilibrium;
  push = std::move(found->push);
  return {};
}

}  // namespace flexopt
