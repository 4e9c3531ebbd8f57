// The rows of the table of quantities, by topic.
#include "core/response/principal_stiffness.hpp"
#include "core/response/quantities.hpp"

namespace flexopt {
namespace {

constexpr int most_frequencies = 12;  // that have names of their own

std::optional<double> entry(const std::vector<double>& list, int k) {
  if (k >= static_cast<int>(list.size())) return std::nullopt;
  return list[static_cast<std::size_t>(k)];
}

std::optional<VectorXd> row_of(const MatrixXd& rows, int k) {
  if (k >= rows.rows()) return std::nullopt;
  return VectorXd(rows.row(k));
}

std::optional<VectorXd> filled(const VectorXd& gradient) {
  if (gradient.size() == 0) return std::nullopt;
  return gradient;
}

// Component k of what a point has of a number.
std::optional<double> component(std::optional<double> number, int) { return number; }
std::optional<double> component(const std::vector<double>& list, int k) { return entry(list, k); }
std::optional<double> component(const Vector3d& vector, int k) { return vector[k]; }
template <class T>
std::optional<double> component(const std::optional<T>& with_value, int) {
  return with_value ? std::optional(with_value->value) : std::nullopt;
}
std::optional<double> component(const std::optional<Envelope>& envelope, int k) {
  if (!envelope) return std::nullopt;
  return k < 3 ? envelope->box[k] : envelope->cylinder;
}
template <class T, std::size_t n>
std::optional<T> component(const std::array<std::optional<T>, n>& list, int k) {
  return list[static_cast<std::size_t>(k)];
}
template <class T>
std::optional<T> component(const std::vector<std::optional<T>>& list, int k) {
  const auto i = static_cast<std::size_t>(k);
  return i < list.size() ? list[i] : std::nullopt;
}
std::optional<VectorXd> component(const std::optional<VectorXd>& gradient, int) { return gradient; }
std::optional<VectorXd> component(const MatrixXd& rows, int k) { return row_of(rows, k); }

template <auto member>
std::optional<double> value_at(const PathPoint& point, int k) {
  return component(point.*member, k);
}
template <auto member>
std::optional<VectorXd> rate_at(const PathPoint&, const PointGradients& gradients, int k) {
  return component(gradients.*member, k);
}

std::string plain_number(Direction, int) { return "1"; }
std::string metre(Direction, int) { return "m"; }
std::string radian(Direction, int) { return "rad"; }
std::string kilogram(Direction, int) { return "kg"; }
std::string hertz(Direction, int) { return "Hz"; }
std::string pascal(Direction, int) { return "Pa"; }
std::string load_of_drive(Direction drive, int) { return load_unit(drive); }
std::string stiffness_of_drive(Direction drive, int) { return stiffness_unit(drive); }
std::string stiffness_of_component(Direction, int d) {
  return stiffness_unit(static_cast<Direction>(d));
}

std::vector<std::string> axes() { return {"x", "y", "z"}; }

std::vector<std::string> directions() { return {direction_names.begin(), direction_names.end()}; }

std::vector<std::string> ranks() {
  std::vector<std::string> names;
  for (int k = 0; k < most_frequencies; ++k) names.push_back(std::to_string(k));
  return names;
}

// Value of drive k. The value of the first drive is also stored on its own, as `first`.
std::optional<double> of_drive(double first, const std::vector<double>& all, int k) {
  return k == 0 ? std::optional(first) : entry(all, k);
}
std::optional<VectorXd> of_drive(const VectorXd& first, const MatrixXd& all, int k) {
  return k == 0 ? filled(first) : row_of(all, k);
}

std::vector<std::string> sizes() { return {"x", "y", "z", "cylinder"}; }

std::optional<double> critical_factor(const PathPoint& p, int drive) {
  if (!p.buckling) return std::nullopt;
  return (drive == 0 ? p.buckling->drive_locked : p.buckling->drive_free).factor;
}

std::string load_of_component(Direction, int d) { return load_unit(static_cast<Direction>(d % 6)); }

std::vector<std::string> signed_directions() {
  std::vector<std::string> names = directions();
  for (const std::string& name : directions()) names.push_back("-" + name);
  return names;
}

std::vector<QuantityRow> make_rows() {
  return {
      {.name = "drive_load",
       .label = "drive load",
       .meaning = "derivative of the energy by the stroke, all other strokes and loads kept",
       .needs = {Output::equilibrium},
       .unit = load_of_drive,
       .value = [](const PathPoint& p, int k) { return of_drive(p.drive_load, p.drive_loads, k); },
       .gradient = [](const PathPoint&, const PointGradients& g,
                      int k) { return of_drive(g.drive_load, g.drive_loads, k); },
       .error = ErrorKind::load,
       .of_drives = true,
       .in_summary = SummaryLine::number,
       .in_report = true},
      {.name = "drive_stiffness",
       .label = "drive stiffness",
       .meaning = "derivative of the drive load by its stroke, other drives locked",
       .needs = {Output::stiffness},
       .unit = stiffness_of_drive,
       .value = [](const PathPoint& p,
                   int k) { return of_drive(p.drive_stiffness, p.drive_stiffnesses, k); },
       .gradient = [](const PathPoint&, const PointGradients& g,
                      int k) { return of_drive(g.drive_stiffness, g.drive_stiffnesses, k); },
       .error = ErrorKind::stiffness,
       .of_drives = true,
       .in_report = true},
      {.name = "support_stiffness",
       .components = directions(),
       .layout = Layout::object,
       .label = "support stiffness",
       .meaning = "1/C_dd with the drive locked, all other directions free",
       .needs = {Output::stiffness},
       .unit = stiffness_of_component,
       .value = value_at<&PathPoint::support_stiffness>,
       .gradient = rate_at<&PointGradients::support_stiffness>,
       .error = ErrorKind::stiffness,
       .of_supports = true,
       .in_summary = SummaryLine::weakest,
       .in_report = true},
      {.name = "displacement",
       .components = axes(),
       .layout = Layout::list,
       .label = "displacement of O",
       .needs = {Output::equilibrium},
       .unit = metre,
       .value = value_at<&PathPoint::displacement>,
       .gradient = rate_at<&PointGradients::displacement>,
       .error = ErrorKind::motion},
      {.name = "rotation",
       .components = axes(),
       .layout = Layout::list,
       .label = "rotation of the end-effector",
       .needs = {Output::equilibrium},
       .unit = radian,
       .value = value_at<&PathPoint::rotation>,
       .gradient = rate_at<&PointGradients::rotation>,
       .error = ErrorKind::motion},
      {.name = "parasitic_frequency",
       .label = "parasitic frequency",
       .needs = {Output::parasitic_frequency},
       .unit = hertz,
       .value = value_at<&PathPoint::parasitic_frequency>,
       .gradient = rate_at<&PointGradients::parasitic_frequency>,
       .error = ErrorKind::frequency,
       .in_summary = SummaryLine::number,
       .in_report = true},
      {.name = "parasitic_frequency_screening",
       .label = "parasitic frequency, screening",
       .needs = {Output::frequency_derivatives},
       .unit = hertz,
       .value = value_at<&PathPoint::parasitic_frequency_screening>,
       .gradient = rate_at<&PointGradients::parasitic_frequency_screening>},
      {.name = "frequencies.drive_free",
       .components = ranks(),
       .layout = Layout::list,
       .label = "frequency, drive free,",
       .needs = {Output::frequencies_free},
       .unit = hertz,
       .value = value_at<&PathPoint::frequencies_free>,
       .gradient = rate_at<&PointGradients::frequencies_free>,
       .error = ErrorKind::frequency,
       .in_csv = false},
      {.name = "frequencies.drive_locked",
       .components = ranks(),
       .layout = Layout::list,
       .label = "frequency, drive locked,",
       .needs = {Output::frequencies_locked},
       .unit = hertz,
       .value = value_at<&PathPoint::frequencies_locked>,
       .gradient = rate_at<&PointGradients::frequencies_locked>,
       .error = ErrorKind::frequency,
       .in_csv = false},
      {.name = "max_stress",
       .label = "largest von Mises stress",
       .needs = {Output::stress},
       .unit = pascal,
       .value = value_at<&PathPoint::max_stress>,
       .gradient = rate_at<&PointGradients::max_stress>,
       .error = ErrorKind::stress,
       .in_summary = SummaryLine::number,
       .in_report = true},
      {.name = "notch_stress",
       .label = "largest stress with fillets",
       .meaning = "largest von Mises stress, at clamped edges with the stress concentration "
                  "factors of the job's fillet",
       .needs = {Output::stress},
       .unit = pascal,
       .value = value_at<&PathPoint::notch_stress>,
       .gradient = rate_at<&PointGradients::notch_stress>,
       .error = ErrorKind::stress,
       .in_report = true},
      {.name = "yield_safety",
       .label = "safety against yield",
       .meaning = "yield_strength over the largest von Mises stress, with the fillet if the job "
                  "has one; the least of all leaves",
       .needs = {Output::stress},
       .unit = plain_number,
       .value = value_at<&PathPoint::yield_safety>,
       .gradient = rate_at<&PointGradients::yield_safety>,
       .error = ErrorKind::stress,
       .in_report = true},
      {.name = "fatigue_safety",
       .label = "safety against fatigue",
       .meaning = "factor on the worst cycle between the point and any other of the path (or on "
                  "that of the job's stress ratio) to the line of Goodman, Gerber or Soderberg; "
                  "the least of all leaves",
       .needs = {Output::stress},
       .unit = plain_number,
       .value = value_at<&PathPoint::fatigue_safety>,
       .gradient = rate_at<&PointGradients::fatigue_safety>,
       .error = ErrorKind::stress,
       .in_report = true},
      {.name = "fatigue_life",
       .label = "log10 of the cycles to failure",
       .meaning = "decimal logarithm of the cycles to failure by the S-N curve, under the worst "
                  "cycle between the point and any other of the path (or that of the job's stress "
                  "ratio); the least of all leaves; beyond the knee and the ends of the curve by "
                  "the straight line that goes on there",
       .needs = {Output::stress},
       .unit = plain_number,
       .value = value_at<&PathPoint::fatigue_life>,
       .gradient = rate_at<&PointGradients::fatigue_life>,
       .error = ErrorKind::stress,
       .in_report = true},
      {.name = "principal_stiffness",
       .label = "principal stiffness",
       .meaning = "smallest support stiffness of all translations that the held drive leaves, with "
                  "its direction: 1 over the largest eigenvalue of C's translations",
       .needs = {Output::stiffness},
       .unit = [](Direction, int) { return stiffness_unit(Direction::ux); },
       .value = [](const PathPoint& p, int k) { return component(principal_stiffness(p), k); },
       .gradient = [](const PathPoint& p, const PointGradients& g,
                      int) { return principal_stiffness_gradient(p, g); },
       .direction = [](const PathPoint& p) -> std::optional<Vector3d> {
         const auto softest = principal_stiffness(p);
         return softest ? std::optional(softest->direction) : std::nullopt;
       },
       .error = ErrorKind::stiffness,
       .in_summary = SummaryLine::number,
       .in_report = true},
      {.name = "envelope",
       .components = sizes(),
       .layout = Layout::object,
       .label = "envelope, undeflected,",
       .meaning = "x, y, z: of the smallest box along the axes that holds leaves and boxes of "
                  "bodies, undeflected; cylinder: diameter of the smallest cylinder about the "
                  "axis of the turning drive through O (along z where none turns); moving: the "
                  "same over the whole stroke",
       .needs = {Output::envelope},
       .unit = metre,
       .value = value_at<&PathPoint::envelope>,
       .gradient = rate_at<&PointGradients::envelope>,
       .of_design = true},
      {.name = "envelope.moving",
       .components = sizes(),
       .layout = Layout::object,
       .label = "envelope over the stroke,",
       .needs = {Output::moving_envelope},
       .unit = metre,
       .value = value_at<&PathPoint::moving_envelope>,
       .gradient = rate_at<&PointGradients::moving_envelope>,
       .of_design = true},
      {.name = "leaf_mass",
       .label = "mass of the leaves",
       .needs = {Output::envelope},
       .unit = kilogram,
       .value = value_at<&PathPoint::leaf_mass>,
       .gradient = rate_at<&PointGradients::leaf_mass>,
       .of_design = true},
      {.name = "clearance",
       .label = "clearance",
       .meaning = "smallest distance between leaves, and between leaves and boxes of bodies that "
                  "do not hold them; leaves that are one piece at an edge (folds, hubs) do not "
                  "count as a pair",
       .needs = {Output::clearance},
       .unit = metre,
       .value = value_at<&PathPoint::clearance>,
       .gradient = rate_at<&PointGradients::clearance>,
       .in_report = true},
      {.name = "buckling_load_factor",
       .label = "buckling load factor",
       .meaning = "by which the load that `buckling` names must be multiplied, all else kept, "
                  "until the tangent with the drive locked is singular, followed along the "
                  "equilibria; below zero where only the reversed load does so",
       .needs = {Output::equilibrium, Output::buckling},
       .unit = plain_number,
       .value = [](const PathPoint& p, int) { return critical_factor(p, 0); },
       .gradient = rate_at<&PointGradients::buckling_locked>,
       .in_report = true},
      {.name = "buckling",
       .components = {"drive_locked", "drive_free"},
       .layout = Layout::object,
       .label = "buckling load factor,",
       .meaning = "drive_locked: strokes kept while the load grows; drive_free: loads of the "
                  "drives kept; linearised: foretold from the state of the point",
       .needs = {Output::equilibrium, Output::buckling},
       .unit = plain_number,
       .value = critical_factor,
       .gradient = [](const PathPoint&, const PointGradients& g,
                      int drive) { return drive == 0 ? g.buckling_locked : g.buckling_free; }},
      {.name = "bandwidth",
       .label = "bandwidth of the drive",
       .meaning = "frequency up to which the drive moves one mass on its spring: where the mass "
                  "that it feels first is the square root of 2 (3 dB) times that at rest",
       .needs = {Output::equilibrium, Output::dynamics},
       .unit = hertz,
       .value = value_at<&PathPoint::bandwidths>,
       .gradient = rate_at<&PointGradients::bandwidths>,
       .error = ErrorKind::frequency,
       .of_drives = true,
       .in_report = true},
      {.name = "transmissibility",
       .label = "transmissibility",
       .meaning = "largest gain over the band from a harmonic translation of the ground to the "
                  "absolute one of O in the same direction",
       .needs = {Output::equilibrium, Output::dynamics},
       .unit = plain_number,
       .value = value_at<&PathPoint::transmissibility>,
       .gradient = rate_at<&PointGradients::transmissibility>,
       .error = ErrorKind::frequency,
       .in_report = true},
      {.name = "load_capacity",
       .components = signed_directions(),
       .layout = Layout::object,
       .label = "load capacity",
       .meaning = "largest dead load at O along (or, with -, against) a direction, beside the "
                  "loads that act, drives held, before the stress limit, a singular tangent or "
                  "the stated loss of support stiffness; load_capacity_limit says which",
       .needs = {Output::equilibrium, Output::load_capacity},
       .unit = load_of_component,
       .value = [](const PathPoint& p, int d) -> std::optional<double> {
         const auto& capacity = p.load_capacity[static_cast<std::size_t>(d)];
         if (!capacity || capacity->limit == CapacityLimit::none) return std::nullopt;
         return capacity->value;
       },
       .gradient = rate_at<&PointGradients::load_capacity>,
       .error = ErrorKind::stress,  // which often ends it
       .of_supports = true,
       .in_report = true}};
}

}  // namespace

const std::vector<QuantityRow>& quantity_rows() {
  static const std::vector<QuantityRow> rows = make_rows();
  return rows;
}

}  // namespace flexopt
