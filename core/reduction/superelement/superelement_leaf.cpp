#include "core/reduction/superelement/superelement_leaf.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "core/math/lanczos.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {

SuperelementLeaf::SuperelementLeaf(const LeafSpring& leaf,
                                   std::shared_ptr<const SuperelementGrid> grid, int index)
    : leaf_(leaf), grid_(std::move(grid)), index_(index), scale_(leaf, grid_->shape().flexure) {
  const int lines = grid_->lines(), k = grid_->nodes_per_line();
  for (int i = 0; i < lines; ++i)
    for (int j = 0; j < k; ++j)
      nodes_.push_back(
          {leaf.origin + leaf.axes * Vector3d(grid_->x(i), grid_->y(j), 0), leaf.axes});
  for (int e = 0; e < grid_->elements(); ++e) elements_.emplace_back(grid_->model(e));
  gather_.resize(grid_->nodes_per_element());
  diagonal_.assign(lines, MatrixXd::Zero(6 * k, 6 * k));
  below_.assign(lines - 1, MatrixXd::Zero(6 * k, 6 * k));
  line_force_.assign(lines, VectorXd::Zero(6 * k));
  for (MatrixXd& J : edge_jacobian_) J = MatrixXd::Identity(6, 6).replicate(k, 1);
  const int inner = lines - (leaf.tip == free_edge ? 1 : 2);
  if (inner > 0) K_.resize(std::vector<int>(inner, 6 * k));
  g_.resize(unknowns());
  coupling_ = MatrixXd::Zero(unknowns(), 12);
  shares_ = point_shares(leaf, *grid_);
  for (const NodeShare& s : shares_) place_ += s.weight * nodes_[node_index(s.node)].position;
}

void SuperelementLeaf::place_edges(const EdgePoses& edges) {
  const int k = grid_->nodes_per_line();
  for (int e = 0; e < (leaf_.tip == free_edge ? 1 : 2); ++e)
    for (int j = 0; j < k; ++j)
      nodes_[(e == 0 ? 0 : grid_->lines() - 1) * k + j] = {
          edges[e].position + edges[e].axes.col(1) * grid_->y(j), edges[e].axes};
}

void SuperelementLeaf::displace_point(const Vector3d& displacement, const Vector3d& du) {
  displacement_ = displacement;
  increment_ = du;
}

void SuperelementLeaf::solve(Eigen::Ref<MatrixXd> b) const {
  if (unknowns() > 0) interior_.solve(K_, b);
}

MatrixXd SuperelementLeaf::static_shapes() const {
  if (unknowns() == 0) return MatrixXd(0, boundary());
  std::vector<int> all(static_cast<std::size_t>(boundary()));
  std::iota(all.begin(), all.end(), 0);
  return interior_.static_shapes(K_, all);
}

MatrixXd SuperelementLeaf::node_rates(int element, const MatrixXd& T) const {
  const int m = grid_->nodes_per_element();
  MatrixXd rates(6 * m, T.cols());
  for (int k = 0; k < m; ++k) {
    const auto [line, node] = grid_->node(element, k);
    if (is_edge(line)) {
      const int e = edge_of(line);
      if (T.rows() == unknowns())
        rates.middleRows<6>(6 * k).setZero();  // the edges are held
      else
        rates.middleRows<6>(6 * k) =
            edge_jacobian_[e].middleRows<6>(6 * node) * T.middleRows<6>(unknowns() + 6 * e);
    } else {
      rates.middleRows<6>(6 * k) = T.middleRows<6>(offset(line) + 6 * node);
    }
  }
  return rates;
}

void SuperelementLeaf::move(const EdgePoses& edges, const Vector12d& dq) {
  Vector3d df = Vector3d::Zero();
  VectorXd T(unknowns() + 12);
  if (unknowns() > 0) T.head(unknowns()) = interior_.step(K_, dq, increment_, df);
  T.tail<12>() = dq;
  point_force_ += df;
  linearised_.resize(elements_.size());
  for (int e = 0; e < grid_->elements(); ++e)
    linearised_[e] = elements_[e].local() + elements_[e].local_rate() * node_rates(e, T);
  for (int i = 1; i < grid_->lines() && !is_edge(i); ++i)
    for (int j = 0; j < grid_->nodes_per_line(); ++j) {
      NodePose& node = nodes_[node_index({i, j})];
      const auto step = T.segment<6>(offset(i) + 6 * j);
      node.position += step.head<3>();
      node.axes = orthonormalised(rotation_exp(step.tail<3>()) * node.axes);
    }
  place_edges(edges);
}

