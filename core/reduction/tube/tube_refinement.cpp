// Where a tube leaf is believed, and what takes its place where it is not: equations (R5), (R5′) of
// core/reduction/README.md.
#include <fmt/format.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/reduction/tube/tube_leaf.hpp"

namespace flexopt {

TubeModel::TubeModel(TubeModel& lower)
    : shape_(lower.shape_),
      mesh_(lower.mesh()),
      range_(lower.range_),
      directions_(lower.directions_) {
  lower.pool();
  pool_ = lower.pool_;
  range_.order = 3;
  std::vector<TubeNode> nodes;
  for (const TubeExpansion& e : lower.expansions_) {
    lower.stand_at(e);
    expansions_.push_back(expand(leaf(), e.sigma, directions_, range_.order));
    nodes.push_back({e.sigma, expansions_.back().W});
  }
  if (lower.dynamics_) dynamics_ = std::make_unique<TubeDynamics>(*lower.dynamics_);
  expected_ = lower.expected_;
  make_potentials(nodes);
}

std::shared_ptr<TubeModel> TubeModel::higher() {
  if (range_.order == 3) return nullptr;
  std::shared_ptr<TubeModel> model = higher_.lock();
  if (!model) {
    cover(range_.sigma_max);
    higher_ = model = std::make_shared<TubeModel>(*this);
  }
  return model;
}

std::shared_ptr<TubeModel> TubeModel::centred(const Vector3d& forces) {
  TubeRange range = range_;
  range.order = 2;
  range.sigma_max = std::max(range.sigma_max, potential_->last_sigma());
  range.force_centre = forces[0];
  range.moment_centre = forces.tail<2>();
  std::erase_if(centred_, [](const auto& m) { return m.expired(); });
  for (const std::weak_ptr<TubeModel>& known : centred_)
    if (auto model = known.lock(); model->range_.centre() == forces) return model;
  pool();
  auto model = std::make_shared<TubeModel>(mesh(), range, pool_);
  if (!model->built()) return nullptr;
  centred_.push_back(model);
  return model;
}

namespace {

/// The tests' unit of a force: a thousandth of the load that buckles the leaf between held edges,
/// or of a moment with such stress at a side.
Vector3d force_unit() {
  constexpr double buckling = 4 * std::numbers::pi * std::numbers::pi, share = 1e-3;
  return share * buckling * Vector3d(1, 1 / 6.0, 1 / 6.0);
}

}  // namespace

Matrix6d TubeLeaf::highest_degree() const {
  MixedState state = state_.mixed;
  return response_.mixed.hessian - condense(model_->lower(), response_.frame.e, state).hessian;
}

std::optional<double> TubeLeaf::degree_change() const {
  const Eigen::LLT<Matrix6d> llt(response_.mixed.hessian);
  if (llt.info() != Eigen::Success) return std::nullopt;
  Matrix6d X = llt.matrixL().solve(highest_degree());
  X = llt.matrixL().solve(X.transpose()).eval();
  return X.norm();
}

double TubeLeaf::degree_change(const Matrix12d& compliance) const {
  const Rows6x12 T = response_.frame.B.lazyProduct(scale_.transformation().transpose());
  const Matrix6d C = scale_.energy * T * compliance * T.transpose(), X = highest_degree() * C;
  return std::sqrt(std::max(0.0, (X * X).trace()));
}

std::string TubeLeaf::doubt(const Compliance& compliance) const {
  const int degree = model_->potential().degree();
  const double largest = degree == 7 ? largest_change_of_degree_7 : largest_degree_change;
  const std::optional<double> alone = degree_change();
  if (alone && *alone <= largest) return {};
  const std::optional<Matrix12d> C = compliance();
  if (!C) return "it is not stable, nor is the mechanism";
  const double held = degree_change(*C);
  if (held <= largest) return {};
  return fmt::format(
      "its potential has not converged: degree {} changes the stiffness of the mechanism by {:.2g} "
      "> {:.2g}",
      degree, held, largest);
}

LeafElement::Refinement TubeLeaf::refine(const Compliance& compliance) {
  const TubeLocation& at = response_.location;
  const double sigma = std::abs(at.sigma);
  if (at.beyond > 1e-9 * sigma) {
    const double further = 1.1 * (model_->potential().mirrored() ? sigma : at.sigma);
    if (sigma < 1.0 && model_->extend(further)) return {.changed = true, .replacement = {}};
    return {true, full_model(fmt::format("bends to {:.3g} rad, beyond the tube", sigma))};
  }
  const std::string reason = doubt(compliance);
  if (reason.empty()) return {};
  const Vector3d forces = state_.mixed.f.cwiseQuotient(force_unit())
                              .array()
                              .round()
                              .matrix()
                              .cwiseProduct(force_unit());
  const double off =
      (forces - model_->range().centre()).cwiseQuotient(force_unit()).cwiseAbs().maxCoeff();
  std::shared_ptr<TubeModel> better;
  const bool again = off >= 10 && centred_ < most_centred;
  if (again) better = model_->centred(forces);
  if (!better) better = model_->higher();
  if (!better) return {true, full_model(reason)};
  auto leaf = std::make_unique<TubeLeaf>(leaf_, better, index_, reason);
  leaf->edges_ = edges_;
  leaf->state_ = state_;
  leaf->centred_ = centred_ + (again ? 1 : 0);
  return {true, std::move(leaf)};
}

std::unique_ptr<LeafElement> TubeLeaf::full_model(const std::string& reason) {
  auto full = std::make_unique<FullLeaf>(leaf_, model_->mesh(), index_, reason);
  full->plate().set_state(rebuilt());
  return full;
}

}  // namespace flexopt
