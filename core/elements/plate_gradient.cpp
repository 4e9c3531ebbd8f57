#include "core/elements/plate_gradient.hpp"

#include <cassert>
#include <utility>

#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

constexpr int points = PlateMesh::points;
using Gradient = Eigen::Matrix<double, 16, 3>;
using PointArray = Eigen::Array<double, points, 1>;
using Stress = Eigen::Array<double, points, 3>;

// a b of gradients at the points: (a1·b1, a2·b2, a1·b2 + a2·b1).
template <class A, class B>
Stress strain_product(const A& a, const B& b) {
  Stress e = Stress::Zero();
  for (int c = 0; c < 3; ++c) {
    const auto a1 = a.col(c).template head<points>().array(),
               a2 = a.col(c).template tail<points>().array();
    const auto b1 = b.col(c).template head<points>().array(),
               b2 = b.col(c).template tail<points>().array();
    e.col(0) += a1 * b1;
    e.col(1) += a2 * b2;
    e.col(2) += a1 * b2 + a2 * b1;
  }
  return e;
}

Stress stress_of(const PlateMesh::Membrane& A, const Stress& e) {
  Stress n;
  n.col(0) = A.A11 * e.col(0) + A.A12 * e.col(1);
  n.col(1) = A.A12 * e.col(0) + A.A11 * e.col(1);
  n.col(2) = A.A33 * e.col(2);
  return n;
}

Stress weighted(const Stress& n, const PointArray& w) { return n.colwise() * w; }

// Σ n_ab r,b: what stands against r,a.
template <class A>
Gradient stress_times(const Stress& n, const A& a) {
  Gradient s;
  for (int c = 0; c < 3; ++c) {
    const auto a1 = a.col(c).template head<points>().array(),
               a2 = a.col(c).template tail<points>().array();
    s.col(c).template head<points>() = n.col(0) * a1 + n.col(2) * a2;
    s.col(c).template tail<points>() = n.col(2) * a1 + n.col(1) * a2;
  }
  return s;
}

double sum(const Stress& a, const Stress& b) { return (a * b).sum(); }

// Nodal values of an element: functions × columns.
template <int Side>
Eigen::Matrix<double, 2 * Side, Eigen::Dynamic> gather(const MatrixXd& low, const MatrixXd& high,
                                                       int j) {
  Eigen::Matrix<double, 2 * Side, Eigen::Dynamic> U(2 * Side, low.cols());
  U << low.middleRows<Side>(4 * j), high.middleRows<Side>(4 * j);
  return U;
}

}  // namespace

PlateGradient::PlateGradient(const PlateLeaf& plate, std::shared_ptr<const PlateMeshRate> rate,
                             const LeafRows& rows)
    : plate_(&plate), mesh_(&plate.mesh()), rate_(std::move(rate)), rows_(rows) {
  const auto& slopes = mesh_->edge_slopes();
  for (int e = 0; e < 2; ++e) {
    EdgeNodes& edge = edges_[e];
    edge.line = e == 0 ? 0 : mesh_->lines() - 1;
    rigid_[e] = plate.is_rigid_edge(edge.line);
    if (!rigid_[e]) continue;
    edge.axes = plate.state().edges[e].axes;
    const Vector3d arm = edge.axes.transpose() * rows.lever[e];
    for (int j = 0; j < mesh_->nodes_per_line(); ++j) {
      std::array<Vector3d, 4> w{arm + mesh_->y()[j] * Vector3d::UnitY(), Vector3d::UnitX(),
                                Vector3d::UnitY(), Vector3d::Zero()};
      const double* a = plate.state().x.data() + plate.block_offset(edge.line) +
                        static_cast<int>(slopes.size()) * j;
      for (const PlateMesh::EdgeSlope& s : slopes) w[s.function][s.axis] += *a++;
      for (const Vector3d& local : w) {
        edge.local.push_back(local);
        edge.arm.push_back(edge.axes * local);
      }
    }
  }
  if (mesh_->functions_per_side() == 8)
    prepare<8>();
  else
    prepare<4>();
  add_point_force();
  MatrixXd force = MatrixXd::Zero(size(), 1);
  for (int line = 0; line < mesh_->lines(); ++line) add_to_rows(line, nodal_force_[line], force);
  force_ = force;
  if (rows.point > 0) {
    Vector3d apart = plate.state().point + plate.point_place();
    for (const NodalWeight& w : plate.support().point)
      apart -= w.weight * plate.nodal()[w.line].row(w.function).transpose();
    force_.segment<3>(rows.unknowns) = apart;
    force_.segment<3>(rows.point_body()) = plate.state().point_force;
  }
}

