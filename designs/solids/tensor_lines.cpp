#include "designs/solids/tensor_lines.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "designs/solids/mesh_plan.hpp"

namespace flexopt {

namespace {

/// Half the height and width of what the notch leaves at its ends.
template <class S>
std::array<S, 2> inner_halves(const NotchShapeT<S>& notch) {
  const S rise = notch_end(notch).rise;
  return {0.5 * notch.thickness + rise,
          0.5 * notch.width - (notch.two_axes ? S(notch.depth - rise) : S(0.0))};
}

template <class S>
void add_planes(const BoxShapeT<S>& box, PlanesT<S>& planes) {
  for (int d = 0; d < 3; ++d) planes.at[d] = {-0.5 * box.lengths[d], 0.5 * box.lengths[d]};
}
template <class S>
void add_planes(const PlateShapeT<S>& plate, PlanesT<S>& planes) {
  const auto add = [&](const ContourT<S>& contour) {
    for (const auto& corner : contour)
      for (int d = 0; d < 2; ++d) planes.at[d].push_back(corner.at[d]);
  };
  add(plate.outline);
  for (const auto& window : plate.windows) add(window);
  planes.at[2] = {-0.5 * plate.thickness, 0.5 * plate.thickness};
}
template <class S>
void add_planes(const NotchShapeT<S>& notch, PlanesT<S>& planes) {
  const S end = notch.half_length + notch.end_length, half = 0.5 * notch.thickness + notch.depth;
  const auto inner = inner_halves(notch);
  planes.at[0] = {-end, -notch.half_length, notch.half_length, end};
  planes.at[1] = {-half, -inner[0], inner[0], half};
  planes.at[2] = {-0.5 * notch.width, -inner[1], inner[1], 0.5 * notch.width};
}

bool is_within(const ContourT<double>& contour, double x, double y) {
  bool within = false;
  for (std::size_t c = 0; c < contour.size(); ++c) {
    const auto &a = contour[c].at, &b = contour[(c + 1) % contour.size()].at;
    if ((a[1] > y) != (b[1] > y) && x < a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]))
      within = !within;
  }
  return within;
}

bool is_within(const BoxShapeT<double>& box, const Vector3d& place) {
  for (int d = 0; d < 3; ++d)
    if (std::abs(place[d]) > 0.5 * box.lengths[d]) return false;
  return true;
}
bool is_within(const PlateShapeT<double>& plate, const Vector3d& place) {
  const auto holds = [&](const ContourT<double>& contour) {
    return is_within(contour, place[0], place[1]);
  };
  return std::abs(place[2]) <= 0.5 * plate.thickness && holds(plate.outline) &&
         std::none_of(plate.windows.begin(), plate.windows.end(), holds);
}
bool is_within(const NotchShapeT<double>& notch, const Vector3d& place) {
  const bool in_notch = std::abs(place[0]) < notch.half_length;
  const auto inner = inner_halves(notch);
  return std::abs(place[0]) <= notch.half_length + notch.end_length &&
         std::abs(place[1]) <= (in_notch ? inner[0] : 0.5 * notch.thickness + notch.depth) &&
         std::abs(place[2]) <= (in_notch ? inner[1] : 0.5 * notch.width);
}

/// Largest sizes of elements along the axes [m].
struct Sizes {
  std::array<double, 3> largest;
  bool corners = false;  ///< smaller ones at the planes of the shape between the outer ones
  double share = 0;      ///< of an element in the thinnest thickness of a notch
};

Sizes sizes_of(const BoxShapeT<double>& box, double /*extent*/, const MeshDensity& density) {
  const auto [least, most] = std::minmax_element(box.lengths.begin(), box.lengths.end());
  Sizes sizes;
  for (int d = 0; d < 3; ++d)
    sizes.largest[d] = std::min(density.size > 0 ? density.size : *most / 16, box.lengths[d] / 2);
  if (density.through > 0) sizes.largest[least - box.lengths.begin()] = *least / density.through;
  return sizes;
}
Sizes sizes_of(const PlateShapeT<double>& plate, double extent, const MeshDensity& density) {
  double largest = density.size;
  if (!(largest > 0)) largest = extent / 10;
  const double through = density.through > 0 ? plate.thickness / density.through
                                             : std::min(plate.thickness, largest) / 2;
  return {{largest, largest, through}, true};
}
Sizes sizes_of(const NotchShapeT<double>& notch, double /*extent*/, const MeshDensity& density) {
  const int through = density.through > 0 ? density.through : 4;
  const auto inner = inner_halves(notch);
  const double height = notch.thickness + 2 * notch.depth, across = 2 * inner[0] / through;
  const double end = density.size > 0 ? density.size : std::min(height / 3, notch.end_length / 2);
  return {{end, across, notch.two_axes ? 2 * inner[1] / through : notch.width / (1.5 * through)},
          false,
          1.0 / through};
}

