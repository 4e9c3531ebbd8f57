#include "core/response/path/point_outputs.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/equilibrium/elastic_degree.hpp"
#include "core/equilibrium/elastic_stress.hpp"
#include "core/equilibrium/end_effector_compliance.hpp"
#include "core/math/rotation.hpp"
#include "core/response/actuators.hpp"
#include "core/response/gain.hpp"
#include "core/response/gauges.hpp"
#include "core/response/room_taken.hpp"
#include "core/response/stability/critical_load.hpp"
#include "core/response/stress_safety.hpp"

namespace flexopt {
namespace {

Vector3d displacement_of(System& system, const NamedPoint& point) {
  if (point.body) {
    const JointBody& now = system.pose(*point.body);
    return now.position + point.lever(now) - point.at.value_or(now.reference);
  }
  return system.leaf(point.leaf).material_point(point.along, point.across) -
         undeflected_place(system.mechanism().leaves[point.leaf], point.along, point.across);
}

double motion_along(const NamedPoint& named, const Vector3d& displacement, const PathPoint& point) {
  return named.turns() ? named.direction->tail<3>().dot(point.bodies[*named.body].rotation)
                       : named.direction->head<3>().dot(displacement);
}

void add_motion(System& system, const StrokeRequest& request, PathPoint& point) {
  const Mechanism& mechanism = system.mechanism();
  const JointBody& pose = system.pose(mechanism.end_effector);
  const RigidBody& body = mechanism.bodies[mechanism.end_effector];
  point.displacement = pose.position - body.reference;
  point.rotation = pose.turn;
  for (int i = 0; i < system.leaves(); ++i) {
    const auto& follows = mechanism.leaves[i].point;
    if (follows && follows->body == mechanism.end_effector && follows->spread_over_tip)
      point.displacement =
          system.leaf(i).material_point(follows->along, follows->across) - body.reference;
  }
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    const JointBody& at = system.pose(static_cast<int>(b));
    point.bodies.push_back({at.position - at.reference, at.turn});
  }
  point.bodies[mechanism.end_effector].displacement = point.displacement;
  for (const NamedPoint& named : request.named_points) {
    const Vector3d& moved = point.named_points.emplace_back(displacement_of(system, named));
    point.motions_along.emplace_back();
    if (named.direction) point.motions_along.back() = motion_along(named, moved, point);
  }
}

void add_stiffness(const System& system, const StrokeRequest& request, PathPoint& point) {
  const EndEffectorCompliance c = end_effector_compliance(system);
  point.compliance_free = c.drive_free;
  point.compliance_locked = c.drive_locked;
  point.support_stiffness = c.support_stiffness();
  point.drive_stiffnesses.assign(c.drive_stiffness.begin(), c.drive_stiffness.end());
  if (!point.drive_stiffnesses.empty()) point.drive_stiffness = point.drive_stiffnesses.front();
  set_gain(system.mechanism(), c.drive_motion, point);
  if (has_actuators(system.mechanism())) set_actuators(system.mechanism(), c.drive_motion, point);
  point.negative_pivots = request.loads.stable_with_all_held() && !system.follows()
                              ? c.negative_pivots
                              : negative_pivots(system, request.loads.stable_with_all_held());
  point.stable = point.negative_pivots == 0;
}

void add_gauges(System& system, const StrokeRequest& request, PathPoint& point) {
  VectorXd strains(request.gauges.size());
  for (std::size_t k = 0; k < request.gauges.size(); ++k) {
    const StrainGauge& gauge = request.gauges[k];
    const SectionStress section = system.leaf(gauge.leaf).stress().sections({place_of(gauge)});
    point.gauges.push_back(
        read_gauge(gauge, section, system.mechanism().leaves[gauge.leaf].material));
    strains[static_cast<Eigen::Index>(k)] = point.gauges.back().strain;
  }
  const VectorXd outputs = bridge_outputs(request, strains);
  point.bridges.assign(outputs.begin(), outputs.end());
}

/// The largest stress of every leaf, then of elastic bodies.
std::vector<StressPeak> largest_stresses(System& system,
                                         const std::vector<std::optional<ElasticStress>>& elastic) {
  std::vector<StressPeak> peaks;
  for (int i = 0; i < system.leaves(); ++i) peaks.push_back(system.leaf(i).stress().largest());
  for (const auto& body : elastic)
    if (const auto largest = body ? body->largest() : std::nullopt) peaks.push_back(*largest);
  return peaks;
}

void add_max_stress(const std::vector<StressPeak>& parts, PathPoint& point) {
  for (const StressPeak& peak : parts)  // of those equal but for rounding the first is named
    if (!point.max_stress || peak.value > point.max_stress->value * (1 + 1e-9))
      point.max_stress = peak;
}

void add_safety(System& system, const StressRules& rules, std::vector<StressPeak> parts,
                PathPoint& point) {
  if (!rules.fillet && !rules.yield && !rules.fatigue && !rules.life) return;
  const Mechanism& mechanism = system.mechanism();
  if (rules.fillet) point.fillet_fault = why_not(check_fillet(mechanism, *rules.fillet));
  if (!point.fillet_fault.empty()) return;
  if (rules.fillet)
    for (int i = 0; i < system.leaves(); ++i) {
      StressPeak& largest = parts[i];
      largest = with_fillets(largest, system.leaf(i), mechanism, *rules.fillet);
    }
  add_stress_safety(parts, mechanism, rules, point);
}

// The places are those of the first point that is evaluated.
void add_sections(System& system, const std::vector<std::optional<ElasticStress>>& elastic,
                  std::vector<std::vector<StressPlace>>& places, PathPoint& point) {
  const auto leaves = static_cast<std::size_t>(system.leaves());
  if (places.empty()) {
    for (int i = 0; i < system.leaves(); ++i)
      places.push_back(system.leaf(i).stress().stations.places());
    for (const auto& body : elastic)
      places.push_back(body ? body->places() : std::vector<StressPlace>());
  }
  point.sections.clear();
  for (int i = 0; i < system.leaves(); ++i)
    point.sections.push_back(system.leaf(i).stress().sections(places[i]));
  for (std::size_t k = 0; k < elastic.size(); ++k)
    point.sections.push_back(elastic[k] ? elastic[k]->sections(places[leaves + k])
                                        : MatrixXd(6, 0));
}

Solids solids_of(System& system) {
  const Mechanism& mechanism = system.mechanism();
  return {mechanism,
          [&](int leaf, const std::vector<std::array<double, 2>>& points) {
            return system.leaf(leaf).material_points(points);
          },
          system.poses()};
}

ElasticBodyReport report_of(const System& system, int k) {
  const ElasticBodies& elastic = system.elastic_bodies();
  const CondensedSolid& solid = elastic.solid(k);
  const VectorXd& local = elastic.held(k).floating.local;
  const std::optional<double> share = geometric_share(elastic, k);
  ElasticBodyReport report{.geometric_share = share,
                           .degree_error = degree_error(system, k, share),
                           .rigid_residual = solid.rigid_residual,
                           .unknowns = solid.unknowns};
  for (Eigen::Index a = 3; a < local.size(); a += 6)
    report.turn = std::max(report.turn, local.segment<3>(a).norm());
  return report;
}

// Bodies with meshes have a stress, others none.
std::vector<std::optional<ElasticStress>> elastic_stresses(const System& system) {
  const ElasticBodies& elastic = system.elastic_bodies();
  std::vector<std::optional<ElasticStress>> stresses(static_cast<std::size_t>(elastic.count()));
  for (int k = 0; k < elastic.count(); ++k)
    if (elastic.body(k).cells) stresses[k].emplace(elastic, k);
  return stresses;
}

ElasticShape shape_of(const ElasticStress& body) {
  const SolidSurface& surface = body.surface();
  ElasticShape shape{.triangles = surface.triangles};
  for (const int corner : surface.corners) {
    const int node = surface.nodes[corner];
    shape.undeflected.push_back(body.undeflected_place(node));
    shape.deflected.push_back(body.place(node));
    shape.von_mises.push_back(body.stress().von_mises[corner]);
  }
  return shape;
}

}  // namespace

