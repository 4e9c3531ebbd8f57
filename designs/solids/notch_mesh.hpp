#pragma once
// The contour of a notch, and the lines of its mesh.
#include "core/math/answer.hpp"
#include "designs/solids/solid_shape.hpp"

namespace flexopt {

/// A plane of nodes across an axis: between two planes of the shape or of a patch, or at a place of
/// the contour of a notch.
struct MeshLine {
  int from = 0, to = 0;  ///< the planes
  double at = 0;         ///< share of the way from one to the other, or along the segment
  int side = 0;          ///< of the notch, −1 or 1: of its thinnest section; 0: between planes
  int segment = 0;       ///< of the contour
};

/// A place of the contour of one side, 0 ≤ x ≤ half_length.
template <class S>
struct NotchPlaceT {
  S x;     ///< along the notch [m]
  S rise;  ///< of the contour over its thinnest section [m]
};
/// `segment`: 0, and 1 where the contour has two: fillet after line, line after fillet.
template <class S>
NotchPlaceT<S> notch_place(const NotchShapeT<S>& notch, int segment, double at);
/// Tells where it ends: its rise is the depth, but for corner fillets, behind which a wall follows.
template <class S>
NotchPlaceT<S> notch_end(const NotchShapeT<S>& notch);

/// Tells of sizes that make no notch.
Check check_notch(const NotchShapeT<double>& notch);

/// Lines across x strictly within the notch, ascending: boundaries of elements and, between them,
/// their middles. `share`: of an element in the thinnest thickness.
std::vector<MeshLine> notch_lines(const NotchShapeT<double>& notch, double share, double growth);

}  // namespace flexopt
