#pragma once
// Flat faces of a shape, which patches lie on.
#include <optional>
#include <vector>

#include "designs/solids/solid_shape.hpp"

namespace flexopt {

/// A flat face, own axes of the shape. It is a rectangle; that of a plate along its plane lies
/// within this rectangle.
template <class S>
struct FlatFaceT {
  Vector3<S> center;
  Vector3<S> normal;          ///< unit, out of the shape
  Vector3<S> half_u, half_v;  ///< from the centre to the middles of two sides [m]
  bool whole = true;          ///< the rectangle itself

  /// How far a place stands off the face to the outside [m].
  S height(const Vector3<S>& place) const { return (place - center).dot(normal); }
  /// Whether the place, seen along the normal, is within the rectangle, or nearer to it than
  /// `within` [m].
  bool holds(const Vector3<S>& place, double within) const;
};

/// Faces of a box, the sides of a plate and its straight walls, the ends of a notch.
template <class S>
std::vector<FlatFaceT<S>> flat_faces(const SolidShapeT<S>& shape);

/// The longest side of the cuboid around the shape [m].
template <class S>
double extent(const std::vector<FlatFaceT<S>>& faces);

}  // namespace flexopt
