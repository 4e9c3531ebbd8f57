#include "core/reduction/plate_body.hpp"

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <cassert>
#include <cmath>

#include "core/math/lanczos.hpp"

namespace flexopt {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;
using Matrix16 = PlateMesh::Matrix16;
enum Component { u, v, w };

/// Numbers of the nodal dofs, in the order of PlateLeaf::nodal: function k (value, ∂x, ∂y, ∂xy) of
/// component c at node (i, j).
struct Dofs {
  int per_line;
  explicit Dofs(const PlateMesh& mesh) : per_line(mesh.functions_per_line()) {}
  int operator()(int i, int j, int c, int k) const {
    return 3 * per_line * i + per_line * c + 4 * j + k;
  }
};

double cell_thickness(const PlateBody& body, int i, int j) {
  return body.cells.size() == 0 ? 1.0 : body.cells(i, j);
}

struct SparsePlate {
  SparseMatrix stiffness, mass;
};

// Over D and ρ t L⁴. The membrane takes the integration rule of the plate leaf.
SparsePlate assemble(const PlateBody& body, const PlateMesh& mesh) {
  constexpr int points = PlateMesh::points;
  const int nx = mesh.elements_along(), ny = mesh.elements_across();
  const double nu = mesh.shape().poissons_ratio, A11 = mesh.membrane().A11, A12 = nu * A11,
               A33 = 0.5 * (1 - nu) * A11;
  const Dofs dof(mesh);
  Triplets K, M;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      const double t = cell_thickness(body, i, j);
      if (t == 0) continue;
      const PlateMesh::Element& element = mesh.element(i, j);
      const double hx = mesh.x()[i + 1] - mesh.x()[i], hy = mesh.y()[j + 1] - mesh.y()[j];
      Matrix16 bending = t * t * t * element.bending;
      for (int side = 0; side < 2; ++side) {
        if (!body.free_edges[side] || (side == 0 ? j != 0 : j != ny - 1)) continue;
        // −½ G c t⁴ ∫ |r,xy|² ds, c = 0.105, over D; r,xy at an edge is quadratic along it
        const double factor = 0.105 * 6 * (1 - nu) * mesh.shape().thickness * std::pow(t, 4);
        constexpr double offset = 0.7745966692414834;  // Gauss, three points
        for (const auto& [at, weight] : {std::pair{-offset, 5.0 / 18}, std::pair{0.0, 8.0 / 18},
                                         std::pair{offset, 5.0 / 18}}) {
          const auto Nxy =
              hermite_products(hermite(0.5 + 0.5 * at, hx).slope, hermite(side, hy).slope);
          bending -= factor * weight * hx * Nxy * Nxy.transpose();
        }
      }
      std::array<std::array<int, 16>, 3> at;
      for (int c = 0; c < 3; ++c)
        for (int p = 0; p < 2; ++p)
          for (int q = 0; q < 2; ++q)
            for (int k = 0; k < 4; ++k) at[c][8 * p + 4 * q + k] = dof(i + p, j + q, c, k);
      const auto Gx = element.gradient.topRows<points>(),
                 Gy = element.gradient.bottomRows<points>();
      const Eigen::Matrix<double, points, 1> weight = t * element.weight;
      const auto W = weight.asDiagonal();
      const Matrix16 xx = Gx.transpose() * W * Gx, yy = Gy.transpose() * W * Gy,
                     xy = Gx.transpose() * W * Gy;
      const Matrix16 Kuu = A11 * xx + A33 * yy, Kvv = A11 * yy + A33 * xx,
                     Kuv = A12 * xy + A33 * xy.transpose();
      for (int a = 0; a < 16; ++a)
        for (int b = 0; b < 16; ++b) {
          K.emplace_back(at[u][a], at[u][b], Kuu(a, b) + bending(a, b));
          K.emplace_back(at[v][a], at[v][b], Kvv(a, b) + bending(a, b));
          K.emplace_back(at[u][a], at[v][b], Kuv(a, b));
          K.emplace_back(at[v][a], at[u][b], Kuv(b, a));
          K.emplace_back(at[w][a], at[w][b], bending(a, b));
          for (int c = 0; c < 3; ++c) M.emplace_back(at[c][a], at[c][b], t * element.mass(a, b));
        }
    }
  const int n = 3 * dof.per_line * mesh.lines();
  SparsePlate plate{SparseMatrix(n, n), SparseMatrix(n, n)};
  plate.stiffness.setFromTriplets(K.begin(), K.end());
  plate.mass.setFromTriplets(M.begin(), M.end());
  return plate;
}