int PlateGradient::edge_at(int line) const {
  if (line == 0 && rigid_[0]) return 0;
  if (line == mesh_->lines() - 1 && rigid_[1]) return 1;
  return -1;
}

// Strains, stresses, nodal forces and what these change by with the shape.
template <int Side>
void PlateGradient::prepare() {
  const int n = mesh_->functions_per_line(), nx = mesh_->elements_along(),
            ny = mesh_->elements_across();
  nodal_force_.assign(nx + 1, MatrixXd::Zero(n, 3));
  for (int p = 0; p < 3; ++p) shape_force_[p].assign(nx + 1, MatrixXd::Zero(n, 3));
  a0_.resize(nx * ny);
  strain_.resize(nx * ny);
  n0_.resize(nx * ny);
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      const int k = i * ny + j;
      const PlateMesh::Element& element = mesh_->element(i, j);
      const auto G = element.gradient.leftCols<2 * Side>();
      const Eigen::Matrix<double, 2 * Side, 3> U =
          gather<Side>(plate_->nodal()[i], plate_->nodal()[i + 1], j);
      const Gradient& a0 = a0_[k] = G * U;
      Stress& e = strain_[k] = 0.5 * strain_product(a0, a0);
      e.leftCols<2>() -= 0.5;
      const Stress bare = stress_of(mesh_->membrane(), e);
      n0_[k] = weighted(bare, element.weight);
      const Gradient s = stress_times(n0_[k], a0);
      const auto add = [&](std::vector<MatrixXd>& to, const Eigen::Matrix<double, 2 * Side, 3>& F) {
        to[i].middleRows<Side>(4 * j) += F.template topRows<Side>();
        to[i + 1].middleRows<Side>(4 * j) += F.template bottomRows<Side>();
      };
      add(nodal_force_,
          G.transpose() * s + element.bending.topLeftCorner<2 * Side, 2 * Side>() * U);
      for (int p = 0; p < 3; ++p) {
        const PlateMeshRate::Shape& by = rate_->shape[p];
        Stress dn = weighted(stress_of(by.membrane, e), element.weight);
        if (!by.weight.empty()) dn += weighted(bare, by.weight[k]);
        Eigen::Matrix<double, 2 * Side, 3> F;
        if (by.gradient.empty()) {
          F = G.transpose() * stress_times(dn, a0);
        } else {
          const auto dG = by.gradient[k].leftCols<2 * Side>();
          const Gradient da = dG * U;
          dn += weighted(stress_of(mesh_->membrane(), strain_product(a0, da)), element.weight);
          F = G.transpose() * (stress_times(dn, a0) + stress_times(n0_[k], da)) +
              dG.transpose() * s;
        }
        F += by.bending[k].topLeftCorner<2 * Side, 2 * Side>() * U;
        add(shape_force_[p], F);
      }
    }
}

