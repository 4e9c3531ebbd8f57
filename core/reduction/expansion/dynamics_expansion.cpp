#include "core/reduction/expansion/dynamics_expansion.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace flexopt {
namespace {

constexpr int P = field_loads;

// Rows of a nodal vector: line by line, component by component.
Eigen::Index nodal_row(const PlateMesh& mesh, int line, int component, int function) {
  return (3 * line + component) * mesh.functions_per_line() + function;
}

// Nodal values of fields: rows as ChordLeaf::unknowns, and those of the edges' lines.
MatrixXd nodal_values(const ChordLeaf& leaf, const MatrixXd& fields, const MatrixXd& edge_nodal) {
  const PlateMesh& mesh = leaf.plate().mesh();
  const Eigen::Index n3 = 3 * mesh.functions_per_line(), last = mesh.lines() - 1;
  MatrixXd nodal(n3 * (last + 1), fields.cols());
  nodal.topRows(n3) = edge_nodal.topRows(n3);
  nodal.bottomRows(n3) = edge_nodal.bottomRows(n3);
  for (int i = 1; i < last; ++i)
    nodal.middleRows(i * n3, n3) = fields.middleRows(leaf.plate().block_offset(i), n3);
  return nodal;
}

MatrixXd nodal_mass_times(const PlateMesh& mesh, const MatrixXd& V) {
  const int n = mesh.functions_per_line(), lines = mesh.lines();
  const Eigen::Index columns = V.cols();
  MatrixXd MV(V.rows(), columns);
  std::vector<MatrixXd> R;  // functions × (3 components of each column)
  for (int i = 0; i < lines; ++i)
    R.push_back(MatrixXd(V.middleRows(3 * n * i, 3 * n)).reshaped(n, 3 * columns));
  for (int i = 0; i < lines; ++i) {
    MatrixXd F = mesh.mass_diagonal(i) * R[i];
    if (i > 0) F.noalias() += mesh.mass_below(i - 1) * R[i - 1];
    if (i + 1 < lines) F.noalias() += mesh.mass_below(i).transpose() * R[i + 1];
    MV.middleRows(3 * n * i, 3 * n) = F.reshaped(3 * n, columns);
  }
  return MV;
}

// A nodal vector seen in the mirror across the width, or of the thickness.
VectorXd mirrored(const PlateMesh& mesh, const VectorXd& v, bool across) {
  const int nodes = mesh.nodes_per_line();
  VectorXd image(v.size());
  for (int i = 0; i < mesh.lines(); ++i)
    for (int c = 0; c < 3; ++c)
      for (int j = 0; j < nodes; ++j)
        for (int k = 0; k < 4; ++k) {
          double sign = c == (across ? 1 : 2) ? -1 : 1;
          if (across && k >= 2) sign = -sign;
          const int from = across ? nodes - 1 - j : j;
          image[nodal_row(mesh, i, c, 4 * j + k)] = sign * v[nodal_row(mesh, i, c, 4 * from + k)];
        }
  return image;
}

}  // namespace

namespace {

// Nodal values of a leaf between held edges that bends in its plane. That mode is far above the
// others, but its inertia counts where a body swings a narrow leaf sideways.
VectorXd lateral_shape(const PlateMesh& mesh) {
  VectorXd nodal = VectorXd::Zero(3 * mesh.functions_per_line() * mesh.lines());
  for (int i = 0; i < mesh.lines(); ++i) {
    const double x = mesh.x()[i], r = 1 - x;
    for (int j = 0; j < mesh.nodes_per_line(); ++j) {
      nodal[nodal_row(mesh, i, 1, 4 * j)] = x * x * r * r;
      nodal[nodal_row(mesh, i, 1, 4 * j + 1)] = 2 * x * r * (r - x);
    }
  }
  return nodal;
}

}  // namespace

