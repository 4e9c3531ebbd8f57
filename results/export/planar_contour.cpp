#include "results/export/planar_contour.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/polygon/polygon.hpp>
#include <cmath>

namespace flexopt {

namespace {

namespace bp = boost::polygon;
using Grid = int;  ///< of whole numbers, on which unions of outlines are exact
using GridPoint = bp::point_data<Grid>;
using GridSet = bp::polygon_set_data<Grid>;
using GridPolygon = bp::polygon_with_holes_data<Grid>;

constexpr int around = 180;  ///< corners of a circle about a corner that the wire goes round

/// From millimetres to whole numbers and back.
class OnGrid {
 public:
  explicit OnGrid(const std::vector<PlanarPart>& parts) {
    double largest = 0;
    for (const PlanarPart& part : parts)
      for (const auto* list : {&part.shapes, &part.cut})
        for (const Outline& outline : *list)
          for (const Eigen::Vector2d& p : outline)
            largest = std::max(largest, p.cwiseAbs().maxCoeff());
    unit_ =
        std::max(1e-6, largest / 5e8);  // a nanometre, unless the part is as large as half a metre
  }
  Grid length(double mm) const { return static_cast<Grid>(std::lround(mm / unit_)); }
  GridPoint point(const Eigen::Vector2d& p) const { return {length(p[0]), length(p[1])}; }
  Eigen::Vector2d place(const GridPoint& p) const { return {unit_ * p.x(), unit_ * p.y()}; }

  GridSet set(const std::vector<Outline>& outlines) const {
    GridSet all;
    for (const Outline& outline : outlines) {
      std::vector<GridPoint> points;
      for (const Eigen::Vector2d& p : outline) points.push_back(point(p));
      bp::polygon_data<Grid> polygon(points.begin(), points.end());
      using namespace bp::operators;
      all += polygon;
    }
    return all;
  }

  /// A ring without the points that rounding has put into its straight lines.
  template <class Ring>
  Outline outline(const Ring& ring) const {
    Outline all;
    for (const GridPoint& p : ring) all.push_back(place(p));
    if (all.size() > 1 && all.front() == all.back()) all.pop_back();
    for (bool less = true; less && all.size() > 3;) {
      less = false;
      for (std::size_t k = 0; k < all.size() && all.size() > 3; ++k) {
        const Eigen::Vector2d &a = all[(k + all.size() - 1) % all.size()],
                              &b = all[(k + 1) % all.size()];
        const Eigen::Vector2d line = b - a, own = all[k] - a;
        const double area = std::abs(line[0] * own[1] - line[1] * own[0]);
        if (area > 10 * unit_ * line.norm() && own.norm() > 10 * unit_) continue;
        all.erase(all.begin() + static_cast<std::ptrdiff_t>(k));
        less = true;
      }
    }
    return all;
  }

 private:
  double unit_ = 1e-6;
};

std::vector<GridPolygon> polygons_of(const GridSet& set) {
  std::vector<GridPolygon> all;
  set.get(all);
  return all;
}

/// Numbers of polygons and of all their holes.
std::pair<std::size_t, std::size_t> counts_of(const std::vector<GridPolygon>& polygons) {
  std::size_t holes = 0;
  for (const GridPolygon& polygon : polygons) holes += polygon.size_holes();
  return {polygons.size(), holes};
}

/// Distance of a place from an outline; negative outside.
double depth_in(const Outline& outline, const Eigen::Vector2d& place) {
  double least = 1e300;
  bool inside = false;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Eigen::Vector2d &a = outline[k], &b = outline[(k + 1) % outline.size()];
    const Eigen::Vector2d line = b - a;
    const double part = std::clamp((place - a).dot(line) / line.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (a + part * line - place).norm());
    if ((a[1] > place[1]) != (b[1] > place[1]) &&
        place[0] < a[0] + (place[1] - a[1]) / line[1] * line[0])
      inside = !inside;
  }
  return inside ? least : -least;
}

/// The place in an outline that is farthest from it: the best of a grid, which then becomes finer
/// about it.
Eigen::Vector2d inner_place(const Outline& outline) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : outline) box.extend(p);
  Eigen::Vector2d half = 0.5 * box.sizes(), best = box.center();
  double depth = depth_in(outline, best);
  constexpr int steps = 24;  // to each side
  for (int round = 0; round < 8; ++round, half *= 0.25) {
    const Eigen::Vector2d centre = best;
    for (int i = -steps; i <= steps; ++i)
      for (int j = -steps; j <= steps; ++j) {
        const Eigen::Vector2d place = centre + Eigen::Vector2d(i, j).cwiseProduct(half) / steps;
        const double own = depth_in(outline, place);
        if (own <= depth + 1e-12) continue;
        depth = own;
        best = place;
      }
  }
  return best;
}

}  // namespace

ContourAnswer planar_contour(const std::vector<PlanarPart>& parts, double beside) {
  const OnGrid grid(parts);
  using namespace bp::operators;
  GridSet all;
  for (const PlanarPart& part : parts) {
    all += grid.set(part.cut) - grid.set(part.rooms);
    all += grid.set(part.shapes);
  }
  // gaps of some nanometres between what touches are closed
  const Grid rounding = 20;
  all.resize(rounding);
  all.resize(-rounding);
  std::vector<GridPolygon> polygons = polygons_of(all);
  const auto [islands, holes] = counts_of(polygons);
  if (islands != 1)
    return {std::nullopt, fmt::format("its outlines are {} separate ones", islands)};
  if (beside > 0) {
    all.resize(grid.length(beside), true, around);
    polygons = polygons_of(all);
    if (counts_of(polygons) != std::pair(islands, holes))
      return {std::nullopt, "a gap is narrower than the cut"};
  }
  const GridPolygon& one = polygons.front();
  PlanarContour contour{.outer = grid.outline(one)};
  const auto left = std::ranges::min_element(contour.outer, {}, [](const auto& p) { return p[0]; });
  contour.starts.push_back(*left - Eigen::Vector2d(2 + 2 * beside, 0));
  for (auto hole = one.begin_holes(); hole != one.end_holes(); ++hole) {
    contour.holes.push_back(grid.outline(*hole));
    contour.starts.push_back(inner_place(contour.holes.back()));
    contour.clear.push_back(depth_in(contour.holes.back(), contour.starts.back()));
  }
  return {std::move(contour), {}};
}

}  // namespace flexopt
