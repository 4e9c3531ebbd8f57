#include "core/reduction/modal/modal_leaf_gradient.hpp"

#include <cassert>
#include <utility>

#include "core/elements/plate/plate_fields.hpp"
#include "core/math/rotation.hpp"
#include "core/reduction/frame/chord_path.hpp"
#include "core/reduction/modal/modal_derivatives.hpp"

namespace flexopt {

using chord::edge_turn;

namespace {
LeafRows plate_rows(const PlateLeaf& plate) {
  LeafRows rows;
  rows.unknowns = plate.unknowns();
  return rows;
}
}  // namespace

ModalLeafGradient::ModalLeafGradient(const ModalLeaf& leaf,
                                     std::shared_ptr<const ModalModelRate> rate,
                                     const LeafRows& rows)
    : LeafGradient<double>(rows, leaf.plate().mesh().shape().width),
      leaf_(&leaf),
      model_(&leaf.model()),
      mesh_(&leaf.plate().mesh()),
      rate_(std::move(rate)),
      plate_(leaf.plate(), rate_->mesh, plate_rows(leaf.plate()), present_state(leaf.plate())),
      m_(model_->amplitudes()),
      u_(model_->slopes()),
      n_(leaf.plate().unknowns()),
      functions_(mesh_->functions_per_line()) {
  assert(rows.unknowns == m_ && rows.point == 0);
  const PlateLeaf::State& state = leaf.plate().state();
  for (int a = 0; a < 2; ++a) {
    axes_[a] = state.edges[a].axes;
    local_[a] = leaf.plate().nodal()[a == 0 ? 0 : mesh_->lines() - 1];
    for (int s = 0; s < functions_; s += 4) local_[a].row(s) -= state.edges[a].position.transpose();
    local_[a] = (local_[a] * axes_[a]).eval();
  }
  set_shape_rates();
  chord_ = ChordGradient(leaf.frame(), leaf.edges(), rows,
                         {leaf.generalised_force(), leaf.generalised_tangent(), shape_force()});
  force_ = chord_.force();
}

VectorXd ModalLeafGradient::pairs(const MatrixXd& theta, const Vector6d& a,
                                  const Vector6d& b) const {
  VectorXd weight(21);
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i <= j; ++i)
      weight[pair_index(i, j)] = i == j ? a[i] * b[i] : a[i] * b[j] + a[j] * b[i];
  return theta * weight;
}

VectorXd ModalLeafGradient::inner(const Lines& c) const {
  const int n3 = 3 * functions_;
  VectorXd x(n_ - 2 * u_);
  for (int i = 1; i + 1 < mesh_->lines(); ++i) x.segment((i - 1) * n3, n3) = c[i].reshaped();
  return x;
}

MatrixXd ModalLeafGradient::followed(const Lines& c) const {
  return (model_->line_shapes().transpose() * inner(c)).reshaped(3 * functions_, 2);
}

// The edges' nodes functions × 3 by slopes of a field of the unknowns, in the edges' axes.
MatrixXd ModalLeafGradient::slopes(int edge, const VectorXd& x) const {
  MatrixXd w = MatrixXd::Zero(functions_, 3);
  const auto& free = mesh_->edge_slopes();
  const int per_node = static_cast<int>(free.size()), first = edge == 0 ? 0 : n_ - u_;
  for (int j = 0; j < mesh_->nodes_per_line(); ++j)
    for (int d = 0; d < per_node; ++d)
      w(4 * j + free[d].function, free[d].axis) += x[first + per_node * j + d];
  return w;
}

// The other way.
void ModalLeafGradient::add_to_slopes(int edge, const MatrixXd& w, VectorXd& x) const {
  const auto& free = mesh_->edge_slopes();
  const int per_node = static_cast<int>(free.size()), first = edge == 0 ? 0 : n_ - u_;
  for (int j = 0; j < mesh_->nodes_per_line(); ++j)
    for (int d = 0; d < per_node; ++d)
      x[first + per_node * j + d] += w(4 * j + free[d].function, free[d].axis);
}

// Nodes of an edge growing across, per ẏ/y.
MatrixXd ModalLeafGradient::across() const {
  MatrixXd w = MatrixXd::Zero(functions_, 3);
  if (!mesh_->shape().is_beam())
    for (int j = 0; j < mesh_->nodes_per_line(); ++j) w(4 * j, 1) = mesh_->y()[j] / width_;
  return w;
}

