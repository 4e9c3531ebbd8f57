#pragma once
// What a designer asks of a mechanism over its stroke. Plain data.
#include <algorithm>
#include <array>
#include <bitset>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "core/math/work_limit.hpp"
#include "core/mechanism/joint.hpp"
#include "core/mechanism/load_case.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"

namespace flexopt {

/// A point whose motion is wanted, and at which loads of a linear model act: fixed to a body, or a
/// material point of a leaf's mid-surface.
struct NamedPoint {
  std::string name;
  int leaf = 0;
  double along = 0, across = 0;  ///< place on the leaf, each in [0, 1]
  std::optional<int> body = {};  ///< to which it is fixed; nothing: it is on the leaf
  /// Place on the body, undeflected, global axes [m]. It stays the same where a design parameter
  /// moves the body. Nothing: the body's reference point.
  std::optional<Vector3d> at = {};
  /// Along which it moves and is loaded, a unit vector of translations or rotations along global
  /// axes, which does not turn; rotations are those of a body. Nothing: all three translations.
  std::optional<Vector6d> direction = {};
  const char* kind = "point";  ///< what results call it; "probe" by the old key of a job

  int motions() const { return direction ? 1 : 3; }
  bool turns() const { return direction && !direction->tail<3>().isZero(0); }
  /// Vector from the reference point of the body, where it stands now, to the point [m].
  Vector3d lever(const JointBody& now) const {
    return at ? Vector3d(now.rotation * (*at - now.reference)) : Vector3d::Zero();
  }
};

/// The point at a place of the undeflected mechanism (its foot on the mid-surface), if a leaf is
/// there.
std::optional<NamedPoint> point_on_leaf(const Mechanism& mechanism, std::string name,
                                        const Vector3d& place);

/// A strain gauge on a surface of a leaf.
struct StrainGauge {
  std::string name;
  int leaf = 0;
  double along = 0, across = 0.5;  ///< place on the leaf, each in [0, 1]
  bool on_positive_normal = true;
  double angle = 0;  ///< of the strain that it measures, from along to across [rad]
};

/// A Wheatstone bridge: supply voltage → ¼ gauge_factor Σ sign · strain.
struct StrainBridge {
  struct Arm {
    std::size_t gauge = 0;  ///< of StrokeRequest::gauges
    double sign = 1;
  };
  std::string name;
  std::vector<Arm> arms;
  double gauge_factor = 1;
};

/// What an evaluation can answer.
enum class Output {
  equilibrium,            ///< drive load, motion of O and points, stability
  stiffness,              ///< compliance at O and what follows from it
  gain,                   ///< gain and cross-coupling of the drives
  stress,                 ///< largest von Mises stress
  gauges,                 ///< strains of gauges, and what bridges make of them
  leaf_points,            ///< derivatives of the displacement of named points of leaves
  frequencies_free,       ///< natural frequencies and modes, drive free
  frequencies_locked,     ///< natural frequencies and modes, drive held
  parasitic_frequency,    ///< from the list that `ParasiticRule::drive` names
  frequency_derivatives,  ///< along the stroke, from the undeflected state alone
  envelope,               ///< box, cylinder and mass of the leaves, undeflected
  moving_envelope,        ///< box and cylinder that hold the mechanism over the stroke
  clearance,              ///< smallest distance between parts
  buckling,               ///< critical factors of the load that the request names
  dynamics,               ///< bandwidth and transmissibility, by the rule of the request
  transfers,              ///< from point to point, by the same rule
  state_space,            ///< the linear model about the equilibrium, as the request wants it
  load_capacity,          ///< largest loads at O, by the rule of the request
  stroke_capacity,        ///< largest strokes, by the rules of the request
  stable_states,          ///< the stable equilibria that are found: StableState
  shapes                  ///< deformed mid-surfaces for drawing
};

/// A set of outputs.
class Outputs {
 public:
  Outputs(std::initializer_list<Output> list = {}) {
    for (const Output o : list) set_.set(static_cast<std::size_t>(o));
  }
  /// All outputs that are numbers: everything but the shapes and the stable states.
  static Outputs numbers() {
    Outputs all;
    all.set_.set();
    return all.remove({Output::shapes, Output::stable_states});
  }

  Outputs& add(const Outputs& more) {
    set_ |= more.set_;
    return *this;
  }
  Outputs& add(Output one) { return add(Outputs{one}); }
  Outputs& remove(const Outputs& those) {
    set_ &= ~those.set_;
    return *this;
  }
  Outputs& remove(Output one) { return remove(Outputs{one}); }

