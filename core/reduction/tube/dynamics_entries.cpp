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

void DynamicsEntries::put(const Slot& s, double x) {
  switch (s.matrix) {
    case k_part:
      k(s.row, s.column) = k(s.column, s.row) = x;
      break;
    case G_part:
      G(s.row, s.column) = x;
      break;
    case F_part:
      F(s.row, s.column) = F(s.column, s.row) = x;
      break;
    case g_part:
      g(s.row, s.column) = x;
      break;
    default:
      mass(s.row, s.column) = mass(s.column, s.row) = x;
  }
}

double DynamicsEntries::taken(const Slot& s) const {
  const auto both = [&](const auto& A) {
    return s.row == s.column ? A(s.row, s.row) : A(s.row, s.column) + A(s.column, s.row);
  };
  switch (s.matrix) {
    case k_part:
      return both(k);
    case G_part:
      return G(s.row, s.column);
    case F_part:
      return both(F);
    case g_part:
      return g(s.row, s.column);
    default:
      return both(mass);
  }
}

bool DynamicsEntries::stiffness(Square& K, Flat& X) const {
  if (!positive(F)) return false;
  X.noalias() = F.inverse() * G;
  K = k;
  K.noalias() += G.transpose() * X;
  return true;
}

}  // namespace flexopt
