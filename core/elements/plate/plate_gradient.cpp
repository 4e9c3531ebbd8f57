#include "core/elements/plate/plate_gradient.hpp"

#include <cassert>
#include <type_traits>
#include <utility>

#include "core/elements/plate/plate_curvature.hpp"
#include "core/elements/plate/plate_fields.hpp"
#include "core/elements/plate/plate_products.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {

using namespace plate;

namespace {
bool changes(const PlateMesh::Membrane& rate) {
  return rate.A11 != 0 || rate.A12 != 0 || rate.A33 != 0;
}
// Of strains that a changed metric of the undeflected leaf leaves.
template <class S>
Stress<S> metric_stress(const PlateMesh& mesh, const PointArray& metric, const PointArray& weight) {
  Stress<S> e = Stress<S>::Zero();
  for (int g = 0; g < points; ++g) e(g, 0) = -0.5 * metric[g];
  return weighted(stress_of(mesh.membrane(), e), weight);
}
}  // namespace

PlateGradientState<double> present_state(const PlateLeaf& plate) {
  const PlateLeaf::State& at = plate.state();
  return {{at.edges[0].axes, at.edges[1].axes}, at.x, at.point, at.point_force, plate.nodal()};
}

template <class S>
PlateGradient<S>::PlateGradient(const PlateLeaf& plate, std::shared_ptr<const PlateMeshRate> rate,
                                const LeafRows& rows, PlateGradientState<S> state)
    : LeafGradient<S>(rows, plate.mesh().shape().width),
      plate_(&plate),
      mesh_(&plate.mesh()),
      rate_(std::move(rate)),
      state_(std::move(state)) {
  const auto& slopes = mesh_->edge_slopes();
  const PlateSupport& support = plate.support();
  for (const ShapeRate& along : rate_->direction) {
    point_rates_.emplace_back();
    if (support.point.empty()) continue;
    point_rates_.back() =
        support.spread_over_tip
            ? tip_mean_weight_rates(*mesh_, along)
            : point_weight_rates(*mesh_, along, support.place[0], support.place[1]);
  }
  for (int e = 0; e < 2; ++e) {
    EdgeNodes& edge = edges_[e];
    edge.line = e == 0 ? 0 : mesh_->lines() - 1;
    rigid_[e] = plate.is_rigid_edge(edge.line);
    if (!rigid_[e]) continue;
    edge.axes = state_.axes[e];
    const Vector3d arm = plate.state().edges[e].axes.transpose() * rows.lever[e];
    for (int j = 0; j < mesh_->nodes_per_line(); ++j) {
      std::array<Vector3d, 4> reference =
          PlateLeaf::edge_reference(*mesh_, edge.line, j, plate.clamp());
      reference[0] += arm;
      std::array<Vector3<S>, 4> w;
      for (int k = 0; k < 4; ++k) w[k] = reference[k].template cast<S>();
      const S* a =
          state_.x.data() + plate.block_offset(edge.line) + static_cast<int>(slopes.size()) * j;
      for (const PlateMesh::EdgeSlope& s : slopes) w[s.function][s.axis] += *a++;
      for (const Vector3<S>& local : w) {
        edge.local.push_back(local);
        edge.arm.push_back(edge.axes * local);
      }
    }
  }
  if (mesh_->functions_per_side() == 8)
    this->template prepare<8>();
  else
    this->template prepare<4>();
  add_point_force();
  add_weight();
  Matrix force = Matrix::Zero(size(), 1);
  for (int line = 0; line < mesh_->lines(); ++line) add_to_rows(line, nodal_force_[line], force);
  force_ = force;
  if (rows.point > 0) {
    Vector3<S> apart = state_.point + (plate.clamp() * plate.point_place()).template cast<S>();
    for (const NodalWeight& w : plate.support().point)
      apart -= w.weight * state_.nodal[w.line].row(w.function).transpose();
    force_.template segment<3>(rows.unknowns) = apart;
    force_.template segment<3>(rows.point_body()) = state_.point_force;
  }
}