void PlateGradient::add_to_rows(int line, const MatrixXd& nodal, MatrixXd& rows) const {
  const int n = mesh_->functions_per_line(), columns = static_cast<int>(rows.cols());
  const int e = edge_at(line);
  if (e < 0) {
    rows.middleRows(plate_->block_offset(line), 3 * n) += nodal.reshaped(3 * n, columns);
    return;
  }
  const auto& slopes = mesh_->edge_slopes();
  const int body = rows_.body(e);
  for (int k = 0; k < columns; ++k)
    for (int s = 0; s < n; ++s) {
      const Vector3d f = nodal.block<1, 3>(s, 3 * k).transpose();
      if (s % 4 == 0) rows.block<3, 1>(body, k) += f;
      rows.block<3, 1>(body + 3, k) += edges_[e].arm[s].cross(f);
      for (std::size_t d = 0; d < slopes.size(); ++d)
        if (slopes[d].function == s % 4)
          rows(plate_->block_offset(line) + static_cast<int>(slopes.size()) * (s / 4) +
                   static_cast<int>(d),
               k) += edges_[e].axes.col(slopes[d].axis).dot(f);
    }
}

// N0′ of the edges' nodes: functions × (3 components of each variation).
std::array<MatrixXd, 2> PlateGradient::edge_nodal_rates(
    const std::vector<LeafVariation>& variations) const {
  const int n = mesh_->functions_per_line(), columns = static_cast<int>(variations.size());
  std::array<MatrixXd, 2> rates{MatrixXd::Zero(n, 3 * columns), MatrixXd::Zero(n, 3 * columns)};
  for (int e = 0; e < 2; ++e) {
    if (!rigid_[e]) continue;
    for (int k = 0; k < columns; ++k) {
      const LeafVariation& v = variations[k];
      for (int s = 0; s < n; ++s) {
        Vector3d r = v.edge[e].rotation * edges_[e].local[s];
        if (s % 4 == 0)
          r += v.edge[e].position +
               edges_[e].axes *
                   (v.edge[e].arm + v.shape[0] / mesh_->shape().width *
                                        (mesh_->shape().is_beam() ? 0 : mesh_->y()[s / 4]) *
                                        Vector3d::UnitY());
        rates[e].block<1, 3>(s, 3 * k) = r.transpose();
      }
    }
  }
  return rates;
}

std::vector<MatrixXd> PlateGradient::nodal_rates(
    const MatrixXd& Y, const std::vector<LeafVariation>& variations) const {
  const int n = mesh_->functions_per_line();
  const MatrixXd T = rows_.edge_rows(Y);
  const std::array<MatrixXd, 2> edges = edge_nodal_rates(variations);
  std::vector<MatrixXd> N;
  for (int i = 0; i < mesh_->lines(); ++i) {
    N.push_back(plate_->nodal_rates(i, T).reshaped(n, 3 * Y.cols()));
    if (const int e = edge_at(i); e >= 0) N.back() += edges[e];
  }
  return N;
}

