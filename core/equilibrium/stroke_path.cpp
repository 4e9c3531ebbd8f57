#include "core/equilibrium/stroke_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "core/equilibrium/continuity.hpp"
#include "core/equilibrium/free_motions.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {

VectorXd present_strokes(const System& system) {
  const Mechanism& m = system.mechanism();
  VectorXd strokes(m.drives.size());
  for (std::size_t k = 0; k < m.drives.size(); ++k) {
    const Drive& drive = m.drives[k];
    double& stroke = strokes[static_cast<Eigen::Index>(k)];
    stroke = drive_stroke(drive, body_or_ground(system.poses(), drive.body),
                          body_or_ground(system.poses(), drive.other))
                 .value;
    if (is_rotation(drive.direction))
      stroke = unwrapped(stroke, system.constraints().value()[*system.drives()[k].condition]);
  }
  return strokes;
}

int negative_pivots(const System& system, DriveHold held) {
  const int all = system.negative_pivots() + FreeMotions(system, held).negative_pivots();
  return system.follows() ? all % 2 : all;
}

std::string stretch_message(double strain) {
  return fmt::format("a leaf is stretched by {:.3g} > {:.3g}: beyond its reach", strain,
                     largest_strain);
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

// A step of a way is taken for one along its branch up to this departure().
constexpr double largest_departure = 0.05;
// A way that takes more steps is taken for lost.
constexpr int most_steps = 2000;
// So many of the bifurcations on a way are named.
constexpr int named_crossings = 3;

// A way of parameter 0 to 1.
struct Way {
  const char* what;
  DriveHold drive_held;
  bool moves;      ///< else a shorter step is the same one
  bool assembles;  ///< errors of assembly grow on it
  std::function<Equilibrium(double)> solve;
  std::function<BranchState()> state;       ///< at an equilibrium
  std::function<std::string(double)> name;  ///< of a parameter, for messages
};

// An equilibrium of a way.
struct WayPoint {
  double at = 0;  ///< parameter
  int negative_pivots = 0;
  double strain = 0;
  BranchState branch;  ///< where the way moves
};

// Whether the stretch, which grows from point to point, is far beyond its limit at parameter 1.
bool ends_stretched(const WayPoint& before, const WayPoint& here) {
  constexpr double near = 0.5, far = 4;
  const double slope = (here.strain - before.strain) / (here.at - before.at);
  return here.strain > near * largest_strain &&
         here.strain + slope * (1 - here.at) > far * largest_strain;
}

// Halves the step when it fails; after two steps in succession a halving is taken back. A step is
// halved so often where Newton's method fails; beside a bifurcation, where the branch of an
// imperfect mechanism turns sharply, more often. Where errors of assembly grow, a change of
// stability is accepted after few halvings: a long step then lands on the unstable state of the
// perfect mechanism, which tells that the errors buckle a leaf.
class WayFollower {
 public:
  WayFollower(System& system, const NewtonOptions& options, const Way& way)
      : system_(system),
        way_(way),
        good_(system.save()),
        fewest_halvings_(way.moves ? options.max_halvings : 0),
        most_halvings_(fewest_halvings_) {}

  Equilibrium follow();

 private:
  void judge(WayPoint& there);
  void accept(WayPoint there);
  void lengthen();
  bool shorten(double failed);
  void reject(std::string message) {
    result_.converged = false;
    result_.message = std::move(message);
  }

  System& system_;
  const Way& way_;
  System::Snapshot good_;  // at the last point that was accepted
  int fewest_halvings_, most_halvings_, halvings_ = 0, far_ = 0, sub_steps_ = 0, in_succession_ = 0,
                                        crossed_ = 0;
  int before_crossing_ = -1;  // halvings where one was first seen
  double step_ = 1;
  bool halved_ = false, turns_sharply_ = false;
  WayPoint here_;
  BranchState origin_;
  std::string crossings_;
  Overstretched overstretched_;
  Equilibrium result_;
};

Equilibrium WayFollower::follow() {
  system_.assemble();
  here_ = {0, negative_pivots(system_, way_.drive_held), system_.strain(), {}};
  if (way_.moves) origin_ = here_.branch = way_.state();
  while (here_.at < 1) {
    WayPoint there{.at = std::min(1.0, here_.at + step_)};  // powers of two: 1 is met exactly
    double failed = there.at;
    result_ = way_.solve(there.at);
    if (result_.converged || result_.stretched) judge(there);
    if (result_.converged) {
      const bool ends = halved_ && there.at < 1 && ends_stretched(here_, there);
      accept(std::move(there));
      if (here_.at < 1 && sub_steps_ == most_steps) {
        reject(fmt::format("no equilibrium beyond {:.7g} of the {} step: {} steps taken", here_.at,
                           way_.what, most_steps));
        break;
      }
      if (!ends) {
        lengthen();
        continue;
      }
      failed = 1;
      result_.beyond_reach = true;
      reject(fmt::format("a leaf, stretched by {:.3g}, comes to more than {:.3g}: beyond its reach",
                         here_.strain, largest_strain));
    }
    if (!shorten(failed)) break;
  }
  result_.sub_steps = std::max(sub_steps_, 1);
  if (crossed_ > named_crossings)
    crossings_ += fmt::format("; and {} changes more", crossed_ - named_crossings);
  result_.crossings = std::move(crossings_);
  result_.turns_sharply = turns_sharply_;
  return std::move(result_);
}

// Rejects the equilibrium that was found where it is beyond the leaves' reach or off the branch.
void WayFollower::judge(WayPoint& there) {
  there.negative_pivots = negative_pivots(system_, way_.drive_held);
  there.strain = system_.strain();
  if (there.strain > largest_strain) {
    reject(stretch_message(there.strain));
    result_.beyond_reach = there.negative_pivots <= here_.negative_pivots &&
                           overstretched_.is_believed(here_.at, there.at, there.strain);
    return;
  }
  if (!way_.moves) return;
  there.branch = way_.state();
  there.strain = system_.strain();  // that may have moved away and back
  const double off = departure(origin_, here_.branch, there.branch, there.at - here_.at, system_);
  const bool crosses = there.negative_pivots != here_.negative_pivots;
  const int most_for_stability = fewest_halvings_ + (way_.assembles ? -4 : 4);
  if (off <= largest_departure && !(crosses && halvings_ < most_for_stability)) return;
  if (crosses && before_crossing_ < 0) before_crossing_ = halvings_;
  most_halvings_ = fewest_halvings_ + 12;
  turns_sharply_ = turns_sharply_ || (!crosses && halvings_ >= 2);
  result_.left_branch = true;
  reject(fmt::format(
      "the equilibrium found there is not on the branch of the one before: off by {:.2g}", off));
}

void WayFollower::accept(WayPoint there) {
  ++sub_steps_;
  const int more_negative = there.negative_pivots - here_.negative_pivots;
  if (more_negative != 0 && ++crossed_ <= named_crossings)
    crossings_ +=
        fmt::format("{}stability is {} between {} {} and {}", crossings_.empty() ? "" : "; ",
                    more_negative > 0 ? "lost" : "regained", way_.what, way_.name(here_.at),
                    way_.name(there.at));
  if (before_crossing_ >= 0 && (more_negative != 0 || halvings_ <= before_crossing_)) {
    // what lies behind it needs no shorter steps than what lay before it
    step_ *= std::exp2(halvings_ - before_crossing_);
    halvings_ = before_crossing_;
    in_succession_ = 0;
    before_crossing_ = -1;
  }
  if (before_crossing_ < 0 && halvings_ <= fewest_halvings_) most_halvings_ = fewest_halvings_;
  here_ = std::move(there);
  if (here_.at < 1) good_ = system_.save();
}

void WayFollower::lengthen() {
  if (++in_succession_ != 2 || halvings_ == 0) return;
  in_succession_ = 0;
  --halvings_;
  step_ *= 2;
}

// Goes back and halves the step; false where it has been halved too often, or nothing is to be
// found: then the message says so.
bool WayFollower::shorten(double failed) {
  system_.restore(good_);
  // a step that is seen to be too long at once costs next to nothing
  int& counted = result_.too_far && far_ < most_halvings_ ? far_ : halvings_;
  if (++counted > most_halvings_ || result_.beyond_reach) {
    system_.assemble();
    // leaves that are pulled straight are at the end of their reach, whatever ends the way
    result_.left_branch = result_.left_branch && here_.strain < 0.05 * largest_strain;
    const std::string where = way_.moves ? fmt::format(" between {:.7g} and {:.7g} of the {} step",
                                                       here_.at, failed, way_.what)
                                         : std::string();
    result_.message = fmt::format("no equilibrium{}: {}", where, result_.message);
    return false;
  }
  step_ /= 2;
  halved_ = true;
  in_succession_ = 0;
  return true;
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
    const bool turns = is_rotation(system.mechanism().drives[k].direction);
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
  Equilibrium result = WayFollower(system, options, along).follow();
  if (!result.converged)
    result.message =
        moves ? fmt::format("stroke {} to {}: {}", listed(start), listed(strokes), result.message)
              : fmt::format("stroke {}: {}", listed(strokes), result.message);
  return result;
}

Equilibrium step_load(System& system, LoadFactors to, const NewtonOptions& options,
                      bool drives_free) {
  const LoadFactors from = system.load_factors();
  const bool driven = system.loads().driven() && !drives_free;
  const std::optional<VectorXd> strokes =
      driven ? std::optional(present_strokes(system)) : std::nullopt;
  const LoadFactors growth{to.constant - from.constant, to.growing - from.growing};
  const auto at = [&](double p) {
    return p == 1 ? to
                  : LoadFactors{from.constant + p * growth.constant,
                                from.growing + p * growth.growing, to.step};
  };
  const Way along{.what = "load",
                  .drive_held = driven ? DriveHold::all : DriveHold::none,
                  .moves = !(from == to),
                  .assembles = growth.constant != 0 && system.loads().assembles_in(to.step),
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
  Equilibrium result = WayFollower(system, options, along).follow();
  if (!result.converged) result.message += held_meanwhile(system, driven);
  return result;
}

Equilibrium mount(System& system, const NewtonOptions& options) {
  const LoadCase& loads = system.loads();
  const std::size_t steps = loads.mounting.size();
  const LoadFactors from = system.load_factors();
  Equilibrium whole;
  std::string crossings;
  for (int k = from.step; k <= loads.mounted().step; ++k) {
    const MountingStep step = steps > 0 ? loads.mounting[k] : MountingStep();
    const auto named = [&](const std::string& text) {
      return steps == 0 ? text
                        : fmt::format("mounting step {} of {}{}: {}", k + 1, steps,
                                      step.name.empty() ? "" : " (" + step.name + ")", text);
    };
    const auto add = [&](Equilibrium next) {
      next.iterations += whole.iterations;
      next.turns_sharply = next.turns_sharply || whole.turns_sharply;
      if (!next.crossings.empty())
        crossings += (crossings.empty() ? "" : "; ") + named(next.crossings);
      whole = std::move(next);
    };
    const bool begun = k == from.step && from.constant > 0;
    if (!begun) system.apply({0, 0, k});
    whole.converged = true;
    if (step.strokes && !begun) add(step_to(system, *step.strokes, options));
    if (whole.converged) add(step_load(system, {1, 0, k}, options, step.drives_free));
    if (whole.converged) continue;
    whole.message = named(whole.message);
    if (loads.driven() && !system.drives().empty())
      whole.message +=
          step.drives_free
              ? "; meanwhile the drives are free: put less on in this step, or hold them"
              : "; steps of \"assembly\" may leave drives free until loads have come (\"drive\": "
                "\"free\")";
    break;
  }
  whole.crossings = std::move(crossings);
  return whole;
}

}  // namespace flexopt
