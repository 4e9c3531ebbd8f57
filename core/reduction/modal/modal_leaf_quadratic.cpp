// The quadratic forms of a leaf of modal derivatives and what they change by. Equations (M12),
// (M13).
#include "core/reduction/modal/modal_leaf_gradient.hpp"

#include "core/math/dual.hpp"
#include "core/math/rotation.hpp"
#include "core/reduction/frame/chord_path.hpp"
#include "core/reduction/modal/modal_derivatives.hpp"

namespace flexopt {
namespace {

using namespace chord;

using DualVector = Vector3<Dual15>;
using DualMatrix = Matrix3<Dual15>;

}  // namespace

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

// A column of increments, and how the leaf moves along it.
struct ModalLeafGradient::Path : ChordGradient::Column {
  VectorXd a1;
  std::array<VectorXd, 2> x;                      ///< the chart's, first and second derivative
  std::array<std::array<Matrix3d, 3>, 2> R;       ///< of the edges: value, first, second
  std::array<std::array<MatrixXd, 2>, 2> slopes;  ///< edge, order
  std::array<std::array<MatrixXd, 2>, 2> edges;   ///< nodes: order, edge
};

auto ModalLeafGradient::path_along(const VectorXd& y) const -> Path {
  const std::array<Turn<double>, 2> turn{Turn<double>(edge_turn(0) * leaf_->frame().e),
                                         Turn<double>(edge_turn(1) * leaf_->frame().e)};
  Path p{chord_.column(y.tail<12>()), {}, {}, {}, {}, {}};
  p.a1 = y.head(m_);
  p.x = chart(model_->boundary(), model_->derivatives(), model_->fields(), p.e1, p.e2, p.a1);
  for (int a = 0; a < 2; ++a) {
    p.R[a] = rotation_path<double>(turn[a], edge_turn(a) * p.e1, edge_turn(a) * p.e2);
    for (int o = 0; o < 2; ++o) p.slopes[a][o] = slopes(a, p.x[o]);
    p.edges[0][a] = local_[a] * p.R[a][1].transpose() + p.slopes[a][0] * p.R[a][0].transpose();
    p.edges[1][a] = local_[a] * p.R[a][2].transpose() + 2 * p.slopes[a][0] * p.R[a][1].transpose() +
                    p.slopes[a][1] * p.R[a][0].transpose();
  }
  for (int s = 0; s < functions_; s += 4) {
    p.edges[0][1](s, 0) += p.e1[elongation];
    p.edges[1][1](s, 0) += p.e2[elongation];
  }
  return p;
}

// Covectors of what a path is made of, one for each order: of e, e′, e″, the pairs of the slaved
// derivatives, the edges' rotations and the frame's spin.
struct ModalLeafGradient::Covectors {
  std::array<Vector6d, 3> e{Vector6d::Zero(), Vector6d::Zero(), Vector6d::Zero()};
  std::array<Matrix6d, 3> pairs{Matrix6d::Zero(), Matrix6d::Zero(), Matrix6d::Zero()};
  std::array<std::array<Matrix3d, 3>, 2> R;
  Vector3d spin = Vector3d::Zero();
};

// Of the nodes N0, N1, N2 (c) to those of the path; the shape's and the amplitudes' own share.
auto ModalLeafGradient::pulled_back(const std::array<Lines, 3>& c, const Path& p,
                                    Eigen::Ref<Vector3d> shape, VectorXd& amplitudes) const
    -> Covectors {
  const int last = mesh_->lines() - 1, n3 = 3 * functions_;
  Covectors to;
  std::array<MatrixXd, 3> edge;  // n3 × 2
  std::array<VectorXd, 3> v;
  for (int o = 0; o < 3; ++o) {
    edge[o] = followed(c[o]);
    edge[o].col(0) += c[o][0].reshaped();
    edge[o].col(1) += c[o][last].reshaped();
    v[o] = VectorXd::Zero(n_);
    v[o].segment(u_, n_ - 2 * u_) = inner(c[o]);
  }
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
    shape[ShapeParameter::width] += grows.cwiseProduct(w0).sum();
    to.R[a] = {c0.transpose() * local_[a] + c1.transpose() * p.slopes[a][0] +
                   c2.transpose() * p.slopes[a][1],
               c1.transpose() * local_[a] + 2 * c2.transpose() * p.slopes[a][0],
               c2.transpose() * local_[a]};
  }
  for (int o = 0; o < 3; ++o) {
    for (int s = 0; s < functions_; s += 4) to.e[o][elongation] += edge[o](s, 1);
    to.e[o] += model_->boundary().transpose() * v[o];
    if (!model_->slaved()) continue;
    const VectorXd t = model_->derivatives().transpose() * v[o];
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) to.pairs[o](i, j) = t[pair_index(i, j)];
  }
  amplitudes = model_->fields().transpose() * v[0];

  // what the model's own fields change by
  for (int s = 0; s < 3; ++s) {
    const ModalModelRate::Shape& by = rate_->shape[s];
    const auto x = chart(by.boundary, by.theta, by.fields, p.e1, p.e2, p.a1);
    shape[s] += v[0].dot(chart_rates_[s]) + v[1].dot(x[0]) + v[2].dot(x[1]);
    shape[s] += inner(c[0]).dot(follow_rates_[s]);
    for (int o = 0; o < 2; ++o) {
      VectorXd b(2 * n3);
      b << p.edges[o][0].reshaped(), p.edges[o][1].reshaped();
      shape[s] += inner(c[o + 1]).dot(by.follow * b);
    }
  }
  return to;
}

