#pragma once
// A linear plate or beam on its mesh and how interface nodes hold it: equations (15)–(17) of
// README.md, written once for numbers and for numbers with their derivatives in the shape
// (w/L, t/L, ν). Lengths over L, energies over D, masses over ρ t L⁴.
#include <Eigen/SparseCore>
#include <array>
#include <cassert>
#include <cmath>
#include <unsupported/Eigen/AutoDiff>
#include <utility>
#include <vector>

#include "core/elements/plate/plate_mesh_rate.hpp"
#include "core/reduction/superelement/plate_body.hpp"

namespace flexopt::linear_plate {

/// A number and its derivatives in w/L, t/L, ν.
using Dual = Eigen::AutoDiffScalar<Vector3d>;

using SparseMatrix = Eigen::SparseMatrix<double>;
template <class S>
using Triplets = std::vector<Eigen::Triplet<S>>;
template <class S>
using MatrixX = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
enum Component { u, v, w };

/// What of a mesh depends on the shape.
template <class S>
struct Operators {
  struct Element {
    Eigen::Matrix<S, 16, 16> gradient, bending, mass;
    Eigen::Matrix<S, PlateMesh::points, 1> weight;
  };
  S width, thickness, poissons_ratio, A11, A12, A33;
  std::vector<S> y;
  std::vector<Element> elements;
};
Operators<double> operators(const PlateMesh& mesh);
Operators<Dual> operators(const PlateMesh& mesh, const PlateMeshRate& rate);

/// Numbers of the nodal dofs, in the order of PlateLeaf::nodal: function k of component c at node
/// (i, j).
struct Dofs {
  int per_line, lines;
  explicit Dofs(const PlateMesh& mesh) : per_line(mesh.functions_per_line()), lines(mesh.lines()) {}
  int operator()(int i, int j, int c, int k) const {
    return 3 * per_line * i + per_line * c + 4 * j + k;
  }
  int count() const { return 3 * per_line * lines; }
};

inline double cell_thickness(const PlateBody& body, int i, int j) {
  return body.cells.size() == 0 ? 1.0 : body.cells(i, j);
}

template <class S>
struct Matrices {
  Triplets<S> stiffness, mass;
};

/// Unconstrained. The membrane takes the integration rule of the plate leaf.
template <class S>
Matrices<S> assemble(const PlateBody& body, const PlateMesh& mesh, const Operators<S>& operators) {
  constexpr int points = PlateMesh::points;
  using Matrix16 = Eigen::Matrix<S, 16, 16>;
  const int nx = mesh.elements_along(), ny = mesh.elements_across(),
            side_functions = mesh.functions_per_side(), functions = 2 * side_functions;
  const S &A11 = operators.A11, &A12 = operators.A12, &A33 = operators.A33;
  const Dofs dof(mesh);
  Matrices<S> result;
  auto &K = result.stiffness, &M = result.mass;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      const double t = cell_thickness(body, i, j);
      if (t == 0) continue;
      const typename Operators<S>::Element& element = operators.elements[i * ny + j];
      Matrix16 bending = S(t * t * t) * element.bending;
      for (int side = 0; side < 2; ++side) {
        if (!body.free_edges[side] || (side == 0 ? j != 0 : j != ny - 1)) continue;
        // −½ G c t⁴ ∫ |r,xy|² ds, c = 0.105, over D; r,xy at an edge is quadratic along it
        const double hx = mesh.x()[i + 1] - mesh.x()[i];
        const S hy = operators.y[j + 1] - operators.y[j];
        const S factor =
            (0.105 * 6 * std::pow(t, 4)) * (1.0 - operators.poissons_ratio) * operators.thickness;
        constexpr double offset = 0.7745966692414834;  // Gauss, three points
        for (const auto& [at, weight] : {std::pair{-offset, 5.0 / 18}, std::pair{0.0, 8.0 / 18},
                                         std::pair{offset, 5.0 / 18}}) {
          const auto Nxy =
              hermite_products<S>(hermite(0.5 + 0.5 * at, hx).slope, hermite<S>(side, hy).slope);
          bending -= S(factor * (weight * hx)) * Nxy * Nxy.transpose();
        }
      }
      std::array<std::array<int, 16>, 3> at;
      for (int c = 0; c < 3; ++c)
        for (int f = 0; f < functions; ++f) {
          const int s = f % side_functions;
          at[c][f] = dof(i + f / side_functions, j + s / 4, c, s % 4);
        }
      const auto Gx = element.gradient.template topRows<points>(),
                 Gy = element.gradient.template bottomRows<points>();
      const Eigen::Matrix<S, points, 1> weight = S(t) * element.weight;
      const Eigen::Matrix<S, points, 16> WGx = weight.asDiagonal() * Gx,
                                         WGy = weight.asDiagonal() * Gy;
      const Matrix16 xx = Gx.transpose() * WGx, yy = Gy.transpose() * WGy,
                     xy = Gx.transpose() * WGy;
      const Matrix16 Kuu = A11 * xx + A33 * yy + bending, Kvv = A11 * yy + A33 * xx + bending,
                     Kuv = A12 * xy + A33 * xy.transpose();
      for (int a = 0; a < functions; ++a)
        for (int b = 0; b < functions; ++b) {
          K.emplace_back(at[u][a], at[u][b], Kuu(a, b));
          K.emplace_back(at[v][a], at[v][b], Kvv(a, b));
          K.emplace_back(at[u][a], at[v][b], Kuv(a, b));
          K.emplace_back(at[v][a], at[u][b], Kuv(b, a));
          K.emplace_back(at[w][a], at[w][b], bending(a, b));
          const S m = t * element.mass(a, b);
          for (int c = 0; c < 3; ++c) M.emplace_back(at[c][a], at[c][b], m);
        }
    }
  return result;
}

