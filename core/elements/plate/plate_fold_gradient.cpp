// The line behind an elastic fold in exact gradients: its nodal values are functions of the
// unknowns that are not linear, (E8) of core/elements/README.md, and change with the fold's angle.
#include "core/elements/plate/plate_fold.hpp"
#include "core/elements/plate/plate_gradient.hpp"

namespace flexopt {

namespace {
// Product of the forces on the r,x and r,xy of node j, column k, with `moved`.
template <class S>
S fold_product(const Eigen::MatrixX<S>& force, int j, int k,
               const std::array<Vector3<S>, 2>& moved) {
  S sum(0);
  for (int p = 0; p < 2; ++p)
    for (int c = 0; c < 3; ++c) sum += force(4 * j + 1 + 2 * p, 3 * k + c) * moved[p][c];
  return sum;
}
}  // namespace

template <class S>
void PlateGradient<S>::add_fold_rows(const Matrix& nodal, Matrix& rows) const {
  const int n = mesh_->functions_per_line(), columns = static_cast<int>(rows.cols()),
            first = plate_->block_offset(mesh_->fold_line());
  const auto map = FoldMap<S>::of(mesh_->shape().fold->angle);
  for (int j = 0; j < mesh_->nodes_per_line(); ++j) {
    const auto u = FoldNode<S>::state(fold_block(state_.x), n, j);
    for (const int s : {4 * j, 4 * j + 2})
      for (int k = 0; k < columns; ++k)
        for (int c = 0; c < 3; ++c) rows(first + c * n + s, k) += nodal(s, 3 * k + c);
    for (int unknown = 0; unknown < FoldNode<S>::unknowns; ++unknown) {
      const auto moved = map.first(u, FoldNode<S>::unit(unknown));
      for (int k = 0; k < columns; ++k)
        rows(first + FoldNode<S>::row(unknown, n, j), k) += fold_product(nodal, j, k, moved);
    }
  }
}

template <class S>
void PlateGradient<S>::set_fold_rates(const Matrix& Y, Matrix& N) const {
  const int n = mesh_->functions_per_line();
  const auto map = FoldMap<S>::of(mesh_->shape().fold->angle);
  for (int j = 0; j < mesh_->nodes_per_line(); ++j) {
    const auto u = FoldNode<S>::state(fold_block(state_.x), n, j);
    for (int k = 0; k < static_cast<int>(Y.cols()); ++k) {
      const auto moved = map.first(u, FoldNode<S>::of(fold_block(Y.col(k)), n, j));
      for (int p = 0; p < 2; ++p)
        N.template block<1, 3>(4 * j + 1 + 2 * p, 3 * k) = moved[p].transpose();
    }
  }
}

template <class S>
double PlateGradient<S>::fold_rate(const LeafVariation<S>& v) const {
  double rate = 0;
  for (int p = 0; p < directions(); ++p) rate += v.shape[p] * rate_->direction[p].fold.angle;
  return rate;
}

template <class S>
auto PlateGradient<S>::fold_nodal_rates(const std::vector<LeafVariation<S>>& variations) const
    -> Matrix {
  const int n = mesh_->functions_per_line(), columns = static_cast<int>(variations.size());
  Matrix rates = Matrix::Zero(n, 3 * columns);
  if (mesh_->fold_line() < 0) return rates;
  const auto opened = FoldMap<S>::rate(mesh_->shape().fold->angle);
  for (int j = 0; j < mesh_->nodes_per_line(); ++j) {
    const auto nodal = opened.value(FoldNode<S>::state(fold_block(state_.x), n, j));
    for (int k = 0; k < columns; ++k)
      for (int p = 0; p < 2; ++p)
        rates.template block<1, 3>(4 * j + 1 + 2 * p, 3 * k) =
            S(fold_rate(variations[k])) * nodal[p].transpose();
  }
  return rates;
}

// N2 = N2,uu y y behind the fold.
template <class S>
void PlateGradient<S>::add_fold_second(const Matrix& Y, std::vector<Matrix>& N2,
                                       std::vector<Matrix>& n1) const {
  const int line = mesh_->fold_line() + 1, n = mesh_->functions_per_line(),
            columns = static_cast<int>(Y.cols());
  if (line == 0) return;
  const auto map = FoldMap<S>::of(mesh_->shape().fold->angle);
  n1[line] = N2[line] = Matrix::Zero(n, 3 * columns);
  for (int j = 0; j < mesh_->nodes_per_line(); ++j) {
    const auto u = FoldNode<S>::state(fold_block(state_.x), n, j);
    for (int k = 0; k < columns; ++k) {
      const auto y = FoldNode<S>::of(fold_block(Y.col(k)), n, j);
      const auto second = map.second(u, y, y);
      for (int p = 0; p < 2; ++p)
        N2[line].template block<1, 3>(4 * j + 1 + 2 * p, 3 * k) = second[p].transpose();
    }
  }
}

// What (N0, N1, N2) of the line behind the fold, (N, N,u y, N,uu y y), change by with the unknowns
// and with the angle of the fold.
template <class S>
void PlateGradient<S>::add_fold_quadratic(const Matrix& Y, const std::vector<Matrix>& n0,
                                          const std::vector<Matrix>& n1,
                                          LeafQuadratic<S>& q) const {
  const int line = mesh_->fold_line() + 1, n = mesh_->functions_per_line();
  if (line == 0) return;
  const double angle = mesh_->shape().fold->angle;
  const auto map = FoldMap<S>::of(angle), opened = FoldMap<S>::rate(angle);
  for (int k = 0; k < static_cast<int>(Y.cols()); ++k) {
    S by_angle(0);
    for (int j = 0; j < mesh_->nodes_per_line(); ++j) {
      const auto u = FoldNode<S>::state(fold_block(state_.x), n, j),
                 y = FoldNode<S>::of(fold_block(Y.col(k)), n, j);
      for (int unknown = 0; unknown < FoldNode<S>::unknowns; ++unknown) {
        const auto e = FoldNode<S>::unit(unknown);
        q.state(plate_->block_offset(line) + FoldNode<S>::row(unknown, n, j), k) +=
            fold_product(n1[line], j, k, map.second(u, y, e)) +
            fold_product(nodal_force_[line], j, 0, map.third(u, y, y, e));
      }
      by_angle += fold_product(n0[line], j, k, opened.value(u)) +
                  fold_product(n1[line], j, k, opened.first(u, y)) +
                  fold_product(nodal_force_[line], j, 0, opened.second(u, y, y));
    }
    for (int p = 0; p < q.shape.rows(); ++p)
      if (const double turn = rate_->direction[p].fold.angle; turn != 0)
        q.shape(p, k) += turn * by_angle;
  }
}

// The Jacobian of the map turns with the angle.
template <class S>
void PlateGradient<S>::add_fold_force_rates(const std::vector<LeafVariation<S>>& variations,
                                            Matrix& rows) const {
  const int line = mesh_->fold_line() + 1, n = mesh_->functions_per_line();
  if (line == 0) return;
  const auto opened = FoldMap<S>::rate(mesh_->shape().fold->angle);
  for (int j = 0; j < mesh_->nodes_per_line(); ++j) {
    const auto u = FoldNode<S>::state(fold_block(state_.x), n, j);
    for (int unknown = 0; unknown < FoldNode<S>::unknowns; ++unknown) {
      const S rate =
          fold_product(nodal_force_[line], j, 0, opened.first(u, FoldNode<S>::unit(unknown)));
      for (int k = 0; k < static_cast<int>(variations.size()); ++k)
        rows(plate_->block_offset(line) + FoldNode<S>::row(unknown, n, j), k) +=
            fold_rate(variations[static_cast<std::size_t>(k)]) * rate;
    }
  }
}

#define INSTANTIATE(S)                                                                          \
  template void PlateGradient<S>::add_fold_rows(const Matrix&, Matrix&) const;                  \
  template void PlateGradient<S>::set_fold_rates(const Matrix&, Matrix&) const;                 \
  template double PlateGradient<S>::fold_rate(const LeafVariation<S>&) const;                   \
  template PlateGradient<S>::Matrix PlateGradient<S>::fold_nodal_rates(                         \
      const std::vector<LeafVariation<S>>&) const;                                              \
  template void PlateGradient<S>::add_fold_second(const Matrix&, std::vector<Matrix>&,          \
                                                  std::vector<Matrix>&) const;                  \
  template void PlateGradient<S>::add_fold_quadratic(                                           \
      const Matrix&, const std::vector<Matrix>&, const std::vector<Matrix>&, LeafQuadratic<S>&) \
      const;                                                                                    \
  template void PlateGradient<S>::add_fold_force_rates(const std::vector<LeafVariation<S>>&,    \
                                                       Matrix&) const;
INSTANTIATE(double)
INSTANTIATE(Jet)
#undef INSTANTIATE

}  // namespace flexopt
