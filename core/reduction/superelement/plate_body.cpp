#include "core/reduction/superelement/plate_body.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/elements/plate/element_numbers.hpp"
#include "core/math/lanczos.hpp"

namespace flexopt {
namespace {

using Matrix16 = PlateMesh::Matrix16;
using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;
enum Component { u, v, w };

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

/// Nodal dofs as a linear map of interface coordinates and free unknowns, (R11)–(R13) of README.md:
/// the part that the shape does not enter.
struct FreeDofs {
  Triplets free;  ///< (dof, unknown, 1)
  int unknowns = 0;
  std::vector<bool> held;  ///< dofs already spoken for

  explicit FreeDofs(const PlateMesh& mesh) : held(Dofs(mesh).count(), false) {}
  void release(int dof) {
    free.emplace_back(dof, unknowns++, 1.0);
    held[dof] = true;
  }
  void hold(int dof) { held[dof] = true; }
};

/// The part that the shape enters, for m interface nodes. Lengths over L, energies over D, masses
/// over ρ t L⁴.
struct Interfaces {
  std::vector<Vector3d> nodes;
  MatrixXd boundary;               ///< dofs × 6m
  MatrixXd penalty, penalty_mass;  ///< 6m × 6m, added to K_CB and M_CB; may be empty
};

// Rows and columns of an element's matrices of one displacement component.
struct ElementMatrices {
  Matrix16 uu, vv, uv, bending, mass;
};

// The membrane's share, for the area weights of e11, e22 (the same) and 2 e12.
void set_membrane(ElementMatrices& to, const PlateMesh::Membrane& A, const Matrix16& gradient,
                  const PlateMesh::Weights& weight) {
  constexpr int points = PlateMesh::points;
  using Points16 = Eigen::Matrix<double, points, 16>;
  const Points16 x = gradient.topRows<points>(), y = gradient.bottomRows<points>();
  const auto product = [&](const Points16& left, int strain, const Points16& right) {
    return Matrix16(left.transpose() * (weight.col(strain).matrix().asDiagonal() * right));
  };
  to.uu = A.A11 * product(x, 0, x) + A.A33 * product(y, 2, y);
  to.vv = A.A11 * product(y, 0, y) + A.A33 * product(x, 2, x);
  to.uv = A.A12 * product(x, 0, y) + A.A33 * product(y, 2, x);
}

// Elements at a free edge that are narrower than this times t have a smaller c of (E2), in
// proportion.
constexpr double least_edge_element = 0.6;

// ½ G c t⁴ ∫ |r,xy|² ds along a free edge, over D; r,xy at an edge is quadratic along it.
Matrix16 edge_torsion(const PlateMesh& mesh, int i, int j, int side) {
  const PlateShape& shape = mesh.shape();
  const double hx = mesh.x()[i + 1] - mesh.x()[i], hy = mesh.y()[j + 1] - mesh.y()[j],
               t = shape.thickness;
  double factor = 6 * free_edge_coefficient * (1.0 - shape.poissons_ratio) * t;
  if (hy < least_edge_element * t) factor *= hy / (least_edge_element * t);
  constexpr double offset = 0.7745966692414834;  // Gauss, three points
  Matrix16 torsion = Matrix16::Zero();
  for (const auto& [at, weight] :
       {std::pair{-offset, 5.0 / 18}, std::pair{0.0, 8.0 / 18}, std::pair{offset, 5.0 / 18}}) {
    const Eigen::Matrix<double, 16, 1> Nxy =
        hermite_products(hermite(0.5 + 0.5 * at, hx).slope, hermite(side, hy).slope);
    torsion += (factor * weight * hx) * Nxy * Nxy.transpose();
  }
  return torsion;
}

ElementMatrices element_matrices(const PlateBody& body, const PlateMesh& mesh, int i, int j) {
  const PlateMesh::Element& element = mesh.element(i, j);
  ElementMatrices e;
  e.bending = element.bending;
  if (!mesh.shape().free_edge_torsion)  // else the mesh has it
    for (int side = 0; side < 2; ++side)
      if (body.free_edges[side] && j == (side == 0 ? 0 : mesh.elements_across() - 1))
        e.bending -= edge_torsion(mesh, i, j, side);
  set_membrane(e, mesh.membrane(), element.gradient, element.weight);
  e.mass = element.mass;
  return e;
}

/// Unconstrained, dofs × dofs. The membrane takes the integration rule of the plate leaf.
struct Matrices {
  Sparse stiffness, mass;
};

Matrices assemble(const PlateBody& body, const PlateMesh& mesh) {
  const Dofs dof(mesh);
  const int side = mesh.functions_per_side(), functions = 2 * side;
  Triplets K, M;
  for (int i = 0; i < mesh.elements_along(); ++i)
    for (int j = 0; j < mesh.elements_across(); ++j) {
      const ElementMatrices e = element_matrices(body, mesh, i, j);
      std::array<std::array<int, 16>, 3> at;
      for (int c = 0; c < 3; ++c)
        for (int f = 0; f < functions; ++f) {
          const int s = f % side;
          at[c][f] = dof(i + f / side, j + s / 4, c, s % 4);
        }
      for (int a = 0; a < functions; ++a)
        for (int b = 0; b < functions; ++b) {
          K.emplace_back(at[u][a], at[u][b], e.uu(a, b) + e.bending(a, b));
          K.emplace_back(at[v][a], at[v][b], e.vv(a, b) + e.bending(a, b));
          K.emplace_back(at[u][a], at[v][b], e.uv(a, b));
          K.emplace_back(at[v][a], at[u][b], e.uv(b, a));
          K.emplace_back(at[w][a], at[w][b], e.bending(a, b));
          for (int c = 0; c < 3; ++c) M.emplace_back(at[c][a], at[c][b], e.mass(a, b));
        }
    }
  Matrices result{Sparse(dof.count(), dof.count()), Sparse(dof.count(), dof.count())};
  result.stiffness.setFromTriplets(K.begin(), K.end());
  result.mass.setFromTriplets(M.begin(), M.end());
  return result;
}

Interfaces no_interfaces(int dofs, int nodes) {
  Interfaces none;
  none.boundary = MatrixXd::Zero(dofs, 6 * nodes);
  return none;
}

// Linearised rigid edges: r = t + y e2, r,y = e2, r,x = (1 + α) e1 + γ e2, r,xy = α′ e1 + γ′ e2;
// of a beam as beams.md, "Ends", says.
Interfaces rigid_edges(const PlateMesh& mesh, FreeDofs& free) {
  const Dofs dof(mesh);
  Interfaces c = no_interfaces(dof.count(), 2);
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
        for (int k = 0; k < 4; ++k) free.hold(dof(i, j, d, k));
      for (const PlateMesh::EdgeSlope& s : mesh.edge_slopes())
        free.release(dof(i, j, s.axis, s.function));
    }
  }
  return c;
}

