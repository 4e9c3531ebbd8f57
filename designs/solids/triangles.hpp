#pragma once
// Triangles of a plane region between given edges: constrained Delaunay triangulation that is
// refined to a size and smoothed.
#include <array>
#include <functional>

#include "core/math/answer.hpp"
#include "designs/solids/contour_curves.hpp"

namespace flexopt {

/// An edge that stays: a part u of a curve, or of a line within the region.
struct PlaneEdge {
  std::array<int, 2> points;
  int piece;
  std::array<double, 2> u;
  bool is_boundary;  ///< of the region
};

struct PlaneMesh {
  std::vector<Point2<double>> points;
  std::vector<PlaneEdge> edges;
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise
};

/// Triangulates what the boundary edges enclose an odd number of times. Adds points: between
/// the ends of an edge that is no Delaunay edge (`at` tells where), and where a triangle is larger
/// than `size` at its middle or has a small angle. Equal input gives equal bits: signs of
/// determinants are those of exact integers. Method: Bowyer-Watson with circumcentres that keep off
/// the edges (Ruppert, J. Algorithms 18, 1995, without his splitting), then swaps and shifts that
/// raise the least angle. Tells where edges cannot become edges of triangles.
Check triangulate(PlaneMesh& mesh, const std::function<Point2<double>(int piece, double u)>& at,
                  const std::function<double(const Point2<double>&)>& size);

}  // namespace flexopt