Check check_degree(const Mechanism& mechanism, const PathPoint& point) {
  for (std::size_t k = 0; k < point.elastic_bodies.size(); ++k)
    if (Check holds =
            check_degree(mechanism.elastic_bodies[k], point.elastic_bodies[k].degree_error);
        !holds)
      return holds;
  return {};
}

PointOutputs::PointOutputs(const Mechanism& mechanism, const ModelOptions& model,
                           const StrokeRequest& request,
                           std::vector<std::vector<StressPlace>>& stress_places,
                           DifferentiablePath* differentiable)
    : model_(&model),
      request_(&request),
      differentiable_(differentiable),
      stress_places_(&stress_places) {
  if (request.frequencies > 0 && model.mass == LeafMass::constant)
    constant_mass_.emplace(mechanism, model);
  if (request.outputs.has(Output::clearance)) clearance_pairs_ = clearance_pairs(mechanism);
}

void PointOutputs::add_reports(System& system, PathPoint& point) {
  point.leaves.clear();
  for (int i = 0; i < system.leaves(); ++i) point.leaves.push_back(system.leaf(i).report());
  point.elastic_bodies.clear();
  system.assemble();
  for (int k = 0; k < system.elastic_bodies().count(); ++k)
    point.elastic_bodies.push_back(report_of(system, k));
}