template <class S>
void PlateGradient<S>::add_weight() {
  weight_ = plate_->weight();
  if (weight_.isZero(0)) return;
  const Eigen::RowVector3d weight = weight_.transpose();
  const int lines = mesh_->lines(), n = mesh_->functions_per_line(), ny = mesh_->elements_across(),
            side = mesh_->functions_per_side();
  for (int i = 0; i < lines; ++i)
    nodal_force_[i] -= (mesh_->mass_moment(i) * weight).template cast<S>();
  for (int p = 0; p < directions(); ++p) {
    std::vector<VectorXd>& rates =
        moment_rates_.emplace_back(static_cast<std::size_t>(lines), VectorXd::Zero(n));
    const auto& mass = rate_->shape[p].mass;
    for (std::size_t k = 0; k < mass.size(); ++k) {
      const std::size_t i = k / static_cast<std::size_t>(ny);
      const int j = static_cast<int>(k) % ny;
      VectorXd moment = VectorXd::Zero(2 * side);
      for (int s = 0; s < 2 * side; s += 4) moment += mass[k].col(s).head(2 * side);
      rates[i].segment(4 * j, side) += moment.head(side);
      rates[i + 1].segment(4 * j, side) += moment.tail(side);
    }
    for (int i = 0; i < lines; ++i)
      shape_force_[p][i] -= (rates[static_cast<std::size_t>(i)] * weight).template cast<S>();
  }
}

template <class S>
int PlateGradient<S>::edge_at(int line) const {
  if (line == 0 && rigid_[0]) return 0;
  if (line == mesh_->lines() - 1 && rigid_[1]) return 1;
  return -1;
}

// Strains, stresses, nodal forces and what these change by with the shape.
template <class S>
template <int Side>
void PlateGradient<S>::prepare() {
  using Block = Eigen::Matrix<S, 2 * Side, 3>;
  const int n = mesh_->functions_per_line(), nx = mesh_->elements_along(),
            ny = mesh_->elements_across();
  nodal_force_.assign(nx + 1, Matrix::Zero(n, 3));
  shape_force_.assign(directions(), std::vector<Matrix>(nx + 1, Matrix::Zero(n, 3)));
  a0_.resize(nx * ny);
  strain_.resize(nx * ny);
  n0_.resize(nx * ny);
  natural_.resize(nx * ny);
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      const int k = i * ny + j;
      const PlateMesh::Element& element = mesh_->element(i, j);
      const auto G = element.gradient.leftCols<2 * Side>();
      const Block U = gather<Side>(state_.nodal[i], state_.nodal[i + 1], j);
      Gradient<S>& a0 = a0_[k];
      assign_product(a0, G, U);
      Stress<S>& e = strain_[k] = 0.5 * strain_product(a0, a0);
      for (int g = 0; g < points; ++g) e(g, 0) -= 0.5 * element.metric[g];
      e.col(1) -= S(0.5);
      const Stress<S> bare = stress_of(mesh_->membrane(), e);
      n0_[k] = weighted(bare, element.weight);
      const Gradient<S> s = stress_times(n0_[k], a0);
      const auto add = [&](std::vector<Matrix>& to, const Block& F) {
        to[i].template middleRows<Side>(4 * j) += F.template topRows<Side>();
        to[i + 1].template middleRows<Side>(4 * j) += F.template bottomRows<Side>();
      };
      Block F, part;
      const auto add_part = [&](const auto& A, const auto& B) {
        assign_product(part, A, B);
        F += part;
      };
      assign_product(F, G.transpose(), s);
      add_part(element.bending.topLeftCorner<2 * Side, 2 * Side>(), U);
      const bool natural = element.curvature_weight.size() > 0;
      Matrix bent;
      const auto add_curvature = [&](const MatrixXd& rows, const Matrix& field) {
        F += curvature_force(rows, 2 * Side, field);
      };
      if (natural) {
        const Matrix& field = natural_[k] = curvature_field(element.curvature, U);
        bent = 0.5 * curvature_product(element.curvature_weight, field, field);
        add_curvature(element.curvature, bent);
      }
      add(nodal_force_, F);
      for (int p = 0; p < directions(); ++p) {
        const PlateMeshRate::Shape& by = rate_->shape[p];
        Stress<S> dn = weighted(stress_of(by.membrane, e), element.weight);
        if (!by.weight.empty()) dn += weighted(bare, by.weight[k]);
        if (!by.metric.empty()) dn += metric_stress<S>(*mesh_, by.metric[k], element.weight);
        if (by.gradient.empty()) {
          assign_product(F, G.transpose(), stress_times(dn, a0));
        } else {
          const auto dG = by.gradient[k].leftCols<2 * Side>();
          Gradient<S> da;
          assign_product(da, dG, U);
          dn += weighted(stress_of(mesh_->membrane(), strain_product(a0, da)), element.weight);
          const Gradient<S> ds = stress_times(dn, a0) + stress_times(n0_[k], da);
          assign_product(F, G.transpose(), ds);
          add_part(dG.transpose(), s);
        }
        add_part(by.bending[k].template topLeftCorner<2 * Side, 2 * Side>(), U);
        if (!by.curvature_weight.empty())
          add_curvature(element.curvature,
                        0.5 * curvature_product(by.curvature_weight[k], natural_[k], natural_[k]));
        if (!by.curvature.empty()) {
          add_curvature(element.curvature, curvature_product(element.curvature_weight, natural_[k],
                                                             curvature_field(by.curvature[k], U)));
          add_curvature(by.curvature[k], bent);
        }
        add(shape_force_[p], F);
      }
    }
}

