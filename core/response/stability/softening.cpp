#include "core/response/stability/softening.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/math/decompositions.hpp"
#include "core/response/modes/mechanism_factor.hpp"

namespace flexopt {
namespace {

constexpr int most_vectors = 60;        // of a Krylov space
constexpr double enough_digits = 1e-6;  // of a root that a step is made by
constexpr int exact_vectors = 4;  // at each end that is wanted, whose forms are computed exactly

// No force on what is held, and nothing in the rows of conditions (joints, drives, material
// points): answers that keep them alone have a positive product with K.
VectorXd on_motions(const MechanismFactor& factor, MatrixXd column) {
  factor.clear_held(column);
  column.bottomRows(factor.conditions()).setZero();
  for (const MechanismFactor::Leaf& leaf : factor.leaves())
    column.middleRows(leaf.offset + leaf.rows.unknowns, leaf.rows.point).setZero();
  return column;
}

}  // namespace

StiffnessRate::StiffnessRate(const MechanismFactor& factor, DesignDirections& still,
                             const ModelOptions& model, const BodyLoad& named)
    : factor_(&factor), design_(design_rates(factor, still, model).value()), named_(named) {}

// Derivative by the state of yᵀK y of the leaves, column by column.
MatrixXd StiffnessRate::leaf_gradients_of(const MatrixXd& Y) const {
  MatrixXd forces = MatrixXd::Zero(factor_->size(), Y.cols());
  for (std::size_t i = 0; i < factor_->leaves().size(); ++i) {
    const MechanismFactor::Leaf& leaf = factor_->leaves()[i];
    const MatrixXd rows = factor_->leaf_rows(leaf, Y);
    factor_->add_leaf_force(leaf, leaf.linear->scale().energy,
                            design_.leaf(static_cast<int>(i)).state_rates(rows), forces);
  }
  return forces;
}

void StiffnessRate::set_direction(const VectorXd& state, double load) {
  state_ = state;
  load_ = load;
  size_ = state.norm();
  if (size_ == 0) return;
  scaled_state_ = state / size_;
  of_state_ = leaf_gradients_of(scaled_state_);
}

MatrixXd StiffnessRate::forms(const MatrixXd& Y) const {
  const Eigen::Index n = Y.cols();
  MatrixXd all(Y.rows(), n * (n + 1) / 2);
  all.leftCols(n) = Y;
  Eigen::Index column = n;
  for (Eigen::Index a = 0; a < n; ++a)
    for (Eigen::Index b = a + 1; b < n; ++b) all.col(column++) = Y.col(a) + Y.col(b);
  VectorXd q = design_.quadratic(all, VectorXd::Zero(all.cols()), state_);
  // growing forces on the present arms
  const Eigen::Index r = 6 * static_cast<Eigen::Index>(named_.body) + 3;
  const Vector3d arm = factor_->system().pose(named_.body).rotation * named_.arm;
  const Matrix3d K = load_ * arm_stiffness(named_.force, arm);
  for (Eigen::Index k = 0; k < all.cols(); ++k) {
    const Vector3d w = all.col(k).segment<3>(r);
    q[k] += w.dot(K * w);
  }
  MatrixXd T(n, n);
  column = n;
  for (Eigen::Index a = 0; a < n; ++a) T(a, a) = q[a];
  for (Eigen::Index a = 0; a < n; ++a)
    for (Eigen::Index b = a + 1; b < n; ++b, ++column)
      T(a, b) = T(b, a) = 0.5 * (q[column] - q[a] - q[b]);
  return T;
}

// The third derivative of the energy is symmetric: T(ẏ, y, ·) from the gradients of ẏ, y and ẏ + y.
VectorXd StiffnessRate::times(const VectorXd& y) const {
  VectorXd w = VectorXd::Zero(y.size());
  const double size = y.norm();
  if (size_ > 0 && size > 0) {
    MatrixXd both(y.size(), 2);
    both << y / size, y / size + scaled_state_;
    const MatrixXd g = leaf_gradients_of(both);
    w = 0.5 * size * size_ * (g.col(1) - g.col(0) - of_state_);
  }
  const auto spin = [](const VectorXd& v, int body) -> Vector3d {
    return v.segment<3>(6 * static_cast<Eigen::Index>(body) + 3);
  };
  const auto add_load = [&](const BodyLoad& load, const Vector3d& arm, double by) {
    w.segment<3>(6 * static_cast<Eigen::Index>(load.body) + 3) +=
        by * (arm_stiffness(load.force, arm) * spin(y, load.body));
  };
  const System& system = factor_->system();
  add_load(named_, system.pose(named_.body).rotation * named_.arm, load_);
  for (const BodyLoad& load : system.acting()) {
    const Vector3d arm = system.pose(load.body).rotation * load.arm;
    add_load(load, spin(state_, load.body).cross(arm), 1);
  }
  return on_motions(*factor_, std::move(w));
}

namespace {

// The first roots of either sign in a basis with YᵀK Y = 1, from exact forms.
Softening roots_in(const MatrixXd& Y, const StiffnessRate& rate) {
  Softening found;
  const SymmetricEigen eigen(rate.forms(Y));
  const VectorXd& values = eigen.eigenvalues();
  const Eigen::Index last = values.size() - 1;
  const double least = 1e-13 * values.cwiseAbs().maxCoeff();
  if (values[0] < -least) found.ahead = SoftMode{-1 / values[0], Y * eigen.eigenvectors().col(0)};
  if (values[last] > least)
    found.behind = SoftMode{-1 / values[last], Y * eigen.eigenvectors().col(last)};
  return found;
}

}  // namespace

VectorXd any_force(const MechanismFactor& factor) {
  VectorXd r(factor.size());
  unsigned long long seed = 1;
  for (Eigen::Index k = 0; k < r.rows(); ++k) {
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    r[k] = static_cast<double>(seed >> 33) / 2147483648.0 - 1;
  }
  return on_motions(factor, std::move(r));
}

// Lanczos with K⁻¹ dK/dσ in the product of K: of v = K⁻¹ r it is vᵀr.
Softening soften(const MechanismFactor& factor, const StiffnessRate& rate, bool drives_locked,
                 const VectorXd& start, bool behind) {
  const LinearMap solve = factor.solver(drives_locked);
  const Eigen::Index n = factor.size();
  const bool known = start.size() == n;
  VectorXd r = any_force(factor);
  if (known) {
    const VectorXd w = rate.times(start);
    if (w.norm() > 0) r = w / w.norm() + 1e-3 * r / r.norm();
  }
  const int most = std::min<int>(most_vectors, static_cast<int>(n));
  MatrixXd V(n, most), R(n, most), W(n, most), T(most, most);
  int count = 0;
  VectorXd values;
  MatrixXd vectors;
  double first_end = 0, last_end = 0;
  while (count < most) {
    VectorXd v = solve(r);
    for (int pass = 0; pass < 2; ++pass) {
      const VectorXd by = R.leftCols(count).transpose() * v;
      v.noalias() -= V.leftCols(count) * by;
      r.noalias() -= R.leftCols(count) * by;
    }
    const double size = v.dot(r);
    if (!(size > 1e-26 * std::abs(v.norm() * r.norm()))) break;
    V.col(count) = v / std::sqrt(size);
    R.col(count) = r / std::sqrt(size);
    r = rate.times(V.col(count));
    W.col(count) = r;
    const int last = count++;
    T.col(last).head(count) = 0.5 * (V.leftCols(count).transpose() * W.col(last) +
                                     W.leftCols(count).transpose() * V.col(last));
    T.row(last).head(count) = T.col(last).head(count).transpose();
    const SymmetricEigen eigen(T.topLeftCorner(count, count));
    values = eigen.eigenvalues();
    vectors = eigen.eigenvectors();
    // the ends of the spectrum that are wanted stand still
    const double rounding = 1e-9 * values.cwiseAbs().maxCoeff();
    const double enough =
        behind ? rounding : std::max(rounding, enough_digits * std::abs(values[0]));
    const bool still = std::abs(values[0] - first_end) < enough &&
                       (!behind || std::abs(values[last] - last_end) < enough);
    first_end = values[0];
    last_end = values[last];
    if (still && count >= (known ? 5 : 12)) break;
  }
  if (count == 0) return {};
  std::vector<int> wanted;
  for (int k = 0; k < std::min(exact_vectors, count); ++k) wanted.push_back(k);
  for (int k = std::max(count - exact_vectors, static_cast<int>(wanted.size()));
       behind && k < count; ++k)
    wanted.push_back(k);
  return roots_in(V.leftCols(count) * vectors(Eigen::all, wanted), rate);
}

}  // namespace flexopt
