#include "core/reduction/superelement/condensation.hpp"

#include <algorithm>
#include <cassert>

#include "core/math/block_lanczos.hpp"
#include "core/math/deflated_solve.hpp"
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

template <class S, class Part>
SparseMatrix sparse(const Triplets<S>& triplets, int rows, int columns, const Part& part) {
  Triplets<double> numbers;
  numbers.reserve(triplets.size());
  for (const auto& t : triplets) numbers.emplace_back(t.row(), t.col(), part(t.value()));
  SparseMatrix A(rows, columns);
  A.setFromTriplets(numbers.begin(), numbers.end());
  return A;
}

MatrixXd symmetric(const MatrixXd& A) { return 0.5 * (A + A.transpose()); }

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
  const Operators<double> operators = linear_plate::operators(*mesh_);
  Constraint<double> c = constraint(*mesh_, operators, condensation);
  for (int i = 0; i <= nx; ++i)
    for (int j = 0; j < mesh_->nodes_per_line(); ++j)
      if (in_use(body, *mesh_, i, j))
        for (int d = 0; d < 3; ++d)
          for (int k = 0; k < 4; ++k)
            if (!c.held[dof(i, j, d, k)]) c.release(dof(i, j, d, k));

  const auto number = [](double x) { return x; };
  const Matrices<double> matrices = assemble(body, *mesh_, operators);
  stiffness_ = sparse(matrices.stiffness, dof.count(), dof.count(), number);
  mass_ = sparse(matrices.mass, dof.count(), dof.count(), number);
  free_ = sparse(c.free, dof.count(), c.unknowns, number);
  factor_.compute(SparseMatrix(free_.transpose() * stiffness_ * free_));
  assert(factor_.info() == Eigen::Success);

  // boundary modes Φ = B − F K_ff⁻¹ Fᵀ K B, vibration modes F ψ (15)
  const MatrixXd KB = stiffness_ * c.boundary;
  boundary_ = c.boundary - free_ * factor_.solve(MatrixXd(free_.transpose() * KB));
  kept_ = std::min(condensation.vibration_modes, c.unknowns / 4);
  if (kept_ > 0) {
    free_mass_ = free_.transpose() * mass_ * free_;
    const LowestPairs pairs = lowest_pairs_of_blocks(
        c.unknowns, std::min(kept_ + guard, c.unknowns / 2), 2,
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
  model_.frame_modes = motion_of_middle(*mesh_, operators) * boundary_;
  model_.recovery = boundary_;
}

std::array<SuperelementModel, 3> Condensation::shape_rates() const {
  const PlateMeshRate mesh_rate(*mesh_);
  const Operators<Dual> operators = linear_plate::operators(*mesh_, mesh_rate);
  const Matrices<Dual> matrices = assemble(body_, *mesh_, operators);
  const Constraint<Dual> c = constraint(*mesh_, operators, condensation_);
  const MatrixX<Dual> motion = motion_of_middle(*mesh_, operators);
  const bool wire = mesh_->shape().section == Section::circular;
  const MatrixXd middle = motion.unaryExpr([](const Dual& x) { return x.value(); });

  const Eigen::Index dofs = stiffness_.rows();
  const MatrixXd KPhi = stiffness_ * boundary_, MPhi = mass_ * boundary_,
                 V = free_ * modes_.leftCols(kept_), MV = mass_ * V;
  const VectorXd lambda = omega2_.head(kept_);
  const DeflatedSystem system{[&](const VectorXd& b) -> VectorXd { return factor_.solve(b); },
                              [&](const VectorXd& x) -> VectorXd { return free_mass_ * x; }, modes_,
                              omega2_};
  std::array<SuperelementModel, 3> rates;
  for (int p = 0; p < 3; ++p) {
    // a wire's width is its thickness
    const auto part = [p, wire](const Dual& x) -> double {
      if (!wire || p == PlateMeshRate::poissons_ratio) return x.derivatives()[p];
      return p == PlateMeshRate::width ? 0 : x.derivatives()[0] + x.derivatives()[1];
    };
    const auto part_of = [&](const auto& A) { return MatrixXd(A.unaryExpr(part)); };
    const SparseMatrix dK = sparse(matrices.stiffness, dofs, dofs, part),
                       dM = sparse(matrices.mass, dofs, dofs, part);
    const MatrixXd dB = part_of(c.boundary), dKPhi = dK * boundary_;
    // Φ′ = B′ − F K_ff⁻¹ Fᵀ (K′Φ + K B′), for Fᵀ K Φ = 0
    const MatrixXd dPhi =
        dB - free_ * factor_.solve(MatrixXd(free_.transpose() * (dKPhi + stiffness_ * dB)));
    MatrixXd K = boundary_.transpose() * dKPhi + 2 * symmetric(dB.transpose() * KPhi),
             M = boundary_.transpose() * (dM * boundary_) + 2 * symmetric(dPhi.transpose() * MPhi);
    if (c.penalty.size() > 0) {
      K += part_of(c.penalty);
      M += part_of(c.penalty_mass);
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
    for (const auto& node : c.nodes) rate.nodes.push_back(part_of(node));
    rate.stiffness =
        bordered(K, MatrixXd::Zero(K.rows(), kept_), G - symmetric(H * lambda.asDiagonal()));
    rate.mass = bordered(M, dPhi.transpose() * MV + boundary_.transpose() * (dMV + mass_ * dV),
                         MatrixXd::Zero(kept_, kept_));
    rate.frame_modes = part_of(motion) * boundary_ + middle * dPhi;
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