// Along e and what the frame sees of the edges: (e, spin of the base, of the tip, apart).
auto ModalLeafGradient::seen_by_frame(const Covectors& c, const Path& p) const -> Seen {
  Eigen::Matrix<Dual15, 6, 1> at;
  for (int i = 0; i < 6; ++i) at[i] = Dual15::variable(leaf_->frame().e[i], i);
  std::array<DualVector, 2> spins;
  DualVector apart;
  for (int k = 0; k < 3; ++k) {
    spins[0][k] = Dual15::variable(p.spin[0][k], 6 + k);
    spins[1][k] = Dual15::variable(p.spin[1][k], 9 + k);
    apart[k] = Dual15::variable(p.apart[k], 12 + k);
  }
  const auto turned = [](int a, const Eigen::Matrix<Dual15, 6, 1>& by) {
    const double half = a == 0 ? -0.5 : 0.5;
    DualVector theta;
    theta[0] = half * by[twist];
    theta[1] = by[a == 0 ? theta1y : theta2y];
    theta[2] = by[a == 0 ? theta1z : theta2z];
    return theta;
  };
  const std::array<Turn<Dual15>, 2> turns{Turn<Dual15>(turned(0, at)), Turn<Dual15>(turned(1, at))};
  const Dual15 chord = 1.0 + at[elongation];
  const FramePath<Dual15> path = frame_path(turns, chord, spins, apart);
  const std::array<Eigen::Matrix<Dual15, 6, 1>, 3> d{at, path.first.e(), path.second.e()};
  Dual15 sum;
  for (int o = 0; o < 3; ++o)
    for (int i = 0; i < 6; ++i) sum += c.e[o][i] * d[o][i];
  for (int k = 0; k < 3; ++k) sum += c.spin[k] * path.first.spin[k];
  if (model_->slaved())
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) {
        sum += (0.5 * c.pairs[0](i, j)) * (d[0][i] * d[0][j]);
        sum += c.pairs[1](i, j) * (d[0][i] * d[1][j]);
        sum += c.pairs[2](i, j) * (d[1][i] * d[1][j] + d[0][i] * d[2][j]);
      }
  for (int a = 0; a < 2; ++a) {
    const std::array<DualMatrix, 3> R = rotation_path(turns[a], turned(a, d[1]), turned(a, d[2]));
    for (int o = 0; o < 3; ++o)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) sum += c.R[a][o](i, j) * R[o](i, j);
  }
  return Eigen::Map<const Seen>(sum.derivatives.data());
}

