#include "core/elements/plate/plate_leaf.hpp"

#include <cassert>
#include <utility>

#include "core/elements/plate/plate_fold.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

// Nodal vectors (r − t, r,x, r,y, r,xy) of an edge node: function k of node j.
std::array<Vector3d, 4> edge_vectors(const Matrix3d& axes, std::array<Vector3d, 4> v,
                                     const std::vector<PlateMesh::EdgeSlope>& slopes,
                                     const double* a) {
  for (Vector3d& w : v) w = (axes * w).eval();
  for (const PlateMesh::EdgeSlope& s : slopes) v[s.function] += *a++ * axes.col(s.axis);
  return v;
}

}  // namespace

PlateLeaf::PlateLeaf(std::shared_ptr<const PlateMesh> mesh, PlateSupport support)
    : mesh_(std::move(mesh)), support_(std::move(support)) {
  const int n = mesh_->functions_per_line(), lines = mesh_->lines();
  std::vector<int> sizes(lines, 3 * n);
  const int m = mesh_->edge_unknowns();
  for (const int line : {0, lines - 1})
    if (is_rigid_edge(line)) sizes[line] = m;
  if (const int fold = mesh_->fold_line(); fold >= 0) {
    assert(!support_.free_tip && support_.point.empty());
    sizes[fold] = fold_unknowns();
    sizes.erase(sizes.begin() + fold + 1);
    for (int side = 0; side < 2; ++side) {
      fold_diagonal_[side].resize(3 * n, 3 * n);
      fold_below_[side].resize(3 * n, 3 * n);
    }
    fold_gap_ = MatrixXd::Zero(3 * n, 3 * n);
    fold_jacobian_ = MatrixXd::Zero(3 * n, fold_unknowns());
  }
  K_.resize(sizes);
  nodal_.assign(lines, MatrixXd::Zero(n, 3));
  nodal_force_.assign(lines, VectorXd::Zero(3 * n));
  points_.resize(mesh_->elements_along() * mesh_->elements_across());
  nodal_change_.assign(lines, MatrixXd::Zero(n, 3));
  for (int e = 0; e < 2; ++e) {
    edge_diagonal_[e].resize(3 * n, 3 * n);
    edge_below_[e].resize(3 * n, 3 * n);
    edge_jacobian_[e] = MatrixXd::Zero(3 * n, m + 6);
  }
  g_.resize(unknowns());
  coupling_ = MatrixXd::Zero(unknowns(), 12);
  set_state(undeflected(*mesh_, support_.free_tip));
  point_place_.setZero();
  for (const NodalWeight& w : support_.point)
    point_place_ += w.weight * nodal_[w.line].row(w.function).transpose();
}

PlateLeaf::State PlateLeaf::undeflected(const PlateMesh& mesh, bool free_tip) {
  const int n = mesh.functions_per_line(), lines = mesh.lines(), m = mesh.edge_unknowns();
  State state;
  state.edges = {mesh.line_pose(0), mesh.line_pose(lines - 1)};
  const int last = free_tip ? lines - 1 : lines - 2;  // the last line with nodal unknowns
  const int fold = mesh.fold_line(), own = 4 * mesh.nodes_per_line();
  const int nodal = fold < 0 ? last * 3 * n : (last - 1) * 3 * n + own;
  state.x = VectorXd::Zero(m + nodal + (free_tip ? 0 : m));
  int o = m;
  for (int i = 1; i <= last; ++i) {
    if (fold >= 0 && i == fold + 1) {
      o += own;
      continue;
    }
    state.x.segment(o, 3 * n) = mesh.undeflected(i).reshaped();
    o += 3 * n;
  }
  return state;
}

void PlateLeaf::set_clamps(const std::array<double, 2>& edges, double place) {
  if (edges == clamps_ && place == place_ratio_) return;
  clamps_ = edges;
  place_ratio_ = place;
  stress_is_linearised_ = false;
  update_nodal();
}

void PlateLeaf::set_state(const State& state) {
  assert(state.x.size() == unknowns());
  state_ = state;
  stress_is_linearised_ = false;
  update_nodal();
}

void PlateLeaf::step(const EdgePoses& edges, const VectorXd& dx, const Vector12d& dq,
                     const Vector3d& point, const Vector3d& df) {
  step_to({edges, state_.x + dx, point, state_.point_force + df}, dx, dq);
}

void PlateLeaf::step_to(const State& state, const VectorXd& dx, const Vector12d& dq) {
  assert(state.x.size() == unknowns());
  mesh_->with_side([&]<int Side>() { linearised_stress<Side>(dx, dq); });
  state_ = state;
  update_nodal();
}