MatrixXd PlateGradient::force_rates(const std::vector<LeafVariation>& variations) const {
  const int n = mesh_->functions_per_line(), nx = mesh_->elements_along(),
            ny = mesh_->elements_across(), columns = static_cast<int>(variations.size());
  const std::array<MatrixXd, 2> N = edge_nodal_rates(variations);
  std::vector<MatrixXd> F(nx + 1, MatrixXd::Zero(n, 3 * columns));
  for (int line = 0; line <= nx; ++line)
    for (int k = 0; k < columns; ++k)
      for (int p = 0; p < 3; ++p)
        F[line].middleCols<3>(3 * k) += variations[k].shape[p] * shape_force_[p][line];

  const Eigen::RowVector3d point_force = plate_->state().point_force.transpose();
  for (int a = 0; a < 2; ++a)
    for (const NodalWeight& w : plate_->support().point_slopes[a])
      for (int k = 0; k < columns; ++k)
        F[w.line].block<1, 3>(w.function, 3 * k) -= variations[k].point[a] * w.weight * point_force;

  // K N′, which only the elements at the edges feel
  const auto product = [&]<int Side>() {
    const MatrixXd zero = MatrixXd::Zero(n, 3 * columns);
    for (int i = 0; i < nx; ++i) {
      if (edge_at(i) < 0 && edge_at(i + 1) < 0) continue;
      const MatrixXd &low = edge_at(i) >= 0 ? N[edge_at(i)] : zero,
                     &high = edge_at(i + 1) >= 0 ? N[edge_at(i + 1)] : zero;
      for (int j = 0; j < ny; ++j) {
        const int e = i * ny + j;
        const PlateMesh::Element& element = mesh_->element(i, j);
        const auto G = element.gradient.leftCols<2 * Side>();
        const auto U = gather<Side>(low, high, j);
        const Eigen::Matrix<double, 16, Eigen::Dynamic> a = G * U;
        Eigen::Matrix<double, 16, Eigen::Dynamic> s(16, 3 * columns);
        for (int k = 0; k < columns; ++k) {
          const auto a1 = a.middleCols<3>(3 * k);
          const Stress dn =
              weighted(stress_of(mesh_->membrane(), strain_product(a0_[e], a1)), element.weight);
          s.middleCols<3>(3 * k) = stress_times(dn, a0_[e]) + stress_times(n0_[e], a1);
        }
        const Eigen::Matrix<double, 2 * Side, Eigen::Dynamic> f =
            G.transpose() * s + element.bending.topLeftCorner<2 * Side, 2 * Side>() * U;
        F[i].middleRows<Side>(4 * j) += f.template topRows<Side>();
        F[i + 1].middleRows<Side>(4 * j) += f.template bottomRows<Side>();
      }
    }
  };
  if (mesh_->functions_per_side() == 8)
    product.template operator()<8>();
  else
    product.template operator()<4>();

  MatrixXd rows = MatrixXd::Zero(size(), columns);
  for (int line = 0; line <= nx; ++line) add_to_rows(line, F[line], rows);
  add_point_rates(N, variations, rows);
  // the edges' axes and arms turn and grow
  const auto& slopes = mesh_->edge_slopes();
  for (int e = 0; e < 2; ++e) {
    if (!rigid_[e]) continue;
    const int line = edges_[e].line, body = rows_.body(e);
    for (int k = 0; k < columns; ++k)
      for (int s = 0; s < n; ++s) {
        const Vector3d f = nodal_force_[line].row(s).transpose();
        Vector3d dv = N[e].block<1, 3>(s, 3 * k).transpose();
        if (s % 4 == 0) dv -= variations[k].edge[e].position;
        rows.block<3, 1>(body + 3, k) += dv.cross(f);
        for (std::size_t d = 0; d < slopes.size(); ++d)
          if (slopes[d].function == s % 4)
            rows(plate_->block_offset(line) + static_cast<int>(slopes.size()) * (s / 4) +
                     static_cast<int>(d),
                 k) += variations[k].edge[e].rotation.col(slopes[d].axis).dot(f);
      }
  }
  return rows;
}

