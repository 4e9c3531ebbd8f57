#include "core/reduction/modal_leaf_gradient.hpp"

#include <cassert>
#include <unsupported/Eigen/AutoDiff>
#include <utility>

#include "core/math/rotation.hpp"
#include "core/reduction/modal_derivatives.hpp"

namespace flexopt {
namespace {

// Rotation vectors of the edges in the chord frame: θ = T e.
Eigen::Matrix<double, 3, 6> edge_turn(int edge) {
  Eigen::Matrix<double, 3, 6> T = Eigen::Matrix<double, 3, 6>::Zero();
  T(0, twist) = edge == 0 ? -0.5 : 0.5;
  T(1, edge == 0 ? theta1y : theta2y) = T(2, edge == 0 ? theta1z : theta2z) = 1;
  return T;
}

// What the edges' increments are to the chord frame, in its axes: spins of both edges and the
// difference of their displacements.
constexpr int seen = 15;  // e and these
using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, seen, 1>>;
using DualVector = Vector3<Dual>;
using DualMatrix = Matrix3<Dual>;

template <class S>
struct SineFactor {
  S value, slope;
};
// Σ m! (−q)ᵏ/(2k + m)! as sine_series(), and its derivative in q.
template <class S>
SineFactor<S> sine_factor(const S& q, int m) {
  SineFactor<S> f{S(1.0), S(0.0)};
  for (int k = 16; k >= 1; --k) {
    const double c = 1.0 / ((2 * k + m - 1) * (2 * k + m));
    const S slope = -c * (f.value + q * f.slope), value = S(1.0) - c * q * f.value;
    f = {value, slope};
  }
  return f;
}

// A rotation exp(θ): its matrix R, left tangent J, and J⁻¹.
template <class S>
struct Turn {
  Vector3<S> theta;
  Matrix3<S> R, J, inverse;
  SineFactor<S> a, b;

  explicit Turn(const Vector3<S>& t) : theta(t) {
    const S q = t.dot(t);
    const Matrix3<S> W = hat(t), WW = W * W;
    a = sine_factor(q, 2);
    b = sine_factor(q, 3);
    const S sine = sine_factor(q, 1).value, half = S(0.5) * a.value, sixth = S(1.0 / 6) * b.value;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const S one(i == j ? 1.0 : 0.0);
        R(i, j) = one + sine * W(i, j) + half * WW(i, j);
        J(i, j) = one + half * W(i, j) + sixth * WW(i, j);
      }
    const Vector3<S> c0 = J.col(1).cross(J.col(2)), c1 = J.col(2).cross(J.col(0)),
                     c2 = J.col(0).cross(J.col(1));
    const S det = J.col(0).dot(c0);
    for (int j = 0; j < 3; ++j) {
      inverse(0, j) = c0[j] / det;
      inverse(1, j) = c1[j] / det;
      inverse(2, j) = c2[j] / det;
    }
  }
  // (d/dε J(θ + ε t)) t
  Vector3<S> spin_rate(const Vector3<S>& t) const {
    const S dq = S(2.0) * theta.dot(t), da = S(0.5) * a.slope * dq, db = S(1.0 / 6) * b.slope * dq,
            sixth = S(1.0 / 6) * b.value;
    const Vector3<S> v = theta.cross(t), vv = theta.cross(v), tv = t.cross(v);
    Vector3<S> result;
    for (int i = 0; i < 3; ++i) result[i] = da * v[i] + db * vv[i] + sixth * tv[i];
    return result;
  }
};

// Rates of the chord frame and of e for what it sees of the edges.
template <class S>
struct FrameRate {
  Vector3<S> spin;
  std::array<Vector3<S>, 2> theta;
  S stretch;