// The chart's unknowns along (e1, a1), (e2, 0): its first and second derivative.
std::array<VectorXd, 2> ModalLeafGradient::chart(const MatrixXd& X, const MatrixXd& theta,
                                                 const MatrixXd& fields, const Vector6d& e1,
                                                 const Vector6d& e2, const VectorXd& a1) const {
  const Vector6d& e = leaf_->frame().e;
  std::array<VectorXd, 2> x{X * e1, X * e2};
  if (model_->slaved()) {
    x[0] += pairs(theta, e, e1);
    x[1] += pairs(theta, e, e2) + pairs(theta, e1, e1);
  } else {
    x[0] += fields * a1;
  }
  return x;
}

// The lines' nodes: of the edges as given, of the others by the chart and what follows the edges.
auto ModalLeafGradient::lines(const std::array<MatrixXd, 2>& edges, const VectorXd& x,
                              const MatrixXd& follow) const -> Lines {
  const int n3 = 3 * functions_, last = mesh_->lines() - 1;
  VectorXd b(2 * n3);
  b << edges[0].reshaped(), edges[1].reshaped();
  const VectorXd y = x.segment(u_, n_ - 2 * u_) + follow * b;
  Lines N(static_cast<std::size_t>(last + 1));
  N[0] = edges[0];
  N[last] = edges[1];
  for (int i = 1; i < last; ++i) N[i] = y.segment((i - 1) * n3, n3).reshaped(functions_, 3);
  return N;
}

void ModalLeafGradient::set_shape_rates() {
  const Vector6d& e = leaf_->frame().e;
  const int last = mesh_->lines() - 1, n3 = 3 * functions_;
  VectorXd b(2 * n3);
  b << leaf_->plate().nodal()[0].reshaped(), leaf_->plate().nodal()[last].reshaped();
  const PlateLeaf::State rest = PlateLeaf::undeflected(*mesh_);
  VectorXd b_rest(2 * n3);
  for (int a = 0; a < 2; ++a)
    b_rest.segment(a * n3, n3) =
        PlateLeaf::edge_nodal(*mesh_, a, rest.edges[a], rest.x.data() + (a == 0 ? 0 : n_ - u_))
            .reshaped();
  for (int p = 0; p < 3; ++p) {
    const ModalModelRate::Shape& by = rate_->shape[p];
    VectorXd x = by.rest + by.boundary * e;
    x += model_->slaved() ? VectorXd(0.5 * pairs(by.theta, e, e))
                          : VectorXd(by.fields * leaf_->amplitudes());
    std::array<MatrixXd, 2> edges;
    for (int a = 0; a < 2; ++a) {
      MatrixXd w = slopes(a, x);
      if (p == ShapeParameter::width) w += across();
      edges[a] = w * axes_[a].transpose();
    }
    follow_rates_[p] = by.follow * (b - b_rest) - model_->line_shapes() * by.edges_at_rest;
    VectorXd whole = x;
    whole.segment(u_, n_ - 2 * u_) += follow_rates_[p];
    node_rates_[p] = lines(edges, whole, model_->line_shapes());
    chart_rates_[p] = x;
  }
}

