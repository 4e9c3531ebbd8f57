#pragma once
// Edges and leaves that are moved by a vector.
#include "core/elements/leaf/edge_pose.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Each edge shifted by three components of v and turned by the next three, in global axes.
inline EdgePoses moved(EdgePoses edges, const Vector12d& v) {
  for (int e = 0; e < 2; ++e) {
    edges[e].position += v.segment<3>(6 * e);
    edges[e].axes = rotation_exp(v.segment<3>(6 * e + 3)) * edges[e].axes;
  }
  return edges;
}

/// The numbers of a leaf t along a rate, its axes turned by t `turn`.
inline LeafSpring moved(LeafSpring leaf, const LeafSpring& rate, const Vector3d& turn, double t) {
  leaf.origin += t * rate.origin;
  leaf.axes = rotation_exp(t * turn) * leaf.axes;
  leaf.length += t * rate.length;
  leaf.width += t * rate.width;
  leaf.thickness += t * rate.thickness;
  leaf.material.youngs_modulus += t * rate.material.youngs_modulus;
  leaf.material.poissons_ratio += t * rate.material.poissons_ratio;
  leaf.material.density += t * rate.material.density;
  return leaf;
}

}  // namespace flexopt