/// Nodal dofs as a linear map of interface coordinates and free unknowns.
template <class S>
struct Constraint {
  std::vector<Vector3<S>> nodes;
  MatrixX<S> boundary;    ///< dofs × 6m
  Triplets<double> free;  ///< (dof, unknown, factor)
  int unknowns = 0;
  MatrixX<S> penalty, penalty_mass;  ///< added to K_CB and M_CB; may be empty
  std::vector<bool> held;            ///< dofs already spoken for

  Constraint(int dofs, int m)
      : boundary(MatrixX<S>::Constant(dofs, 6 * m, S(0))), held(dofs, false) {}
  void release(int dof) {
    free.emplace_back(dof, unknowns++, 1.0);
    held[dof] = true;
  }
  void hold(int dof) { held[dof] = true; }
};

/// Linearised rigid edges: r = t + y e2, r,y = e2, r,x = (1 + α) e1 + γ e2, r,xy = α′ e1 + γ′ e2;
/// of a beam as beams.md, "Ends", says.
template <class S>
Constraint<S> rigid_edges(const PlateMesh& mesh, const Operators<S>& operators) {
  const Dofs dof(mesh);
  Constraint<S> c(dof.count(), 2);
  c.nodes = {Vector3<S>(S(0), S(0), S(0)), Vector3<S>(S(1), S(0), S(0))};
  for (int e = 0; e < 2; ++e) {
    const int i = e == 0 ? 0 : mesh.elements_along(), b = 6 * e;
    for (int j = 0; j < mesh.nodes_per_line(); ++j) {
      const S& y = operators.y[j];
      MatrixX<S>& B = c.boundary;
      for (int d = 0; d < 3; ++d) B(dof(i, j, d, 0), b + d) = S(1);
      B(dof(i, j, u, 0), b + 5) = -y;
      B(dof(i, j, w, 0), b + 3) = y;
      B(dof(i, j, u, 2), b + 5) = S(-1);
      B(dof(i, j, w, 2), b + 3) = S(1);
      B(dof(i, j, v, 1), b + 5) = S(1);
      B(dof(i, j, w, 1), b + 4) = S(-1);
      for (int d = 0; d < 3; ++d)
        for (int k = 0; k < 4; ++k) c.hold(dof(i, j, d, k));
      for (const PlateMesh::EdgeSlope& s : mesh.edge_slopes())
        c.release(dof(i, j, s.axis, s.function));
    }
  }
  return c;
}

