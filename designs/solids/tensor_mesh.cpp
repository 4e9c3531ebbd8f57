// Structured hexahedra between planes across the own axes: planes of the shape, planes at the sides
// of patches, and graded ones between. A notch is a box whose planes follow the contour.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "designs/solids/mesh_plan.hpp"
#include "designs/solids/notch_mesh.hpp"

namespace flexopt {

namespace {

template <class S>
using Planes = std::array<std::vector<S>, 3>;

/// Half the height and width of what the notch leaves at its ends.
template <class S>
std::array<S, 2> inner_halves(const NotchShapeT<S>& notch) {
  const S rise = notch_end(notch).rise;
  return {0.5 * notch.thickness + rise,
          0.5 * notch.width - (notch.two_axes ? S(notch.depth - rise) : S(0.0))};
}

template <class S>
void add_planes(const BoxShapeT<S>& box, Planes<S>& planes) {
  for (int d = 0; d < 3; ++d) planes[d] = {-0.5 * box.lengths[d], 0.5 * box.lengths[d]};
}
template <class S>
void add_planes(const PlateShapeT<S>& plate, Planes<S>& planes) {
  const auto add = [&](const ContourT<S>& contour) {
    for (const auto& corner : contour)
      for (int d = 0; d < 2; ++d) planes[d].push_back(corner.at[d]);
  };
  add(plate.outline);
  for (const auto& window : plate.windows) add(window);
  planes[2] = {-0.5 * plate.thickness, 0.5 * plate.thickness};
}
template <class S>
void add_planes(const NotchShapeT<S>& notch, Planes<S>& planes) {
  const S end = notch.half_length + notch.end_length, half = 0.5 * notch.thickness + notch.depth;
  const auto inner = inner_halves(notch);
  planes[0] = {-end, -notch.half_length, notch.half_length, end};
  planes[1] = {-half, -inner[0], inner[0], half};
  planes[2] = {-0.5 * notch.width, -inner[1], inner[1], 0.5 * notch.width};
}

/// Places of the planes of the shape, then of both sides of each patch: the same order always.
template <class S>
Planes<S> planes_of(const SolidShapeT<S>& shape, const std::vector<PatchT<S>>& patches) {
  using std::abs;
  Planes<S> planes;
  std::visit([&](const auto& kind) { add_planes(kind, planes); }, shape);
  for (const PatchT<S>& patch : patches)
    for (int d = 0; d < 3; ++d) {
      const S half = abs(patch.half_u[d]) + abs(patch.half_v[d]);
      planes[d].push_back(patch.center[d] - half);
      planes[d].push_back(patch.center[d] + half);
    }
  return planes;
}

using Lines = std::array<std::vector<MeshLine>, 3>;

struct TensorPlacing final : SolidPlan::Placing {
  Lines lines;                         ///< of nodes, middles of elements between
  std::vector<std::array<int, 3>> at;  ///< lines of each node

  template <class S>
  std::vector<Vector3<S>> place(const SolidShapeT<S>& shape,
                                const std::vector<PatchT<S>>& patches) const {
    const Planes<S> planes = planes_of(shape, patches);
    const auto* notch = std::get_if<NotchShapeT<S>>(&shape);
    Planes<S> places;
    std::array<std::vector<S>, 3> narrower;  // sizes over those of the notch's end, by line of x
    for (int d = 0; d < 3; ++d)
      for (const MeshLine& line : lines[d]) {
        if (line.side == 0) {
          const S &a = planes[d][line.from], &b = planes[d][line.to];
          places[d].push_back(a + line.at * (b - a));
          if (d == 0) narrower[1].push_back(S(1.0)), narrower[2].push_back(S(1.0));
        } else {
          const NotchPlaceT<S> place = notch_place(*notch, line.segment, line.at);
          const S missing = notch_end(*notch).rise - place.rise;
          const auto inner = inner_halves(*notch);
          places[0].push_back(double(line.side) * place.x);
          narrower[1].push_back(1.0 - missing / inner[0]);
          narrower[2].push_back(notch->two_axes ? S(1.0 - missing / inner[1]) : S(1.0));
        }
      }
    std::vector<Vector3<S>> nodes(at.size());
    for (std::size_t n = 0; n < at.size(); ++n) {
      const auto [i, j, k] = at[n];
      nodes[n] = {places[0][i], places[1][j] * narrower[1][i], places[2][k] * narrower[2][i]};
    }
    return nodes;
  }
  std::vector<Vector3d> nodes(const SolidShapeT<double>& shape,
                              const std::vector<PatchT<double>>& patches) const override {
    return place(shape, patches);
  }
  std::vector<Vector3<Dual1>> nodes(const SolidShapeT<Dual1>& shape,
                                    const std::vector<PatchT<Dual1>>& patches) const override {
    return place(shape, patches);
  }
};

bool is_within(const ContourT<double>& contour, double x, double y) {
  bool within = false;
  for (std::size_t c = 0; c < contour.size(); ++c) {
    const auto &a = contour[c].at, &b = contour[(c + 1) % contour.size()].at;
    if ((a[1] > y) != (b[1] > y) && x < a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]))
      within = !within;
  }
  return within;
}

