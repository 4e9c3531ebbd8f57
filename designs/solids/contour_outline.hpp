#pragma once
// The lines and arcs that the triangles of a plate keep: contours, divided at patches, and outlines
// of patches on the faces z = ∓t/2.
#include "designs/solids/contour_curves.hpp"

namespace flexopt {

/// An end of a piece: the beginning of a curve; or a corner of a patch, put on the line of `curve`
/// where it has one.
struct PlaneKey {
  int curve = -1, patch = -1, corner = 0;
};

/// A curve or a part of a line of a contour, or (curve −1) a side of a patch.
struct PlanePiece {
  int curve = -1;
  std::array<int, 2> keys;
};

/// How a patch lies: on z = ∓t/2, or on a side face with `half_u` or `half_v` along z.
enum class PatchFace { flat, u_along_z, v_along_z };

struct PlaneOutline {
  std::vector<PatchFace> faces;  ///< of each patch
  std::vector<PlaneKey> keys;
  std::vector<PlanePiece> pieces;

  /// Corners of a patch in the plane: of a flat one in turn, else the two ends of its side.
  template <class S>
  std::array<Point2<S>, 4> corners(int patch, const PatchT<S>& of) const;
  /// Half of what it is along z [m].
  template <class S>
  S half_height(int patch, const PatchT<S>& of) const;

  template <class S>
  std::vector<Point2<S>> places(const ContoursT<S>& contours,
                                const std::vector<PatchT<S>>& patches) const;
  template <class S>
  CurveT<S> curve(int piece, const ContoursT<S>& contours,
                  const std::vector<Point2<S>>& places) const;
};

/// Tells of patches that lie on no face or whose outlines cross others.
Answer<PlaneOutline> outline_of(const PlateShapeT<double>& plate, const ContoursT<double>& contours,
                                const std::vector<PatchT<double>>& patches, double tolerance);

}  // namespace flexopt