  bool has(Output one) const { return set_.test(static_cast<std::size_t>(one)); }
  bool has_any(const Outputs& of) const { return (set_ & of.set_).any(); }
  bool empty() const { return set_.none(); }
  /// Whether equilibria at the points of the stroke are solved for them; the frequency derivatives
  /// need the undeflected one only, the undeflected envelope none, and stroke capacities points of
  /// their own.
  bool need_path() const {
    return !Outputs(*this)
                .remove({Output::frequency_derivatives, Output::envelope, Output::stroke_capacity})
                .empty();
  }
  /// Whether they are made of natural frequencies.
  bool need_frequencies() const {
    return has_any({Output::frequencies_free, Output::frequencies_locked,
                    Output::parasitic_frequency, Output::frequency_derivatives});
  }
  bool operator==(const Outputs&) const = default;

 private:
  static constexpr std::size_t count = static_cast<std::size_t>(Output::shapes) + 1;  // the last
  std::bitset<count> set_;
};

/// How exact the values of a path point are.
enum class PathValues {
  /// Values of the leaves that ModelOptions chooses; frequencies are Ritz values, up to some 1e-5
  /// above those of the whole mechanism.
  as_modelled,
  /// What exact derivatives belong to. Points of the mixed potential are finished on full leaves,
  /// to which the reduced ones only lead; where all leaves are looked up and their tables hold,
  /// they stay those of the reduced leaves. Frequencies are those of the whole mechanism to
  /// rounding.
  differentiable
};

enum class DriveState { free, locked };

enum class ModeKind { drive, end_effector, intermediate_body, leaf };

/// Rule for the parasitic frequency: the lowest of a list that is neither the drive's nor of a kind
/// that is left out.
struct ParasiticRule {
  DriveState drive = DriveState::locked;  ///< the list
  std::vector<ModeKind> skipped;          ///< kinds left out beside the drive's

  bool admits(ModeKind kind) const;
};

/// What a mean stress takes from the amplitude that is endured.
enum class MeanStress {
  goodman,   ///< σa/σe + σm/σu = 1
  gerber,    ///< σa/σe + (σm/σu)² = 1
  soderberg  ///< σa/σe + σm/σy = 1
};

/// The stress cycles for which fatigue is assessed.
struct FatigueRule {
  /// Smallest over largest stress, in [−1, 1), of cycles that reach the stress of each point;
  /// nothing: the cycles between the points of the path, with the signs of stress at each place.
  std::optional<double> stress_ratio;
  MeanStress mean_stress = MeanStress::goodman;
  std::optional<double> cycles;  ///< that must be survived; nothing: without end
};

/// How stresses are judged.
struct StressRules {
  /// Radius where leaves meet bodies [m]; nothing: no concentration of stress there.
  std::optional<double> fillet;
  /// Whether safeties are wanted; all leaves' materials then have the numbers.
  bool yield = false, fatigue = false;
  FatigueRule fatigue_rule;
  bool life = false;  ///< whether lives are wanted

  /// Whether the stresses of all points are to be kept until the path has ended.
  bool need_history() const { return (fatigue || life) && !fatigue_rule.stress_ratio; }
};

/// How the ground shakes a mechanism.
struct TransmissibilityRule {
  Direction direction = Direction::uy;  ///< translation of the ground, and of O
  double from = 0, to = 0;              ///< band in which the largest gain counts [Hz]
  DriveState drive = DriveState::free;
  /// Named point, with a translation as direction, whose motion counts in place of O's.
  std::optional<std::size_t> point;
};

/// A harmonic load or motion at a named point, and the motion of another, or the same; both have
/// directions.
struct TransferRule {
  /// Point of StrokeRequest::named_points. Nothing: the ground moves along the direction of `to`, a
  /// translation.
  std::optional<std::size_t> from;
  std::size_t to = 0;
  DriveState drive = DriveState::free;
  bool of_motion = false;  ///< the motion of `from` is given, not the load there
  std::string name;        ///< what results call it
};

/// What is read off the harmonic motion about an equilibrium.
struct DynamicsRule {
  double damping = 0.01;  ///< ratio ζ, above zero: stiffness K (1 + 2iζ)
  std::optional<TransmissibilityRule> transmissibility;
  std::vector<TransferRule> transfers;
};

/// Settings of a linear state-space model.
struct StateSpaceRequest {
  int modes = 8;                      ///< that are kept, drive free; fewer where there are fewer
  std::vector<double> damping{0.01};  ///< ratio of all modes, or one of each mode that is kept
  bool sensors = true;                ///< whether the named points are inputs and outputs
  std::vector<int> points;            ///< of the stroke; empty: all
};

/// What a load at O is increased to. Loads are counted by direction: 0 … 5 along (about) ux … rz, 6
/// … 11 against them.
struct CapacityRule {
  std::array<bool, 12> directions{};
  DriveState drive = DriveState::locked;  ///< strokes kept, or loads of the drives kept
  std::optional<double> stress;  ///< limit of all parts [Pa]; nothing: their yield strengths
  /// Least share of the unloaded support stiffness that must remain. Skipped when zero.
  double stiffness_share = 0;
  std::array<bool, 6> supports{true, true, true, true, true, true};  ///< whose stiffness counts
  /// The search ends beyond these loads [N, N m].
  std::optional<double> largest_force, largest_moment;