InternalLoads internal_loads(const ChordLeaf& leaf) {
  constexpr int sought = P + 2;         // some may be two parities of one mode
  constexpr double least_share = 0.02;  // of a mode that mixes parities by chance
  const PlateMesh& mesh = leaf.plate().mesh();
  InternalLoads result;
  result.loads.resize(3 * mesh.functions_per_line() * mesh.lines(), P);
  if (leaf.plate().unknowns() < 4 * sought) return result;
  MatrixXd shapes(result.loads.rows(), P);
  int kept = 0;
  const auto keep = [&](const VectorXd& shape, double least) {
    for (const int y : {1, -1})
      for (const int z : {-1, 1}) {
        if (kept == P) return;
        VectorXd part = 0.5 * (shape + y * mirrored(mesh, shape, true));
        part = (0.5 * (part + z * mirrored(mesh, part, false))).eval();
        for (int k = 0; k < kept; ++k) part -= shapes.col(k) * result.loads.col(k).dot(part);
        const VectorXd load = nodal_mass_times(mesh, part);
        const double share = load.dot(part);
        if (!(share > least)) continue;
        shapes.col(kept) = part / std::sqrt(share);
        result.loads.col(kept) = load / std::sqrt(share);
        result.across[kept] = y;
        result.normal[kept] = z;
        ++kept;
      }
  };
  constexpr double narrow = 40;  // widths over thicknesses, as their bending modes are apart
  const VectorXd lateral = lateral_shape(mesh);
  if (mesh.shape().width < narrow * mesh.shape().thickness)
    keep(lateral, 0.5 * lateral.dot(nodal_mass_times(mesh, lateral).col(0)));
  for (const PlateLeaf::Mode& mode : leaf.plate().modes(sought, 1e-6)) {
    VectorXd nodal(result.loads.rows());
    for (int i = 0; i < mesh.lines(); ++i)
      nodal.segment(nodal_row(mesh, i, 0, 0), 3 * mesh.functions_per_line()) =
          leaf.plate().nodal_rates(i, mode.shape);
    keep(nodal, least_share);
  }
  result.found = kept == P;
  return result;
}

namespace {

// The motions whose mass is wanted, nodal values: columns of one monomial after the other, each
// (turns about the base 3, per x 6, per load P).
constexpr int motions = 9 + P;
struct Motions {
  MatrixXd nodal;  ///< of all 28 monomials
  MatrixXd stiff;  ///< of the stiff deformations, likewise; rows (u, θ1z, θ2z)
};

MatrixXd turned(const PlateMesh& mesh, const VectorXd& r, int axis) {
  VectorXd v = VectorXd::Zero(r.size());
  const int n = mesh.functions_per_line(), b = (axis + 1) % 3, c = (axis + 2) % 3;
  for (int i = 0; i < mesh.lines(); ++i) {
    v.segment(nodal_row(mesh, i, b, 0), n) = -r.segment(nodal_row(mesh, i, c, 0), n);
    v.segment(nodal_row(mesh, i, c, 0), n) = r.segment(nodal_row(mesh, i, b, 0), n);
  }
  return v;
}

Motions motions_of(const ChordLeaf& leaf, const Eigen::Matrix2d& ray, const InternalLoads& loads) {
  const MonomialTable &table = monomials<6, 2>(), &higher = monomials<6, 3>();
  const PlateMesh& mesh = leaf.plate().mesh();
  const FieldExpansion fields = expand_fields(leaf, ray, 3);
  const LoadFields by_load = expand_load_fields(leaf, ray, fields.fields, loads);
  const MatrixXd r = nodal_values(leaf, fields.fields, fields.edge_nodal),
                 by_loads = nodal_values(leaf, by_load.fields, by_load.edge_nodal);
  const Eigen::Index m = table.size();
  Motions all{MatrixXd(r.rows(), motions * m), MatrixXd::Zero(3, motions * m)};
  for (int k = 0; k < m; ++k) {
    const Eigen::Index o = motions * k;
    for (int a = 0; a < 3; ++a) all.nodal.col(o + a) = turned(mesh, r.col(k), a);
    std::array<int, 6> e{};
    std::copy(table.exponents(k).begin(), table.exponents(k).end(), e.begin());
    for (int p = 0; p < 6; ++p) {
      ++e[p];
      const int of = higher.index(e);
      all.nodal.col(o + 3 + p) = e[p] * r.col(of);
      all.stiff.col(o + 3 + p) = e[p] * fields.fields.col(of).tail<3>();
      --e[p];
    }
    for (int p = 0; p < P; ++p) {
      all.nodal.col(o + 9 + p) = by_loads.col(p * m + k);
      all.stiff.col(o + 9 + p) = by_load.fields.col(p * m + k).tail<3>();
    }
  }
  return all;
}

// Vᵀ M V of the motions, with three translations before them.
MatrixPolynomial mass_of(const PlateMesh& mesh, const MatrixXd& nodal) {
  const MonomialTable& table = monomials<6, 2>();
  const Eigen::Index low = motions * table.count(1);
  MatrixXd slide = MatrixXd::Zero(nodal.rows(), 3);
  for (int i = 0; i < mesh.lines(); ++i)
    for (int c = 0; c < 3; ++c)
      for (int j = 0; j < mesh.nodes_per_line(); ++j) slide(nodal_row(mesh, i, c, 4 * j), c) = 1;
  const MatrixXd M_slide = nodal_mass_times(mesh, slide),
                 M_low = nodal_mass_times(mesh, nodal.leftCols(low));
  MatrixPolynomial M(table, 3 + motions, 3 + motions);
  const MatrixXd linear = M_slide.transpose() * nodal,
                 constant = M_low.leftCols(motions).transpose() * nodal,
                 first = M_low.rightCols(low - motions).transpose() *
                         nodal.middleCols(motions, low - motions);
  M[0].topLeftCorner<3, 3>() = M_slide.transpose() * slide;
  for (int k = 0; k < table.size(); ++k) {
    const auto L = linear.middleCols(motions * k, motions);
    M[k].topRightCorner(3, motions) += L;
    M[k].bottomLeftCorner(motions, 3) += L.transpose();
    const auto C = constant.middleCols(motions * k, motions);
    M[k].bottomRightCorner(motions, motions) += C;
    if (k > 0) M[k].bottomRightCorner(motions, motions) += C.transpose();
  }
  for (int i = 1; i < table.count(1); ++i)
    for (int j = 1; j < table.count(1); ++j)
      M[table.products(i)[j]].bottomRightCorner(motions, motions) +=
          first.block(motions * (i - 1), motions * (j - 1), motions, motions);
  return M;
}

// A few rows of the motions.
MatrixPolynomial rows_of(const MatrixXd& rows) {
  const MonomialTable& table = monomials<6, 2>();
  MatrixPolynomial R(table, rows.rows(), motions);
  for (int k = 0; k < table.size(); ++k) R[k] = rows.middleCols(motions * k, motions);
  return R;
}

MatrixXd station_rows(const PlateMesh& mesh, const MatrixXd& nodal) {
  const int inner = mesh.lines() - 2, middle = 4 * (mesh.nodes_per_line() / 2);
  MatrixXd rows(6 * inner, nodal.cols());
  for (int i = 0; i < inner; ++i)
    for (int c = 0; c < 3; ++c) {
      const Eigen::Index row = nodal_row(mesh, i + 1, c, middle);
      rows.row(6 * i + c) = nodal.row(row);
      rows.row(6 * i + 3 + c) = 0.5 * mesh.shape().width * nodal.row(row + 2);
    }
  return rows;
}

MatrixPolynomial identity(Eigen::Index n) {
  MatrixPolynomial I(monomials<6, 2>(), n, n);
  I[0].setIdentity();
  return I;
}

}  // namespace

