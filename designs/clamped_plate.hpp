#pragma once
// A plate clamped along two opposite edges, loaded at a point.
#include "designs/leaf.hpp"

namespace flexopt {

template <class S>
struct ClampedPlateParameters {
  S length, width, thickness, load_point_x, load_point_z;

  template <class Visit>
  void each(Visit visit) {
    visit("length", length);
    visit("width", width);
    visit("thickness", thickness);
    visit("load_point_x", load_point_x);
    visit("load_point_z", load_point_z);
  }
};

/// In the x–z plane, edges x = 0 and x = length clamped, z = 0 and z = width free; O is the
/// material point at the load point.
template <class S>
MechanismT<S> make_clamped_plate(const ClampedPlateParameters<S>& p, const MaterialT<S>& material,
                                 const EndEffector&) {
  const S middle = p.width * 0.5;
  MechanismT<S> mechanism;
  mechanism.drives = {make_drive<S>(Direction::uy)};
  mechanism.bodies.push_back(make_point_body<S>({p.load_point_x, S(0), p.load_point_z}));
  mechanism.leaves.push_back(make_leaf<S>("plate", {ground, {S(0), S(0), middle}},
                                          {ground, {p.length, S(0), middle}}, z_axis<S>(),
                                          {p.width, p.thickness, material}));
  mechanism.leaves[0].point = LeafPointT<S>{
      .body = 0, .along = p.load_point_x / p.length, .across = p.load_point_z / p.width};
  return mechanism;
}

extern template MechanismT<double> make_clamped_plate(const ClampedPlateParameters<double>&,
                                                      const Material&, const EndEffector&);

}  // namespace flexopt
