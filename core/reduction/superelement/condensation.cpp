#include "core/reduction/superelement/condensation.hpp"

#include <algorithm>
#include <cassert>

#include "core/math/deflated_solve.hpp"
#include "core/math/lanczos.hpp"
#include "core/reduction/superelement/linear_plate.hpp"

namespace flexopt {

using namespace linear_plate;

namespace {

// Modes beyond the kept ones: they make the gap behind the kept ones wide.
constexpr int guard = 3;
// Frequencies (squared) nearer than this are one.
constexpr double equal = 1e-9;

bool in_use(const PlateBody& body, const PlateMesh& mesh, int i, int j) {
  for (int p = i - 1; p <= i; ++p)
    for (int q = j - 1; q <= j; ++q)
      if (p >= 0 && q >= 0 && p < mesh.elements_along() && q < mesh.elements_across() &&
          cell_thickness(body, p, q) > 0)
        return true;
  return false;
}

MatrixXd symmetric(const MatrixXd& A) { return 0.5 * (A + A.transpose()); }

// Moves one derivative to another.
void move_rate(Matrices& to, Matrices& from) {
  for (SparseMatrix Matrices::*part : {&Matrices::stiffness, &Matrices::mass}) {
    to.*part += from.*part;
    (from.*part).setZero();
  }
}
void move_rate(Interfaces& to, Interfaces& from) {
  for (MatrixXd Interfaces::*part : {&Interfaces::boundary, &Interfaces::penalty,
                                     &Interfaces::penalty_mass, &Interfaces::middle}) {
    to.*part += from.*part;
    (from.*part).setZero();
  }
  for (std::size_t k = 0; k < to.nodes.size(); ++k) {
    to.nodes[k] += from.nodes[k];
    from.nodes[k].setZero();
  }
}

// [boundary, coupling; couplingᵀ, modal].
MatrixXd bordered(const MatrixXd& boundary, const MatrixXd& coupling, const MatrixXd& modal) {
  const Eigen::Index n = boundary.rows(), k = modal.rows();
  MatrixXd A(n + k, n + k);
  A.topLeftCorner(n, n) = symmetric(boundary);
  A.topRightCorner(n, k) = coupling;
  A.bottomLeftCorner(k, n) = coupling.transpose();
  A.bottomRightCorner(k, k) = symmetric(modal);
  return A;
}

}  // namespace

Condensation::Condensation(const PlateBody& body, const PlateCondensation& condensation,
                           std::shared_ptr<const PlateMesh> mesh)
    : body_(body), condensation_(condensation), mesh_(std::move(mesh)) {
  [[maybe_unused]] const int nx = mesh_->elements_along(), ny = mesh_->elements_across();
  assert(body.cells.size() == 0 || (body.cells.rows() == nx && body.cells.cols() == ny));
  const Dofs dof(*mesh_);
  FreeDofs free(*mesh_);
  const Interfaces c = interfaces(*mesh_, condensation, free);
  for (int i = 0; i <= nx; ++i)
    for (int j = 0; j < mesh_->nodes_per_line(); ++j)
      if (in_use(body, *mesh_, i, j))
        for (int d = 0; d < 3; ++d)
          for (int k = 0; k < 4; ++k)
            if (!free.held[dof(i, j, d, k)]) free.release(dof(i, j, d, k));

  Matrices matrices = assemble(body, *mesh_);
  stiffness_.swap(matrices.stiffness);
  mass_.swap(matrices.mass);
  free_ = SparseMatrix(dof.count(), free.unknowns);
  free_.setFromTriplets(free.free.begin(), free.free.end());
  factor_.compute(SparseMatrix(free_.transpose() * stiffness_ * free_));
  assert(factor_.info() == Eigen::Success);

  // boundary modes Φ = B − F K_ff⁻¹ Fᵀ K B, vibration modes F ψ (R11)
  const MatrixXd KB = stiffness_ * c.boundary;
  boundary_ = c.boundary - free_ * factor_.solve(MatrixXd(free_.transpose() * KB));
  kept_ = std::min(condensation.vibration_modes, free.unknowns / 4);
  modes_.resize(free.unknowns, 0);
  if (kept_ > 0) {
    free_mass_ = free_.transpose() * mass_ * free_;
    const LowestPairs pairs = lowest_pairs(
        free.unknowns, std::min(kept_ + guard, free.unknowns / 2), 2,
        [&](const MatrixXd& X) -> MatrixXd { return factor_.solve(X); },
        [&](const MatrixXd& X) -> MatrixXd { return free_mass_ * X; }, 1e-9);
    assert(pairs.converged);
    omega2_ = pairs.values;
    modes_ = pairs.vectors;
  }
  const MatrixXd V = free_ * modes_.leftCols(kept_);
  for (const Vector3d& node : c.nodes) model_.nodes.push_back(node - 0.5 * Vector3d::UnitX());
  MatrixXd K = boundary_.transpose() * (stiffness_ * boundary_),
           M = boundary_.transpose() * (mass_ * boundary_);
  if (c.penalty.size() > 0) {
    K += c.penalty;
    M += c.penalty_mass;
  }
  model_.stiffness =
      bordered(K, MatrixXd::Zero(K.rows(), kept_), MatrixXd(omega2_.head(kept_).asDiagonal()));
  model_.mass = bordered(M, boundary_.transpose() * (mass_ * V), MatrixXd::Identity(kept_, kept_));
  model_.frame_modes = c.middle * boundary_;
  model_.recovery = boundary_;
}

std::array<SuperelementModel, 3> Condensation::shape_rates() const {
  const PlateMeshRate mesh_rate(*mesh_);
  std::array<Matrices, 3> matrices = assemble_rates(body_, *mesh_, mesh_rate);
  std::array<Interfaces, 3> interface = interface_rates(*mesh_, condensation_, mesh_rate);
  if (mesh_->shape().section == Section::circular) {  // a wire's width is its thickness
    move_rate(matrices[ShapeParameter::thickness], matrices[ShapeParameter::width]);
    move_rate(interface[ShapeParameter::thickness], interface[ShapeParameter::width]);
  }
  FreeDofs held(*mesh_);
  const MatrixXd middle = interfaces(*mesh_, condensation_, held).middle;

  const MatrixXd KPhi = stiffness_ * boundary_, MPhi = mass_ * boundary_,
                 V = free_ * modes_.leftCols(kept_), MV = mass_ * V;
  const VectorXd lambda = omega2_.head(kept_);
  const DeflatedSystem system{[&](const VectorXd& b) -> VectorXd { return factor_.solve(b); },
                              [&](const VectorXd& x) -> VectorXd { return free_mass_ * x; }, modes_,
                              omega2_};
  std::array<SuperelementModel, 3> rates;
  for (int p = 0; p < 3; ++p) {
    const SparseMatrix &dK = matrices[p].stiffness, &dM = matrices[p].mass;
    const Interfaces& c = interface[p];
    const MatrixXd &dB = c.boundary, dKPhi = dK * boundary_;
    // Φ′ = B′ − F K_ff⁻¹ Fᵀ (K′Φ + K B′), for Fᵀ K Φ = 0
    const MatrixXd dPhi =
        dB - free_ * factor_.solve(MatrixXd(free_.transpose() * (dKPhi + stiffness_ * dB)));
    MatrixXd K = boundary_.transpose() * dKPhi + 2 * symmetric(dB.transpose() * KPhi),
             M = boundary_.transpose() * (dM * boundary_) + 2 * symmetric(dPhi.transpose() * MPhi);
    if (c.penalty.size() > 0) {
      K += c.penalty;
      M += c.penalty_mass;
    }
    // ψ′ = −½ Ψ ΨᵀM′Ψ + x, x off the kept modes: (K − ω² M) x = −(K′ − ω² M′) ψ there
    const MatrixXd dKV = dK * V, dMV = dM * V, G = V.transpose() * dKV, H = V.transpose() * dMV;
    MatrixXd dV = -0.5 * V * H;
    for (int i = 0; i < kept_; ++i) {
      const VectorXd b = -(free_.transpose() * (dKV.col(i) - lambda[i] * dMV.col(i)));
      VectorXd x = complement_solve(system, lambda[i], b, 1e-13, 1000).value();
      for (Eigen::Index k = kept_; k < omega2_.size(); ++k)
        if (const double gap = omega2_[k] - lambda[i]; gap > equal * omega2_[k])
          x += modes_.col(k).dot(b) / gap * modes_.col(k);
      dV.col(i) += free_ * x;
    }
    SuperelementModel& rate = rates[p];
    rate.nodes = c.nodes;
    rate.stiffness =
        bordered(K, MatrixXd::Zero(K.rows(), kept_), G - symmetric(H * lambda.asDiagonal()));
    rate.mass = bordered(M, dPhi.transpose() * MV + boundary_.transpose() * (dMV + mass_ * dV),
                         MatrixXd::Zero(kept_, kept_));
    rate.frame_modes = c.middle * boundary_ + middle * dPhi;
    rate.recovery = dPhi;
  }
  return rates;
}

SuperelementModel in_units(const SuperelementModel& model, double length, double energy,
                           double mass) {
  const int n = model.coordinates();
  VectorXd unit = VectorXd::Constant(model.stiffness.rows(), 1 / std::sqrt(mass));
  for (int i = 0; i < n; i += 6) {
    unit.segment<3>(i).setConstant(1 / length);
    unit.segment<3>(i + 3).setOnes();
  }
  SuperelementModel other;
  for (const Vector3d& node : model.nodes) other.nodes.push_back(length * node);
  other.stiffness = energy * unit.asDiagonal() * model.stiffness * unit.asDiagonal();
  other.mass = mass * unit.asDiagonal() * model.mass * unit.asDiagonal();
  other.frame_modes = model.frame_modes * unit.head(n).asDiagonal();
  other.frame_modes.topRows<3>() *= length;
  other.recovery = model.recovery * unit.head(n).asDiagonal();
  return other;
}

}  // namespace flexopt
