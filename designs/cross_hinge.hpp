#pragma once
// Hinges of leaves that cross at the origin: two side by side, or three mirrored in z.
#include <cmath>

#include "designs/leaf.hpp"

namespace flexopt {

/// A leaf in the plane z through the rotation axis, at `angle` from x, of which the part
/// `crossing_fraction` of its length lies before the axis.
template <class S>
LeafSpringT<S> make_crossing_leaf(std::string name, const S& angle, const S& z, const S& length,
                                  const S& crossing_fraction, const LeafSection<S>& section) {
  using std::cos, std::sin;
  const Vector3<S> along(cos(angle), sin(angle), S(0)), middle(S(0), S(0), z);
  const S before = -crossing_fraction * length, after = (S(1) - crossing_fraction) * length;
  return make_leaf<S>(std::move(name), {ground, Vector3<S>(middle + along * before)},
                      {0, Vector3<S>(middle + along * after)}, z_axis<S>(), section);
}

template <class S>
struct CrossHingeParameters {
  S length, width, thickness, half_angle, crossing_fraction, gap;

  template <class Visit>
  void each(Visit visit) {
    visit("length", length);
    visit("width", width);
    visit("thickness", thickness);
    visit("half_angle", half_angle);
    visit("crossing_fraction", crossing_fraction);
    visit("gap", gap);
  }
};

/// Leaf 1 from (-, -) to (+, +) at z = +(width + gap)/2, leaf 2 mirrored in y at
/// z = -(width + gap)/2; O at the origin, drive rz.
template <class S>
MechanismT<S> make_cross_hinge(const CrossHingeParameters<S>& p, const MaterialT<S>& material,
                               const EndEffector& payload) {
  const S z = (p.width + p.gap) * 0.5;
  const LeafSection<S> section{p.width, p.thickness, material};
  MechanismT<S> mechanism;
  mechanism.drives = {make_drive<S>(Direction::rz)};
  mechanism.bodies.push_back(make_end_effector<S>(Vector3<S>(S(0), S(0), S(0)), payload));
  mechanism.leaves.push_back(
      make_crossing_leaf<S>("leaf 1", p.half_angle, z, p.length, p.crossing_fraction, section));
  mechanism.leaves.push_back(make_crossing_leaf<S>("leaf 2", S(-p.half_angle), S(-z), p.length,
                                                   p.crossing_fraction, section));
  return mechanism;
}

template <class S>
struct ThreeFlexureCrossHingeParameters {
  S length, thickness, outer_width, inner_width, half_angle, crossing_fraction, gap;

  template <class Visit>
  void each(Visit visit) {
    visit("length", length);
    visit("thickness", thickness);
    visit("outer_width", outer_width);
    visit("inner_width", inner_width);
    visit("half_angle", half_angle);
    visit("crossing_fraction", crossing_fraction);
    visit("gap", gap);
  }
};

/// Two outer leaves like leaf 1 of the cross hinge at z = ±(inner_width/2 + gap + outer_width/2),
/// the inner leaf like leaf 2 at z = 0; O at the origin, drive rz.
template <class S>
MechanismT<S> make_three_flexure_cross_hinge(const ThreeFlexureCrossHingeParameters<S>& p,
                                             const MaterialT<S>& material,
                                             const EndEffector& payload) {
  const S z = p.inner_width * 0.5 + p.gap + p.outer_width * 0.5;
  const LeafSection<S> outer{p.outer_width, p.thickness, material};
  const LeafSection<S> inner{p.inner_width, p.thickness, material};
  const S against = -p.half_angle;
  MechanismT<S> mechanism;
  mechanism.drives = {make_drive<S>(Direction::rz)};
  mechanism.bodies.push_back(make_end_effector<S>(Vector3<S>(S(0), S(0), S(0)), payload));
  mechanism.leaves = {
      make_crossing_leaf<S>("outer +z", p.half_angle, z, p.length, p.crossing_fraction, outer),
      make_crossing_leaf<S>("inner", against, S(0), p.length, p.crossing_fraction, inner),
      make_crossing_leaf<S>("outer -z", p.half_angle, S(-z), p.length, p.crossing_fraction, outer)};
  return mechanism;
}

extern template MechanismT<double> make_cross_hinge(const CrossHingeParameters<double>&,
                                                    const Material&, const EndEffector&);
extern template MechanismT<double> make_three_flexure_cross_hinge(
    const ThreeFlexureCrossHingeParameters<double>&, const Material&, const EndEffector&);

}  // namespace flexopt
