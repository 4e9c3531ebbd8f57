#include "core/response/path/frequency_derivatives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/equilibrium/stroke_path.hpp"
#include "core/math/lanczos.hpp"

namespace flexopt {
namespace {

// Change of a vector by a step of inverse iteration.
constexpr double tolerance = 1e-6;

// Whether the frequencies up to this one are equal to none above.
bool ends_cluster(const VectorXd& lambda, int count) {
  return lambda[count] - lambda[count - 1] > 10 * repeated_frequency * std::abs(lambda[count]);
}

// Modes of leaves may be so far above the mechanism's that K⁻¹ M rounds them away: Lanczos' method
// then ends with vectors that are none.
bool are_modes(const MechanismFactor& factor, const LowModes& modes) {
  const MatrixXd change = factor.solve(modes.M_phi) * modes.lambda.asDiagonal() - modes.phi;
  const VectorXd squares = change.cwiseProduct(factor.mass(change)).colwise().sum();
  return (squares.array() <= tolerance * tolerance).all();
}

std::optional<LowModes> modes_of_krylov(const MechanismFactor& factor, int wanted) {
  const int width = std::min(std::max(3, static_cast<int>(factor.leaves().size())), wanted);
  LowestPairs pairs =
      lowest_pairs(factor.size(), wanted, width, factor.solver(false), factor.masses(), tolerance);
  if (!pairs.converged) return std::nullopt;
  LowModes modes{std::move(pairs.values), std::move(pairs.vectors), {}};
  modes.M_phi = factor.mass(modes.phi);
  if (!are_modes(factor, modes)) return std::nullopt;
  return modes;
}

std::optional<LowModes> exact_modes(const MechanismFactor& factor, int wanted,
                                    const FullModes* known) {
  std::optional<FullModeLists> own;
  if (!known || known->converged < wanted) {
    own = full_modes(factor, wanted, 0, ModeMotions::no);
    if (!own) return std::nullopt;
  }
  const FullModes& lowest = own ? own->free : *known;
  LowModes modes{lowest.lambda.head(lowest.converged), lowest.phi.leftCols(lowest.converged), {}};
  modes.M_phi = factor.mass(modes.phi);
  return modes;
}

}  // namespace

Answer<LowModes> low_modes(const MechanismFactor& factor, int count, bool exact,
                           const FullModes* known) {
  const std::string none =
      fmt::format("the lowest {} modes of {} unknowns were not found", count, factor.size());
  // modes of equal leaves come in clusters of as many: larger ones are given up at once
  const int most = factor.leaves().size() > 64 ? 8 : 64;
  const auto unstable = negative_pivots(factor.system(), false);
  std::optional<LowModes> last;
  for (int guard = modes_needed(count) - count; guard <= most; guard *= 2) {
    const int wanted = std::min(count + guard, factor.size());
    std::optional<LowModes> modes;
    if (!exact) modes = modes_of_krylov(factor, wanted);
    if (!modes) modes = exact_modes(factor, wanted, known);
    if (!modes) return Because(none);
    last = std::move(modes);
    // the pairs are those of least size: unstable ones may be beyond. Of leaves whose stiffness
    // spans more than numbers have digits the count is rounding, and there may be none.
    if ((last->lambda.array() < 0).count() < unstable) continue;
    const VectorXd& l = last->lambda;
    last->kept = count;
    while (last->kept < l.size() && !ends_cluster(l, last->kept)) ++last->kept;
    if (last->kept + 2 <= l.size() && l[l.size() - 1] > 1.05 * l[last->kept - 1])
      return std::move(*last);
  }
  const VectorXd& l = last->lambda;
  int& kept = last->kept = std::min(count, static_cast<int>(l.size()) - 1);
  while (kept > 0 && (!ends_cluster(l, kept) || l[l.size() - 1] <= 1.05 * l[kept - 1])) --kept;
  if (kept <= 0) return Because(none);
  return std::move(*last);
}

}  // namespace flexopt
