#pragma once
// What comes back from the evaluation of a stroke. Plain data.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/elements/leaf/leaf_results.hpp"
#include "core/math/answer.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/response/request.hpp"

namespace flexopt {

enum class PointStatus {
  converged,
  /// Newton failed although the step was halved, or numbers about an equilibrium were not found;
  /// the message has the figures.
  no_equilibrium,
  left_branch,   ///< the branch of the way to the point ends, or could not be followed to it
  not_reached,   ///< the path ended before this point
  limit_reached  ///< the limits of the request ended the evaluation before this point was done
};

struct Mode {
  double frequency = 0;  ///< [Hz]; negative of a motion that grows
  /// Rate at which the oscillation of a pair of modes that flutters grows [1/s]; else 0.
  double growth_rate = 0;
  ModeKind kind = ModeKind::end_effector;
  /// Share of the modal kinetic energy, each in [0, 1]; drive + end_effector + intermediate_body +
  /// leaf = 1.
  double drive = 0, end_effector = 0, intermediate_body = 0, leaf = 0;
  /// Motion of the bodies in their own axes and of stations of the leaves, times the root of their
  /// mass: for telling which mode is which at another stroke.
  VectorXd motion;
  /// Motion for drawing, where shapes are asked for: displacement of the reference point and spin
  /// of each body, and motion of the points of each LeafShape (x, y, z of one after the other;
  /// empty where the leaf's model does not tell). Global axes, in one common scale.
  VectorXd body_motion;
  std::vector<VectorXd> leaf_motion;
  std::vector<VectorXd> elastic_motion;  ///< likewise, of the points of each ElasticShape
};

/// How the square of a natural frequency, drive free, leaves its value at the undeflected state
/// (dead load applied) along the path of equilibria: equations (S1) to (S4) of README.md.
struct FrequencyDerivatives {
  int drive = 0;                                   ///< whose stroke, the others held
  int index = 0;                                   ///< among the undeflected frequencies, ascending
  Mode mode;                                       ///< at the undeflected state
  double omega2 = 0, d_omega2 = 0, d2_omega2 = 0;  ///< [rad²/s²], per stroke, per stroke²
  double compliance = 0, d_compliance = 0, d2_compliance = 0;  ///< of 1/ω²
  /// Stroke up to which the parabola is within 2 % of the path; nothing if it is to the path's end.
  std::optional<double> omega2_valid_to, compliance_valid_to;
};

/// Frequency derivatives of several drives along a straight way from rest to points of the path.
struct FrequencyWay {
  VectorXd strokes;  ///< of the furthest of the points: there the way's own number is 1
  /// Derivatives and valid_to by that number: parts of the way; `drive` means nothing.
  std::vector<FrequencyDerivatives> modes;
};

/// How far a body is from where it was undeflected.
struct BodyMotion {
  Vector3d displacement = Vector3d::Zero();  ///< of its reference point [m]
  Vector3d rotation = Vector3d::Zero();      ///< rotation vector [rad]
};

/// A stable equilibrium at the strokes (or loads) of a point: its own, or one on the branches that
/// meet its own.
struct StableState {
  double energy = 0;  ///< of leaves, bodies, springs and dead forces; undeflected 0 [J]
  BodyMotion motion;  ///< of the end-effector
};

/// A material point of a leaf with its thickness or of a body's box, by coordinates of its own:
/// core/response/solids.hpp.
struct SolidPoint {
  int solid = -1;  ///< the leaves first, then the boxes
  Vector3d at = Vector3d::Zero();
};

/// How far a mechanism reaches in one state.
struct Extents {
  Vector3d low = Vector3d::Zero(), high = Vector3d::Zero();  ///< along the global axes [m]
  double radius = 0;                                         ///< about the axis of the cylinder [m]
  std::array<SolidPoint, 7> at;  ///< where: low x, y, z, high x, y, z, radius
};

/// Sizes of the smallest box along the global axes and of the smallest cylinder about its axis.
struct Envelope {
  Vector3d box = Vector3d::Zero();  ///< [m]
  double cylinder = 0;              ///< diameter [m]
};

/// The smallest distance between two parts.
struct Clearance {
  double value = 0;      ///< [m]; negative where leaves overlap
  bool overlap = false;  ///< the points are then those of the middle surfaces
  std::array<SolidPoint, 2> at;
  std::array<Vector3d, 2> places{Vector3d::Zero(), Vector3d::Zero()};  ///< [m]
  std::array<std::string, 2> names;                                    ///< of leaves or bodies
};

/// Factor of a dead load at which the tangent becomes singular, when this load alone grows.
struct CriticalLoad {
  /// Factor of the load on the branch of equilibria; negative where the reversed load
  /// does so and the load itself, followed to its bound, does not.
  std::optional<double> factor;
  /// Factor that the state of the point predicts if its tangent goes on changing as it does there.
  std::optional<double> linearised;
  bool fold = false;  ///< the load is the largest of the branch there; else branches meet
  /// The branch was followed to its bound on both sides, and its tangent is not singular.
  bool none = false;
  /// Largest factor of the request, where the branch was followed so far and none was met.
  std::optional<double> at_least;
  std::string reason;  ///< why there is no factor
  /// Motion of every body in the buckling mode, relative to the largest unknown of bodies and
  /// leaves, with lengths over the longest leaf.
  std::vector<BodyMotion> mode;
};
struct Buckling {
  CriticalLoad drive_locked, drive_free;  ///< strokes kept; loads of the drives kept
};

/// What ends the growth of a load.
enum class CapacityLimit {
  stress,       ///< of a leaf or an elastic body, the limit that is stated or its yield strength
  instability,  ///< singular tangent
  stiffness,    ///< a support stiffness fell to the stated share
  none          ///< none of these as far as it was looked
};
/// The largest load at O along one direction, beside the loads that act; drives as CapacityRule
/// says.
struct LoadCapacity {
  double value = 0;  ///< [N or N m]; of `none` what is carried at least
  CapacityLimit limit = CapacityLimit::none;
  std::string reason;                ///< what happens there, or why the search ended
  bool fold = false;                 ///< of an instability: the load is the largest of its branch
  std::optional<StressPeak> stress;  ///< of a stress
  std::optional<Direction> support;  ///< of a stiffness: which one
  double stiffness = 0;              ///< of a stiffness: its value there [N/m or N m/rad]
};

/// What ends a drive's way.
enum class StrokeLimit {
  stress,          ///< the one that is stated
  yield,           ///< safety of 1
  fatigue,         ///< safety of 1
  stiffness,       ///< a support stiffness falls to the stated share of that at rest
  clearance,       ///< the one that is stated
  drive_load,      ///< the one that is stated
  instability,     ///< a bifurcation
  no_equilibrium,  ///< none is found beyond
  none             ///< none of these as far as it was looked
};
/// The largest stroke of a drive one way, the others at rest.
struct StrokeCapacity {
  double value = 0;  ///< [m or rad], not negative; of `none` what is reached at least
  StrokeLimit limit = StrokeLimit::none;
  std::string reason;                ///< what happens there, or why the search ended
  double drive_load = 0;             ///< there [N or N m]
  std::optional<StressPeak> stress;  ///< the largest there
};

/// Life that counts in goals where there is none: decimal logarithm of the number of cycles.
inline constexpr double longest_life = 30;

/// Strength over stress, for the leaf or elastic body with the least ratio.
struct StressSafety {
  double value = 0;
  StressPeak stress;
};

/// The worst cycle of stress of a point: equations (Y3) to (Y8) of README.md.
struct FatigueCycle {
  double value = 0;          ///< safety, or the decimal logarithm of the cycles to failure
  double amplitude = 0;      ///< effective one, fillet in [Pa]
  double mean = 0;           ///< effective mean, compression below zero [Pa]
  StressPeak stress;         ///< where; the larger von Mises stress of both ends, without position
  std::optional<int> other;  ///< point of the path at the other end; nothing: by a stress ratio
  LifeRange range = LifeRange::within;  ///< of a life
};

/// The largest gain from the ground to O, or to a named point.
struct Transmissibility {
  double value = 0;      ///< absolute motion over that of the ground
  double frequency = 0;  ///< where [Hz]
};

/// Why there is no bandwidth.
struct NoBandwidth {
  std::string reason;  ///< empty: the line that it would be read off does not end
  /// Up to where the line was followed without an end, where it is not known beyond [Hz].
  std::optional<double> at_least;
};

/// From a load or a motion at a named point to the motion of another.
struct Transfer {
  /// At rest: motion over load [m/N, rad/N, m/(N m), rad/(N m)], or over motion [1, rad/m, m/rad].
  double compliance = 0;
  /// Frequency [Hz]: of a load where the mass that it feels leaves that at rest by √2, up or down;
  /// of a motion where the ratio first falls to that at rest over √2.
  std::optional<double> bandwidth;
  NoBandwidth no_bandwidth;  ///< where it is missing
};

/// What a strain gauge reads.
struct GaugeReading {
  double strain = 0;
  Vector3d stress = Vector3d::Zero();  ///< σ11 along the leaf, σ22, σ12 of the surface [Pa]
};

/// A number that a request names itself: "gauge.g1".
struct NamedNumber {
  std::string row, name;  ///< of the table of quantities; behind the dot
  std::string unit;       ///< SI
  int component = 0;      ///< among the numbers of the row
  std::string quantity() const { return row + "." + name; }
};

/// What goes into a linear model, or comes out of it.
struct Signal {
  std::string name, unit;
};

/// Linear model of small motions about an equilibrium, drive free: equations (H1) to (H3) of
/// modes/README.md. Modes by rows of `forces` and columns of `motions`.
struct StateSpace {
  std::vector<Signal> inputs, outputs;
  VectorXd omega2;    ///< squares of the circular frequencies, ascending [rad²/s²]
  VectorXd damping;   ///< ratio of each mode
  MatrixXd forces;    ///< of the inputs on the modes
  MatrixXd motions;   ///< of the modes at the outputs
  MatrixXd residual;  ///< static answers of all that is not kept: outputs × inputs
};

/// How far an elastic body is from where its model holds.
struct ElasticBodyReport {
  double turn = 0;  ///< largest rotation of an interface in the floating frame [rad]
  /// Largest change of a stiffness by the deformation, relative; of degree 2, which leaves it out,
  /// at least the forces of second order over those of first order. README.md of
  /// core/elements/solid, "Degree 4". Nothing where A is not known, or at rest.
  std::optional<double> geometric_share;
  double degree_error = 0;    ///< what the degree leaves out, relative to a stiffness
  double rigid_residual = 0;  ///< stiffness against rigid motion before it was projected away
  int unknowns = 0;           ///< of its mesh
  /// Largest von Mises stress of the surface, but of cells beside patches; where the stress is
  /// asked for. Nothing of imported matrices.
  std::optional<StressPeak> stress;
  /// The largest difference of the stresses of neighbouring cells from their average around the
  /// place of `stress`: an estimate of its error by the mesh [Pa].
  double stress_jump = 0;
};

/// Deformed surface of an elastic body, by the corners of its cells.
struct ElasticShape {
  std::vector<Vector3d> undeflected, deflected;  ///< [m]
  std::vector<double> von_mises;                 ///< [Pa]
  std::vector<std::array<int, 3>> triangles;     ///< counterclockwise seen from outside
};

/// What a job makes of the quantities of a point by a formula of its own.
struct NamedQuantity {
  std::string name;
  std::optional<double> value;  ///< SI; nothing where the formula or one of its terms has none
};

/// One equilibrium of the stroke path. 6×6 order [ux uy uz rx ry rz] at the moved O, global axes.
/// Stroke, drive load and drive stiffness of several drives: those of the first, and lists.
struct PathPoint {
  double stroke = 0;                     ///< [m or rad]
  std::vector<double> strokes;           ///< of each drive; a point of a load path has none
  std::vector<std::string> drive_names;  ///< of drives with names
  std::vector<NamedNumber> numbers;      ///< that have names by the request
  PointStatus status = PointStatus::not_reached;
  std::string message;
  int newton_iterations = 0;  ///< of the last step onto this point
  int sub_steps = 1;