// Of a column of increments: along e and what the frame sees, the amplitudes, the base's place.
struct ModalLeafGradient::Pulled {
  Seen seen;
  VectorXd amplitudes;
  Vector3d by_base = Vector3d::Zero();
};

// Of the nodes N1 along the path and the covectors n0, n1 of nodes and N1; adds the column's mass.
auto ModalLeafGradient::pulled_back(const Path& p, const Lines& N1, const Lines& n0,
                                    const Lines& n1, double mu, double& mass,
                                    Eigen::Ref<Vector3d> shape) const -> Pulled {
  const int last = mesh_->lines() - 1;
  const Lines &f = plate_.nodal_force(), &N0 = leaf_->plate().nodal();
  const Vector3d& spin = p.path.first.spin;
  // velocities seen from axes that stand still
  Lines moving, nm;
  for (int i = 0; i <= last; ++i) {
    moving.push_back(N1[i] + N0[i] * hat(spin).transpose());
    for (int s = 0; s < functions_; s += 4) moving[i].row(s) += p.base.transpose();
  }
  add_mass(moving, mu, mass, shape, nm);
  Pulled result;
  Vector3d by_spin = Vector3d::Zero();
  std::array<Lines, 3> c;
  for (int i = 0; i <= last; ++i) {
    c[0].push_back(n0[i]);
    c[1].push_back(n1[i] + nm[i]);
    c[2].push_back(f[i]);
    for (int s = 0; s < functions_; ++s) {
      const Vector3d m = nm[i].row(s).transpose(), place = N0[i].row(s).transpose();
      c[0][i].row(s) += m.cross(spin).transpose();
      by_spin += place.cross(m);
      if (s % 4 == 0) result.by_base += m;
    }
  }
  Covectors back = pulled_back(c, p, shape, result.amplitudes);
  back.spin = by_spin;
  result.seen = seen_by_frame(back, p);
  return result;
}

LeafQuadratic<double> ModalLeafGradient::quadratic(const MatrixXd& Y, const VectorXd& mu) const {
  const int columns = static_cast<int>(Y.cols()), last = mesh_->lines() - 1;
  const MatrixXd T = rows_.edge_rows(Y);
  std::vector<Path> paths;
  const std::size_t count = leaf_->plate().nodal().size();
  Lines N1(count, MatrixXd(functions_, 3 * columns)), N2 = N1;
  for (int k = 0; k < columns; ++k) {
    const Path& p = paths.emplace_back(path_along(T.col(k)));
    const Lines first = lines(p.edges[0], p.x[0], model_->line_shapes()),
                second = lines(p.edges[1], p.x[1], model_->line_shapes());
    for (int i = 0; i <= last; ++i) {
      N1[i].middleCols<3>(3 * k) = first[i];
      N2[i].middleCols<3>(3 * k) = second[i];
    }
  }
  const auto nodal = plate_.nodal_quadratic(N1, N2);
  LeafQuadratic<double> q(size(), columns);
  q.stiffness = nodal.value.stiffness;
  q.shape = nodal.value.shape;
  const auto column_of = [](const Lines& all, int k) {
    Lines own;
    for (const MatrixXd& line : all) own.push_back(line.middleCols<3>(3 * k));
    return own;
  };
  for (int k = 0; k < columns; ++k) {
    const Path& p = paths[static_cast<std::size_t>(k)];
    const Pulled pulled = pulled_back(p, column_of(N1, k), column_of(nodal.n0, k),
                                      column_of(nodal.n1, k), mu[k], q.mass[k], q.shape.col(k));
    q.state.col(k).head(m_) = pulled.amplitudes;
    chord_.add(Y, k, p, pulled.seen, pulled.by_base, q);
  }
  return q;
}

}  // namespace flexopt
