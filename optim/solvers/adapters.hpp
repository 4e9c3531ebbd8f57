#pragma once
// What each library's adapter file offers to `minimise`. Private to optim/.
#include <string>
#include <vector>

#include "optim/solvers/trials.hpp"

namespace flexopt {

enum class Constraining {
  own,        ///< the algorithm models constraints
  augmented,  ///< through NLopt's augmented Lagrangian
  none        ///< bounds only
};

struct AlgorithmInfo {
  std::string name;
  bool gradients = false;
  bool slack = false;  ///< better served by a slack variable than by one value with kinks
  Constraining constraining = Constraining::own;
  std::vector<std::string> locals;  ///< what may run inside it, the default first
};

/// NLopt's algorithms that this build offers, by NLopt's names.
const std::vector<AlgorithmInfo>& nlopt_algorithms();

/// Optimisers that start from the best point of `trials`, which must exist.
OptimiserSummary minimise_nlopt(Trials& trials);
OptimiserSummary minimise_ipopt(Trials& trials);

}  // namespace flexopt