/// A mesh node: u, v, w and the rotation (w,y, −w,x, ½(v,x − u,y)); the shear v,x + u,y stays free.
template <class S>
Constraint<S> mesh_nodes(const PlateMesh& mesh, const Operators<S>& operators,
                         const std::vector<std::array<int, 2>>& nodes) {
  const Dofs dof(mesh);
  Constraint<S> c(dof.count(), static_cast<int>(nodes.size()));
  for (int a = 0; a < static_cast<int>(nodes.size()); ++a) {
    const auto [i, j] = nodes[a];
    assert(i >= 0 && i < mesh.lines() && j >= 0 && j < mesh.nodes_per_line());
    const int b = 6 * a;
    c.nodes.emplace_back(S(mesh.x()[i]), operators.y[j], S(0));
    for (int d = 0; d < 3; ++d) c.boundary(dof(i, j, d, 0), b + d) = S(1);
    c.boundary(dof(i, j, w, 2), b + 3) = S(1);
    c.boundary(dof(i, j, w, 1), b + 4) = S(-1);
    c.boundary(dof(i, j, v, 1), b + 5) = S(1);
    c.boundary(dof(i, j, u, 2), b + 5) = S(-1);
    for (const int k : {dof(i, j, u, 0), dof(i, j, v, 0), dof(i, j, w, 0), dof(i, j, w, 1),
                        dof(i, j, w, 2), dof(i, j, v, 1), dof(i, j, u, 2)})
      c.hold(k);
    c.free.emplace_back(dof(i, j, v, 1), c.unknowns, 0.5);
    c.free.emplace_back(dof(i, j, u, 2), c.unknowns, 0.5);
    ++c.unknowns;
  }
  return c;
}

/// Sides between four corners. Along a side (tangent s, normal n; length a): w the cubic of the
/// ends' values and slopes, the slope across it linear; the tangential displacement linear; the
/// normal one linear plus Allman's parabola of the ends' drilling rotations (16)
template <class S>
Constraint<S> corners(const PlateMesh& mesh, const Operators<S>& operators) {
  const Dofs dof(mesh);
  const int nx = mesh.elements_along(), ny = mesh.elements_across();
  const S a = S(mesh.x().back() - mesh.x().front()), b = operators.y.back() - operators.y.front();
  Constraint<S> c(dof.count(), 4);
  const std::array<std::array<int, 2>, 4> corner{{{0, 0}, {0, ny}, {nx, 0}, {nx, ny}}};
  for (const auto& [i, j] : corner) c.nodes.emplace_back(S(mesh.x()[i]), operators.y[j], S(0));
  MatrixX<S>& B = c.boundary;

  struct Side {
    int along;          ///< axis it runs along: 0 x, 1 y
    int fixed;          ///< mesh index across
    int first, second;  ///< corners
  };
  const Side sides[] = {{0, 0, 0, 2}, {0, ny, 1, 3}, {1, 0, 0, 1}, {1, nx, 2, 3}};
  for (const Side& side : sides) {
    const bool x = side.along == 0;
    const auto& points = x ? mesh.x() : mesh.y();
    const S length = x ? a : b;
    const int last = x ? nx : ny, tangent = x ? u : v, normal = x ? v : u;
    const int ds = x ? 1 : 2, dn = x ? 2 : 1;  // functions: slope along, slope across
    // w,x = −θ2, w,y = θ1;  drilling: v,x = θ3, u,y = −θ3
    const int slope_s = x ? 4 : 3, slope_n = x ? 3 : 4;
    const double sign_s = x ? -1 : 1, sign_n = x ? 1 : -1, sign_drill = x ? 1 : -1;
    for (int p = 0; p <= last; ++p) {
      const double s = (points[p] - points.front()) / (points.back() - points.front());
      const HermiteValuesT<S> H = hermite<S>(s, length);
      const bool at_corner = p == 0 || p == last;
      const auto row = [&](int component, int k) {
        const int d = x ? dof(p, side.fixed, component, k) : dof(side.fixed, p, component, k);
        c.hold(d);
        return d;
      };
      const int first = 6 * side.first, second = 6 * side.second;
      const auto linear = [&](int value, int slope, int coordinate, double sign) {
        B(value, first + coordinate) = S(sign * (1 - s));
        B(value, second + coordinate) = S(sign * s);
        if (slope < 0) return;
        B(slope, first + coordinate) = -sign / length;
        B(slope, second + coordinate) = sign / length;
      };
      const int value = row(w, 0), slope = row(w, ds);
      for (int end = 0; end < 2; ++end) {
        const int o = end == 0 ? first : second;
        B(value, o + 2) = H.value[2 * end];
        B(value, o + slope_s) = sign_s * H.value[2 * end + 1];
        B(slope, o + 2) = H.slope[2 * end];
        B(slope, o + slope_s) = sign_s * H.slope[2 * end + 1];
      }
      // the two sides of a corner disagree about w,xy: their mean
      linear(row(w, dn), -1, slope_n, sign_n);
      const int twist = row(w, 3);
      const double share = at_corner ? 0.5 : 1;
      B(twist, first + slope_n) += -share * sign_n / length;
      B(twist, second + slope_n) += share * sign_n / length;

      linear(row(tangent, 0), row(tangent, ds), tangent, 1);
      const int nvalue = row(normal, 0), nslope = row(normal, ds);
      linear(nvalue, nslope, normal, 1);
      for (int end = 0; end < 2; ++end) {
        const int o = end == 0 ? first : second;
        const double sign = (end == 0 ? -1 : 1) * sign_drill;
        B(nvalue, o + 5) = (-sign * 0.5 * s * (1 - s)) * length;
        B(nslope, o + 5) = S(-sign * 0.5 * (1 - 2 * s));
      }
    }
  }

  // Hughes and Brezzi's penalty on the difference of mean drilling rotation and mean continuum
  // rotation ½ ∮ (v nx − u ny) ds / ab: without it equal drilling rotations store no energy (17)
  Eigen::Matrix<S, Eigen::Dynamic, 1> difference =
      Eigen::Matrix<S, Eigen::Dynamic, 1>::Constant(24, S(0));
  for (int k = 0; k < 4; ++k) {
    difference[6 * k + 5] = S(0.25);
    difference[6 * k + v] = (k >= 2 ? -0.25 : 0.25) / a;
    difference[6 * k + u] = (k % 2 == 1 ? 0.25 : -0.25) / b;
  }
  const S shear = 0.5 * (1.0 - operators.poissons_ratio) * operators.A11;  // G t L²/D
  const S area = a * b;
  c.penalty = S(shear * area) * difference * difference.transpose();
  // and with its inertia M_CB is regular; rigid motions do not feel it
  c.penalty_mass = S(area * (a * a + b * b) / 12.0) * difference * difference.transpose();
  return c;
}

