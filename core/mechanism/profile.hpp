#pragma once
// How the width or the thickness of a leaf varies along it: factors on a reference number over the
// place s, 0 at the base edge and 1 at the tip edge. Equation (P1) of core/elements/README.md.
//
// No numbers: uniform. Two numbers p0, p1: linear, p0 (1 − s) + p1 s. Otherwise one number for each
// of profile_stations(): equal pieces of [0, 1], in each the polynomial through its stations. Every
// value is linear in the numbers.
#include <array>
#include <cstddef>
#include <span>

namespace flexopt {

inline constexpr int profile_pieces = 24;
inline constexpr int profile_points = 6;  ///< Chebyshev points of a piece, none on its border

/// The places s where a reader evaluates a formula, ascending; 0 and 1 are not among them.
std::span<const double> profile_stations();

/// Whether a profile may have this many numbers.
bool is_profile_size(std::size_t numbers);

/// What the numbers first, first + 1, … are multiplied with.
struct ProfileWeights {
  int first = 0, count = 0;
  std::array<double, 2 * profile_points> weight{};
};
/// Weights of a derivative of the profile at s ∈ [0, 1]: order 0 is the value, 1 d/ds, 2 d²/ds² …
/// Where two pieces meet, the derivative is the mean of both sides. A profile without numbers has
/// no weights.
ProfileWeights profile_weights(std::size_t numbers, double s, int order = 0);

/// The value at s, or a derivative of it.
double profile_at(std::span<const double> numbers, double s, int order = 0);

/// Mean of the numbers; 1 of none.
double profile_mean(std::span<const double> numbers);

/// Smallest and largest value over [0, 1], sampled at the stations, between them and at the ends.
struct ProfileRange {
  double smallest = 1, largest = 1;
};
ProfileRange profile_range(std::span<const double> numbers);

}  // namespace flexopt
