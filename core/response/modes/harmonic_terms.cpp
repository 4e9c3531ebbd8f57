#include "core/response/modes/harmonic_terms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/response/modes/frequencies.hpp"

namespace flexopt {

using std::numbers::pi;

Complex shift_of(double frequency, double damping) {
  const double omega = 2 * pi * frequency;
  return omega * omega / Complex(1, 2 * damping);
}

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

double sign_change(const std::function<double(double)>& function, double a, double b) {
  for (int k = 0; k < 200 && b - a > 4 * std::numeric_limits<double>::epsilon() * b; ++k) {
    const double middle = 0.5 * (a + b);
    (function(middle) < 0 ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

std::optional<double> first_excess(const std::function<double(double)>& excess,
                                   const std::vector<double>& list) {
  for (std::size_t k = 1; k < list.size(); ++k)
    if (excess(list[k]) >= 0) return sign_change(excess, list[k - 1], list[k]);
  return std::nullopt;
}

namespace {

void lower(ModeLimit& limit, double highest, const std::string& part) {
  const double frequency = highest / FrequencyOptions{}.cutoff_ratio;
  if (frequency < limit.frequency)
    limit = {frequency, fmt::format("{} has modes up to {:.4g} Hz, enough for {:.4g} Hz", part,
                                    highest, frequency)};
}

// A line of which an answer that is not exact knows no accurate end: how far it is known.
// `beyond`: an end by this answer.
NoBandwidth unresolved(const HarmonicAnswer& answer, double damping, std::optional<double> beyond) {
  constexpr double step = 1.1;
  const std::vector<double> poles = answer.mass().frequencies();
  std::optional<double> known;
  if (!poles.empty())
    for (double f = 1e-2 * poles.front();
         f < beyond.value_or(poles.back()) &&
         answer.residual(shift_of(f, damping)) <= harmonic_tolerance;
         f *= step)
      known = f;
  return {known ? fmt::format("its line does not end up to {:.4g} Hz, and is not resolved beyond",
                              *known)
                : "its line is not resolved",
          known};
}

LineEnd end_of_line(HarmonicAnswer& answer, double damping,
                    const std::function<std::optional<double>()>& end) {
  for (;;) {
    const bool more = answer.extend();
    if (answer.still()) return {};
    const std::optional<double> found = end();
    if (found && answer.residual(shift_of(*found, damping)) <= harmonic_tolerance)
      return {found, {}};
    if (more) continue;
    if (answer.exact()) return {};
    return {{}, unresolved(answer, damping, found)};
  }
}

}  // namespace

ModeLimit mode_limit(const ElasticBodies& bodies, int frequencies) {
  ModeLimit limit;
  for (int k = 0; k < bodies.count(); ++k) {
    if (bodies.body(k).imported) continue;
    const auto modes = bodies.modes(k, frequencies);
    if (modes->count() > 0) lower(limit, modes->highest(), bodies.body(k).name);
  }
  return limit;
}

LineEnd found_end(HarmonicAnswer& answer, const MechanismFactor& factor, double damping,
                  const std::function<std::optional<double>()>& end) {
  LineEnd found = end_of_line(answer, damping, end);
  ModeLimit limit;
  if (!factor.elastic().empty())
    limit = mode_limit(factor.system().elastic_bodies(), factor.frequencies());
  // leaves are exchanged for full ones where the end is beyond their tables
  if (!found.frequency)
    for (std::size_t i = 0; i < factor.leaves().size(); ++i)
      if (const auto highest = factor.leaves()[i].linear->highest_mode())
        lower(limit, *highest, fmt::format("leaf {}", i));
  double to = std::numeric_limits<double>::infinity();  // what it says something about
  if (found.frequency)
    to = *found.frequency;
  else if (!found.none.reason.empty())
    to = found.none.at_least.value_or(0);
  if (to > limit.frequency) return {{}, {limit.reason, limit.frequency}};
  return found;
}

bool reaches(HarmonicAnswer& answer, double damping, const std::vector<double>& frequencies) {
  const auto good = [&] {
    return answer.still() || std::ranges::all_of(frequencies, [&](double f) {
             return answer.residual(shift_of(f, damping)) <= harmonic_tolerance;
           });
  };
  if (answer.still()) answer.extend();
  while (!good())
    if (!answer.extend()) return good();
  return true;
}

double HarmonicTerms::size(const Motion& motion) const {
  const double energy = motion.y.dot(factor_->mass(motion.y).col(0));
  return std::sqrt(std::max(energy, std::numeric_limits<double>::min()));
}

template <class Use>
void HarmonicTerms::each_sum(const Motion& a, const Motion& b, const Use& use) const {
  if (a.y.isZero(0) || (b.y.isZero(0) && b.ground.isZero(0))) return;
  const double scale = b.y.isZero(0) ? 1 : std::sqrt(size(b) / size(a));
  for (const double sign : {1.0, -1.0})
    use(0.25 * sign,
        Motion{scale * a.y + sign / scale * b.y, scale * a.ground + sign / scale * b.ground});
}

void HarmonicTerms::pencil(double weight, double lambda, Motion motion) {
  if (weight != 0) rate_.terms.push_back({weight, lambda, std::move(motion.y), motion.ground});
}

void HarmonicTerms::mass(double weight, const Motion& motion) {
  pencil(weight / mass_shift_, 0, motion);
  pencil(-weight / mass_shift_, mass_shift_, motion);
}

void HarmonicTerms::pencil(double weight, double lambda, const Motion& a, const Motion& b) {
  each_sum(a, b, [&](double sign, Motion sum) { pencil(sign * weight, lambda, std::move(sum)); });
}

void HarmonicTerms::mass(double weight, const Motion& a, const Motion& b) {
  each_sum(a, b, [&](double sign, const Motion& sum) { mass(sign * weight, sum); });
}

void HarmonicTerms::real_part(double weight, Complex sigma, const Parts& left, const Parts& right) {
  pencil(weight, sigma.real(), left[0], right[0]);
  pencil(-weight, sigma.real(), left[1], right[1]);
  mass(weight * sigma.imag(), left[0], right[1]);
  mass(weight * sigma.imag(), left[1], right[0]);
}

}  // namespace flexopt