template <class S>
void PlateGradient<S>::add_to_rows(int line, const Matrix& nodal, Matrix& rows) const {
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
      const Vector3<S> f = nodal.template block<1, 3>(s, 3 * k).transpose();
      if (s % 4 == 0) rows.template block<3, 1>(body, k) += f;
      rows.template block<3, 1>(body + 3, k) += edges_[e].arm[s].cross(f);
      for (std::size_t d = 0; d < slopes.size(); ++d)
        if (slopes[d].function == s % 4)
          rows(plate_->block_offset(line) + static_cast<int>(slopes.size()) * (s / 4) +
                   static_cast<int>(d),
               k) += edges_[e].axes.col(slopes[d].axis).dot(f);
    }
}

// N0′ of the edges' nodes: functions × (3 components of each variation).
template <class S>
auto PlateGradient<S>::edge_nodal_rates(const std::vector<LeafVariation<S>>& variations) const
    -> std::array<Matrix, 2> {
  const int n = mesh_->functions_per_line(), columns = static_cast<int>(variations.size());
  std::array<Matrix, 2> rates{Matrix::Zero(n, 3 * columns), Matrix::Zero(n, 3 * columns)};
  for (int e = 0; e < 2; ++e) {
    if (!rigid_[e]) continue;
    for (int k = 0; k < columns; ++k) {
      const LeafVariation<S>& v = variations[k];
      for (int s = 0; s < n; ++s) {
        Vector3<S> r = v.edge[e].rotation * edges_[e].local[s];
        Vector3d local = s % 4 == 0 ? v.edge[e].arm : Vector3d(Vector3d::Zero());
        for (int p = 0; p < directions(); ++p)
          if (!rate_->shape[p].reference.empty())
            local += held(s) * coordinate(v, p) *
                     rate_->shape[p].reference[edges_[e].line].row(s).transpose();
        r += edges_[e].axes * local;
        if (s % 4 == 0) r += v.edge[e].position;
        rates[e].template block<1, 3>(s, 3 * k) = r.transpose();
      }
    }
  }
  return rates;
}

template <class S>
auto PlateGradient<S>::line_rates(int line, const Matrix& Y) const -> Matrix {
  const int n = mesh_->functions_per_line(), columns = static_cast<int>(Y.cols()),
            first = plate_->block_offset(line), e = edge_at(line);
  if (e < 0) return Matrix(Y.middleRows(first, 3 * n)).reshaped(n, 3 * columns);
  const auto& slopes = mesh_->edge_slopes();
  const int body = rows_.body(e), per_node = static_cast<int>(slopes.size());
  Matrix N(n, 3 * columns);
  for (int k = 0; k < columns; ++k) {
    const Vector3<S> u = Y.template block<3, 1>(body, k), w = Y.template block<3, 1>(body + 3, k);
    for (int s = 0; s < n; ++s) {
      Vector3<S> r = w.cross(edges_[e].arm[s]);
      if (s % 4 == 0) r += u;
      for (int d = 0; d < per_node; ++d)
        if (slopes[d].function == s % 4)
          r += Y(first + per_node * (s / 4) + d, k) * edges_[e].axes.col(slopes[d].axis);
      N.template block<1, 3>(s, 3 * k) = r.transpose();
    }
  }
  return N;
}

template <class S>
std::unique_ptr<LeafFields> PlateGradient<S>::fields(
    const Matrix& rows, const std::vector<LeafVariation<S>>& variations) const {
  if constexpr (std::is_same_v<S, double>) {
    const std::array<Matrix, 2> edges = edge_nodal_rates(variations);
    std::vector<Matrix> rates;
    for (int i = 0; i < mesh_->lines(); ++i) {
      rates.push_back(line_rates(i, rows));
      if (const int e = edge_at(i); e >= 0) rates.back() += edges[e];
    }
    std::vector<ShapeRate> shapes;
    for (const LeafVariation<S>& v : variations) shapes.push_back(rate_->along(v.shape, v.profile));
    return std::make_unique<PlateFields>(*mesh_, state_.nodal, std::move(rates), std::move(shapes));
  } else {
    return nullptr;
  }
}

