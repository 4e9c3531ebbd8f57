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
          PlateLeaf::edge_reference(*mesh_, edge.line, j, plate.clamp(e));
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
  mesh_->with_side([&]<int Side>() { this->template prepare<Side>(); });
  add_point_force();
  add_weight();
  Matrix force = Matrix::Zero(size(), 1);
  for (int line = 0; line < mesh_->lines(); ++line) add_to_rows(line, nodal_force_[line], force);
  force_ = force;
  if (rows.point > 0) {
    Vector3<S> apart =
        state_.point + (plate.place_ratio() * plate.point_place()).template cast<S>();
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

namespace {

// Change of an element's nodal force with its shape; `bent`: covector of the natural field.
template <int Side, class S>
Eigen::Matrix<S, 2 * Side, 3> force_rate(const PlateMesh& mesh, const PlateMeshRate::Shape& by,
                                         const DeflectedElement<S>& e,
                                         const Eigen::Matrix<S, 2 * Side, 3>& U,
                                         const Eigen::MatrixX<S>& bent) {
  const PlateMesh::Element& element = e.operators;
  const auto G = element.gradient.leftCols<2 * Side>();
  Eigen::Matrix<S, 2 * Side, 3> F, part;
  const auto add_part = [&](const auto& A, const auto& B) {
    assign_product(part, A, B);
    F += part;
  };
  const auto add_curvature = [&](const MatrixXd& rows, const Eigen::MatrixX<S>& field) {
    F += curvature_force(rows, 2 * Side, field);
  };
  Stress<S> dn = stress_rate(mesh, by, e, e.strain);
  if (!by.metric.empty()) dn += metric_stress<S>(mesh, by.metric[e.index], element.weight);
  if (by.gradient.empty()) {
    assign_product(F, G.transpose(), stress_times(dn, e.a0));
  } else {
    const auto dG = by.gradient[e.index].template leftCols<2 * Side>();
    Gradient<S> da;
    assign_product(da, dG, U);
    dn += weighted(stress_of(mesh.membrane(), strain_product(e.a0, da)), element.weight);
    const Gradient<S> ds = stress_times(dn, e.a0) + stress_times(e.stress, da);
    assign_product(F, G.transpose(), ds);
    add_part(dG.transpose(), stress_times(e.stress, e.a0));
  }
  add_part(by.bending[e.index].template topLeftCorner<2 * Side, 2 * Side>(), U);
  if (!by.curvature_weight.empty())
    add_curvature(element.curvature,
                  0.5 * curvature_product(by.curvature_weight[e.index], e.natural, e.natural));
  if (!by.curvature.empty()) {
    add_curvature(element.curvature, curvature_product(element.curvature_weight, e.natural,
                                                       curvature_field(by.curvature[e.index], U)));
    add_curvature(by.curvature[e.index], bent);
  }
  return F;
}

}  // namespace

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
      n0_[k] = weighted(stress_of(mesh_->membrane(), e), element.weight);
      const auto add = [&](std::vector<Matrix>& to, const Block& F) {
        to[i].template middleRows<Side>(4 * j) += F.template topRows<Side>();
        to[i + 1].template middleRows<Side>(4 * j) += F.template bottomRows<Side>();
      };
      Block F, bending;
      assign_product(F, G.transpose(), stress_times(n0_[k], a0));
      assign_product(bending, element.bending.topLeftCorner<2 * Side, 2 * Side>(), U);
      F += bending;
      Matrix bent;
      if (element.curvature_weight.size() > 0) {
        const Matrix& field = natural_[k] = curvature_field(element.curvature, U);
        bent = 0.5 * curvature_product(element.curvature_weight, field, field);
        F += curvature_force(element.curvature, 2 * Side, bent);
      }
      add(nodal_force_, F);
      const DeflectedElement<S> deflected{k, element, a0, e, n0_[k], natural_[k]};
      for (int p = 0; p < directions(); ++p)
        add(shape_force_[p], force_rate<Side>(*mesh_, rate_->shape[p], deflected, U, bent));
    }
}

template <class S>
void PlateGradient<S>::add_to_rows(int line, const Matrix& nodal, Matrix& rows) const {
  const int n = mesh_->functions_per_line(), columns = static_cast<int>(rows.cols());
  const int e = edge_at(line), first = plate_->block_offset(line);
  if (plate_->is_second_of_fold(line)) return add_fold_rows(nodal, rows);
  if (e < 0) {
    rows.middleRows(first, 3 * n) += nodal.reshaped(3 * n, columns);
    return;
  }
  const int body = rows_.body(e);
  for (int k = 0; k < columns; ++k)
    for (int s = 0; s < n; ++s) {
      const Vector3<S> f = nodal.template block<1, 3>(s, 3 * k).transpose();
      if (s % 4 == 0) rows.template block<3, 1>(body, k) += f;
      rows.template block<3, 1>(body + 3, k) += edges_[e].arm[s].cross(f);
      mesh_->each_slope(s, [&](int axis, int unknown) {
        rows(first + unknown, k) += edges_[e].axes.col(axis).dot(f);
      });
    }
}

