// Transfers between named points, and from the ground. Equations (H10) to (H12) of README.md.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/response/modes/dynamics_measures.hpp"
#include "core/response/modes/point_forces.hpp"

namespace flexopt {
namespace {

using Motions = HarmonicTerms::Parts;
using std::numbers::sqrt2;

constexpr double uncoupled = 1e-10;  // share of a compliance between points that is rounding

// A point that is loaded, or whose motion is wanted: the forces there, and K⁻¹ of them.
struct PointAnswer {
  const NamedPoint* point = nullptr;
  VectorXd force, still;
};

// Two points of a mechanism with all that their responses are made of.
class Transferred {
 public:
  Transferred(const MechanismFactor& factor, bool locked, double damping)
      : factor_(&factor), solve_(factor.solver(locked)), damping_(damping) {}

  void set(PointAnswer& of, const NamedPoint& point, const VectorXd& force) const {
    of = {&point, force, solve_(force).col(0)};
  }
  HarmonicAnswer answer(const VectorXd& still) const {
    return {still, std::min(factor_->size(), most_harmonic_columns), solve_, factor_->masses()};
  }
  // The motion (K − σM)⁻¹ f at a frequency, of the answer's own accuracy; nothing where it is not
  // found.
  std::optional<VectorXcd> motion(const VectorXd& still, double frequency) const {
    HarmonicAnswer of = answer(still);
    if (!reaches(of, damping_, {frequency})) return std::nullopt;
    return of.vector(shift_of(frequency, damping_));
  }
  HarmonicTerms terms(double frequency) const {
    return {*factor_, frequency > 0 ? std::abs(shift_of(frequency, damping_)) : 1};
  }
  // Re[c H′] of the response H(σ) = e_tᵀ(K − σM)⁻¹e_f, with the motions that loads at both make.
  void add_response(Complex c, Complex sigma, const PointAnswer& from, const VectorXcd& of_from,
                    const PointAnswer& to, const VectorXcd& of_to, HarmonicTerms& terms) const {
    const VectorXcd weighted = c * of_to, loaded = c * of_from;
    terms.real_part(-1, sigma, HarmonicTerms::parts(weighted), HarmonicTerms::parts(of_from));
    terms.force(*to.point, loaded.real());
    terms.force(*from.point, weighted.real());
  }
  void add_compliance(double c, const PointAnswer& from, const PointAnswer& to,
                      HarmonicTerms& terms) const {
    terms.pencil(-c, 0, {to.still}, {from.still});
    terms.force(*to.point, c * from.still);
    terms.force(*from.point, c * to.still);
  }
  // c times the derivative of dH/dσ at rest.
  void add_growth(double c, const PointAnswer& from, const PointAnswer& to,
                  HarmonicTerms& terms) const {
    const VectorXd z_from = solve_(factor_->mass(from.still)).col(0),
                   z_to = solve_(factor_->mass(to.still)).col(0);
    terms.pencil(-c, 0, {to.still}, {z_from});
    terms.pencil(-c, 0, {z_to}, {from.still});
    terms.mass(c, {to.still}, {from.still});
    terms.force(*to.point, c * z_from);
    terms.force(*from.point, c * z_to);
  }
  double damping() const { return damping_; }