  Eigen::Matrix<S, 6, 1> e() const {
    Eigen::Matrix<S, 6, 1> rate;
    rate << stretch, theta[0][1], theta[0][2], theta[1][1], theta[1][2], theta[1][0] - theta[0][0];
    return rate;
  }
};
template <class S>
FrameRate<S> frame_rate(const std::array<Turn<S>, 2>& turn, const S& chord,
                        const std::array<Vector3<S>, 2>& spin, const Vector3<S>& apart) {
  FrameRate<S> r;
  r.stretch = apart[0];
  r.spin[1] = -apart[2] / chord;
  r.spin[2] = apart[1] / chord;
  // neither edge rolls more than the other
  S sum(0.0), weight(0.0);
  for (int a = 0; a < 2; ++a) {
    for (int c = 0; c < 3; ++c) sum += turn[a].inverse(0, c) * spin[a][c];
    for (int c = 1; c < 3; ++c) sum -= turn[a].inverse(0, c) * r.spin[c];
    weight += turn[a].inverse(0, 0);
  }
  r.spin[0] = sum / weight;
  for (int a = 0; a < 2; ++a) {
    const Vector3<S> relative = spin[a] - r.spin;
    r.theta[a] = turn[a].inverse * relative;
  }
  return r;
}

// Of increments of the edges: e′ and e″ along them, and the spin of the frame.
template <class S>
struct FramePath {
  FrameRate<S> first, second;
};
template <class S>
FramePath<S> frame_path(const std::array<Turn<S>, 2>& turn, const S& chord,
                        const std::array<Vector3<S>, 2>& spin, const Vector3<S>& apart) {
  FramePath<S> p;
  p.first = frame_rate(turn, chord, spin, apart);
  const Vector3<S>& w = p.first.spin;
  std::array<Vector3<S>, 2> spin2;
  for (int a = 0; a < 2; ++a) spin2[a] = spin[a].cross(w) - turn[a].spin_rate(p.first.theta[a]);
  Vector3<S> apart2 = apart.cross(w);
  apart2[1] -= p.first.stretch * w[2];
  apart2[2] += p.first.stretch * w[1];
  p.second = frame_rate(turn, chord, spin2, apart2);
  return p;
}

template <class S>
std::array<Matrix3<S>, 3> rotation_path(const Turn<S>& turn, const Vector3<S>& first,
                                        const Vector3<S>& second) {
  const Vector3<S> w = turn.J * first, dw = turn.spin_rate(first) + turn.J * second;
  const Matrix3<S> W = hat(w), W2 = hat(dw);
  const Matrix3<S> R1 = W * turn.R;
  const Matrix3<S> R2 = W2 * turn.R + W * R1;
  return {turn.R, R1, R2};
}

}  // namespace

MatrixXd ModalLeafLinear::static_shapes(const std::vector<int>& columns) const {
  return MatrixXd(leaf_->static_shapes() * leaf_->frame().B)(Eigen::all, columns);
}

MatrixXd ModalLeafLinear::mass_times(const MatrixXd& V) const {
  MatrixXd edges_first(V.rows(), V.cols());
  edges_first << V.bottomRows(12), V.topRows(unknowns());
  const MatrixXd f = mass_ * edges_first;
  MatrixXd result(V.rows(), V.cols());
  result << f.bottomRows(unknowns()), f.topRows(12);
  return result;
}

MatrixXd ModalLeafLinear::station_motion(const MatrixXd& V) const {
  return leaf_->station_motion(rates_.leftCols<12>() * V.bottomRows(12) +
                               rates_.rightCols(unknowns()) * V.topRows(unknowns()));
}

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
  VectorXd f(m_ + 12);
  f << leaf.generalised_force().tail(m_),
      leaf.frame().B.transpose() * leaf.generalised_force().head<6>();
  force_ = rows.body_rows(f);
  set_shape_rates();
  set_shape_force();
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
        PlateLeaf::edge_nodal(*mesh_, rest.edges[a], rest.x.data() + (a == 0 ? 0 : n_ - u_))
            .reshaped();
  for (int p = 0; p < 3; ++p) {
    const ModalModelRate::Shape& by = rate_->shape[p];
    VectorXd x = by.rest + by.boundary * e;
    x += model_->slaved() ? VectorXd(0.5 * pairs(by.theta, e, e))
                          : VectorXd(by.fields * leaf_->amplitudes());
    std::array<MatrixXd, 2> edges;
    for (int a = 0; a < 2; ++a) {
      MatrixXd w = slopes(a, x);
      if (p == PlateMeshRate::width) w += across();
      edges[a] = w * axes_[a].transpose();
    }
    follow_rates_[p] = by.follow * (b - b_rest) - model_->line_shapes() * by.edges_at_rest;
    VectorXd whole = x;
    whole.segment(u_, n_ - 2 * u_) += follow_rates_[p];
    node_rates_[p] = lines(edges, whole, model_->line_shapes());
    chart_rates_[p] = x;
  }
}

void ModalLeafGradient::set_shape_force() {
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

  MatrixXd& G = shape_force_ = MatrixXd::Zero(6 + m_, 3);
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
      if (p == PlateMeshRate::width) w[a] += across();
    }
    pull_edges(f_edges, w, g);
    G.col(p) = g;
  }
}

