#pragma once
// What a designer asks of a mechanism over its stroke, and what comes back. Plain data.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/elements/leaf/leaf_results.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"

namespace flexopt {

/// A material point of a leaf's mid-surface whose displacement is wanted.
struct Probe {
  std::string name;
  int leaf = 0;
  double along = 0, across = 0;  ///< place on the leaf, each in [0, 1]
};

/// The probe at a place of the undeflected mechanism (its foot on the mid-surface), if a leaf is
/// there.
std::optional<Probe> probe_at(const Mechanism& mechanism, std::string name, const Vector3d& place);

struct StrokeRequest {
  std::vector<double> points{0.0};   ///< stroke of the drive, in the order wanted [m or rad]
  Vector6d load = Vector6d::Zero();  ///< dead load at O: force [N], moment [N m], global axes
  /// Nothing is driven: the points are factors of this dead load at O, which comes to `load`.
  std::optional<Vector6d> load_path;
  std::vector<Probe> probes;
  int frequencies = 0;                ///< how many, drive free and drive locked each
  bool frequency_derivatives = true;  ///< beside them, where there is a stroke
  /// Without it no equilibrium is solved but the undeflected one: the points only get what the
  /// frequency derivatives foretell.
  bool path = true;
  /// Every point is finished on full leaves, to which reduced ones only lead, and its frequencies
  /// are those of the whole mechanism to rounding (else Ritz values, up to some 1e-5 above them):
  /// what exact derivatives belong to. No more than `frequencies_free` and `frequencies_locked` of
  /// them.
  bool exact = false;
  std::optional<int> frequencies_free, frequencies_locked;
  bool parasitic_with_drive_locked = true;  ///< which list the parasitic frequency is taken from
  bool parasitic_skips_leaf_modes = false;
  bool parasitic_skips_intermediate_modes = false;
  bool stress = true;  ///< largest von Mises stress
  /// Of exact points, how many places of large stress are wanted: PathPoint::stress_peaks.
  int stress_peaks = 0;
  bool shapes = false;  ///< deformed mid-surfaces for drawing
  NewtonOptions newton;
};

enum class PointStatus {
  converged,
  no_equilibrium,  ///< Newton failed although the step was halved; the message has the figures
  not_reached      ///< the path ended before this point
};

enum class ModeKind { drive, end_effector, intermediate_body, leaf };

struct Mode {
  double frequency = 0;  ///< [Hz]
  ModeKind kind = ModeKind::end_effector;
  /// Share of the modal kinetic energy, each in [0, 1]; drive + end_effector + intermediate_body +
  /// leaf = 1.
  double drive = 0, end_effector = 0, intermediate_body = 0, leaf = 0;
  /// Motion of the bodies in their own axes and of stations of the leaves, times the root of their
  /// mass: for telling which mode is which at another stroke.
  VectorXd motion;
};

/// How the square of a natural frequency, drive free, leaves its value at the undeflected state
/// (dead load applied) along the path of equilibria: equations (21) to (24) of README.md.
struct FrequencyDerivatives {
  int index = 0;                                   ///< among the undeflected frequencies, ascending
  Mode mode;                                       ///< at the undeflected state
  double omega2 = 0, d_omega2 = 0, d2_omega2 = 0;  ///< [rad²/s²], per stroke, per stroke²
  double compliance = 0, d_compliance = 0, d2_compliance = 0;  ///< of 1/ω²
  /// Stroke up to which the parabola is within 2 % of the path; nothing if it is to the path's end.
  std::optional<double> omega2_valid_to, compliance_valid_to;
};

/// One equilibrium of the stroke path. 6×6 order [ux uy uz rx ry rz] at the moved O, global axes.
struct PathPoint {
  double stroke = 0;  ///< [m or rad]
  PointStatus status = PointStatus::not_reached;
  std::string message;
  int newton_iterations = 0;  ///< of the last step onto this point
  int sub_steps = 1;

  double drive_load = 0;                          ///< [N or N m]
  Vector3d displacement = Vector3d::Zero();       ///< of O [m]
  Vector3d rotation = Vector3d::Zero();           ///< rotation vector of the end-effector [rad]
  Matrix6d compliance_free = Matrix6d::Zero();    ///< drive free
  Matrix6d compliance_locked = Matrix6d::Zero();  ///< drive held; zero row and column at the drive
  std::array<std::optional<double>, 6> support_stiffness;    ///< 1/C_dd locked [N/m or N m/rad]
  double drive_stiffness = 0;                                ///< 1/C_dd free
  std::vector<double> frequencies_free, frequencies_locked;  ///< ascending [Hz]
  std::vector<Mode> modes_free, modes_locked;
  std::optional<double> parasitic_frequency;  ///< [Hz]
  /// The same foretold from the undeflected state: README.md (25) [Hz].
  std::optional<double> parasitic_frequency_screening;
  std::optional<StressPeak> max_stress;
  /// The largest of the local maxima of all leaves, from `max_stress` down to 0.8 of it; as many
  /// as were asked for or fewer.
  std::vector<StressPeak> stress_peaks;
  std::optional<double> buckling_load_factor;  ///< of the dead load
  bool stable = true;       ///< the tangent with the drive held has no negative eigenvalue
  int negative_pivots = 0;  ///< inertia of that tangent
  std::vector<LeafReport> leaves;
  std::vector<LeafShape> shapes;
  std::vector<Vector3d> probes;  ///< displacements, in the order of the request [m]
};

/// Whether the parasitic frequency may be that of this mode: not the drive's, nor of a kind that
/// the request skips.
bool is_parasitic(const Mode& mode, const StrokeRequest& request);

enum class Status { ok, no_equilibrium };

struct StrokeResponse {
  Status status = Status::ok;
  std::string message;
  std::vector<PathPoint> path;  ///< one for each requested point, in that order
  std::vector<FrequencyDerivatives> frequency_derivatives;
  double seconds_coefficients = 0, seconds_path = 0, seconds_derivatives = 0;
};

/// Follows the stroke from the undeflected state and evaluates every point.
StrokeResponse evaluate_stroke(const Mechanism& mechanism, const ModelOptions& model,
                               const StrokeRequest& request);

/// A scalar that objectives, constraints and columns can name.
struct Quantity {
  std::string name;  ///< "drive_load", "support_stiffness.ux", "displacement.x", …
  std::string unit;  ///< SI; "N or N m" is resolved with the drive
};

/// Every quantity a path point offers for this drive, in a fixed order.
std::vector<Quantity> quantities(Direction drive);

/// Value of a quantity at a point; nothing if the point has none (not converged, not asked for).
/// `parasitic_frequency_screening` needs no converged point.
/// The name must be one of `quantities`.
std::optional<double> value_of(const PathPoint& point, std::string_view name);

}  // namespace flexopt