void SuperelementLeaf::evaluate_elements() {
  framed_ = true;
  for (int e = 0; e < grid_->elements() && framed_; ++e) {
    for (std::size_t k = 0; k < gather_.size(); ++k)
      gather_[k] = nodes_[node_index(grid_->node(e, static_cast<int>(k)))];
    framed_ = elements_[e].evaluate(gather_, linearised_.empty() ? nullptr : &linearised_[e]);
  }
  linearised_.clear();
}

void SuperelementLeaf::assemble_lines() {
  for (MatrixXd& D : diagonal_) D.setZero();
  for (MatrixXd& O : below_) O.setZero();
  for (VectorXd& f : line_force_) f.setZero();
  evaluation_.energy = evaluation_.strain = 0;
  const int m = grid_->nodes_per_element();
  for (int e = 0; e < grid_->elements(); ++e) {
    const Superelement& element = elements_[e];
    evaluation_.energy += element.energy();
    evaluation_.strain = std::max(evaluation_.strain, element.strain());
    for (int a = 0; a < m; ++a) {
      const auto [i, p] = grid_->node(e, a);
      line_force_[i].segment<6>(6 * p) += element.force().segment<6>(6 * a);
      for (int b = 0; b < m; ++b) {
        const auto [j, q] = grid_->node(e, b);
        if (j > i) continue;
        (i == j ? diagonal_[i] : below_[j]).block<6, 6>(6 * p, 6 * q) +=
            element.tangent().block<6, 6>(6 * a, 6 * b);
      }
    }
  }
}

void SuperelementLeaf::condense() {
  const int last = grid_->lines() - 1, k = grid_->nodes_per_line();
  for (const NodeShare& s : shares_)
    line_force_[s.node.line].segment<3>(6 * s.node.node) -= s.weight * point_force_;
  for (int i = 1; i <= last && !is_edge(i); ++i) {
    g_.segment(offset(i), 6 * k) = line_force_[i];
    K_.diagonal[i - 1] = diagonal_[i];
    if (i < last && !is_edge(i + 1)) K_.below[i - 1] = below_[i];
  }
  coupling_.setZero();
  edge_tangent_.setZero();
  edge_force_.setZero();
  for (int e = 0; e < 2; ++e) {
    const int line = e == 0 ? 0 : last;
    if (!is_edge(line)) continue;
    MatrixXd& J = edge_jacobian_[e];
    Matrix6d H = Matrix6d::Zero();  // second derivatives of the rigid edge times the forces
    for (int j = 0; j < k; ++j) {
      const Vector3d arm = nodes_[node_index({line, j})].axes.col(1) * grid_->y(j);
      const Vector3d f = line_force_[line].segment<3>(6 * j);
      J.block<3, 3>(6 * j, 3) = -hat(arm);
      H.bottomRightCorner<3, 3>() += arm_curvature(f, arm);
    }
    edge_force_.segment<6>(6 * e) = J.transpose() * line_force_[line];
    edge_tangent_.block<6, 6>(6 * e, 6 * e) = H + J.transpose() * diagonal_[line] * J;
    const int inner = e == 0 ? 1 : last - 1;
    if (is_edge(inner)) continue;
    coupling_.block(offset(inner), 6 * e, 6 * k, 6).noalias() =
        (e == 0 ? below_[0] : MatrixXd(below_[last - 1].transpose())) * J;
  }
  if (last == 1 && is_edge(1)) {
    const Matrix6d O = edge_jacobian_[1].transpose() * below_[0] * edge_jacobian_[0];
    edge_tangent_.bottomLeftCorner<6, 6>() = O;
    edge_tangent_.topRightCorner<6, 6>() = O.transpose();
  }

  evaluation_.negative_pivots = 0;
  evaluation_.force = edge_force_;
  evaluation_.tangent = edge_tangent_;
  evaluation_.correction = 0;
  if (unknowns() == 0) return;
  K_.factorise();
  interior_.condense(K_, g_, coupling_, edge_force_, edge_tangent_, K_.blocks() - 1);
  if (has_point()) hold_point();
  evaluation_.point = interior_.point();
  evaluation_.negative_pivots = interior_.negative_pivots();
  evaluation_.force = interior_.force();
  evaluation_.tangent = interior_.tangent();
  evaluation_.correction = std::sqrt(interior_.correction() / scale_.energy);
}

