#include "core/response/modes/dynamics_measures.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "core/response/modes/harmonic_answer.hpp"
#include "core/response/modes/mechanism_factor.hpp"
#include "core/response/modes/point_forces.hpp"

namespace flexopt {
namespace {

using std::numbers::pi, std::numbers::sqrt2;

constexpr double residual_tolerance = 1e-10;  // of answers; what is read off them has its square
constexpr int most_columns = 320;             // of their Krylov spaces

// (H4): K (1 + 2iζ) − ω² M = (1 + 2iζ)(K − σ M)
Complex shift(double frequency, double damping) {
  const double omega = 2 * pi * frequency;
  return omega * omega / Complex(1, 2 * damping);
}

// Ascending frequencies between two, close enough together to see every peak that the poles of
// `of` make: at least `least` high.
std::vector<double> samples(const PoleSum& of, double low, double high, double damping,
                            double least) {
  constexpr double step = 1.02;
  constexpr int beside = 30;  // samples on either side of a pole, a third of its width apart
  std::vector<double> list{low, high};
  for (double f = low * step; f < high; f *= step) list.push_back(f);
  for (Eigen::Index j = 0; j < of.theta.size(); ++j) {
    if (of.theta[j] <= 0 || std::abs(of.weight[j]) < 2 * damping * least) continue;
    const double pole = 1 / (2 * pi * std::sqrt(of.theta[j]));
    for (int k = -beside; k <= beside; ++k)
      if (const double f = pole * (1 + damping * k / 3); f > low && f < high) list.push_back(f);
  }
  std::ranges::sort(list);
  return list;
}

// Zero of `function`, which is negative at a and not at b, to the last bit but a few.
double sign_change(const std::function<double(double)>& function, double a, double b) {
  for (int k = 0; k < 200 && b - a > 4 * std::numeric_limits<double>::epsilon() * b; ++k) {
    const double middle = 0.5 * (a + b);
    (function(middle) < 0 ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

// The least frequency of a list, refined, at which an excess is not negative.
std::optional<double> first_excess(const std::function<double(double)>& excess,
                                   const std::vector<double>& list) {
  for (std::size_t k = 1; k < list.size(); ++k)
    if (excess(list[k]) >= 0) return sign_change(excess, list[k - 1], list[k]);
  return std::nullopt;
}

// End of the mass line (H7): where |m(σ)| first is √2 m(0).
std::optional<double> end_of_mass_line(const PoleSum& mass, double damping) {
  const std::vector<double> poles = mass.frequencies();
  if (poles.empty()) return std::nullopt;
  const double still = mass.at(0).real();
  // a peak lower than this share leaves the line within 1 %
  return first_excess(
      [&](double f) { return std::abs(mass.at(shift(f, damping))) - sqrt2 * still; },
      samples(mass, 1e-2 * poles.front(), poles.back(), damping, 0.01 * still));
}

// End of the mass line of a response H between points (H10).
std::optional<double> end_of_transfer(const PoleSum& response, double damping) {
  const std::vector<double> poles = response.frequencies();
  const double compliance = response.at(0).real();
  PoleSum growth = response;  // (H − H(0))/σ
  growth.weight = response.weight.cwiseProduct(response.theta);
  const double still = std::abs(growth.at(0).real() / compliance);
  if (poles.empty() || !(still > 0)) return std::nullopt;
  return first_excess(
      [&](double f) {
        const Complex sigma = shift(f, damping);
        const double ratio = std::abs(growth.at(sigma) / response.at(sigma)) / still;
        return std::max(ratio, 1 / ratio) - sqrt2;
      },
      samples(response, 1e-2 * poles.front(), poles.back(), damping, 0));
}

// `end`: where the line ends by the answer so far.
std::optional<double> end_of_mass_line(HarmonicAnswer& answer, double damping,
                                       const std::function<std::optional<double>()>& end) {
  for (;;) {
    const bool more = answer.extend();
    if (answer.still()) return std::nullopt;
    const std::optional<double> found = end();
    if (found && answer.residual(shift(*found, damping)) <= residual_tolerance) return found;
    if (!more) return std::nullopt;
  }
}

// Gain (H8) from a direction in which the ground moves everything by 1.
struct Gain {
  double carried;  ///< motion with the ground
  PoleSum relative;
  double damping;

  Complex at(double f) const {
    const Complex sigma = shift(f, damping);
    return carried + sigma * relative.at(sigma);
  }
  // Derivative of |T|² with respect to the frequency, up to a positive factor.
  double slope(double f) const {
    const Complex sigma = shift(f, damping);
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

// Terms of a derivative: real quadratic forms of complex motions.
class Terms {
 public:
  struct Motion {
    VectorXd y;
    Vector3d ground = Vector3d::Zero();
  };

  /// `mass_shift`: what tells M′ from K′: yᵀM′y = (yᵀK′y − yᵀ(K′ − ΛM′)y)/Λ.
  Terms(const MechanismFactor& factor, double mass_shift)
      : factor_(&factor), mass_shift_(mass_shift) {}

  void pencil(double weight, double lambda, Motion motion) {
    if (weight != 0) terms_.push_back({weight, lambda, std::move(motion.y), motion.ground});
  }
  void mass(double weight, const Motion& motion) {
    pencil(weight / mass_shift_, 0, motion);
    pencil(-weight / mass_shift_, mass_shift_, motion);
  }
  /// Adds the terms of aᵀ(…)b as those of the sum and the difference of a and b, scaled to like
  /// sizes.
  void pencil(double weight, double lambda, const Motion& a, const Motion& b) {
    each_sum(a, b, [&](double sign, Motion sum) { pencil(sign * weight, lambda, std::move(sum)); });
  }
  void mass(double weight, const Motion& a, const Motion& b) {
    each_sum(a, b, [&](double sign, const Motion& sum) { mass(sign * weight, sum); });
  }
  /// weight · Re[(a + ib)ᵀ(K′ − σM′)(u + iv)].
  void real_part(double weight, Complex sigma, const std::array<Motion, 2>& left,
                 const std::array<Motion, 2>& right) {
    pencil(weight, sigma.real(), left[0], right[0]);
    pencil(-weight, sigma.real(), left[1], right[1]);
    mass(weight * sigma.imag(), left[0], right[1]);
    mass(weight * sigma.imag(), left[1], right[0]);
  }
  std::vector<QuadraticTerm> take() { return std::move(terms_); }

 private:
  double size(const Motion& motion) const {
    const double energy = motion.y.dot(factor_->mass(motion.y).col(0));
    return std::sqrt(std::max(energy, std::numeric_limits<double>::min()));
  }
  template <class Use>
  void each_sum(const Motion& a, const Motion& b, const Use& use) {
    if (a.y.isZero(0) || (b.y.isZero(0) && b.ground.isZero(0))) return;
    const double scale = b.y.isZero(0) ? 1 : std::sqrt(size(b) / size(a));
    for (const double sign : {1.0, -1.0})
      use(0.25 * sign,
          Motion{scale * a.y + sign / scale * b.y, scale * a.ground + sign / scale * b.ground});
  }

  const MechanismFactor* factor_;
  double mass_shift_;
  std::vector<QuadraticTerm> terms_;
};

std::array<Terms::Motion, 2> parts(const VectorXcd& y) { return {{{y.real()}, {y.imag()}}}; }

// (H9)
std::vector<QuadraticTerm> bandwidth_terms(const MechanismFactor& factor, double frequency,
                                           double damping, const HarmonicAnswer& answer,
                                           const VectorXd& unit_stroke) {
  const Complex sigma = shift(frequency, damping);
  const PoleSum mass = answer.mass();
  const Complex m = mass.at(sigma), phase = std::conj(m) / std::abs(m);
  const double per_hertz = (phase * mass.slope(sigma) * 2.0 * sigma / frequency).real();
  const double weight = -1 / per_hertz;  // of the change of |m| − √2 m(0) at a frequency
  const Complex share = phase / sigma;
  Terms terms(factor, std::abs(sigma));
  // m = (k − Z)/σ, Z = xᵀ(K − σM)x
  const VectorXcd x = std::sqrt(share) * answer.vector(sigma);
  const auto [a, b] = parts(x);
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

std::optional<DynamicsMeasure> bandwidth(const MechanismFactor& factor, double damping,
                                         const VectorXd& unit_stroke, bool terms) {
  HarmonicAnswer answer(unit_stroke, std::min(factor.size(), most_columns), factor.solver(true),
                        factor.masses());
  const std::optional<double> end =
      end_of_mass_line(answer, damping, [&] { return end_of_mass_line(answer.mass(), damping); });
  if (!end) return std::nullopt;
  DynamicsMeasure measure{*end, *end, {}, {}};
  if (terms) measure.terms = bandwidth_terms(factor, *end, damping, answer, unit_stroke);
  return measure;
}

// Extends the answer until it is accurate at these frequencies; false where it does not become so.
bool reaches(HarmonicAnswer& answer, double damping, const std::vector<double>& frequencies) {
  const auto good = [&] {
    return answer.still() || std::ranges::all_of(frequencies, [&](double f) {
             return answer.residual(shift(f, damping)) <= residual_tolerance;
           });
  };
  if (answer.still()) answer.extend();
  while (!good())
    if (!answer.extend()) return good();
  return true;
}

std::optional<DynamicsMeasure> transmissibility(const MechanismFactor& factor,
                                                const RigidMotion& rigid,
                                                const TransmissibilityRule& rule, double damping,
                                                bool terms, const NamedPoint* point) {
  const int d = index(rule.direction);
  VectorXd force = VectorXd::Zero(factor.size());
  if (point)
    force = point_on_body_forces(factor, *point);
  else
    force[6 * factor.system().mechanism().end_effector + d] = 1;
  const double carried = point ? (*point->direction)[d] : 1;
  const LinearMap solve = factor.solver(rule.drive == DriveState::locked), mass = factor.masses();
  const int most = std::min(factor.size(), most_columns);
  HarmonicAnswer answer(solve(rigid.inertia.col(d)).col(0), most, solve, mass);
  // all over the band, then at the peak
  constexpr int watched = 12;
  std::vector<double> frequencies;
  for (int k = 0; k <= watched; ++k)
    frequencies.push_back(rule.from *
                          std::pow(rule.to / rule.from, static_cast<double>(k) / watched));
  double frequency = rule.to;
  for (bool found = false; !found;) {
    if (!reaches(answer, damping, frequencies)) return std::nullopt;
    frequency = largest_gain({carried, answer.along(force), damping}, rule.from, rule.to);
    found = answer.still() || answer.residual(shift(frequency, damping)) <= residual_tolerance;
    frequencies.push_back(frequency);
  }
  const Complex sigma = shift(frequency, damping);
  const VectorXcd relative = sigma * answer.vector(sigma);
  const Complex T = carried + (force.cast<Complex>().transpose() * relative)(0);
  DynamicsMeasure measure{std::abs(T), frequency, {}, {}};
  if (!terms) return measure;
  HarmonicAnswer adjoint(solve(force).col(0), most, solve, mass);
  if (!reaches(adjoint, damping, {frequency})) return std::nullopt;
  const VectorXcd weighted = std::conj(T) / std::abs(T) * adjoint.vector(sigma);
  std::array<Terms::Motion, 2> absolute = parts(relative);
  absolute[0].ground[d] = 1;
  Terms of(factor, std::abs(sigma));
  of.real_part(-1, sigma, parts(weighted), absolute);
  measure.terms = of.take();
  if (point) {
    const Vector3d spin =
        (std::conj(T) / std::abs(T) * relative.segment<3>(6 * *point->body + 3)).real();
    measure.lever = {*point, point->direction->head<3>().cross(spin)};
  }
  return measure;
}

}  // namespace

DynamicsMeasures dynamics_measures(const MechanismFactor& factor, const DynamicsRule& rule,
                                   bool driven, bool terms, const std::vector<NamedPoint>& points) {
  DynamicsMeasures measures;
  const MatrixXd strokes = driven ? factor.drive_shapes() : MatrixXd(factor.size(), 0);
  for (Eigen::Index k = 0; k < strokes.cols(); ++k)
    measures.bandwidths.push_back(bandwidth(factor, rule.damping, strokes.col(k), terms));
  if (rule.transmissibility) {
    const RigidMotion rigid = rigid_motion(factor);
    measures.transmissibility = transmissibility(
        factor, rigid, *rule.transmissibility, rule.damping, terms,
        rule.transmissibility->point ? &points[*rule.transmissibility->point] : nullptr);
    measures.carried = rigid.motion.leftCols<3>();
  }
  return measures;
}

Answer<std::vector<Transfer>> transfers(const MechanismFactor& factor, const DynamicsRule& rule,
                                        const std::vector<NamedPoint>& points, LeafRates& rates) {
  constexpr double rounding = 1e-10;  // of a compliance between points that nothing couples
  std::vector<Transfer> found;
  for (const TransferRule& wanted : rule.transfers) {
    const Answer<MatrixXd> forces =
        point_forces(factor, {points[wanted.from], points[wanted.to]}, rates);
    if (!forces) return Because(forces.error());
    const LinearMap solve = factor.solver(wanted.drive == DriveState::locked);
    const MatrixXd still = solve(*forces);
    const Eigen::Matrix2d compliance = forces->transpose() * still;
    Transfer& transfer = found.emplace_back(Transfer{compliance(1, 0), {}});
    if (std::abs(compliance(1, 0)) <=
        rounding * std::sqrt(std::abs(compliance(0, 0) * compliance(1, 1))))
      continue;
    HarmonicAnswer answer(still.col(0), std::min(factor.size(), most_columns), solve,
                          factor.masses());
    transfer.bandwidth = end_of_mass_line(answer, rule.damping, [&] {
      return end_of_transfer(answer.along(forces->col(1)), rule.damping);
    });
  }
  return found;
}

}  // namespace flexopt
