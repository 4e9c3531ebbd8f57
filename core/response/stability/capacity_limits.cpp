#include "core/response/stability/capacity_limits.hpp"

#include <fmt/format.h>

#include <utility>

#include "core/equilibrium/elastic_degree.hpp"
#include "core/equilibrium/elastic_stress.hpp"
#include "core/equilibrium/end_effector_compliance.hpp"
#include "core/response/gradients/moving_places.hpp"

namespace flexopt {
namespace {

// Largest stress of a leaf, with the notch factors of its fillets where it has some.
StressPeak peak_of(System& system, int i, const StressRules& rules) {
  const StressPeak largest = system.leaf(i).stress().largest();
  if (!rules.fillet || !check_fillet(system.mechanism(), *rules.fillet)) return largest;
  return with_fillets(largest, system.leaf(i), system.mechanism(), *rules.fillet);
}

// Derivatives along the directions and the load, with the state that moves along each.
struct Rates {
  std::unique_ptr<MechanismFactor> factor;
  std::unique_ptr<DesignRates<double>> design;
  MatrixXd state;
};

Rates rates_of(System& system, CapacityDirections& directions, const ModelOptions& model) {
  Rates rates;
  rates.factor = std::make_unique<MechanismFactor>(MechanismFactor::of(system).value());
  rates.design = std::make_unique<DesignRates<double>>(
      design_rates(*rates.factor, directions.with_load, model).value());
  return rates;
}

// k = 1/c, c = yᵀK y of the answer y to a unit load.
VectorXd stiffness_rates(const Rates& rates, int support, const BodyLoad* load) {
  const MechanismFactor& factor = *rates.factor;
  const Eigen::Index at =
      6 * static_cast<Eigen::Index>(factor.system().mechanism().end_effector) + support;
  MatrixXd force = MatrixXd::Zero(factor.size(), 1);
  force(at, 0) = 1;
  const MatrixXd y = factor.solve_locked(force);
  VectorXd form = rates.design->quadratic(y, VectorXd::Zero(1), rates.state).row(0).transpose();
  if (load) {  // its size grows on the present arm
    const Vector3d w = y.col(0).segment<3>(6 * static_cast<Eigen::Index>(load->body) + 3);
    const Vector3d arm = factor.system().pose(load->body).rotation * load->arm;
    form[form.size() - 1] += w.dot(arm_stiffness(load->force, arm) * w);
  }
  return form / (y(at, 0) * y(at, 0));
}

}  // namespace

CapacityLimits::CapacityLimits(System& system, const StrokeRequest& request)
    : request_(&request), mechanism_(&system.mechanism()) {
  if (request.capacity.stiffness_share > 0) unloaded_ = support_stiffness(system);
}

std::array<std::optional<double>, 6> CapacityLimits::support_stiffness(const System& system) const {
  std::array<std::optional<double>, 6> stiffness =
      end_effector_compliance(system).support_stiffness();
  for (std::size_t d = 0; d < 6; ++d)
    if (!request_->capacity.supports[d]) stiffness[d].reset();
  return stiffness;
}

double CapacityLimits::beyond(System& system) {
  double largest = -1;
  stress_.reset();
  support_.reset();
  too_far_.clear();
  const auto take = [&](const Material& material, const auto& peak_of_part) {
    const std::optional<double>& stated = request_->capacity.stress;
    const std::optional<double>& strength = stated ? stated : material.yield_strength;
    if (!strength) return;
    const std::optional<StressPeak> peak = peak_of_part();
    if (!peak || peak->value / *strength - 1 <= largest) return;
    largest = peak->value / *strength - 1;
    stress_ = peak;
  };
  for (int i = 0; i < system.leaves(); ++i)
    take(mechanism_->leaves[i].material,
         [&] { return std::optional(peak_of(system, i, request_->stress)); });
  const ElasticBodies& elastic = system.elastic_bodies();
  for (int k = 0; k < elastic.count(); ++k)
    if (elastic.body(k).cells)
      take(elastic.body(k).material, [&] { return ElasticStress(elastic, k).largest(); });
  for (int k = 0; k < elastic.count(); ++k) {
    const double error = degree_error(system, k, geometric_share(elastic, k)),
                 over = error / largest_degree_error - 1;
    if (over <= largest) continue;
    largest = over;
    stress_.reset();
    too_far_ =
        why_not(check_degree(elastic.body(k), std::max(error, largest_degree_error * (1 + 1e-9))));
  }
  if (request_->capacity.stiffness_share == 0) return largest;
  const auto now = support_stiffness(system);
  for (std::size_t d = 0; d < 6; ++d) {
    if (!now[d] || !unloaded_[d]) continue;
    const double over = request_->capacity.stiffness_share * *unloaded_[d] / *now[d] - 1;
    if (over <= largest) continue;
    largest = over;
    stress_.reset();
    too_far_.clear();
    support_ = static_cast<int>(d);
    stiffness_ = *now[d];
  }
  return largest;
}

LoadCapacity CapacityLimits::reached() const {
  LoadCapacity capacity;
  if (stress_) {
    capacity.limit = CapacityLimit::stress;
    capacity.stress = stress_;
    capacity.reason = fmt::format("the stress of {} reaches {:.4g} MPa",
                                  *part_of(*stress_, *mechanism_).name, stress_->value / 1e6);
  } else if (support_) {
    capacity.limit = CapacityLimit::stiffness;
    capacity.support = static_cast<Direction>(*support_);
    capacity.stiffness = stiffness_;
    capacity.reason = fmt::format(
        "the support stiffness {} falls to {:g} of what it is without "
        "the load",
        direction_names[*support_], request_->capacity.stiffness_share);
  } else {
    capacity.reason = too_far_;
  }
  return capacity;
}

UnloadedStiffness CapacityLimits::unloaded(System& system, CapacityDirections& design,
                                           const ModelOptions& model, bool driven) const {
  UnloadedStiffness stiffness;
  if (request_->capacity.stiffness_share == 0) return stiffness;
  Rates rates = rates_of(system, design, model);
  rates.state =
      rates.factor->balance(-rates.design->residual(), driven).topRows(rates.factor->size());
  for (std::size_t d = 0; d < 6; ++d)
    if (unloaded_[d])
      stiffness[d] =
          stiffness_rates(rates, static_cast<int>(d), nullptr).head(rates.state.cols() - 1);
  return stiffness;
}

std::optional<VectorXd> CapacityLimits::gradient(LoadBranch& branch, CapacityDirections& design,
                                                 const ModelOptions& model,
                                                 const MatrixXd& drive_load_rates,
                                                 const UnloadedStiffness& unloaded) const {
  if (!stress_ && !support_) return std::nullopt;
  Rates rates = rates_of(branch.system(), design, model);
  const Eigen::Index count = rates.design->residual().cols() - 1;
  rates.state = moved_states(branch, *rates.factor, rates.design->residual().leftCols(count),
                             drive_load_rates);
  if (stress_) {
    MovingFields fields(*rates.factor, *rates.design, rates.state);
    const VectorXd of = stress_rates(fields, *stress_, *mechanism_, request_->stress.fillet);
    return VectorXd(-of.head(count) / of[count]);
  }
  const BodyLoad named = branch.named();
  const VectorXd of = stiffness_rates(rates, *support_, &named);
  const VectorXd& without = *unloaded[*support_];
  return VectorXd(-(of.head(count) - request_->capacity.stiffness_share * without) / of[count]);
}

}  // namespace flexopt