Vector12d ModalLeafGradient::edge_force() const {
  return leaf_->frame().B.transpose() * leaf_->generalised_force().head<6>();
}

// What the edges' force changes by at constant forces of e.
Matrix12d ModalLeafGradient::edge_stiffness(const Vector12d& force) const {
  Matrix12d K = geometric_stiffness(leaf_->frame(), leaf_->generalised_force().head<6>());
  for (int a = 0; a < 2; ++a)  // increments do not commute
    K.block<3, 3>(6 * a + 3, 6 * a + 3) -= 0.5 * hat(Vector3d(force.segment<3>(6 * a + 3)));
  return K;
}

Vector12d ModalLeafGradient::edge_moves(const LeafVariation<double>& v,
                                        std::array<Vector3d, 2>& lever) const {
  Vector12d moved;
  for (int a = 0; a < 2; ++a) {
    const LeafVariation<double>::Edge& edge = v.edge[a];
    const Matrix3d& R = leaf_->edges()[a].axes;
    const Matrix3d spin = edge.rotation * R.transpose();
    lever[a] = edge.rotation * (R.transpose() * rows_.lever[a]) + R * edge.arm;
    moved.segment<3>(6 * a) = edge.position + lever[a];
    moved.segment<3>(6 * a + 3) =
        0.5 * Vector3d(spin(2, 1) - spin(1, 2), spin(0, 2) - spin(2, 0), spin(1, 0) - spin(0, 1));
  }
  return moved;
}

auto ModalLeafGradient::nodal_rates(const VectorXd& y, const LeafVariation<double>& variation) const
    -> Lines {
  const ChordFrame& frame = leaf_->frame();
  const VectorXd T = rows_.edge_rows(y);
  std::array<Vector3d, 2> lever;
  const Vector12d moved = T.tail<12>() + edge_moves(variation, lever);
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
  return std::make_unique<PlateFields>(*mesh_, leaf_->nodal(), std::move(rates),
                                       shapes_of(variations));
}

MatrixXd ModalLeafGradient::force_rates(
    const std::vector<LeafVariation<double>>& variations) const {
  const int columns = static_cast<int>(variations.size());
  const ChordFrame& frame = leaf_->frame();
  const MatrixXd& H = leaf_->generalised_tangent();
  const Vector12d force = edge_force();
  const Matrix12d K = edge_stiffness(force);
  MatrixXd rows = MatrixXd::Zero(size(), columns);
  for (int k = 0; k < columns; ++k) {
    const LeafVariation<double>& v = variations[k];
    std::array<Vector3d, 2> lever;
    const Vector12d moved = edge_moves(v, lever);
    const VectorXd g_rate = H.leftCols<6>() * (frame.B * moved) + shape_force_ * v.shape;
    VectorXd f(m_ + 12);
    f << g_rate.tail(m_), frame.B.transpose() * g_rate.head<6>() + K * moved;
    rows.col(k) = rows_.body_rows(f);
    for (int a = 0; a < 2; ++a)
      rows.block<3, 1>(rows_.body(a) + 3, k) += lever[a].cross(Vector3d(force.segment<3>(6 * a)));
  }
  return rows;
}

// −μ NᵀM N with its derivatives in the nodes and in the shape.
void ModalLeafGradient::add_mass(const Lines& N, double mu, double& mass,
                                 Eigen::Ref<Vector3d> shape, Lines& n) const {
  const int nx = mesh_->elements_along(), ny = mesh_->elements_across(),
            side = mesh_->functions_per_side();
  n.assign(N.size(), MatrixXd::Zero(functions_, 3));
  mass = 0;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      MatrixXd U(2 * side, 3);
      U << N[i].middleRows(4 * j, side), N[i + 1].middleRows(4 * j, side);
      const MatrixXd MU = mesh_->element(i, j).mass.topLeftCorner(2 * side, 2 * side) * U;
      mass += U.cwiseProduct(MU).sum();
      n[i].middleRows(4 * j, side) -= 2 * mu * MU.topRows(side);
      n[i + 1].middleRows(4 * j, side) -= 2 * mu * MU.bottomRows(side);
      for (int p = 0; p < 3; ++p) {
        const PlateMeshRate::Shape& by = rate_->mesh->shape[p];
        if (by.mass.empty()) continue;
        const MatrixXd dMU = by.mass[i * ny + j].topLeftCorner(2 * side, 2 * side) * U;
        shape[p] -= mu * U.cwiseProduct(dMU).sum();
      }
    }
}