template <class S>
Constraint<S> constraint(const PlateMesh& mesh, const Operators<S>& operators,
                         const PlateCondensation& condensation) {
  switch (condensation.interface) {
    case Interface::rigid_edges:
      return rigid_edges(mesh, operators);
    case Interface::corners:
      return corners(mesh, operators);
    case Interface::mesh_nodes:
      break;
  }
  return mesh_nodes(mesh, operators, condensation.mesh_nodes);
}

/// Rows of the displacement and rotation (w,y, −w,x, ½(v,x − u,y)) in the middle.
template <class S>
MatrixX<S> motion_of_middle(const PlateMesh& mesh, const Operators<S>& operators) {
  const auto locate = [](const std::vector<double>& points, double s) {
    int i = 0;
    while (i + 2 < static_cast<int>(points.size()) && s > points[i + 1]) ++i;
    return i;
  };
  const Dofs dof(mesh);
  const int i = locate(mesh.x(), 0.5), side = mesh.functions_per_side();
  const double hx = mesh.x()[i + 1] - mesh.x()[i];
  const HermiteValues X = hermite((0.5 - mesh.x()[i]) / hx, hx);
  Eigen::Matrix<S, 16, 1> N, Nx, Ny;
  int j = 0;
  if (mesh.shape().is_beam()) {
    N = beam_functions(X.value, 1, 0).template cast<S>();
    Nx = beam_functions(X.slope, 1, 0).template cast<S>();
    Ny = beam_functions(X.value, 0, 1).template cast<S>();
  } else {
    j = locate(mesh.y(), 0);
    const HermiteValuesT<S> Y = hermite<S>(-mesh.y()[j] / (mesh.y()[j + 1] - mesh.y()[j]),
                                           operators.y[j + 1] - operators.y[j]);
    N = hermite_products<S>(X.value, Y.value);
    Nx = hermite_products<S>(X.slope, Y.value);
    Ny = hermite_products<S>(X.value, Y.slope);
  }
  MatrixX<S> rows = MatrixX<S>::Constant(6, dof.count(), S(0));
  for (int f = 0; f < 2 * side; ++f) {
    const int s = f % side;
    const auto at = [&](int c) { return dof(i + f / side, j + s / 4, c, s % 4); };
    for (int c = 0; c < 3; ++c) rows(c, at(c)) = N[f];
    rows(3, at(w)) = Ny[f];
    rows(4, at(w)) = -Nx[f];
    rows(5, at(v)) = 0.5 * Nx[f];
    rows(5, at(u)) = -0.5 * Ny[f];
  }
  return rows;
}

}  // namespace flexopt::linear_plate
