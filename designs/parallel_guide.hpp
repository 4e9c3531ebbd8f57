#pragma once
// Two parallel leaves that guide the end-effector across themselves.
#include "designs/leaf.hpp"

namespace flexopt {

template <class S>
struct ParallelGuideParameters {
  S length, width, thickness, spacing;

  template <class Visit>
  void each(Visit visit) {
    visit("length", length);
    visit("width", width);
    visit("thickness", thickness);
    visit("spacing", spacing);
  }
};

/// Leaves along x at y = ±spacing/2, width along z; O at (length, 0, 0).
template <class S>
MechanismT<S> make_parallel_guide(const ParallelGuideParameters<S>& p, const MaterialT<S>& material,
                                  const EndEffector& payload) {
  MechanismT<S> mechanism;
  mechanism.drives = {make_drive<S>(Direction::uy)};
  mechanism.bodies.push_back(make_end_effector<S>(Vector3<S>(p.length, S(0), S(0)), payload));
  for (const int side : {+1, -1}) {
    const S y = p.spacing * (0.5 * side);
    mechanism.leaves.push_back(make_leaf<S>(
        side > 0 ? "leaf +y" : "leaf -y", {ground, Vector3<S>(S(0), y, S(0))},
        {0, Vector3<S>(p.length, y, S(0))}, z_axis<S>(), {p.width, p.thickness, material}));
  }
  return mechanism;
}

extern template MechanismT<double> make_parallel_guide(const ParallelGuideParameters<double>&,
                                                       const Material&, const EndEffector&);

}  // namespace flexopt