// Covectors n0 of N0 (all lines) and n1 of N1 (edges), values and shape derivatives, of
//   q = Σ w [ e1·A e1 + A e0·q2 ] + N1ᵀB N1 + N0ᵀB N2 − μ N1ᵀM N1.
template <int Side>
void PlateGradient::quadratic_elements(const std::vector<MatrixXd>& N1,
                                       const std::array<MatrixXd, 2>& N2, const VectorXd& mu,
                                       Quadratic& q, std::vector<MatrixXd>& n0,
                                       std::array<MatrixXd, 2>& n1) const {
  constexpr int functions = 2 * Side;
  using Block = Eigen::Matrix<double, functions, Eigen::Dynamic>;
  using PointBlock = Eigen::Matrix<double, 16, Eigen::Dynamic>;
  const int n = mesh_->functions_per_line(), nx = mesh_->elements_along(),
            ny = mesh_->elements_across(), columns = static_cast<int>(mu.size());
  const MatrixXd zero = MatrixXd::Zero(n, 3 * columns);
  const auto column_dots = [&](const Block& A, const Block& B, auto&& add) {
    for (int k = 0; k < columns; ++k)
      add(k, A.template middleCols<3>(3 * k).cwiseProduct(B.template middleCols<3>(3 * k)).sum());
  };
  PointBlock a1, a2, da1, da2, s0(16, 3 * columns), s1(16, 3 * columns);
  Block U1, U2, BU, F0, F1;
  for (int i = 0; i < nx; ++i) {
    const int low = edge_at(i), high = edge_at(i + 1);
    const bool at_edge = low >= 0 || high >= 0;
    for (int j = 0; j < ny; ++j) {
      const int element_index = i * ny + j;
      const PlateMesh::Element& element = mesh_->element(i, j);
      const auto G = element.gradient.template leftCols<functions>();
      const auto B = element.bending.template topLeftCorner<functions, functions>();
      const auto M = element.mass.template topLeftCorner<functions, functions>();
      const Gradient& a0 = a0_[element_index];
      const Stress &e0 = strain_[element_index], &n_0 = n0_[element_index];
      const Eigen::Matrix<double, functions, 3> U0 =
          gather<Side>(plate_->nodal()[i], plate_->nodal()[i + 1], j);
      U1 = gather<Side>(N1[i], N1[i + 1], j);
      a1.noalias() = G * U1;
      if (at_edge) {
        U2 = gather<Side>(low >= 0 ? N2[low] : zero, high >= 0 ? N2[high] : zero, j);
        a2.noalias() = G * U2;
      }
      const PlateMeshRate::Shape& by_w = rate_->shape[PlateMeshRate::width];
      const auto dG = by_w.gradient[element_index].template leftCols<functions>();
      const Gradient da0 = dG * U0;
      da1.noalias() = dG * U1;
      if (at_edge) da2.noalias() = dG * U2;

      for (int k = 0; k < columns; ++k) {
        const auto a1k = a1.template middleCols<3>(3 * k);
        const Stress e1 = strain_product(a0, a1k);
        Stress e2 = strain_product(a1k, a1k);
        if (at_edge) e2 += strain_product(a0, a2.template middleCols<3>(3 * k));
        const Stress bare1 = stress_of(mesh_->membrane(), e1),
                     bare2 = stress_of(mesh_->membrane(), e2),
                     bare0 = stress_of(mesh_->membrane(), e0);
        const Stress nu1 = weighted(bare1, element.weight), nu2 = weighted(bare2, element.weight);
        q.stiffness[k] += sum(nu1, e1) + sum(n_0, e2);
        Gradient c0 = 2 * stress_times(nu1, a1k) + stress_times(nu2, a0);
        if (at_edge) c0 += stress_times(n_0, a2.template middleCols<3>(3 * k));
        const Gradient c1 = 2 * (stress_times(nu1, a0) + stress_times(n_0, a1k));
        s0.template middleCols<3>(3 * k) = c0;
        s1.template middleCols<3>(3 * k) = c1;
        // shape: the operators alone
        q.shape(0, k) +=
            c0.cwiseProduct(da0).sum() + c1.cwiseProduct(da1.template middleCols<3>(3 * k)).sum();
        if (at_edge)
          q.shape(0, k) +=
              stress_times(n_0, a0).cwiseProduct(da2.template middleCols<3>(3 * k)).sum();
        for (int p = 0; p < 3; ++p) {
          const PlateMeshRate::Shape& by = rate_->shape[p];
          if (!by.weight.empty()) {
            const PointArray& dw = by.weight[element_index];
            q.shape(p, k) += sum(weighted(bare1, dw), e1) + sum(weighted(bare0, dw), e2);
          }
          const PlateMesh::Membrane& dA = by.membrane;
          if (dA.A11 != 0 || dA.A12 != 0 || dA.A33 != 0)
            q.shape(p, k) += sum(weighted(stress_of(dA, e1), element.weight), e1) +
                             sum(weighted(stress_of(dA, e0), element.weight), e2);
        }
      }
      BU.noalias() = B * U1;
      column_dots(U1, BU, [&](int k, double d) { q.stiffness[k] += d; });
      F0.noalias() = G.transpose() * s0;
      if (at_edge) {
        F1.noalias() = G.transpose() * s1 + 2 * BU;
        const Block BU2 = B * U2;
        F0 += BU2;
        for (int k = 0; k < columns; ++k)
          q.stiffness[k] += U0.cwiseProduct(BU2.template middleCols<3>(3 * k)).sum();
      }
      for (int p = 0; p < 3; ++p) {
        const PlateMeshRate::Shape& by = rate_->shape[p];
        const auto dB = by.bending[element_index].template topLeftCorner<functions, functions>();
        if (!dB.isZero(0)) {
          BU.noalias() = dB * U1;
          column_dots(U1, BU, [&](int k, double d) { q.shape(p, k) += d; });
          if (at_edge) {
            const Eigen::Matrix<double, functions, 3> BU0 = dB * U0;
            for (int k = 0; k < columns; ++k)
              q.shape(p, k) += BU0.cwiseProduct(U2.template middleCols<3>(3 * k)).sum();
          }
        }
        if (!by.mass.empty()) {
          const auto dM = by.mass[element_index].template topLeftCorner<functions, functions>();
          BU.noalias() = dM * U1;
          column_dots(U1, BU, [&](int k, double d) { q.shape(p, k) -= mu[k] * d; });
        }
      }
      BU.noalias() = M * U1;
      column_dots(U1, BU, [&](int k, double d) { q.mass[k] += d; });
      if (at_edge) {
        for (int k = 0; k < columns; ++k)
          F1.template middleCols<3>(3 * k) -= 2 * mu[k] * BU.template middleCols<3>(3 * k);
        if (low >= 0) n1[low].template middleRows<Side>(4 * j) += F1.template topRows<Side>();
        if (high >= 0) n1[high].template middleRows<Side>(4 * j) += F1.template bottomRows<Side>();
      }
      n0[i].template middleRows<Side>(4 * j) += F0.template topRows<Side>();
      n0[i + 1].template middleRows<Side>(4 * j) += F0.template bottomRows<Side>();
    }
  }
}

