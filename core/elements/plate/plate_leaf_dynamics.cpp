// Rates of the nodal values, mass and modes of a plate leaf with its edges held, and what a
// mechanism sees of them.
#include <cmath>
#include <numbers>
#include <utility>

#include "core/elements/plate/full_leaf.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/lanczos.hpp"

namespace flexopt {

MatrixXd PlateLeaf::nodal_rates(int line, const MatrixXd& T) const {
  const int n = mesh_->functions_per_line();
  if (is_second_of_fold(line))
    return fold_jacobian_ * T.middleRows(block_offset(line), fold_unknowns());
  if (!is_rigid_edge(line)) return T.middleRows(block_offset(line), 3 * n);
  const int e = edge_of(line);
  const int m = mesh_->edge_unknowns();
  MatrixXd rates = edge_jacobian_[e].leftCols(m) * T.middleRows(block_offset(line), m);
  if (T.rows() == unknowns() + 12)
    rates.noalias() += edge_jacobian_[e].rightCols<6>() * T.middleRows(unknowns() + 6 * e, 6);
  return rates;
}

MatrixXd PlateLeaf::mass(const MatrixXd& T) const {
  const MatrixXd M = T.transpose() * mass_times(T);
  return 0.5 * (M + M.transpose());
}

MatrixXd PlateLeaf::station_rates(const MatrixXd& T) const {
  const int n = mesh_->functions_per_line(), inner = mesh_->lines() - 2;
  const int middle = 4 * (mesh_->nodes_per_line() / 2);
  MatrixXd rates(6 * inner, T.cols());
  for (int i = 0; i < inner; ++i)
    for (int c = 0; c < 3; ++c) {
      const int row = block_offset(i + 1) + c * n + middle;
      rates.row(6 * i + c) = T.row(row);
      rates.row(6 * i + 3 + c) = 0.5 * mesh_->shape().width * T.row(row + 2);
    }
  return rates;
}

MatrixXd PlateLeaf::mass_times(const MatrixXd& V) const {
  const int n = mesh_->functions_per_line(), lines = mesh_->lines();
  const int m = static_cast<int>(V.cols());
  std::vector<MatrixXd> R(lines);  // functions × (3 components of each column)
  for (int i = 0; i < lines; ++i) R[i] = nodal_rates(i, V).reshaped(n, 3 * m);
  const bool edges = V.rows() == unknowns() + 12;
  MatrixXd result(V.rows(), m), F;
  if (edges) result.bottomRows(12).setZero();
  for (int i = 0; i < lines; ++i) {
    F.noalias() = mesh_->mass_diagonal(i) * R[i];
    if (i > 0) F.noalias() += mesh_->mass_below(i - 1) * R[i - 1];
    if (i + 1 < lines) F.noalias() += mesh_->mass_below(i).transpose() * R[i + 1];
    const auto rows = F.reshaped(3 * n, m);
    if (is_rigid_edge(i)) {
      const int u = mesh_->edge_unknowns();
      const MatrixXd& J = edge_jacobian_[edge_of(i)];
      result.middleRows(block_offset(i), u).noalias() = J.leftCols(u).transpose() * rows;
      if (edges)
        result.middleRows(unknowns() + 6 * edge_of(i), 6).noalias() =
            J.rightCols<6>().transpose() * rows;
    } else if (is_second_of_fold(i)) {
      result.middleRows(block_offset(i), fold_unknowns()).noalias() +=
          fold_jacobian_.transpose() * rows;
    } else {
      if (i == mesh_->fold_line()) result.middleRows(block_offset(i), fold_unknowns()).setZero();
      result.middleRows(block_offset(i), 3 * n) = rows;
    }
  }
  return result;
}

std::vector<PlateLeaf::Mode> PlateLeaf::modes(int count, double tolerance) const {
  std::vector<Mode> result;
  if (count == 0) return result;
  // a round or square wire bends in two planes alike
  const ModesWanted wanted{.count = count,
                           .negative = negative_pivots(),
                           .in_pairs = mesh_->shape().is_beam(),
                           .tolerance = tolerance};
  const LowestPairs pairs = lowest_modes(
      unknowns(), wanted,
      [this](MatrixXd X) {
        solve(X);
        return X;
      },
      [this](const MatrixXd& X) { return mass_times(X); });
  if (!pairs.converged) return result;
  for (int k = 0; k < static_cast<int>(pairs.values.size()); ++k)
    result.push_back({pairs.values[k], pairs.vectors.col(k)});
  return result;
}

MatrixXd leaf_station_motion(const PlateLeaf& plate, const LeafScale& scale, const MatrixXd& T) {
  // leaf mass ρ t w L = mass · (w/L) / L², motion · L
  const int stations = plate.mesh().lines() - 2;
  return std::sqrt(scale.mass * plate.mesh().shape().mean_width() / stations) *
         plate.station_rates(T);
}

MatrixXd leaf_shape_motion(const PlateLeaf& plate, const LeafScale& scale, const MatrixXd& T) {
  const PlateMesh& mesh = plate.mesh();
  const bool beam = mesh.shape().is_beam();
  const int lines = mesh.lines(), across = beam ? 2 : mesh.nodes_per_line();
  const int n = mesh.functions_per_line();
  const Matrix3d turn = scale.length * scale.axes;
  MatrixXd motion(3 * lines * across, T.cols()), node(3, T.cols());
  for (int i = 0; i < lines; ++i) {
    const MatrixXd rates = plate.nodal_rates(i, T);
    const double edge = 0.5 * mesh.shape().width_at(mesh.x()[i]);
    for (int j = 0; j < across; ++j) {
      for (int c = 0; c < 3; ++c) {
        node.row(c) = rates.row(c * n + (beam ? 0 : 4 * j));
        if (beam) node.row(c) += (j == 0 ? -edge : edge) * rates.row(c * n + 2);
      }
      motion.middleRows<3>(3 * (j * lines + i)).noalias() = turn * node;
    }
  }
  return motion;
}

namespace {

// Shapes with M and K times them.
struct Shapes {
  MatrixXd U, MU, KU;
};

// The modes, M-orthonormal, after one more inverse iteration: K times them then is known to
// rounding, however far the iteration that found them went.
struct LeafModeShapes {
  VectorXd omega2;
  Shapes shapes;
};
LeafModeShapes iterated(const PlateLeaf& plate, const VectorXd& omega2, const MatrixXd& M_Psi,
                        MatrixXd Psi) {
  if (omega2.size() == 0) return {omega2, {Psi, Psi, Psi}};
  Psi *= omega2.asDiagonal();
  const MatrixXd K_Psi = M_Psi * omega2.asDiagonal(), M = plate.mass_times(Psi),
                 A = Psi.transpose() * K_Psi, G = Psi.transpose() * M;
  const SymmetricEigen ritz(0.5 * (A + A.transpose()), 0.5 * (G + G.transpose()));
  const MatrixXd& Z = ritz.eigenvectors();
  return {ritz.eigenvalues(), {Psi * Z, M * Z, K_Psi * Z}};
}

// M-orthonormal Ritz shapes of span(Y), Y M-orthogonal to the modes; KY = K Y. Directions that Y
// hardly has are left out, and with them what cancellation leaves of others: beside the lowest
// modes nothing is slower than the last of them, `least`. Columns that consisted of the modes
// alone, as those of coarse wires do, are nothing but rounding: `before`, the sizes that they had.
struct RitzShapes {
  VectorXd omega2;
  MatrixXd shapes, mass;  ///< Y, M Y
};
RitzShapes ritz_shapes(const PlateLeaf& plate, MatrixXd Y, MatrixXd KY, const VectorXd& before,
                       double least) {
  constexpr double nothing = 1e-6;
  std::vector<int> left;
  for (int k = 0; k < static_cast<int>(Y.cols()); ++k)
    if (Y.col(k).norm() > nothing * before[k]) left.push_back(k);
  if (left.empty()) return {VectorXd(0), MatrixXd(Y.rows(), 0), MatrixXd(Y.rows(), 0)};
  if (left.size() < static_cast<std::size_t>(Y.cols())) {
    Y = MatrixXd(Y(Eigen::all, left));
    KY = MatrixXd(KY(Eigen::all, left));
  }
  const VectorXd size = Y.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  Y *= size.asDiagonal();
  KY *= size.asDiagonal();
  const MatrixXd MY = plate.mass_times(Y), M = Y.transpose() * MY, K = Y.transpose() * KY;
  const SymmetricEigen mass(0.5 * (M + M.transpose()));
  const VectorXd& mu = mass.eigenvalues();
  int first = 0;
  while (first < mu.size() && mu[first] < 1e-9 * mu[mu.size() - 1]) ++first;
  const int kept = static_cast<int>(mu.size()) - first;
  const MatrixXd B =
      mass.eigenvectors().rightCols(kept) * mu.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  const SymmetricEigen ritz(B.transpose() * (0.5 * (K + K.transpose())) * B);
  const VectorXd& omega2 = ritz.eigenvalues();
  int noise = 0;
  while (noise < kept && omega2[noise] < least) ++noise;
  const MatrixXd combined = B * ritz.eigenvectors().rightCols(kept - noise);
  return {omega2.tail(kept - noise), Y * combined, MY * combined};
}

// Shapes between held edges, M-orthonormal: the modes, and what they leave of the static answer to
// the static shapes' own inertia, Y = K⁻¹ M X, without which the modes left out cost (ω/ω_cut)²:
// (E7) of core/elements/README.md. `MX`: M X in the rows of the unknowns.
struct InternalShapes {
  VectorXd omega2;
  MatrixXd shapes, mass;  ///< U, M U
  double highest_mode;    ///< ω² of the last mode, 0 without modes
};
InternalShapes internal_shapes(const PlateLeaf& plate, const std::vector<PlateLeaf::Mode>& modes,
                               const MatrixXd& MX) {
  const int n = plate.unknowns(), m = static_cast<int>(modes.size()),
            a = static_cast<int>(MX.cols());
  MatrixXd Psi(n, m);
  VectorXd omega2(m);
  for (int k = 0; k < m; ++k) {
    Psi.col(k) = modes[k].shape;
    omega2[k] = modes[k].omega2;
  }
  // what the modes share of Y is left out before K⁻¹: beside it the rest would be rounded
  MatrixXd B(n, m + a);
  if (m > 0) B.leftCols(m) = plate.mass_times(Psi);
  B.rightCols(a) = MX;
  B.rightCols(a) -= B.leftCols(m) * (Psi.transpose() * B.rightCols(a)).eval();
  MatrixXd Y = B;
  plate.solve(Y);
  const LeafModeShapes iteration = iterated(plate, omega2, B.leftCols(m), Y.leftCols(m));
  Y = Y.rightCols(a).eval();
  B = B.rightCols(a).eval();
  const Shapes& own = iteration.shapes;
  const MatrixXd of_modes =
                     iteration.omega2.cwiseInverse().asDiagonal() * (own.U.transpose() * MX).eval(),
                 share = own.MU.transpose() * Y;
  const VectorXd before = (Y + own.U * of_modes).colwise().norm();
  Y -= own.U * share;
  B -= own.KU * share;
  const double last = m > 0 ? iteration.omega2[m - 1] : 0;
  const RitzShapes ritz =
      ritz_shapes(plate, std::move(Y), std::move(B), before, last - 1e-6 * std::abs(last));
  const Eigen::Index r = ritz.omega2.size();
  InternalShapes all{VectorXd(m + r), MatrixXd(n, m + r), MatrixXd(n, m + r), last};
  all.omega2 << iteration.omega2, ritz.omega2;
  all.shapes << own.U, ritz.shapes;
  all.mass << own.MU, ritz.mass;
  return all;
}

}  // namespace

LeafDynamics plate_dynamics(const PlateLeaf& plate, const LeafSpring& leaf, const LeafScale& scale,
                            DynamicsRequest request) {
  const std::vector<PlateLeaf::Mode> modes =
      plate.modes(std::min(request.modes, plate.unknowns() / 4));
  const int n = plate.unknowns();
  const int b = plate.has_point() ? 15 : 12;  // boundary coordinates; the ground's do not move
  std::vector<int> moving;
  for (int k = 0; k < b; ++k)
    if (k >= 12 || (k < 6 ? leaf.base : leaf.tip) >= 0) moving.push_back(k);
  const int a = static_cast<int>(moving.size());

  // x = X q + U ξ, static shapes and internal ones
  MatrixXd X = MatrixXd::Zero(n + 12, a);
  X.topRows(n) = plate.static_shapes(moving);
  for (int k = 0; k < a; ++k)
    if (moving[k] < 12) X(n + moving[k], k) = 1;
  const MatrixXd MX = plate.mass_times(X);
  InternalShapes own{VectorXd(0), MatrixXd(n, 0), MatrixXd(n, 0), 0};
  if (request.modes > 0) own = internal_shapes(plate, modes, MX.topRows(n));
  const int internal = static_cast<int>(own.omega2.size());
  MatrixXd T = MatrixXd::Zero(n + 12, a + internal);
  T.leftCols(a) = X;
  T.topRightCorner(n, internal) = own.shapes;
  // the columns of internal shapes have no rows of edges
  MatrixXd mass(a + internal, a + internal);
  mass.leftCols(a).noalias() = T.transpose() * MX;
  mass.bottomRightCorner(internal, internal).noalias() =
      T.block(0, a, n, internal).transpose() * own.mass;
  mass.topRightCorner(a, internal) = mass.bottomLeftCorner(internal, a).transpose();
  mass = (0.5 * (mass + mass.transpose())).eval();
  const double amplitude = 1 / std::sqrt(scale.mass);  // unit modal mass in SI
  MatrixXd S = MatrixXd::Zero(b + internal, a + internal);
  {
    MatrixXd boundary = MatrixXd::Zero(b, b);
    boundary.topLeftCorner<12, 12>() = scale.transformation();
    if (plate.has_point()) boundary.block<3, 3>(12, 12) = scale.axes / scale.length;
    for (int k = 0; k < a; ++k) S.col(k).head(b) = boundary.col(moving[k]);
    for (int k = 0; k < internal; ++k) S(b + k, a + k) = amplitude;
  }
  LeafDynamics dynamics;
  dynamics.mass = scale.mass * (S * mass * S.transpose());
  const MatrixXd rates = T * S.transpose();
  dynamics.stations = leaf_station_motion(plate, scale, rates);
  if (request.shapes) dynamics.shape_motion = leaf_shape_motion(plate, scale, rates);
  const double to_SI = scale.energy / scale.mass;
  set_modes(dynamics, own.omega2 * to_SI);
  dynamics.highest_mode =
      std::sqrt(std::max(own.highest_mode, 0.0) * to_SI) / (2 * std::numbers::pi);
  return dynamics;
}

}  // namespace flexopt