std::array<Vector3d, 4> PlateLeaf::edge_reference(const PlateMesh& mesh, int line, int node,
                                                  double clamp) {
  std::array<Vector3d, 4> reference = mesh.reference_node(line, node);
  reference[0] *= clamp;
  reference[2] *= clamp;
  return reference;
}

MatrixXd PlateLeaf::edge_nodal(const PlateMesh& mesh, int edge, const EdgePose& pose,
                               const double* slopes, double clamp) {
  const int line = edge == 0 ? 0 : mesh.lines() - 1;
  MatrixXd nodal(mesh.functions_per_line(), 3);
  const int per_node = static_cast<int>(mesh.edge_slopes().size());
  for (int j = 0; j < mesh.nodes_per_line(); ++j) {
    const auto v = edge_vectors(pose.axes, edge_reference(mesh, line, j, clamp), mesh.edge_slopes(),
                                slopes + per_node * j);
    for (int k = 0; k < 4; ++k) nodal.row(4 * j + k) = v[k].transpose();
    nodal.row(4 * j) += pose.position.transpose();
  }
  return nodal;
}

void PlateLeaf::update_nodal() {
  const int n = mesh_->functions_per_line(), last = mesh_->lines() - 1;
  for (int i = 1; i <= last; ++i)
    if (!is_rigid_edge(i) && !is_second_of_fold(i))
      nodal_[i] = Eigen::Map<const MatrixXd>(state_.x.data() + block_offset(i), n, 3);
  if (const int fold = mesh_->fold_line(); fold >= 0) {
    const auto map = FoldMap<double>::of(mesh_->shape().fold->angle);
    nodal_[fold + 1] = nodal_[fold];
    for (int j = 0; j < mesh_->nodes_per_line(); ++j) {
      const auto own = map.value(
          FoldNode<double>::state(state_.x.segment(block_offset(fold), fold_unknowns()), n, j));
      nodal_[fold + 1].row(4 * j + 1) = own[0].transpose();
      nodal_[fold + 1].row(4 * j + 3) = own[1].transpose();
    }
  }
  for (int e = 0; e < 2; ++e) {
    const int line = e == 0 ? 0 : last;
    if (!is_rigid_edge(line)) continue;
    nodal_[line] =
        edge_nodal(*mesh_, e, state_.edges[e], state_.x.data() + block_offset(line), clamp(e));
  }
}

void PlateLeaf::assemble() {
  linearise();
  eliminate();
}

MatrixXd PlateLeaf::tangent_times(const MatrixXd& V) const { return K_.times(V); }

MatrixXd PlateLeaf::line_shapes() const {
  const int n3 = 3 * mesh_->functions_per_line(), inner = mesh_->lines() - 2;
  assert(!support_.free_tip && mesh_->fold_line() < 0);
  BlockTridiagonal K;
  K.resize(std::vector<int>(inner, n3));
  for (int i = 0; i < inner; ++i) {
    K.diagonal[i] = K_.diagonal[i + 1];
    if (i + 1 < inner) K.below[i] = K_.below[i + 1];
  }
  K.factorise();
  MatrixXd X = MatrixXd::Zero(inner * n3, 2 * n3);
  X.topLeftCorner(n3, n3) = -edge_below_[0];
  X.bottomRightCorner(n3, n3) = -edge_below_[1].transpose();
  K.solve(X);
  return X;
}

void PlateLeaf::eliminate() {
  const int last = mesh_->lines() - 1;
  K_.factorise();
  interior_.condense(K_, g_, coupling_, edge_force_, edge_tangent_, block(last - 1));
  if (has_point()) hold_point();
}

void PlateLeaf::hold_point() {
  const int n = mesh_->functions_per_line(), m = mesh_->edge_unknowns();
  CondensedInterior::Point point{.gradient = MatrixXd::Zero(unknowns(), 3),
                                 .edge_gradient = Eigen::Matrix<double, 3, 12>::Zero(),
                                 .missing = state_.point + place_ratio_ * point_place_,
                                 .force = state_.point_force};
  for (const NodalWeight& w : support_.point) {
    point.missing -= w.weight * nodal_[w.line].row(w.function).transpose();
    const int o = block_offset(w.line);
    for (int c = 0; c < 3; ++c) {
      if (!is_rigid_edge(w.line)) {
        point.gradient(o + c * n + w.function, c) += w.weight;
        continue;
      }
      const int e = edge_of(w.line);
      const auto J = edge_jacobian_[e].row(c * n + w.function);
      point.gradient.block(o, c, m, 1) += w.weight * J.head(m).transpose();
      point.edge_gradient.block<1, 6>(c, 6 * e) += w.weight * J.tail<6>();
    }
  }
  interior_.hold(K_, std::move(point));
}

}  // namespace flexopt
