// Transfers between named points, and from the ground. Equations (H10) to (H12) of README.md.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/response/modes/dynamics_measures.hpp"
#include "core/response/modes/point_forces.hpp"

namespace flexopt {
namespace {

using std::numbers::sqrt2;

constexpr double uncoupled = 1e-10;  // share of a compliance between points that is rounding

// A point that is loaded, or whose motion is wanted: the forces there, and K⁻¹ of them.
struct PointAnswer {
  const NamedPoint* point = nullptr;
  VectorXd force, still;
};

// What a bandwidth is read off: a function of σ, 1 at rest.
struct Line {
  PoleSum response;  ///< whose poles are its peaks
  std::function<Complex(Complex)> value, log_slope;
  bool either_way;  ///< whether it ends above √2 as well as below 1/√2
};

// (H(σ) − H(0))/σ
PoleSum growth_of(const PoleSum& response) {
  PoleSum growth = response;
  growth.weight = response.weight.cwiseProduct(response.theta);
  return growth;
}

// Relative change of a response with σ.
Complex slope_of(const PoleSum& response, Complex sigma) {
  return response.slope(sigma) / response.at(sigma);
}

std::optional<double> end_of(const Line& line, double damping) {
  const std::vector<double> poles = line.response.frequencies();
  if (poles.empty()) return std::nullopt;
  const double last = line.either_way ? poles.back() : 1e2 * poles.back();
  return first_excess(
      [&](double f) {
        const double ratio = std::abs(line.value(shift_of(f, damping)));
        return (line.either_way ? std::max(ratio, 1 / ratio) : 1 / ratio) - sqrt2;
      },
      samples(line.response, 1e-2 * poles.front(), last, damping, 0));
}

// One transfer: its responses H(σ) = e_tᵀ(K − σM)⁻¹e_f, and what they change by.
class Transferred {
 public:
  Transferred(const MechanismFactor& factor, const TransferRule& rule, double damping, bool rates)
      : factor_(&factor),
        solve_(factor.solver(rule.drive == DriveState::locked)),
        damping_(damping),
        rates_(rates) {}

  PointAnswer answer_of(const NamedPoint& point, const VectorXd& force) const {
    return {&point, force, solve_(force).col(0)};
  }
  TransferMeasure of_load(const PointAnswer& from, const PointAnswer& to) const;
  TransferMeasure of_motion(const PointAnswer& from, const PointAnswer& to) const;
  TransferMeasure of_ground(const PointAnswer& to) const;

 private:
  // Adds what the logarithm of the line changes by at σ, `weight` times, with the motion of the
  // answer and, by a unit load there, of `to`.
  using AddRates = std::function<void(double weight, Complex sigma, const VectorXcd& moved,
                                      const VectorXcd& of_to, HarmonicTerms& terms)>;
  void set_bandwidth(const VectorXd& still, const PointAnswer& to,
                     const std::function<Line(const HarmonicAnswer&)>& line_of,
                     const AddRates& add_rates, TransferMeasure& measure) const;
  HarmonicAnswer answer(const VectorXd& still) const {
    return {still, std::min(factor_->size(), most_harmonic_columns), solve_, factor_->masses()};
  }
  // Adds Re[c H′], with the motions by loads at both points.
  static void add_response(Complex c, Complex sigma, const PointAnswer& from,
                           const VectorXcd& of_from, const PointAnswer& to, const VectorXcd& of_to,
                           HarmonicTerms& terms) {
    const VectorXcd weighted = c * of_to;
    terms.real_part(-1, sigma, HarmonicTerms::parts(weighted), HarmonicTerms::parts(of_from));
    terms.force(*to.point, (c * of_from).real());
    terms.force(*from.point, weighted.real());
  }
  static std::string why_uncoupled(const PointAnswer& from, const PointAnswer& to) {
    return fmt::format("a load at {} does not move {}", from.point->name, to.point->name);
  }
  static void add_compliance(double c, const PointAnswer& from, const PointAnswer& to,
                             HarmonicTerms& terms) {
    terms.pencil(-c, 0, {to.still}, {from.still});
    terms.force(*to.point, c * from.still);
    terms.force(*from.point, c * to.still);
  }
  // Adds c times the derivative of dH/dσ at rest.
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