/// Whether a place is in the material; of a notch, in the box that it is mapped from.
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

Check check_shape(const BoxShapeT<double>& box) {
  if (!(*std::min_element(box.lengths.begin(), box.lengths.end()) > 0))
    return Because("the lengths of a box must be positive");
  return {};
}
Check check_shape(const PlateShapeT<double>& plate) {
  if (!(plate.thickness > 0)) return Because("the thickness of a plate must be positive");
  return {};
}
Check check_shape(const NotchShapeT<double>& notch) { return check_notch(notch); }

/// Largest sizes of elements along the axes [m].
struct Sizes {
  std::array<double, 3> largest;
  bool corners = false;  ///< smaller ones at the planes of the shape between the outer ones
};

Sizes sizes_of(const BoxShapeT<double>& box, const MeshDensity& density) {
  const auto [least, most] = std::minmax_element(box.lengths.begin(), box.lengths.end());
  Sizes sizes;
  for (int d = 0; d < 3; ++d)
    sizes.largest[d] = std::min(density.size > 0 ? density.size : *most / 10, box.lengths[d] / 2);
  if (density.through > 0) sizes.largest[least - box.lengths.begin()] = *least / density.through;
  return sizes;
}
Sizes sizes_of(const PlateShapeT<double>& plate, const MeshDensity& density) {
  double largest = density.size;
  if (!(largest > 0)) {
    Eigen::Array2d low = Eigen::Array2d::Constant(INFINITY), high = -low;
    for (const auto& corner : plate.outline) {
      low = low.min(Eigen::Array2d(corner.at[0], corner.at[1]));
      high = high.max(Eigen::Array2d(corner.at[0], corner.at[1]));
    }
    largest = (high - low).maxCoeff() / 10;
  }
  const int through = density.through > 0 ? density.through : 2;
  return {{largest, largest, plate.thickness / through}, true};
}
Sizes sizes_of(const NotchShapeT<double>& notch, const MeshDensity& density) {
  const int through = density.through > 0 ? density.through : 4;
  const auto inner = inner_halves(notch);
  const double height = notch.thickness + 2 * notch.depth, across = 2 * inner[0] / through;
  const double end = density.size > 0 ? density.size : height / 3;
  return {{end, across, notch.two_axes ? 2 * inner[1] / through : notch.width / 6}, false};
}

/// A plane that lines are put on.
struct Plane {
  int key;      ///< the first of those that are there
  double at;    ///< [m]
  double size;  ///< wanted of the elements beside it
};

/// The planes across axis `d`, ascending.
std::vector<Plane> distinct_planes(const std::vector<double>& places, std::size_t of_shape,
                                   double largest, bool corners, const MeshDensity& density,
                                   double tolerance) {
  std::vector<int> order(places.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return places[a] < places[b]; });
  std::vector<Plane> planes;
  for (const int key : order) {
    double size = largest;
    if (key >= int(of_shape)) {
      const int low = key - (key - int(of_shape)) % 2;
      const double width = places[low + 1] - places[low];
      if (width > tolerance) size = density.root > 0 ? density.root : width / 3;
    }
    if (planes.empty() || places[key] > planes.back().at + tolerance) {
      planes.push_back({key, places[key], size});
    } else {
      planes.back().size = std::min(planes.back().size, size);
      if (key < planes.back().key) planes.back().key = key, planes.back().at = places[key];
    }
  }
  planes.front().size = planes.back().size = largest;
  std::vector<Plane*> of_corners;
  for (Plane& plane : planes)
    if (plane.key < int(of_shape)) of_corners.push_back(&plane);
  for (std::size_t k = 1; corners && k + 1 < of_corners.size(); ++k) {
    const double gap = std::min(of_corners[k]->at - of_corners[k - 1]->at,
                                of_corners[k + 1]->at - of_corners[k]->at);
    of_corners[k]->size = std::min(of_corners[k]->size, std::max(gap / 4, largest / 8));
  }
  return planes;
}

}  // namespace

}  // namespace flexopt
