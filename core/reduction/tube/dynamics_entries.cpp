#include "core/reduction/tube/dynamics_entries.hpp"

#include <Eigen/LU>

#include <array>

namespace flexopt {
namespace {

constexpr std::array<double, 12> across_parity{1, -1, 1, -1, 1, -1, 1, 1, -1, 1, -1, -1};
constexpr std::array<double, 12> thickness_parity{1, 1, -1, -1, -1, 1, -1, -1, -1, 1, 1, 1};

bool positive(const Matrix3d& A) {
  return A(0, 0) > 0 && A(0, 0) * A(1, 1) > A(1, 0) * A(0, 1) && A.determinant() > 0;
}

DynamicsLayout make_layout(const LoadParity& loads) {
  constexpr int P = DynamicsEntries::P, R = DynamicsEntries::R;
  DynamicsLayout layout;
  Eigen::Matrix<double, R, 1> across;
  for (int i = 0; i < R; ++i) {
    across[i] = i < 12 ? across_parity[i] : loads.across[i - 12];
    layout.mirror[i] = i < 12 ? thickness_parity[i] : loads.normal[i - 12];
  }
  const auto add = [&](DynamicsEntries::Part part, int i, int j, double sign) {
    (sign > 0 ? layout.even : layout.odd).push_back({part, i, j});
  };
  for (int i = 0; i < P; ++i)
    for (int j = 0; j <= i; ++j)
      add(DynamicsEntries::k_part, i, j, across[12 + i] * across[12 + j]);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < P; ++j) add(DynamicsEntries::G_part, i, j, across[9 + i] * across[12 + j]);
    for (int j = 0; j <= i; ++j) add(DynamicsEntries::F_part, i, j, across[9 + i] * across[9 + j]);
  }
  layout.even_stiffness = static_cast<int>(layout.even.size());
  layout.odd_stiffness = static_cast<int>(layout.odd.size());
  for (int i = 0; i < P; ++i)
    for (int j = 0; j < 3; ++j) add(DynamicsEntries::g_part, i, j, across[12 + i] * across[6 + j]);
  for (int i = 0; i < R; ++i)
    for (int j = 0; j <= i; ++j) add(DynamicsEntries::mass_part, i, j, across[i] * across[j]);
  return layout;
}

}  // namespace

const DynamicsLayout& DynamicsLayout::get() {
  static const DynamicsLayout found = make_layout(load_parity());
  return found;
}

namespace {

// Calls use(matrix, whether it is symmetric) for the matrix of a slot.
template <class Entries, class Use>
auto in_matrix(Entries& e, const DynamicsEntries::Slot& s, const Use& use) {
  switch (s.matrix) {
    case DynamicsEntries::k_part:
      return use(e.k, true);
    case DynamicsEntries::G_part:
      return use(e.G, false);
    case DynamicsEntries::F_part:
      return use(e.F, true);
    case DynamicsEntries::g_part:
      return use(e.g, false);
    default:
      return use(e.mass, true);
  }
}

}  // namespace

void DynamicsEntries::put(const Slot& s, double x) {
  in_matrix(*this, s, [&](auto& A, bool symmetric) {
    A(s.row, s.column) = x;
    if (symmetric) A(s.column, s.row) = x;
  });
}

double DynamicsEntries::taken(const Slot& s) const {
  return in_matrix(*this, s, [&](const auto& A, bool symmetric) -> double {
    return A(s.row, s.column) + (symmetric && s.row != s.column ? A(s.column, s.row) : 0);
  });
}

bool DynamicsEntries::stiffness(Square& K, Flat& X) const {
  if (!positive(F)) return false;
  X.noalias() = F.inverse() * G;
  K = k;
  K.noalias() += G.transpose() * X;
  return true;
}

}  // namespace flexopt
