// Which mesher plans a shape, and what the meshers share.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "designs/solids/mesh_plan.hpp"

namespace flexopt {

namespace {

/// Whether structured hexahedra fill the plate: contours of lines along x and y.
bool is_rectilinear(const PlateShapeT<double>& plate) {
  const auto fits = [](const ContourT<double>& contour) {
    for (std::size_t c = 0; c < contour.size(); ++c) {
      const auto& from = contour[c].at;
      const auto& to = contour[(c + 1) % contour.size()].at;
      const double x = std::abs(to[0] - from[0]), y = std::abs(to[1] - from[1]);
      if (contour[c].fillet > 0 || contour[c].through || std::min(x, y) > 1e-9 * std::max(x, y))
        return false;
    }
    return true;
  };
  return plate.holes.empty() && fits(plate.outline) &&
         std::all_of(plate.windows.begin(), plate.windows.end(), fits);
}

}  // namespace

Answer<SolidPlan> plan_mesh(const SolidShapeT<double>& nominal,
                            const std::vector<PatchT<double>>& patches,
                            const MeshDensity& density) {
  const auto* plate = std::get_if<PlateShapeT<double>>(&nominal);
  Answer<SolidPlan> plan = plate && !is_rectilinear(*plate)
                               ? plan_contour_mesh(*plate, patches, density)
                               : plan_tensor_mesh(nominal, patches, density);
  if (!plan) return plan;
  if (const Check check = check_patches(patches, *plan, place_nodes(*plan, nominal, patches));
      !check)
    return Because(check.error());
  return plan;
}

template <class S>
std::vector<Vector3<S>> place_nodes(const SolidPlan& plan, const SolidShapeT<S>& shape,
                                    const std::vector<PatchT<S>>& patches) {
  return plan.placing->nodes(shape, patches);
}
template std::vector<Vector3d> place_nodes(const SolidPlan&, const SolidShapeT<double>&,
                                           const std::vector<PatchT<double>>&);
template std::vector<Vector3<Dual1>> place_nodes(const SolidPlan&, const SolidShapeT<Dual1>&,
                                                 const std::vector<PatchT<Dual1>>&);

SolidCells mirrored(const SolidCells& cells) {
  static const std::vector<int> order[] = {
      {4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19},
      {3, 4, 5, 0, 1, 2, 9, 10, 11, 6, 7, 8, 12, 13, 14},
      {1, 0, 2, 3, 4, 6, 5, 8, 7, 9}};
  SolidCells turned = cells;
  for (std::size_t b = 0; b < cells.blocks.size(); ++b) {
    const auto& from = cells.blocks[b];
    const auto& place = order[static_cast<int>(from.cell)];
    for (std::size_t k = 0; k < from.nodes.size(); ++k)
      turned.blocks[b].nodes[k] =
          from.nodes[k - k % place.size() + static_cast<std::size_t>(place[k % place.size()])];
  }
  return turned;
}

std::vector<double> graded_lines(double length, double first, double last, double largest,
                                 double growth) {
  // The wanted size is min(a + s x, largest, b + s (length − x)), s = log(growth): elements of size
  // ratio `growth` where it grows. Boundaries are at equal steps of the integral of 1/size.
  const double s = std::log(std::max(growth, 1.01));
  double a = std::min(first, largest), b = std::min(last, largest);
  a = std::min(a, b + s * length);
  b = std::min(b, a + s * length);
  const double top = std::min(largest, (a + b + s * length) / 2);
  const double rise = (top - a) / s, up = std::log(top / a) / s, down = std::log(top / b) / s;
  const double flat = std::max(0.0, length - rise - (top - b) / s) / top;
  const double total = up + flat + down;
  const int count = std::max(1, static_cast<int>(std::lround(std::min(total, 1e4))));
  std::vector<double> lines(count + 1, 0.0);
  for (int i = 1; i < count; ++i) {
    const double n = total * i / count;
    lines[i] = n < up          ? a * std::expm1(s * n) / s
               : n < up + flat ? rise + (n - up) * top
                               : length - b * std::expm1(s * (total - n)) / s;
  }
  lines[count] = length;
  return lines;
}

Check check_patches(const std::vector<PatchT<double>>& patches, const SolidPlan& plan,
                    const std::vector<Vector3d>& nodes) {
  std::vector<int> holder(nodes.size(), -1);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const auto& held = plan.patches[p];
    double area = 0;
    for (const int k : held) {
      if (holder[k] >= 0)
        return Because(fmt::format("the patches of {} and {} overlap or touch each other",
                                   patches[holder[k]].name, patches[p].name));
      holder[k] = static_cast<int>(p);
      area = std::max(
          area, (nodes[k] - nodes[held[0]]).cross(nodes[held.back()] - nodes[held[0]]).norm());
    }
    const double length = held.empty() ? 0 : (nodes[held.back()] - nodes[held[0]]).norm();
    if (area <= 1e-6 * length * length)
      return Because(
          fmt::format("the patch of {} holds fewer than three nodes off a line", patches[p].name));
  }
  return {};
}

}  // namespace flexopt
