#pragma once
// Random optimisations of a guide in closed form, and the best design that a dense search finds.
#include <nlohmann/json.hpp>
#include <optional>

#include "optim/search/optimise.hpp"

namespace flexopt {

struct RandomSearch {
  nlohmann::json job;
  double breaks_at = 0;  ///< stress beyond which the guide has no equilibrium [Pa]
};

/// Two to four variables with boxes of up to fifty times, the first start anywhere in the box, none
/// to three constraints that some design keeps; half of them have no equilibrium in parts of the
/// box; objectives from 1e-9 to 1e9 in SI.
RandomSearch random_search(unsigned seed, const std::string& algorithm);

/// The mechanics of such a job: closed forms with exact derivatives.
Evaluators closed_forms(double breaks_at);

/// The best objective of a job: of searches from the best of many points of a sequence over the
/// box. Nothing where none of them keeps the constraints.
std::optional<double> dense_search(const RandomSearch& search, int points, int searches);

/// By how much an objective is worse than the best one, relative to it; negative where it is
/// better.
double shortfall(const RandomSearch& search, double objective, double best);

}  // namespace flexopt
