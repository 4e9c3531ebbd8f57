
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/response/stress_safety.hpp"

namespace flexopt {
namespace {

double von_mises_square(const Vector3d& s) {
  return s[0] * s[0] - s[0] * s[1] + s[1] * s[1] + 3 * s[2] * s[2];
}

/// Stress: 11, 22, 33, 23, 13, 12.
using Tensor = Vector6d;
double von_mises_square(const Tensor& s) {
  return 0.5 * (std::pow(s[0] - s[1], 2) + std::pow(s[1] - s[2], 2) + std::pow(s[2] - s[0], 2)) +
         3 * s.tail<3>().squaredNorm();
}
EffectiveCycle effective_cycle_of(const Vector3d& one, const Vector3d& other) {
  return effective_cycle(one, other);
}
EffectiveCycle effective_cycle_of(const Tensor& one, const Tensor& other) {
  return {std::sqrt(von_mises_square(Tensor(0.5 * (one - other)))),
          0.5 * (one + other).head<3>().sum()};
}

/// One side of the leaf at a place, or a node of an elastic body. Parts: the leaves, then these.
struct Spot {
  std::size_t part = 0;
  Eigen::Index place = 0;
  bool positive = true;
  NotchFactors notch;
  int end = -1;  ///< the edge with the notch
};

/// A cycle at a spot, between two points of the path.
struct Found {
  double measure = 0;  ///< what is the largest of: use, or reversed amplitude
  Spot spot;
  std::size_t other = 0;
  EffectiveCycle cycle;
};

class History {
 public:
  History(const Mechanism& mechanism, const StressRules& rules, const StrokeResponse& response)
      : mechanism_(mechanism), rules_(rules), response_(response) {
    for (const LeafSpring& leaf : mechanism.leaves)
      factors_.push_back(rules.fillet ? clamp_factors(leaf, *rules.fillet) : ClampFactors{});
  }

  /// The stress of a spot from that of its section.
  static Vector3d on_side(const Spot& spot, const SectionStress& section) {
    const double bending = spot.positive ? spot.notch.bending : -spot.notch.bending;
    return spot.notch.membrane * section.head<3>() + bending * section.tail<3>();
  }

  std::size_t parts() const { return factors_.size() + mechanism_.elastic_bodies.size(); }
  bool is_elastic(std::size_t part) const { return part >= factors_.size(); }
  StressedPart part(std::size_t part) const {
    StressPeak in;
    in.leaf = static_cast<int>(part);
    if (is_elastic(part)) in.elastic_body = static_cast<int>(part - factors_.size());
    return part_of(in, mechanism_);
  }

  /// Calls `take(spot, stresses)` for every spot of a part, with its stress at each point.
  template <class Take>
  void each_spot(std::size_t part, const Take& take) const {
    if (is_elastic(part)) return each_node(part, take);
    const std::vector<StressPlace>& places = response_.stress_places[part];
    std::vector<Vector3d> stresses(response_.path.size());
    for (std::size_t q = 0; q < places.size(); ++q)
      for (const bool positive : {true, false}) {
        Spot spot{part, static_cast<Eigen::Index>(q), positive, {}, -1};
        for (const int end : {0, 1})
          if (const auto& factors = factors_[part][end]; factors && places[q].along == end) {
            spot.notch = *factors;
            spot.end = end;
          }
        for (std::size_t k = 0; k < stresses.size(); ++k)
          stresses[k] = on_side(spot, section(k, spot));
        take(spot, stresses);
      }
  }

  SectionStress section(std::size_t point, const Spot& spot) const {
    return response_.path[point].sections[spot.part].col(spot.place);
  }
  Tensor stress(std::size_t point, const Spot& spot) const {
    if (is_elastic(spot.part)) return section(point, spot);
    const Vector3d plane = on_side(spot, section(point, spot));
    Tensor tensor = Tensor::Zero();
    tensor << plane[0], plane[1], 0, 0, 0, plane[2];
    return tensor;
  }

  FatigueCycle cycle_of(const Found& found, std::size_t point) const {
    const Spot& spot = found.spot;
    const StressPlace& at = response_.stress_places[spot.part][spot.place];
    FatigueCycle cycle;
    cycle.amplitude = found.cycle.amplitude;
    cycle.mean = found.cycle.mean;
    cycle.other = static_cast<int>(found.other);
    StressPeak& peak = cycle.stress;
    if (is_elastic(spot.part)) {
      peak.elastic_body = static_cast<int>(spot.part - factors_.size());
      peak.node = at.node;
    } else {
      peak.leaf = static_cast<int>(spot.part);
    }
    peak.along = at.along;
    peak.across = at.across;
    peak.segment = at.segment;
    peak.on_positive_normal = spot.positive;
    peak.notch = spot.notch;
    for (const std::size_t k : {point, found.other})
      peak.value = std::max(peak.value, std::sqrt(von_mises_square(stress(k, spot))));
    return cycle;
  }