// Derivatives N0′ of the edges' nodes: functions × (3 components of each variation).
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
            local += held(e, s) * v.shape[p] *
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
  if (e < 0) {
    Matrix N = Matrix(Y.middleRows(first, 3 * n)).reshaped(n, 3 * columns);
    if (plate_->is_second_of_fold(line)) set_fold_rates(Y, N);
    return N;
  }
  const int body = rows_.body(e);
  Matrix N(n, 3 * columns);
  for (int k = 0; k < columns; ++k) {
    const Vector3<S> u = Y.template block<3, 1>(body, k), w = Y.template block<3, 1>(body + 3, k);
    for (int s = 0; s < n; ++s) {
      Vector3<S> r = w.cross(edges_[e].arm[s]);
      if (s % 4 == 0) r += u;
      mesh_->each_slope(
          s, [&](int axis, int unknown) { r += Y(first + unknown, k) * edges_[e].axes.col(axis); });
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
    const Matrix fold = fold_nodal_rates(variations);
    std::vector<Matrix> rates;
    for (int i = 0; i < mesh_->lines(); ++i) {
      rates.push_back(line_rates(i, rows));
      if (const int e = edge_at(i); e >= 0) rates.back() += edges[e];
      if (plate_->is_second_of_fold(i)) rates.back() += fold;
    }
    std::vector<ShapeRate> shapes;
    for (const LeafVariation<S>& v : variations) shapes.push_back(rate_->along(v.shape));
    return std::make_unique<PlateFields>(*mesh_, state_.nodal, std::move(rates), std::move(shapes));
  } else {
    return nullptr;
  }
}

template <class S>
template <int Side>
void PlateGradient<S>::add_tangent_times(const std::array<Matrix, 2>& edges, const Matrix& fold,
                                         std::vector<Matrix>& force) const {
  const int nx = mesh_->elements_along(), ny = mesh_->elements_across();
  const Eigen::Index columns = fold.cols();
  using PointBlock = Eigen::Matrix<S, 16, Eigen::Dynamic>;
  Eigen::Matrix<S, 2 * Side, Eigen::Dynamic> f, bent;
  const Matrix zero = Matrix::Zero(fold.rows(), columns);
  for (int i = 0; i < nx; ++i) {
    const bool behind = plate_->is_second_of_fold(i);
    if (edge_at(i) < 0 && edge_at(i + 1) < 0 && !behind) continue;
    const Matrix &low = behind            ? fold
                        : edge_at(i) >= 0 ? edges[edge_at(i)]
                                          : zero,
                 &high = edge_at(i + 1) >= 0 ? edges[edge_at(i + 1)] : zero;
    for (int j = 0; j < ny; ++j) {
      const int e = i * ny + j;
      const PlateMesh::Element& element = mesh_->element(i, j);
      const auto G = element.gradient.leftCols<2 * Side>();
      const auto U = gather<Side>(low, high, j);
      PointBlock a, s(16, columns);
      assign_product(a, G, U);
      for (Eigen::Index k = 0; k < columns; k += 3) {
        const auto a1 = a.template middleCols<3>(k);
        const Stress<S> dn =
            weighted(stress_of(mesh_->membrane(), strain_product(a0_[e], a1)), element.weight);
        s.template middleCols<3>(k) = stress_times(dn, a0_[e]) + stress_times(n0_[e], a1);
      }
      assign_product(f, G.transpose(), s);
      assign_product(bent, element.bending.topLeftCorner<2 * Side, 2 * Side>(), U);
      f += bent;
      if (element.curvature_weight.size() > 0) {
        const auto field = curvature_field(element.curvature, U);
        for (Eigen::Index k = 0; k < columns; k += 3)
          f.template middleCols<3>(k) +=
              curvature_force(element.curvature, 2 * Side,
                              curvature_product(element.curvature_weight, natural_[e],
                                                field.template middleCols<3>(k)));
      }
      force[i].template middleRows<Side>(4 * j) += f.template topRows<Side>();
      force[i + 1].template middleRows<Side>(4 * j) += f.template bottomRows<Side>();
    }
  }
}

// The axes and arms of an edge turn and grow.
template <class S>
void PlateGradient<S>::add_edge_force_rates(int e, const Matrix& edge_rates,
                                            const std::vector<LeafVariation<S>>& variations,
                                            Matrix& rows) const {
  const int line = edges_[e].line;
  for (int k = 0; k < static_cast<int>(variations.size()); ++k)
    for (int s = 0; s < mesh_->functions_per_line(); ++s) {
      const Vector3<S> f = nodal_force_[line].row(s).transpose();
      Vector3<S> dv = edge_rates.template block<1, 3>(s, 3 * k).transpose();
      if (s % 4 == 0) dv -= variations[k].edge[e].position;
      rows.template block<3, 1>(rows_.body(e) + 3, k) += dv.cross(f);
      mesh_->each_slope(s, [&](int axis, int unknown) {
        rows(plate_->block_offset(line) + unknown, k) +=
            variations[k].edge[e].rotation.col(axis).dot(f);
      });
    }
}

template <class S>
auto PlateGradient<S>::force_rates(const std::vector<LeafVariation<S>>& variations) const
    -> Matrix {
  const int n = mesh_->functions_per_line(), nx = mesh_->elements_along(),
            columns = static_cast<int>(variations.size());
  const std::array<Matrix, 2> N = edge_nodal_rates(variations);
  const Matrix fold = fold_nodal_rates(variations);
  std::vector<Matrix> F(nx + 1, Matrix::Zero(n, 3 * columns));
  for (int line = 0; line <= nx; ++line)
    for (int k = 0; k < columns; ++k)
      for (int p = 0; p < directions(); ++p)
        F[line].template middleCols<3>(3 * k) += variations[k].shape[p] * shape_force_[p][line];

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

  mesh_->with_side([&]<int Side>() { this->template add_tangent_times<Side>(N, fold, F); });
  Matrix rows = Matrix::Zero(size(), columns);
  for (int line = 0; line <= nx; ++line) add_to_rows(line, F[line], rows);
  add_point_rates(N, variations, rows);
  add_fold_force_rates(variations, rows);
  for (int e = 0; e < 2; ++e)
    if (rigid_[e]) add_edge_force_rates(e, N[e], variations, rows);
  return rows;
}

template class PlateGradient<double>;
template class PlateGradient<Jet>;

}  // namespace flexopt
