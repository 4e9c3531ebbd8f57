#pragma once
// One leaf spring with a rigid, guided, hinged or free tip.
#include "designs/leaf.hpp"

namespace flexopt {

template <class S>
struct LeafSpringParameters {
  S length, width, thickness;

  template <class Visit>
  void each(Visit visit) {
    visit("length", length);
    visit("width", width);
    visit("thickness", thickness);
  }
};

enum class Tip {
  rigid,   ///< the tip edge is part of the end-effector
  guided,  ///< and that moves along x and y only
  hinged,  ///< the same, but the tip edge turns about z on the end-effector: a revolute joint
  free     ///< O is the middle of the free tip edge; its load is spread evenly over the edge
};

/// From x = 0 (ground) to x = length, width along z; O in the middle of the tip.
template <class S>
MechanismT<S> make_leaf_spring(const LeafSpringParameters<S>& p, const MaterialT<S>& material,
                               const EndEffector& payload, Tip kind = Tip::rigid) {
  const Vector3<S> foot(S(0), S(0), S(0)), tip(p.length, S(0), S(0));
  MechanismT<S> mechanism;
  mechanism.drives = {make_drive<S>(Direction::uy)};
  const bool is_free = kind == Tip::free, is_hinged = kind == Tip::hinged;
  mechanism.bodies.push_back(is_free ? make_point_body<S>(tip)
                                     : make_end_effector<S>(tip, payload));
  if (kind == Tip::guided || is_hinged)
    mechanism.bodies[0].held = {false, false, true, true, true, true};
  mechanism.leaves.push_back(make_leaf<S>("leaf", {ground, foot},
                                          {is_free     ? free_edge
                                           : is_hinged ? 1
                                                       : 0,
                                           tip},
                                          z_axis<S>(), {p.width, p.thickness, material}));
  if (is_free)
    mechanism.leaves[0].point =
        LeafPointT<S>{.body = 0, .along = S(1), .across = S(0.5), .spread_over_tip = true};
  if (is_hinged) {
    RigidBodyT<S> edge = make_end_effector<S>(tip, EndEffector{});
    edge.name = "tip edge";
    edge.role = BodyRole::intermediate;
    mechanism.bodies.push_back(edge);
    mechanism.joints.push_back({.name = "hinge",
                                .type = JointType::revolute,
                                .body = 0,
                                .other = 1,
                                .place = tip,
                                .axis = z_axis<S>()});
  }
  return mechanism;
}

extern template MechanismT<double> make_leaf_spring(const LeafSpringParameters<double>&,
                                                    const Material&, const EndEffector&, Tip);

}  // namespace flexopt
