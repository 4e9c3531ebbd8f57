#include "core/math/block_tridiagonal.hpp"

#include <Eigen/Jacobi>
#include <algorithm>
#include <cmath>

#include "core/math/work_limit.hpp"

namespace flexopt {
namespace {

/// R and signs Σ with S = R⁻¹ Σ R⁻ᵀ, of the lower triangle of a symmetric matrix, by symmetric
/// elimination with the pivots of Bunch and Parlett (SIAM J. Numer. Anal. 8, 1971): the largest
/// entry of the diagonal, or, where one beside the diagonal is far larger, its two columns, which a
/// Jacobi rotation parts first.
void split(const MatrixXd& S, MatrixXd& R, VectorXd& signs) {
  const Eigen::Index n = S.rows();
  MatrixXd A = S.selfadjointView<Eigen::Lower>();
  R.setIdentity(n, n);
  signs.resize(n);
  const double least = 1e-300 + 1e-15 * A.cwiseAbs().maxCoeff();
  const double threshold = (1 + std::sqrt(17.0)) / 8;
  const auto exchange = [&](Eigen::Index a, Eigen::Index b) {
    if (a == b) return;
    A.row(a).swap(A.row(b));
    A.col(a).swap(A.col(b));
    R.row(a).swap(R.row(b));
  };
  bool parted = false;  // column k is the second of two
  for (Eigen::Index k = 0; k < n; ++k) {
    if (!parted) {
      Eigen::Index on = k, row = k, column = k;
      double beside = 0;
      for (Eigen::Index j = k; j < n; ++j) {
        if (std::abs(A(j, j)) > std::abs(A(on, on))) on = j;
        for (Eigen::Index i = j + 1; i < n; ++i)
          if (std::abs(A(i, j)) > beside) beside = std::abs(A(i, j)), row = i, column = j;
      }
      parted = std::abs(A(on, on)) < threshold * beside;
      if (parted) {
        exchange(k, column);
        exchange(k + 1, row);
        Eigen::JacobiRotation<double> turn;
        turn.makeJacobi(A, k, k + 1);
        A.applyOnTheLeft(k, k + 1, turn.adjoint());
        A.applyOnTheRight(k, k + 1, turn);
        R.applyOnTheLeft(k, k + 1, turn.adjoint());
      } else {
        exchange(k, on);
      }
    } else {
      parted = false;
    }
    signs[k] = A(k, k) < 0 ? -1 : 1;
    const double pivot = signs[k] * std::max(std::abs(A(k, k)), least);
    const Eigen::Index below = n - k - 1;
    const VectorXd factors = A.col(k).tail(below) / pivot;
    A.bottomRightCorner(below, below).noalias() -= pivot * factors * factors.transpose();
    R.bottomRows(below).noalias() -= factors * R.row(k);
    R.row(k) /= std::sqrt(std::abs(pivot));
  }
}

}  // namespace

void BlockTridiagonal::resize(const std::vector<int>& sizes) {
  const int n = static_cast<int>(sizes.size());
  diagonal.resize(n);
  below.resize(n - 1);
  offset.assign(1, 0);
  for (int i = 0; i < n; ++i) {
    diagonal[i].resize(sizes[i], sizes[i]);
    if (i > 0) below[i - 1].resize(sizes[i], sizes[i - 1]);
    offset.push_back(offset.back() + sizes[i]);
  }
  indefinite_.assign(n, {});
}

void BlockTridiagonal::invert_pivots() {
  if (inverted_) return;
  for (int i = 0; i < blocks(); ++i) {
    if (indefinite_[i].signs.size() != 0) continue;
    MatrixXd& inverse = indefinite_[i].inverse_root;
    inverse.setIdentity(diagonal[i].rows(), diagonal[i].rows());
    diagonal[i].triangularView<Eigen::Lower>().solveInPlace(inverse);
  }
  inverted_ = true;
}

void BlockTridiagonal::factorise() {
  negative_ = 0;
  inverted_ = false;
  for (int i = 0; i < blocks(); ++i) {
    check_work();
    if (i > 0) {
      // S_i = D_i − W Σ Wᵀ with W = O C⁻ᵀ Σ, already in below[i − 1]
      const Indefinite& previous = indefinite_[i - 1];
      if (previous.signs.size() == 0)
        diagonal[i].selfadjointView<Eigen::Lower>().rankUpdate(below[i - 1], -1.0);
      else
        diagonal[i] -= below[i - 1] * previous.signs.asDiagonal() * below[i - 1].transpose();
    }
    Indefinite& pivot = indefinite_[i];
    const MatrixXd& S = diagonal[i];
    // The in-place Cholesky destroys S: its diagonal must first show no plain sign of failure.
    bool positive = (S.diagonal().array() > 0).all();
    if (positive) {
      pivot.signs.resize(0);
      MatrixXd& C = diagonal[i];
      pivot.inverse_root = C.triangularView<Eigen::Lower>();
      Eigen::LLT<Eigen::Ref<MatrixXd>> llt(C);
      positive = llt.info() == Eigen::Success;
      if (!positive) C.triangularView<Eigen::Lower>() = pivot.inverse_root;
    }
    if (positive) {
      if (i + 1 < blocks())
        diagonal[i].triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(
            below[i]);
    } else {
      split(S, pivot.inverse_root, pivot.signs);
      negative_ += static_cast<int>((pivot.signs.array() < 0).count());
      if (i + 1 < blocks())
        below[i] = (below[i] * pivot.inverse_root.transpose() * pivot.signs.asDiagonal()).eval();
    }
  }
}

template <class Derived>
void BlockTridiagonal::lower(Eigen::MatrixBase<Derived>& b, int first) const {
  for (int i = first; i < blocks(); ++i) {
    auto row = b.middleRows(offset[i], offset[i + 1] - offset[i]);
    if (i > first)
      row.noalias() -= below[i - 1] * b.middleRows(offset[i - 1], offset[i] - offset[i - 1]);
    if (indefinite_[i].signs.size() == 0 && !inverted_)
      diagonal[i].triangularView<Eigen::Lower>().solveInPlace(row);
    else
      row = (indefinite_[i].inverse_root * row).eval();
  }
}

template <class Derived>
void BlockTridiagonal::upper(Eigen::MatrixBase<Derived>& b) const {
  for (int i = blocks() - 1; i >= 0; --i) {
    auto row = b.middleRows(offset[i], offset[i + 1] - offset[i]);
    if (i + 1 < blocks())
      row.noalias() -=
          below[i].transpose() * b.middleRows(offset[i + 1], offset[i + 2] - offset[i + 1]);
    if (indefinite_[i].signs.size() == 0 && !inverted_)
      diagonal[i].triangularView<Eigen::Lower>().transpose().solveInPlace(row);
    else
      row = (indefinite_[i].inverse_root.transpose() * row).eval();
  }
}

MatrixXd BlockTridiagonal::times(const MatrixXd& b) const {
  MatrixXd result(b.rows(), b.cols());
  for (int i = 0; i < blocks(); ++i) {
    auto row = result.middleRows(offset[i], offset[i + 1] - offset[i]);
    row.noalias() = diagonal[i].selfadjointView<Eigen::Lower>() *
                    b.middleRows(offset[i], offset[i + 1] - offset[i]);
    if (i > 0)
      row.noalias() += below[i - 1] * b.middleRows(offset[i - 1], offset[i] - offset[i - 1]);
    if (i + 1 < blocks())
      row.noalias() +=
          below[i].transpose() * b.middleRows(offset[i + 1], offset[i + 2] - offset[i + 1]);
  }
  return result;
}

// A single column takes matrix–vector kernels, which need no packing.
void BlockTridiagonal::solve_lower(Eigen::Ref<MatrixXd> b, int first) const {
  if (b.cols() == 1) {
    auto v = b.col(0);
    lower(v, first);
  } else {
    lower(b, first);
  }
}

void BlockTridiagonal::solve_upper(Eigen::Ref<MatrixXd> b) const {
  if (b.cols() == 1) {
    auto v = b.col(0);
    upper(v);
  } else {
    upper(b);
  }
}

void BlockTridiagonal::apply_signs(Eigen::Ref<MatrixXd> y) const {
  if (negative_ == 0) return;
  for (int i = 0; i < blocks(); ++i)
    if (indefinite_[i].signs.size() != 0)
      y.middleRows(offset[i], offset[i + 1] - offset[i]) =
          (indefinite_[i].signs.asDiagonal() * y.middleRows(offset[i], offset[i + 1] - offset[i]))
              .eval();
}

}  // namespace flexopt
