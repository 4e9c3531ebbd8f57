#pragma once
// The box of errors of assembly that a job states, by coordinates z, each −1 … 1.
#include <functional>
#include <string>
#include <vector>

#include "core/math/types.hpp"
#include "core/response/stroke_gradients.hpp"
#include "optim/job/job.hpp"
#include "optim/problem/goals.hpp"

namespace flexopt {

class AssemblyBox {
 public:
  explicit AssemblyBox(const AssemblyTolerances& spec);

  /// How many errors may differ from zero.
  int size() const { return static_cast<int>(entries_.size()); }
  /// Assembly errors at z: one for each edge that has some.
  std::vector<AssemblyError> errors(const VectorXd& z) const;
  /// The request with the errors at z in addition to its own.
  StrokeRequest with_errors(StrokeRequest request, const VectorXd& z) const;
  /// Directions along every coordinate of the box, for derivatives.
  std::vector<MechanismDirection> directions(const Mechanism& mechanism) const;

 private:
  struct Entry {
    int leaf, end, axis;
    bool turn;
    double size;
  };
  std::vector<Entry> entries_;
};

// Places in the box [−1, 1]ⁿ at which each of many numbers is largest. The numbers are evaluated
// together, and share the places that are visited.

/// The numbers at one place z of the box.
struct BoxLook {
  VectorXd values;
  MatrixXd rates;  ///< numbers × n
};
using LookInBox = std::function<Answer<BoxLook, Why>(const VectorXd& z)>;

struct BoxSearch {
  int size = 0;    ///< n
  int starts = 4;  ///< the middle and points of a Sobol sequence
  unsigned seed = 1;
  int places = 1;  ///< how many of each number are wanted
};

struct WorstPlaces {
  /// For each number, the place where it is largest, then other local maxima that were found, in
  /// descending order; at least one, at most `BoxSearch::places`.
  std::vector<std::vector<VectorXd>> places;
};

/// Searches the worst places from the starts and from the corners to which the derivatives there
/// point (of a box of up to four sides, all corners). Where the best of these is no local maximum:
/// SLSQP from there, from its end with single sides at their bounds if that is worse, and Newton
/// steps where it ends inside. The maxima are local; the global one is not guaranteed. `kinds`: of
/// each number; numbers of one kind are compared with the largest of them to decide whether a slope
/// counts as zero. None where a place has no numbers.
Answer<WorstPlaces, Why> worst_places(const BoxSearch& search,
                                      const std::vector<std::size_t>& kinds, const LookInBox& look);

// Goals that count at the worst errors of assembly in a box. Each value, at every point of the
// stroke and in every load case, is that at its own worst place z*(p) in the box:
//     V(p) = max over z of v(z, p),    ∂V/∂p = ∂v/∂p at z*                                   (V3)
// because z* is at its bounds, which no parameter moves, or ∂v/∂z is zero there.

class WorstAssemblyGoals {
 public:
  /// Gives the goals in question their candidates at each point (Goal::branches): values at other
  /// places in the box that are as bad or nearly so, where `places` is more than one. The job has
  /// a box.
  WorstAssemblyGoals(const Job& job, std::vector<Goal>& goals, int places);

  /// What the goals ask of a load case of the job; no outputs where they ask nothing.
  StrokeRequest request(const Job& job, std::size_t load_case) const;
  /// Values of the design, with derivatives by its parameters where these are asked for.
  using Evaluate = std::function<StrokeSensitivity(const StrokeRequest&, bool gradient)>;
  struct Design {
    const Mechanism& mechanism;
    const ModelOptions& model;
    const std::vector<StrokeRequest>& requests;  ///< requests of all load cases
    const ParameterValues& parameters;           ///< that formulas use
    /// Derivatives along the errors are exact; else central differences.
    bool exact = false;
  };
  /// Readings as of all goals; empty of others.
  Answer<std::vector<GoalReading>, Why> read(const Design& design, const Evaluate& evaluate,
                                             bool gradient) const;

 private:
  /// One number of a goal: its value at a point of the stroke of a load case.
  struct Number {
    std::size_t goal = 0, load_case = 0, point = 0;
  };
  Answer<BoxLook, Why> look(const Design& design, const Evaluate& evaluate,
                            const VectorXd& z) const;
  /// All numbers from the paths at z that `evaluate` gives for the load cases that the goals ask
  /// for.
  Answer<BoxLook, Why> values_at(
      const Design& design, const VectorXd& z,
      const std::function<StrokeSensitivity(const StrokeRequest&)>& evaluate) const;
  /// Adds the candidates of a point, the worst first.
  void add_candidates(std::size_t goal, const std::vector<const GoalReading*>& readings,
                      std::size_t point, GoalReading& whole) const;

  AssemblyBox box_;
  BoxSearch search_;
  std::vector<std::string> cases_;  ///< their names; of a job without several, one without
  std::vector<Goal> plain_;
  std::vector<std::size_t> which_;  ///< goals in question
  std::vector<int> candidates_;     ///< candidates of every goal at a point
  std::vector<Number> numbers_;     ///< goal by goal, load case by load case
};

}  // namespace flexopt
