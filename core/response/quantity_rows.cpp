// The rows of the table of quantities, by topic.
#include "core/response/actuators.hpp"
#include "core/response/gain.hpp"
#include "core/response/principal_stiffness.hpp"
#include "core/response/quantity_readers.hpp"

namespace flexopt {
namespace {

constexpr int most_frequencies = 12;  // that have names of their own

// Readers of a member of a point or of its gradients: a number, the value of a peak, a safety or a
// gain, the component of an array.
template <auto Member>
std::optional<double> number(const PathPoint& p, int) {
  return p.*Member;
}
template <auto Member>
std::optional<VectorXd> rate(const PathPoint&, const PointGradients& g, int) {
  return g.*Member;
}
template <auto Member>
std::optional<double> value_within(const PathPoint& p, int) {
  return p.*Member ? std::optional((p.*Member)->value) : std::nullopt;
}
template <auto Member>
std::optional<double> component(const PathPoint& p, int k) {
  return (p.*Member)[k];
}
template <auto Member>
std::optional<VectorXd> component(const PathPoint&, const PointGradients& g, int k) {
  return (g.*Member)[k];
}

// Value of drive k, and its derivatives. Those of the first drive also stand on their own.
template <auto First, auto All>
std::optional<double> of_drive(const PathPoint& p, int k) {
  return k == 0 ? std::optional(p.*First) : entry<All>(p, k);
}
template <auto First, auto All>
std::optional<VectorXd> of_drive(const PathPoint& p, const PointGradients& g, int k) {
  if (k > 0) return rate_row<All>(p, g, k);
  return (g.*First).size() > 0 ? std::optional(g.*First) : std::nullopt;
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

std::vector<std::string> directions() { return {direction_names.begin(), direction_names.end()}; }

std::vector<std::string> ranks() {
  std::vector<std::string> names;
  for (int k = 0; k < most_frequencies; ++k) names.push_back(std::to_string(k));
  return names;
}

std::vector<QuantityRow> load_and_motion() {
  return {
      {.name = "drive_load",
       .label = "drive load",
       .meaning = "derivative of the energy by the stroke, all other strokes and loads kept",
       .needs = {Output::equilibrium},
       .unit = load_of_drive,
       .value = of_drive<&PathPoint::drive_load, &PathPoint::drive_loads>,
       .gradient = of_drive<&PointGradients::drive_load, &PointGradients::drive_loads>,
       .error = ErrorKind::load,
       .of_drives = true,
       .in_summary = SummaryLine::number,
       .in_report = true},
      {.name = "drive_stiffness",
       .label = "drive stiffness",
       .meaning = "derivative of the drive load by its stroke, other drives locked",
       .needs = {Output::stiffness},
       .unit = stiffness_of_drive,
       .value = of_drive<&PathPoint::drive_stiffness, &PathPoint::drive_stiffnesses>,
       .gradient = of_drive<&PointGradients::drive_stiffness, &PointGradients::drive_stiffnesses>,
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
       .value = component<&PathPoint::support_stiffness>,
       .gradient = component<&PointGradients::support_stiffness>,
       .error = ErrorKind::stiffness,
       .of_supports = true,
       .in_summary = SummaryLine::weakest,
       .in_report = true},
      {.name = "displacement",
       .components = {"x", "y", "z"},
       .layout = Layout::list,
       .label = "displacement of O",
       .needs = {Output::equilibrium},
       .unit = metre,
       .value = entry<&PathPoint::displacement>,
       .gradient = rate_row<&PointGradients::displacement>,
       .error = ErrorKind::motion},
      {.name = "rotation",
       .components = {"x", "y", "z"},
       .layout = Layout::list,
       .label = "rotation of the end-effector",
       .needs = {Output::equilibrium},
       .unit = radian,
       .value = entry<&PathPoint::rotation>,
       .gradient = rate_row<&PointGradients::rotation>,
       .error = ErrorKind::motion}};
}

std::vector<QuantityRow> frequencies_and_stress() {
  return {{.name = "parasitic_frequency",
           .label = "parasitic frequency",
           .needs = {Output::parasitic_frequency},
           .unit = hertz,
           .value = number<&PathPoint::parasitic_frequency>,
           .gradient = rate<&PointGradients::parasitic_frequency>,
           .error = ErrorKind::frequency,
           .in_summary = SummaryLine::number,
           .in_report = true},
          {.name = "parasitic_frequency_screening",
           .label = "parasitic frequency, screening",
           .needs = {Output::frequency_derivatives},
           .unit = hertz,
           .value = number<&PathPoint::parasitic_frequency_screening>,
           .gradient = rate<&PointGradients::parasitic_frequency_screening>},
          {.name = "frequencies.drive_free",
           .components = ranks(),
           .layout = Layout::list,
           .label = "frequency, drive free,",
           .needs = {Output::frequencies_free},
           .unit = hertz,
           .value = entry<&PathPoint::frequencies_free>,
           .gradient = rate_row<&PointGradients::frequencies_free>,
           .error = ErrorKind::frequency,
           .in_csv = false},
          {.name = "frequencies.drive_locked",
           .components = ranks(),
           .layout = Layout::list,
           .label = "frequency, drive locked,",
           .needs = {Output::frequencies_locked},
           .unit = hertz,
           .value = entry<&PathPoint::frequencies_locked>,
           .gradient = rate_row<&PointGradients::frequencies_locked>,
           .error = ErrorKind::frequency,
           .in_csv = false},
          {.name = "max_stress",
           .label = "largest von Mises stress",
           .needs = {Output::stress},
           .unit = pascal,
           .value = value_within<&PathPoint::max_stress>,
           .gradient = rate<&PointGradients::max_stress>,
           .error = ErrorKind::stress,
           .in_summary = SummaryLine::number,
           .in_report = true}};
}

std::vector<QuantityRow> stress_safety() {
  return {
      {.name = "notch_stress",
       .label = "largest stress with fillets",
       .meaning = "largest von Mises stress, at clamped edges with the stress concentration "
                  "factors of the job's fillet",
       .needs = {Output::stress},
       .unit = pascal,
       .value = value_within<&PathPoint::notch_stress>,
       .gradient = rate<&PointGradients::notch_stress>,
       .error = ErrorKind::stress,
       .in_report = true},
      {.name = "yield_safety",
       .label = "safety against yield",
       .meaning = "yield_strength over the largest von Mises stress, with the fillet if the job "
                  "has one; the least of all leaves",
       .needs = {Output::stress},
       .unit = plain_number,
       .value = value_within<&PathPoint::yield_safety>,
       .gradient = rate<&PointGradients::yield_safety>,
       .error = ErrorKind::stress,
       .in_report = true},
      {.name = "fatigue_safety",
       .label = "safety against fatigue",
       .meaning = "factor on the worst cycle between the point and any other of the path (or on "
                  "that of the job's stress ratio) to the line of Goodman, Gerber or Soderberg; "
                  "the least of all leaves",
       .needs = {Output::stress},
       .unit = plain_number,
       .value = value_within<&PathPoint::fatigue_safety>,
       .gradient = rate<&PointGradients::fatigue_safety>,
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
       .value = value_within<&PathPoint::fatigue_life>,
       .gradient = rate<&PointGradients::fatigue_life>,
       .error = ErrorKind::stress,
       .in_report = true}};
}

std::vector<QuantityRow> softest_translation() {
  return {{.name = "principal_stiffness",
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
           .in_report = true}};
}

template <auto Member>
std::optional<double> size_of(const PathPoint& p, int k) {
  const std::optional<Envelope>& e = p.*Member;
  return e ? std::optional(k < 3 ? e->box[k] : e->cylinder) : std::nullopt;
}

std::vector<QuantityRow> room_taken() {
  return {
      {.name = "envelope",
       .components = {"x", "y", "z", "cylinder"},
       .layout = Layout::object,
       .label = "envelope, undeflected,",
       .meaning = "x, y, z: of the smallest box along the axes that holds leaves and boxes of "
                  "bodies, undeflected; cylinder: diameter of the smallest cylinder about the "
                  "axis of the turning drive through O (along z where none turns); moving: the "
                  "same over the whole stroke",
       .needs = {Output::envelope},
       .unit = metre,
       .value = size_of<&PathPoint::envelope>,
       .gradient = rate_row<&PointGradients::envelope>,
       .of_design = true},
      {.name = "envelope.moving",
       .components = {"x", "y", "z", "cylinder"},
       .layout = Layout::object,
       .label = "envelope over the stroke,",
       .needs = {Output::moving_envelope},
       .unit = metre,
       .value = size_of<&PathPoint::moving_envelope>,
       .gradient = rate_row<&PointGradients::moving_envelope>,
       .of_design = true},
      {.name = "leaf_mass",
       .label = "mass of the leaves",
       .needs = {Output::envelope},
       .unit = kilogram,
       .value = number<&PathPoint::leaf_mass>,
       .gradient = rate<&PointGradients::leaf_mass>,
       .of_design = true},
      {.name = "clearance",
       .label = "clearance",
       .meaning = "smallest distance between leaves, and between leaves and boxes of bodies that "
                  "do not hold them; leaves that are one piece at an edge (folds, hubs) do not "
                  "count as a pair",
       .needs = {Output::clearance},
       .unit = metre,
       .value = value_within<&PathPoint::clearance>,
       .gradient = rate<&PointGradients::clearance>,
       .in_report = true}};
}

std::optional<double> critical_factor(const PathPoint& p, int drive) {
  if (!p.buckling) return std::nullopt;
  return (drive == 0 ? p.buckling->drive_locked : p.buckling->drive_free).factor;
}

std::optional<double> factor_at_least(const PathPoint& p, int drive) {
  if (!p.buckling) return std::nullopt;
  return (drive == 0 ? p.buckling->drive_locked : p.buckling->drive_free).at_least;
}

std::vector<QuantityRow> buckling() {
  return {{.name = "buckling_load_factor",
           .label = "buckling load factor",
           .meaning = "by which the load that `buckling` names must be multiplied, all else kept, "
                      "until the tangent with the drive locked is singular, followed along the "
                      "equilibria; below zero where only the reversed load does so",
           .needs = {Output::equilibrium, Output::buckling},
           .unit = plain_number,
           .value = [](const PathPoint& p, int) { return critical_factor(p, 0); },
           .gradient = rate<&PointGradients::buckling_locked>,
           .at_least = [](const PathPoint& p, int) { return factor_at_least(p, 0); },
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
                          int drive) { return drive == 0 ? g.buckling_locked : g.buckling_free; },
           .at_least = factor_at_least}};
}

std::vector<QuantityRow> dynamics() {
  return {
      {.name = "bandwidth",
       .label = "bandwidth of the drive",
       .meaning = "frequency up to which the drive moves one mass on its spring: where the mass "
                  "that it feels first is the square root of 2 (3 dB) times that at rest",
       .needs = {Output::equilibrium, Output::dynamics},
       .unit = hertz,
       .value = entry<&PathPoint::bandwidths>,
       .gradient = entry<&PointGradients::bandwidths>,
       .at_least = [](const PathPoint& p, int k) -> std::optional<double> {
         if (k >= std::ssize(p.no_bandwidth)) return std::nullopt;
         return p.no_bandwidth[k].at_least;
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
       .value = value_within<&PathPoint::transmissibility>,
       .gradient = rate<&PointGradients::transmissibility>,
       .error = ErrorKind::frequency,
       .in_report = true}};
}

}  // namespace

const std::vector<QuantityRow>& quantity_rows() {
  static const std::vector<QuantityRow> rows = [] {
    std::vector<QuantityRow> all;
    for (const auto& topic : {load_and_motion(), gain_rows(), actuator_rows(),
                              frequencies_and_stress(), stress_safety(), softest_translation(),
                              room_taken(), buckling(), dynamics(), named_rows(), capacity_rows()})
      all.insert(all.end(), topic.begin(), topic.end());
    return all;
  }();
  return rows;
}

}  // namespace flexopt
