#include "core/equilibrium/continuity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/equilibrium/newton_equations.hpp"
#include "core/equilibrium/stroke_path.hpp"
#include "core/math/rotation.hpp"
#include "core/math/sparse_solver.hpp"

namespace flexopt {
namespace {

// What is smaller is rounding: lengths over the longest leaf, energies and changes inside leaves.
constexpr double rounding = 1e-6;

// Displacement over the length of the system, and rotation vector.
Vector6d motion_between(const JointBody& from, const JointBody& to, double length) {
  Vector6d motion;
  motion << (to.position - from.position) / length,
      rotation_log(to.rotation * from.rotation.transpose());
  return motion;
}

// What rounding makes of the energies: strains are differences of lengths.
double rounding_of_energies(const System& system) {
  constexpr double share = 1e-12;
  const VectorXd energies = system.tangent().diagonal().cwiseProduct(system.units().cwiseAbs2());
  double rounding_inside = 0;
  for (int i = 0; i < system.leaves(); ++i) rounding_inside += system.leaf(i).evaluation().rounding;
  return share * energies.cwiseAbs().maxCoeff() + rounding_inside;
}

// How far a motion goes, lengths over the longest leaf's.
double lengths_of(const VectorXd& motion, const System& system) {
  return motion.cwiseQuotient(system.units()).norm();
}

// How far the end is from where both slopes lead the interior of a leaf, a quarter of it where they
// are less than 60° apart: the branch of a leaf that buckles may turn, but not change its side.
// Beside a bifurcation the mean of slopes of both sides may lead from one to the other: slopes that
// point against each other are believed where what they lead to is small beside the way from the
// origin.
double inside(const LeafInterior& origin, const LeafInterior& start, const LeafInterior& end,
              double step) {
  constexpr double small = 0.5;
  if (start.unknowns.size() == 0 || start.unknowns.size() != end.unknowns.size()) return 0;
  const VectorXd motion = end.unknowns - start.unknowns;
  const double before = start.change.norm(), after = end.change.norm(),
               cosine = start.change.dot(end.change) / std::max(before * after, 1e-300),
               slight = rounding * end.unknowns.norm();
  if (!std::isfinite(before + after)) return std::numeric_limits<double>::infinity();
  if (cosine < 0 && origin.unknowns.size() == end.unknowns.size()) {
    const double way = std::max((end.unknowns - origin.unknowns).norm(),
                                (start.unknowns - origin.unknowns).norm());
    if (step * (before + after) > small * way + slight)
      return std::numeric_limits<double>::infinity();
  }
  const double weight = cosine < 0.5 ? 1 : 0.25;
  const double beside = (motion - 0.5 * step * (start.change + end.change)).norm();
  return weight * beside / (motion.norm() + slight);
}

}  // namespace

Place place_of(const System& system) {
  Place place{system.poses(), {}};
  const int leaves = system.leaves();
  place.energies.resize(leaves + 2);
  for (int i = 0; i < leaves; ++i) place.energies[i] = system.leaf(i).evaluation().energy;
  place.energies[leaves] = system.energy() - place.energies.head(leaves).sum();
  place.energies[leaves + 1] = system.load_energy();
  return place;
}

bool is_near(const System& system, const Place& before, double energy_share) {
  constexpr double share = 0.05, slight = 1e-4;
  const Place now = place_of(system);
  double moved = 0, apart = 0;
  for (std::size_t b = 0; b < now.poses.size(); ++b) {
    const JointBody rest = undeflected_body(system.mechanism(), static_cast<int>(b));
    moved += motion_between(rest, before.poses[b], system.length()).squaredNorm();
    apart += motion_between(before.poses[b], now.poses[b], system.length()).squaredNorm();
  }
  if (!(std::sqrt(apart) <= share * std::sqrt(moved) + slight)) return false;
  const double sum = now.energies.cwiseAbs().sum() + before.energies.cwiseAbs().sum();
  return (now.energies - before.energies).cwiseAbs().sum() <=
         energy_share * 0.5 * sum + rounding_of_energies(system);
}

BranchState branch_state_of_strokes(const System& system, const VectorXd& strokes) {
  BranchState state{.place = place_of(system)};
  NewtonEquations equations(system, true);
  const VectorXd present = present_strokes(system);
  equations.assemble(system.load() - system.internal_force(), present);
  const LinearSolver solver(equations.matrix(), system.analyses());
  state.blur = lengths_of(equations.motion(solver.solve(equations.right_side())), system);
  equations.assemble(VectorXd::Zero(system.size()), present + strokes);
  const VectorXd x = solver.solve(equations.right_side());
  state.slope = equations.motion(x);
  for (int i = 0; i < system.leaves(); ++i)
    state.interiors.push_back(system.leaf(i).interior(system.edge_increment(i, state.slope)));
  VectorXd loads(strokes.size()), change = VectorXd::Zero(strokes.size());
  equations.read_loads(x, change);
  const VectorXd multipliers = equations.conditions() > 0 ? equations.multipliers(x) : VectorXd();
  for (Eigen::Index k = 0; k < strokes.size(); ++k) {
    loads[k] = system.drive_load(k);
    if (const auto& row = system.drives()[k].condition) change[k] = -multipliers[*row];
  }
  if (!system.follows())  // loads that follow their bodies have no potential
    state.work = {.rate = loads.dot(strokes), .slope = change.dot(strokes)};
  return state;
}

BranchState branch_state_of_loads(System& system, LoadFactors growth, bool driven) {
  constexpr double step = 1e-5;  // moved edges stretch their leaves by its square
  BranchState state{.place = place_of(system)};
  const std::optional<VectorXd> strokes =
      driven ? std::optional(present_strokes(system)) : std::nullopt;
  const System::Snapshot here = system.save();
  const VectorXd rest = system.load() - system.internal_force();  // what Newton's method has left
  NewtonEquations equations(system, driven ? DriveHold::all : DriveHold::none);
  equations.assemble(rest, strokes);
  // the tangent here: where loads have changed the leaves are out of balance, and a soft motion
  // takes what they pull for its stiffness
  const LinearSolver solver(equations.matrix(), system.analyses());
  state.blur = lengths_of(equations.motion(solver.solve(equations.right_side())), system);
  state.noise = state.blur / step;
  // where errors of assembly grow, the unstable state is wanted
  const bool assembles = growth.constant != 0 && system.loads().assembles_in(here.factors.step),
             settled = system.correction() < rounding * step;
  for (int i = 0; !assembles && settled && i < system.leaves(); ++i)
    state.interiors.push_back(system.leaf(i).interior(Vector12d::Zero()));
  system.apply({here.factors.constant - step * growth.constant,
                here.factors.growing - step * growth.growing, here.factors.step});
  system.assemble();
  VectorXd change = VectorXd::Zero(equations.right_side().size());
  change.head(system.size()) =
      equations.scale().cwiseProduct(system.load() - system.internal_force() - rest);
  const VectorXd motion = equations.motion(solver.solve(change));
  state.slope = -1 / step * motion;
  for (std::size_t i = 0; i < state.interiors.size(); ++i) {
    LeafInterior& interior = state.interiors[i];
    const int leaf = static_cast<int>(i);
    const LeafInterior moved = system.leaf(leaf).interior(system.edge_increment(leaf, motion));
    interior.change = -1 / step * (moved.unknowns + moved.change - interior.unknowns);
  }
  system.restore(here);
  system.assemble();
  return state;
}

double departure(const BranchState& origin, const BranchState& start, const BranchState& end,
                 double step, const System& system) {
  if (!start.slope.allFinite() || !end.slope.allFinite())
    return std::numeric_limits<double>::infinity();
  double moved = 0, beside = 0, of_moments = 0;
  for (std::size_t b = 0; b < start.place.poses.size(); ++b) {
    const auto at = static_cast<Eigen::Index>(6 * b);
    const Vector6d motion =
        motion_between(start.place.poses[b], end.place.poses[b], system.length());
    Vector6d led = 0.5 * step * (start.slope.segment<6>(at) + end.slope.segment<6>(at));
    led.head<3>() /= system.length();
    for (const BodyLoad& load : system.acting())  // a dead moment has no energy
      if (load.body == static_cast<int>(b)) of_moments += load.moment.dot(motion.tail<3>());
    moved += motion.squaredNorm();
    beside += (motion - led).squaredNorm();
  }
  const double blurred = 2 * (start.blur + end.blur + step * (start.noise + end.noise));
  double motion = std::max(0.0, std::sqrt(beside) - blurred) / (std::sqrt(moved) + rounding);
  const bool sharp = blurred <= 0.05 * std::sqrt(moved);
  for (std::size_t i = 0; sharp && i < std::min(start.interiors.size(), end.interiors.size()); ++i)
    motion = std::max(motion,
                      inside(i < origin.interiors.size() ? origin.interiors[i] : start.interiors[i],
                             start.interiors[i], end.interiors[i], step));
  if (!start.work || !end.work) return motion;
  const VectorXd change = end.place.energies - start.place.energies;
  const double work = 0.5 * step * (start.work->rate + end.work->rate) +
                      step * step / 12 * (start.work->slope - end.work->slope) + of_moments;
  const double off = std::abs(work - change.sum()) - 2 * rounding_of_energies(system);
  const double scale = change.cwiseAbs().sum() + rounding * end.place.energies.cwiseAbs().sum();
  return off > 0 ? std::max(motion, off / scale) : motion;
}

}  // namespace flexopt