/// A plane that lines are put on.
struct Plane {
  int key;      ///< the first of those that are there
  double at;    ///< [m]
  double size;  ///< wanted of the elements beside it
};

/// The planes across an axis, ascending. `wanted`: sizes beside each.
std::vector<Plane> distinct_planes(const std::vector<double>& places,
                                   const std::vector<double>& wanted, double tolerance) {
  std::vector<int> order(places.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return places[a] < places[b]; });
  std::vector<Plane> planes;
  for (const int key : order) {
    if (planes.empty() || places[key] > planes.back().at + tolerance)
      planes.push_back({key, places[key], wanted[key]});
    else
      planes.back() = {std::min(key, planes.back().key), planes.back().at,
                       std::min(wanted[key], planes.back().size)};
  }
  return planes;
}

/// Sizes wanted beside the planes of patches: `small` at its sides and below it, where a rigid
/// patch ends in a singular stress, or half of a patch that is small itself. A side needs none at
/// the edge of the body, nor where the strip beside it is narrower than a quarter of the patch and
/// carries little; below a patch that has no other, a fifth of its smaller side will do.
/// Infinite for planes of the shape.
std::array<std::vector<double>, 3> sizes_at_patches(const PlanesT<double>& planes, double root,
                                                    double small, double tolerance) {
  std::array<std::vector<double>, 3> wanted;
  for (int d = 0; d < 3; ++d) wanted[d].assign(planes.at[d].size(), INFINITY);
  const int patches = (static_cast<int>(planes.at[0].size()) - planes.of_shape[0]) / 2;
  for (int p = 0; p < patches; ++p) {
    Vector3d width;
    for (int d = 0; d < 3; ++d) {
      const double* sides = &planes.at[d][planes.of_shape[d] + 2 * p];
      width[d] = sides[1] > sides[0] + tolerance ? sides[1] - sides[0] : INFINITY;
    }
    bool has_rim = false;
    for (int d = 0; d < 3; ++d) {
      const auto first = planes.at[d].begin(), last = first + planes.of_shape[d];
      const auto [low, high] = std::minmax_element(first, last);
      for (int side = 0; side < 2; ++side) {
        const int key = planes.of_shape[d] + 2 * p + side;
        const double outside = std::min(planes.at[d][key] - *low, *high - planes.at[d][key]);
        const double strip = root > 0 ? tolerance : std::max(tolerance, width[d] / 4);
        if (width[d] == INFINITY || outside < strip) continue;
        has_rim = true;
        wanted[d][key] = root > 0 ? root : std::min(width[d] / 2, small);
      }
    }
    const double least = width.minCoeff(), fine = std::min(least / 2, small);
    for (int d = 0; d < 3; ++d)
      if (width[d] == INFINITY)
        for (const int side : {0, 1})
          wanted[d][planes.of_shape[d] + 2 * p + side] = root > 0  ? root
                                                         : has_rim ? fine
                                                                   : std::max(least / 5, fine);
  }
  return wanted;
}

/// Chooses the sizes of the elements beside planes.
void choose_sizes(std::vector<Plane>& planes, int of_shape, double largest, bool corners,
                  const MeshDensity& density) {
  std::vector<Plane*> of_corners;
  for (Plane& plane : planes)
    if (plane.key < of_shape) of_corners.push_back(&plane);
  for (std::size_t k = 1; corners && k + 1 < of_corners.size(); ++k) {
    const double gap = std::min(of_corners[k]->at - of_corners[k - 1]->at,
                                of_corners[k + 1]->at - of_corners[k]->at);
    of_corners[k]->size = std::min(of_corners[k]->size, std::max(gap / 4, largest / 8));
  }
  const double slope = std::log(density.growth);
  for (Plane& plane : planes) plane.size = std::min(largest, plane.size) * density.coarsening;
  for (std::size_t k = 1; k < planes.size(); ++k)
    planes[k].size =
        std::min(planes[k].size, planes[k - 1].size + slope * (planes[k].at - planes[k - 1].at));
  for (std::size_t k = planes.size() - 1; k-- > 0;)
    planes[k].size =
        std::min(planes[k].size, planes[k + 1].size + slope * (planes[k + 1].at - planes[k].at));
}

