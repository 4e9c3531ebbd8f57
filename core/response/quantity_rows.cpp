// The rows of the table of quantities, by topic.
#include "core/response/principal_stiffness.hpp"
#include "core/response/quantities.hpp"

namespace flexopt {
namespace {

constexpr int most_frequencies = 12;  // that have names of their own

std::optional<double> entry(const std::vector<double>& list, int k) {
  if (k >= static_cast<int>(list.size())) return std::nullopt;
  return list[k];
}

std::optional<double> entry(const Vector3d& vector, int k) {
  if (k >= 3) return std::nullopt;
  return vector[k];
}

std::optional<VectorXd> row_of(const MatrixXd& rows, int k) {
  if (k >= rows.rows()) return std::nullopt;
  return VectorXd(rows.row(k));
}

std::optional<VectorXd> filled(const VectorXd& gradient) {
  if (gradient.size() == 0) return std::nullopt;
  return gradient;
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

std::vector<QuantityRow> load_and_motion() {
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
       .value = [](const PathPoint& p, int d) { return p.support_stiffness[d]; },
       .gradient = [](const PathPoint&, const PointGradients& g,
                      int d) { return g.support_stiffness[d]; },
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
       .value = [](const PathPoint& p, int k) { return entry(p.displacement, k); },
       .gradient = [](const PathPoint&, const PointGradients& g,
                      int k) { return row_of(g.displacement, k); },
       .error = ErrorKind::motion},
      {.name = "rotation",
       .components = axes(),
       .layout = Layout::list,
       .label = "rotation of the end-effector",
       .needs = {Output::equilibrium},
       .unit = radian,
       .value = [](const PathPoint& p, int k) { return entry(p.rotation, k); },
       .gradient = [](const PathPoint&, const PointGradients& g,
                      int k) { return row_of(g.rotation, k); },
       .error = ErrorKind::motion}};
}

std::vector<QuantityRow> frequencies_and_stress() {
  return {{.name = "parasitic_frequency",
           .label = "parasitic frequency",
           .needs = {Output::parasitic_frequency},
           .unit = hertz,
           .value = [](const PathPoint& p, int) { return p.parasitic_frequency; },
           .gradient = [](const PathPoint&, const PointGradients& g,
                          int) { return g.parasitic_frequency; },
           .error = ErrorKind::frequency,
           .in_summary = SummaryLine::number,
           .in_report = true},
          {.name = "parasitic_frequency_screening",
           .label = "parasitic frequency, screening",
           .needs = {Output::frequency_derivatives},
           .unit = hertz,
           .value = [](const PathPoint& p, int) { return p.parasitic_frequency_screening; },
           .gradient = [](const PathPoint&, const PointGradients& g,
                          int) { return g.parasitic_frequency_screening; }},
          {.name = "frequencies.drive_free",
           .components = ranks(),
           .layout = Layout::list,
           .label = "frequency, drive free,",
           .needs = {Output::frequencies_free},
           .unit = hertz,
           .value = [](const PathPoint& p, int k) { return entry(p.frequencies_free, k); },
           .gradient = [](const PathPoint&, const PointGradients& g,
                          int k) { return row_of(g.frequencies_free, k); },
           .error = ErrorKind::frequency,
           .in_csv = false},
          {.name = "frequencies.drive_locked",
           .components = ranks(),
           .layout = Layout::list,
           .label = "frequency, drive locked,",
           .needs = {Output::frequencies_locked},
           .unit = hertz,
           .value = [](const PathPoint& p, int k) { return entry(p.frequencies_locked, k); },
           .gradient = [](const PathPoint&, const PointGradients& g,
                          int k) { return row_of(g.frequencies_locked, k); },
           .error = ErrorKind::frequency,
           .in_csv = false},
          {.name = "max_stress",
           .label = "largest von Mises stress",
           .needs = {Output::stress},
           .unit = pascal,
           .value =
               [](const PathPoint& p, int) {
                 return p.max_stress ? std::optional(p.max_stress->value) : std::nullopt;
               },
           .gradient = [](const PathPoint&, const PointGradients& g, int) { return g.max_stress; },
           .error = ErrorKind::stress,
           .in_summary = SummaryLine::number,
           .in_report = true}};
}

std::optional<double> value_of_safety(const std::optional<StressSafety>& safety) {
  return safety ? std::optional(safety->value) : std::nullopt;
}

std::optional<double> value_of_cycle(const std::optional<FatigueCycle>& cycle) {
  return cycle ? std::optional(cycle->value) : std::nullopt;
}

std::vector<QuantityRow> stress_safety() {
  return {
      {.name = "notch_stress",
       .label = "largest stress with fillets",
       .meaning = "largest von Mises stress, at clamped edges with the stress concentration "
                  "factors of the job's fillet",
       .needs = {Output::stress},
       .unit = pascal,
       .value =
           [](const PathPoint& p, int) {
             return p.notch_stress ? std::optional(p.notch_stress->value) : std::nullopt;
           },
       .gradient = [](const PathPoint&, const PointGradients& g, int) { return g.notch_stress; },
       .error = ErrorKind::stress,
       .in_report = true},
      {.name = "yield_safety",
       .label = "safety against yield",
       .meaning = "yield_strength over the largest von Mises stress, with the fillet if the job "
                  "has one; the least of all leaves",
       .needs = {Output::stress},
       .unit = plain_number,
       .value = [](const PathPoint& p, int) { return value_of_safety(p.yield_safety); },
       .gradient = [](const PathPoint&, const PointGradients& g, int) { return g.yield_safety; },
       .error = ErrorKind::stress,
       .in_report = true},
      {.name = "fatigue_safety",
       .label = "safety against fatigue",
       .meaning = "factor on the worst cycle between the point and any other of the path (or on "
                  "that of the job's stress ratio) to the line of Goodman, Gerber or Soderberg; "
                  "the least of all leaves",
       .needs = {Output::stress},
       .unit = plain_number,
       .value = [](const PathPoint& p, int) { return value_of_cycle(p.fatigue_safety); },
       .gradient = [](const PathPoint&, const PointGradients& g, int) { return g.fatigue_safety; },
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
       .value = [](const PathPoint& p, int) { return value_of_cycle(p.fatigue_life); },
       .gradient = [](const PathPoint&, const PointGradients& g, int) { return g.fatigue_life; },
       .error = ErrorKind::stress,
       .in_report = true}};
}

QuantityRow softest_translation() {
  return {.name = "principal_stiffness",
          .label = "principal stiffness",
          .meaning =
              "smallest support stiffness of all translations that the held drive leaves, with "
              "its direction: 1 over the largest eigenvalue of C's translations",
          .needs = {Output::stiffness},
          .unit = [](Direction, int) { return stiffness_unit(Direction::ux); },
          .value = [](const PathPoint& p, int) -> std::optional<double> {
            const auto softest = principal_stiffness(p);
            return softest ? std::optional(softest->value) : std::nullopt;
          },
          .gradient = [](const PathPoint& p, const PointGradients& g,
                         int) { return principal_stiffness_gradient(p, g); },
          .direction = [](const PathPoint& p) -> std::optional<Vector3d> {
            const auto softest = principal_stiffness(p);
            return softest ? std::optional(softest->direction) : std::nullopt;
          },
          .error = ErrorKind::stiffness,
          .in_summary = SummaryLine::number,
          .in_report = true};
}

std::vector<std::string> sizes() { return {"x", "y", "z", "cylinder"}; }

std::optional<double> size_of(const std::optional<Envelope>& envelope, int k) {
  if (!envelope) return std::nullopt;
  return k < 3 ? envelope->box[k] : envelope->cylinder;
}

std::vector<QuantityRow> room_taken() {
  return {
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
       .value = [](const PathPoint& p, int k) { return size_of(p.envelope, k); },
       .gradient = [](const PathPoint&, const PointGradients& g,
                      int k) { return row_of(g.envelope, k); },
       .of_design = true},
      {.name = "envelope.moving",
       .components = sizes(),
       .layout = Layout::object,
       .label = "envelope over the stroke,",
       .needs = {Output::moving_envelope},
       .unit = metre,
       .value = [](const PathPoint& p, int k) { return size_of(p.moving_envelope, k); },
       .gradient = [](const PathPoint&, const PointGradients& g,
                      int k) { return row_of(g.moving_envelope, k); },
       .of_design = true},
      {.name = "leaf_mass",
       .label = "mass of the leaves",
       .needs = {Output::envelope},
       .unit = kilogram,
       .value = [](const PathPoint& p, int) { return p.leaf_mass; },
       .gradient = [](const PathPoint&, const PointGradients& g, int) { return g.leaf_mass; },
       .of_design = true},
      {.name = "clearance",
       .label = "clearance",
       .meaning = "smallest distance between leaves, and between leaves and boxes of bodies that "
                  "do not hold them; leaves that are one piece at an edge (folds, hubs) do not "
                  "count as a pair",
       .needs = {Output::clearance},
       .unit = metre,
       .value = [](const PathPoint& p,
                   int) { return p.clearance ? std::optional(p.clearance->value) : std::nullopt; },
       .gradient = [](const PathPoint&, const PointGradients& g, int) { return g.clearance; },
       .in_report = true}};
}