// A side between two of four corners, tangent s, normal n, length a: w is the cubic of the ends'
// values and slopes, the slope across it linear; the tangential displacement is linear; the normal
// one linear plus Allman's parabola of the ends' drilling rotations (R12).
struct Side {
  int along;                  ///< axis it runs along: 0 x, 1 y
  int fixed;                  ///< mesh index across
  std::array<int, 2> corner;  ///< its ends
};
void hold_side(const PlateMesh& mesh, const Side& side, MatrixXd& B, FreeDofs& free) {
  const Dofs dof(mesh);
  const bool x = side.along == 0;
  const auto& points = x ? mesh.x() : mesh.y();
  const double length = points.back() - points.front();
  const int tangent = x ? u : v, normal = x ? v : u;
  const int ds = x ? 1 : 2, dn = x ? 2 : 1;  // functions: slope along, slope across
  // w,x = −θ2, w,y = θ1;  drilling: v,x = θ3, u,y = −θ3
  const int slope_s = x ? 4 : 3, slope_n = x ? 3 : 4;
  const double sign_s = x ? -1 : 1, sign_n = x ? 1 : -1, sign_drill = x ? 1 : -1;
  const int last = static_cast<int>(points.size()) - 1;
  for (int p = 0; p <= last; ++p) {
    const double s = (points[p] - points.front()) / length;
    const HermiteValues H = hermite(s, length);
    const auto row = [&](int component, int k) {
      const int d = x ? dof(p, side.fixed, component, k) : dof(side.fixed, p, component, k);
      free.hold(d);
      return d;
    };
    const int value = row(w, 0), slope = row(w, ds), across = row(w, dn), twist = row(w, 3),
              along = row(tangent, 0), stretch = row(tangent, ds), beside = row(normal, 0),
              turn = row(normal, ds);
    // the two sides of a corner disagree about w,xy: their mean
    const double share = p == 0 || p == last ? 0.5 : 1;
    for (int end = 0; end < 2; ++end) {
      const int o = 6 * side.corner[end];
      const double linear = end == 0 ? 1 - s : s, rate = (end == 0 ? -1 : 1) / length,
                   sign = (end == 0 ? -1 : 1) * sign_drill;
      B(value, o + 2) = H.value[2 * end];
      B(value, o + slope_s) = sign_s * H.value[2 * end + 1];
      B(slope, o + 2) = H.slope[2 * end];
      B(slope, o + slope_s) = sign_s * H.slope[2 * end + 1];
      B(across, o + slope_n) = sign_n * linear;
      B(twist, o + slope_n) += share * sign_n * rate;
      B(along, o + tangent) = B(beside, o + normal) = linear;
      B(stretch, o + tangent) = B(turn, o + normal) = rate;
      B(beside, o + 5) = (-sign * 0.5 * s * (1 - s)) * length;
      B(turn, o + 5) = -sign * 0.5 * (1 - 2 * s);
    }
  }
}