  const MechanismFactor* factor_;
  LinearMap solve_;
  double damping_;
  bool rates_;
};

// The bandwidth moves by the change of the logarithm over its slope along the frequency.
void Transferred::set_bandwidth(const VectorXd& still, const PointAnswer& to,
                                const std::function<Line(const HarmonicAnswer&)>& line_of,
                                const AddRates& add_rates, TransferMeasure& measure) const {
  HarmonicAnswer moved = answer(still);
  const LineEnd end =
      found_end(moved, *factor_, damping_, [&] { return end_of(line_of(moved), damping_); });
  measure.bandwidth = end.frequency;
  measure.no_bandwidth = end.none;
  if (!rates_ || !measure.bandwidth) return;
  const double f = *measure.bandwidth;
  HarmonicAnswer of_to = answer(to.still);
  if (!reaches(of_to, damping_, {f})) return;
  const Complex sigma = shift_of(f, damping_);
  const double slope = (line_of(moved).log_slope(sigma) * 2.0 * sigma / f).real();
  HarmonicTerms terms(*factor_, std::abs(sigma));
  add_rates(-1 / slope, sigma, moved.vector(sigma), of_to.vector(sigma), terms);
  measure.of_bandwidth = terms.take();
}

// (H10)
TransferMeasure Transferred::of_load(const PointAnswer& from, const PointAnswer& to) const {
  const double C = to.force.dot(from.still), own = from.force.dot(from.still),
               other = to.force.dot(to.still);
  TransferMeasure measure;
  measure.compliance = C;
  if (rates_) {
    HarmonicTerms terms(*factor_, 1);
    add_compliance(1, from, to, terms);
    measure.at_rest = terms.take();
  }
  if (std::abs(C) <= uncoupled * std::sqrt(std::abs(own * other))) {
    measure.no_bandwidth.reason = why_uncoupled(from, to);
    return measure;
  }
  const MatrixXd inertia = factor_->mass(from.still);
  const double G = to.force.dot(solve_(inertia).col(0));  // dH/dσ at rest
  if (G == 0) {                                           // no line that anything could leave
    measure.no_bandwidth.reason = inertia.isZero(0) ? "" : "the load feels no mass at rest";
    return measure;
  }
  const auto line_of = [&](const HarmonicAnswer& answer) -> Line {
    const PoleSum H = answer.along(to.force), growth = growth_of(H);
    return {H, [=](Complex s) { return growth.at(s) / H.at(s) * (C / G); },
            [=](Complex s) { return slope_of(growth, s) - slope_of(H, s); }, true};
  };
  const auto add_rates = [&](double weight, Complex sigma, const VectorXcd& of_from,
                             const VectorXcd& of_to, HarmonicTerms& terms) {
    const Complex H = to.force.cast<Complex>().dot(of_from), moved = 1.0 / (H - C);
    add_response(weight * (moved - 1.0 / H), sigma, from, of_from, to, of_to, terms);
    add_compliance(weight * (1 / C - moved.real()), from, to, terms);
    add_growth(-weight / G, from, to, terms);
  };
  set_bandwidth(from.still, to, line_of, add_rates, measure);
  return measure;
}

// (H11)
TransferMeasure Transferred::of_motion(const PointAnswer& from, const PointAnswer& to) const {
  const double C = to.force.dot(from.still), own = from.force.dot(from.still),
               other = to.force.dot(to.still);
  TransferMeasure measure;
  measure.compliance = C / own;
  const auto add_ratio = [&](double weight, HarmonicTerms& terms) {
    add_compliance(weight / own, from, to, terms);
    add_compliance(-weight * C / (own * own), from, from, terms);
  };
  if (rates_) {
    HarmonicTerms terms(*factor_, 1);
    add_ratio(1, terms);
    measure.at_rest = terms.take();
  }
  if (std::abs(C) <= uncoupled * std::sqrt(std::abs(own * other))) {
    measure.no_bandwidth.reason = why_uncoupled(from, to);
    return measure;
  }
  const auto line_of = [&](const HarmonicAnswer& answer) -> Line {
    const PoleSum H = answer.along(to.force), H_own = answer.along(from.force);
    return {H, [=](Complex s) { return H.at(s) / H_own.at(s) * (own / C); },
            [=](Complex s) { return slope_of(H, s) - slope_of(H_own, s); }, false};
  };
  const auto add_rates = [&](double weight, Complex sigma, const VectorXcd& of_from,
                             const VectorXcd& of_to, HarmonicTerms& terms) {
    const Complex H = to.force.cast<Complex>().dot(of_from),
                  H_own = from.force.cast<Complex>().dot(of_from);
    add_response(weight / H, sigma, from, of_from, to, of_to, terms);
    add_response(-weight / H_own, sigma, from, of_from, from, of_from, terms);
    add_ratio(-weight * own / C, terms);
  };
  set_bandwidth(from.still, to, line_of, add_rates, measure);
  return measure;
}

// (H12): the ground moves along the direction n of the point.
TransferMeasure Transferred::of_ground(const PointAnswer& to) const {
  const Vector3d n = to.point->direction->head<3>();
  TransferMeasure measure;
  measure.compliance = 1;
  const auto line_of = [&](const HarmonicAnswer& answer) -> Line {
    const PoleSum y = answer.along(to.force);
    const auto T = [=](Complex s) { return 1.0 + s * y.at(s); };
    return {y, T, [=](Complex s) { return (y.at(s) + s * y.slope(s)) / T(s); }, false};
  };
  const RigidMotion rigid = rigid_motion(*factor_);
  const VectorXd carried = rigid.motion.leftCols<3>() * n;
  const auto add_rates = [&](double weight, Complex sigma, const VectorXcd& moved,
                             const VectorXcd& of_to, HarmonicTerms& terms) {
    const VectorXcd relative = sigma * moved;
    const Complex c = weight / (1.0 + to.force.cast<Complex>().dot(relative));
    HarmonicTerms::Parts absolute = HarmonicTerms::parts(relative);
    absolute[0].ground = n;
    terms.real_part(-1, sigma, HarmonicTerms::parts(c * of_to), absolute);
    terms.force(*to.point, (c * (relative + carried.cast<Complex>())).real());
  };
  const VectorXd shaken = rigid.inertia.leftCols<3>() * n;
  set_bandwidth(solve_(shaken).col(0), to, line_of, add_rates, measure);
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
    const Transferred of(factor, wanted, rule.damping, terms);
    const PointAnswer from = of.answer_of(points[first], forces->col(0)),
                      to = of.answer_of(points[wanted.to], forces->col(1));
    constexpr double still = 1e-14;  // share of a compliance that is rounding
    if (wanted.from && wanted.of_motion &&
        from.force.dot(from.still) <= still * to.force.dot(to.still))
      return Because(fmt::format("the motion of {} is held, and no other can be given to it",
                                 from.point->name));
    found.push_back(!wanted.from       ? of.of_ground(to)
                    : wanted.of_motion ? of.of_motion(from, to)
                                       : of.of_load(from, to));
  }
  return found;
}

}  // namespace flexopt