LeafQuadratic<double> ModalLeafGradient::quadratic(const MatrixXd& Y, const VectorXd& mu) const {
  const int columns = static_cast<int>(Y.cols()), last = mesh_->lines() - 1, n3 = 3 * functions_;
  const ChordFrame& frame = leaf_->frame();
  const Matrix3d &E = frame.axes, Et = E.transpose();
  const Vector6d& e = frame.e;
  const Lines& f = plate_.nodal_force();
  const Lines& N0 = leaf_->plate().nodal();
  const MatrixXd T = rows_.edge_rows(Y);
  const std::array<Turn<double>, 2> turn{Turn<double>(edge_turn(0) * e),
                                         Turn<double>(edge_turn(1) * e)};
  struct Path {
    FramePath<double> frame;
    std::array<Vector3d, 2> spin;
    Vector3d apart, base;
    Vector6d e1, e2;
    VectorXd a1;
    std::array<VectorXd, 2> x;
    std::array<std::array<Matrix3d, 3>, 2> R;
    std::array<std::array<MatrixXd, 2>, 2> w;  ///< edge, order
    std::array<std::array<MatrixXd, 2>, 2> b;
  };
  std::vector<Path> paths(static_cast<std::size_t>(columns));
  Lines N1, N2;
  for (int i = 0; i <= last; ++i) {
    N1.emplace_back(functions_, 3 * columns);
    N2.emplace_back(functions_, 3 * columns);
  }
  for (int k = 0; k < columns; ++k) {
    Path& p = paths[k];
    const auto y = T.col(k).tail<12>();
    for (int a = 0; a < 2; ++a) p.spin[a] = Et * y.segment<3>(6 * a + 3);
    p.base = Et * y.head<3>();
    p.apart = Et * y.segment<3>(6) - p.base;
    p.frame = frame_path(turn, frame.chord, p.spin, p.apart);
    p.e1 = p.frame.first.e();
    p.e2 = p.frame.second.e();
    p.a1 = T.col(k).head(m_);
    p.x = chart(model_->boundary(), model_->derivatives(), model_->fields(), p.e1, p.e2, p.a1);
    std::array<MatrixXd, 2> first, second;
    for (int a = 0; a < 2; ++a) {
      p.R[a] = rotation_path<double>(turn[a], edge_turn(a) * p.e1, edge_turn(a) * p.e2);
      for (int o = 0; o < 2; ++o) p.w[a][o] = slopes(a, p.x[o]);
      first[a] = local_[a] * p.R[a][1].transpose() + p.w[a][0] * p.R[a][0].transpose();
      second[a] = local_[a] * p.R[a][2].transpose() + 2 * p.w[a][0] * p.R[a][1].transpose() +
                  p.w[a][1] * p.R[a][0].transpose();
      if (a == 0) continue;
      for (int s = 0; s < functions_; s += 4) {
        first[a](s, 0) += p.e1[elongation];
        second[a](s, 0) += p.e2[elongation];
      }
    }
    p.b = {first, second};
    const Lines of_first = lines(first, p.x[0], model_->line_shapes()),
                of_second = lines(second, p.x[1], model_->line_shapes());
    for (int i = 0; i <= last; ++i) {
      N1[i].middleCols<3>(3 * k) = of_first[i];
      N2[i].middleCols<3>(3 * k) = of_second[i];
    }
  }
  const auto nodal = plate_.nodal_quadratic(N1, N2);
  LeafQuadratic<double> q(size(), columns);
  const Vector12d force = edge_force();
  const Matrix12d by_pose =
      edge_stiffness(force).transpose() +
      frame.B.transpose() * leaf_->generalised_tangent().topLeftCorner<6, 6>() * frame.B;
  q.stiffness = nodal.value.stiffness;
  q.shape = nodal.value.shape;

  for (int k = 0; k < columns; ++k) {
    const Path& p = paths[k];
    const Vector3d& spin = p.frame.first.spin;
    // velocities seen from axes that stand still
    Lines moving, nm;
    for (int i = 0; i <= last; ++i) {
      moving.push_back(N1[i].middleCols<3>(3 * k) + N0[i] * hat(spin).transpose());
      for (int s = 0; s < functions_; s += 4) moving[i].row(s) += p.base.transpose();
    }
    add_mass(moving, mu[k], q.mass[k], q.shape.col(k), nm);
    Vector3d by_spin = Vector3d::Zero(), by_base = Vector3d::Zero();
    std::array<Lines, 3> c;
    for (int i = 0; i <= last; ++i) {
      c[0].push_back(nodal.n0[i].middleCols<3>(3 * k));
      c[1].push_back(nodal.n1[i].middleCols<3>(3 * k) + nm[i]);
      c[2].push_back(f[i]);
      for (int s = 0; s < functions_; ++s) {
        const Vector3d m = nm[i].row(s).transpose(), place = N0[i].row(s).transpose();
        c[0][i].row(s) += m.cross(spin).transpose();
        by_spin += place.cross(m);
        if (s % 4 == 0) by_base += m;
      }
    }

    // to the edges' nodes and the chart
    std::array<MatrixXd, 3> edge;  // n3 × 2
    std::array<VectorXd, 3> v;
    for (int o = 0; o < 3; ++o) {
      edge[o] = followed(c[o]);
      edge[o].col(0) += c[o][0].reshaped();
      edge[o].col(1) += c[o][last].reshaped();
      v[o] = VectorXd::Zero(n_);
      v[o].segment(u_, n_ - 2 * u_) = inner(c[o]);
    }
    std::array<std::array<Matrix3d, 3>, 2> C;  // covectors of R, R′, R″
    std::array<Vector6d, 3> g{Vector6d::Zero(), Vector6d::Zero(), Vector6d::Zero()};
    const MatrixXd grows = across();
    for (int a = 0; a < 2; ++a) {
      const MatrixXd c0 = edge[0].col(a).reshaped(functions_, 3),
                     c1 = edge[1].col(a).reshaped(functions_, 3),
                     c2 = edge[2].col(a).reshaped(functions_, 3);
      const auto& R = p.R[a];
      const MatrixXd w0 = c0 * R[0] + c1 * R[1] + c2 * R[2];
      add_to_slopes(a, w0, v[0]);
      add_to_slopes(a, c1 * R[0] + 2 * c2 * R[1], v[1]);
      add_to_slopes(a, c2 * R[0], v[2]);
      q.shape(PlateMeshRate::width, k) += grows.cwiseProduct(w0).sum();
      C[a] = {c0.transpose() * local_[a] + c1.transpose() * p.w[a][0] + c2.transpose() * p.w[a][1],
              c1.transpose() * local_[a] + 2 * c2.transpose() * p.w[a][0],
              c2.transpose() * local_[a]};
      if (a == 1)
        for (int s = 0; s < functions_; s += 4) {
          g[0][elongation] += c0(s, 0);
          g[1][elongation] += c1(s, 0);
          g[2][elongation] += c2(s, 0);
        }
    }
    std::array<Matrix6d, 3> Theta{Matrix6d::Zero(), Matrix6d::Zero(), Matrix6d::Zero()};
    for (int o = 0; o < 3; ++o) {
      g[o] += model_->boundary().transpose() * v[o];
      if (!model_->slaved()) continue;
      const VectorXd t = model_->derivatives().transpose() * v[o];
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) Theta[o](i, j) = t[pair_index(i, j)];
    }
    // what the model's own fields change by
    for (int s = 0; s < 3; ++s) {
      const ModalModelRate::Shape& by = rate_->shape[s];
      const auto x = chart(by.boundary, by.theta, by.fields, p.e1, p.e2, p.a1);
      double& sum = q.shape(s, k);
      sum += v[0].dot(chart_rates_[s]) + v[1].dot(x[0]) + v[2].dot(x[1]);
      sum += inner(c[0]).dot(follow_rates_[s]);
      for (int o = 0; o < 2; ++o) {
        VectorXd b(2 * n3);
        b << p.b[o][0].reshaped(), p.b[o][1].reshaped();
        sum += inner(c[o + 1]).dot(by.follow * b);
      }
    }

    // along e and what the frame sees of the edges
    Eigen::Matrix<Dual, 6, 1> at;
    for (int i = 0; i < 6; ++i) at[i] = Dual(e[i], seen, i);
    std::array<DualVector, 2> spins;
    DualVector apart;
    for (int c3 = 0; c3 < 3; ++c3) {
      spins[0][c3] = Dual(p.spin[0][c3], seen, 6 + c3);
      spins[1][c3] = Dual(p.spin[1][c3], seen, 9 + c3);
      apart[c3] = Dual(p.apart[c3], seen, 12 + c3);
    }
    const auto turned = [](int a, const Eigen::Matrix<Dual, 6, 1>& by) {
      const double half = a == 0 ? -0.5 : 0.5;
      DualVector theta;
      theta[0] = Dual(half * by[twist]);
      theta[1] = by[a == 0 ? theta1y : theta2y];
      theta[2] = by[a == 0 ? theta1z : theta2z];
      return theta;
    };
    const std::array<Turn<Dual>, 2> turns{Turn<Dual>(turned(0, at)), Turn<Dual>(turned(1, at))};
    const Dual chord = Dual(1.0) + at[elongation];
    const FramePath<Dual> path = frame_path(turns, chord, spins, apart);
    const std::array<Eigen::Matrix<Dual, 6, 1>, 3> d{at, path.first.e(), path.second.e()};
    Dual sum(0.0);
    for (int o = 0; o < 3; ++o)
      for (int i = 0; i < 6; ++i) sum += g[o][i] * d[o][i];
    for (int c3 = 0; c3 < 3; ++c3) sum += by_spin[c3] * path.first.spin[c3];
    if (model_->slaved())
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) {
          sum += (0.5 * Theta[0](i, j)) * (d[0][i] * d[0][j]);
          sum += Theta[1](i, j) * (d[0][i] * d[1][j]);
          sum += Theta[2](i, j) * (d[1][i] * d[1][j] + d[0][i] * d[2][j]);
        }
    for (int a = 0; a < 2; ++a) {
      const std::array<DualMatrix, 3> R = rotation_path(turns[a], turned(a, d[1]), turned(a, d[2]));
      for (int o = 0; o < 3; ++o)
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) sum += C[a][o](i, j) * R[o](i, j);
    }
    const Eigen::Matrix<double, seen, 1>& h = sum.derivatives();

    // to the edges and their increments, then to the bodies
    const Vector3d h1 = h.segment<3>(6), h2 = h.segment<3>(9), ha = h.segment<3>(12);
    const Vector3d rolled =
        -(p.spin[0].cross(h1) + p.spin[1].cross(h2) + p.apart.cross(ha) + p.base.cross(by_base));
    Vector12d pose = frame.B.transpose() * h.head<6>() + frame.spin_local.transpose() * rolled;
    // the lever arms turn: F·(w × (w × lever))
    Vector12d turning = Vector12d::Zero();
    for (int a = 0; a < 2; ++a) {
      const Vector3d w = Y.block<3, 1>(rows_.body(a) + 3, k);
      turning.segment<3>(6 * a) = w.cross(w.cross(rows_.lever[a]));
    }
    q.stiffness[k] += force.dot(turning);
    pose += by_pose * turning;
    const Vector6d of_e = frame.B * turning;
    q.shape.col(k) += shape_force_.topRows<6>().transpose() * of_e;
    const std::array<Vector3d, 2> by_displacement{E * (by_base - ha), E * ha},
        by_edge_spin{E * h1, E * h2};
    if (m_ > 0)
      q.state.col(k).head(m_) = model_->fields().transpose() * v[0] +
                                leaf_->generalised_tangent().bottomLeftCorner(m_, 6) * of_e;
    for (int a = 0; a < 2; ++a) {
      LeafQuadratic<double>::Edge& to = q.edge[k][a];
      const Vector3d w = Y.block<3, 1>(rows_.body(a) + 3, k), lever = rows_.lever[a];
      const Matrix3d& R = leaf_->edges()[a].axes;
      const Vector3d moved = pose.segment<3>(6 * a), turned_by = pose.segment<3>(6 * a + 3),
                     fw = Vector3d(force.segment<3>(6 * a)).cross(w),
                     arm = moved + by_displacement[a].cross(w) + fw.cross(w);
      to.position = moved;
      to.arm = R.transpose() * arm;
      to.rotation = arm * (R.transpose() * lever).transpose() + 0.5 * hat(turned_by) * R;
      to.displacement = by_displacement[a];
      to.spin = by_edge_spin[a] + lever.cross(by_displacement[a] + fw) +
                w.cross(lever).cross(Vector3d(force.segment<3>(6 * a)));
      q.state.block<3, 1>(rows_.body(a), k) = moved;
      q.state.block<3, 1>(rows_.body(a) + 3, k) = turned_by + lever.cross(arm);
    }
  }
  return q;
}

}  // namespace flexopt
