#include "core/equilibrium/stroke_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "core/equilibrium/continuity.hpp"
#include "core/equilibrium/free_motions.hpp"
#include "core/equilibrium/held_meanwhile.hpp"
#include "core/equilibrium/newton_equations.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"
#include "core/math/work_limit.hpp"

namespace flexopt {

VectorXd present_strokes(const System& system) {
  const Mechanism& m = system.mechanism();
  VectorXd strokes(static_cast<Eigen::Index>(m.drives.size()));
  for (std::size_t k = 0; k < m.drives.size(); ++k) {
    const Drive& drive = m.drives[k];
    const auto body = [&](int b) -> JointBody {
      if (b < 0) return {};
      return {system.pose(b).position, system.pose(b).rotation, m.bodies[b].reference};
    };
    strokes[static_cast<Eigen::Index>(k)] =
        drive_stroke<double>(drive, body(drive.body), body(drive.other)).value;
  }
  return strokes;
}

int negative_pivots(const System& system, bool drives_held) {
  if (system.constraints().count() > 0 || system.analyses())
    return system.negative_pivots() + FreeMotions(system, drives_held).negative_pivots();
  const MatrixXd K = system.tangent_stiffness();
  const VectorXd s = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  MatrixXd H = s.asDiagonal() * K * s.asDiagonal();
  if (drives_held)  // a decoupled positive one in the place of each drive
    for (const int d : system.driven_coordinates()) {
      H.row(d).setZero();
      H.col(d).setZero();
      H(d, d) = 1;
    }
  return system.negative_pivots() +
         static_cast<int>((symmetric_eigenvalues(H).array() < 0).count());
}

namespace {

constexpr double violation_weight = 1e4;
// A last step below that [lengths / L] is not made: it is rounding, or next to it.
constexpr double as_good_as_none = 1e-12;
// After a longer one [lengths / L] the tangent is assembled once more.
constexpr double longest_last_step = 1e-5;

// What is wrong where the joints' conditions, and the strokes' if they are held, depend on each
// other at this state; empty if they do not.
std::string dependence(const System& system, bool driven) {
  const int drives = static_cast<int>(system.drives().size());
  const int wanted = static_cast<int>(system.size() - system.held().size()) -
                     system.constraints().joints() - (driven ? drives : 0);
  const int free = FreeMotions(system, driven).count();
  if (free == wanted) return {};
  return fmt::format("{} of the conditions of joints{} repeat others here (a dead point)",
                     free - wanted, driven ? " and stroke" : "");
}

// What tells early that Newton's method will not end at a state within reach. Strains of flexures
// at work are below largest_strain, those of first iterates up to 0.5 times the square of the step.
// Where reduced leaves are thrown too far, shorter steps may lead to states that are none of the
// full leaves': of those a first iterate says nothing.
class Prospect {
 public:
  enum class Says { go_on, too_far, stretched, no_progress };
  explicit Prospect(const System& system) : full_(system.all_full()) {}

  Says look(int iteration, double step, double strain) {
    steps_.push_back(step);
    const double before = std::exchange(strain_, strain);
    if (full_ && iteration == 1 && strain > 25 * largest_strain) return Says::too_far;
    if (iteration < 2) return Says::go_on;
    const bool settled = std::abs(strain - before) < 0.05 * strain && step < 0.05;
    if (settled && strain > 2 * largest_strain) return Says::stretched;
    if (iteration >= 4 && strain > 10 * largest_strain) return Says::no_progress;
    if (iteration < window || step < 1e-3) return Says::go_on;
    const auto recent = steps_.end() - window;
    const double least = *std::min_element(steps_.begin(), recent);
    return *std::min_element(recent, steps_.end()) > 0.5 * least ? Says::no_progress : Says::go_on;
  }

