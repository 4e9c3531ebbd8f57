#include "core/response/stroke_series/mechanism_modes.hpp"

#include <algorithm>

#include "core/math/deflated_solve.hpp"
#include "core/math/lanczos.hpp"
#include "core/response/stroke_series/mechanism_series.hpp"

namespace flexopt {

std::optional<MechanismModes> mechanism_modes(System& system, int count, ModalInertia inertia) {
  const auto linear = MechanismFactor::of(system).value;
  if (!linear) return std::nullopt;
  const MechanismFactor& factor = *linear;
  const auto along = MechanismSeries::of(factor).value;
  if (!along) return std::nullopt;
  MechanismSeries& series = *along;
  const auto solve = [&](const MatrixXd& B) { return factor.solve(B); };
  const auto mass = [&](const MatrixXd& B) { return factor.mass(B); };
  const int guard = 3;  // modes beyond, which the shifted systems are solved by
  const LowestPairs pairs =
      lowest_pairs(factor.size(), count + guard, std::max(4, system.leaves()), solve, mass, 1e-11);
  if (!pairs.converged) return std::nullopt;

  MechanismModes result{pairs.values.head(count), pairs.vectors.leftCols(count),
                        MatrixXd(factor.size(), count * count)};
  const MatrixXd M_phi = factor.mass(result.modes);
  const DeflatedSystem deflated{[&](const VectorXd& b) -> VectorXd { return solve(b); },
                                [&](const VectorXd& x) -> VectorXd { return mass(x); },
                                pairs.vectors, pairs.values};
  for (int j = 0; j < count; ++j) {
    series.expand_along(result.modes.col(j));
    const MatrixXd K_phi = series.tangent_times(result.modes)[1];  // K′ Φ
    if (inertia == ModalInertia::left_out) {
      const MatrixXd theta = -factor.solve(K_phi);
      for (int i = 0; i < count; ++i) result.derivatives.col(count * i + j) = theta.col(i);
      continue;
    }
    // (K − ω² M) θ = −(K′ − ω² M′ − (ω²)′ M) φ,   φᵀ M θ = −½ φᵀ M′ φ
    const MatrixXd dM_phi = series.mass_times(result.modes)[1];
    for (int i = 0; i < count; ++i) {
      const VectorXd b = result.omega2[i] * dM_phi.col(i) - K_phi.col(i);
      const auto x = deflated_solve(deflated, i, b);
      if (!x) return std::nullopt;
      result.derivatives.col(count * i + j) =
          *x - 0.5 * result.modes.col(i).dot(dM_phi.col(i)) * result.modes.col(i);
    }
  }
  return result;
}

}  // namespace flexopt
