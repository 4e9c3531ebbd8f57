#include "core/mechanism/load_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>

namespace flexopt {
namespace {

Check check_loads(const LoadCase& loads, const Mechanism& mechanism) {
  const int bodies = static_cast<int>(mechanism.bodies.size());
  for (const std::vector<DeadLoad>* list : {&loads.constant, &loads.growing})
    for (const DeadLoad& load : *list) {
      const int body = load.body.value_or(mechanism.end_effector);
      if (body < 0 || body >= bodies)
        return Because(
            fmt::format("a load acts on body {}, but there are {} bodies", body, bodies));
      if (!load.force.allFinite() || !load.moment.allFinite() || !load.arm.allFinite() ||
          !load.place.value_or(load.arm).allFinite())
        return Because(fmt::format("a load on body {} is not finite", body));
    }
  if (!loads.gravity.allFinite()) return Because("gravity is not finite");
  return {};
}

Check check_assembly(const LoadCase& loads, const Mechanism& mechanism) {
  const int leaves = static_cast<int>(mechanism.leaves.size());
  std::set<std::array<int, 3>> edges;
  for (const AssemblyError& error : loads.assembly) {
    if (error.leaf < 0 || error.leaf >= leaves)
      return Because(fmt::format("an assembly error is of leaf {}, but there are {} leaves",
                                 error.leaf, leaves));
    const LeafSpring& leaf = mechanism.leaves[error.leaf];
    if (error.end < 0 || error.end > 1 || (error.end == 1 && leaf.tip == free_edge))
      return Because(
          fmt::format("an assembly error of leaf {} is not of a clamped edge", error.leaf));
    if (!error.move.allFinite() || !error.turn.allFinite())
      return Because(fmt::format("an assembly error of leaf {} is not finite", error.leaf));
    if (!edges.insert({error.leaf, error.end, error.step}).second)
      return Because(fmt::format("two assembly errors are of one edge of leaf {}", error.leaf));
  }
  return {};
}

Check check_mounting(const LoadCase& loads, const Mechanism& mechanism) {
  const std::size_t steps = std::max<std::size_t>(1, loads.mounting.size());
  const auto exists = [&](int step) { return step >= 0 && static_cast<std::size_t>(step) < steps; };
  const auto of_one = [&](const auto& item) { return exists(item.step); };
  if (!std::ranges::all_of(loads.constant, of_one) ||
      !std::ranges::all_of(loads.assembly, of_one) || !exists(loads.gravity_step) ||
      !exists(loads.temperature_step) || !std::ranges::all_of(loads.spring_steps, exists))
    return Because(fmt::format("a load comes in a step that is none of the {}", steps));
  if (!loads.spring_steps.empty() && loads.spring_steps.size() != mechanism.springs.size())
    return Because(fmt::format("there are steps of {} springs, but {} springs",
                               loads.spring_steps.size(), mechanism.springs.size()));
  bool held = false;
  for (const MountingStep& step : loads.mounting) {
    if (held && step.drives_free) return Because("a step frees drives that were held before");
    held = held || !step.drives_free;
    if (step.strokes && step.strokes->size() != static_cast<Eigen::Index>(mechanism.drives.size()))
      return Because(fmt::format("a step has {} strokes, but there are {} drives",
                                 step.strokes->size(), mechanism.drives.size()));
  }
  return {};
}

Check check_temperatures(const LoadCase& loads, const Mechanism& mechanism) {
  if (loads.temperature.empty()) return {};
  if (loads.temperature.size() != mechanism.leaves.size())
    return Because(fmt::format("there are {} temperatures, but {} leaves", loads.temperature.size(),
                               mechanism.leaves.size()));
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    const double change = loads.temperature[i];
    const Material& material = mechanism.leaves[i].material;
    if (change != 0 && !material.thermal_expansion)
      return Because(
          fmt::format("leaf {} is warmed, but its material has no thermal expansion", i));
    const double strain = material.thermal_expansion.value_or(0) * change;
    if (!(strain > -largest_expansion && strain < largest_expansion))
      return Because(fmt::format("leaf {} expands by {:.3g}; expected at most {:g}", i, strain,
                                 largest_expansion));
  }
  return {};
}

// A displacement that the ground holds away from the origin, along which it grows.
Check check_ground(const Mechanism& mechanism) {
  const auto apart = [](const std::string& body, std::string_view direction, double place) {
    return Because(fmt::format(
        "the ground holds {} of {} at {:.4g} m from the origin: such a ground does not expand",
        direction, body, place));
  };
  const double length = longest_leaf(mechanism);
  for (const RigidBody& body : mechanism.bodies)
    for (std::size_t d = 0; d < 3; ++d)
      if (const double place = body.reference[d]; body.held[d] && std::abs(place) > 1e-9 * length)
        return apart(body.name, direction_names[d], place);
  for (const Joint& joint : mechanism.joints) {
    if (joint.type != JointType::held_displacement) continue;
    const RigidBody& body = mechanism.bodies[joint.body];
    if (const double place = joint.axis.dot(body.reference); std::abs(place) > 1e-9 * length)
      return apart(body.name, "a displacement", place);
  }
  return {};
}

Check check_strain(double strain, const std::string& name) {
  if (strain > -largest_expansion && strain < largest_expansion) return {};
  return Because(
      fmt::format("{} expands by {:.3g}; expected at most {:g}", name, strain, largest_expansion));
}

Check check_elastic_expansions(const LoadCase& loads, const Mechanism& mechanism) {
  if (loads.elastic_expansion.empty()) return {};
  if (loads.elastic_expansion.size() != mechanism.elastic_bodies.size())
    return Because(fmt::format("there are {} expansions, but {} elastic bodies",
                               loads.elastic_expansion.size(), mechanism.elastic_bodies.size()));
  for (std::size_t k = 0; k < loads.elastic_expansion.size(); ++k)
    if (Check kept = check_strain(loads.elastic_expansion[k], mechanism.elastic_bodies[k].name);
        !kept)
      return kept;
  return {};
}

// Joints and springs that a body holds would have to grow with it.
Check check_expansions(const LoadCase& loads, const Mechanism& mechanism) {
  if (loads.body_expansion.empty()) return {};
  if (loads.body_expansion.size() != mechanism.bodies.size() + 1)
    return Because(fmt::format("there are {} expansions, but {} bodies and the ground",
                               loads.body_expansion.size(), mechanism.bodies.size()));
  for (std::size_t k = 0; k < loads.body_expansion.size(); ++k) {
    const double strain = loads.body_expansion[k];
    const bool is_ground = k == mechanism.bodies.size();
    const std::string name = is_ground ? "the ground" : mechanism.bodies[k].name;
    if (Check kept = check_strain(strain, name); !kept) return kept;
    if (strain == 0) continue;
    const int b = is_ground ? ground : static_cast<int>(k);
    const auto holds = [b](const auto& part) { return part.body == b || part.other == b; };
    if (std::ranges::any_of(mechanism.joints,
                            [&](const Joint& j) { return !is_held(j.type) && holds(j); }))
      return Because(name + " has a joint: such a body does not expand");
    if (std::ranges::any_of(mechanism.springs, holds))
      return Because(name + " has a spring: such a body does not expand");
    if (is_ground)
      if (Check kept = check_ground(mechanism); !kept) return kept;
    if (std::ranges::any_of(mechanism.leaves,
                            [b](const LeafSpring& l) { return l.point && l.point->body == b; }))
      return Because(name + " is a point of a leaf: it does not expand");
  }
  return {};
}

}  // namespace

