#include "core/response/modes/dynamics_measures.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/response/modes/point_forces.hpp"

namespace flexopt {
namespace {

using std::numbers::sqrt2;

// End of the mass line (H7): where |m(σ)| first is √2 m(0).
std::optional<double> end_of_mass_line(const PoleSum& mass, double damping) {
  const std::vector<double> poles = mass.frequencies();
  if (poles.empty()) return std::nullopt;
  const double still = mass.at(0).real();
  // a peak lower than this share leaves the line within 1 %
  return first_excess(
      [&](double f) { return std::abs(mass.at(shift_of(f, damping))) - sqrt2 * still; },
      samples(mass, 1e-2 * poles.front(), poles.back(), damping, 0.01 * still));
}

// Gain (H8) from a direction in which the ground moves everything by 1.
struct Gain {
  double carried;  ///< motion with the ground
  PoleSum relative;
  double damping;

  Complex at(double f) const {
    const Complex sigma = shift_of(f, damping);
    return carried + sigma * relative.at(sigma);
  }
  // Derivative of |T|² with respect to the frequency, up to a positive factor.
  double slope(double f) const {
    const Complex sigma = shift_of(f, damping);
    const Complex dT = (relative.at(sigma) + sigma * relative.slope(sigma)) * sigma;
    return (std::conj(at(f)) * dT).real();
  }
};

// Frequency of the largest gain between two frequencies [Hz].
double largest_gain(const Gain& gain, double low, double high) {
  constexpr double near = 0.7;  // of the largest sample: lower maxima are not the largest
  // a peak of 2 % in σ y is no maximum that counts beside T(0) = 1
  PoleSum strong = gain.relative;
  for (Eigen::Index j = 0; j < strong.theta.size(); ++j)
    if (strong.theta[j] > 0) strong.weight[j] /= strong.theta[j];
  const std::vector<double> list = samples(strong, low, high, gain.damping, 0.02);
  std::vector<double> height;
  for (const double f : list) height.push_back(std::abs(gain.at(f)));
  const double largest = *std::ranges::max_element(height);
  double best = low;
  const auto take = [&](double f) {
    if (std::abs(gain.at(f)) > std::abs(gain.at(best))) best = f;
  };
  take(high);
  for (std::size_t k = 1; k + 1 < list.size(); ++k) {
    if (height[k] < near * largest || height[k] < height[k - 1] || height[k] < height[k + 1])
      continue;
    if (gain.slope(list[k - 1]) <= 0 || gain.slope(list[k + 1]) >= 0) continue;
    take(sign_change([&](double f) { return -gain.slope(f); }, list[k - 1], list[k + 1]));
  }
  return best;
}

// (H9)
MeasureRate bandwidth_rate(const MechanismFactor& factor, double frequency, double damping,
                           const HarmonicAnswer& answer, const VectorXd& unit_stroke) {
  const Complex sigma = shift_of(frequency, damping);
  const PoleSum mass = answer.mass();
  const Complex m = mass.at(sigma), phase = std::conj(m) / std::abs(m);
  const double per_hertz = (phase * mass.slope(sigma) * 2.0 * sigma / frequency).real();
  const double weight = -1 / per_hertz;  // of the change of |m| − √2 m(0) at a frequency
  const Complex share = phase / sigma;
  HarmonicTerms terms(factor, std::abs(sigma));
  // m = (k − Z)/σ, Z = xᵀ(K − σM)x
  const VectorXcd x = std::sqrt(share) * answer.vector(sigma);
  const auto [a, b] = HarmonicTerms::parts(x);
  terms.pencil(-weight, sigma.real(), a);
  terms.pencil(weight, sigma.real(), b);
  terms.mass(-2 * weight * sigma.imag(), a, b);
  terms.pencil(weight * share.real(), 0, {unit_stroke});
  // m(0) = cᵀMc, where c changes too
  const VectorXd lag = factor.solve_locked(factor.mass(unit_stroke)).col(0);
  terms.mass(-sqrt2 * weight, {unit_stroke});
  terms.pencil(2 * sqrt2 * weight, 0, {lag}, {unit_stroke});
  return terms.take();
}

void add_bandwidth(const MechanismFactor& factor, double damping, const VectorXd& unit_stroke,
                   bool terms, DynamicsMeasures& measures) {
  HarmonicAnswer answer(unit_stroke, std::min(factor.size(), most_harmonic_columns),
                        factor.solver(true), factor.masses());
  const LineEnd end =
      found_end(answer, factor, damping, [&] { return end_of_mass_line(answer.mass(), damping); });
  measures.no_bandwidth.push_back(end.none);
  auto& measure = measures.bandwidths.emplace_back();
  if (!end.frequency) return;
  measure = {*end.frequency, *end.frequency, {}};
  if (terms) measure->rate = bandwidth_rate(factor, *end.frequency, damping, answer, unit_stroke);
}

Answer<DynamicsMeasure> transmissibility(const MechanismFactor& factor, const RigidMotion& rigid,
                                         const TransmissibilityRule& rule, double damping,
                                         bool terms, const NamedPoint* point) {
  if (!factor.elastic().empty())
    if (const auto limit = mode_limit(factor.system().elastic_bodies(), factor.frequencies());
        rule.to > limit.frequency)
      return Because(limit.reason);
  const int d = index(rule.direction);
  VectorXd force = VectorXd::Zero(factor.size());
  if (point) {
    LeafRates own;
    const Answer<MatrixXd> forces = point_forces(factor, {*point}, own);
    if (!forces) return Because(forces.error());
    force = forces->col(0);
  } else {
    force[6 * factor.system().mechanism().end_effector + d] = 1;
  }
  const double carried = point ? (*point->direction)[d] : 1;
  const LinearMap solve = factor.solver(rule.drive == DriveState::locked), mass = factor.masses();
  const int most = std::min(factor.size(), most_harmonic_columns);
  HarmonicAnswer answer(solve(rigid.inertia.col(d)).col(0), most, solve, mass);
  // all over the band, then at the peak
  constexpr int watched = 12;
  std::vector<double> frequencies;
  for (int k = 0; k <= watched; ++k)
    frequencies.push_back(rule.from *
                          std::pow(rule.to / rule.from, static_cast<double>(k) / watched));
  double frequency = rule.to;
  for (bool found = false; !found;) {
    if (!reaches(answer, damping, frequencies))
      return Because("the response over the band is not resolved");
    frequency = largest_gain({carried, answer.along(force), damping}, rule.from, rule.to);
    found = answer.still() || answer.residual(shift_of(frequency, damping)) <= harmonic_tolerance;
    frequencies.push_back(frequency);
  }
  const Complex sigma = shift_of(frequency, damping);
  const VectorXcd relative = sigma * answer.vector(sigma);
  const Complex T = carried + (force.cast<Complex>().transpose() * relative)(0);
  DynamicsMeasure measure{std::abs(T), frequency, {}};
  if (!terms) return measure;
  HarmonicAnswer adjoint(solve(force).col(0), most, solve, mass);
  if (!reaches(adjoint, damping, {frequency})) return measure;
  const VectorXcd weighted = std::conj(T) / std::abs(T) * adjoint.vector(sigma);
  HarmonicTerms::Parts absolute = HarmonicTerms::parts(relative);
  absolute[0].ground[d] = 1;
  HarmonicTerms of(factor, std::abs(sigma));
  of.real_part(-1, sigma, HarmonicTerms::parts(weighted), absolute);
  if (point)
    of.force(
        *point,
        (std::conj(T) / std::abs(T) * (relative + rigid.motion.col(d).cast<Complex>())).real());
  measure.rate = of.take();
  return measure;
}

}  // namespace

DynamicsMeasures dynamics_measures(const MechanismFactor& factor, const DynamicsRule& rule,
                                   bool driven, bool terms, const std::vector<NamedPoint>& points) {
  DynamicsMeasures measures;
  const MatrixXd strokes = driven ? factor.drive_shapes() : MatrixXd(factor.size(), 0);
  for (Eigen::Index k = 0; k < strokes.cols(); ++k)
    add_bandwidth(factor, rule.damping, strokes.col(k), terms, measures);
  if (rule.transmissibility) {
    const RigidMotion rigid = rigid_motion(factor);
    auto found = transmissibility(
        factor, rigid, *rule.transmissibility, rule.damping, terms,
        rule.transmissibility->point ? &points[*rule.transmissibility->point] : nullptr);
    if (found)
      measures.transmissibility = std::move(*found);
    else
      measures.no_transmissibility = found.error();
  }
  return measures;
}

}  // namespace flexopt