/// Lines on the planes and between them, middles of elements too.
std::vector<MeshLine> lines_on(const std::vector<Plane>& planes, const std::vector<double>& places,
                               int of_shape, double largest, const MeshDensity& density,
                               const std::vector<MeshLine>& of_notch) {
  std::vector<MeshLine> lines;
  for (std::size_t k = 0; k + 1 < planes.size(); ++k) {
    const Plane &from = planes[k], &to = planes[k + 1];
    const double middle = (from.at + to.at) / 2, length = to.at - from.at;
    lines.push_back({from.key, from.key});
    if (!of_notch.empty() && from.at < 0 && to.at > 0) {
      lines.insert(lines.end(), of_notch.begin(), of_notch.end());
      continue;
    }
    double most = largest;  // two elements in a patch
    for (std::size_t p = of_shape; p < places.size(); p += 2)
      if (places[p] < middle && middle < places[p + 1])
        most = std::min(most, (places[p + 1] - places[p]) / 2);
    most *= density.coarsening;
    if (planes.size() == 2) most = std::min(most, length / 2);  // one element alone can fold
    const auto graded = graded_lines(length, from.size, to.size, most, density.growth);
    for (std::size_t n = 1; n < graded.size(); ++n) {
      lines.push_back({from.key, to.key, (graded[n - 1] + graded[n]) / 2 / length});
      if (n + 1 < graded.size()) lines.push_back({from.key, to.key, graded[n] / length});
    }
  }
  lines.push_back({planes.back().key, planes.back().key});
  return lines;
}

}  // namespace

template <class S>
PlanesT<S> planes_of(const SolidShapeT<S>& shape, const std::vector<PatchT<S>>& patches) {
  using std::abs;
  PlanesT<S> planes;
  std::visit([&](const auto& kind) { add_planes(kind, planes); }, shape);
  for (int d = 0; d < 3; ++d) {
    planes.of_shape[d] = static_cast<int>(planes.at[d].size());
    for (const PatchT<S>& patch : patches) {
      const S half = abs(patch.half_u[d]) + abs(patch.half_v[d]);
      planes.at[d].push_back(patch.center[d] - half);
      planes.at[d].push_back(patch.center[d] + half);
    }
  }
  return planes;
}
template PlanesT<double> planes_of(const SolidShapeT<double>&, const std::vector<PatchT<double>>&);
template PlanesT<Dual1> planes_of(const SolidShapeT<Dual1>&, const std::vector<PatchT<Dual1>>&);

bool is_within(const SolidShapeT<double>& shape, const Vector3d& place) {
  return std::visit([&](const auto& kind) { return is_within(kind, place); }, shape);
}

MeshLines plan_lines(const SolidShapeT<double>& shape, const PlanesT<double>& planes, double extent,
                     const MeshDensity& density) {
  const auto* notch = std::get_if<NotchShapeT<double>>(&shape);
  const double tolerance = 1e-6 * extent;
  const Sizes sizes =
      std::visit([&](const auto& kind) { return sizes_of(kind, extent, density); }, shape);
  const auto wanted = sizes_at_patches(planes, density.root, extent / 200, tolerance);
  MeshLines lines;
  for (int d = 0; d < 3; ++d) {
    const int of_shape = planes.of_shape[d];
    std::vector<Plane> distinct = distinct_planes(planes.at[d], wanted[d], tolerance);
    choose_sizes(distinct, of_shape, sizes.largest[d], sizes.corners, density);
    std::vector<MeshLine> of_notch;
    if (notch && d == 0)
      of_notch = notch_lines(*notch, density.coarsening * sizes.share, density.growth);
    lines[d] = lines_on(distinct, planes.at[d], of_shape, sizes.largest[d], density, of_notch);
  }
  return lines;
}

template <class S>
LinePlacesT<S> places_of(const MeshLines& lines, const SolidShapeT<S>& shape,
                         const PlanesT<S>& planes) {
  const auto* notch = std::get_if<NotchShapeT<S>>(&shape);
  LinePlacesT<S> places;
  for (int d = 0; d < 3; ++d)
    for (const MeshLine& line : lines[d])
      if (line.side == 0) {
        const S &a = planes.at[d][line.from], &b = planes.at[d][line.to];
        places.at[d].push_back(a + line.at * (b - a));
        if (d == 0) places.narrower.push_back({S(1.0), S(1.0)});
      } else {
        const NotchPlaceT<S> place = notch_place(*notch, line.segment, line.at);
        const S missing = notch_end(*notch).rise - place.rise;
        const auto inner = inner_halves(*notch);
        places.at[0].push_back(double(line.side) * place.x);
        places.narrower.push_back(
            {S(1.0 - missing / inner[0]), notch->two_axes ? S(1.0 - missing / inner[1]) : S(1.0)});
      }
  return places;
}
template LinePlacesT<double> places_of(const MeshLines&, const SolidShapeT<double>&,
                                       const PlanesT<double>&);
template LinePlacesT<Dual1> places_of(const MeshLines&, const SolidShapeT<Dual1>&,
                                      const PlanesT<Dual1>&);

}  // namespace flexopt
