#include "core/elements/plate/plate_series.hpp"

#include "core/elements/plate/plate_curvature.hpp"
#include "core/elements/plate/plate_products.hpp"
#include "core/math/small_product.hpp"

namespace flexopt {
namespace {

using plate::strain_product, plate::stress_times;
using Gradient = plate::Gradient<double>;
using Stress = plate::Stress<double>;

// Rows of both lines of element j, `side` functions each, among the nodal values of a component. A
// beam fills the leading 8 of 16 (the others are zero, as are their operators).
Gradient gather(const VectorXd& low, const VectorXd& high, int n, int j, int side) {
  Gradient U = Gradient::Zero();
  for (int c = 0; c < 3; ++c) {
    U.col(c).head(side) = low.segment(c * n + 4 * j, side);
    U.col(c).segment(side, side) = high.segment(c * n + 4 * j, side);
  }
  return U;
}

template <class Low, class High>
void scatter(const Gradient& F, int n, int j, int side, Low&& low, High&& high) {
  for (int c = 0; c < 3; ++c) {
    low.segment(c * n + 4 * j, side) += F.col(c).head(side);
    high.segment(c * n + 4 * j, side) += F.col(c).segment(side, side);
  }
}

// Rates of the nodal forces of an element for rates U of its nodal values, zero from the order
// `moving` on.
template <int orders, class Point>
Series<Gradient> force_rates(const PlateMesh::Membrane& A, const PlateMesh::Element& element,
                             const Point& point, const Series<Gradient>& U, int moving) {
  const bool natural = element.curvature_weight.size() > 0;
  Series<Gradient> da, F, ds;
  Series<Stress> dn;
  Series<MatrixXd> bent;
  if (natural)
    for (MatrixXd& b : bent) b = MatrixXd::Zero(element.curvature.rows(), 3);
  for (int o = 0; o < orders; ++o) {
    dn[o].setZero();
    ds[o].setZero();
    F[o].setZero();
    if (o >= moving) continue;
    assign_small_product(da[o], element.gradient, U[o]);
    assign_small_product(F[o], element.bending, U[o]);
    if (!natural) continue;
    const MatrixXd field = plate::curvature_field(element.curvature, U[o]);
    for (int b = 0; o + b < orders; ++b)
      bent[o + b] += plate::curvature_product(element.curvature_weight, field, point.natural[b]);
  }
  for (int a = 0; a < moving; ++a)
    for (int b = 0; a + b < orders; ++b) dn[a + b] += strain_product(da[a], point.gradient[b]);
  for (int o = 0; o < orders; ++o)
    dn[o] = plate::weighted(plate::stress_of(A, dn[o]), element.weight);
  for (int a = 0; a < orders; ++a)
    for (int b = 0; a + b < orders; ++b) ds[a + b] += stress_times(dn[a], point.gradient[b]);
  for (int a = 0; a < moving; ++a)
    for (int b = 0; a + b < orders; ++b) ds[a + b] += stress_times(point.stress[b], da[a]);
  for (int o = 0; o < orders; ++o) {
    Gradient membrane;
    assign_small_product(membrane, element.gradient.transpose(), ds[o]);
    F[o] += membrane;
    if (natural) F[o] += plate::curvature_force(element.curvature, 16, bent[o]);
  }
  return F;
}

}  // namespace

PlateSeries::PlateSeries(const PlateLeaf& plate)
    : plate_(&plate),
      mesh_(plate.shared_mesh()),
      point_place_(plate.place_ratio() * plate.point_place()) {
  const int n = mesh_->functions_per_line(), lines = mesh_->lines();
  for (int line = 0; line <= lines; ++line) offset_.push_back(plate.block_offset(line));
  rows_.unknowns = offset_.back();
  rows_.point = support().point.empty() ? 0 : 3;
  for (int o = 0; o < 3; ++o) nodal_[o].assign(lines, VectorXd::Zero(3 * n));
  points_.resize(mesh_->elements_along() * mesh_->elements_across());
}

void PlateSeries::expand(const std::array<EdgeBodySeries, 2>& edges, const Series<VectorXd>& x,
                         const PointSeries& point) {
  const int n = mesh_->functions_per_line(), last = mesh_->lines() - 1;
  x_ = x;
  point_ = point;
  for (int i = 0; i <= last; ++i)
    if (plate_->is_rigid_edge(i))
      expand_edge(edge_of(i), edges[edge_of(i)], x);
    else if (map_of(i) == fold)
      expand_fold(x);
    else
      for (int o = 0; o < 3; ++o) nodal_[o][i] = x[o].segment(offset_[i], 3 * n);
  expand_elements();
  for (int i = 0; i <= last; ++i)
    for (int c = 0; c < 3; ++c)
      force_[0][i].segment(c * n, n) -= plate_->weight()[c] * mesh_->mass_moment(i);
  if (mesh_->fold_line() >= 0) expand_fold_curvature(x);
  for (const NodalWeight& w : support().point)
    for (int o = 0; o < 3; ++o)
      for (int c = 0; c < 3; ++c)
        force_[o][w.line][c * n + w.function] -= w.weight * point.force[o][c];
  for (const int line : {0, last})
    if (plate_->is_rigid_edge(line)) expand_edge_curvature(edge_of(line));
}

void PlateSeries::expand_elements() {
  const int n = mesh_->functions_per_line(), nx = mesh_->elements_along(),
            ny = mesh_->elements_across(), side = mesh_->functions_per_side();
  for (int o = 0; o < 3; ++o) force_[o].assign(mesh_->lines(), VectorXd::Zero(3 * n));
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      const PlateMesh::Element& element = mesh_->element(i, j);
      Point& point = points_[i * ny + j];
      Series<Gradient> F;
      Series<Stress> e, &n_ = point.stress;
      for (int o = 0; o < 3; ++o) {
        const Gradient U = gather(nodal_[o][i], nodal_[o][i + 1], n, j, side);
        assign_small_product(point.gradient[o], element.gradient, U);
        assign_small_product(F[o], element.bending, U);
        e[o].setZero();
      }
      add_product(e, point.gradient, point.gradient, strain_product<Gradient, Gradient>);
      e[0].col(0) -= element.metric;
      e[0].col(1) -= 1;
      Series<Gradient> stress;
      for (int o = 0; o < 3; ++o) {
        e[o] *= 0.5;
        n_[o] = plate::weighted(plate::stress_of(mesh_->membrane(), e[o]), element.weight);
        stress[o].setZero();
      }
      add_product(stress, n_, point.gradient, stress_times<double, Gradient>);
      for (int o = 0; o < 3; ++o) {
        Gradient membrane;
        assign_small_product(membrane, element.gradient.transpose(), stress[o]);
        F[o] += membrane;
      }
      if (element.curvature_weight.size() > 0) {
        Series<MatrixXd> product;
        for (int o = 0; o < 3; ++o) {
          point.natural[o] = plate::curvature_field(
              element.curvature, gather(nodal_[o][i], nodal_[o][i + 1], n, j, side));
          product[o] = MatrixXd::Zero(element.curvature.rows(), 3);
        }
        add_product(product, point.natural, point.natural,
                    [&](const MatrixXd& a, const MatrixXd& b) -> MatrixXd {
                      return 0.5 * plate::curvature_product(element.curvature_weight, a, b);
                    });
        for (int o = 0; o < 3; ++o)
          F[o] += plate::curvature_force(element.curvature, 16, product[o]);
      }
      for (int o = 0; o < 3; ++o) scatter(F[o], n, j, side, force_[o][i], force_[o][i + 1]);
    }
}

