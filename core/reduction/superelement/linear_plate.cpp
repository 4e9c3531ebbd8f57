#include "core/reduction/superelement/linear_plate.hpp"

#include <cassert>
#include <cmath>
#include <utility>

#include "core/elements/plate/mesh_numbers.hpp"
#include "core/math/dual.hpp"

namespace flexopt::linear_plate {
namespace {

using Matrix16 = PlateMesh::Matrix16;
enum Component { u, v, w };

// Rows and columns of an element's matrices of one displacement component.
struct ElementMatrices {
  Matrix16 uu, vv, uv, bending, mass;
};

// Integrals of the products of first derivatives, weights included: those of the stretching, which
// are the same along and across, and those of the shear.
struct MembraneProducts {
  Matrix16 xx, yy, xy, shear_xx, shear_yy, shear_xy;
};
using Points16 = Eigen::Matrix<double, PlateMesh::points, 16>;
using Weights = Eigen::Array<double, PlateMesh::points, 3>;  // of e11, e22 and 2 e12
MembraneProducts membrane_products(const Matrix16& left, const Weights& weight,
                                   const Matrix16& right) {
  constexpr int points = PlateMesh::points;
  const auto Lx = left.topRows<points>(), Ly = left.bottomRows<points>();
  const auto weighted = [&](const auto& G, int strain) {
    return Points16(weight.col(strain).matrix().asDiagonal() * G);
  };
  const Points16 Gx = weighted(right.topRows<points>(), 0),
                 Gy = weighted(right.bottomRows<points>(), 0),
                 Sx = weighted(right.topRows<points>(), 2),
                 Sy = weighted(right.bottomRows<points>(), 2);
  return {Lx.transpose() * Gx, Ly.transpose() * Gy, Lx.transpose() * Gy,
          Lx.transpose() * Sx, Ly.transpose() * Sy, Lx.transpose() * Sy};
}

void add_membrane(ElementMatrices& to, const PlateMesh::Membrane& A, const MembraneProducts& p) {
  to.uu += A.A11 * p.xx + A.A33 * p.shear_yy;
  to.vv += A.A11 * p.yy + A.A33 * p.shear_xx;
  to.uv += A.A12 * p.xy + A.A33 * p.shear_xy.transpose();
}

// Elements at a free edge that are narrower than this times t have a smaller c of (E2), in
// proportion.
constexpr double least_edge_element = 0.6;

// ½ G c t⁴ ∫ |r,xy|² ds along a free edge, over D; r,xy at an edge is quadratic along
// it. With derivatives in w/L, t/L, ν.
struct EdgeTorsion {
  Matrix16 value = Matrix16::Zero();
  std::array<Matrix16, 3> rate{Matrix16::Zero(), Matrix16::Zero(), Matrix16::Zero()};
};
EdgeTorsion edge_torsion(const PlateMesh& mesh, int i, int j, int side, double cell) {
  const PlateShape& shape = mesh.shape();
  const double hx = mesh.x()[i + 1] - mesh.x()[i], y = mesh.y()[j + 1] - mesh.y()[j];
  const Dual3 hy(y, {y / shape.width, 0, 0}), t = Dual3::variable(shape.thickness, 1),
                                              nu = Dual3::variable(shape.poissons_ratio, 2);
  Dual3 factor = (6 * free_edge_coefficient * std::pow(cell, 4)) * (1.0 - nu) * t;
  if (y < least_edge_element * shape.thickness) factor *= hy / (least_edge_element * t);
  constexpr double offset = 0.7745966692414834;  // Gauss, three points
  EdgeTorsion torsion;
  for (const auto& [at, weight] :
       {std::pair{-offset, 5.0 / 18}, std::pair{0.0, 8.0 / 18}, std::pair{offset, 5.0 / 18}}) {
    const Eigen::Matrix<Dual3, 16, 1> Nxy =
        hermite_products(hermite(0.5 + 0.5 * at, hx).slope, hermite<Dual3>(side, hy).slope);
    const Dual3 by = factor * (weight * hx);
    for (int g = 0; g < 16; ++g)
      for (int f = 0; f < 16; ++f) {
        const Dual3 x = by * Nxy[f] * Nxy[g];
        torsion.value(f, g) += x.value;
        for (int p = 0; p < 3; ++p) torsion.rate[p](f, g) += x.derivatives[p];
      }
  }
  return torsion;
}

// Adds the elements' matrices to those of the mesh.
class Assembler {
 public:
  explicit Assembler(const PlateMesh& mesh) : dof_(mesh), side_(mesh.functions_per_side()) {
    const auto entries = static_cast<std::size_t>(4 * side_ * side_ * mesh.elements_along() *
                                                  mesh.elements_across());
    K_.reserve(5 * entries);
    M_.reserve(3 * entries);
  }

