#include "core/math/lanczos.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "core/math/decompositions.hpp"

namespace flexopt {

MatrixXd start_columns(int n, int width, int seed) {
  MatrixXd start(n, width);
  for (int c = 0; c < width; ++c) {
    const int k = seed + c;
    for (int i = 0; i < n; ++i) start(i, c) = std::sin(1.0 + 1.7 * k + 12.9898 * i + 0.3 * k * i);
  }
  return start;
}

BlockKrylov::BlockKrylov(const MatrixXd& start, int most, LinearMap solve, LinearMap mass)
    : solve_(std::move(solve)),
      mass_(std::move(mass)),
      width_(static_cast<int>(start.cols())),
      most_(most),
      V_(start.rows(), 0),
      MV_(start.rows(), 0) {
  append(start);
}

bool BlockKrylov::extend() {
  const int first = columns_, block = block_;
  MatrixXd W = solve_(MV_.middleCols(first, block));
  columns_ += block;
  const MatrixXd H = append(std::move(W));
  T_.block(0, first, columns_, block) = H;
  T_.block(first, 0, block, columns_) = H.transpose();
  return block_ > 0;
}

void BlockKrylov::go_on(const MatrixXd& columns) { append(columns); }

MatrixXd BlockKrylov::T() const {
  const auto A = T_.topLeftCorner(columns_, columns_);
  return 0.5 * (A + A.transpose());
}

// W ← W − V Vᵀ M W, M-orthonormal: the next block. Gives the coefficients; what is left of W in
// the next block goes to rest_.
MatrixXd BlockKrylov::append(MatrixXd W) {
  const int k = columns_;
  MatrixXd H = MatrixXd::Zero(k, W.cols());
  // the last two blocks carry the coefficients; all others only rounding, removed in one pass
  for (const int first : {std::max(0, k - 3 * width_), 0}) {
    const int columns = k - first;
    const MatrixXd h = MV_.middleCols(first, columns).transpose() * W;
    W.noalias() -= V_.middleCols(first, columns) * h;
    H.bottomRows(columns) += h;
  }
  orthonormalise(W, H.colwise().squaredNorm());
  return H;
}

// Gram–Schmidt, the largest column first. What is left out is below 1e-12 of its column: a Gram
// matrix, whose rounding ends at 1e-8, would leave out more than the residual tells.
void BlockKrylov::orthonormalise(MatrixXd& W, const VectorXd& removed) {
  MatrixXd MW = mass_(W);
  const int columns = static_cast<int>(W.cols()), k = columns_, room = std::min(columns, most_ - k);
  if (k + room > V_.cols()) {
    const Eigen::Index more = std::min<Eigen::Index>(most_, std::max(8 * width_, 2 * k));
    V_.conservativeResize(W.rows(), more);
    MV_.conservativeResize(W.rows(), more);
    T_.conservativeResizeLike(MatrixXd::Zero(more, more));
  }
  VectorXd size = W.cwiseProduct(MW).colwise().sum();
  const VectorXd floor = 1e-24 * (size + removed);
  VectorXd known = size + removed;  // before anything cancelled
  rest_ = MatrixXd::Zero(columns, columns);
  std::vector<bool> done(columns, false);
  block_ = 0;
  while (block_ < room) {
    int next = -1;
    for (int c = 0; c < columns; ++c)
      if (!done[c] && size[c] > floor[c] && (next < 0 || size[c] > size[next])) next = c;
    if (next < 0) break;
    done[next] = true;
    // what is left of a column that cancelled: once more against all others
    while (size[next] < 1e-6 * known[next] && size[next] > floor[next]) {
      known[next] = size[next];
      const VectorXd h = MV_.leftCols(k + block_).transpose() * W.col(next);
      W.col(next).noalias() -= V_.leftCols(k + block_) * h;
      rest_.col(next).head(block_) += h.tail(block_);
      MW.col(next) = mass_(MatrixXd(W.col(next)));
      size[next] = W.col(next).dot(MW.col(next));
    }
    if (!(size[next] > floor[next])) continue;  // rounding alone
    const double norm = std::sqrt(size[next]);
    rest_(block_, next) = norm;
    V_.col(k + block_) = W.col(next) / norm;
    MV_.col(k + block_) = MW.col(next) / norm;
    for (int c = 0; c < columns; ++c) {
      if (done[c]) continue;
      const double h = MV_.col(k + block_).dot(W.col(c));
      rest_(block_, c) = h;
      W.col(c) -= h * V_.col(k + block_);
      MW.col(c) -= h * MV_.col(k + block_);
      size[c] = W.col(c).dot(MW.col(c));
    }
    ++block_;
  }
  // columns without room in the space count as what is left out, each for itself
  int rows = block_;
  for (int c = 0; c < columns; ++c)
    if (!done[c] && size[c] > floor[c]) rest_(rows++, c) = std::sqrt(size[c]);
  rest_.conservativeResize(rows, columns);
}

namespace {

LargestPairs largest_of(const SymmetricEigen& eigen, int count) {
  const VectorXd& theta = eigen.eigenvalues();
  std::vector<int> order(theta.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return std::abs(theta[a]) > std::abs(theta[b]); });
  order.resize(std::min<std::size_t>(order.size(), static_cast<std::size_t>(count)));
  return {theta(order), eigen.eigenvectors()(Eigen::all, order)};
}

// The lowest of the Ritz pairs in ascending order.
LowestPairs ascending(const BlockKrylov& krylov, const LargestPairs& ritz) {
  std::vector<int> order(static_cast<std::size_t>(ritz.values.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return 1 / ritz.values[a] < 1 / ritz.values[b]; });
  return {true, ritz.values(order).cwiseInverse(), krylov.V() * ritz.vectors(Eigen::all, order)};
}

}  // namespace