Vector3d growth_move(const Mechanism& warm, int leaf, int end) {
  const LeafSpring& l = warm.leaves[leaf];
  const int body = end == 0 ? l.base : l.tip;
  if (body == free_edge) return Vector3d::Zero();
  const Vector3d place = end == 0 ? l.origin : l.tip_middle(),
                 still = body == ground ? Vector3d(Vector3d::Zero()) : warm.bodies[body].reference;
  return (l.clamp_growth[end] - 1) * (place - still);
}

Mechanism warmed(const Mechanism& mechanism, const LoadCase& loads) {
  Mechanism warm = mechanism;
  for (std::size_t i = 0; i < std::min(warm.leaves.size(), loads.temperature.size()); ++i) {
    LeafSpring& leaf = warm.leaves[i];
    leaf.growth = 1 + leaf.material.thermal_expansion.value_or(0) * loads.temperature[i];
  }
  for (std::size_t i = 0; i < std::min(warm.elastic_bodies.size(), loads.elastic_expansion.size());
       ++i)
    warm.elastic_bodies[i].growth = 1 + loads.elastic_expansion[i];
  if (loads.body_expansion.empty()) return warm;
  const auto growth_of = [&](int body) {
    return 1 + (body == ground ? loads.body_expansion.back() : loads.body_expansion[body]);
  };
  for (LeafSpring& leaf : warm.leaves)
    for (int e = 0; e < 2; ++e)
      if (const int body = e == 0 ? leaf.base : leaf.tip; body != free_edge)
        leaf.clamp_growth[e] = growth_of(body);
  for (ElasticBody& elastic : warm.elastic_bodies)
    for (ElasticInterface& interface : elastic.interfaces)
      interface.clamp_growth = growth_of(interface.body);
  return warm;
}

Check is_reducible(const LeafSpring& leaf, const LoadCase& loads) {
  if (leaf.growth != 1) return Because("it is warmer than its clamps");
  if (leaf.clamp_growth != std::array<double, 2>{1, 1}) return Because("its clamps are warm");
  if (!loads.gravity.isZero(0) && leaf.material.density > 0)
    return Because("its weight acts on it");
  return {};
}

Check check_rules(const LoadCase& loads, const Mechanism& mechanism) {
  if (Check kept = check_loads(loads, mechanism); !kept) return kept;
  if (Check kept = check_assembly(loads, mechanism); !kept) return kept;
  if (Check kept = check_mounting(loads, mechanism); !kept) return kept;
  if (Check kept = check_temperatures(loads, mechanism); !kept) return kept;
  if (Check kept = check_elastic_expansions(loads, mechanism); !kept) return kept;
  return check_expansions(loads, mechanism);
}

}  // namespace flexopt
