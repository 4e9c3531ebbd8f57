#include "core/reduction/superelement/modal_leaf.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/elements/plate/deformed_plate.hpp"
#include "core/elements/plate/full_model.hpp"
#include "core/elements/plate/plate_stress.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {

ModalLeaf::ModalLeaf(const LeafSpring& leaf, std::shared_ptr<const ModalModel> model, int index)
    : leaf_(leaf),
      index_(index),
      scale_(leaf, model->mesh()->shape().flexure),
      model_(std::move(model)),
      plate_(model_->mesh()),
      edges_(PlateLeaf::undeflected(*model_->mesh()).edges),
      a_(VectorXd::Zero(model_->amplitudes())) {}

void ModalLeaf::move(const EdgePoses& edges, const Vector12d& dq) {
  moved_ = evaluated_;
  if (evaluated_) {
    const Vector6d de = frame_.B * scale_.scaled_increment(dq);
    const int m = model_->amplitudes();
    const VectorXd da = static_ * de - inverse_ * g_.tail(m);
    VectorXd step(6 + m);
    step << de, da;
    dx_ = V_ * step;
    dq_ = edge_map_ * de;
    a_ += da;
    // all of a slaved step may be stretch: a small one then moves the stress by much
    step_size_ = model_->slaved() ? std::sqrt(std::abs(de.dot(H_ * de))) : 0;
  }
  edges_ = {scale_.scaled(edges[0]), scale_.scaled(edges[1])};
  placed_ = evaluated_ = false;
}

bool ModalLeaf::place() {
  if (placed_) return true;
  frame_ = chord_frame(edges_, 1.0);
  if (!frame_.converged) return false;
  PlateLeaf::State state;
  state.edges = chord_edges(frame_.e);
  state.x = model_->unknowns(frame_.e, state.edges, a_);
  if (moved_)
    plate_.step_to(state, dx_, dq_);
  else
    plate_.set_state(state);
  moved_ = false;
  placed_ = true;
  return true;
}

void ModalLeaf::linearise_chart() {
  plate_.linearise();
  const int m = model_->amplitudes(), n = plate_.unknowns();
  const Vector6d& e = frame_.e;
  edge_map_ = chord_edge_map(e);
  const Vector12d& f = plate_.edge_force();
  // x follows e and a directly and, in the interior, through the nodal values of the edges
  const MatrixXd chart = model_->chart_rates(e);
  const MatrixXd& Xb = model_->line_shapes();
  const int u = model_->slopes(), inner = n - 2 * u, n3 = static_cast<int>(Xb.cols()) / 2;
  std::array<MatrixXd, 2> W;  // (slopes, displacement and spin) of an edge by (e, a)
  V_ = chart;
  for (int k = 0; k < 2; ++k) {
    W[k] = MatrixXd::Zero(u + 6, 6 + m);
    W[k].topRows(u) = k == 0 ? chart.topRows(u) : chart.bottomRows(u);
    W[k].bottomLeftCorner<6, 6>() = edge_map_.middleRows<6>(6 * k);
    V_.middleRows(u, inner).noalias() +=
        Xb.middleCols(k * n3, n3) * (plate_.edge_jacobian(k) * W[k]);
  }
  const VectorXd& r = plate_.residual();
  g_ = V_.transpose() * r;
  g_.head<6>() += edge_map_.transpose() * f;
  MatrixXd KV = plate_.tangent_times(V_);
  const MatrixXd coupling = plate_.coupling() * edge_map_;
  KV.leftCols<6>() += coupling;
  H_.noalias() = V_.transpose() * KV;
  H_.topRows<6>() += coupling.transpose() * V_;
  H_.topLeftCorner<6, 6>() += edge_map_.transpose() * plate_.edge_tangent() * edge_map_;
  // second derivatives of the map times the residual
  const VectorXd followed = Xb.transpose() * r.segment(u, inner);
  Vector12d edge_force = f;
  VectorXd whole = r;  // of the chart: the slopes' share of what the interior follows
  for (int k = 0; k < 2; ++k) {
    const MatrixXd C = plate_.edge_curvature(k, followed.segment(k * n3, n3));
    const MatrixXd CW = C.selfadjointView<Eigen::Lower>() * W[k];
    H_.noalias() += W[k].transpose() * CW;
    const VectorXd share = plate_.edge_jacobian(k).transpose() * followed.segment(k * n3, n3);
    edge_force.segment<6>(6 * k) += share.tail<6>();
    (k == 0 ? whole.head(u) : whole.tail(u)) += share.head(u);
  }
  H_.topLeftCorner<6, 6>() += chord_edge_curvature(e, edge_force);
  if (model_->slaved())
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        H_(i, j) += model_->derivatives().col(pair_index(i, j)).dot(whole);
  H_ = (0.5 * (H_ + H_.transpose())).eval();
}

const LeafEvaluation& ModalLeaf::evaluate() {
  if (!place()) {  // edges on top of each other: no step leads on from here
    evaluation_.correction = 1e6;
    return evaluation_;
  }
  linearise_chart();
  const int m = model_->amplitudes();
  Vector6d g = g_.head<6>();
  Matrix6d K = H_.topLeftCorner<6, 6>();
  evaluation_.correction = step_size_;
  evaluation_.negative_pivots = 0;
  inverse_.resize(m, m);
  static_.resize(m, 6);
  if (m > 0) {
    const SymmetricEigen eigen(H_.bottomRightCorner(m, m));
    evaluation_.negative_pivots = static_cast<int>((eigen.eigenvalues().array() < 0).count());
    inverse_ = eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
               eigen.eigenvectors().transpose();
    static_ = -inverse_ * H_.bottomLeftCorner(m, 6);
    g += static_.transpose() * g_.tail(m);
    K += H_.topRightCorner(6, m) * static_;
    evaluation_.correction = std::sqrt(std::abs(g_.tail(m).dot(inverse_ * g_.tail(m))));
  }
  const Vector12d force = frame_.B.transpose() * g;
  const Matrix12d tangent = frame_.B.transpose() * (0.5 * (K + K.transpose())) * frame_.B +
                            geometric_stiffness(frame_, g);
  evaluation_.energy = scale_.energy * plate_.energy();
  evaluation_.force = scale_.global_force(force);
  evaluation_.tangent = scale_.global_tangent(tangent);
  evaluation_.strain = plate_.strain();
  evaluated_ = true;
  return evaluation_;
}

