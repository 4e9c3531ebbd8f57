#pragma once
// Places in the box [−1, 1]ⁿ at which each of many numbers is largest. The numbers are evaluated
// together, and share the places that are visited.
#include <functional>
#include <string>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// The numbers at one place z of the box.
struct BoxLook {
  bool ok = false;
  std::string message;  ///< why not, with the figures
  std::string reason;   ///< why not, in a few words without figures
  VectorXd values;
  MatrixXd rates;  ///< numbers × n
};
using LookInBox = std::function<BoxLook(const VectorXd& z)>;

struct BoxSearch {
  int size = 0;    ///< n
  int starts = 4;  ///< the middle and points of a Sobol sequence
  unsigned seed = 1;
  int places = 1;  ///< how many of each number are wanted
};

struct WorstPlaces {
  bool ok = false;
  std::string message, reason;  ///< of the first place without numbers
  /// For each number, the place where it is largest, then other local maxima that were found, in
  /// descending order; at least one, at most `BoxSearch::places`.
  std::vector<std::vector<VectorXd>> places;
  int looks = 0;
};

/// Searches the worst places from the starts and from the corners to which the derivatives there
/// point (of a box of up to four sides, all corners). Where the best of these is no local maximum:
/// SLSQP from there, from its end with single sides at their bounds if that is worse, and Newton
/// steps where it ends inside. The maxima are local; the global one is not guaranteed. `kinds`: of
/// each number; numbers of one kind are compared with the largest of them to decide whether a slope
/// counts as zero.
WorstPlaces worst_places(const BoxSearch& search, const std::vector<std::size_t>& kinds,
                         const LookInBox& look);

}  // namespace flexopt