PlateGradient::Quadratic PlateGradient::quadratic(const MatrixXd& Y, const VectorXd& mu) const {
  const int n = mesh_->functions_per_line(), lines = mesh_->lines(),
            columns = static_cast<int>(Y.cols());
  assert(Y.rows() == size() && mu.size() == columns);
  const auto& slopes = mesh_->edge_slopes();
  const int per_node = static_cast<int>(slopes.size());
  const MatrixXd T = rows_.edge_rows(Y);
  std::vector<MatrixXd> N1(lines), n0(lines, MatrixXd::Zero(n, 3 * columns));
  for (int i = 0; i < lines; ++i) N1[i] = plate_->nodal_rates(i, T).reshaped(n, 3 * columns);
  std::array<MatrixXd, 2> N2, n1;
  for (int e = 0; e < 2; ++e) {
    N2[e] = n1[e] = MatrixXd::Zero(n, 3 * columns);
    if (!rigid_[e]) continue;
    for (int k = 0; k < columns; ++k) {
      const Vector3d w = Y.block<3, 1>(rows_.body(e) + 3, k);
      for (int s = 0; s < n; ++s) {
        Vector3d r = w.cross(w.cross(edges_[e].arm[s]));
        for (int d = 0; d < per_node; ++d)
          if (slopes[d].function == s % 4)
            r += 2 * Y(plate_->block_offset(edges_[e].line) + per_node * (s / 4) + d, k) *
                 w.cross(edges_[e].axes.col(slopes[d].axis));
        N2[e].block<1, 3>(s, 3 * k) = r.transpose();
      }
    }
  }
  Quadratic q;
  q.stiffness = VectorXd::Zero(columns);
  q.mass = VectorXd::Zero(columns);
  q.shape = Eigen::Matrix3Xd::Zero(3, columns);
  q.state = MatrixXd::Zero(size(), columns);
  q.edge.resize(columns);
  if (mesh_->functions_per_side() == 8)
    quadratic_elements<8>(N1, N2, mu, q, n0, n1);
  else
    quadratic_elements<4>(N1, N2, mu, q, n0, n1);
  add_point_quadratic(Y, N1, N2, q, n1);

  for (int i = 0; i < lines; ++i)
    if (edge_at(i) < 0) add_to_rows(i, n0[i], q.state);
  // The edges: N0 = p + v, N1 = u̇ + ω×v + Σ ȧ d, N2 = ω×(ω×v) + 2 Σ ȧ ω×d with v = R w and axes d
  for (int e = 0; e < 2; ++e) {
    if (!rigid_[e]) continue;
    const int line = edges_[e].line, body = rows_.body(e);
    const Matrix3d& R = edges_[e].axes;
    for (int k = 0; k < columns; ++k) {
      Quadratic::Edge& g = q.edge[k][e];
      g.rotation.setZero();
      g.position.setZero();
      g.arm.setZero();
      g.displacement.setZero();
      g.spin.setZero();
      const Vector3d w = Y.block<3, 1>(body + 3, k);
      for (int s = 0; s < n; ++s) {
        const Vector3d f0 = n0[line].block<1, 3>(s, 3 * k).transpose(),
                       f1 = n1[e].block<1, 3>(s, 3 * k).transpose(),
                       f2 = nodal_force_[line].row(s).transpose();
        const Vector3d &v = edges_[e].arm[s], f2w = f2.cross(w);
        const Vector3d c = f0 + f1.cross(w) + f2w.cross(w);
        g.rotation += c * edges_[e].local[s].transpose();
        g.spin += v.cross(f1) + w.cross(v).cross(f2) + v.cross(f2w);
        q.state.block<3, 1>(body + 3, k) += v.cross(c);
        if (s % 4 == 0) {
          g.position += f0;
          g.displacement += f1;
          g.arm += R.transpose() * c;
          if (!mesh_->shape().is_beam()) g.across += mesh_->y()[s / 4] * R.col(1).dot(c);
        }
        for (int d = 0; d < per_node; ++d) {
          if (slopes[d].function != s % 4) continue;
          const int row = plate_->block_offset(line) + per_node * (s / 4) + d;
          const Vector3d axis = R.col(slopes[d].axis);
          const double rate = Y(row, k);
          const Vector3d cd = rate * (f1 + 2 * f2w);
          g.rotation.col(slopes[d].axis) += cd;
          g.spin += 2 * rate * axis.cross(f2);
          q.state.block<3, 1>(body + 3, k) += axis.cross(cd);
          q.state(row, k) += c.dot(axis);
        }
      }
      q.state.block<3, 1>(body, k) += g.position;
    }
  }
  return q;
}

double PlateGradient::rate(const Quadratic& q, const MatrixXd& Y, int k,
                           const LeafVariation& v) const {
  double sum = q.shape.col(k).dot(v.shape) + q.point.col(k).dot(v.point);
  if (rows_.point > 0) {
    const Vector3d y_u = Y.block<3, 1>(rows_.point_body(), k);
    sum += 2 * Y.block<3, 1>(rows_.unknowns, k).dot(v.turn * y_u - v.length * y_u);
  }
  for (int e = 0; e < 2; ++e) {
    if (!rigid_[e]) continue;
    const Quadratic::Edge& g = q.edge[k][e];
    const auto body = Y.col(k).segment<6>(rows_.body(e));
    sum += g.rotation.cwiseProduct(v.edge[e].rotation).sum() + g.position.dot(v.edge[e].position) +
           g.arm.dot(v.edge[e].arm) + g.across * v.shape[0] / mesh_->shape().width +
           g.displacement.dot(v.turn * body.head<3>() - v.length * body.head<3>()) +
           g.spin.dot(v.turn * body.tail<3>());
  }
  return sum;
}

}  // namespace flexopt