template <class S>
auto PlateGradient<S>::force_rates(const std::vector<LeafVariation<S>>& variations) const
    -> Matrix {
  const int n = mesh_->functions_per_line(), nx = mesh_->elements_along(),
            ny = mesh_->elements_across(), columns = static_cast<int>(variations.size());
  const std::array<Matrix, 2> N = edge_nodal_rates(variations);
  std::vector<Matrix> F(nx + 1, Matrix::Zero(n, 3 * columns));
  for (int line = 0; line <= nx; ++line)
    for (int k = 0; k < columns; ++k)
      for (int p = 0; p < directions(); ++p)
        F[line].template middleCols<3>(3 * k) +=
            coordinate(variations[k], p) * shape_force_[p][line];

  if (!weight_.isZero(0))
    for (int k = 0; k < columns; ++k) {
      const Eigen::RowVector3d rate = this->weight_rate(variations[k]).transpose();
      for (int line = 0; line <= nx; ++line)
        F[line].template middleCols<3>(3 * k) -=
            (mesh_->mass_moment(line) * rate).template cast<S>();
    }
  const Eigen::RowVector3<S> point_force = state_.point_force.transpose();
  for (int a = 0; a < 2; ++a)
    for (const NodalWeight& w : plate_->support().point_slopes[a])
      for (int k = 0; k < columns; ++k)
        F[w.line].template block<1, 3>(w.function, 3 * k) -=
            variations[k].point[a] * w.weight * point_force;

  // K N′, which only the elements at the edges feel
  const auto product = [&]<int Side>() {
    using PointBlock = Eigen::Matrix<S, 16, Eigen::Dynamic>;
    Eigen::Matrix<S, 2 * Side, Eigen::Dynamic> f, bent;
    const Matrix zero = Matrix::Zero(n, 3 * columns);
    for (int i = 0; i < nx; ++i) {
      if (edge_at(i) < 0 && edge_at(i + 1) < 0) continue;
      const Matrix &low = edge_at(i) >= 0 ? N[edge_at(i)] : zero,
                   &high = edge_at(i + 1) >= 0 ? N[edge_at(i + 1)] : zero;
      for (int j = 0; j < ny; ++j) {
        const int e = i * ny + j;
        const PlateMesh::Element& element = mesh_->element(i, j);
        const auto G = element.gradient.leftCols<2 * Side>();
        const auto U = gather<Side>(low, high, j);
        PointBlock a, s(16, 3 * columns);
        assign_product(a, G, U);
        for (int k = 0; k < columns; ++k) {
          const auto a1 = a.template middleCols<3>(3 * k);
          const Stress<S> dn =
              weighted(stress_of(mesh_->membrane(), strain_product(a0_[e], a1)), element.weight);
          s.template middleCols<3>(3 * k) = stress_times(dn, a0_[e]) + stress_times(n0_[e], a1);
        }
        assign_product(f, G.transpose(), s);
        assign_product(bent, element.bending.topLeftCorner<2 * Side, 2 * Side>(), U);
        f += bent;
        if (element.curvature_weight.size() > 0) {
          const auto field = curvature_field(element.curvature, U);
          for (int k = 0; k < columns; ++k)
            f.template middleCols<3>(3 * k) +=
                curvature_force(element.curvature, 2 * Side,
                                curvature_product(element.curvature_weight, natural_[e],
                                                  field.template middleCols<3>(3 * k)));
        }
        F[i].template middleRows<Side>(4 * j) += f.template topRows<Side>();
        F[i + 1].template middleRows<Side>(4 * j) += f.template bottomRows<Side>();
      }
    }
  };
  if (mesh_->functions_per_side() == 8)
    product.template operator()<8>();
  else
    product.template operator()<4>();

  Matrix rows = Matrix::Zero(size(), columns);
  for (int line = 0; line <= nx; ++line) add_to_rows(line, F[line], rows);
  add_point_rates(N, variations, rows);
  // the edges' axes and arms turn and grow
  const auto& slopes = mesh_->edge_slopes();
  for (int e = 0; e < 2; ++e) {
    if (!rigid_[e]) continue;
    const int line = edges_[e].line, body = rows_.body(e);
    for (int k = 0; k < columns; ++k)
      for (int s = 0; s < n; ++s) {
        const Vector3<S> f = nodal_force_[line].row(s).transpose();
        Vector3<S> dv = N[e].template block<1, 3>(s, 3 * k).transpose();
        if (s % 4 == 0) dv -= variations[k].edge[e].position;
        rows.template block<3, 1>(body + 3, k) += dv.cross(f);
        for (std::size_t d = 0; d < slopes.size(); ++d)
          if (slopes[d].function == s % 4)
            rows(plate_->block_offset(line) + static_cast<int>(slopes.size()) * (s / 4) +
                     static_cast<int>(d),
                 k) += variations[k].edge[e].rotation.col(slopes[d].axis).dot(f);
      }
  }
  return rows;
}

