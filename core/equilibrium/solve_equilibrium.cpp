#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/equilibrium/free_motions.hpp"
#include "core/equilibrium/newton_equations.hpp"
#include "core/equilibrium/stroke_path.hpp"
#include "core/math/work_limit.hpp"

namespace flexopt {
namespace {

constexpr double violation_weight = 1e4;
// A last step below that [lengths / L] is not made: it is rounding, or next to it.
constexpr double as_good_as_none = 1e-12;
// After a longer one [lengths / L] the tangent is assembled once more.
constexpr double longest_last_step = 1e-5;

// Whether the joints' conditions, and the strokes' if they are held, do not depend on each other at
// this state.
Check check_conditions(const System& system, bool driven) {
  const int drives = static_cast<int>(system.drives().size());
  const int wanted = static_cast<int>(system.size() - system.held().size()) -
                     system.constraints().joints() - (driven ? drives : 0);
  const int free = FreeMotions(system, driven ? DriveHold::all : DriveHold::none).count();
  if (free == wanted) return {};
  return Because(fmt::format("{} of the conditions of joints{} repeat others here (a dead point)",
                             free - wanted, driven ? " and stroke" : ""));
}

// What tells early that Newton's method will not end at a state within reach. Strains of flexures
// at work are below largest_strain, those of first iterates up to 0.5 times the square of the step.
// Reduced leaves that are thrown too far may reach, by shorter steps, states that full leaves do
// not have: a first iterate says nothing about those.
class Prospect {
 public:
  explicit Prospect(const System& system) : full_(system.all_full()) {}

  // Looks at an iteration; fills in how it ends, false where it goes on.
  bool ends(const System& system, Equilibrium& result) {
    const int iteration = result.iterations;
    const double step = result.step, strain = system.strain(),
                 before = std::exchange(strain_, strain);
    steps_.push_back(step);
    if (full_ && iteration == 1 && strain > 25 * largest_strain) {
      result.too_far = true;
      result.message =
          fmt::format("the first iterates stretch a leaf by {:.3g} > {:.3g}: beyond its reach",
                      strain, largest_strain);
      return true;
    }
    if (iteration < 2) return false;
    if (std::abs(strain - before) < 0.05 * strain && step < 0.05 && strain > 2 * largest_strain) {
      result.stretched = true;
      result.message = stretch_message(strain);
      return true;
    }
    if ((iteration < 4 || strain <= 10 * largest_strain) && !stands_still(step)) return false;
    result.message = fmt::format(
        "Newton makes no progress after {} iterations: step {:.1e} (lengths / L), "
        "a leaf stretched by {:.3g}",
        iteration, step, strain);
    return true;
  }

 private:
  // Whether the steps of late are no shorter than those before.
  bool stands_still(double step) const {
    constexpr int window = 8;
    if (static_cast<int>(steps_.size()) <= window || step < 1e-3) return false;
    const auto recent = steps_.end() - window;
    const double least = *std::min_element(steps_.begin(), recent);
    return *std::min_element(recent, steps_.end()) > 0.5 * least;
  }

  bool full_;
  std::vector<double> steps_;
  double strain_ = 0;
};

// Drives that are free carry no load: their multipliers go to zero.
void unload_drives(const System& system, NewtonEquations& equations) {
  for (int j = system.constraints().joints(); j < equations.conditions(); ++j)
    equations.right_side()[equations.first_condition() + j] =
        -system.multipliers()[j] / equations.reaction()[j];
}

VectorXd loads_of_drives(const System& system, const NewtonEquations& equations,
                         const VectorXd& x) {
  VectorXd loads = VectorXd::Zero(system.drives().size());
  equations.read_loads(x, loads);
  if (equations.conditions() == 0) return loads;
  const VectorXd multipliers = system.multipliers() + equations.multipliers(x);
  for (std::size_t k = 0; k < system.drives().size(); ++k)
    if (const auto& row = system.drives()[k].condition)
      loads[static_cast<Eigen::Index>(k)] = -multipliers[*row];
  return loads;
}

}  // namespace

Equilibrium solve_equilibrium(System& system, const std::optional<VectorXd>& strokes,
                              const NewtonOptions& options) {
  Equilibrium result;
  NewtonEquations equations(system, strokes ? DriveHold::all : DriveHold::none);
  system.assemble();
  if (equations.conditions() > 0) {
    result.message = why_not(check_conditions(system, strokes.has_value()));
    if (!result.message.empty()) return result;
  }
  const auto advance = [&](const VectorXd& x) {
    system.move(equations.motion(x));
    if (equations.conditions() > 0) system.add_to_multipliers(equations.multipliers(x));
    system.assemble();
  };
  double previous = 0;
  Prospect prospect(system);
  for (int it = 0;; ++it) {
    count_iteration();
    equations.assemble(system.load() - system.internal_force(), strokes);
    const double violation = equations.violation();
    if (!strokes) unload_drives(system, equations);
    const VectorXd x = equations.solve();
    result.step = equations.step(x);
    // steps within the tolerance, conditions far within it: they must not drift
    const double size = std::max({result.step, system.correction(), violation_weight * violation});
    result.iterations = it;
    if (!std::isfinite(size)) {
      result.message = fmt::format("Newton met a singular tangent in iteration {}", it + 1);
      return result;
    }
    // rounding holds the last digits: a small step that no longer shrinks is the end too
    const bool stalled = it > 1 && size < 1e-6 && size > 0.3 * previous;
    if (it > 0 && (size < options.tolerance || stalled)) {
      result.converged = true;
      result.drive_loads = loads_of_drives(system, equations, x);
      if (result.drive_loads.size() > 0) result.drive_load = result.drive_loads[0];
      // The step is known: with it the state is as good as the loads are. After a long one, as that
      // of a leaf that is merely pulled, the tangent still has the linearised stress.
      if (!stalled && (size > as_good_as_none || previous > longest_last_step)) advance(x);
      return result;
    }
    if (result.step > 2 || it == options.max_iterations) {
      const bool inside = system.correction() > result.step;
      result.message =
          fmt::format("Newton stopped after {} iterations: {} {:.1e} > {:.1e} (lengths / L)", it,
                      inside ? "the step inside a leaf is" : "step",
                      inside ? system.correction() : result.step, options.tolerance);
      return result;
    }
    if (prospect.ends(system, result)) return result;
    previous = size;
    advance(x);
  }
}

}  // namespace flexopt