std::optional<double> critical_factor(const PathPoint& p, int drive) {
  if (!p.buckling) return std::nullopt;
  return (drive == 0 ? p.buckling->drive_locked : p.buckling->drive_free).factor;
}

std::vector<QuantityRow> buckling() {
  return {
      {.name = "buckling_load_factor",
       .label = "buckling load factor",
       .meaning = "by which the load that `buckling` names must be multiplied, all else kept, "
                  "until the tangent with the drive locked is singular, followed along the "
                  "equilibria; below zero where only the reversed load does so",
       .needs = {Output::equilibrium, Output::buckling},
       .unit = plain_number,
       .value = [](const PathPoint& p, int) { return critical_factor(p, 0); },
       .gradient = [](const PathPoint&, const PointGradients& g, int) { return g.buckling_locked; },
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
       .gradient = [](const PathPoint&, const PointGradients& g, int drive) {
         return drive == 0 ? g.buckling_locked : g.buckling_free;
       }}};
}

std::vector<QuantityRow> dynamics() {
  return {
      {.name = "bandwidth",
       .label = "bandwidth of the drive",
       .meaning = "frequency up to which the drive moves one mass on its spring: where the mass "
                  "that it feels first is the square root of 2 (3 dB) times that at rest",
       .needs = {Output::equilibrium, Output::dynamics},
       .unit = hertz,
       .value = [](const PathPoint& p, int k) -> std::optional<double> {
         const auto i = static_cast<std::size_t>(k);
         return i < p.bandwidths.size() ? p.bandwidths[i] : std::nullopt;
       },
       .gradient = [](const PathPoint&, const PointGradients& g, int k) -> std::optional<VectorXd> {
         const auto i = static_cast<std::size_t>(k);
         return i < g.bandwidths.size() ? g.bandwidths[i] : std::nullopt;
       },
       .error = ErrorKind::frequency,
       .of_drives = true,
       .in_report = true},
      {.name = "transmissibility",
       .label = "transmissibility",
       .meaning = "largest gain over the band from a harmonic translation of the ground to the "
                  "absolute one of O in the same direction",
       .needs = {Output::equilibrium, Output::dynamics},
       .unit = plain_number,
       .value =
           [](const PathPoint& p, int) {
             return p.transmissibility ? std::optional(p.transmissibility->value) : std::nullopt;
           },
       .gradient = [](const PathPoint&, const PointGradients& g,
                      int) { return g.transmissibility; },
       .error = ErrorKind::frequency,
       .in_report = true}};
}