// Covectors n0 of N0 (all lines) and n1 of N1 (lines that are asked for), N2 on lines that have it;
// values and shape derivatives, of
//   q = Σ w [ e1·A e1 + A e0·q2 ] + N1ᵀB N1 + N0ᵀB N2 − μ N1ᵀM N1.
template <class S>
template <int Side>
void PlateGradient<S>::quadratic_elements(const std::vector<Matrix>& N1,
                                          const std::vector<Matrix>& N2, const Vector& mu,
                                          LeafQuadratic<S>& q, std::vector<Matrix>& n0,
                                          std::vector<Matrix>& n1) const {
  constexpr int functions = 2 * Side;
  using Block = Eigen::Matrix<S, functions, Eigen::Dynamic>;
  using ElementBlock = Eigen::Matrix<S, functions, 3>;
  using PointBlock = Eigen::Matrix<S, 16, Eigen::Dynamic>;
  const int n = mesh_->functions_per_line(), nx = mesh_->elements_along(),
            ny = mesh_->elements_across(), columns = static_cast<int>(mu.size());
  const Matrix zero = Matrix::Zero(n, 3 * columns);
  const auto column_dots = [&](const Block& A, const Block& B, auto&& add) {
    for (int k = 0; k < columns; ++k)
      add(k, A.template middleCols<3>(3 * k).cwiseProduct(B.template middleCols<3>(3 * k)).sum());
  };
  PointBlock a1, a2, s0(16, 3 * columns), s1(16, 3 * columns);
  Block U1, U2, BU, BU2, F0, F1;
  struct Along {
    bool moves = false, weighs = false, bends = false;
    Gradient<S> da0;
    PointBlock da1, da2;
    Stress<S> dn_0;
    Matrix db0, db1, db2;  // of the fields of a curved leaf
  };
  Matrix b1, b2;
  std::vector<Along> along_shape(static_cast<std::size_t>(directions()));
  ElementBlock BU0;
  const auto stress_rate = [&](const PlateMeshRate::Shape& by, int element, const Stress<S>& e) {
    Stress<S> n = Stress<S>::Zero();
    if (changes(by.membrane))
      n = weighted(stress_of(by.membrane, e), mesh_->element(element / ny, element % ny).weight);
    if (!by.weight.empty()) n += weighted(stress_of(mesh_->membrane(), e), by.weight[element]);
    return n;
  };
  for (int i = 0; i < nx; ++i) {
    const bool curved = N2[i].size() > 0 || N2[i + 1].size() > 0,
               moved = n1[i].size() > 0 || n1[i + 1].size() > 0;
    for (int j = 0; j < ny; ++j) {
      const int element_index = i * ny + j;
      const PlateMesh::Element& element = mesh_->element(i, j);
      const auto G = element.gradient.template leftCols<functions>();
      const auto B = element.bending.template topLeftCorner<functions, functions>();
      const auto M = element.mass.template topLeftCorner<functions, functions>();
      const Gradient<S>& a0 = a0_[element_index];
      const Stress<S>&e0 = strain_[element_index], &n_0 = n0_[element_index];
      const ElementBlock U0 = gather<Side>(state_.nodal[i], state_.nodal[i + 1], j);
      U1 = gather<Side>(N1[i], N1[i + 1], j);
      assign_product(a1, G, U1);
      if (curved) {
        U2 = gather<Side>(N2[i].size() > 0 ? N2[i] : zero, N2[i + 1].size() > 0 ? N2[i + 1] : zero,
                          j);
        assign_product(a2, G, U2);
      }
      // of the gradients, and of the stresses by the shape, the strains being constant
      for (int p = 0; p < directions(); ++p) {
        const PlateMeshRate::Shape& by = rate_->shape[p];
        Along& a = along_shape[p];
        a.moves = !by.gradient.empty();
        a.weighs = changes(by.membrane) || !by.weight.empty() || !by.metric.empty();
        if (a.weighs) a.dn_0 = stress_rate(by, element_index, e0);
        if (!by.metric.empty())
          a.dn_0 += metric_stress<S>(*mesh_, by.metric[element_index], element.weight);
        a.bends = !by.curvature.empty();
        if (a.bends) {
          const MatrixXd& dH = by.curvature[element_index];
          a.db0 = curvature_field(dH, U0);
          a.db1 = curvature_field(dH, U1);
          if (curved) a.db2 = curvature_field(dH, U2);
        }
        if (!a.moves) continue;
        const auto dG = by.gradient[element_index].template leftCols<functions>();
        assign_product(a.da0, dG, U0);
        assign_product(a.da1, dG, U1);
        if (curved) assign_product(a.da2, dG, U2);
      }

      for (int k = 0; k < columns; ++k) {
        const auto a1k = a1.template middleCols<3>(3 * k);
        const Stress<S> e1 = strain_product(a0, a1k);
        Stress<S> e2 = strain_product(a1k, a1k);
        if (curved) e2 += strain_product(a0, a2.template middleCols<3>(3 * k));
        const Stress<S> nu1 = weighted(stress_of(mesh_->membrane(), e1), element.weight),
                        nu2 = weighted(stress_of(mesh_->membrane(), e2), element.weight);
        q.stiffness[k] += sum(nu1, e1) + sum(n_0, e2);
        Gradient<S> c0 = 2.0 * stress_times(nu1, a1k) + stress_times(nu2, a0);
        if (curved) c0 += stress_times(n_0, a2.template middleCols<3>(3 * k));
        const Gradient<S> c1 = 2.0 * (stress_times(nu1, a0) + stress_times(n_0, a1k));
        s0.template middleCols<3>(3 * k) = c0;
        s1.template middleCols<3>(3 * k) = c1;
        // shape: the operators alone
        for (int p = 0; p < directions(); ++p) {
          const Along& a = along_shape[p];
          if (a.moves) {
            along(q, p, k) += c0.cwiseProduct(a.da0).sum() +
                              c1.cwiseProduct(a.da1.template middleCols<3>(3 * k)).sum();
            if (curved)
              along(q, p, k) +=
                  stress_times(n_0, a0).cwiseProduct(a.da2.template middleCols<3>(3 * k)).sum();
          }
          if (a.weighs)
            along(q, p, k) +=
                sum(stress_rate(rate_->shape[p], element_index, e1), e1) + sum(a.dn_0, e2);
        }
      }
      assign_product(BU, B, U1);
      column_dots(U1, BU, [&](int k, const S& d) { q.stiffness[k] += d; });
      assign_product(F0, G.transpose(), s0);
      if (moved) {
        assign_product(F1, G.transpose(), s1);
        F1 += 2.0 * BU;
      }
      // the cubic energy of a curved leaf: b1·(b0, b1) + ½ b2·(b0, b0) of curvature_product
      if (element.curvature_weight.size() > 0) {
        const Matrix& b0 = natural_[element_index];
        const Eigen::ArrayXd& c = element.curvature_weight;
        b1 = curvature_field(element.curvature, U1);
        if (curved) b2 = curvature_field(element.curvature, U2);
        const Matrix c2 = 0.5 * curvature_product(c, b0, b0);
        for (int k = 0; k < columns; ++k) {
          const auto b1k = b1.template middleCols<3>(3 * k);
          const Matrix once = curvature_product(c, b0, b1k), c1 = 2.0 * once;
          Matrix c0 = curvature_product(c, b1k, b1k);
          q.stiffness[k] += once.cwiseProduct(b1k).sum();
          if (curved) {
            const auto b2k = b2.template middleCols<3>(3 * k);
            c0 += curvature_product(c, b0, b2k);
            q.stiffness[k] += c2.cwiseProduct(b2k).sum();
          }
          F0.template middleCols<3>(3 * k) += curvature_force(element.curvature, functions, c0);
          if (moved)
            F1.template middleCols<3>(3 * k) += curvature_force(element.curvature, functions, c1);
          for (int p = 0; p < directions(); ++p) {
            const Along& a = along_shape[p];
            if (a.bends) {
              along(q, p, k) += c0.cwiseProduct(a.db0).sum() +
                                c1.cwiseProduct(a.db1.template middleCols<3>(3 * k)).sum();
              if (curved)
                along(q, p, k) += c2.cwiseProduct(a.db2.template middleCols<3>(3 * k)).sum();
            }
            if (rate_->shape[p].curvature_weight.empty()) continue;
            const Eigen::ArrayXd& dc = rate_->shape[p].curvature_weight[element_index];
            along(q, p, k) += curvature_product(dc, b0, b1k).cwiseProduct(b1k).sum();
            if (curved)
              along(q, p, k) += 0.5 * curvature_product(dc, b0, b0)
                                          .cwiseProduct(b2.template middleCols<3>(3 * k))
                                          .sum();
          }
        }
      }
      if (curved) {
        assign_product(BU2, B, U2);
        F0 += BU2;
        for (int k = 0; k < columns; ++k)
          q.stiffness[k] += U0.cwiseProduct(BU2.template middleCols<3>(3 * k)).sum();
      }
      for (int p = 0; p < directions(); ++p) {
        const PlateMeshRate::Shape& by = rate_->shape[p];
        const auto dB = by.bending[element_index].template topLeftCorner<functions, functions>();
        if (!dB.isZero(0)) {
          assign_product(BU, dB, U1);
          column_dots(U1, BU, [&](int k, const S& d) { along(q, p, k) += d; });
          if (curved) {
            assign_product(BU0, dB, U0);
            for (int k = 0; k < columns; ++k)
              along(q, p, k) += BU0.cwiseProduct(U2.template middleCols<3>(3 * k)).sum();
          }
        }
        if (!by.mass.empty()) {
          const auto dM = by.mass[element_index].template topLeftCorner<functions, functions>();
          assign_product(BU, dM, U1);
          column_dots(U1, BU, [&](int k, const S& d) { along(q, p, k) -= mu[k] * d; });
        }
      }
      assign_product(BU, M, U1);
      column_dots(U1, BU, [&](int k, const S& d) { q.mass[k] += d; });
      if (moved) {
        for (int k = 0; k < columns; ++k)
          F1.template middleCols<3>(3 * k) -= S(2.0 * mu[k]) * BU.template middleCols<3>(3 * k);
        if (n1[i].size() > 0) n1[i].template middleRows<Side>(4 * j) += F1.template topRows<Side>();
        if (n1[i + 1].size() > 0)
          n1[i + 1].template middleRows<Side>(4 * j) += F1.template bottomRows<Side>();
      }
      n0[i].template middleRows<Side>(4 * j) += F0.template topRows<Side>();
      n0[i + 1].template middleRows<Side>(4 * j) += F0.template bottomRows<Side>();
    }
  }
}

