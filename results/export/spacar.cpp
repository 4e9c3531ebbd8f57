#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iterator>

#include "core/response/quantities.hpp"
#include "results/export/spacar_model.hpp"
#include "results/export/writers.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace {

template <class Out>
void write_sets(const SpacarModel& model, Out out) {
  int number = 0;
  for (const SpacarSet& set : model.sets()) {
    ++number;
    fmt::format_to(out, "% {}\neprops({}).elems = [{}];\n", one_line(set.name), number,
                   fmt::join(set.elements, " "));
    const Vector3d& a = set.across;
    fmt::format_to(out, "eprops({}).orien = [{:.12g} {:.12g} {:.12g}];\n", number, a[0], a[1],
                   a[2]);
    fmt::format_to(out, "eprops({}).nbeams = {};\n", number, set.beams);
    if (!set.material) {
      fmt::format_to(out, "eprops({}).color = 'darkblue';\n", number);
      continue;
    }
    const Material& m = *set.material;
    fmt::format_to(out, "eprops({}).emod = {:.12g};\neprops({}).smod = {:.12g};\n", number,
                   m.youngs_modulus, number, m.shear_modulus());
    fmt::format_to(out, "eprops({}).dens = {:.12g};\n", number, m.density);
    if (set.round)
      fmt::format_to(out, "eprops({}).cshape = 'circ';\neprops({}).dim = {:.12g};\n", number,
                     number, set.width);
    else
      fmt::format_to(out,
                     "eprops({}).cshape = 'rect';\neprops({}).dim = [{:.12g} {:.12g}];\n"
                     "eprops({}).warping = true;\n",
                     number, number, set.width, set.thickness, number);
    fmt::format_to(out, "eprops({}).flex = 1:6;\neprops({}).color = 'grey';\n", number, number);
  }
}

/// What to look at in the answer, and flexopt's numbers.
template <class Out>
void write_comparison(const Exported& exported, const SpacarModel& model, const PathPoint& point,
                      Out out) {
  const Mechanism& m = exported.mechanism;
  fmt::format_to(out, "\n%% COMPARISON: flexopt, beams at full accuracy\n");
  const int O = model.reference_of(m.end_effector);
  for (std::size_t k = 0; exported.request.loads.driven() && k < m.drives.size(); ++k) {
    const Drive& drive = m.drives[k];
    const bool turn = is_rotation(drive.direction);
    fmt::format_to(out, "% drive load {} = {:.9g} {}: out.step(end).node({}).{}({})\n",
                   direction_names[static_cast<std::size_t>(index(drive.direction))],
                   point.drive_loads[k], load_unit(drive.direction), model.reference_of(drive.body),
                   turn ? "Mreac" : "Freac", index(drive.direction) % 3 + 1);
  }
  for (std::size_t d = 0; d < 6; ++d)
    if (point.support_stiffness[d])
      fmt::format_to(out,
                     "% support stiffness {} = {:.9g} {}: 1/out.step(end).node({}).CMglob({},{})\n",
                     direction_names[d], *point.support_stiffness[d], d < 3 ? "N/m" : "N m/rad", O,
                     d + 1, d + 1);
}

}  // namespace

std::string spacar_script(const Exported& exported, const VectorXd& strokes) {
  SpacarModel model(exported);
  model.drive(strokes);
  ModelOptions beams = exported.model;
  beams.accuracy = Accuracy::full;
  beams.flexure = Flexure::beam;
  const PathPoint point = exported.equilibria({strokes}, beams, {Output::stiffness}).front();
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out,
                 "% {}: flexopt {} wrote this script for SPACAR Light. SI units.\n% stroke: {}\n"
                 "clear\n\n%% NODES\nnodes = [\n",
                 one_line(exported.name), version(), one_line(exported.stroke_text(strokes)));
  for (const Vector3d& p : model.nodes())
    fmt::format_to(out, "  {:.12g} {:.12g} {:.12g};\n", p[0], p[1], p[2]);
  text += "];\n\n%% ELEMENTS\nelements = [\n";
  for (const auto& [p, q] : model.elements()) fmt::format_to(out, "  {} {};\n", p, q);
  text += "];\n\n%% NODE PROPERTIES\n";
  for (const auto& [node, lines] : model.properties())
    for (const std::string& line : lines) fmt::format_to(out, "nprops({}).{};\n", node, line);
  text += "\n%% ELEMENT PROPERTIES\n";
  write_sets(model, out);
  text += "\n%% OPTIONS\nopt.filename = 'flexopt_export';\nopt.loadsteps = 10;\n";
  if (const Vector3d& g = exported.request.loads.gravity; !g.isZero(0))
    fmt::format_to(out, "opt.gravity = [{:.12g} {:.12g} {:.12g}];\n", g[0], g[1], g[2]);
  text += "\n%% CALL\nout = spacarlight(nodes, elements, nprops, eprops, opt);\n";
  write_comparison(exported, model, point, out);
  return text;
}

}  // namespace flexopt