  void add(int i, int j, const ElementMatrices& e) {
    const int functions = 2 * side_;
    std::array<std::array<int, 16>, 3> at;
    for (int c = 0; c < 3; ++c)
      for (int f = 0; f < functions; ++f) {
        const int s = f % side_;
        at[c][f] = dof_(i + f / side_, j + s / 4, c, s % 4);
      }
    for (int a = 0; a < functions; ++a)
      for (int b = 0; b < functions; ++b) {
        K_.emplace_back(at[u][a], at[u][b], e.uu(a, b) + e.bending(a, b));
        K_.emplace_back(at[v][a], at[v][b], e.vv(a, b) + e.bending(a, b));
        K_.emplace_back(at[u][a], at[v][b], e.uv(a, b));
        K_.emplace_back(at[v][a], at[u][b], e.uv(b, a));
        K_.emplace_back(at[w][a], at[w][b], e.bending(a, b));
        for (int c = 0; c < 3; ++c) M_.emplace_back(at[c][a], at[c][b], e.mass(a, b));
      }
  }
  Matrices matrices() const {
    const int n = dof_.count();
    Matrices result{SparseMatrix(n, n), SparseMatrix(n, n)};
    result.stiffness.setFromTriplets(K_.begin(), K_.end());
    result.mass.setFromTriplets(M_.begin(), M_.end());
    return result;
  }

