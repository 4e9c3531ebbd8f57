#include "core/mechanism/s_n_curve.hpp"

#include <cassert>
#include <cmath>

namespace flexopt {
namespace {

// A straight piece of the curve: log10 cycles = at + slope (log10 amplitude − of).
struct Piece {
  double at = 0, of = 0, slope = 0;

  double log_cycles(double log_amplitude) const { return at + slope * (log_amplitude - of); }
  double log_amplitude(double log_cycles) const { return of + (log_cycles - at) / slope; }
};

Piece piece(const SnCurve& curve, std::size_t i) {
  if (curve.basquin)
    return {-std::log10(2.0), std::log10(curve.basquin->coefficient), 1 / curve.basquin->exponent};
  const SnCurve::Point &a = curve.points[i], &b = curve.points[i + 1];
  const double from = std::log10(a.amplitude), to = std::log10(b.amplitude);
  return {std::log10(a.cycles), from, (std::log10(b.cycles) - std::log10(a.cycles)) / (to - from)};
}

std::size_t piece_count(const SnCurve& curve) {
  assert(curve.basquin || curve.points.size() > 1);
  return curve.basquin ? 1 : curve.points.size() - 1;
}

// Piece of the curve that contains this number of cycles, or the first or last piece outside of
// all. At a point of the curve, the piece before it.
std::size_t piece_of(const SnCurve& curve, double cycles) {
  std::size_t i = 0;
  while (i + 1 < piece_count(curve) && cycles > curve.points[i + 1].cycles) ++i;
  return i;
}

double amplitude_at(const SnCurve& curve, double cycles) {
  return std::pow(10.0, piece(curve, piece_of(curve, cycles)).log_amplitude(std::log10(cycles)));
}

}  // namespace

Life life_at(const SnCurve& curve, double amplitude) {
  assert(amplitude > 0);
  // beyond the knee the piece goes on on which it lies
  const std::size_t last = curve.knee ? piece_of(curve, *curve.knee) : piece_count(curve) - 1;
  std::size_t i = 0;
  while (i < last && amplitude < curve.points[i + 1].amplitude) ++i;
  const Piece on = piece(curve, i);
  Life life{on.log_cycles(std::log10(amplitude)), on.slope};
  const double first = curve.basquin ? 1 : curve.points.front().cycles;
  if (curve.knee && amplitude <= amplitude_at(curve, *curve.knee))
    life.range = LifeRange::without_end;
  else if (life.log10_cycles < std::log10(first) - 1e-12)
    life.range = LifeRange::short_of_curve;
  else if (!curve.basquin && amplitude < curve.points.back().amplitude)
    life.range = LifeRange::beyond_curve;
  return life;
}

std::optional<double> strength_at(const SnCurve& curve, double cycles) {
  if (curve.knee && cycles >= *curve.knee) return amplitude_at(curve, *curve.knee);
  if (!curve.basquin &&
      (cycles < curve.points.front().cycles || cycles > curve.points.back().cycles))
    return std::nullopt;
  return amplitude_at(curve, cycles);
}

std::optional<double> endurance_of(const SnCurve& curve) {
  return curve.knee ? std::optional(amplitude_at(curve, *curve.knee)) : std::nullopt;
}

}  // namespace flexopt
