#pragma once
// Points spread over the unit box [0, 1)ⁿ, the same for the same seed on every machine.
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// The first `count` points of Sobol's sequence (Joe and Kuo's direction numbers, Boost.Random),
/// its origin included, each coordinate's bits XORed with a random number of the seed: a digital
/// shift, which keeps every net property. More points begin with the same ones.
std::vector<VectorXd> sobol_points(int dimensions, int count, unsigned seed);

/// `count` points of which each coordinate has one in every 1/count-th of [0, 1), at a random place
/// in it, the coordinates shuffled independently.    [McKay, Beckman, Conover, Technometrics 1979]
std::vector<VectorXd> latin_hypercube_points(int dimensions, int count, unsigned seed);

/// All combinations of `counts[j]` values in [0, 1], ends included (½ where there is one value),
/// the last coordinate running fastest.
std::vector<VectorXd> grid_points(const std::vector<int>& counts);

}  // namespace flexopt