 private:
  Dofs dof_;
  int side_;
  Triplets K_, M_;
};

ElementMatrices no_matrices() {
  const Matrix16 none = Matrix16::Zero();
  return {none, none, none, none, none};
}

// `add(i, j, t)` for every element that is there, and its thickness over that of the plate.
template <class Add>
void each_element(const PlateBody& body, const PlateMesh& mesh, const Add& add) {
  for (int i = 0; i < mesh.elements_along(); ++i)
    for (int j = 0; j < mesh.elements_across(); ++j)
      if (const double t = cell_thickness(body, i, j); t != 0) add(i, j, t);
}
// `add(torsion)` for every side of an element that is a free edge, where the mesh has it not.
template <class Add>
void each_free_edge(const PlateBody& body, const PlateMesh& mesh, int i, int j, double t,
                    const Add& add) {
  if (mesh.shape().free_edge_torsion) return;
  for (int side = 0; side < 2; ++side)
    if (body.free_edges[side] && (side == 0 ? j == 0 : j == mesh.elements_across() - 1))
      add(edge_torsion(mesh, i, j, side, t));
}

}  // namespace

Matrices assemble(const PlateBody& body, const PlateMesh& mesh) {
  Assembler all(mesh);
  each_element(body, mesh, [&](int i, int j, double t) {
    const PlateMesh::Element& element = mesh.element(i, j);
    ElementMatrices e = no_matrices();
    e.bending = t * t * t * element.bending;
    each_free_edge(body, mesh, i, j, t, [&](const EdgeTorsion& x) { e.bending -= x.value; });
    add_membrane(e, mesh.membrane(),
                 membrane_products(element.gradient, t * element.weight, element.gradient));
    e.mass = t * element.mass;
    all.add(i, j, e);
  });
  return all.matrices();
}

std::array<Matrices, 3> assemble_rates(const PlateBody& body, const PlateMesh& mesh,
                                       const PlateMeshRate& rate) {
  std::array<Matrices, 3> result;
  for (int p = 0; p < 3; ++p) {
    const PlateMeshRate::Shape& by = rate.shape[p];
    Assembler all(mesh);
    each_element(body, mesh, [&](int i, int j, double t) {
      const PlateMesh::Element& element = mesh.element(i, j);
      const auto k = static_cast<std::size_t>(i * mesh.elements_across() + j);
      ElementMatrices e = no_matrices();
      if (!by.bending.empty()) e.bending = t * t * t * by.bending[k];
      each_free_edge(body, mesh, i, j, t, [&](const EdgeTorsion& x) { e.bending -= x.rate[p]; });
      if (!by.mass.empty()) e.mass = t * by.mass[k];
      // (A Gᵀ W G)′
      const PlateMesh::Membrane& A = mesh.membrane();
      const Matrix16& G = element.gradient;
      const Weights W = t * element.weight;
      add_membrane(e, by.membrane, membrane_products(G, W, G));
      if (!by.weight.empty()) add_membrane(e, A, membrane_products(G, t * by.weight[k], G));
      if (!by.gradient.empty()) {
        add_membrane(e, A, membrane_products(by.gradient[k], W, G));
        add_membrane(e, A, membrane_products(G, W, by.gradient[k]));
      }
      all.add(i, j, e);
    });
    result[p] = all.matrices();
  }
  return result;
}

namespace {

template <class S>
using MatrixX = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;

// What the formulas below take of the shape.
template <class S>
struct Shape {
  S poissons_ratio, A11;
  std::vector<S> x, y;
};

template <class S>
struct InterfacesOf {
  std::vector<Vector3<S>> nodes;
  MatrixX<S> boundary, penalty, penalty_mass, middle;