  bool any() const { return std::ranges::find(directions, true) != directions.end(); }
};

/// How far a drive may go, the others at rest, under the constant loads alone.
struct StrokeCapacityRule {
  int drive = 0;
  double up_to = 0;                      ///< where the search ends, either way [m or rad]
  std::array<bool, 2> ways{true, true};  ///< forward, backward: which are looked at
  /// Limit of all leaves and elastic bodies [Pa]; nothing: safeties against yield and fatigue, of
  /// those that the request's StressRules want, of 1.
  std::optional<double> stress;
  /// Least share of the support stiffness at rest that must remain. Skipped when zero.
  double stiffness_share = 0;
  std::array<bool, 6> supports{true, true, true, true, true, true};  ///< whose stiffness counts
  std::optional<double> clearance;                                   ///< that must remain [m]
  std::optional<double> drive_load;  ///< that is there, either way [N or N m]
};

/// Branch that is followed where branches of equilibria meet.
enum class BranchChoice {
  primary,  ///< the one that the path comes along, stable or not
  stable    ///< the one that is stable, where the bodies can be led to it
};

/// What a factor or a safety counts as in goals where there is none.
inline constexpr double no_critical_factor = 1e6;

/// How far an evaluation is.
struct StrokeProgress {
  int done = 0, total = 0;  ///< points, and at each its critical loads and load capacities
  int iterations = 0;       ///< Newton iterations, as WorkLimits counts them
};

struct StrokeRequest {
  /// Stroke of the drive, in the order wanted [m or rad]; factors of the growing loads where the
  /// load case has some.
  std::vector<double> points{0.0};
  /// For several drives, the strokes of all of them, point by point; `points` holds those of the
  /// first drive.
  std::vector<VectorXd> strokes;
  /// The way to a point, once the constant loads act, is straight from rest, so that its answer
  /// does not depend on the other points; or it leads from point to point as they are listed.
  bool in_order = false;
  LoadCase loads;
  /// Name of the constant load that grows until the tangent is singular; empty for none.
  std::string buckling_load;
  double largest_factor = no_critical_factor;  ///< of it, either way: beyond, none is looked for
  /// What is wanted. Other numbers of a path point may come along where they cost nothing.
  Outputs outputs = Outputs::numbers();
  PathValues values = PathValues::as_modelled;
  int frequencies = 0;  ///< how many modes of each list wanted, and in the frequency derivatives
  ParasiticRule parasitic;
  StressRules stress;
  std::optional<DynamicsRule> dynamics;
  std::optional<StateSpaceRequest> state_space;
  CapacityRule capacity;
  std::vector<StrokeCapacityRule> stroke_capacity;  ///< at most one for each drive
  BranchChoice branch = BranchChoice::primary;
  /// How many places of large stress a differentiable point lists: PathPoint::stress_peaks.
  int stress_peaks = 0;
  std::vector<NamedPoint> named_points;
  std::vector<StrainGauge> gauges;
  std::vector<StrainBridge> bridges;
  NewtonOptions newton;
  WorkLimits limits;  ///< of one evaluation of these points
  /// Told of every Newton iteration.
  std::function<void(const StrokeProgress&)> progress;

  /// Strokes of all drives of a mechanism at a point.
  VectorXd strokes_at(std::size_t point, std::size_t drives) const;
  /// How many natural frequencies of a list have to be found.
  int frequencies_of(DriveState drive) const;
  bool wants_frequencies() const {
    return frequencies_of(DriveState::free) > 0 || frequencies_of(DriveState::locked) > 0;
  }
  bool wants_frequency_derivatives() const;
  bool wants_dynamics() const { return dynamics && outputs.has(Output::dynamics); }
  bool wants_transfers() const {
    return dynamics && !dynamics->transfers.empty() && outputs.has(Output::transfers);
  }
  /// Whether anything is wanted that has the mass of the interiors of the leaves.
  bool wants_harmonic_answers() const { return wants_dynamics() || wants_transfers(); }
  bool wants_gauges() const { return !gauges.empty() && outputs.has(Output::gauges); }
  bool wants_state_space(std::size_t point) const;
  /// Whether named points of leaves are loaded there, or their small motions wanted, or, of a
  /// `differentiable` path, the derivatives of their displacements.
  bool wants_leaf_points(std::size_t point, bool differentiable) const;
  /// The load that grows, among the constant ones, where critical factors are wanted.
  std::optional<std::size_t> growing_load() const;
  bool wants_capacity() const { return outputs.has(Output::load_capacity) && capacity.any(); }
  bool wants_stroke_capacity() const {
    return outputs.has(Output::stroke_capacity) && !stroke_capacity.empty();
  }
};

}  // namespace flexopt
