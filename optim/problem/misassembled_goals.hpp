#pragma once
// Goals that count at the worst errors of assembly in a box. Each value, at every point of the
// stroke and in every load case, is that at its own worst place z*(p) in the box:
//     V(p) = max over z of v(z, p),    ∂V/∂p = ∂v/∂p at z*                                   (V3)
// because z* is at its bounds, which no parameter moves, or ∂v/∂z is zero there.
#include <functional>
#include <string>
#include <vector>

#include "optim/problem/assembly_box.hpp"
#include "optim/problem/goals.hpp"
#include "optim/problem/worst_places.hpp"

namespace flexopt {

class MisassembledGoals {
 public:
  /// Gives the goals in question their candidates at each point (Goal::branches): values at other
  /// places in the box that are as bad or nearly so, where `places` is more than one. The job has
  /// a box.
  MisassembledGoals(const Job& job, std::vector<Goal>& goals, int places);

  /// What the goals ask of a load case of the job; no outputs where they ask nothing.
  StrokeRequest request(const Job& job, std::size_t load_case) const;
  /// The goal to which a number belongs, as it is without errors or with given ones.
  const Goal& plain(std::size_t goal) const { return plain_[goal]; }

  /// Values of the design, with derivatives by its parameters where these are asked for.
  using Evaluate = std::function<StrokeSensitivity(const StrokeRequest&, bool gradient)>;
  struct Design {
    const Mechanism& mechanism;
    const ModelOptions& model;
    const std::vector<StrokeRequest>& requests;  ///< of all load cases
    /// Derivatives along the errors are exact; else central differences.
    bool exact = false;
  };
  struct Found {
    bool ok = false;
    std::string message, reason;
    std::vector<GoalReading> goals;       ///< as all goals; empty of others
    std::vector<std::string> parameters;  ///< of the gradients
  };
  Found read(const Design& design, const Evaluate& evaluate, bool gradient) const;

 private:
  /// One number of a goal: its value at a point of the stroke of a load case.
  struct Number {
    std::size_t goal = 0, load_case = 0, point = 0;
  };
  /// All numbers, goal by goal, load case by load case.
  std::vector<Number> numbers() const;
  /// Paths at one place of the box, for all load cases that the goals ask for.
  std::vector<StrokeSensitivity> paths_at(
      const Design& design, const VectorXd& z,
      const std::function<StrokeSensitivity(const StrokeRequest&)>& evaluate) const;
  BoxLook look(const Design& design, const Evaluate& evaluate, const std::vector<Number>& numbers,
               const VectorXd& z) const;
  BoxLook values_at(const std::vector<StrokeSensitivity>& found, const Design& design,
                    const std::vector<Number>& numbers, const VectorXd& z) const;
  /// Why a goal has no value, with the load case where there are several.
  std::string said(const std::string& message, std::size_t load_case) const;
  /// Adds the candidates of a point, the worst first.
  void add_candidates(std::size_t goal, const std::vector<const GoalReading*>& readings,
                      std::size_t point, GoalReading& whole) const;

  AssemblyBox box_;
  BoxSearch search_;
  std::vector<std::string> cases_;  ///< their names; of a job without several, one without
  std::vector<Goal> plain_;
  std::vector<std::size_t> which_;  ///< goals in question
  std::vector<int> candidates_;     ///< of every goal
};

}  // namespace flexopt
