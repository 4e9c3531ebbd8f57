#pragma once
// The numbers of a leaf's internal dynamics at one state, and where its tables have them. Equation
// (D1) of core/reduction/README.md.
#include <vector>

#include "core/reduction/tube/tube_dynamics.hpp"

namespace flexopt {

/// k, G, F′, g of (D1), and the mass.
struct DynamicsEntries {
  static constexpr int P = TubeDynamics::amplitudes, R = TubeDynamics::rates;
  using Square = Eigen::Matrix<double, P, P>;
  using Flat = Eigen::Matrix<double, 3, P>;
  using RateMatrix = Eigen::Matrix<double, R, R>;

  Square k = Square::Zero();
  Flat G = Flat::Zero();
  Eigen::Matrix<double, P, 3> g = Eigen::Matrix<double, P, 3>::Zero();
  Matrix3d F = Matrix3d::Zero();
  RateMatrix mass = RateMatrix::Zero();

  enum Part { k_part, G_part, F_part, g_part, mass_part };
  /// Place of a number of a table; symmetric matrices use the lower half.
  struct Slot {
    int matrix, row, column;
  };
  void put(const Slot& slot, double x);
  /// Covector of the number of a slot, where this holds covectors of the matrices.
  double taken(const Slot& slot) const;

  /// Stiffness (D3) of the amplitudes, the stiff deformations held, and X = F′⁻¹ G; false where F′
  /// is not positive.
  bool stiffness(Square& K, Flat& X) const;
};

/// The numbers of all tables in their order: those that are even and those that are odd in (φ, M1,
/// M2); of each first those of the stiffness.
struct DynamicsLayout {
  std::vector<DynamicsEntries::Slot> even, odd;
  int even_stiffness = 0, odd_stiffness = 0;
  Eigen::Matrix<double, DynamicsEntries::R, 1> mirror;  ///< of the rates, in the thickness

  static const DynamicsLayout& get();
};

/// A = L Lᵀ of small matrices, in place, the lower triangle; false where A is not positive.
template <int n>
bool factorise(Eigen::Matrix<double, n, n>& A) {
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < j; ++k) A.col(j).tail(n - j) -= A(j, k) * A.col(k).tail(n - j);
    if (!(A(j, j) > 0)) return false;
    A.col(j).tail(n - j) /= std::sqrt(A(j, j));
  }
  return true;
}
/// (L Lᵀ)⁻¹ B in place, L the lower triangle.
template <int n, class B>
void solve_factorised(const Eigen::Matrix<double, n, n>& L, B& X) {
  L.template triangularView<Eigen::Lower>().solveInPlace(X);
  L.transpose().template triangularView<Eigen::Upper>().solveInPlace(X);
}

}  // namespace flexopt