/// Nodal dofs as a linear map of interface coordinates (over L) and free unknowns.
struct Constraint {
  std::vector<Vector3d> nodes;  ///< over L
  MatrixXd boundary;            ///< dofs × 6m
  Triplets free;                ///< (dof, unknown, factor)
  int unknowns = 0;
  MatrixXd penalty;  ///< added to K_CB, over D
  MatrixXd penalty_mass;

  Constraint(int dofs, int m) : boundary(MatrixXd::Zero(dofs, 6 * m)), held(dofs, false) {}
  void release(int dof) {
    free.emplace_back(dof, unknowns++, 1.0);
    held[dof] = true;
  }
  void hold(int dof) { held[dof] = true; }
  std::vector<bool> held;  ///< dofs already spoken for
};

bool in_use(const PlateBody& body, const PlateMesh& mesh, int i, int j) {
  for (int p = i - 1; p <= i; ++p)
    for (int q = j - 1; q <= j; ++q)
      if (p >= 0 && q >= 0 && p < mesh.elements_along() && q < mesh.elements_across() &&
          cell_thickness(body, p, q) > 0)
        return true;
  return false;
}

// Linearised rigid edges: r = t + y e2, r,y = e2, r,x = (1 + α) e1 + γ e2, r,xy = α′ e1 + γ′ e2.
Constraint rigid_edges(const PlateMesh& mesh, int dofs) {
  const Dofs dof(mesh);
  Constraint c(dofs, 2);
  c.nodes = {Vector3d::Zero(), Vector3d::UnitX()};
  for (int e = 0; e < 2; ++e) {
    const int i = e == 0 ? 0 : mesh.elements_along(), b = 6 * e;
    for (int j = 0; j < mesh.nodes_per_line(); ++j) {
      const double y = mesh.y()[j];
      MatrixXd& B = c.boundary;
      for (int d = 0; d < 3; ++d) B(dof(i, j, d, 0), b + d) = 1;
      B(dof(i, j, u, 0), b + 5) = -y;
      B(dof(i, j, w, 0), b + 3) = y;
      B(dof(i, j, u, 2), b + 5) = -1;
      B(dof(i, j, w, 2), b + 3) = 1;
      B(dof(i, j, v, 1), b + 5) = 1;
      B(dof(i, j, w, 1), b + 4) = -1;
      for (int d = 0; d < 3; ++d)
        for (int k = 0; k < 4; ++k) c.hold(dof(i, j, d, k));
      for (const int d : {u, v})
        for (const int k : {1, 3}) c.release(dof(i, j, d, k));
    }
  }
  return c;
}

// A mesh node: u, v, w and the rotation (w,y, −w,x, ½(v,x − u,y)); the shear v,x + u,y stays free.
Constraint mesh_nodes(const PlateMesh& mesh, int dofs,
                      const std::vector<std::array<int, 2>>& nodes) {
  const Dofs dof(mesh);
  Constraint c(dofs, static_cast<int>(nodes.size()));
  for (int a = 0; a < static_cast<int>(nodes.size()); ++a) {
    const auto [i, j] = nodes[a];
    assert(i >= 0 && i < mesh.lines() && j >= 0 && j < mesh.nodes_per_line());
    const int b = 6 * a;
    c.nodes.emplace_back(mesh.x()[i], mesh.y()[j], 0);
    for (int d = 0; d < 3; ++d) c.boundary(dof(i, j, d, 0), b + d) = 1;
    c.boundary(dof(i, j, w, 2), b + 3) = 1;
    c.boundary(dof(i, j, w, 1), b + 4) = -1;
    c.boundary(dof(i, j, v, 1), b + 5) = 1;
    c.boundary(dof(i, j, u, 2), b + 5) = -1;
    for (const int k : {dof(i, j, u, 0), dof(i, j, v, 0), dof(i, j, w, 0), dof(i, j, w, 1),
                        dof(i, j, w, 2), dof(i, j, v, 1), dof(i, j, u, 2)})
      c.hold(k);
    c.free.emplace_back(dof(i, j, v, 1), c.unknowns, 0.5);
    c.free.emplace_back(dof(i, j, u, 2), c.unknowns, 0.5);
    ++c.unknowns;
  }
  return c;
}

