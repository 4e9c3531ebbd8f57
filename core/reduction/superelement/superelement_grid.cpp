#include "core/reduction/superelement/superelement_grid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/elements/plate/element_numbers.hpp"
#include "core/reduction/superelement/superelement_rule.hpp"

namespace flexopt {

int own_elements(int of_leaf, int superelements) {
  return std::max(4, (of_leaf + superelements - 1) / superelements);
}

namespace {

struct Local {
  int index;     ///< of the interval
  double place;  ///< in it, [0, 1]
};
Local locate(double s, int intervals) {
  const int i = std::clamp(static_cast<int>(s * intervals), 0, intervals - 1);
  return {i, s * intervals - i};
}

using Gradient = Eigen::Matrix<double, 16, 3>;

}  // namespace

SuperelementGrid::SuperelementGrid(const LeafSpring& leaf, const ModelOptions& model)
    : along_(model.superelements[0]),
      across_(model.superelements[1]),
      length_(leaf.length),
      width_(leaf.width),
      shape_(leaf_shape(leaf, model)),
      youngs_modulus_(leaf.material.youngs_modulus),
      density_(leaf.material.density),
      modes_((model.leaf_modes + elements() - 1) / elements()) {
  PlateBody body;
  body.plate = leaf;
  body.plate.length = length_ / along_;
  if (shape_.is_beam()) {
    const int elements = own_elements(model.mesh[0], along_);
    kinds_ = {std::make_shared<CondensedPlate>(condense_beam(
        body.plate, elements + elements % 2, along_ == 1 ? model.warping : Warping::free, modes_,
        model.transverse_shear))};
    return;
  }
  body.plate.width = width_ / rows();
  body.mesh = {own_elements(model.mesh[0], along_), own_elements(model.mesh[1], rows())};
  body.transverse_shear = model.transverse_shear;
  const bool edge = model.free_edge_torsion;
  body.interface = across_ == 0 ? Interface::rigid_edges : Interface::corners;
  body.vibration_modes = modes_;
  std::vector<std::array<bool, 2>> kinds{{edge, edge}};
  if (rows() > 1) kinds = {{edge, false}, {false, false}, {false, edge}};
  for (const auto& free_edges : kinds) {
    body.free_edges = free_edges;
    kinds_.push_back(std::make_shared<CondensedPlate>(condense(body)));
  }
}

std::shared_ptr<const PlateMesh> SuperelementGrid::full_mesh() const {
  std::call_once(full_mesh_made_, [&] { full_mesh_ = std::make_shared<PlateMesh>(shape_); });
  return full_mesh_;
}

int SuperelementGrid::kind(int row) const {
  if (rows() == 1) return 0;
  return row == 0 ? 0 : row == rows() - 1 ? 2 : 1;
}

bool SuperelementGrid::fits(const LeafSpring& leaf, const ModelOptions& model) const {
  return model.superelements == std::array{along_, across_} && alike(length_, leaf.length) &&
         alike(shape_, leaf_shape(leaf, model)) &&
         youngs_modulus_ == leaf.material.youngs_modulus && density_ == leaf.material.density &&
         modes_ == (model.leaf_modes + elements() - 1) / elements();
}

SuperelementGrid::Node SuperelementGrid::node(int element, int k) const {
  const int i = element / rows(), j = element % rows();
  if (across_ == 0) return {i + k, 0};
  return {i + k / 2, j + k % 2};  // (0, −), (0, +), (L, −), (L, +)
}

std::vector<MatrixXd> SuperelementGrid::displacements(const State& state, int e) const {
  const VectorXd dofs = model(e).recovery * *state.q[e];
  const PlateMesh& mesh = *plate(e).mesh;
  const Eigen::Index n = mesh.functions_per_line();
  std::vector<MatrixXd> nodal;
  for (int i = 0; i < mesh.lines(); ++i)
    nodal.push_back(dofs.segment(3 * n * i, 3 * n).reshaped(n, 3));
  return nodal;
}

namespace {

// Linear strains of a superelement of length `a` over L, its dofs over that length.
Strains linear_strains(const Gradient& U, const HermiteValues& X, const HermiteValues& Y, double a,
                       const Vector3d& turn) {
  const auto at = [&](const std::array<double, 4>& x, const std::array<double, 4>& y) {
    return Vector3d(U.transpose() * hermite_products(x, y));
  };
  const Vector3d d1 = at(X.slope, Y.value), d2 = at(X.value, Y.slope),
                 d11 = at(X.curvature, Y.value) - turn, d22 = at(X.value, Y.curvature),
                 d12 = at(X.slope, Y.slope);
  Strains e;
  e << d1[0], d2[1], d1[1] + d2[0], -d11[2] / a, -d22[2] / a, -2.0 * d12[2] / a;
  return e;
}

}  // namespace

StrainField SuperelementGrid::strains(const State& state) const {
  const PlateMesh& mesh = *kinds_[0]->mesh;
  const int nx = mesh.elements_along(), ny = mesh.elements_across();
  std::vector<double> across = stations_across();
  for (double& y : across) y = (y - 0.5) * shape_.width;
  std::vector<double> x = strain_stations(stations_along()), y = strain_stations(across);
  std::vector<Strains> values(x.size() * y.size());
  for (int e = 0; e < elements(); ++e) {
    const int i = e / rows(), j = e % rows();
    const std::vector<MatrixXd> nodal = displacements(state, e);
    for (int p = 0; p < nx; ++p)
      for (int q = 0; q < ny; ++q) {
        Gradient U;
        U << nodal[p].middleRows<8>(4 * q), nodal[p + 1].middleRows<8>(4 * q);
        const double hx = mesh.x()[p + 1] - mesh.x()[p], hy = mesh.y()[q + 1] - mesh.y()[q];
        for (int r = 0; r < 2; ++r)
          for (int s = 0; s < 2; ++s)
            values[(2 * (i * nx + p) + r) * y.size() + 2 * (j * ny + q) + s] =
                linear_strains(U, hermite(station[r], hx), hermite(station[s], hy), 1.0 / along_,
                               section_turn(mesh, p, q, U, station[r]));
      }
  }
  return {std::move(x), std::move(y), values};
}

SuperelementGrid::Point SuperelementGrid::locate(double along, double across) const {
  const Local i = flexopt::locate(along, along_), j = flexopt::locate(across, rows());
  return {i.index * rows() + j.index, i.place, j.place};
}

Vector3d SuperelementGrid::place(const State& state, double along, double across) const {
  const Point at = locate(along, across);
  const CondensedPlate& p = plate(at.element);
  const std::vector<MatrixXd> nodal = displacements(state, at.element);
  Vector3d r(at.along, (at.across - 0.5) * p.mesh->shape().width, 0);
  for (const NodalWeight& w : point_weights(*p.mesh, at.along, at.across))
    r += w.weight * nodal[w.line].row(w.function).transpose();
  const NodePose& frame = *state.frames[at.element];
  return frame.position + frame.axes * (p.scale.length * r - p.frame_point);
}

namespace {
std::vector<double> repeated(const std::vector<double>& points, int times) {
  const double first = points.front(), size = points.back() - first;
  std::vector<double> result{0};
  for (int k = 0; k < times; ++k)
    for (std::size_t i = 1; i < points.size(); ++i)
      result.push_back((k + (points[i] - first) / size) / times);
  return result;
}
}  // namespace

std::vector<double> SuperelementGrid::stations_along() const {
  return repeated(kinds_[0]->mesh->x(), along_);
}
std::vector<double> SuperelementGrid::stations_across() const {
  return repeated(kinds_[0]->mesh->y(), rows());
}

std::vector<NodeShare> point_shares(const LeafSpring& leaf, const SuperelementGrid& grid) {
  if (!leaf.point) return {};
  const int k = grid.nodes_per_line();
  std::vector<NodeShare> shares;
  if (leaf.point->spread_over_tip) {
    for (int j = 0; j < k; ++j) {
      const double share = k == 1 ? 1.0 : (j == 0 || j == k - 1 ? 0.5 : 1.0) / (k - 1);
      shares.push_back({{grid.lines() - 1, j}, share});
    }
  } else {
    const int line = node_at(leaf.point->along, grid.along()).value();
    const int node = k == 1 ? 0 : node_at(leaf.point->across, k - 1).value();
    shares.push_back({{line, node}, 1.0});
  }
  return shares;
}

}  // namespace flexopt