// Largest first, the one that is named max_stress at their head.
void PointOutputs::add_stress_peaks(System& system, int wanted, PathPoint& point) {
  constexpr double share = 0.8;  // smaller ones are far from any bound
  const StressPeak& largest = *point.max_stress;
  std::vector<StressPeak> others;
  const auto add = [&](const std::vector<StressPeak>& peaks) {
    for (const StressPeak& p : peaks) {
      const bool same = p.leaf == largest.leaf && p.along == largest.along &&
                        p.across == largest.across &&
                        p.on_positive_normal == largest.on_positive_normal &&
                        p.elastic_body == largest.elastic_body && p.node == largest.node;
      if (!same && p.value >= share * largest.value) others.push_back(p);
    }
  };
  for (int i = 0; i < system.leaves(); ++i) add(system.leaf(i).stress().peaks());
  for (const auto& body : elastic_stresses(system))
    if (body) add(body->peaks());
  std::stable_sort(others.begin(), others.end(),
                   [](const StressPeak& a, const StressPeak& b) { return a.value > b.value; });
  point.stress_peaks.push_back(largest);
  for (const StressPeak& p : others)
    if (static_cast<int>(point.stress_peaks.size()) < wanted) point.stress_peaks.push_back(p);
}

void PointOutputs::add_buckling(System& system, const Equilibrium& equilibrium, std::size_t index,
                                PathPoint& point, PointGradients* gradients) {
  const double growing = request_->loads.driven() ? 0 : request_->points[index];
  Buckling& buckling = point.buckling.emplace();
  for (const DriveState drive : {DriveState::locked, DriveState::free}) {
    const bool locked = drive == DriveState::locked;
    if (!locked && system.drives().empty()) {
      buckling.drive_free = buckling.drive_locked;
      if (gradients) gradients->buckling_free = gradients->buckling_locked;
      continue;
    }
    LoadBranch branch(system, *request_->growing_load(), growing, drive, equilibrium.drive_loads,
                      request_->newton);
    CriticalLoadResult found =
        find_critical_load(branch, *model_, gradients ? &differentiable_->design : nullptr,
                           request_->loads.driven(), request_->largest_factor);
    (locked ? buckling.drive_locked : buckling.drive_free) = std::move(found.load);
    if (gradients)
      (locked ? gradients->buckling_locked : gradients->buckling_free) = std::move(found.gradient);
  }
}