std::unique_ptr<LeafGradient<Jet>> PlateSeries::gradient(LeafRates& rates,
                                                         const LeafRows& rows) const {
  return std::make_unique<PlateGradient<Jet>>(*plate_, shared_mesh_rate(rates, mesh_), rows,
                                              path());
}

PlateGradientState<Jet> PlateSeries::path() const {
  const int n = mesh_->functions_per_line();
  PlateGradientState<Jet> path{{jets(axes_[0]), jets(axes_[1])},
                               jets(x_),
                               jets(point_.displacement),
                               jets(point_.force),
                               {}};
  for (int i = 0; i < mesh_->lines(); ++i) {
    Series<MatrixXd> line;
    for (int o = 0; o < 3; ++o) line[o] = nodal_[o][i].reshaped(n, 3);
    path.nodal.push_back(jets(line));
  }
  return path;
}

MatrixXd PlateSeries::rates(int line, int order, const MatrixXd& Y) const {
  const int n = mesh_->functions_per_line(), m = offset_[line + 1] - offset_[line];
  if (map_of(line) == fold)
    return J_[fold][order] * Y.middleRows(offset_[line], plate_->fold_unknowns());
  if (!plate_->is_rigid_edge(line))
    return order == 0 ? MatrixXd(Y.middleRows(offset_[line], 3 * n))
                      : MatrixXd(MatrixXd::Zero(3 * n, Y.cols()));
  const int e = edge_of(line);
  MatrixXd R = J_[e][order].leftCols(m) * Y.middleRows(offset_[line], m);
  R.noalias() += J_[e][order].rightCols<6>() * Y.middleRows(rows_.body(e), 6);
  return R;
}