void SuperelementLeaf::hold_point() {
  CondensedInterior::Point point{.gradient = MatrixXd::Zero(unknowns(), 3),
                                 .edge_gradient = Eigen::Matrix<double, 3, 12>::Zero(),
                                 .missing = place_ + displacement_,
                                 .force = point_force_};
  for (const NodeShare& s : shares_) {
    point.gradient.middleRows<3>(offset(s.node.line) + 6 * s.node.node) +=
        s.weight * Matrix3d::Identity();
    point.missing -= s.weight * nodes_[node_index(s.node)].position;
  }
  interior_.hold(K_, std::move(point));
}

const LeafEvaluation& SuperelementLeaf::evaluate() {
  evaluate_elements();
  if (!framed_) {  // nodes turned against each other: no step leads on from here
    evaluation_.correction = 1e6;
    return evaluation_;
  }
  assemble_lines();
  condense();
  return evaluation_;
}

namespace {
struct SuperelementLeafState final : LeafState {
  std::vector<NodePose> nodes;
  Vector3d displacement, point_force;
};
}  // namespace

std::unique_ptr<LeafState> SuperelementLeaf::save() const {
  auto copy = std::make_unique<SuperelementLeafState>();
  copy->nodes = nodes_;
  copy->displacement = displacement_;
  copy->point_force = point_force_;
  return copy;
}

void SuperelementLeaf::restore(const LeafState& state) {
  const auto& kept = static_cast<const SuperelementLeafState&>(state);
  nodes_ = kept.nodes;
  displacement_ = kept.displacement;
  point_force_ = kept.point_force;
  linearised_.clear();
}

// Unknowns: the inner nodes, then the vibration modes of the superelements, which statics does not
// move.
LeafDynamics SuperelementLeaf::dynamics(DynamicsRequest request) {
  const int nodal = unknowns(), elements = grid_->elements(), m = 6 * grid_->nodes_per_element();
  const int own = static_cast<int>(grid_->model(0).mass.rows()) - m, n = nodal + own * elements;
  std::vector<MatrixXd> masses;
  VectorXd modal(own * elements);
  for (int e = 0; e < elements; ++e) {
    masses.push_back(elements_[e].mass());
    modal.segment(own * e, own) = grid_->model(e).stiffness.diagonal().tail(own);
  }
  const auto solve_all = [&](MatrixXd x) {
    solve(x.topRows(nodal));
    x.bottomRows(own * elements) = modal.cwiseInverse().asDiagonal() * x.bottomRows(own * elements);
    return x;
  };
  // rows of T: unknowns, and the edges where they move
  const auto rates = [&](int e, const MatrixXd& T) {
    MatrixXd nodes(nodal + T.rows() - n, T.cols());
    nodes << T.topRows(nodal), T.bottomRows(T.rows() - n);
    MatrixXd result(m + own, T.cols());
    result << node_rates(e, nodes), T.middleRows(nodal + own * e, own);
    return result;
  };
  const auto mass_times = [&](const MatrixXd& V) {
    MatrixXd result = MatrixXd::Zero(n, V.cols());
    for (int e = 0; e < elements; ++e) {
      const MatrixXd F = masses[e] * rates(e, V);
      for (int k = 0; k < grid_->nodes_per_element(); ++k) {
        const auto [line, node] = grid_->node(e, k);
        if (!is_edge(line)) result.middleRows<6>(offset(line) + 6 * node) += F.middleRows<6>(6 * k);
      }
      result.middleRows(nodal + own * e, own) += F.bottomRows(own);
    }
    return result;
  };
  LowestPairs pairs;
  if (request.modes > 0)  // massless: as coarse grids have them
    pairs = lowest_modes(
        n, {.count = request.modes, .negative = interior_.negative_pivots(), .massless = true},
        solve_all, mass_times);
  // x = static shapes · (edges, point) + Ψ ξ
  const int modes = static_cast<int>(pairs.values.size()), outer = boundary();
  MatrixXd T = MatrixXd::Zero(n + 12, outer + modes);
  T.topLeftCorner(nodal, outer) = static_shapes();
  T.bottomLeftCorner(12, 12).setIdentity();
  if (modes > 0) T.topRightCorner(n, modes) = pairs.vectors;

  LeafDynamics dynamics;
  dynamics.mass = MatrixXd::Zero(outer + modes, outer + modes);
  for (int e = 0; e < elements; ++e) {
    const MatrixXd R = rates(e, T);
    dynamics.mass.noalias() += R.transpose() * (masses[e] * R);
  }
  set_modes(dynamics, pairs.values);
  if (modes > 0 && modes < request.modes)  // there are no others
    dynamics.highest_mode = std::numeric_limits<double>::infinity();
  return dynamics;
}

}  // namespace flexopt