LargestPairs largest_pairs(const MatrixXd& A, int count) {
  return largest_of(SymmetricEigen(A), count);
}

LowestPairs lowest_pairs(int n, int count, int width, const LinearMap& solve, const LinearMap& mass,
                         double tolerance) {
  LowestPairs pairs;
  count = std::min(count, n);
  width = std::min(width, n);
  const bool single = width == 1;
  const int most = std::min(n, 6 * count + 20 * width + 40);
  const MatrixXd start = start_columns(n, width);
  BlockKrylov krylov(single ? start : solve(mass(start)), most, solve, mass);
  constexpr int most_fruitless = 3;
  int known = -1, fruitless = 0;
  for (int step = 1;; ++step) {
    const bool more = krylov.extend();
    if (!more && krylov.columns() < count) {
      // where nothing is left of other columns either, the rest is rounded away
      fruitless = krylov.columns() == known ? fruitless + 1 : 0;
      if (fruitless == most_fruitless) return pairs;
      known = krylov.columns();
      krylov.go_on(start_columns(n, width, step * width));
      continue;
    }
    // a decomposition costs about a solve: not at every step
    const int columns = krylov.columns();
    if (more &&
        (single ? columns < count || columns % 4 != 0 : columns < 3 * count || step % 2 != 0))
      continue;
    const MatrixXd T = krylov.T();
    const LargestPairs ritz =
        single ? largest_of(SymmetricEigen::of_tridiagonal(T.diagonal(), T.diagonal(-1)), count)
               : largest_pairs(T, count);
    const MatrixXd& B = krylov.rest();
    const VectorXd residual = (B * ritz.vectors.bottomRows(B.cols())).colwise().norm();
    pairs.converged = more ? (residual.array() <= tolerance * ritz.values.array().abs()).all()
                           : krylov.invariant();
    if (more && !pairs.converged) continue;
    if (single) {
      LowestPairs found = ascending(krylov, ritz);
      found.converged = pairs.converged && ritz.values.allFinite();
      return found;
    }
    // Rayleigh–Ritz on Y = K⁻¹ M X:  (Yᵀ M X) z = λ⁻¹… with Yᵀ K Y = Yᵀ M X
    const MatrixXd MX = krylov.MV() * ritz.vectors, Y = solve(MX), MY = mass(Y);
    const MatrixXd KY = Y.transpose() * MX, G = Y.transpose() * MY;
    const SymmetricEigen last(0.5 * (KY + KY.transpose()), 0.5 * (G + G.transpose()));
    // eigenvalues are known to the rounding of the largest, quotients each to its own
    const MatrixXd& Z = last.eigenvectors();
    const VectorXd quotients =
        Z.cwiseProduct(KY * Z).colwise().sum().cwiseQuotient(Z.cwiseProduct(G * Z).colwise().sum());
    std::vector<int> order(static_cast<std::size_t>(quotients.size()));
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int k) { return quotients[k]; });
    pairs.values = quotients(order);
    pairs.vectors = Y * Z(Eigen::all, order);
    pairs.converged &= pairs.values.allFinite() && pairs.vectors.allFinite();
    return pairs;
  }
}

namespace {

// Pairs of motions without mass, the size and the sign of which are rounding, go.
void leave_out_massless(LowestPairs& pairs) {
  constexpr double nothing = 1e-12;  // of the largest 1/λ
  const VectorXd size = pairs.values.cwiseAbs();
  std::vector<int> kept;
  for (int k = 0; k < size.size(); ++k)
    if (size.minCoeff() > nothing * size[k]) kept.push_back(k);
  if (kept.size() == static_cast<std::size_t>(size.size())) return;
  pairs.values = pairs.values(kept).eval();
  pairs.vectors = pairs.vectors(Eigen::all, kept).eval();
}

}  // namespace

LowestPairs lowest_modes(int n, const ModesWanted& wanted, const LinearMap& solve,
                         const LinearMap& mass) {
  assert(!(wanted.in_pairs && wanted.massless));
  const int width = wanted.in_pairs ? 2 : 1;
  int kept = std::min(n, wanted.count + wanted.negative);
  LowestPairs pairs;
  for (int asked = std::min(n, kept + width - 1);; asked = std::min(n, 2 * asked)) {
    pairs = lowest_pairs(n, asked, width, solve, mass, wanted.tolerance);
    if (!pairs.converged) return {};
    if (wanted.massless) leave_out_massless(pairs);
    const auto negative = (pairs.values.array() < 0).count();  // those of large magnitude come late
    if (negative >= wanted.negative || asked == n || wanted.massless) break;
  }
  const VectorXd& lambda = pairs.values;
  kept = std::min(kept, static_cast<int>(lambda.size()));
  constexpr double equal = 1e-6;  // vectors known to 1e-7 mix those of nearer values
  if (wanted.in_pairs && kept > 0 && kept < lambda.size() &&
      lambda[kept] - lambda[kept - 1] < equal * std::abs(lambda[kept]))
    ++kept;
  pairs.values = pairs.values.head(kept).eval();
  pairs.vectors = pairs.vectors.leftCols(kept).eval();
  return pairs;
}

}  // namespace flexopt