void PlateSeries::add_to_rows(int line, int order, const MatrixXd& F, MatrixXd& Y) const {
  const int n = mesh_->functions_per_line(), m = offset_[line + 1] - offset_[line];
  if (map_of(line) == fold) {
    Y.middleRows(offset_[line], plate_->fold_unknowns()).noalias() +=
        J_[fold][order].transpose() * F;
    return;
  }
  if (!plate_->is_rigid_edge(line)) {
    if (order == 0) Y.middleRows(offset_[line], 3 * n) += F;
    return;
  }
  const int e = edge_of(line);
  Y.middleRows(offset_[line], m).noalias() += J_[e][order].leftCols(m).transpose() * F;
  Y.middleRows(rows_.body(e), 6).noalias() += J_[e][order].rightCols<6>().transpose() * F;
}

Series<VectorXd> PlateSeries::force() const {
  const int n = mesh_->functions_per_line(), lines = mesh_->lines();
  Series<VectorXd> result;
  for (int i = 0; i < 3; ++i) {
    MatrixXd rows = MatrixXd::Zero(size(), 1);
    for (int a = 0; a <= i; ++a)
      for (int line = 0; line < lines; ++line) add_to_rows(line, a, force_[i - a][line], rows);
    result[i] = rows;
    if (rows_.point == 0) continue;
    Vector3d apart = point_.displacement[i];
    if (i == 0) apart += point_place_;
    for (const NodalWeight& w : support().point)
      for (int c = 0; c < 3; ++c) apart[c] -= w.weight * nodal_[i][w.line][c * n + w.function];
    result[i].segment<3>(rows_.unknowns) = apart;
    result[i].segment<3>(rows_.point_body()) = point_.force[i];
  }
  return result;
}