namespace {
struct ModalLeafState final : LeafState {
  EdgePoses edges;
  VectorXd amplitudes;
};
}  // namespace

std::unique_ptr<LeafState> ModalLeaf::save() const {
  auto copy = std::make_unique<ModalLeafState>();
  copy->edges = edges_;
  copy->amplitudes = a_;
  return copy;
}

void ModalLeaf::restore(const LeafState& state) {
  const auto& copy = static_cast<const ModalLeafState&>(state);
  edges_ = copy.edges;
  a_ = copy.amplitudes;
  placed_ = evaluated_ = moved_ = false;
  step_size_ = 0;
}

MatrixXd ModalLeaf::rates() const {
  const int m = model_->amplitudes(), n = plate_.unknowns();
  const Matrix3d Et = frame_.axes.transpose();
  // rates of the unknowns, seen from axes that stand still: the frame's motion, X de + Ψ da
  MatrixXd T = MatrixXd::Zero(n + 12, 12 + m);
  T.topLeftCorner(n, 12) = V_.leftCols<6>() * frame_.B;
  T.topRightCorner(n, m) = V_.rightCols(m);
  for (int k = 0; k < 4; ++k) T.block<3, 3>(n + 3 * k, 3 * k) = Et;
  const PlateMesh& mesh = *model_->mesh();
  const int functions = mesh.functions_per_line();
  for (int i = 1; i + 1 < mesh.lines(); ++i)
    for (int s = 0; s < functions; ++s) {
      const Vector3d v = plate_.nodal()[i].row(s).transpose();
      Eigen::Matrix<double, 3, 12> rigid = -hat(v) * frame_.spin_local;
      if (s % 4 == 0) rigid.leftCols<3>() += Et;
      for (int c = 0; c < 3; ++c)
        T.row(plate_.block_offset(i) + c * functions + s).head<12>() += rigid.row(c);
    }
  return T;
}

LeafDynamics ModalLeaf::dynamics(DynamicsRequest request) {
  if (!evaluated_) evaluate();
  const int m = model_->amplitudes();
  MatrixXd T = rates();
  T.leftCols<12>() += T.rightCols(m) * (static_ * frame_.B);

  // what the amplitudes do beside the edges: eigenvectors of their own stiffness and mass
  const MatrixXd M = plate_.mass(T);
  const int kept = std::min(request.modes, m);
  MatrixXd S = MatrixXd::Zero(12 + m, 12 + kept);
  S.topLeftCorner<12, 12>().setIdentity();
  VectorXd omega2(kept);
  if (kept > 0) {
    const SymmetricEigen eigen(H_.bottomRightCorner(m, m), M.bottomRightCorner(m, m));
    omega2 = eigen.eigenvalues().head(kept);
    S.bottomRightCorner(m, kept) = eigen.eigenvectors().leftCols(kept);
  }
  MatrixXd units = MatrixXd::Zero(12 + kept, 12 + kept);  // scaled → SI
  units.topLeftCorner<12, 12>() = scale_.transformation();
  units.bottomRightCorner(kept, kept).diagonal().setConstant(1 / std::sqrt(scale_.mass));

  LeafDynamics dynamics;
  dynamics.mass = scale_.mass * (units * (S.transpose() * M * S) * units.transpose());
  dynamics.stations = leaf_station_motion(plate_, scale_, T * (S * units.transpose()));
  for (Eigen::Index k = 0; k < dynamics.stations.rows(); k += 3)
    dynamics.stations.middleRows<3>(k) = (frame_.axes * dynamics.stations.middleRows<3>(k)).eval();
  set_modes(dynamics, scale_.energy / scale_.mass * omega2);
  return dynamics;
}

std::vector<MatrixXd> ModalLeaf::nodal() const {
  assert(placed_);
  std::vector<MatrixXd> nodal = plate_.nodal();
  for (MatrixXd& line : nodal) {
    line = (line * frame_.axes.transpose()).eval();
    for (Eigen::Index s = 0; s < line.rows(); s += 4) line.row(s) += edges_[0].position.transpose();
  }
  return nodal;
}

LeafStress ModalLeaf::stress() {
  place();
  return leaf_stress(*model_->mesh(), nodal(), leaf_, scale_, index_);
}

LeafShape ModalLeaf::shape() {
  place();
  return plate_deformed_shape(*model_->mesh(), nodal(), leaf_, scale_);
}

std::unique_ptr<LeafElement> ModalLeaf::full_model(const std::string& reason) {
  if (!evaluated_) evaluate();
  const LeafHold hold{{scale_.global(edges_[0]), scale_.global(edges_[1])}};
  return full_model_in_place(*this, hold, leaf_, model_->mesh(), index_, reason);
}

LeafReport ModalLeaf::report() const {
  return {.model = model_->slaved() ? "quadratic_manifold" : "modal_derivatives",
          .reason = {},
          .check = 0};
}

std::vector<Vector3d> ModalLeaf::material_points(const std::vector<std::array<double, 2>>& places) {
  place();
  return plate_material_points(*model_->mesh(), nodal(), scale_, places);
}

}  // namespace flexopt