std::string load_of_component(Direction, int d) { return load_unit(static_cast<Direction>(d % 6)); }

std::vector<std::string> signed_directions() {
  std::vector<std::string> names = directions();
  for (const std::string& name : directions()) names.push_back("-" + name);
  return names;
}

QuantityRow load_capacity() {
  return {.name = "load_capacity",
          .components = signed_directions(),
          .layout = Layout::object,
          .label = "load capacity",
          .meaning =
              "largest dead load at O along (or, with -, against) a direction, beside the "
              "loads that act, drives held, before the stress limit, a singular tangent or "
              "the stated loss of support stiffness; load_capacity_limit says which",
          .needs = {Output::equilibrium, Output::load_capacity},
          .unit = load_of_component,
          .value = [](const PathPoint& p, int d) -> std::optional<double> {
            const auto& capacity = p.load_capacity[d];
            if (!capacity || capacity->limit == CapacityLimit::none) return std::nullopt;
            return capacity->value;
          },
          .gradient = [](const PathPoint&, const PointGradients& g,
                         int d) { return g.load_capacity[d]; },
          .error = ErrorKind::stress,  // which often ends it
          .of_supports = true,
          .in_report = true};
}

std::vector<QuantityRow> make_rows() {
  std::vector<QuantityRow> rows = load_and_motion();
  for (auto& row : frequencies_and_stress()) rows.push_back(std::move(row));
  for (auto& row : stress_safety()) rows.push_back(std::move(row));
  rows.push_back(softest_translation());
  for (auto& row : room_taken()) rows.push_back(std::move(row));
  for (auto& row : buckling()) rows.push_back(std::move(row));
  for (auto& row : dynamics()) rows.push_back(std::move(row));
  rows.push_back(load_capacity());
  return rows;
}

}  // namespace

const std::vector<QuantityRow>& quantity_rows() {
  static const std::vector<QuantityRow> rows = make_rows();
  return rows;
}

}  // namespace flexopt
