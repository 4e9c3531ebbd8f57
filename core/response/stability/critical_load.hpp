#pragma once
// The factor of one dead load at which the tangent of a mechanism becomes singular, all else kept:
// about a state as a linear estimate, and along the branch of equilibria that leads there.
// README.md of core/response, (S22)–(S25).
#include <optional>

#include "core/response/stability/branch_tracer.hpp"

namespace flexopt {

struct CriticalLoadResult {
  CriticalLoad load;
  std::optional<VectorXd> gradient;  ///< of the factor, where there is one and it was asked for
};

/// Follows the branch from where it stands, first to larger factors, then to smaller ones.
/// `design`: null where no derivatives are wanted. `driven`: the drives' loads are those of their
/// strokes; else there are none. `largest`: size of a factor beyond which nothing is looked for.
CriticalLoadResult find_critical_load(LoadBranch& branch, const ModelOptions& model,
                                      DesignDirections* design, bool driven = true,
                                      double largest = no_critical_factor);

}  // namespace flexopt