  /// What the stress of a spot at a point changes by: 6 × parameters.
  MatrixXd rates(const Spot& spot, std::size_t point, const std::vector<Mechanism>& directions,
                 const StrokeGradients& gradients) const {
    const auto of = gradients.path[point].section_rates[spot.part].middleRows(6 * spot.place, 6);
    if (is_elastic(spot.part)) return of;
    const double side = spot.positive ? 1 : -1;
    MatrixXd plane =
        spot.notch.membrane * of.topRows<3>() + side * spot.notch.bending * of.bottomRows<3>();
    const SectionStress s = section(point, spot);
    for (Eigen::Index p = 0; spot.end >= 0 && p < plane.cols(); ++p) {
      const NotchFactors moved = clamp_factor_rates(
          mechanism_.leaves[spot.part], directions[p].leaves[spot.part], spot.end, *rules_.fillet);
      plane.col(p) += moved.membrane * s.head<3>() + side * moved.bending * s.tail<3>();
    }
    MatrixXd rates = MatrixXd::Zero(6, plane.cols());
    rates.topRows<2>() = plane.topRows<2>();
    rates.row(5) = plane.row(2);
    return rates;
  }

  /// What amplitude and mean of a cycle change by.
  struct CycleRates {
    VectorXd amplitude, mean;
  };
  CycleRates cycle_rates(const Found& found, std::size_t point,
                         const std::vector<Mechanism>& directions,
                         const StrokeGradients& gradients) const {
    const Spot& spot = found.spot;
    const Tensor half = 0.5 * (stress(point, spot) - stress(found.other, spot));
    const MatrixXd one = rates(spot, point, directions, gradients),
                   other = rates(spot, found.other, directions, gradients);
    Tensor slope = Tensor::Zero();
    if (const double a = found.cycle.amplitude; a > 0) {
      slope.head<3>() = 1.5 / a * (half.head<3>().array() - half.head<3>().mean());
      slope.tail<3>() = 3 / a * half.tail<3>();
    }
    return {0.5 * (one - other).transpose() * slope,
            0.5 * (one + other).topRows<3>().colwise().sum().transpose()};
  }

 private:
  template <class Take>
  void each_node(std::size_t part, const Take& take) const {
    std::vector<Tensor> stresses(response_.path.size());
    for (std::size_t q = 0; q < response_.stress_places[part].size(); ++q) {
      const Spot spot{part, static_cast<Eigen::Index>(q), true, {}, -1};
      for (std::size_t k = 0; k < stresses.size(); ++k) stresses[k] = section(k, spot);
      take(spot, stresses);
    }
  }

  const Mechanism& mechanism_;
  const StressRules& rules_;
  const StrokeResponse& response_;
  std::vector<ClampFactors> factors_;  ///< of the leaves
};

/// Keeps the larger one for both ends of a cycle; of equal ones but for rounding the first.
void keep(std::vector<Found>& worst, std::size_t i, std::size_t j, double measure, const Spot& spot,
          const EffectiveCycle& cycle) {
  for (const auto& [at, other] : {std::pair{i, j}, std::pair{j, i}})
    if (measure > worst[at].measure * (1 + 1e-9)) worst[at] = {measure, spot, other, cycle};
}

/// Largest use and largest reversed amplitude of the cycles of one part that end at each point, and
/// the largest mean where one breaks the part.
struct WorstOfPart {
  std::vector<Found> use, reversed;
  double broken = 0;
};

WorstOfPart worst_of_part(const History& history, std::size_t part, const FatigueLaw& law,
                          const StressRules& rules, std::size_t points) {
  WorstOfPart worst{std::vector<Found>(points), std::vector<Found>(points), 0};
  history.each_spot(part, [&](const Spot& spot, const auto& stresses) {
    for (std::size_t i = 0; i < points; ++i)
      for (std::size_t j = i + 1; j < points; ++j) {
        const EffectiveCycle cycle = effective_cycle_of(stresses[i], stresses[j]);
        if (rules.fatigue)
          keep(worst.use, i, j, law.use(cycle.amplitude, cycle.mean).value, spot, cycle);
        if (!rules.life) continue;
        if (const auto reversed = law.reversed(cycle.amplitude, cycle.mean))
          keep(worst.reversed, i, j, reversed->value, spot, cycle);
        else
          worst.broken = std::max(worst.broken, cycle.mean);
      }
  });
  return worst;
}

VectorXd chain(const FatigueLaw::Answer& law, const History::CycleRates& rates) {
  return law.per_amplitude * rates.amplitude + law.per_mean * rates.mean;
}

/// Puts what one part has into the points where it is worse than those before.
class Points {
 public:
  Points(const History& history, const std::vector<Mechanism>* directions, StrokeResponse& response,
         StrokeGradients* gradients)
      : history_(history), directions_(directions), response_(response), gradients_(gradients) {}

