#pragma once
// Towards the optimum of full accuracy, with a handful of full evaluations.
#include "optim/search/optimum.hpp"
#include "optim/search/search.hpp"

namespace flexopt {

struct VerificationOutcome {
  VerificationLoop report;
  /// Best design with its values at full accuracy; nothing where full accuracy has none.
  std::optional<Candidate> best;
  Pose pose;                        ///< with the correction that holds there
  std::vector<double> multipliers;  ///< of the goals 1, 2, …, from the corrected search
  std::vector<LoggedEvaluation> evaluations;
};

/// Model management with first-order consistent corrections in a trust region
/// [Alexandrov, Dennis, Lewis, Torczon, Struct. Optim. 15 (1998)]: the job's own model, corrected
/// to equal full accuracy at the current design (`make_correction`), is optimised in a box of half
/// width Δ round it; the new design is evaluated at full accuracy and accepted where the merit
/// f + 20 · violation falls by at least a twentieth of what the corrected model promised; Δ doubles
/// above three quarters, and halves below a quarter. It ends where the corrected search stays where
/// it is, or where full accuracy confirms its proposal: within the tolerance, feasible, and not
/// held back by Δ. Where both models have exact derivatives the proposal must meet the first-order
/// conditions of full accuracy instead, to the job's tolerance.
VerificationOutcome verify_optimum(const Campaign& campaign, const VerifySpec& rules,
                                   const EvaluationBook& known, const Pose& pose,
                                   const Candidate& optimum);

}  // namespace flexopt
