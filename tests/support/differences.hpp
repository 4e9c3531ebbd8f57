#pragma once
// The same number of a mechanism found in two ways: what differs by more than it may is wrong.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace flexopt {

/// One law looked at on one job.
struct Difference {
  enum class End {
    skipped,    ///< the job has not what the law is about
    no_answer,  ///< one of the evaluations ended with a status, or at no point stable in both
    kept,
    broken
  };
  std::string law;
  End end = End::skipped;
  double error = 0;      ///< over what it may be: above 1 it is broken
  std::string what;      ///< the number that differs most, with both values
  std::string message;   ///< of an evaluation without an answer
  nlohmann::json other;  ///< the job that the other way ran
};

/// What is looked at: all laws, or full accuracy and every third other one, by turns.
enum class Laws { all, quick };

/// How the job itself ended ("refused", "ok", "no_equilibrium", …) and what the laws say of it.
struct Differences {
  std::string status, message;
  double seconds = 0;  ///< of its evaluation, by processor time
  int points = 0, leaves = 0, full_leaves = 0;
  std::vector<Difference> laws;
};

/// Evaluates a job of random_own_job() and looks at:
///   full accuracy         every number as on full leaves
///   drives raise frequencies, the k-th with d of them held no further than to the (k + d)-th
///   alone                 the last point without the others
///   other order           the points from last to first
///   more points           two more on the way to each
///   load in steps         the end of a load path of two points and of eight
///   stiffness, stroke     drive stiffness against differences of the load along its stroke
///   compliance, load      compliance at O, drives held, against motions under a small load
///   closed way            work of two drives around a rectangle of their strokes
///   spring for drive      a drive as a stiff spring that is pulled
///   springs for held      held directions as stiff springs
///   cut leaf              a leaf as two halves
///   turned, mirrored, grown
///   warm as a whole       expands without stress
///   heavy body            frequencies of a body much heavier than the leaves by compliance and
///   mass state space           its modes are the frequencies, its static answer the compliance
///   beam and plate        where all leaves are narrow
///   capacity              a load that is just smaller is carried, one that is just larger is not
///   buckling              likewise, of the factor
/// Points that are unstable, or on another branch, and numbers that an evaluation itself estimates
/// to be as wrong count as answers that were not given.
Differences differences_of(const nlohmann::json& job, unsigned long long seed, Laws laws);

}  // namespace flexopt
