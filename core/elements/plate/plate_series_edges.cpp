// Series of the nonlinear maps from the unknowns of a plate to its nodal values, at the edges and
// behind a fold, and their derivatives J and H of (S2).
#include "core/elements/plate/plate_fold.hpp"
#include "core/elements/plate/plate_series.hpp"

namespace flexopt {

void PlateSeries::expand_edge(int e, const EdgeBodySeries& body, const Series<VectorXd>& x) {
  const int n = mesh_->functions_per_line(), line = e == 0 ? 0 : mesh_->lines() - 1;
  const int m = offset_[line + 1] - offset_[line];
  const Series<Matrix3d>& R = axes_[e] = body.rotation;
  for (int o = 0; o < 3; ++o) {
    arm_[e][o].assign(n, Vector3d::Zero());
    J_[e][o] = MatrixXd::Zero(3 * n, m + 6);
  }
  for (int s = 0; s < n; ++s) {
    // the nodal vector in the axes of the edge: constants, and the free slopes
    const int k = s % 4;
    Series<Vector3d> w;
    for (Vector3d& c : w) c.setZero();
    w[0] = PlateLeaf::edge_reference(*mesh_, line, s / 4,
                                     plate_->clamp(e))[static_cast<std::size_t>(k)];
    if (k == 0) w[0] += body.arm;
    mesh_->each_slope(s, [&](int axis, int unknown) {
      for (int o = 0; o < 3; ++o) {
        w[o][axis] += x[o][offset_[line] + unknown];
        for (int c = 0; c < 3; ++c) J_[e][o](c * n + s, unknown) = R[o](c, axis);
      }
    });
    Series<Vector3d> v;
    for (Vector3d& c : v) c.setZero();
    add_product(v, R, w, [](const Matrix3d& a, const Vector3d& b) { return Vector3d(a * b); });
    for (int o = 0; o < 3; ++o) {
      arm_[e][o][s] = v[o];
      for (int c = 0; c < 3; ++c) {
        J_[e][o].block<1, 3>(c * n + s, m + 3) = v[o].cross(Vector3d::Unit(c)).transpose();
        if (k == 0 && o == 0) J_[e][0](c * n + s, m + c) = 1;
        nodal_[o][line][c * n + s] = v[o][c] + (k == 0 ? body.position[o][c] : 0.0);
      }
    }
  }
}

namespace {
Eigen::VectorX<Jet> fold_block(const Series<VectorXd>& x, int first, int size) {
  Series<VectorXd> part;
  for (int o = 0; o < 3; ++o) part[o] = x[o].segment(first, size);
  return jets(part);
}
}  // namespace

void PlateSeries::expand_fold(const Series<VectorXd>& x) {
  using Node = FoldNode<Jet>;
  const int n = mesh_->functions_per_line(), line = mesh_->fold_line() + 1,
            size = plate_->fold_unknowns();
  const auto map = FoldMap<Jet>::of(mesh_->shape().fold->angle);
  const Eigen::VectorX<Jet> block = fold_block(x, offset_[line], size);
  for (int o = 0; o < 3; ++o) {
    nodal_[o][line] = nodal_[o][line - 1];
    J_[fold][o] = MatrixXd::Zero(3 * n, size);
  }
  for (int j = 0; j < mesh_->nodes_per_line(); ++j) {
    const Node u = Node::state(block, n, j);
    const auto values = map.value(u);
    for (int c = 0; c < 3; ++c)
      for (const int k : {0, 2}) J_[fold][0](c * n + 4 * j + k, c * n + 4 * j + k) = 1;
    const auto put = [&](const FoldMap<Jet>::Pair& pair, const auto& to) {
      for (int p = 0; p < 2; ++p)
        for (int c = 0; c < 3; ++c)
          for (int o = 0; o < 3; ++o) to(o, c * n + 4 * j + 1 + 2 * p) = pair[p][c].c[o];
    };
    put(values, [&](int o, int row) -> double& { return nodal_[o][line][row]; });
    for (int k = 0; k < Node::unknowns; ++k)
      put(map.first(u, Node::unit(k)),
          [&](int o, int row) -> double& { return J_[fold][o](row, Node::row(k, n, j)); });
  }
}

void PlateSeries::expand_fold_curvature(const Series<VectorXd>& x) {
  using Node = FoldNode<Jet>;
  const int n = mesh_->functions_per_line(), line = mesh_->fold_line() + 1,
            size = plate_->fold_unknowns();
  const auto map = FoldMap<Jet>::of(mesh_->shape().fold->angle);
  const Eigen::VectorX<Jet> block = fold_block(x, offset_[line], size);
  for (int o = 0; o < 3; ++o) H_[fold][o] = MatrixXd::Zero(size, size);
  for (int j = 0; j < mesh_->nodes_per_line(); ++j) {
    const Node u = Node::state(block, n, j);
    for (int k = 0; k < Node::unknowns; ++k)
      for (int l = 0; l <= k; ++l) {
        const auto twice = map.second(u, Node::unit(k), Node::unit(l));
        Jet sum;
        for (int p = 0; p < 2; ++p)
          for (int c = 0; c < 3; ++c) {
            const int row = c * n + 4 * j + 1 + 2 * p;
            sum +=
                Jet(force_[0][line][row], force_[1][line][row], force_[2][line][row]) * twice[p][c];
          }
        const int a = Node::row(k, n, j), b = Node::row(l, n, j);
        for (int o = 0; o < 3; ++o) H_[fold][o](a, b) = H_[fold][o](b, a) = sum.c[o];
      }
  }
}

void PlateSeries::expand_edge_curvature(int e) {
  const int n = mesh_->functions_per_line(), line = e == 0 ? 0 : mesh_->lines() - 1;
  const int m = offset_[line + 1] - offset_[line];
  for (int o = 0; o < 3; ++o) H_[e][o] = MatrixXd::Zero(m + 6, m + 6);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; i + j < 3; ++j) {
      MatrixXd& H = H_[e][i + j];
      for (int s = 0; s < n; ++s) {
        const VectorXd& F = force_[i][line];
        const Vector3d f(F[s], F[n + s], F[2 * n + s]), &v = arm_[e][j][s];
        H.bottomRightCorner<3, 3>() +=
            0.5 * (f * v.transpose() + v * f.transpose()) - f.dot(v) * Matrix3d::Identity();
        mesh_->each_slope(s, [&](int axis, int unknown) {
          const Vector3d row = axes_[e][j].col(axis).cross(f);
          H.block<3, 1>(m + 3, unknown) += row;
          H.block<1, 3>(unknown, m + 3) += row.transpose();
        });
      }
    }
}

}  // namespace flexopt
