#include "core/reduction/expansion/dynamics_expansion.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace flexopt {
namespace {

constexpr int P = field_loads;

// Rows of a nodal vector: line by line, component by component.
Eigen::Index nodal_row(const PlateMesh& mesh, int line, int component, int function) {
  return (3 * line + component) * mesh.functions_per_line() + function;
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

// ---------------------------------------------------------------------------- loads

// Value and slope of a function on [0, 1].
struct Sample {
  double value, slope;
};

// The a-th mode of a beam, a ≥ 1: between clamps, or free (of free ends 1 and y come before it).
Sample beam_mode(int a, bool clamped, double x) {
  constexpr double first[4] = {4.730040744862704, 7.853204624095838, 10.99560783800167,
                               14.13716549125746};
  const double beta = a <= 4 ? first[a - 1] : (a + 0.5) * std::numbers::pi;
  const double ratio = (std::cosh(beta) - std::cos(beta)) / (std::sinh(beta) - std::sin(beta));
  const double sign = clamped ? -1 : 1, b = beta * x;
  return {std::cosh(b) + sign * std::cos(b) - ratio * (std::sinh(b) + sign * std::sin(b)),
          beta * (std::sinh(b) - sign * std::sin(b) - ratio * (std::cosh(b) + sign * std::cos(b)))};
}

// Across the width: 1, y, then the modes of a free beam; y over the width from its middle.
Sample across_function(int b, double y) {
  if (b == 0) return {1, 0};
  if (b == 1) return {2 * y, 2};
  return beam_mode(b - 1, false, y + 0.5);
}

// Bending modes of a flat leaf between clamps by the half waves along and the nodal lines across;
// `across` −1: bending in the plane of the leaf.
struct LoadShape {
  int along, across;
};
constexpr int in_plane = -1;
// What the lowest modes of leaves of all widths look like: those of a narrow one have half waves
// along, those of a wide one nodal lines across; without bending in the plane the frequencies of a
// narrow one that is swung sideways are off by 1.7 %.
constexpr std::array<LoadShape, P> load_shapes{
    {{1, 0}, {2, 0}, {3, 0}, {1, 1}, {2, 1}, {1, 2}, {2, 2}, {1, 3}, {1, 4}, {1, in_plane}}};

VectorXd nodal_shape(const PlateMesh& mesh, const LoadShape& shape) {
  const double width = mesh.shape().width;
  VectorXd nodal = VectorXd::Zero(3 * mesh.functions_per_line() * mesh.lines());
  for (int i = 0; i < mesh.lines(); ++i) {
    const Sample X = beam_mode(shape.along, true, mesh.x()[i]);
    for (int j = 0; j < mesh.nodes_per_line(); ++j) {
      const bool plane = shape.across == in_plane;
      const Sample Y = across_function(plane ? 0 : shape.across, mesh.y()[j] / width);
      const Eigen::Index row = nodal_row(mesh, i, plane ? 1 : 2, 4 * j);
      nodal[row] = X.value * Y.value;
      nodal[row + 1] = X.slope * Y.value;
      nodal[row + 2] = X.value * Y.slope / width;
      nodal[row + 3] = X.slope * Y.slope / width;
    }
  }
  return nodal;
}

}  // namespace

LoadParity load_parity() {
  LoadParity parity;
  for (int p = 0; p < P; ++p) {
    const int across = load_shapes[p].across;
    parity.normal[p] = across == in_plane ? 1 : -1;
    parity.across[p] = across == in_plane || across % 2 == 1 ? -1 : 1;
  }
  return parity;
}

// The interpolated shapes of a coarse mesh are not orthogonal: that of four nodal lines across has
// a mean, which bends a narrow leaf far more than the rest of it does, so that the loads would
// differ from each other by rounding alone. Each shape is therefore freed of those before it.
InternalLoads internal_loads(const PlateMesh& mesh) {
  const Eigen::Index rows = 3 * mesh.functions_per_line() * mesh.lines();
  InternalLoads result{MatrixXd(rows, P), load_parity()};
  const LoadParity& parity = result.parity;
  MatrixXd shapes(rows, P);
  for (int p = 0; p < P; ++p) {
    VectorXd shape = nodal_shape(mesh, load_shapes[p]), load = nodal_mass_times(mesh, shape);
    for (int q = 0; q < p; ++q)
      if (parity.normal[q] == parity.normal[p] && parity.across[q] == parity.across[p]) {
        const double share = load.dot(shapes.col(q));
        shape -= share * shapes.col(q);
        load -= share * result.loads.col(q);
      }
    const double size = std::sqrt(load.dot(shape));
    shapes.col(p) = shape / size;
    result.loads.col(p) = load / size;
  }
  return result;
}

namespace {

// The motions whose mass is wanted, nodal values: columns of one monomial after the other, each
// (turns about the base 3, per x 6, per load P).
constexpr int motions = 9 + P;
struct Motions {
  MatrixXd nodal;  ///< motions of the nodes for all 28 monomials
  MatrixXd stiff;  ///< stiff deformations (u, θ1z, θ2z) in rows, for all 28 monomials
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
  const FieldExpansion by_load = expand_load_fields(leaf, ray, fields.fields, loads);
  const MatrixXd& r = fields.nodal;
  const Eigen::Index m = table.size();
  const Eigen::Matrix2d per_rotation = ray.inverse();
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
    // from rates of (σ, τ) to those of the ends' rotations
    all.nodal.middleCols<2>(o + 3) = (all.nodal.middleCols<2>(o + 3) * per_rotation).eval();
    all.stiff.middleCols<2>(o + 3) = (all.stiff.middleCols<2>(o + 3) * per_rotation).eval();
    for (int p = 0; p < P; ++p) {
      all.nodal.col(o + 9 + p) = by_load.nodal.col(p * m + k);
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

// Matrix polynomial of some rows of the motions.
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