// Sides between four corners. Along a side (tangent s, normal n; length a): w the cubic of the
// ends' values and slopes, the slope across it linear; the tangential displacement linear; the
// normal one linear plus Allman's parabola of the ends' drilling rotations (16)
Constraint corners(const PlateMesh& mesh, int dofs) {
  const Dofs dof(mesh);
  const int nx = mesh.elements_along(), ny = mesh.elements_across();
  const double a = mesh.x().back() - mesh.x().front(), b = mesh.y().back() - mesh.y().front();
  Constraint c(dofs, 4);
  const std::array<std::array<int, 2>, 4> corner{{{0, 0}, {0, ny}, {nx, 0}, {nx, ny}}};
  for (const auto& [i, j] : corner) c.nodes.emplace_back(mesh.x()[i], mesh.y()[j], 0);
  MatrixXd& B = c.boundary;

  struct Side {
    int along;          ///< axis it runs along: 0 x, 1 y
    int fixed;          ///< mesh index across
    int first, second;  ///< corners
  };
  const Side sides[] = {{0, 0, 0, 2}, {0, ny, 1, 3}, {1, 0, 0, 1}, {1, nx, 2, 3}};
  for (const Side& side : sides) {
    const bool x = side.along == 0;
    const auto& points = x ? mesh.x() : mesh.y();
    const double length = x ? a : b;
    const int last = x ? nx : ny, tangent = x ? u : v, normal = x ? v : u;
    const int ds = x ? 1 : 2, dn = x ? 2 : 1;  // functions: slope along, slope across
    // w,x = −θ2, w,y = θ1;  drilling: v,x = θ3, u,y = −θ3
    const int slope_s = x ? 4 : 3, slope_n = x ? 3 : 4;
    const double sign_s = x ? -1 : 1, sign_n = x ? 1 : -1, sign_drill = x ? 1 : -1;
    for (int p = 0; p <= last; ++p) {
      const double s = (points[p] - points[0]) / length;
      const HermiteValues H = hermite(s, length);
      const bool at_corner = p == 0 || p == last;
      const auto row = [&](int component, int k) {
        const int d = x ? dof(p, side.fixed, component, k) : dof(side.fixed, p, component, k);
        c.hold(d);
        return d;
      };
      const int first = 6 * side.first, second = 6 * side.second;
      const auto linear = [&](int value, int slope, int coordinate, double sign) {
        B(value, first + coordinate) = sign * (1 - s);
        B(value, second + coordinate) = sign * s;
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
        B(nvalue, o + 5) = -sign * 0.5 * length * s * (1 - s);
        B(nslope, o + 5) = -sign * 0.5 * (1 - 2 * s);
      }
    }
  }

  // Hughes and Brezzi's penalty on the difference of mean drilling rotation and mean continuum
  // rotation ½ ∮ (v nx − u ny) ds / ab: without it equal drilling rotations store no energy (17)
  VectorXd difference = VectorXd::Zero(24);
  for (int k = 0; k < 4; ++k) {
    difference[6 * k + 5] = 0.25;
    difference[6 * k + v] -= (k >= 2 ? 1 : -1) * 0.25 / a;
    difference[6 * k + u] += (k % 2 == 1 ? 1 : -1) * 0.25 / b;
  }
  const double shear = 0.5 * (1 - mesh.shape().poissons_ratio) * mesh.membrane().A11;  // G t L²/D
  c.penalty = shear * a * b * difference * difference.transpose();
  // and with its inertia M_CB is regular; rigid motions do not feel it
  c.penalty_mass = a * b * (a * a + b * b) / 12 * difference * difference.transpose();
  return c;
}

// Rows of the displacement and rotation (w,y, −w,x, ½(v,x − u,y)) at a place.
MatrixXd motion_at(const PlateMesh& mesh, double x, double y, int dofs) {
  const auto locate = [](const std::vector<double>& points, double s) {
    int i = 0;
    while (i + 2 < static_cast<int>(points.size()) && s > points[i + 1]) ++i;
    return i;
  };
  const Dofs dof(mesh);
  const int i = locate(mesh.x(), x), j = locate(mesh.y(), y);
  const double hx = mesh.x()[i + 1] - mesh.x()[i], hy = mesh.y()[j + 1] - mesh.y()[j];
  const HermiteValues X = hermite((x - mesh.x()[i]) / hx, hx),
                      Y = hermite((y - mesh.y()[j]) / hy, hy);
  const auto N = hermite_products(X.value, Y.value), Nx = hermite_products(X.slope, Y.value),
             Ny = hermite_products(X.value, Y.slope);
  MatrixXd rows = MatrixXd::Zero(6, dofs);
  for (int p = 0; p < 2; ++p)
    for (int q = 0; q < 2; ++q)
      for (int k = 0; k < 4; ++k) {
        const int f = 8 * p + 4 * q + k;
        for (int c = 0; c < 3; ++c) rows(c, dof(i + p, j + q, c, k)) = N[f];
        rows(3, dof(i + p, j + q, w, k)) = Ny[f];
        rows(4, dof(i + p, j + q, w, k)) = -Nx[f];
        rows(5, dof(i + p, j + q, v, k)) = 0.5 * Nx[f];
        rows(5, dof(i + p, j + q, u, k)) = -0.5 * Ny[f];
      }
  return rows;
}

}  // namespace