Interfaces corners(const PlateMesh& mesh, FreeDofs& free) {
  const int nx = mesh.elements_along(), ny = mesh.elements_across();
  const double a = mesh.x().back() - mesh.x().front(), b = mesh.y().back() - mesh.y().front();
  Interfaces c = no_interfaces(Dofs(mesh).count(), 4);
  const std::array<std::array<int, 2>, 4> corner{{{0, 0}, {0, ny}, {nx, 0}, {nx, ny}}};
  for (const auto& [i, j] : corner) c.nodes.emplace_back(mesh.x()[i], mesh.y()[j], 0);
  for (const Side& side :
       {Side{0, 0, {0, 2}}, Side{0, ny, {1, 3}}, Side{1, 0, {0, 1}}, Side{1, nx, {2, 3}}})
    hold_side(mesh, side, c.boundary, free);

  // Hughes and Brezzi's penalty on the difference of mean drilling rotation and mean continuum
  // rotation ½ ∮ (v nx − u ny) ds / ab: without it equal drilling rotations store no energy (R13)
  Eigen::Matrix<double, 24, 1> difference = Eigen::Matrix<double, 24, 1>::Zero();
  for (int k = 0; k < 4; ++k) {
    difference[6 * k + 5] = 0.25;
    difference[6 * k + v] = (k >= 2 ? -0.25 : 0.25) / a;
    difference[6 * k + u] = (k % 2 == 1 ? 0.25 : -0.25) / b;
  }
  const double shear = 0.5 * (1.0 - mesh.shape().poissons_ratio) * mesh.membrane().A11;  // G t L²/D
  const double area = a * b, stiff = shear * area;
  const double inertia =
      area * (a * a + b * b) / 12.0;  // makes M_CB regular; rigid motions feel none
  const MatrixXd square = difference * difference.transpose();
  c.penalty = stiff * square;
  c.penalty_mass = inertia * square;
  return c;
}

// Rows of the displacement and rotation (w,y, −w,x, ½(v,x − u,y)) in the middle.
MatrixXd motion_of_middle(const PlateMesh& mesh) {
  const Dofs dof(mesh);
  MatrixXd rows = MatrixXd::Zero(6, dof.count());
  const auto add = [&](int row, double factor, int component, std::array<int, 2> derivative) {
    for (const NodalWeight& at : point_weights(mesh, 0.5, 0.5, derivative))
      rows(row, dof(at.line, at.function / 4, component, at.function % 4)) += factor * at.weight;
  };
  const double per_width = 1 / mesh.shape().width;
  for (const int c : {u, v, w}) add(c, 1, c, {0, 0});
  add(3, per_width, w, {0, 1});
  add(4, -1, w, {1, 0});
  add(5, 0.5, v, {1, 0});
  add(5, -0.5 * per_width, u, {0, 1});
  return rows;
}

// Modes beyond the kept ones: they make the gap behind the kept ones wide.
constexpr int guard = 3;

MatrixXd symmetric(const MatrixXd& A) { return 0.5 * (A + A.transpose()); }

// [boundary, coupling; couplingᵀ, modal].
MatrixXd bordered(const MatrixXd& boundary, const MatrixXd& coupling, const MatrixXd& modal) {
  const Eigen::Index n = boundary.rows(), k = modal.rows();
  MatrixXd A(n + k, n + k);
  A.topLeftCorner(n, n) = symmetric(boundary);
  A.topRightCorner(n, k) = coupling;
  A.bottomLeftCorner(k, n) = coupling.transpose();
  A.bottomRightCorner(k, k) = symmetric(modal);
  return A;
}

