#include "core/equilibrium/stroke_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "core/equilibrium/free_motions.hpp"
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

double present_stroke(const System& system) { return present_strokes(system)[0]; }

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

}  // namespace

Equilibrium solve_equilibrium(System& system, double stroke, const NewtonOptions& options) {
  return solve_equilibrium(system, std::optional<VectorXd>(VectorXd::Constant(1, stroke)), options);
}

namespace {

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
      // the step is known: with it the state is as good as the loads are
      if (!stalled && size > as_good_as_none) {
        system.move(equations.motion(x));
        if (equations.conditions() > 0) system.add_to_multipliers(equations.multipliers(x));
        system.assemble();
      }
      return result;
    }
    if (result.step > 2 || it == options.max_iterations) {
      result.message = fmt::format(
          "Newton stopped after {} iterations: step {:.1e} > {:.1e} (lengths / L), leaf correction "
          "{:.1e}",
          it, result.step, options.tolerance, system.correction());
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

// From parameter 0 to 1 with `solve(parameter)`, halving the step when it fails; after two steps in
// succession a halving is taken back. `way`: whether there is one; else a shorter step is the same
// one.
template <class Solve>
Equilibrium step_parameter(System& system, const NewtonOptions& options, const char* what,
                           bool drive_held, bool way, const Solve& solve) {
  System::Snapshot good = system.save();
  double reached = 0, step = 1;
  Overstretched overstretched;
  const int most_halvings = way ? options.max_halvings : 0;
  int halvings = 0, far = 0, sub_steps = 0, in_succession = 0, negative = -1;
  bool halved = false;
  double strain = 0;  // of the last good state
  Equilibrium result;
  while (reached < 1) {
    if (negative < 0) {
      system.assemble();
      negative = negative_pivots(system, drive_held);
      strain = system.strain();
    }
    const double target = std::min(1.0, reached + step);  // powers of two: 1 is met exactly
    double failed = target;
    result = solve(target);
    int now = 0;
    if (result.converged || result.stretched) {
      now = negative_pivots(system, drive_held);
      if (system.strain() > largest_strain) {
        result.converged = false;
        result.message = stretch_message(system.strain());
        result.beyond_reach =
            now <= negative && overstretched.is_believed(reached, target, system.strain());
      } else if (now > negative && way && halvings + 4 < options.max_halvings) {
        result.converged = false;  // another branch? believed only if short steps lead there too
      }
    }
    if (result.converged) {
      ++sub_steps;
      const bool ends =
          halved && target < 1 && ends_stretched(reached, strain, target, system.strain());
      reached = target;
      negative = now;
      strain = system.strain();
      if (reached < 1) good = system.save();
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
      result.message =
          way ? fmt::format("no equilibrium between {:.4g} and {:.4g} of the {} step: {}", reached,
                            failed, what, result.message)
              : fmt::format("no equilibrium: {}", result.message);
      break;
    }
    step /= 2;
    halved = true;
    in_succession = 0;
  }
  result.sub_steps = std::max(sub_steps, 1);
  return result;
}

}  // namespace

namespace {
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
  bool way = false;
  for (Eigen::Index k = 0; k < strokes.size(); ++k) {
    const bool turns =
        is_rotation(system.mechanism().drives[static_cast<std::size_t>(k)].direction);
    way = way || std::abs(strokes[k] - start[k]) > 1e-14 * (turns ? 1 : system.length());
  }
  Equilibrium result = step_parameter(system, options, "stroke", true, way, [&](double s) {
    return solve_equilibrium(
        system, std::optional<VectorXd>(s == 1 ? strokes : VectorXd(start + s * (strokes - start))),
        options);
  });
  if (!result.converged)
    result.message =
        way ? fmt::format("stroke {} to {}: {}", listed(start), listed(strokes), result.message)
            : fmt::format("stroke {}: {}", listed(strokes), result.message);
  return result;
}

Equilibrium step_to(System& system, double stroke, const NewtonOptions& options) {
  return step_to(system, VectorXd::Constant(1, stroke), options);
}

Equilibrium step_load(System& system, LoadFactors to, const NewtonOptions& options) {
  const LoadFactors from = system.load_factors();
  const bool driven = system.loads().driven();
  const std::optional<VectorXd> strokes =
      driven ? std::optional(present_strokes(system)) : std::nullopt;
  return step_parameter(system, options, "load", driven, !(from == to), [&](double s) {
    system.apply(s == 1 ? to
                        : LoadFactors{from.constant + s * (to.constant - from.constant),
                                      from.growing + s * (to.growing - from.growing)});
    return solve_equilibrium(system, strokes, options);
  });
}

}  // namespace flexopt