 private:
  static constexpr int window = 8;
  bool full_;
  std::vector<double> steps_;
  double strain_ = 0;
};

std::string stretch_message(double strain) {
  return fmt::format("a leaf is stretched by {:.3g} > {:.3g}: beyond its reach", strain,
                     largest_strain);
}

// Fills in how it ends; false where it goes on.
bool give_up(Prospect::Says says, const System& system, Equilibrium& result) {
  switch (says) {
    case Prospect::Says::go_on:
      return false;
    case Prospect::Says::too_far:
      result.too_far = true;
      result.message =
          fmt::format("the first iterates stretch a leaf by {:.3g} > {:.3g}: beyond its reach",
                      system.strain(), largest_strain);
      break;
    case Prospect::Says::stretched:
      result.stretched = true;
      result.message = stretch_message(system.strain());
      break;
    case Prospect::Says::no_progress:
      result.message = fmt::format(
          "Newton makes no progress after {} iterations: step {:.1e} (lengths / L), "
          "a leaf stretched by {:.3g}",
          result.iterations, result.step, system.strain());
      break;
  }
  return true;
}

// Drives that are free carry no load: their multipliers go to zero.
void unload_drives(const System& system, NewtonEquations& equations) {
  for (int j = system.constraints().joints(); j < equations.conditions(); ++j)
    equations.right_side()[equations.first_condition() + j] =
        -system.multipliers()[j] / equations.reaction()[j];
}

VectorXd loads_of_drives(const System& system, const NewtonEquations& equations,
                         const VectorXd& x) {
  VectorXd loads = VectorXd::Zero(static_cast<Eigen::Index>(system.drives().size()));
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
  NewtonEquations equations(system, strokes.has_value());
  system.assemble();
  if (equations.conditions() > 0) {
    result.message = dependence(system, strokes.has_value());
    if (!result.message.empty()) return result;
  }
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
      if (!stalled && (size > as_good_as_none || previous > longest_last_step)) {
        system.move(equations.motion(x));
        if (equations.conditions() > 0) system.add_to_multipliers(equations.multipliers(x));
        system.assemble();
      }
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
    if (give_up(prospect.look(it, result.step, system.strain()), system, result)) return result;
    previous = size;
    system.move(equations.motion(x));
    if (equations.conditions() > 0) system.add_to_multipliers(equations.multipliers(x));
    system.assemble();
  }
}

namespace {

// Stable states in which a leaf is stretched too far. One of them may lie on another branch, where
// a long step has landed. They are believed to lie on the way once the step is halved and still
// ends in one, of a smaller stretch, or once a step from half as far ends in the same.
class Overstretched {
 public:
  bool is_believed(double from, double target, double strain) {
    constexpr double same = 1e-3;
    const bool shrinks = from == from_ && target < target_ && strain < strain_;
    const auto [before, first] = seen_.try_emplace(target, strain);
    const bool again = !first && std::abs(strain - before->second) < same * before->second;
    from_ = from;
    target_ = target;
    strain_ = strain;
    return shrinks || again;
  }