template <int orders>
Series<MatrixXd> PlateSeries::tangent_products(const MatrixXd& Y) const {
  const int n = mesh_->functions_per_line(), nx = mesh_->elements_along(),
            ny = mesh_->elements_across(), side = mesh_->functions_per_side(),
            columns = static_cast<int>(Y.cols());
  Series<Lines> dr, df;
  for (int o = 0; o < orders; ++o)
    for (int i = 0; i <= nx; ++i) {
      dr[o].push_back(rates(i, o, Y));
      df[o].push_back(MatrixXd::Zero(3 * n, columns));
    }
  for (int i = 0; i < nx; ++i) {
    const int moving = map_of(i) >= 0 || map_of(i + 1) >= 0 ? orders : 1;  // orders of dr
    for (int j = 0; j < ny; ++j) {
      for (int k = 0; k < columns; ++k) {
        Series<Gradient> U;
        for (int o = 0; o < moving; ++o)
          U[o] = gather(dr[o][i].col(k), dr[o][i + 1].col(k), n, j, side);
        const Series<Gradient> F = force_rates<orders>(mesh_->membrane(), mesh_->element(i, j),
                                                       points_[i * ny + j], U, moving);
        for (int o = 0; o < orders; ++o)
          scatter(F[o], n, j, side, df[o][i].col(k), df[o][i + 1].col(k));
      }
    }
  }
  Series<MatrixXd> result;
  for (int o = 0; o < orders; ++o) result[o] = MatrixXd::Zero(size(), columns);
  for (const NodalWeight& w : support().point)
    for (int c = 0; c < 3; ++c) {
      df[0][w.line].row(c * n + w.function) -= w.weight * Y.row(rows_.unknowns + c);
      for (int o = 0; o < orders; ++o)
        result[o].row(rows_.unknowns + c) -= w.weight * dr[o][w.line].row(c * n + w.function);
    }
  if (rows_.point > 0) {
    result[0].middleRows(rows_.unknowns, 3) += Y.middleRows(rows_.point_body(), 3);
    result[0].middleRows(rows_.point_body(), 3) += Y.middleRows(rows_.unknowns, 3);
  }
  for (int line = 0; line <= nx; ++line)
    for (int a = 0; a < orders; ++a)
      for (int b = 0; a + b < orders; ++b) add_to_rows(line, a, df[b][line], result[a + b]);
  if (const int line = mesh_->fold_line(); line >= 0)
    for (int o = 0; o < orders; ++o)
      result[o].middleRows(offset_[line], plate_->fold_unknowns()) +=
          H_[fold][o] * Y.middleRows(offset_[line], plate_->fold_unknowns());
  for (int e = 0; e < 2; ++e) {
    const int line = e == 0 ? 0 : nx;
    if (!plate_->is_rigid_edge(line)) continue;
    const int m = offset_[line + 1] - offset_[line];
    MatrixXd Ye(m + 6, columns);
    Ye << Y.middleRows(offset_[line], m), Y.middleRows(rows_.body(e), 6);
    for (int o = 0; o < orders; ++o) {
      const MatrixXd G = H_[e][o] * Ye;
      result[o].middleRows(offset_[line], m) += G.topRows(m);
      result[o].middleRows(rows_.body(e), 6) += G.bottomRows<6>();
    }
  }
  return result;
}

Series<MatrixXd> PlateSeries::tangent_times(const MatrixXd& Y, int orders) const {
  return orders == 1   ? tangent_products<1>(Y)
         : orders == 2 ? tangent_products<2>(Y)
                       : tangent_products<3>(Y);
}

MatrixXd PlateSeries::mass_lines(int line, const Lines& R) const {
  const int n = mesh_->functions_per_line(), columns = 3 * static_cast<int>(R[line].cols());
  const auto flat = [&](int i) {
    return R[i].reshaped(n, columns);
  };  // columns (column, component)
  MatrixXd F = mesh_->mass_diagonal(line) * flat(line);
  if (line > 0) F.noalias() += mesh_->mass_below(line - 1) * flat(line - 1);
  if (line + 1 < mesh_->lines())
    F.noalias() += mesh_->mass_below(line).transpose() * flat(line + 1);
  return F.reshaped(3 * n, columns / 3);
}

Series<MatrixXd> PlateSeries::mass_times(const MatrixXd& Y, int orders) const {
  Series<MatrixXd> result;
  Series<Lines> R;
  for (int o = 0; o < orders; ++o) {
    result[o] = MatrixXd::Zero(size(), Y.cols());
    for (int i = 0; i < mesh_->lines(); ++i) R[o].push_back(rates(i, o, Y));
  }
  for (int b = 0; b < orders; ++b)
    for (int i = 0; i < mesh_->lines(); ++i) {
      const MatrixXd F = mass_lines(i, R[b]);
      for (int a = 0; a + b < orders; ++a) add_to_rows(i, a, F, result[a + b]);
    }
  return result;
}

}  // namespace flexopt
