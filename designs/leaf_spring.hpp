#pragma once
// One leaf spring with a rigid tip.
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

/// From x = 0 (ground) to x = length (end-effector), width along z; O in the middle of the tip.
template <class S>
MechanismT<S> make_leaf_spring(const LeafSpringParameters<S>& p, const MaterialT<S>& material,
                               const EndEffector& payload) {
  const Vector3<S> foot(S(0), S(0), S(0)), tip(p.length, S(0), S(0));
  MechanismT<S> mechanism;
  mechanism.drive = Direction::uy;
  mechanism.bodies.push_back(make_end_effector<S>(tip, payload));
  mechanism.leaves.push_back(make_leaf<S>("leaf", {ground, foot}, {0, tip}, z_axis<S>(),
                                          {p.width, p.thickness, material}));
  return mechanism;
}

extern template MechanismT<double> make_leaf_spring(const LeafSpringParameters<double>&,
                                                    const Material&, const EndEffector&);

}  // namespace flexopt