 private:
  const MechanismFactor* factor_;
  LinearMap solve_;
  double damping_;
};

// (H(σ) − H(0))/σ
PoleSum growth_of(const PoleSum& response) {
  PoleSum growth = response;
  growth.weight = response.weight.cwiseProduct(response.theta);
  return growth;
}

// Relative change of a response with the frequency.
Complex slope_of(const PoleSum& response, Complex sigma) {
  return response.slope(sigma) / response.at(sigma);
}

// End of the mass line of a response H between points (H10).
std::optional<double> end_of_transfer(const PoleSum& response, double damping) {
  const std::vector<double> poles = response.frequencies();
  const double compliance = response.at(0).real();
  const PoleSum growth = growth_of(response);
  const double still = std::abs(growth.at(0).real() / compliance);
  if (poles.empty() || !(still > 0)) return std::nullopt;
  return first_excess(
      [&](double f) {
        const Complex sigma = shift_of(f, damping);
        const double ratio = std::abs(growth.at(sigma) / response.at(sigma)) / still;
        return std::max(ratio, 1 / ratio) - sqrt2;
      },
      samples(response, 1e-2 * poles.front(), poles.back(), damping, 0));
}

// Where a ratio of motions, 1 at rest, first is 1/√2.
std::optional<double> three_decibels(const std::function<Complex(Complex)>& ratio,
                                     const PoleSum& response, double damping) {
  const std::vector<double> poles = response.frequencies();
  if (poles.empty()) return std::nullopt;
  return first_excess([&](double f) { return 1 / sqrt2 - std::abs(ratio(shift_of(f, damping))); },
                      samples(response, 1e-2 * poles.front(), 1e2 * poles.back(), damping, 0));
}

// (H10), derivative: of ln|(H − H(0))/(σH)| less its value at rest, over its slope.
MeasureRate end_rates(const Transferred& of, double frequency, const PoleSum& H,
                      const PointAnswer& from, const PointAnswer& to) {
  const Complex sigma = shift_of(frequency, of.damping());
  const PoleSum growth = growth_of(H);
  const double at_rest = H.at(0).real();
  const double slope =
      ((slope_of(growth, sigma) - slope_of(H, sigma)) * 2.0 * sigma / frequency).real();
  const auto of_from = of.motion(from.still, frequency), of_to = of.motion(to.still, frequency);
  if (!of_from || !of_to) return {};
  const Complex moved = 1.0 / (sigma * growth.at(sigma));
  HarmonicTerms terms = of.terms(frequency);
  of.add_response(-(moved - 1.0 / H.at(sigma)) / slope, sigma, from, *of_from, to, *of_to, terms);
  of.add_compliance((moved.real() - 1 / at_rest) / slope, from, to, terms);
  of.add_growth(1 / growth.at(0).real() / slope, from, to, terms);
  return terms.take();
}

TransferMeasure transfer_of_load(const Transferred& of, const PointAnswer& from,
                                 const PointAnswer& to, bool rates) {
  TransferMeasure measure;
  measure.compliance = to.force.dot(from.still);
  if (rates) {
    HarmonicTerms terms = of.terms(0);
    of.add_compliance(1, from, to, terms);
    measure.at_rest = terms.take();
  }
  const double own = from.force.dot(from.still), other = to.force.dot(to.still);
  if (std::abs(measure.compliance) <= uncoupled * std::sqrt(std::abs(own * other))) return measure;
  HarmonicAnswer answer = of.answer(from.still);
  measure.bandwidth = found_end(
      answer, of.damping(), [&] { return end_of_transfer(answer.along(to.force), of.damping()); });
  if (rates && measure.bandwidth)
    measure.of_bandwidth = end_rates(of, *measure.bandwidth, answer.along(to.force), from, to);
  return measure;
}

// (H11): T = H_tf/H_ff.
TransferMeasure transfer_of_motion(const Transferred& of, const PointAnswer& from,
                                   const PointAnswer& to, bool rates) {
  TransferMeasure measure;
  const double own = from.force.dot(from.still), coupled = to.force.dot(from.still),
               other = to.force.dot(to.still);
  measure.compliance = coupled / own;
  const auto add_ratio = [&](double weight, HarmonicTerms& terms) {
    of.add_compliance(weight / own, from, to, terms);
    of.add_compliance(-weight * coupled / (own * own), from, from, terms);
  };
  if (rates) {
    HarmonicTerms terms = of.terms(0);
    add_ratio(1, terms);
    measure.at_rest = terms.take();
  }
  if (std::abs(coupled) <= uncoupled * std::sqrt(std::abs(own * other))) return measure;
  HarmonicAnswer answer = of.answer(from.still);
  measure.bandwidth = found_end(answer, of.damping(), [&] {
    const PoleSum H = answer.along(to.force), H_own = answer.along(from.force);
    return three_decibels(
        [&](Complex sigma) { return H.at(sigma) / H_own.at(sigma) * (own / coupled); }, H,
        of.damping());
  });
  if (!rates || !measure.bandwidth) return measure;
  const double f = *measure.bandwidth;
  const Complex sigma = shift_of(f, of.damping());
  const PoleSum H = answer.along(to.force), H_own = answer.along(from.force);
  const double slope = ((slope_of(H, sigma) - slope_of(H_own, sigma)) * 2.0 * sigma / f).real();
  const auto of_from = of.motion(from.still, f), of_to = of.motion(to.still, f);
  if (!of_from || !of_to) return measure;
  HarmonicTerms terms = of.terms(f);
  of.add_response(-1.0 / H.at(sigma) / slope, sigma, from, *of_from, to, *of_to, terms);
  of.add_response(1.0 / H_own.at(sigma) / slope, sigma, from, *of_from, from, *of_from, terms);
  add_ratio(own / coupled / slope, terms);
  measure.of_bandwidth = terms.take();
  return measure;
}

// (H8), (H12): the ground moves along the direction n of the point.
TransferMeasure transfer_of_ground(const MechanismFactor& factor, const Transferred& of,
                                   const LinearMap& solve, const PointAnswer& to, bool rates) {
  const Vector3d n = to.point->direction->head<3>();
  const VectorXd still = solve(rigid_motion(factor).inertia.leftCols<3>() * n).col(0);
  TransferMeasure measure;
  measure.compliance = 1;
  HarmonicAnswer answer = of.answer(still);
  measure.bandwidth = found_end(answer, of.damping(), [&] {
    const PoleSum relative = answer.along(to.force);
    return three_decibels([&](Complex sigma) { return 1.0 + sigma * relative.at(sigma); }, relative,
                          of.damping());
  });
  if (!rates || !measure.bandwidth) return measure;
  const double f = *measure.bandwidth;
  const Complex sigma = shift_of(f, of.damping());
  const PoleSum relative = answer.along(to.force);
  const Complex T = 1.0 + sigma * relative.at(sigma),
                dT = relative.at(sigma) + sigma * relative.slope(sigma);
  const double slope = (dT / T * 2.0 * sigma / f).real();
  const auto of_to = of.motion(to.still, f);
  if (!of_to) return measure;
  const VectorXcd y = sigma * answer.vector(sigma), weighted = -1.0 / (slope * T) * *of_to;
  Motions absolute = HarmonicTerms::parts(y);
  absolute[0].ground = n;
  HarmonicTerms terms = of.terms(f);
  terms.real_part(-1, sigma, HarmonicTerms::parts(weighted), absolute);
  terms.force(*to.point, (-1.0 / (slope * T) * y).real());
  measure.of_bandwidth = terms.take();
  return measure;
}

}  // namespace

Answer<std::vector<TransferMeasure>> transfers(const MechanismFactor& factor,
                                               const DynamicsRule& rule,
                                               const std::vector<NamedPoint>& points, bool terms,
                                               LeafRates& rates) {
  std::vector<TransferMeasure> found;
  for (const TransferRule& wanted : rule.transfers) {
    const std::size_t first = wanted.from.value_or(wanted.to);
    const Answer<MatrixXd> forces = point_forces(factor, {points[first], points[wanted.to]}, rates);
    if (!forces) return Because(forces.error());
    const bool locked = wanted.drive == DriveState::locked;
    const Transferred of(factor, locked, rule.damping);
    PointAnswer from, to;
    of.set(from, points[first], forces->col(0));
    of.set(to, points[wanted.to], forces->col(1));
    found.push_back(!wanted.from ? transfer_of_ground(factor, of, factor.solver(locked), to, terms)
                    : wanted.of_motion ? transfer_of_motion(of, from, to, terms)
                                       : transfer_of_load(of, from, to, terms));
  }
  return found;
}

}  // namespace flexopt
