#include "results/export/spacar_model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>

#include "core/mechanism/joint.hpp"
#include "core/mechanism/profile.hpp"
#include "core/response/quantities.hpp"
#include "core/spec/spec_error.hpp"
#include "results/export/writers.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace {

constexpr double least_length = 1e-5;  ///< least length of an element of SPACAR Light [m]
constexpr int pieces = 12;             ///< elements of a leaf that is bent or has a profile
constexpr std::array<const char*, 3> axis_names{"x", "y", "z"};

std::string triple(const Vector3d& v) {
  return fmt::format("[{:.12g} {:.12g} {:.12g}]", v[0], v[1], v[2]);
}

/// Whether a drive acts along a global axis, in its positive direction.
bool is_global(const Drive& drive) {
  return drive.axes.col(index(drive.direction) % 3)[index(drive.direction) % 3] > 1 - 1e-12;
}

Vector3d middle_of(const LeafSpring& leaf, double s) {
  const ArcPoint<double> at = leaf.middle(s);
  return leaf.origin + leaf.axes.col(0) * (leaf.length * at.x) +
         leaf.axes.col(2) * (leaf.length * at.z);
}

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

SpacarModel::SpacarModel(const Exported& exported)
    : exported_(&exported), group_(rigid_groups(exported.mechanism)) {
  check();
  const Mechanism& m = exported.mechanism;
  for (std::size_t b = 0; b < m.bodies.size(); ++b)
    if (group_[b] != ground) node_on(group_[b], m.bodies[b].reference);
  for (const LeafSpring& leaf : m.leaves) add_leaf(leaf);
  add_masses();
  add_holds();
}

void SpacarModel::check() const {
  const Mechanism& m = exported_->mechanism;
  const LoadCase& loads = exported_->request.loads;
  std::vector<Fault> faults;
  const auto refuse = [&](const std::string& item, const std::string& reason) {
    faults.push_back({"--format", "spacar", item + " is not carried by the script: " + reason});
  };
  for (const LeafSpring& leaf : m.leaves)
    if (leaf.point)
      refuse("body " + m.bodies[static_cast<std::size_t>(leaf.point->body)].name,
             "it is a material point of leaf " + leaf.name);
  for (const Joint& joint : m.joints)
    if (joint.type != JointType::rigid)
      refuse("joint " + joint.name, "SPACAR Light fixes nodes along the axes alone");
  for (const Spring& spring : m.springs)
    refuse("spring " + spring.name, "SPACAR Light has no such element");
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    const auto& held = m.bodies[b].held;
    const auto turns = std::count(held.begin() + 3, held.end(), true);
    if (turns != 0 && turns != 3)
      refuse("the held direction of body " + m.bodies[b].name,
             "SPACAR Light fixes all rotations of a node or none");
  }
  std::vector<int> turned(m.bodies.size());
  for (const Drive& drive : m.drives) {
    const std::string name = drive.name.empty() ? "the drive" : "drive " + drive.name;
    if (drive.other != ground)
      refuse(name, "it stands on a body that moves");
    else if (!is_global(drive))
      refuse(name, "it is along no global axis");
    else if (is_rotation(drive.direction) && ++turned[static_cast<std::size_t>(drive.body)] == 2)
      refuse(name, "SPACAR Light prescribes one rotation of a node");
  }
  if (!loads.assembly.empty()) refuse("assembly", "clamped edges are where they are drawn");
  if (!loads.temperature.empty() || !loads.body_expansion.empty())
    refuse("temperature", "SPACAR Light has no thermal expansion");
  for (const DeadLoad& load : loads.constant)
    for (const Drive& drive : m.drives) {
      if (load.body.value_or(m.end_effector) != drive.body) continue;
      const Vector3d& along = is_rotation(drive.direction) ? load.moment : load.force;
      if (along[index(drive.direction) % 3] != 0)
        refuse("the load " + load.name, "it acts along the drive, on the node that is driven");
    }
  if (!faults.empty()) throw SpecError(std::move(faults));
}

int SpacarModel::node_on(int group, const Vector3d& place) {
  std::vector<int>& own = of_group_[group];
  for (const int node : own)
    if ((nodes_[static_cast<std::size_t>(node - 1)] - place).norm() < least_length) return node;
  nodes_.push_back(place);
  const int node = static_cast<int>(nodes_.size());
  if (group == ground) {
    properties_[node].push_back("fix = true");
  } else if (!own.empty()) {  // a rigid link from the first node of the body
    const int link = add_element(own.front(), node);
    const Vector3d along = (place - nodes_[static_cast<std::size_t>(own.front() - 1)]).normalized();
    int least = 0;
    along.cwiseAbs().minCoeff(&least);
    const Vector3d across = Vector3d::Unit(least);
    const auto same = std::find_if(sets_.begin(), sets_.end(), [&](const SpacarSet& set) {
      return !set.material && set.across == across;
    });
    if (same == sets_.end())
      sets_.push_back({.name = "rigid bodies", .elements = {link}, .across = across});
    else
      same->elements.push_back(link);
  }
  own.push_back(node);
  return node;
}

int SpacarModel::add_element(int p, int q) {
  elements_.push_back({p, q});
  return static_cast<int>(elements_.size());
}