std::shared_ptr<const PlateMesh> plate_body_mesh(const PlateBody& body) {
  return std::make_shared<PlateMesh>(plate_shape(body.plate, body.mesh, false));
}

PlateMatrices plate_matrices(const PlateBody& body, const PlateMesh& mesh) {
  const SparsePlate plate = assemble(body, mesh);
  return {MatrixXd(plate.stiffness), MatrixXd(plate.mass)};
}

CondensedPlate condense(const PlateBody& body, const PlateCondensation& condensation) {
  const auto mesh = plate_body_mesh(body);
  const int nx = mesh->elements_along(), ny = mesh->elements_across();
  assert(body.cells.size() == 0 || (body.cells.rows() == nx && body.cells.cols() == ny));
  const Dofs dof(*mesh);
  const int dofs = 3 * dof.per_line * mesh->lines();
  Constraint constraint = condensation.interface == Interface::rigid_edges
                              ? rigid_edges(*mesh, dofs)
                          : condensation.interface == Interface::corners
                              ? corners(*mesh, dofs)
                              : mesh_nodes(*mesh, dofs, condensation.mesh_nodes);
  for (int i = 0; i <= nx; ++i)
    for (int j = 0; j <= ny; ++j)
      if (in_use(body, *mesh, i, j))
        for (int c = 0; c < 3; ++c)
          for (int k = 0; k < 4; ++k)
            if (!constraint.held[dof(i, j, c, k)]) constraint.release(dof(i, j, c, k));

  const SparsePlate plate = assemble(body, *mesh);
  SparseMatrix free(dofs, constraint.unknowns);
  free.setFromTriplets(constraint.free.begin(), constraint.free.end());
  const MatrixXd& B = constraint.boundary;
  const SparseMatrix K_ff = free.transpose() * plate.stiffness * free;
  const Eigen::SimplicialLDLT<SparseMatrix> factor(K_ff);
  assert(factor.info() == Eigen::Success);

  // boundary modes Φ = B − F K_ff⁻¹ Fᵀ K B, vibration modes F ψ (15)
  const int nb = static_cast<int>(B.cols());
  const MatrixXd KB = plate.stiffness * B;
  const MatrixXd inner = factor.solve(MatrixXd(free.transpose() * KB));
  const MatrixXd boundary = B - free * inner;
  int modes = std::min(condensation.vibration_modes, constraint.unknowns / 4);
  LowestPairs pairs;
  if (modes > 0) {
    const SparseMatrix M_ff = free.transpose() * plate.mass * free;
    pairs = lowest_pairs(
        constraint.unknowns, modes, [&](const VectorXd& x) -> VectorXd { return factor.solve(x); },
        [&](const VectorXd& x) -> VectorXd { return M_ff * x; });
    assert(pairs.converged);
  }
  MatrixXd Phi(dofs, nb + modes);
  Phi.leftCols(nb) = boundary;
  if (modes > 0) Phi.rightCols(modes) = free * pairs.vectors;

  LeafSpring flat = body.plate;
  flat.origin.setZero();
  flat.axes.setIdentity();
  CondensedPlate result{mesh, LeafScale(flat), 0.5 * flat.length * Vector3d::UnitX(), {}};
  const LeafScale& scale = result.scale;
  SuperelementModel& model = result.superelement;
  for (const Vector3d& node : constraint.nodes)
    model.nodes.push_back(scale.length * node - result.frame_point);
  MatrixXd K = Phi.transpose() * (plate.stiffness * Phi), M = Phi.transpose() * (plate.mass * Phi);
  K.topRightCorner(nb, modes).setZero();
  K.bottomLeftCorner(modes, nb).setZero();
  if (constraint.penalty.size() > 0) {
    K.topLeftCorner(nb, nb) += constraint.penalty;
    M.topLeftCorner(nb, nb) += constraint.penalty_mass;
  }
  // SI: displacements over L; modes of unit mass
  VectorXd unit = VectorXd::Ones(nb + modes);
  for (int i = 0; i < nb; i += 6) unit.segment<3>(i).setConstant(1 / scale.length);
  unit.tail(modes).setConstant(1 / std::sqrt(scale.mass));
  model.stiffness =
      0.5 * scale.energy * unit.asDiagonal() * (K + K.transpose()) * unit.asDiagonal();
  model.mass = 0.5 * scale.mass * unit.asDiagonal() * (M + M.transpose()) * unit.asDiagonal();
  Vector6d frame_unit;
  frame_unit << scale.length, scale.length, scale.length, 1, 1, 1;
  model.frame_modes = frame_unit.asDiagonal() * (motion_at(*mesh, 0.5, 0, dofs) * boundary) *
                      unit.head(nb).asDiagonal();
  model.recovery = boundary * unit.head(nb).asDiagonal();
  return result;
}

}  // namespace flexopt
