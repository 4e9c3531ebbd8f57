// Checks whether a tube leaf is accurate enough, and replaces it where it is not: (R5) of
// core/reduction/README.md.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/decompositions.hpp"
#include "core/reduction/tube/tube_leaf.hpp"

namespace flexopt {

namespace {
/// Bent state to add for a leaf at sigma, which lies beyond the state `last`.
double state_beyond(double sigma, double last) {
  return sigma > 0 ? std::max(1.1 * sigma, last + least_distance_of_states)
                   : std::min(1.1 * sigma, last - least_distance_of_states);
}
}  // namespace

TubeModel::TubeModel(TubeModel& other, const TubeRange& range, double sigma)
    : shape_(other.shape_),
      mesh_(other.mesh()),
      range_(range),
      directions_(ray_directions(range.ray)) {
  other.pool();
  pool_ = other.pool_;
  const std::vector<double> planned = planned_states();
  const auto above = std::upper_bound(planned.begin(), planned.end(), sigma);
  const bool last = above == planned.end();
  const double from = above == planned.begin() ? state_beyond(sigma, *above) : *std::prev(above),
               to = last ? state_beyond(sigma, planned.back()) : *above;
  // Start from the nearest state of the other model, if it has any.
  leaf().reset();
  if (!other.expansions_.empty())
    other.stand_at(*std::ranges::min_element(
        other.expansions_, {}, [&](const TubeExpansion& e) { return std::abs(e.sigma - from); }));
  if (!add(from)) return;
  const double reached = bend(leaf(), range_.ray, from, to);
  if ((reached - sigma) * (to - from) > 0 && add(reached)) make_potentials();
}

double TubeModel::next_state(double sigma) const {
  const std::vector<double> planned = planned_states();
  const std::vector<TubeNode>& nodes = potential_->nodes();
  const bool up = sigma > nodes.front().sigma;
  const auto above = std::lower_bound(planned.begin(), planned.end(), sigma);
  if (up && above != planned.end()) return *above;
  if (!up && above != planned.begin()) return *std::prev(above);
  return state_beyond(sigma, (up ? nodes.back() : nodes.front()).sigma);
}

std::shared_ptr<TubeModel> TubeModel::successor(int order, const Eigen::Vector2d& ray,
                                                const Vector3d& forces, double sigma) {
  TubeRange range = range_;
  range.order = order;
  range.ray = ray;
  range.force_centre = forces[0];
  range.moment_centre = forces.tail<2>();
  std::erase_if(successors_, [](const auto& m) { return m.expired(); });
  for (const std::weak_ptr<TubeModel>& known : successors_)
    if (auto model = known.lock(); model->range_.order == order && model->range_.ray == ray &&
                                   model->range_.centre() == forces)
      return model;
  const auto model = std::make_shared<TubeModel>(*this, range, sigma);
  if (!model->built()) return nullptr;
  successors_.push_back(model);
  return model;
}

namespace {

/// The tests' unit of a force: a thousandth of the load that buckles the leaf between held edges,
/// or of a moment with such stress at a side.
Vector3d force_unit() {
  constexpr double buckling = 4 * std::numbers::pi * std::numbers::pi, share = 1e-3;
  return share * buckling * Vector3d(1, 1 / 6.0, 1 / 6.0);
}
constexpr double far_units = 10;  ///< from there on a leaf is expanded anew

/// Replaces largest_degree_change for leaves under a dead load, for which the same change comes
/// with larger errors.
constexpr double largest_change_under_load = 0.02;

/// Up to this change of its own stiffness a leaf's series is sound: its last degree bounds what
/// comes next. A leaf that is not sound may change the stiffness of the mechanism by the second
/// bound only, and so may the full leaf in the place of one that is indefinite alone.
constexpr double sound_change = 0.05, largest_change_of_unsound = 0.01;

/// Bound on the change by the highest degree times the square of (axial force off the centre over
/// the buckling load), (R18).
constexpr double largest_next_change = 0.0004;

/// Bound on the change along the ray for leaves under a dead load, (R19).
constexpr double largest_change_along_ray = 0.003;

/// Bounds on the change of the leaf's forces, measured by the nominal stress that they cause,
/// (R21), and of a drive load, (R22).
constexpr double largest_own_change = 0.01, largest_load_change = 0.01;

/// Bounds on what the full leaf between the same edges has of other forces, measured as above, and
/// of another stiffness, (R23).
constexpr double largest_force_gap = 0.001, largest_stiffness_gap = 0.01;

/// What changes of a drive's load and stiffness are relative to at least, of what all leaves add to
/// them without signs.
constexpr double least_share = 0.1;

}  // namespace

double TubeLeaf::axial_offset() const {
  const double buckling = 4 * std::numbers::pi * std::numbers::pi;
  return std::abs(state_.mixed.f[0] - model_->range().force_centre) / buckling;
}

TubeLeaf::HighestDegree TubeLeaf::highest_degree() const {
  MixedState state = state_.mixed;
  const MixedEnergy lower = condense(model_->lower(), response_.frame.e, state);
  return {response_.mixed.gradient - lower.gradient, response_.mixed.hessian - lower.hessian};
}

double TubeLeaf::own_change(const Vector6d& force) const {
  const PlateShape& shape = model_->shape();
  const double w = shape.mean_width(), t = shape.mean_thickness();
  const auto nominal_stress = [&](const Vector6d& g) {
    return std::abs(g[elongation]) + 6 / w * (std::abs(g[theta1z]) + std::abs(g[theta2z])) +
           (6 * (std::abs(g[theta1y]) + std::abs(g[theta2y])) + 3 * std::abs(g[twist])) / t;
  };
  constexpr double slight = 1e-6;  // [rad] of bending: less is rounding
  const double least = 6 / t * 4 * w * slight;
  return nominal_stress(force) / std::max(nominal_stress(response_.mixed.gradient), least);
}

namespace {
/// |L⁻¹ ΔK L⁻ᵀ| with K = L Lᵀ; nothing where K is not positive.
std::optional<double> relative_change(const Matrix6d& change, const Matrix6d& stiffness) {
  const Cholesky cholesky(stiffness);
  if (!cholesky.positive_definite()) return std::nullopt;
  return cholesky.solve_lower(cholesky.solve_lower(change).transpose()).norm();
}

/// √tr((ΔK C)²)
double relative_change(const Matrix12d& change, const Matrix12d& compliance) {
  const Matrix12d X = change * compliance;
  return std::sqrt(std::max(0.0, X.cwiseProduct(X.transpose()).sum()));
}

/// Compliance of the edges with the drives free: that with them held and what the strokes add,
/// stiffnesses of drives that (nearly) vanish replaced by shares of their parts.
Matrix12d compliance_with_free_drives(const EdgeSurroundings& s) {
  constexpr double softest = 1e-5;
  if (s.strokes.cols() == 0) return s.compliance;
  const VectorXd unit = s.drive_stiffness.diagonal()
                            .cwiseAbs()
                            .cwiseMax(least_share * s.parts_of_stiffness)
                            .cwiseMax(1e-300)
                            .cwiseSqrt()
                            .cwiseInverse();
  const SymmetricEigen stiffness(unit.asDiagonal() * s.drive_stiffness * unit.asDiagonal());
  const MatrixXd V = s.strokes * unit.asDiagonal() * stiffness.eigenvectors();
  const VectorXd yields = stiffness.eigenvalues().cwiseAbs().cwiseMax(softest).cwiseInverse();
  return s.compliance + V * yields.asDiagonal() * V.transpose();
}
}  // namespace

TubeLeaf::DegreeChanges TubeLeaf::changes_in(const EdgeSurroundings& surroundings) const {
  return changes_in(surroundings, highest_degree());
}

TubeLeaf::DegreeChanges TubeLeaf::changes_in(const EdgeSurroundings& s,
                                             const HighestDegree& highest) const {
  DegreeChanges changes;
  changes.own = own_change(highest.force);
  const Rows6x12& B = response_.frame.B;
  const Rows6x12 KB = highest.stiffness.lazyProduct(B);
  Matrix12d change = geometric_stiffness(response_.frame, highest.force);
  change.noalias() += B.transpose().lazyProduct(KB);
  change = scale_.global_tangent(change);
  changes.held = relative_change(change, s.compliance);
  changes.free = relative_change(change, compliance_with_free_drives(s));
  constexpr double rounding = 1e-9;  // of leaves at rest
  if (changes.own < rounding) return changes;
  const Vector12d force = scale_.global_force(B.transpose() * highest.force);
  for (Eigen::Index k = 0; k < s.strokes.cols(); ++k) {
    const double load = std::max(std::abs(s.drive_loads[k]), least_share * s.parts_of_load[k]);
    if (load > 0)
      changes.load = std::max(changes.load, std::abs(s.strokes.col(k).dot(force)) / load);
  }
  return changes;
}

double TubeLeaf::change_along_ray(const HighestDegree& highest) const {
  const PlateShape& shape = model_->shape();
  if (shape.is_beam() || shape.curve || !model_->range().under_load()) return 0;
  const Eigen::Vector2d ray = model_->range().ray;
  const Eigen::Matrix2d bending{{4, 2}, {2, 4}};
  const Matrix6d& all = highest.stiffness;
  const Eigen::Matrix2d change{{all(theta1y, theta1y), all(theta1y, theta2y)},
                               {all(theta2y, theta1y), all(theta2y, theta2y)}};
  return std::abs(ray.dot(change * ray)) / (shape.mean_width() * ray.dot(bending * ray));
}

Check TubeLeaf::check_beside_full(const PlateLeaf& plate) const {
  // g' = (B Bᵀ)⁻¹ B q', so that forces and stiffness over q give those over g
  const Rows6x12& B = response_.frame.B;
  const Rows6x12 P = Lu(B * B.transpose()).solve(B);
  const Vector6d force = P * plate.force();
  const Matrix12d K = plate.tangent() - geometric_stiffness(response_.frame, force);
  const double forces = own_change(force - response_.mixed.gradient),
               stiffness = relative_change(P * K * P.transpose() - response_.mixed.hessian,
                                           response_.mixed.hessian)
                               .value_or(0);  // indefinite: forces tell alone
  if (!(forces <= largest_force_gap))
    return Because(
        fmt::format("the full leaf between the same edges has other forces by {:.2g} > {:.2g}",
                    forces, largest_force_gap));
  if (!(stiffness <= largest_stiffness_gap))
    return Because(
        fmt::format("the full leaf between the same edges has another stiffness by {:.2g} > {:.2g}",
                    stiffness, largest_stiffness_gap));
  return {};
}

// A leaf that comes near to buckling between its edges has an indefinite stiffness on its own. Its
// series has a pole at that load, which its last degree need not show: the full leaf is asked.
Check TubeLeaf::check_unsound(const EdgeSurroundings& about) {
  const PlateLeaf& plate = condensed();
  if (plate.negative_pivots() > 0)
    return Because("as a reduced leaf it would buckle between its edges");
  if (!rebuilt_believed_) return rebuilt_believed_;
  const Matrix12d change = scale_.global_tangent(plate.tangent()) - evaluation_.tangent;
  const double held = relative_change(change, about.compliance),
               free = relative_change(change, compliance_with_free_drives(about));
  if (std::max(held, free) <= largest_change_of_unsound) return {};
  return Because(fmt::format(
      "the full leaf at its state changes the stiffness of the mechanism by {:.2g}, drives free by "
      "{:.2g}",
      held, free));
}

TubeLeaf::Doubt TubeLeaf::doubt(const Surroundings& surroundings) {
  const int degree = model_->potential().degree();
  const HighestDegree highest = highest_degree();
  const std::optional<double> alone = relative_change(highest.stiffness, response_.mixed.hessian);
  const bool sound = alone && *alone <= sound_change;
  const double largest = degree == 7                    ? largest_change_of_degree_7
                         : !sound                       ? largest_change_of_unsound
                         : model_->range().under_load() ? largest_change_under_load
                                                        : largest_degree_change;
  const double next = axial_offset() * axial_offset();
  const auto too_large = [&](double change) {
    return change > largest || next * change > largest_next_change;
  };
  const bool doubted_alone = !alone || too_large(*alone);
  const double own = own_change(highest.force);
  if (own > largest_own_change)
    return {fmt::format(
        "its potential has not converged: degree {} changes its forces by {:.2g} > {:.2g}", degree,
        own, largest_own_change)};
  if (alone && !too_large(*alone / least_share)) return {};
  if (const double along_ray = doubted_alone ? change_along_ray(highest) : 0;
      along_ray > largest_change_along_ray)
    return {fmt::format(
        "its potential has not converged: degree {} changes its stiffness against the drive by "
        "{:.2g} > {:.2g} of what it is without load",
        degree, along_ray, largest_change_along_ray)};
  const std::optional<EdgeSurroundings> about = surroundings();
  if (!about) return {"it is not stable, nor is the mechanism"};
  const DegreeChanges changes = changes_in(*about, highest);
  if (const double change = std::max(changes.held, changes.free); too_large(change)) {
    std::string reason = fmt::format(
        "its potential has not converged: degree {} changes the stiffness of the mechanism{} by "
        "{:.2g}",
        degree, change > changes.held ? ", drives free," : "", change);
    return {reason + (change > largest ? fmt::format(" > {:.2g}", largest)
                                       : fmt::format(", what comes next would by {:.2g} > {:.2g}",
                                                     next * change, largest_next_change))};
  }
  if (changes.load > largest_load_change)
    return {fmt::format(
        "its potential has not converged: degree {} changes a drive load by {:.2g} > {:.2g}",
        degree, changes.load, largest_load_change)};
  if (alone) return {};
  return {.reason = why_not(check_unsound(*about)), .better_potential_helps = false};
}

LimitedRange::Refinement TubeLeaf::refine(const Surroundings& surroundings) {
  const TubeLocation& at = response_.location;
  const double sigma = model_->potential().mirrored() ? std::abs(at.sigma) : at.sigma;
  const double slight = 1e-9 * std::abs(sigma);
  if (at.beyond > slight) {
    // an equal leaf may have added a state since: another beside it would be nothing but rounding
    const std::vector<TubeNode>& nodes = model_->potential().nodes();
    if (sigma <= nodes.back().sigma + slight && sigma >= nodes.front().sigma - slight)
      return {.changed = true, .replacement = {}};
    if (std::abs(sigma) < 1.0 && model_->extend(model_->next_state(sigma)))
      return {.changed = true, .replacement = {}};
    return {true, full_model(fmt::format("bends to {:.3g} rad, beyond the tube", sigma))};
  }
  const auto [reason, better_potential_helps] = doubt(surroundings);
  if (reason.empty()) {
    centred_ = 0;
    return {};
  }
  // a series that changes its forces by more than they are says nothing of those to expand about
  if (better_potential_helps && own_change(highest_degree().force) < 1)
    if (std::unique_ptr<TubeLeaf> better = successor(sigma, reason))
      return {true, std::move(better)};
  return {true, full_model(reason)};
}

Eigen::Vector2d TubeLeaf::turned_ray() const {
  constexpr double step = 0.1, far = 0.06;  // of the smaller bending over the larger one
  const Vector6d& e = response_.frame.e;
  const Eigen::Vector2d& before = model_->range().ray;
  Eigen::Vector2d ray(e[theta1y], e[theta2y]);
  const double size = ray.cwiseAbs().maxCoeff();
  if (model_->shape().curve || size < least_distance_of_states) return before;
  ray /= ray[0] < 0 ? -size : size;
  if ((ray - before).norm() <= far) return before;
  return step * (ray / step).array().round().matrix();
}

std::unique_ptr<TubeLeaf> TubeLeaf::successor(double sigma, const std::string& reason) {
  const Eigen::Vector2d ray = turned_ray();
  const bool turned = ray != model_->range().ray;
  if (turned)
    sigma = std::max(std::abs(response_.frame.e[theta1y]), std::abs(response_.frame.e[theta2y]));
  const Vector3d unit = force_unit(), centre = model_->range().centre();
  const Vector3d off = (state_.mixed.f - centre).cwiseQuotient(unit);
  const bool far = off.cwiseAbs().maxCoeff() >= far_units;
  const int order = model_->range().order;
  Vector3d forces = centre;
  if (far) {
    forces = state_.mixed.f.cwiseQuotient(unit);
    // centred beyond a pull that grows, away from the buckling load, the expansion serves longer
    constexpr double ahead = 0.5;
    if (centred_ == 0 && off[0] >= far_units) forces[0] += ahead * off[0];
    forces = forces.array().round().matrix().cwiseProduct(unit).eval();
  }
  std::shared_ptr<TubeModel> model;
  if ((far || turned) && centred_ < most_centred)
    model = model_->successor(order, ray, forces, sigma);
  const bool anew = model != nullptr;
  if (!model && order == 2) model = model_->successor(3, ray, forces, sigma);
  if (!model) return nullptr;
  auto leaf = std::make_unique<TubeLeaf>(leaf_, model, index_, reason);
  leaf->edges_ = edges_;
  leaf->state_ = state_;
  leaf->tables_ = tables_;
  leaf->centred_ = anew ? centred_ + 1 : 0;
  return leaf;
}

std::unique_ptr<LeafElement> TubeLeaf::full_model(const std::string& reason) {
  auto full = std::make_unique<FullLeaf>(leaf_, model_->mesh(), index_, reason);
  full->plate().set_state(rebuilt());
  return full;
}

}  // namespace flexopt