  InterfacesOf(int dofs, int m) : boundary(MatrixX<S>::Constant(dofs, 6 * m, S(0))) {}
};

// Linearised rigid edges: r = t + y e2, r,y = e2, r,x = (1 + α) e1 + γ e2, r,xy = α′ e1 + γ′ e2;
// of a beam as beams.md, "Ends", says.
template <class S>
InterfacesOf<S> rigid_edges(const PlateMesh& mesh, const Shape<S>& shape, FreeDofs& free) {
  const Dofs dof(mesh);
  InterfacesOf<S> c(dof.count(), 2);
  c.nodes = {Vector3<S>(S(0), S(0), S(0)), Vector3<S>(S(1), S(0), S(0))};
  for (int e = 0; e < 2; ++e) {
    const int i = e == 0 ? 0 : mesh.elements_along(), b = 6 * e;
    for (int j = 0; j < mesh.nodes_per_line(); ++j) {
      const S& y = shape.y[j];
      MatrixX<S>& B = c.boundary;
      for (int d = 0; d < 3; ++d) B(dof(i, j, d, 0), b + d) = S(1);
      B(dof(i, j, u, 0), b + 5) = -y;
      B(dof(i, j, w, 0), b + 3) = y;
      B(dof(i, j, u, 2), b + 5) = S(-1);
      B(dof(i, j, w, 2), b + 3) = S(1);
      B(dof(i, j, v, 1), b + 5) = S(1);
      B(dof(i, j, w, 1), b + 4) = S(-1);
      for (int d = 0; d < 3; ++d)
        for (int k = 0; k < 4; ++k) free.hold(dof(i, j, d, k));
      for (const PlateMesh::EdgeSlope& s : mesh.edge_slopes())
        free.release(dof(i, j, s.axis, s.function));
    }
  }
  return c;
}

// A mesh node: u, v, w and the rotation (w,y, −w,x, ½(v,x − u,y)); the shear v,x + u,y stays free.
template <class S>
InterfacesOf<S> mesh_nodes(const PlateMesh& mesh, const Shape<S>& shape,
                           const std::vector<std::array<int, 2>>& nodes, FreeDofs& free) {
  const Dofs dof(mesh);
  InterfacesOf<S> c(dof.count(), static_cast<int>(nodes.size()));
  for (int a = 0; a < static_cast<int>(nodes.size()); ++a) {
    const auto [i, j] = nodes[a];
    assert(i >= 0 && i < mesh.lines() && j >= 0 && j < mesh.nodes_per_line());
    const int b = 6 * a;
    c.nodes.emplace_back(S(mesh.x()[i]), shape.y[j], S(0));
    for (int d = 0; d < 3; ++d) c.boundary(dof(i, j, d, 0), b + d) = S(1);
    c.boundary(dof(i, j, w, 2), b + 3) = S(1);
    c.boundary(dof(i, j, w, 1), b + 4) = S(-1);
    c.boundary(dof(i, j, v, 1), b + 5) = S(1);
    c.boundary(dof(i, j, u, 2), b + 5) = S(-1);
    for (const int k : {dof(i, j, u, 0), dof(i, j, v, 0), dof(i, j, w, 0), dof(i, j, w, 1),
                        dof(i, j, w, 2), dof(i, j, v, 1), dof(i, j, u, 2)})
      free.hold(k);
    free.free.emplace_back(dof(i, j, v, 1), free.unknowns, 0.5);
    free.free.emplace_back(dof(i, j, u, 2), free.unknowns, 0.5);
    ++free.unknowns;
  }
  return c;
}

// Sides between four corners. Along a side (tangent s, normal n; length a): w the cubic of the
// ends' values and slopes, the slope across it linear; the tangential displacement linear; the
// normal one linear plus Allman's parabola of the ends' drilling rotations (R12)
template <class S>
InterfacesOf<S> corners(const PlateMesh& mesh, const Shape<S>& shape, FreeDofs& free) {
  const Dofs dof(mesh);
  const int nx = mesh.elements_along(), ny = mesh.elements_across();
  const S a = S(mesh.x().back() - mesh.x().front()), b = shape.y.back() - shape.y.front();
  InterfacesOf<S> c(dof.count(), 4);
  const std::array<std::array<int, 2>, 4> corner{{{0, 0}, {0, ny}, {nx, 0}, {nx, ny}}};
  for (const auto& [i, j] : corner) c.nodes.emplace_back(S(mesh.x()[i]), shape.y[j], S(0));
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
        free.hold(d);
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
  // rotation ½ ∮ (v nx − u ny) ds / ab: without it equal drilling rotations store no energy (R13)
  std::array<S, 24> difference{};
  for (int k = 0; k < 4; ++k) {
    difference[6 * k + 5] = S(0.25);
    difference[6 * k + v] = (k >= 2 ? -0.25 : 0.25) / a;
    difference[6 * k + u] = (k % 2 == 1 ? 0.25 : -0.25) / b;
  }
  const S shear = 0.5 * (1.0 - shape.poissons_ratio) * shape.A11;  // G t L²/D
  const S area = a * b, stiff = shear * area;
  const S inertia = area * (a * a + b * b) / 12.0;  // makes M_CB regular; rigid motions feel none
  c.penalty.resize(24, 24);
  c.penalty_mass.resize(24, 24);
  for (int k = 0; k < 24; ++k)
    for (int l = 0; l < 24; ++l) {
      const S square = difference[k] * difference[l];
      c.penalty(k, l) = stiff * square;
      c.penalty_mass(k, l) = inertia * square;
    }
  return c;
}

// Rows of the displacement and rotation (w,y, −w,x, ½(v,x − u,y)) in the middle.
template <class S>
MatrixX<S> motion_of_middle(const PlateMesh& mesh, const Shape<S>& shape) {
  const auto locate = [](const std::vector<double>& points, double s) {
    int i = 0;
    while (i + 2 < static_cast<int>(points.size()) && s > points[i + 1]) ++i;
    return i;
  };
  const Dofs dof(mesh);
  const int i = locate(mesh.x(), 0.5), side = mesh.functions_per_side();
  const S hx = shape.x[i + 1] - shape.x[i];  // the middle keeps its share of it, by symmetry
  const HermiteValuesT<S> X = hermite<S>((0.5 - mesh.x()[i]) / (mesh.x()[i + 1] - mesh.x()[i]), hx);
  Eigen::Matrix<S, 16, 1> N, Nx, Ny;
  int j = 0;
  if (mesh.shape().is_beam()) {
    N = beam_functions(X.value, 1, 0);
    Nx = beam_functions(X.slope, 1, 0);
    Ny = beam_functions(X.value, 0, 1);
  } else {
    j = locate(mesh.y(), 0);
    const HermiteValuesT<S> Y =
        hermite<S>(-mesh.y()[j] / (mesh.y()[j + 1] - mesh.y()[j]), shape.y[j + 1] - shape.y[j]);
    N = hermite_products(X.value, Y.value);
    Nx = hermite_products(X.slope, Y.value);
    Ny = hermite_products(X.value, Y.slope);
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

template <class S>
InterfacesOf<S> interfaces_of(const PlateMesh& mesh, const Shape<S>& shape,
                              const PlateCondensation& condensation, FreeDofs& free) {
  InterfacesOf<S> result = condensation.interface == Interface::rigid_edges
                               ? rigid_edges(mesh, shape, free)
                           : condensation.interface == Interface::corners
                               ? corners(mesh, shape, free)
                               : mesh_nodes(mesh, shape, condensation.mesh_nodes, free);
  result.middle = motion_of_middle(mesh, shape);
  return result;
}

// The numbers that `part` takes of the scalars.
template <class S, class Part>
Interfaces part_of(const InterfacesOf<S>& all, const Part& part) {
  const auto matrix = [&](const MatrixX<S>& A) {
    MatrixXd result(A.rows(), A.cols());
    for (Eigen::Index k = 0; k < A.size(); ++k) result.data()[k] = part(A.data()[k]);
    return result;
  };
  Interfaces result{
      {}, matrix(all.boundary), matrix(all.penalty), matrix(all.penalty_mass), matrix(all.middle)};
  for (const Vector3<S>& node : all.nodes)
    result.nodes.emplace_back(part(node[0]), part(node[1]), part(node[2]));
  return result;
}

}  // namespace

Interfaces interfaces(const PlateMesh& mesh, const PlateCondensation& condensation,
                      FreeDofs& free) {
  const Shape<double> shape{mesh.shape().poissons_ratio, mesh.membrane().A11, mesh.x(), mesh.y()};
  return part_of(interfaces_of(mesh, shape, condensation, free), [](double x) { return x; });
}

std::array<Interfaces, 3> interface_rates(const PlateMesh& mesh,
                                          const PlateCondensation& condensation,
                                          const PlateMeshRate& rate) {
  Shape<Dual3> shape{
      Dual3::variable(mesh.shape().poissons_ratio, ShapeParameter::poissons_ratio),
      Dual3(mesh.membrane().A11,
            {rate.shape[0].membrane.A11, rate.shape[1].membrane.A11, rate.shape[2].membrane.A11}),
      {},
      {}};
  for (const Dual1& x : MeshNumbers<Dual1>(mesh.shape(), rate.direction[ShapeParameter::width]).x)
    shape.x.push_back({x.value, {x.derivatives[0], 0, 0}});
  for (const double y : mesh.y()) shape.y.push_back({y, {y / mesh.shape().width, 0, 0}});
  FreeDofs free(mesh);
  const InterfacesOf<Dual3> all = interfaces_of(mesh, shape, condensation, free);
  std::array<Interfaces, 3> rates;
  for (int p = 0; p < 3; ++p)
    rates[p] = part_of(all, [p](const Dual3& x) { return x.derivatives[p]; });
  return rates;
}

}  // namespace flexopt::linear_plate