  void add_safety(const Found& found, std::size_t k, const FatigueLaw& law) {
    const FatigueLaw::Answer use = law.use(found.cycle.amplitude, found.cycle.mean);
    if (use.value * no_critical_factor <= 1) return;
    auto& safety = response_.path[k].fatigue_safety;
    const double value = 1 / use.value;
    by_safety_.note(value, found.spot);
    if (safety && value >= safety->value * (1 - 1e-9)) return;
    safety = history_.cycle_of(found, k);
    safety->value = value;
    if (gradients_)
      gradients_->path[k].fatigue_safety = -value * value * chain(use, rates(found, k));
  }

  void add_life(const Found& found, std::size_t k, const FatigueLaw& law) {
    if (found.measure <= 0) return;
    const Life life = life_at(law.curve(), found.measure);
    if (life.log10_cycles >= longest_life) return;
    by_life_.note(life.log10_cycles, found.spot);
    auto& least = response_.path[k].fatigue_life;
    if (least && life.log10_cycles >= least->value - 1e-9) return;
    least = history_.cycle_of(found, k);
    least->value = life.log10_cycles;
    least->range = life.range;
    const auto reversed = law.reversed(found.cycle.amplitude, found.cycle.mean);
    if (gradients_)
      gradients_->path[k].fatigue_life =
          life.slope / (found.measure * std::numbers::ln10) * chain(*reversed, rates(found, k));
  }

  /// Adds, to every point, the stress at the place of the path's least safety or least life, where
  /// it is on a leaf.
  void add_stress() {
    const std::optional<Spot>& spot = by_safety_.spot ? by_safety_.spot : by_life_.spot;
    if (!spot || history_.is_elastic(spot->part)) return;
    for (std::size_t k = 0; k < response_.path.size(); ++k)
      response_.path[k].fatigue_stress = History::on_side(*spot, history_.section(k, *spot));
  }

 private:
  struct Least {
    double value = std::numeric_limits<double>::infinity();
    std::optional<Spot> spot;
    void note(double of, const Spot& at) {
      if (spot && of >= value * (1 - 1e-9)) return;  // of equal ones but for rounding the first
      value = of;
      spot = at;
    }
  };

  History::CycleRates rates(const Found& found, std::size_t k) const {
    return history_.cycle_rates(found, k, *directions_, *gradients_);
  }

  const History& history_;
  const std::vector<Mechanism>* directions_;
  StrokeResponse& response_;
  StrokeGradients* gradients_;
  Least by_safety_, by_life_;
};

// Whether the path has a cycle.
Check check_cycle(const StrokeResponse& response) {
  if (response.path.size() < 2)
    return Because(
        "a path of one point has no cycle: give it more points, or fatigue a stress_ratio");
  for (const PathPoint& point : response.path)
    if (!point.fillet_fault.empty()) return Because(point.fillet_fault);
  if (!std::ranges::all_of(response.path, [](const PathPoint& point) {
        return point.status == PointStatus::converged && !point.sections.empty();
      }))
    return Because("a point of the path has no equilibrium: its cycle is not known");
  return {};
}

}  // namespace

EffectiveCycle effective_cycle(const Vector3d& one, const Vector3d& other) {
  const Vector3d half = 0.5 * (one - other);
  return {std::sqrt(std::max(0.0, von_mises_square(half))),
          0.5 * (one[0] + one[1] + other[0] + other[1])};
}

void add_fatigue(const Mechanism& mechanism, const StressRules& rules,
                 const std::vector<Mechanism>* directions, StrokeResponse& response,
                 StrokeGradients* gradients) {
  assert(rules.need_history() && (directions == nullptr) == (gradients == nullptr));
  Check known = check_cycle(response);
  if (known) {
    const History history(mechanism, rules, response);
    Points points(history, directions, response, gradients);
    for (std::size_t i = 0; i < history.parts(); ++i) {
      if (response.stress_places[i].empty()) continue;  // its stress is not known
      const StressedPart part = history.part(i);
      const FatigueLaw law(*part.material, rules.fatigue_rule);
      const WorstOfPart worst = worst_of_part(history, i, law, rules, response.path.size());
      if (worst.broken > 0)
        known = Because(fmt::format(
            "the mean stress of {:.4g} Pa in {} alone is beyond what the material bears, {:.4g} Pa",
            worst.broken, *part.name, law.limit()));
      for (std::size_t k = 0; k < response.path.size(); ++k) {
        if (rules.fatigue) points.add_safety(worst.use[k], k, law);
        if (rules.life && worst.broken == 0) points.add_life(worst.reversed[k], k, law);
      }
    }
    points.add_stress();
  }
  for (PathPoint& point : response.path) {
    if (!known) {
      point.fatigue_fault = known.error();
      point.fatigue_life.reset();
    }
    point.sections.clear();
  }
  response.stress_places.clear();
  if (!gradients) return;
  for (PointGradients& of : gradients->path) {
    if (!known) of.fatigue_life.reset();
    of.section_rates.clear();
  }
}

}  // namespace flexopt
