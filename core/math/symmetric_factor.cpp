#include "core/math/symmetric_factor.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace flexopt {

// Chooses the row that becomes the last one of the next pivot, so that elements of L stay below
// 1/(1 − alpha).
Eigen::Index SymmetricFactor::choose(Eigen::Index k, int& size) const {
  const double alpha = (1 + std::sqrt(17.0)) / 8;
  const Eigen::Index n = L_.rows();
  const double here = std::abs(L_(k, k));
  size = 1;
  Eigen::Index r = k;
  double below = 0;
  for (Eigen::Index i = k + 1; i < n; ++i)
    if (std::abs(L_(i, k)) > below) {
      below = std::abs(L_(i, k));
      r = i;
    }
  if (!(here < alpha * below)) return k;  // where nothing is a number, too
  double beside = 0;                      // in row r, off the diagonal
  for (Eigen::Index j = k; j < r; ++j) beside = std::max(beside, std::abs(L_(r, j)));
  for (Eigen::Index i = r + 1; i < n; ++i) beside = std::max(beside, std::abs(L_(i, r)));
  if (here * beside >= alpha * below * below) return k;
  if (std::abs(L_(r, r)) >= alpha * beside) return r;
  size = 2;
  return r;
}

// Exchanges rows and columns a < b of the remaining matrix and of L so far.
void SymmetricFactor::exchange(Eigen::Index a, Eigen::Index b) {
  if (a == b) return;
  const Eigen::Index n = L_.rows();
  for (Eigen::Index j = 0; j < a; ++j) std::swap(L_(a, j), L_(b, j));
  std::swap(L_(a, a), L_(b, b));
  for (Eigen::Index i = a + 1; i < b; ++i) std::swap(L_(i, a), L_(b, i));
  for (Eigen::Index i = b + 1; i < n; ++i) std::swap(L_(i, a), L_(i, b));
}

void SymmetricFactor::eliminate_one(Eigen::Index k) {
  const Eigen::Index n = L_.rows();
  double& d = L_(k, k);
  if (std::abs(d) < smallest_) d = d < 0 ? -smallest_ : smallest_;
  negative_ += d < 0;
  const double inverse = 1 / d;
  for (Eigen::Index j = k + 1; j < n; ++j) {
    const double by = L_(j, k) * inverse;
    for (Eigen::Index i = j; i < n; ++i) L_(i, j) -= L_(i, k) * by;
    L_(j, k) = by;  // of row j only later columns are left
  }
}

void SymmetricFactor::eliminate_two(Eigen::Index k) {
  const Eigen::Index n = L_.rows();
  ++negative_;  // such a pivot has one eigenvalue of either sign
  const double b = L_(k + 1, k), a = L_(k, k) / b, c = L_(k + 1, k + 1) / b,
               inverse = 1 / (b * (a * c - 1));
  for (Eigen::Index j = k + 2; j < n; ++j) {
    const double first = (c * L_(j, k) - L_(j, k + 1)) * inverse,
                 second = (a * L_(j, k + 1) - L_(j, k)) * inverse;
    for (Eigen::Index i = j; i < n; ++i) L_(i, j) -= L_(i, k) * first + L_(i, k + 1) * second;
    L_(j, k) = first;
    L_(j, k + 1) = second;
  }
}

void SymmetricFactor::compute(const MatrixXd& A) {
  assert(A.rows() == A.cols());
  L_ = A;
  pivots_.clear();
  negative_ = 0;
  const Eigen::Index n = L_.rows();
  double largest = 0;
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = j; i < n; ++i) largest = std::max(largest, std::abs(L_(i, j)));
  smallest_ = std::numeric_limits<double>::epsilon() * std::max(largest, 1e-280) * 1e-8;
  for (Eigen::Index k = 0; k < n;) {
    int size = 1;
    const Eigen::Index row = choose(k, size), last = k + size - 1;
    exchange(last, row);
    pivots_.push_back({last, row, size});
    if (size == 1)
      eliminate_one(k);
    else
      eliminate_two(k);
    k += size;
  }
}

void SymmetricFactor::solve(VectorXd& x) const {
  const Eigen::Index n = L_.rows();
  assert(x.size() == n);
  for (const Pivot& p : pivots_) std::swap(x[p.row], x[p.swapped]);
  for (const Pivot& p : pivots_)
    for (Eigen::Index k = p.row - p.size + 1; k <= p.row; ++k)
      for (Eigen::Index i = p.row + 1; i < n; ++i) x[i] -= L_(i, k) * x[k];
  for (auto p = pivots_.rbegin(); p != pivots_.rend(); ++p) {
    const Eigen::Index k = p->row;
    if (p->size == 1) {
      x[k] /= L_(k, k);
    } else {
      const double b = L_(k, k - 1), a = L_(k - 1, k - 1) / b, c = L_(k, k) / b,
                   inverse = 1 / (b * (a * c - 1)), first = x[k - 1];
      x[k - 1] = (c * first - x[k]) * inverse;
      x[k] = (a * x[k] - first) * inverse;
    }
    for (Eigen::Index j = k - p->size + 1; j <= k; ++j)
      for (Eigen::Index i = k + 1; i < n; ++i) x[j] -= L_(i, j) * x[i];
  }
  for (auto p = pivots_.rbegin(); p != pivots_.rend(); ++p) std::swap(x[p->row], x[p->swapped]);
}

}  // namespace flexopt