void SpacarModel::add_leaf(const LeafSpring& leaf) {
  const auto group_of = [&](int body) {
    return body == ground ? ground : group_[static_cast<std::size_t>(body)];
  };
  std::vector<double> places{0};
  const bool cut = leaf.curve || leaf.has_profile();
  if (leaf.fold) places.push_back(leaf.fold->place);
  for (int k = 1; cut && k < pieces; ++k) places.push_back(static_cast<double>(k) / pieces);
  places.push_back(1);
  int before = node_on(group_of(leaf.base), leaf.origin);
  for (std::size_t k = 1; k < places.size(); ++k) {
    const Vector3d place = middle_of(leaf, places[k]);
    const bool tip = k + 1 == places.size() && leaf.tip != free_edge;
    int node = 0;
    if (tip) {
      node = node_on(group_of(leaf.tip), place);
    } else {
      nodes_.push_back(place);
      node = static_cast<int>(nodes_.size());
    }
    const double middle = 0.5 * (places[k - 1] + places[k]);
    const bool round = leaf.section == Section::circular;
    const double width = leaf.width * profile_at(leaf.width_profile, middle),
                 thickness = leaf.thickness * profile_at(leaf.thickness_profile, middle);
    sets_.push_back({.name = leaf.name,
                     .elements = {add_element(before, node)},
                     .material = &leaf.material,
                     .width = width,
                     .thickness = round ? width : thickness,
                     .round = round,
                     .across = leaf.axes.col(1),
                     .beams = cut ? 1 : 4});
    before = node;
  }
}

void SpacarModel::add_masses() {
  const Mechanism& m = exported_->mechanism;
  std::map<int, std::pair<double, Matrix3d>> at;  // bodies may share a centre
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    const RigidBody& body = m.bodies[b];
    if (body.mass <= 0 || group_[b] == ground) continue;
    auto [found, fresh] =
        at.insert({node_on(group_[b], body.center_of_mass), {0.0, Matrix3d(Matrix3d::Zero())}});
    found->second.first += body.mass;
    found->second.second += body.inertia;
  }
  for (const auto& [node, own] : at) {
    const Matrix3d& I = own.second;
    properties_[node].push_back(fmt::format("mass = {:.12g}", own.first));
    if (!I.isZero(0))
      properties_[node].push_back(
          fmt::format("mominertia = [{:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g}]", I(0, 0),
                      I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2)));
  }
}

void SpacarModel::add_holds() {
  const Mechanism& m = exported_->mechanism;
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    if (group_[b] == ground) continue;
    const int node = reference_of(static_cast<int>(b));
    for (std::size_t c = 0; c < 3; ++c)
      if (m.bodies[b].held[c])
        properties_[node].push_back(fmt::format("fix_{} = true", axis_names[c]));
    if (m.bodies[b].held[3]) properties_[node].push_back("fix_orien = true");
  }
}

int SpacarModel::reference_of(int body) const {
  const Vector3d& place = exported_->mechanism.bodies[static_cast<std::size_t>(body)].reference;
  for (const int node : of_group_.at(group_[static_cast<std::size_t>(body)]))
    if ((nodes_[static_cast<std::size_t>(node - 1)] - place).norm() < least_length) return node;
  return of_group_.at(group_[static_cast<std::size_t>(body)]).front();
}

void SpacarModel::drive(const VectorXd& strokes) {
  const Mechanism& m = exported_->mechanism;
  const LoadCase& loads = exported_->request.loads;
  if (loads.driven())
    for (std::size_t k = 0; k < m.drives.size(); ++k) {
      const Drive& drive = m.drives[k];
      properties_[reference_of(drive.body)].push_back(
          fmt::format("{}_{} = {:.12g}", is_rotation(drive.direction) ? "rot" : "displ",
                      axis_names[static_cast<std::size_t>(index(drive.direction) % 3)],
                      strokes[static_cast<Eigen::Index>(k)]));
    }
  // by node, for loads that share one; constant ones come before the first step
  for (const bool growing : {false, true}) {
    std::map<int, std::pair<Vector3d, Vector3d>> sums;
    for (const DeadLoad& load : growing ? loads.growing : loads.constant) {
      const int body = load.body.value_or(m.end_effector);
      const Vector3d reference = m.bodies[static_cast<std::size_t>(body)].reference;
      const int node = node_on(group_[static_cast<std::size_t>(body)],
                               load.place.value_or(reference + load.arm));
      auto [sum, fresh] =
          sums.insert({node, {Vector3d(Vector3d::Zero()), Vector3d(Vector3d::Zero())}});
      const double factor = growing ? strokes[0] : 1;
      sum->second.first += factor * load.force;
      sum->second.second += factor * load.moment;
    }
    const char* suffix = growing ? "" : "_initial";
    for (const auto& [node, sum] : sums) {
      if (!sum.first.isZero(0))
        properties_[node].push_back(fmt::format("force{} = {}", suffix, triple(sum.first)));
      if (!sum.second.isZero(0))
        properties_[node].push_back(fmt::format("moment{} = {}", suffix, triple(sum.second)));
    }
  }
}

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