// K_CB, M_CB and Φ_CB of (R11): lengths over L, energies over D, masses over ρ t L⁴.
SuperelementModel condensed(const PlateBody& body, const PlateMesh& mesh) {
  const Dofs dof(mesh);
  FreeDofs free(mesh);
  const Interfaces c =
      body.interface == Interface::corners ? corners(mesh, free) : rigid_edges(mesh, free);
  for (int i = 0; i < mesh.lines(); ++i)
    for (int j = 0; j < mesh.nodes_per_line(); ++j)
      for (int d = 0; d < 3; ++d)
        for (int k = 0; k < 4; ++k)
          if (!free.held[dof(i, j, d, k)]) free.release(dof(i, j, d, k));

  const Matrices matrices = assemble(body, mesh);
  const Sparse &stiffness = matrices.stiffness, &mass = matrices.mass;
  Sparse to_dofs(dof.count(), free.unknowns);  // of the free unknowns
  to_dofs.setFromTriplets(free.free.begin(), free.free.end());
  const Eigen::SimplicialLDLT<Sparse> factor(Sparse(to_dofs.transpose() * stiffness * to_dofs));
  assert(factor.info() == Eigen::Success);

  // boundary modes Φ = B − F K_ff⁻¹ Fᵀ K B, vibration modes F ψ (R11)
  const MatrixXd KB = stiffness * c.boundary;
  MatrixXd boundary = c.boundary - to_dofs * factor.solve(MatrixXd(to_dofs.transpose() * KB));
  const int kept = std::min(body.vibration_modes, free.unknowns / 4);
  VectorXd omega2;
  MatrixXd modes(free.unknowns, 0);  // M-orthonormal
  if (kept > 0) {
    const Sparse free_mass = to_dofs.transpose() * mass * to_dofs;
    const LowestPairs pairs = lowest_pairs(
        free.unknowns, std::min(kept + guard, free.unknowns / 2), 2,
        [&](const MatrixXd& X) -> MatrixXd { return factor.solve(X); },
        [&](const MatrixXd& X) -> MatrixXd { return free_mass * X; }, 1e-9);
    assert(pairs.converged);
    omega2 = pairs.values.head(kept);
    modes = pairs.vectors.leftCols(kept);
  }
  const MatrixXd V = to_dofs * modes;
  SuperelementModel model;
  for (const Vector3d& node : c.nodes) model.nodes.push_back(node - 0.5 * Vector3d::UnitX());
  MatrixXd K = boundary.transpose() * (stiffness * boundary),
           M = boundary.transpose() * (mass * boundary);
  if (c.penalty.size() > 0) {
    K += c.penalty;
    M += c.penalty_mass;
  }
  model.stiffness = bordered(K, MatrixXd::Zero(K.rows(), kept), MatrixXd(omega2.asDiagonal()));
  model.mass = bordered(M, boundary.transpose() * (mass * V), MatrixXd::Identity(kept, kept));
  model.frame_modes = motion_of_middle(mesh) * boundary;
  model.recovery = std::move(boundary);
  return model;
}

// A model in units of its body in other units: L, D and ρ t L⁴ of the body.
SuperelementModel in_units(const SuperelementModel& model, double length, double energy,
                           double mass) {
  const int n = model.coordinates();
  VectorXd unit = VectorXd::Constant(model.stiffness.rows(), 1 / std::sqrt(mass));
  for (int i = 0; i < n; i += 6) {
    unit.segment<3>(i).setConstant(1 / length);
    unit.segment<3>(i + 3).setOnes();
  }
  SuperelementModel other;
  for (const Vector3d& node : model.nodes) other.nodes.push_back(length * node);
  other.stiffness = energy * unit.asDiagonal() * model.stiffness * unit.asDiagonal();
  other.mass = mass * unit.asDiagonal() * model.mass * unit.asDiagonal();
  other.frame_modes = model.frame_modes * unit.head(n).asDiagonal();
  other.frame_modes.topRows<3>() *= length;
  other.recovery = model.recovery * unit.head(n).asDiagonal();
  return other;
}

}  // namespace

CondensedPlate condense(const PlateBody& body) {
  const bool leaf = body.interface == Interface::rigid_edges;
  PlateShape shape = plate_shape(body.plate, body.mesh, leaf && body.free_edges[0]);
  shape.linear = !leaf;
  shape.transverse_shear = leaf && body.transverse_shear;
  return condense(body, std::make_shared<PlateMesh>(shape));
}

CondensedPlate condense(const PlateBody& body, std::shared_ptr<const PlateMesh> mesh) {
  LeafSpring flat = body.plate;
  flat.origin.setZero();
  flat.axes.setIdentity();
  const LeafScale scale(flat, mesh->shape().flexure);
  return {mesh, scale, 0.5 * flat.length * Vector3d::UnitX(),
          in_units(condensed(body, *mesh), scale.length, scale.energy, scale.mass)};
}

CondensedPlate condense_beam(const LeafSpring& beam, int elements, Warping warping,
                             int vibration_modes, bool transverse_shear) {
  assert(elements >= 2 && elements % 2 == 0);
  const ModelOptions options{.flexure = Flexure::beam,
                             .warping = warping,
                             .mesh = {elements, 1},
                             .transverse_shear = transverse_shear};
  PlateBody body{.plate = beam, .interface = Interface::rigid_edges};
  body.vibration_modes = vibration_modes;
  return condense(body, std::make_shared<const PlateMesh>(leaf_shape(beam, options)));
}

}  // namespace flexopt
