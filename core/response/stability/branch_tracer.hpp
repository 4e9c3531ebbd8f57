#pragma once
// Follows a branch of equilibria under a growing load to where its tangent is singular, or to where
// a limit that is watched is reached: README.md of core/response, (S24), (S25), (S30).
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/mechanism/each_number.hpp"
#include "core/response/response.hpp"
#include "core/response/stability/load_branch.hpp"
#include "core/response/stability/softening.hpp"

namespace flexopt {

/// A limit that is watched along a branch beside its tangent. At the equilibrium at which the
/// system stands assembled: below zero within the limit, above beyond it; continuous.
using BranchLimit = std::function<double(System&)>;

class BranchTracer {
 public:
  /// Branch and model must outlive it. `limit`: empty where the tangent alone is watched. `unit`:
  /// what a factor of 1 is [N or N m], where messages are to name loads; else 0.
  BranchTracer(LoadBranch& branch, const ModelOptions& model, BranchLimit limit = {},
               double unit = 0)
      : branch_(&branch),
        model_(&model),
        limit_(std::move(limit)),
        unit_(unit),
        still_(branch.system().mechanism(), {zero_rate(branch.system().mechanism())}) {}

  /// What is linear at a state of the branch.
  struct Look : Softening {
    std::unique_ptr<MechanismFactor> factor;
    std::unique_ptr<StiffnessRate> rate;
    BranchDirection along;  ///< per σ
    double load = 0;        ///< change of the factor that `rate` is for

    double estimate(double at, const SoftMode& mode) const { return at + mode.step * along.factor; }
    /// Distance of the factor from that of the singular state ahead.
    double distance() const { return ahead->step * std::abs(along.factor); }
  };
  /// Linearises where the branch stands, to larger factors (`side` 1) or smaller ones (-1).
  /// `start`, `behind`: as for soften().
  Look look(int side, const VectorXd& start, bool behind = false);

  /// From where the branch stands until its tangent is singular, the limit is reached (the branch
  /// then stands there), or the factor has changed by `bound`.
  CriticalLoad follow(int side, Look first, double bound);
  /// Whether it was the limit that ended the way.
  bool at_limit() const { return at_limit_; }

  /// Whether elastic bodies hold the singular state that was followed to: it deforms them no
  /// further than their degrees hold, and what those of degree 2 leave out of the stiffness of its
  /// mode moves its factor by less than the square of the largest geometric share. The branch
  /// stands there.
  Check check_bodies() const;

  /// What putting the load on says of a factor that follow() found from `begin`.
  struct Trial {
    double stable_to = 0;  ///< the last factor whose equilibrium is stable and within the limit
    std::string doubt;     ///< why the factor is not confirmed; empty if it is
  };
  /// Step by step at given loads, however the branch was followed: just below the factor the
  /// equilibrium is stable and within the limit; just above a singular tangent there is none beside
  /// it that is stable. The branch stands there afterwards.
  Trial put_on(const LoadBranch::State& begin, double factor);

  /// Derivatives of the factor of a singular state that was followed to.
  VectorXd gradient(DesignDirections& design, const MatrixXd& drive_load_rates);

 private:
  struct Stride {
    bool taken = false, stretched = false, crossed = false;
    std::string obstacle;  ///< why not taken; the branch is where it was
  };
  /// The state nearest to a bifurcation that the branch was heading for.
  struct Nearest {
    LoadBranch::State state;
    BranchDirection along;
    VectorXd mode;
    double factor = 0, distance = 0;
    int straight = 0;    ///< as in Heading
    bool tried = false;  ///< whether its other side was looked for
  };
  /// How far the estimates are trusted, by what the last ones were wrong by.
  struct Heading {
    double trust = 0.5;  ///< of the way to the critical state
    double longest = std::numeric_limits<double>::infinity();
    VectorXd mode;  ///< the last that is known
    std::optional<Nearest> nearest;
    int straight = 0;         ///< states in a row whose estimates agree with those before
    bool at_nearest = false;  ///< whether the branch stands there
  };
  Stride stride(const BranchDirection& along, double step);
  Look look_on(int side, Look last, double at, double step, Heading& heading);
  /// `straight`: the branch led straight to it, which makes it no fold.
  CriticalLoad critical_at(double factor, Look here, const VectorXd& mode, bool straight);
  CriticalLoad critical_beside(int side, Nearest nearest);
  void pass_by(Heading& heading, double size);
  CriticalLoad end_at(int side, Look here, double step, const Stride& went, Heading& heading);
  bool close_in(const LoadBranch::State& from, const BranchDirection& along, double step);
  std::string passed_by() const;
  std::string where_it_ended(double factor, bool states_spent) const;
  std::string shown(double factor) const;
  bool stands_within() const;

  double measure(const VectorXd& bodies) const;
  double product(const BranchDirection& a, const BranchDirection& b) const;
  bool crosses(const Look& at);
  bool proves(Nearest& nearest);
  bool turned_away(Heading& heading);
  static bool next_to(const Heading& heading, double size);
  VectorXd nearly_singular_motion(const MechanismFactor& factor, const VectorXd& known) const;
  void weigh_anew(Look& look);

  LoadBranch* branch_;
  const ModelOptions* model_;
  BranchLimit limit_;
  double unit_;
  DesignDirections still_;  ///< a design that does not change
  /// Size of the motions of the bodies by the factor where the branch began, over the longest leaf.
  double first_rate_ = 0, weight_ = 0;
  bool at_limit_ = false;
  std::optional<double> passed_;  ///< estimate of a bifurcation that the branch bends away from
  std::optional<Look> critical_;
};

/// States that equilibria of the branch move through: along the parameters of `residual` (rows of
/// the factor × parameters), the load kept, and, in the last column, along a factor of 1.
/// `drive_load_rates`: of the loads that free drives keep, drives × parameters.
MatrixXd moved_states(const LoadBranch& branch, const MechanismFactor& factor, MatrixXd residual,
                      const MatrixXd& drive_load_rates);

/// Derivatives of the drives' loads where the branch begins, their strokes and the load kept:
/// drives × parameters. Zero where the branch holds the drives, or nothing is `driven`.
MatrixXd drive_load_rates(LoadBranch& branch, const ModelOptions& model, DesignDirections& design,
                          bool driven);

}  // namespace flexopt
