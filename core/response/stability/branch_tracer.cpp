#include "core/response/stability/branch_tracer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/equilibrium/elastic_degree.hpp"
#include "core/equilibrium/stroke_path.hpp"

namespace flexopt {
namespace {

constexpr int most_states = 60;
// The last step aims at this multiple of the bound, so that it ends beyond it in spite of rounding.
constexpr double past_bound = 1 + 1e-6;
// Change of the factor without a critical state that is believed where the states are spent.
constexpr double enough = 10;
// A critical state counts as reached at this distance on the way, over the size of the factor.
constexpr double reached = 1e-8;
// The shortest step, likewise.
constexpr double least_step = 1e-7;
// Estimates that move by so small a share of the way between two states are those of a branch that
// leads straight to a bifurcation. An imperfection that is rounding, or as small, makes it miss
// that by a little; it has passed it where the factor is so far beyond.
constexpr double agreement = 0.02, passed = 1.01;
// As near to it, over the size of the factor, what makes the branch miss it is rounding, or as
// small, and its factor and the derivatives of that are the bifurcation's.
constexpr double nearly_met = 1e-5;
// A bifurcation counts as met at this distance where Newton's method does not come nearer.
constexpr double still_near = 1e-2;
// So many estimates in a row, for next to a fold one may agree by chance.
constexpr int straight_states = 3;
// Beyond it, where the tangent must have become indefinite.
constexpr double beyond = 1e-4;
// Motions of the bodies by the factor that are not rounding, lengths over the longest leaf.
constexpr double least_rate = 1e-6;
// Motions of the bodies by the factor, over those where the branch begins: beyond it a fold.
constexpr double fold_motion = 1e3;
// Where a limit is watched: the first step along σ, and the step, over the size of the factor, at
// which a leaf that is stretched too far ends the search.
constexpr double first_step = 1, last_stretch = 0.01;
// What a limit is missed by.
constexpr double at_the_limit = 1e-11;

// Motions of the bodies, over the largest unknown of all.
std::vector<BodyMotion> motions(const MechanismFactor& factor, const VectorXd& mode) {
  const double L = factor.system().length();
  double largest =
      mode.head(factor.bodies()).cwiseQuotient(factor.system().units()).cwiseAbs().maxCoeff();
  for (const MechanismFactor::Leaf& leaf : factor.leaves())
    largest =
        std::max(largest, mode.segment(leaf.offset, leaf.rows.unknowns).cwiseAbs().maxCoeff());
  std::vector<BodyMotion> bodies;
  for (int b = 0; b < factor.bodies(); b += 6)
    bodies.push_back({mode.segment<3>(b) / (L * largest), mode.segment<3>(b + 3) / largest});
  return bodies;
}

}  // namespace

double BranchTracer::measure(const VectorXd& bodies) const {
  return bodies.cwiseQuotient(branch_->system().units()).norm();
}

double BranchTracer::product(const BranchDirection& a, const BranchDirection& b) const {
  const VectorXd weights = (weight_ * branch_->system().units().cwiseInverse()).cwiseAbs2();
  return a.bodies.dot(weights.cwiseProduct(b.bodies)) + a.factor * b.factor;
}

// The motions of bodies count as the factor does, by how they go with it where the branch begins.
BranchTracer::Look BranchTracer::look(int side, const VectorXd& start, bool behind) {
  Look here;
  Answer<MechanismFactor> linear = MechanismFactor::of(branch_->system());
  assert(linear);  // full leaves have interiors
  here.factor = std::make_unique<MechanismFactor>(std::move(*linear));
  const MechanismFactor& factor = *here.factor;
  MatrixXd forces = MatrixXd::Zero(factor.size(), 1);
  forces.topRows(factor.bodies()) = branch_->load();
  const VectorXd state = factor.balance(forces, branch_->locked()).topRows(factor.size());
  const VectorXd bodies = state.head(factor.bodies());
  if (weight_ == 0) {
    first_rate_ = std::max(measure(bodies), least_rate);
    weight_ = 1 / first_rate_;
  }
  const double size = std::hypot(weight_ * measure(bodies), 1.0);
  // states that are kept have no negative pivot (stride), so that the load does not turn between
  // them: P·u̇ = u̇ᵀK u̇ > 0
  here.along = {side / size * bodies, side / size};
  here.rate = std::make_unique<StiffnessRate>(factor, still_, *model_, branch_->named());
  here.load = side / size;
  here.rate->set_direction(here.load * state, here.load);
  static_cast<Softening&>(here) = soften(factor, *here.rate, branch_->locked(), start, behind);
  return here;
}

// Far from a fold the motions count by how they go with the factor now.
void BranchTracer::weigh_anew(Look& here) {
  const double rate = measure(here.along.bodies) / std::abs(here.along.factor);
  weight_ = 1 / std::max(rate, least_rate);
  const double size = std::sqrt(product(here.along, here.along));
  here.along.bodies /= size;
  here.along.factor /= size;
  if (here.ahead) here.ahead->step *= size;
  if (here.behind) here.behind->step *= size;
}

// Whether the tangent is indefinite a little farther on; the branch stays where it is.
bool BranchTracer::crosses(const Look& at) {
  const LoadBranch::State kept = branch_->save();
  const double size = std::max(1.0, std::abs(branch_->factor()));
  bool found = false;
  for (const double far : {beyond, 10 * beyond}) {
    if (!branch_->advance(at.along, far * size, weight_)) continue;
    found = branch_->negative_pivots() > 0;
    branch_->restore(kept);
    if (found) break;
  }
  return found;
}

// Whether there is a bifurcation that the branch was heading for straight on: beyond the state
// nearest to it there is an equilibrium with an indefinite tangent. Of a fold there is none with so
// much of the load. The branch stays where it is.
bool BranchTracer::proves(Nearest& nearest) {
  if (nearest.straight < straight_states || std::exchange(nearest.tried, true)) return false;
  const double size = std::max(1.0, std::abs(nearest.factor));
  const LoadBranch::State kept = branch_->save();
  bool crossed = false;
  for (const double share : {1, 10, 100}) {
    const double far = share * beyond * size;
    branch_->restore(nearest.state);
    const double from = branch_->factor();
    crossed = branch_->advance(nearest.along, far / std::abs(nearest.along.factor), weight_) &&
              std::abs(branch_->factor() - from) > 0.9 * far && branch_->negative_pivots() > 0;
    if (crossed) break;
  }
  branch_->restore(kept);
  return crossed;
}

// Whether the branch turned away from one that it met but for rounding.
bool BranchTracer::turned_away(Heading& heading) {
  const double size = std::max(1.0, std::abs(branch_->factor()));
  return next_to(heading, size) && !heading.at_nearest && proves(*heading.nearest);
}

// Whether a bifurcation that the branch was heading for straight on is met but for rounding.
bool BranchTracer::next_to(const Heading& heading, double size) {
  return heading.nearest && heading.nearest->straight >= straight_states &&
         heading.nearest->distance < nearly_met * size;
}

// The motion that is known, or next to a singular state the answer to any force.
VectorXd BranchTracer::nearly_singular_motion(const MechanismFactor& factor,
                                              const VectorXd& known) const {
  if (known.size() == factor.size()) return known;
  return factor.solver(branch_->locked())(any_force(factor));
}

CriticalLoad BranchTracer::critical_at(double factor, Look here, const VectorXd& mode,
                                       bool straight) {
  if (!here.ahead) here.ahead = SoftMode{0, nearly_singular_motion(*here.factor, mode)};
  CriticalLoad result;
  result.factor = factor;
  result.fold = !straight && measure(here.along.bodies) >
                                 fold_motion * first_rate_ * std::abs(here.along.factor);
  result.mode = motions(*here.factor, here.ahead->mode);
  if (passed_) result.reason = "the branch of equilibria leads there: " + passed_by();
  critical_ = std::move(here);
  return result;
}

CriticalLoad BranchTracer::critical_beside(int side, Nearest nearest) {
  branch_->restore(nearest.state);
  return critical_at(nearest.factor, look(side, nearest.mode), nearest.mode, true);
}

BranchTracer::Stride BranchTracer::stride(const BranchDirection& along, double step) {
  const LoadBranch::State kept = branch_->save();
  const Check went = branch_->advance(along, step, weight_);
  if (!went) return {.obstacle = went.error()};
  const double strain = branch_->system().strain();
  if (strain <= largest_strain && branch_->negative_pivots() == 0) return {.taken = true};
  branch_->restore(kept);
  if (strain > largest_strain) return {.stretched = true, .obstacle = stretch_message(strain)};
  return {.crossed = true, .obstacle = "the tangent becomes indefinite all at once"};
}

// The look linearises about the state after a step from `last`, and judges the estimate of `last`
// by what the step met.
BranchTracer::Look BranchTracer::look_on(int side, Look last, double at, double step,
                                         Heading& heading) {
  const std::optional<SoftMode> foretold = std::move(last.ahead);
  const double last_estimate = foretold ? last.estimate(at, *foretold) : 0;
  if (foretold) heading.mode = foretold->mode;
  last = {};  // before its leaves move on
  Look here = look(side, heading.mode);
  heading.at_nearest = false;
  if (!foretold || !here.ahead) {
    heading.trust = 0.5;
    weigh_anew(here);
    return here;
  }
  const double left = here.ahead->step / foretold->step,
               error = std::abs(step + here.ahead->step - foretold->step) / foretold->step;
  const double now = here.estimate(branch_->factor(), *here.ahead), distance = here.distance();
  const bool straight =
      std::abs(now - last_estimate) < agreement * std::abs(branch_->factor() - at);
  heading.straight = straight ? heading.straight + 1 : 0;
  heading.at_nearest = straight && (!heading.nearest || distance < heading.nearest->distance);
  if (heading.at_nearest)
    heading.nearest =
        Nearest{branch_->save(), here.along, here.ahead->mode, now, distance, heading.straight};
  // an estimate that keeps its distance is that of a branch that bends away
  heading.trust =
      left > 0.8 ? std::min(2 * heading.trust, 32.0) : std::clamp(1 - 3 * error, 0.5, 0.999);
  if (left > 0.8) weigh_anew(here);
  return here;
}

// The limit lies between a state and the one a step on, where the branch stands: the regula falsi
// in the Illinois way.
bool BranchTracer::close_in(const LoadBranch::State& from, const BranchDirection& along,
                            double step) {
  constexpr int most_rounds = 60;
  double high = step, above = limit_(branch_->system());
  branch_->restore(from);
  double low = 0, below = limit_(branch_->system());
  int last = 0;  // the side that moved
  for (int round = 0; round < most_rounds; ++round) {
    const double middle = (low * above - high * below) / (above - below);
    branch_->restore(from);
    if (!branch_->advance(along, middle, weight_)) return false;
    const double here = limit_(branch_->system());
    if (std::abs(here) < at_the_limit || high - low < 1e-14 * step) return true;
    const int side = here > 0 ? 1 : -1;
    (side > 0 ? high : low) = middle;
    (side > 0 ? above : below) = here;
    if (side == last) (side > 0 ? below : above) *= 0.5;
    last = side;
  }
  return true;
}

// The estimate of every state tells how far the next step goes; what it was
// wrong by tells how far it is trusted.
CriticalLoad BranchTracer::follow(int side, Look here, double bound) {
  CriticalLoad result;
  const double begin = branch_->factor();
  Heading heading;
  at_limit_ = false;
  passed_.reset();
  if (limit_) heading.longest = first_step;
  for (int count = 0;; ++count) {
    const double at = branch_->factor(), size = std::max(1.0, std::abs(at));
    if (here.ahead && here.ahead->step < reached * size) {
      if (crosses(here)) {
        const double factor = here.estimate(at, *here.ahead);
        return critical_at(factor, std::move(here), heading.mode, next_to(heading, size));
      }
      heading.longest = std::numeric_limits<double>::infinity();
      heading.trust = std::max(2.0, heading.trust);  // it only touches
    }
    if (turned_away(heading)) {
      here = {};
      return critical_beside(side, *std::move(heading.nearest));
    }
    if (const auto& nearest = heading.nearest;
        nearest && std::abs(at - begin) > passed * std::abs(nearest->factor - begin)) {
      // the states that lead past it are not those that the way beyond it may take
      if (!passed_) count = 0;
      pass_by(heading, size);
    }
    if (std::abs(at - begin) > bound || count == most_states) {
      result.none = std::abs(at - begin) > std::min(bound, enough);
      result.reason = where_it_ended(std::clamp(at, begin - bound, begin + bound), !result.none);
      return result;
    }
    const double step = std::min(
        {here.ahead ? heading.trust * here.ahead->step : size / std::abs(here.along.factor),
         heading.longest,
         std::max(past_bound * bound - std::abs(at - begin), least_step) /
             std::abs(here.along.factor)});
    std::optional<LoadBranch::State> from;
    if (limit_) from = branch_->save();
    const Stride went = stride(here.along, step);
    if (went.taken && limit_ && limit_(branch_->system()) > 0) {
      at_limit_ = close_in(*from, here.along, step);
      if (!at_limit_)
        result.reason = fmt::format("no equilibrium was found next to the limit, at {}",
                                    shown(branch_->factor()));
      return result;
    }
    if (went.taken) {
      heading.longest = std::max(heading.longest - step, 2 * step);
      here = std::abs(branch_->factor() - begin) > bound
                 ? Look()
                 : look_on(side, std::move(here), at, step, heading);
      continue;
    }
    heading.longest = 0.5 * step;
    const bool stretched = limit_ && went.stretched && step < last_stretch * size;
    if (step >= least_step * size && !stretched) continue;
    return end_at(side, std::move(here), step, went, heading);
  }
}

// Leaves the nearest bifurcation behind, and names it if it was a near one.
void BranchTracer::pass_by(Heading& heading, double size) {
  if (heading.nearest->straight >= straight_states || heading.nearest->distance < still_near * size)
    passed_ = heading.nearest->factor;
  heading.nearest.reset();
  heading.straight = 0;
}

// What ends the branch where no step leads on.
CriticalLoad BranchTracer::end_at(int side, Look here, double step, const Stride& went,
                                  Heading& heading) {
  const double at = branch_->factor(), size = std::max(1.0, std::abs(at));
  // the estimate is rounded where stiff motions hide the soft one; the inertia is not
  if (went.crossed) {
    const bool straight = next_to(heading, size);
    const double factor = straight ? heading.nearest->factor : at + 0.5 * step * here.along.factor;
    return critical_at(factor, std::move(here), heading.mode, straight);
  }
  // where several modes become soft at once no equilibrium may be found next to the singular state
  if (heading.nearest && heading.nearest->distance < still_near * size &&
      proves(*heading.nearest)) {
    here = {};
    return critical_beside(side, *std::move(heading.nearest));
  }
  CriticalLoad result;
  result.none = went.stretched;
  result.reason = fmt::format("the branch of equilibria ends at {}: {}", shown(at), went.obstacle);
  return result;
}

std::string BranchTracer::where_it_ended(double factor, bool states_spent) const {
  std::string text =
      fmt::format("no singular tangent on the branch of equilibria up to {}{}", shown(factor),
                  states_spent ? fmt::format(", where {} states were spent", most_states) : "");
  return passed_ ? text + "; " + passed_by() : text;
}

std::string BranchTracer::passed_by() const {
  return "it bends away from a bifurcation near " + shown(*passed_);
}

std::string BranchTracer::shown(double factor) const {
  const std::string& name = branch_->system().loads().growing.front().name;
  return unit_ == 0 ? fmt::format("a factor of {:.4g} of {}", factor, name)
                    : fmt::format("a load of {:.4g} along {}", factor * unit_, name);
}

// φᵀ(K + (A·e))φ vanishes at a factor that is off by about −φᵀ(A·e)φ / φᵀK_λφ.
Check BranchTracer::check_bodies() const {
  const ElasticBodies& bodies = branch_->system().elastic_bodies();
  if (bodies.count() == 0) return {};
  const VectorXd& mode = critical_->ahead->mode;
  const double rate = critical_->rate->forms(mode)(0, 0) / critical_->load;
  for (int k = 0; k < bodies.count(); ++k) {
    // of degree 2 the mode tells more than stiffnesses, which vanish here
    const double error = bodies.body(k).degree == ElasticDegree::linear
                             ? 0
                             : degree_error(branch_->system(), k, geometric_share(bodies, k));
    if (Check holds = check_degree(bodies.body(k), error); !holds) return holds;
    const double off = left_out_stiffness(bodies, k, mode.head(critical_->factor->bodies())) / rate;
    if (const double share = std::abs(off / std::max(1e-3, std::abs(branch_->factor())));
        share > largest_degree_error)
      return Because(fmt::format(
          "in the mode of instability {} deforms further than degree 2 holds: the load is off by "
          "some {:.2g} %; degree 4 holds further",
          bodies.body(k).name, 100 * share));
  }
  return {};
}

// (S25): the stiffness of the critical mode stays zero.
VectorXd BranchTracer::gradient(DesignDirections& design, const MatrixXd& drive_load_rates) {
  const MechanismFactor& factor = *critical_->factor;
  // by inverse iteration, which leaves no rounding along stiff motions
  VectorXd mode = factor.solver(branch_->locked())(critical_->rate->times(critical_->ahead->mode));
  mode /= mode.norm();
  const DesignRates<double> rates = design_rates(factor, design, *model_).value();
  const MatrixXd moved = moved_states(*branch_, factor, rates.residual(), drive_load_rates);
  const Eigen::Index count = moved.cols() - 1;
  critical_->rate->set_direction(moved.col(count), 1);
  const double along = critical_->rate->forms(mode)(0, 0);
  return -rates.quadratic(mode, VectorXd::Zero(1), moved.leftCols(count)).row(0).transpose() /
         along;
}

// One solve for all: near a fold the motions along the parameters and along the load are as large,
// and what rounding does to them is the same.
MatrixXd moved_states(const LoadBranch& branch, const MechanismFactor& factor, MatrixXd residual,
                      const MatrixXd& drive_load_rates) {
  const System& system = branch.system();
  std::vector<int> free;
  for (int k = 0; k < factor.drives(); ++k)
    if (!system.holds(k, DriveHold::named)) free.push_back(k);
  if (!branch.locked())
    residual.topRows(factor.bodies()) -=
        system.drive_forces(DriveHold::named) * drive_load_rates(free, Eigen::all);
  const Eigen::Index count = residual.cols();
  MatrixXd forces = MatrixXd::Zero(factor.size(), count + 1);
  forces.leftCols(count) = -residual;
  forces.col(count).head(factor.bodies()) = branch.load();
  MatrixXd moved = factor.balance(forces, branch.locked()).topRows(factor.size());
  if (!branch.locked())
    for (int k = 0; k < factor.drives(); ++k)
      if (const auto& row = system.drives()[k].condition; row && !system.holds(k, DriveHold::named))
        moved.row(factor.size() - factor.conditions() + *row).head(count) =
            -drive_load_rates.row(k);
  return moved;
}

MatrixXd drive_load_rates(LoadBranch& branch, const ModelOptions& model, DesignDirections& design,
                          bool driven) {
  const Answer<MechanismFactor> linear = MechanismFactor::of(branch.system());
  const MechanismFactor& factor = *linear;
  const auto count = static_cast<Eigen::Index>(design.list.size());
  if (branch.locked() || !driven || factor.drives() == 0)
    return MatrixXd::Zero(factor.drives(), count);
  const DesignRates<double> rates = design_rates(factor, design, model).value();
  return factor.balance(-rates.residual(), true).bottomRows(factor.drives());
}

}  // namespace flexopt