  double drive_load = 0;                          ///< [N or N m]
  std::vector<double> drive_loads;                ///< of each drive
  Vector3d displacement = Vector3d::Zero();       ///< of O [m]
  Vector3d rotation = Vector3d::Zero();           ///< rotation vector of the end-effector [rad]
  Matrix6d compliance_free = Matrix6d::Zero();    ///< drive free
  Matrix6d compliance_locked = Matrix6d::Zero();  ///< drives held; zero row and column at a drive
  std::array<std::optional<double>, 6> support_stiffness;  ///< 1/C_dd locked [N/m or N m/rad]
  double drive_stiffness = 0;                              ///< own load by own stroke
  std::vector<double> drive_stiffnesses;                   ///< of each drive, the others held
  /// Motion of the end-effector by unit stroke of each drive, the others held, drive by drive six
  /// numbers [m/m, rad/m, m/rad, rad/rad]; none of a drive of the end-effector along a global axis,
  /// nor in the direction of one.
  std::vector<std::optional<double>> gain;
  /// Gain over the motion along the drive's output (gain.hpp). It has no value in the direction of
  /// a drive of the end-effector, nor where the drive has no output.
  std::vector<std::optional<double>> cross_coupling;
  /// Of each drive current [A] and power [W] of its voice coil, and stroke that is left [m], share
  /// of the voltage and amplification of its piezo stack, drive by drive: actuators.hpp.
  std::vector<std::optional<double>> voice_coil, piezo;
  std::vector<double> frequencies_free, frequencies_locked;  ///< ascending [Hz]
  std::vector<Mode> modes_free, modes_locked;
  std::optional<double> parasitic_frequency;  ///< [Hz]
  /// Parasitic frequency predicted from the undeflected state: README.md (S5) [Hz].
  std::optional<double> parasitic_frequency_screening;
  std::optional<StressPeak> max_stress;
  /// Least allowable over largest stress, of the parts whose material tells one; without fillets.
  std::optional<StressSafety> allowable_safety;  ///< nothing above no_critical_factor
  std::optional<StressPeak> notch_stress;  ///< with the factors of the fillets at clamped edges
  /// Least safety against yield; nothing above no_critical_factor.
  std::optional<StressSafety> yield_safety;
  std::optional<FatigueCycle> fatigue_safety;  ///< nothing above no_critical_factor
  std::optional<FatigueCycle> fatigue_life;    ///< nothing above longest_life
  std::string fatigue_fault;                   ///< why there is no safety or life
  /// σ11 along the leaf, σ22, σ12 [Pa], fillet in, at the one place of the path's least safety (or
  /// least life); where the history of stress is looked at.
  std::optional<Vector3d> fatigue_stress;
  /// For every leaf, a SectionStress for each of StrokeResponse::stress_places, in columns; then
  /// for every elastic body the stress (11, 22, 33, 23, 13, 12, its own axes). Kept until the path
  /// has ended; empty in the result.
  std::vector<MatrixXd> sections;
  /// Why a fillet has no factor; notch_stress, yield_safety and what is of fatigue are then
  /// missing.
  std::string fillet_fault;
  /// The largest of the local maxima of all leaves and elastic bodies, from `max_stress` down to
  /// 0.8 of it; as many as were asked for or fewer.
  std::vector<StressPeak> stress_peaks;
  /// Undeflected, and over the whole stroke with the undeflected state: the same at every point.
  std::optional<Envelope> envelope, moving_envelope;
  std::optional<double> leaf_mass;  ///< [kg]; the same at every point
  std::optional<Extents> extents;   ///< of this point
  std::optional<Clearance> clearance;
  std::optional<Buckling> buckling;  ///< by the load that the request names
  /// Bandwidth of each drive, the others held [Hz]: where its mass line ends.
  std::vector<std::optional<double>> bandwidths;
  std::vector<NoBandwidth> no_bandwidth;  ///< of each drive, where it is missing
  std::optional<Transmissibility> transmissibility;
  std::string no_transmissibility;  ///< why it is missing
  std::vector<Transfer> transfers;  ///< as DynamicsRule
  std::optional<StateSpace> state_space;
  /// Load capacities by direction: CapacityRule.
  std::array<std::optional<LoadCapacity>, 12> load_capacity;
  /// Forward and backward of each drive, one drive after the other: StrokeCapacityRule. The same at
  /// every point.
  std::vector<std::optional<StrokeCapacity>> stroke_capacity;
  /// In the order of the job, once it has filled them in.
  std::vector<NamedQuantity> named_quantities;
  std::vector<StableState> stable_states;  ///< lowest first, where they are asked for
  bool other_branch = false;               ///< the path has left the branch that it came along
  /// The path from rest has lost or regained stability.
  bool bifurcation_passed = false;
  /// The tangent with the drive held (but for drives free of those that LoadCase::held leaves) has
  /// no negative eigenvalue; where loads follow their bodies, no motion grows.
  bool stable = true;
  std::optional<Mode> flutter;  ///< one of the pair that grows fastest
  int negative_pivots = 0;      ///< inertia of that tangent
  std::vector<LeafReport> leaves;
  std::vector<ElasticBodyReport> elastic_bodies;
  std::vector<LeafShape> shapes;
  std::vector<ElasticShape> elastic_shapes;  ///< those of imported matrices have no points
  std::vector<Vector3d> named_points;        ///< displacements, in the order of the request [m]
  /// Motion of each along its direction: displacement, or component of the rotation vector of its
  /// body [m, rad].
  std::vector<std::optional<double>> motions_along;
  std::vector<GaugeReading> gauges;  ///< in the order of the request
  std::vector<double> bridges;       ///< output over supply voltage
  std::vector<BodyMotion> bodies;    ///< of every body of the mechanism
};

enum class Status { ok, no_equilibrium, left_branch, limit_reached };

struct StrokeResponse {
  Status status = Status::ok;
  std::string message;
  /// Why `frequency_derivatives` are missing that were asked for; the message has it too.
  std::string no_frequency_derivatives;
  std::vector<PathPoint> path;  ///< one for each requested point, in that order
  std::vector<FrequencyDerivatives> frequency_derivatives;
  std::vector<FrequencyWay> frequency_ways;  ///< to every point of several drives but rest
  /// For every leaf, then every elastic body, the places whose stress history is kept, as long as
  /// PathPoint::sections are.
  std::vector<std::vector<StressPlace>> stress_places;
  double seconds_coefficients = 0, seconds_path = 0, seconds_derivatives = 0;
};

/// Whether evaluations on such leaves and under such loads have exact derivatives, or why not.
Check has_derivatives(const ModelOptions& model, const LoadCase& loads);

/// Follows the stroke from the undeflected state and evaluates every point.
StrokeResponse evaluate_stroke(const Mechanism& mechanism, const ModelOptions& model,
                               const StrokeRequest& request);

}  // namespace flexopt