void PointOutputs::add_load_capacity(System& system, const Equilibrium& equilibrium,
                                     std::size_t index, PathPoint& point,
                                     PointGradients* gradients) {
  const double growing = request_->loads.driven() ? 0 : request_->points[index];
  if (gradients && !capacity_) capacity_.emplace(system.mechanism(), differentiable_->design);
  for (std::size_t k = 0; k < request_->capacity.directions.size(); ++k) {
    if (!request_->capacity.directions[k]) continue;
    LoadCapacityResult found =
        find_load_capacity(system, static_cast<int>(k), growing, equilibrium.drive_loads, *request_,
                           *model_, gradients ? &*capacity_ : nullptr);
    point.load_capacity[k] = std::move(found.capacity);
    if (gradients) gradients->load_capacity[k] = std::move(found.gradient);
  }
}

void PointOutputs::miss_branching(const std::string& why, PathPoint& point) const {
  if (request_->growing_load() && !point.buckling) point.buckling.emplace();
  if (point.buckling)
    for (CriticalLoad* load : {&point.buckling->drive_locked, &point.buckling->drive_free})
      if (!load->factor && load->reason.empty()) load->reason = why;
  for (std::size_t k = 0; request_->wants_capacity() && k < point.load_capacity.size(); ++k)
    if (request_->capacity.directions[k] && !point.load_capacity[k])
      point.load_capacity[k] = LoadCapacity{.reason = why};
  if (request_->outputs.has(Output::stable_states) && point.stable_states.empty() &&
      point.message.empty())
    point.message = "stable states are missing: " + why;
}

void PointOutputs::add_stress_and_shapes(System& system, PathPoint& point) const {
  const bool stress = request_->outputs.has(Output::stress),
             shapes = request_->outputs.has(Output::shapes);
  if (!stress && !shapes) return;
  const std::vector<std::optional<ElasticStress>> elastic = elastic_stresses(system);
  if (stress) {
    std::vector<StressPeak> parts = largest_stresses(system, elastic);
    add_max_stress(parts, point);
    point.allowable_safety = allowable_safety(parts, system.mechanism());
    add_safety(system, request_->stress, std::move(parts), point);
    if (request_->stress.need_history()) add_sections(system, elastic, *stress_places_, point);
    for (std::size_t k = 0; k < elastic.size(); ++k) {
      if (!elastic[k] || !elastic[k]->largest()) continue;
      point.elastic_bodies[k].stress = elastic[k]->largest();
      point.elastic_bodies[k].stress_jump = elastic[k]->stress().largest->jump;
    }
  }
  if (!shapes) return;
  for (int i = 0; i < system.leaves(); ++i) point.shapes.push_back(system.leaf(i).shape());
  for (const auto& body : elastic)
    point.elastic_shapes.push_back(body ? shape_of(*body) : ElasticShape());
}

Check PointOutputs::evaluate(System& system, const Equilibrium& equilibrium, std::size_t index,
                             PathPoint& point, PointGradients* gradients) {
  point.status = PointStatus::converged;
  point.newton_iterations = equilibrium.iterations;
  point.sub_steps = equilibrium.sub_steps;
  point.drive_load = equilibrium.drive_load;
  point.drive_loads.assign(equilibrium.drive_loads.begin(), equilibrium.drive_loads.end());
  add_motion(system, *request_, point);
  add_stiffness(system, *request_, point);
  add_reports(system, point);
  if (system.follows() ||
      (request_->wants_frequencies() && (!differentiable_ || model_->mass == LeafMass::constant)))
    add_ritz_frequencies(system, point);
  add_stress_and_shapes(system, point);
  if (request_->wants_gauges()) add_gauges(system, *request_, point);
  std::optional<Solids> solids;
  if (request_->outputs.has(Output::moving_envelope) || !clearance_pairs_.empty())
    solids = solids_of(system);
  if (request_->outputs.has(Output::moving_envelope) && solids->count() > 0)
    point.extents = extents_of(*solids);
  if (!clearance_pairs_.empty()) point.clearance = clearance_of(*solids, clearance_pairs_);
  if (!differentiable_) return {};
  return evaluate_differentiable(system, solids ? &*solids : nullptr, index, point, gradients);
}

}  // namespace flexopt