DynamicsExpansion expand_dynamics(const ChordLeaf& leaf, const Eigen::Matrix2d& ray,
                                  const InternalLoads& loads) {
  assert(loads.found);
  const PlateMesh& mesh = leaf.plate().mesh();
  const Motions V = motions_of(leaf, ray, loads);
  const MatrixPolynomial a = rows_of(loads.loads.transpose() * V.nodal),  // amplitudes of motions
      c = rows_of(tube_force_scale(mesh.shape()).asDiagonal() * V.stiff);
  const MatrixPolynomial A = a.block(0, 9, P, P), C = c.block(0, 9, 3, P);
  DynamicsExpansion e;
  e.k = A.inverse();
  e.G = C * e.k;
  const MatrixPolynomial a_s = a.block(0, 3, P, 3);
  e.g = e.k * a_s;
  e.F = c.block(0, 6, 3, 3) - e.G * C.transposed();
  // to motions with the amplitudes held (per s, per f) or the forces f held (per a)
  MatrixPolynomial T = identity(motions), zero(monomials<6, 2>(), P, 6);
  T.set_block(9, 9, e.k);
  T.set_block(9, 3, zero.block(0, 0, P, 3) - e.g);
  T.set_block(9, 6, zero.block(0, 3, P, 3) - e.k * C.transposed());
  MatrixPolynomial all = identity(3 + motions);
  all.set_block(3, 3, T);
  e.mass = all.transposed() * (mass_of(mesh, V.nodal) * all);
  e.stations = rows_of(station_rows(mesh, V.nodal)) * T;
  return e;
}

}  // namespace flexopt
