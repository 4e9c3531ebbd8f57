#pragma once
// The stages of an optimisation around its searches.
#include <memory>
#include <string>
#include <vector>

#include "optim/problem/design_problem.hpp"
#include "optim/problem/evaluation_book.hpp"
#include "optim/problem/posing.hpp"
#include "optim/search/optimise.hpp"
#include "optim/search/optimum.hpp"
#include "optim/search/search.hpp"

namespace flexopt {

// Start points of an optimisation.

/// The job's own design: the variables' own start values (the job's parameters where they have
/// none) moved into the box, scaled.
VectorXd own_point(const DesignProblem& problem);

/// Scaled variables of each start: first the job's own design, then the first points of the job's
/// spread (unit_points). Each is moved to the nearest point where the constraints that are formulas
/// hold, which costs no mechanics.
std::vector<VectorXd> start_points(const DesignProblem& problem, const Scales& scales);

// Finds out which searches ended at the same optimum.

/// Whether two objectives agree within 0.1 %.
bool objectives_agree(double a, double b);

/// Places of ends that are the same design: objectives agree and scaled variables are within 0.05
/// of each other. The best end first, in each group too; null: a search without one.
std::vector<std::vector<int>> different_ends(const std::vector<const Candidate*>& ends,
                                             bool maximise, double feasible_within);

// The front of two objectives, by bounding the second one.

struct ParetoOutcome {
  ParetoFront report;
  std::vector<LoggedEvaluation> evaluations;
};

/// ε-constraint: from the first objective's optimum (`optimum`) to the second one's, `points`
/// designs, each the best first objective with the second one bounded by ε; the bounds evenly
/// spaced between the second objective's values at both ends, each search begun at its neighbour's
/// end. Where a later, harder bound gave the better first objective, the earlier search is run
/// again from there.                              [Haimes, Lasdon, Wismer, IEEE Trans. SMC 1971]
ParetoOutcome search_front(const Campaign& campaign, const EvaluationBook& known,
                           const SearchResult& optimum);

// Search from the optimum with continuous sizes to the best design with available sizes.

/// A stage's outcome: what is reported, and the design to go on with.
struct StockOutcome {
  StockSearch report;
  Pose pose;            ///< pose of the chosen design: the stock variables held
  SearchResult chosen;  ///< nothing in `best` where none is feasible
  std::vector<LoggedEvaluation> evaluations;
};

/// True if a variable carries sizes.
bool has_stock(const OptimiseSpec& spec);

/// Every combination of the next smaller and the next larger size round the optimum (the nearest
/// 64 of them) is evaluated with the other variables as they are; in the order feasible first, then
/// by objective or violation, the first 8 have their other variables optimised again. The same is
/// done with the combinations that are at most one step in each size from the best feasible one,
/// until none is better. Then each size is held further and further away with the other sizes of
/// any value, as long as that is better than the best combination, and the combinations round it
/// are tried: where goals are convex none is left that is better. It ends as well where more
/// designs were evaluated than the job allows a search.
StockOutcome search_stock(const Campaign& campaign, const EvaluationBook& known, const Pose& pose,
                          const Candidate& optimum);

// Towards the optimum of full accuracy, with a handful of full evaluations.

struct VerificationOutcome {
  VerificationLoop report;
  /// Best design with its values at full accuracy; nothing where full accuracy has none.
  std::optional<Candidate> best;
  Pose pose;  ///< with the correction that holds there
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

// What the ends of the starts are worth: which design is the answer, and whether it is an optimum.

/// A start of an optimisation, from its begin to its end.
struct Start {
  std::unique_ptr<EvaluationBook> book;
  VectorXd from;
  SearchResult result;
};

struct Confirmation {
  int best = -1;       ///< the start whose end is the answer; −1: no design could be evaluated
  bool holds = false;  ///< the answer keeps its bounds and meets the test of an optimum
  bool confirmed = false;  ///< ... and so does a second search that knew nothing of the first
  std::string message;     ///< which one, with the figures
};

/// The answer is the best design of all that the starts evaluated: where a search passed by it, it
/// goes on from there. Where no other start ends at the same objective, and the answer does not
/// stand out among the designs round it, a fresh search from beside the answer, scaled there, must
/// come back to it; where it finds a better design, that is the answer, and the same is asked of
/// it. Each search spends what the start's own left of the evaluations. All ends are weighed in the
/// scales of the answer, which become the campaign's.
Confirmation confirm(Campaign& campaign, std::vector<Start>& starts);

/// Whether the first-order conditions at a design are those of a strict local optimum, by what the
/// book knows: where multipliers leave directions free, designs that it evaluated span them, and
/// the Lagrangian is larger at all that are near. False where that is not known.
bool stands_out(EvaluationBook& book, const Pose& pose, const Candidate& at);

/// A design beside one in the box, away from the bounds that it is at, to begin a fresh search
/// from.
VectorXd beside(EvaluationBook& book, const Pose& pose, const Candidate& at);

// What an optimum says of its design: whether it is one, its constraints, sensitivities, and paths.

/// What the stages hand on: the design that is the answer, and how it was posed.
struct Chosen {
  Pose pose;
  Candidate best;
  std::vector<double> multipliers;  ///< multipliers of the goals 1, 2, …; empty where unknown
};

/// Parameters, objective, constraints and status of the answer, where it is feasible
/// `if_feasible`.
void judge(const DesignProblem& problem, const Scales& scales, const Chosen& answer,
           OptimumStatus if_feasible, Optimum& optimum);

/// The violated constraints, the worst first, in words with their figures.
std::string violated_words(const std::vector<ConstraintState>& constraints, const Scales& scales);

/// What stands against a feasible design at the least violated one, in words with the figures: the
/// constraints (and bounds of variables) with a multiplier in its first-order conditions, which
/// cannot be met together near it, where these are known (then kept as its conflict); else those
/// that are violated.
std::string what_stops(EvaluationBook& book, const Scales& scales, const Chosen& answer,
                       Optimum& optimum);

/// Sensitivities of the objective and the active constraints, and multipliers of the constraints,
/// at the answer: from the derivatives of all goals there.
void add_derivatives(EvaluationBook& book, const Chosen& answer, Optimum& optimum);

/// Request for the same path with shapes, for drawing.
StrokeRequest drawn(StrokeRequest request);

/// The optimum's path by the job's model, drawn, and the verification; `own`: its values there.
void add_paths(const DesignProblem& problem, const Variables& variables, const DesignValues& own,
               int threads, Optimum& optimum);

}  // namespace flexopt