MatrixXd ModalLeafGradient::shape_force() const {
  const Vector6d& e = leaf_->frame().e;
  const Lines& f = plate_.nodal_force();
  const int last = mesh_->lines() - 1, n3 = 3 * functions_;
  // covectors of the nodes to those of (e, a)
  const auto pull_edges = [&](const MatrixXd& c, const std::array<MatrixXd, 2>& w, VectorXd& g) {
    for (int a = 0; a < 2; ++a) {
      const MatrixXd ca = c.col(a).reshaped(functions_, 3), arm = w[a] * axes_[a].transpose();
      Vector3d moment = Vector3d::Zero();
      for (int s = 0; s < functions_; ++s)
        moment += Vector3d(arm.row(s)).cross(Vector3d(ca.row(s)));
      const Eigen::Matrix<double, 3, 6> T = edge_turn(a);
      g.head<6>() += T.transpose() * (rotation_left_tangent(T * e).transpose() * moment);
    }
  };
  const auto slope_force = [&](const MatrixXd& c, VectorXd& v) {
    for (int a = 0; a < 2; ++a) add_to_slopes(a, c.col(a).reshaped(functions_, 3) * axes_[a], v);
  };
  const auto stretch = [&](const MatrixXd& c) {
    double sum = 0;
    for (int s = 0; s < functions_; s += 4) sum += c(s, 1);
    return sum;
  };
  const auto pull_chart = [&](const MatrixXd& X, const MatrixXd& theta, const MatrixXd& fields,
                              const VectorXd& v, VectorXd& g) {
    g.head<6>() += X.transpose() * v;
    if (!model_->slaved()) {
      g.tail(m_) += fields.transpose() * v;
      return;
    }
    const VectorXd t = theta.transpose() * v;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) g[i] += t[pair_index(i, j)] * e[j];
  };
  const auto edge_covector = [&](const Lines& c) {
    MatrixXd all = followed(c);
    all.col(0) += c[0].reshaped();
    all.col(1) += c[last].reshaped();
    return all;
  };
  const auto inner_covector = [&](const Lines& c) {
    VectorXd v = VectorXd::Zero(n_);
    v.segment(u_, n_ - 2 * u_) = inner(c);
    return v;
  };

  // K Ṅ
  Lines N1;
  for (int i = 0; i <= last; ++i) {
    N1.emplace_back(functions_, 9);
    for (int p = 0; p < 3; ++p) N1.back().middleCols<3>(3 * p) = node_rates_[p][i];
  }
  const auto by_nodes = plate_.nodal_quadratic(N1, Lines(N1.size()));
  const MatrixXd f_edges = edge_covector(f);
  VectorXd f_chart = inner_covector(f);
  slope_force(f_edges, f_chart);

  MatrixXd G = MatrixXd::Zero(6 + m_, 3);
  for (int p = 0; p < 3; ++p) {
    const ModalModelRate::Shape& by = rate_->shape[p];
    VectorXd g = VectorXd::Zero(6 + m_);
    Lines c;
    for (int i = 0; i <= last; ++i)
      c.push_back(plate_.shape_force(p)[i] + 0.5 * by_nodes.n1[i].middleCols<3>(3 * p));
    MatrixXd c_edges = edge_covector(c);
    VectorXd v = inner_covector(c);
    const MatrixXd by_follow = (by.follow.transpose() * inner(f)).reshaped(n3, 2);
    c_edges += by_follow;
    slope_force(c_edges, v);
    pull_edges(c_edges, local_, g);
    g[elongation] += stretch(c_edges);
    pull_chart(model_->boundary(), model_->derivatives(), model_->fields(), v, g);
    pull_chart(by.boundary, by.theta, by.fields, f_chart, g);
    std::array<MatrixXd, 2> w;
    for (int a = 0; a < 2; ++a) {
      w[a] = slopes(a, chart_rates_[p]);
      if (p == ShapeParameter::width) w[a] += across();
    }
    pull_edges(f_edges, w, g);
    G.col(p) = g;
  }
  return G;
}

auto ModalLeafGradient::nodal_rates(const VectorXd& y, const LeafVariation<double>& variation) const
    -> Lines {
  const ChordFrame& frame = leaf_->frame();
  const VectorXd T = rows_.edge_rows(y);
  std::array<Vector3d, 2> lever;
  const Vector12d moved = T.tail<12>() + chord_.edge_moves(variation, lever);
  const Vector6d de = frame.B * moved;
  const VectorXd x = chart(model_->boundary(), model_->derivatives(), model_->fields(), de,
                           Vector6d::Zero(), T.head(m_))[0];
  std::array<MatrixXd, 2> edges;
  for (int a = 0; a < 2; ++a) {
    const Eigen::Matrix<double, 3, 6> turn = edge_turn(a);
    const Vector3d spin = rotation_left_tangent(turn * frame.e) * (turn * de);
    edges[a] = local_[a] * (hat(spin) * axes_[a]).transpose() + slopes(a, x) * axes_[a].transpose();
  }
  for (int s = 0; s < functions_; s += 4) edges[1](s, 0) += de[elongation];
  Lines N = lines(edges, x, model_->line_shapes());
  const Matrix3d turning = hat(Vector3d(frame.spin_local * moved));
  for (std::size_t i = 0; i < N.size(); ++i) {
    for (int p = 0; p < 3; ++p) N[i] += variation.shape[p] * node_rates_[p][i];
    N[i] += leaf_->plate().nodal()[i] * turning.transpose();
    N[i] = (N[i] * frame.axes.transpose()).eval();
    for (int s = 0; s < functions_; s += 4) N[i].row(s) += moved.head<3>().transpose();
  }
  return N;
}

std::unique_ptr<LeafFields> ModalLeafGradient::fields(
    const MatrixXd& rows, const std::vector<LeafVariation<double>>& variations) const {
  std::vector<MatrixXd> rates(static_cast<std::size_t>(mesh_->lines()),
                              MatrixXd(functions_, 3 * rows.cols()));
  for (int k = 0; k < rows.cols(); ++k) {
    const Lines N = nodal_rates(rows.col(k), variations[static_cast<std::size_t>(k)]);
    for (std::size_t i = 0; i < N.size(); ++i) rates[i].middleCols<3>(3 * k) = N[i];
  }
  std::vector<ShapeRate> shapes;
  for (const LeafVariation<double>& v : variations) shapes.emplace_back(Vector3d(v.shape));
  return std::make_unique<PlateFields>(*mesh_, leaf_->nodal(), std::move(rates), std::move(shapes));
}

}  // namespace flexopt