// Of − Σ m w·N2 with the weight w.
template <class S>
void PlateGradient<S>::add_weight_quadratic(const std::vector<Matrix>& N2,
                                            LeafQuadratic<S>& q) const {
  if (weight_.isZero(0)) return;
  const Vector3<S> weight = weight_.template cast<S>();
  for (const EdgeNodes& edge : edges_) {
    const Matrix& second = N2[static_cast<std::size_t>(edge.line)];
    for (Eigen::Index k = 0; 3 * k < second.cols(); ++k) {
      const auto of = second.template middleCols<3>(3 * k);
      const auto moved = [&](const VectorXd& m) {
        return Vector3<S>(of.transpose() * m.template cast<S>());
      };
      const Vector3<S> whole = moved(mesh_->mass_moment(edge.line));
      q.stiffness[k] -= weight.dot(whole);
      q.weight.col(k) -= whole;
      for (int p = 0; p < directions(); ++p)
        along(q, p, static_cast<int>(k)) -=
            weight.dot(moved(moment_rates_[p][static_cast<std::size_t>(edge.line)]));
    }
  }
}

template <class S>
auto PlateGradient<S>::quadratic(const Matrix& Y, const Vector& mu) const -> LeafQuadratic<S> {
  const int n = mesh_->functions_per_line(), lines = mesh_->lines(),
            columns = static_cast<int>(Y.cols());
  assert(Y.rows() == size() && mu.size() == columns);
  const auto& slopes = mesh_->edge_slopes();
  const int per_node = static_cast<int>(slopes.size());
  std::vector<Matrix> N1(lines), n0(lines, Matrix::Zero(n, 3 * columns));
  for (int i = 0; i < lines; ++i) N1[i] = line_rates(i, Y);
  std::vector<Matrix> N2(lines), n1(lines);  // of the edges alone
  for (int e = 0; e < 2; ++e) {
    if (!rigid_[e]) continue;
    Matrix& second = N2[edges_[e].line] = Matrix::Zero(n, 3 * columns);
    n1[edges_[e].line] = second;
    for (int k = 0; k < columns; ++k) {
      const Vector3<S> w = Y.template block<3, 1>(rows_.body(e) + 3, k);
      for (int s = 0; s < n; ++s) {
        Vector3<S> r = w.cross(w.cross(edges_[e].arm[s]));
        for (int d = 0; d < per_node; ++d)
          if (slopes[d].function == s % 4)
            r += S(2.0 * Y(plate_->block_offset(edges_[e].line) + per_node * (s / 4) + d, k)) *
                 w.cross(edges_[e].axes.col(slopes[d].axis));
        second.template block<1, 3>(s, 3 * k) = r.transpose();
      }
    }
  }
  LeafQuadratic<S> q(size(), columns, profiles());
  if (mesh_->functions_per_side() == 8)
    this->template quadratic_elements<8>(N1, N2, mu, q, n0, n1);
  else
    this->template quadratic_elements<4>(N1, N2, mu, q, n0, n1);
  add_point_quadratic(Y, N1, N2, q, n1);
  add_weight_quadratic(N2, q);

  for (int i = 0; i < lines; ++i)
    if (edge_at(i) < 0) add_to_rows(i, n0[i], q.state);
  // The edges: N0 = p + v, N1 = u̇ + ω×v + Σ ȧ d, N2 = ω×(ω×v) + 2 Σ ȧ ω×d with v = R w and axes d
  for (int e = 0; e < 2; ++e) {
    if (!rigid_[e]) continue;
    const int line = edges_[e].line, body = rows_.body(e);
    const Matrix3<S>& R = edges_[e].axes;
    for (int k = 0; k < columns; ++k) {
      typename LeafQuadratic<S>::Edge& g = q.edge[k][e];
      const Vector3<S> w = Y.template block<3, 1>(body + 3, k);
      for (int s = 0; s < n; ++s) {
        const Vector3<S> f0 = n0[line].template block<1, 3>(s, 3 * k).transpose(),
                         f1 = n1[line].template block<1, 3>(s, 3 * k).transpose(),
                         f2 = nodal_force_[line].row(s).transpose();
        const Vector3<S>&v = edges_[e].arm[s], f2w = f2.cross(w);
        const Vector3<S> c = f0 + f1.cross(w) + f2w.cross(w);
        g.rotation += c * edges_[e].local[s].transpose();
        g.spin += v.cross(f1) + w.cross(v).cross(f2) + v.cross(f2w);
        q.state.template block<3, 1>(body + 3, k) += v.cross(c);
        if (s % 4 == 0) {
          g.position += f0;
          g.displacement += f1;
          g.arm += R.transpose() * c;
        }
        for (int p = 0; p < directions(); ++p)
          if (!rate_->shape[p].reference.empty())
            along(q, p, k) +=
                held(s) * c.dot(R * rate_->shape[p].reference[line].row(s).transpose());
        for (int d = 0; d < per_node; ++d) {
          if (slopes[d].function != s % 4) continue;
          const int row = plate_->block_offset(line) + per_node * (s / 4) + d;
          const Vector3<S> axis = R.col(slopes[d].axis);
          const S rate = Y(row, k);
          const Vector3<S> cd = rate * (f1 + 2.0 * f2w);
          g.rotation.col(slopes[d].axis) += cd;
          g.spin += S(2.0 * rate) * axis.cross(f2);
          q.state.template block<3, 1>(body + 3, k) += axis.cross(cd);
          q.state(row, k) += c.dot(axis);
        }
      }
      q.state.template block<3, 1>(body, k) += g.position;
    }
  }
  return q;
}

template <class S>
auto PlateGradient<S>::nodal_quadratic(const std::vector<Matrix>& N1,
                                       const std::vector<Matrix>& N2) const -> NodalQuadratic {
  const int n = mesh_->functions_per_line(), lines = mesh_->lines(),
            columns = static_cast<int>(N1[0].cols() / 3);
  const std::vector<Matrix> none(static_cast<std::size_t>(lines), Matrix::Zero(n, 3 * columns));
  NodalQuadratic result{LeafQuadratic<S>(0, columns, profiles()), none, none};
  const Vector mu = Vector::Zero(columns);
  if (mesh_->functions_per_side() == 8)
    this->template quadratic_elements<8>(N1, N2, mu, result.value, result.n0, result.n1);
  else
    this->template quadratic_elements<4>(N1, N2, mu, result.value, result.n0, result.n1);
  return result;
}

template class PlateGradient<double>;
template class PlateGradient<Jet>;

}  // namespace flexopt