 private:
  double from_ = -1, target_ = 0, strain_ = 0;  // of the last one
  std::map<double, double> seen_;               // by their targets
};

// Whether the stretch, which grows from state to state, is far beyond its limit at parameter 1.
bool ends_stretched(double before, double strain_before, double reached, double strain) {
  constexpr double near = 0.5, far = 4;
  const double slope = (strain - strain_before) / (reached - before);
  return strain > near * largest_strain && strain + slope * (1 - reached) > far * largest_strain;
}

// A step of a way is taken for one along its branch up to this departure().
constexpr double largest_departure = 0.05;
// A way that takes more steps is taken for lost.
constexpr int most_steps = 2000;
// So many of the bifurcations on a way are named.
constexpr int named_crossings = 3;

// A way of parameter 0 to 1.
struct Way {
  const char* what;
  bool drive_held;
  bool moves;      ///< else a shorter step is the same one
  bool assembles;  ///< errors of assembly grow on it
  std::function<Equilibrium(double)> solve;
  /// At an equilibrium.
  std::function<BranchState()> state;
  std::function<std::string(double)> name;  ///< of a parameter, for messages
};

// Halves the step when it fails; after two steps in succession a halving is taken back.
Equilibrium follow(System& system, const NewtonOptions& options, const Way& way) {
  System::Snapshot good = system.save();
  double reached = 0, step = 1;
  Overstretched overstretched;
  // A step is halved so often where Newton's method fails; beside a bifurcation, where the branch
  // of an imperfect mechanism turns sharply, more often. Where errors of assembly grow, a change of
  // stability is accepted after few halvings: a long step then lands on the unstable state of the
  // perfect mechanism, which tells that the errors buckle a leaf.
  const int fewest_halvings = way.moves ? options.max_halvings : 0;
  const int near_bifurcations = fewest_halvings + (way.moves ? 12 : 0);
  const int most_for_stability = fewest_halvings + (way.assembles ? -4 : way.moves ? 4 : 0);
  int most_halvings = fewest_halvings;
  int halvings = 0, far = 0, sub_steps = 0, in_succession = 0, negative = -1;
  int before_crossing = -1;  // halvings where one was first seen
  bool halved = false;
  double strain = 0;  // of the last good state
  BranchState here;   // likewise
  BranchState origin;
  std::string crossings;
  int crossed = 0;
  bool turns_sharply = false;
  Equilibrium result;
  while (reached < 1) {
    if (negative < 0) {
      system.assemble();
      negative = negative_pivots(system, way.drive_held);
      strain = system.strain();
      if (way.moves) origin = here = way.state();
    }
    const double target = std::min(1.0, reached + step);  // powers of two: 1 is met exactly
    double failed = target;
    result = way.solve(target);
    int now = 0;
    BranchState there;
    if (result.converged || result.stretched) {
      now = negative_pivots(system, way.drive_held);
      if (system.strain() > largest_strain) {
        result.converged = false;
        result.message = stretch_message(system.strain());
        result.beyond_reach =
            now <= negative && overstretched.is_believed(reached, target, system.strain());
      } else if (way.moves) {
        there = way.state();
        const double off = departure(origin, here, there, target - reached, system);
        const bool crosses = now != negative;
        if (!(off <= largest_departure) || (crosses && halvings < most_for_stability)) {
          if (crosses && before_crossing < 0) before_crossing = halvings;
          most_halvings = near_bifurcations;
          turns_sharply = turns_sharply || (!crosses && halvings >= 2);
          result.converged = false;
          result.left_branch = true;
          result.message = fmt::format(
              "the equilibrium found there is not on the branch of the one before: off by {:.2g}",
              off);
        }
      }
    }
    if (result.converged) {
      ++sub_steps;
      const bool ends =
          halved && target < 1 && ends_stretched(reached, strain, target, system.strain());
      if (now != negative && ++crossed <= named_crossings)
        crossings += fmt::format(
            "{}stability is {} between {} {} and {}", crossings.empty() ? "" : "; ",
            now > negative ? "lost" : "regained", way.what, way.name(reached), way.name(target));
      if (before_crossing >= 0 && (now != negative || halvings <= before_crossing)) {
        // what lies behind it needs no shorter steps than what lay before it
        step *= std::exp2(halvings - before_crossing);
        halvings = before_crossing;
        in_succession = 0;
        before_crossing = -1;
      }
      if (before_crossing < 0 && halvings <= fewest_halvings) most_halvings = fewest_halvings;
      reached = target;
      negative = now;
      strain = system.strain();
      here = std::move(there);
      if (reached < 1) good = system.save();
      if (reached < 1 && sub_steps == most_steps) {
        result.converged = false;
        result.message = fmt::format("no equilibrium beyond {:.7g} of the {} step: {} steps taken",
                                     reached, way.what, most_steps);
        break;
      }
      if (!ends) {
        if (++in_succession == 2 && halvings > 0) {
          in_succession = 0;
          --halvings;
          step *= 2;
        }
        continue;
      }
      failed = 1;
      result.converged = false;
      result.beyond_reach = true;
      result.message =
          fmt::format("a leaf, stretched by {:.3g}, comes to more than {:.3g}: beyond its reach",
                      strain, largest_strain);
    }
    system.restore(good);
    // a step that is seen to be too long at once costs next to nothing
    int& counted = result.too_far && far < most_halvings ? far : halvings;
    if (++counted > most_halvings || result.beyond_reach) {
      system.assemble();
      // leaves that are pulled straight are at the end of their reach, whatever ends the way
      result.left_branch = result.left_branch && strain < 0.05 * largest_strain;
      result.message = way.moves ? fmt::format(
                                       "no equilibrium between {:.7g} and {:.7g} of the {} "
                                       "step: {}",
                                       reached, failed, way.what, result.message)
                                 : fmt::format("no equilibrium: {}", result.message);
      break;
    }
    step /= 2;
    halved = true;
    in_succession = 0;
  }
  result.sub_steps = std::max(sub_steps, 1);
  if (crossed > named_crossings)
    crossings += fmt::format("; and {} changes more", crossed - named_crossings);
  result.crossings = std::move(crossings);
  result.turns_sharply = turns_sharply;
  return result;
}

std::string listed(const VectorXd& strokes) {
  std::string text;
  for (Eigen::Index k = 0; k < strokes.size(); ++k)
    text +=
        fmt::format("{}{:.6g}", k == 0 ? "" : ", ", std::abs(strokes[k]) < 1e-14 ? 0 : strokes[k]);
  return strokes.size() == 1 ? text : "(" + text + ")";
}
}  // namespace

Equilibrium step_to(System& system, const VectorXd& strokes, const NewtonOptions& options) {
  const VectorXd start = present_strokes(system);
  bool moves = false;
  for (Eigen::Index k = 0; k < strokes.size(); ++k) {
    const bool turns =
        is_rotation(system.mechanism().drives[static_cast<std::size_t>(k)].direction);
    moves = moves || std::abs(strokes[k] - start[k]) > 1e-14 * (turns ? 1 : system.length());
  }
  const VectorXd growth = strokes - start;
  const auto at = [&](double p) { return p == 1 ? strokes : VectorXd(start + p * growth); };
  const Way along{
      .what = "stroke",
      .drive_held = true,
      .moves = moves,
      .assembles = false,
      .solve = [&](double p) { return solve_equilibrium(system, std::optional(at(p)), options); },
      .state = [&] { return branch_state_of_strokes(system, growth); },
      .name = [&](double p) { return listed(at(p)); }};
  Equilibrium result = follow(system, options, along);
  if (!result.converged)
    result.message =
        moves ? fmt::format("stroke {} to {}: {}", listed(start), listed(strokes), result.message)
              : fmt::format("stroke {}: {}", listed(strokes), result.message);
  return result;
}

Equilibrium step_load(System& system, LoadFactors to, const NewtonOptions& options) {
  const LoadFactors from = system.load_factors();
  const bool driven = system.loads().driven();
  const std::optional<VectorXd> strokes =
      driven ? std::optional(present_strokes(system)) : std::nullopt;
  const LoadFactors growth{to.constant - from.constant, to.growing - from.growing};
  const auto at = [&](double p) {
    return p == 1 ? to
                  : LoadFactors{from.constant + p * growth.constant,
                                from.growing + p * growth.growing};
  };
  const Way along{.what = "load",
                  .drive_held = driven,
                  .moves = !(from == to),
                  .assembles = growth.constant != 0 && !system.loads().assembly.empty(),
                  .solve =
                      [&](double p) {
                        system.apply(at(p));
                        return solve_equilibrium(system, strokes, options);
                      },
                  .state = [&] { return branch_state_of_loads(system, growth, driven); },
                  .name =
                      [&](double p) {
                        const LoadFactors f = at(p);
                        return fmt::format("{:.6g}", growth.growing == 0 ? f.constant : f.growing);
                      }};
  Equilibrium result = follow(system, options, along);
  if (!result.converged) result.message += held_meanwhile(system);
  return result;
}

}  // namespace flexopt
