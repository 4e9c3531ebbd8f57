#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>

#include "core/mechanism/joint.hpp"
#include "core/mechanism/profile.hpp"
#include "core/response/quantities.hpp"
#include "core/spec/spec_error.hpp"
#include "results/export/exported.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace {

constexpr double least_length = 1e-5;  ///< least length of an element of SPACAR Light [m]
constexpr int pieces = 12;             ///< elements of a leaf that is bent or has a profile
constexpr std::array<const char*, 3> axis_names{"x", "y", "z"};

std::string triple(const Vector3d& v) {
  return fmt::format("[{:.12g} {:.12g} {:.12g}]", v[0], v[1], v[2]);
}

Vector3d middle_of(const LeafSpring& leaf, double s) {
  const ArcPoint<double> at = leaf.middle(s);
  return leaf.origin + leaf.axes.col(0) * (leaf.length * at.x) +
         leaf.axes.col(2) * (leaf.length * at.z);
}

/// Throws SpecError with all items that cannot be carried.
void check_carried_by_spacar(const Exported& exported) {
  const Mechanism& m = exported.mechanism;
  const LoadCase& loads = exported.request.loads;
  std::vector<Fault> faults;
  const auto refuse = [&](const std::string& item, const std::string& reason) {
    faults.push_back({"--format", "spacar", item + " is not carried by the script: " + reason});
  };
  for (const LeafSpring& leaf : m.leaves)
    if (leaf.point)
      refuse("body " + m.bodies[leaf.point->body].name,
             "it is a material point of leaf " + leaf.name);
  for (const Joint& joint : m.joints)
    if (joint.type != JointType::rigid)
      refuse("joint " + joint.name, "SPACAR Light fixes nodes along the axes alone");
  for (const Spring& spring : m.springs)
    refuse("spring " + spring.name, "SPACAR Light has no such element");
  for (const ElasticBody& body : m.elastic_bodies)
    refuse("elastic body " + body.name, "SPACAR Light has beams alone");
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
    else if (const int k = index(drive.direction) % 3; drive.axes(k, k) <= 1 - 1e-12)
      refuse(name, "it is along no global axis");
    else if (is_rotation(drive.direction) && ++turned[drive.body] == 2)
      refuse(name, "SPACAR Light prescribes one rotation of a node");
  }
  if (!loads.assembly.empty() || !loads.mounting.empty())
    refuse("assembly", "clamped edges are where they are drawn");
  if (!loads.temperature.empty() || !loads.body_expansion.empty())
    refuse("temperature", "SPACAR Light has no thermal expansion");
  if (loads.follow()) refuse("a load that follows its body", "its loads keep their directions");
  for (const DeadLoad& load : loads.constant)
    for (const Drive& drive : m.drives) {
      if (load.body.value_or(m.end_effector) != drive.body) continue;
      const Vector3d& along = is_rotation(drive.direction) ? load.moment : load.force;
      if (along[index(drive.direction) % 3] != 0)
        refuse("the load " + load.name, "it acts along the drive, on the node that is driven");
    }
  if (!faults.empty()) throw SpecError(std::move(faults));
}

/// Elements of one section.
struct SpacarSet {
  std::string name;
  std::vector<int> elements;
  const Material* material = nullptr;  ///< none: rigid
  double width = 0, thickness = 0;     ///< [m]; of a circle the diameter twice
  bool round = false;
  Vector3d across = Vector3d::UnitZ();  ///< along the width
  int beams = 1;                        ///< in each element
};

/// A mechanism as nodes and beam elements. Numbers count from one.
class SpacarModel {
 public:
  /// `exported` must outlive this. Throws SpecError with all items that cannot be carried.
  explicit SpacarModel(const Exported& exported)
      : exported_(&exported), mechanism_(&exported.mechanism), group_(rigid_groups(*mechanism_)) {
    check_carried_by_spacar(exported);
    for (std::size_t b = 0; b < group_.size(); ++b)
      if (group_[b] != ground) node_on(group_[b], mechanism_->bodies[b].reference);
    for (const LeafSpring& leaf : mechanism_->leaves) add_leaf(leaf);
    add_masses();
    add_holds();
  }

  /// Adds what acts: strokes, or the factor of the loads that grow, and constant loads.
  void drive(const VectorXd& strokes) {
    const LoadCase& loads = exported_->request.loads;
    if (loads.driven())
      for (std::size_t k = 0; k < mechanism_->drives.size(); ++k) {
        const Drive& drive = mechanism_->drives[k];
        properties_[reference_of(drive.body)].push_back(
            fmt::format("{}_{} = {:.12g}", is_rotation(drive.direction) ? "rot" : "displ",
                        axis_names[index(drive.direction) % 3], strokes[k]));
      }
    // by node, for loads that share one; constant ones come before the first step
    for (const bool growing : {false, true}) {
      std::map<int, std::pair<Vector3d, Vector3d>> sums;
      for (const DeadLoad& load : growing ? loads.growing : loads.constant) {
        const int body = load.body.value_or(mechanism_->end_effector);
        const Vector3d reference = mechanism_->bodies[body].reference;
        const int node = node_on(group_[body], load.place.value_or(reference + load.arm));
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

  /// The script, and in comments what flexopt finds there: `point`.
  std::string script(const VectorXd& strokes, const PathPoint& point) const {
    std::string text;
    const auto out = std::back_inserter(text);
    fmt::format_to(out,
                   "% {}: flexopt {} wrote this script for SPACAR Light. SI units.\n% stroke: {}\n"
                   "clear\n\n%% NODES\nnodes = [\n",
                   one_line(exported_->name), version(), one_line(exported_->stroke_text(strokes)));
    for (const Vector3d& p : nodes_)
      fmt::format_to(out, "  {:.12g} {:.12g} {:.12g};\n", p[0], p[1], p[2]);
    text += "];\n\n%% ELEMENTS\nelements = [\n";
    for (const auto& [p, q] : elements_) fmt::format_to(out, "  {} {};\n", p, q);
    text += "];\n\n%% NODE PROPERTIES\n";
    for (const auto& [node, lines] : properties_)
      for (const std::string& line : lines) fmt::format_to(out, "nprops({}).{};\n", node, line);
    text += "\n%% ELEMENT PROPERTIES\n";
    write_sets(text);
    text += "\n%% OPTIONS\nopt.filename = 'flexopt_export';\nopt.loadsteps = 10;\n";
    if (const Vector3d& g = exported_->request.loads.gravity; !g.isZero(0))
      fmt::format_to(out, "opt.gravity = [{:.12g} {:.12g} {:.12g}];\n", g[0], g[1], g[2]);
    text += "\n%% CALL\nout = spacarlight(nodes, elements, nprops, eprops, opt);\n";
    write_comparison(point, text);
    return text;
  }

 private:
  int node_on(int group, const Vector3d& place) {
    std::vector<int>& own = of_group_[group];
    for (const int node : own)
      if ((nodes_[node - 1] - place).norm() < least_length) return node;
    nodes_.push_back(place);
    const int node = static_cast<int>(nodes_.size());
    if (group == ground) {
      properties_[node].push_back("fix = true");
    } else if (!own.empty()) {  // a rigid link from the first node of the body
      const int link = add_element(own.front(), node);
      const Vector3d along = (place - nodes_[own.front() - 1]).normalized();
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

  int add_element(int p, int q) {
    elements_.push_back({p, q});
    return static_cast<int>(elements_.size());
  }

  void add_leaf(const LeafSpring& leaf) {
    const auto group_of = [&](int body) { return body == ground ? ground : group_[body]; };
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

  void add_masses() {
    std::map<int, std::pair<double, Matrix3d>> at;  // bodies may share a centre
    for (std::size_t b = 0; b < mechanism_->bodies.size(); ++b) {
      const RigidBody& body = mechanism_->bodies[b];
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

  void add_holds() {
    for (std::size_t b = 0; b < mechanism_->bodies.size(); ++b) {
      if (group_[b] == ground) continue;
      const int node = reference_of(static_cast<int>(b));
      for (std::size_t c = 0; c < 3; ++c)
        if (mechanism_->bodies[b].held[c])
          properties_[node].push_back(fmt::format("fix_{} = true", axis_names[c]));
      if (mechanism_->bodies[b].held[3]) properties_[node].push_back("fix_orien = true");
    }
  }

  /// The node of a body's reference point.
  int reference_of(int body) const {
    const Vector3d& place = mechanism_->bodies[body].reference;
    for (const int node : of_group_.at(group_[body]))
      if ((nodes_[node - 1] - place).norm() < least_length) return node;
    return of_group_.at(group_[body]).front();
  }

  void write_sets(std::string& text) const {
    const auto out = std::back_inserter(text);
    for (int number = 1; const SpacarSet& set : sets_) {
      const auto write = [&](const std::string& property) {
        fmt::format_to(out, "eprops({}).{};\n", number, property);
      };
      fmt::format_to(out, "% {}\n", one_line(set.name));
      write(fmt::format("elems = [{}]", fmt::join(set.elements, " ")));
      write("orien = " + triple(set.across));
      write(fmt::format("nbeams = {}", set.beams));
      if (const Material* m = set.material) {
        write(fmt::format("emod = {:.12g}", m->youngs_modulus));
        write(fmt::format("smod = {:.12g}", m->shear_modulus()));
        write(fmt::format("dens = {:.12g}", m->density));
        write(set.round ? "cshape = 'circ'" : "cshape = 'rect'");
        write(set.round ? fmt::format("dim = {:.12g}", set.width)
                        : fmt::format("dim = [{:.12g} {:.12g}]", set.width, set.thickness));
        if (!set.round) write("warping = true");
        write("flex = 1:6");
      }
      write(set.material ? "color = 'grey'" : "color = 'darkblue'");
      ++number;
    }
  }

  /// What to look at in the answer, and flexopt's numbers.
  void write_comparison(const PathPoint& point, std::string& text) const {
    const auto out = std::back_inserter(text);
    fmt::format_to(out, "\n%% COMPARISON: flexopt, beams at full accuracy\n");
    const int O = reference_of(mechanism_->end_effector);
    for (std::size_t k = 0; exported_->request.loads.driven() && k < mechanism_->drives.size();
         ++k) {
      const Drive& drive = mechanism_->drives[k];
      const bool turn = is_rotation(drive.direction);
      fmt::format_to(out, "% drive load {} = {:.9g} {}: out.step(end).node({}).{}({})\n",
                     direction_names[index(drive.direction)], point.drive_loads[k],
                     load_unit(drive.direction), reference_of(drive.body), turn ? "Mreac" : "Freac",
                     index(drive.direction) % 3 + 1);
    }
    for (std::size_t d = 0; d < 6; ++d)
      if (point.support_stiffness[d])
        fmt::format_to(
            out, "% support stiffness {} = {:.9g} {}: 1/out.step(end).node({}).CMglob({},{})\n",
            direction_names[d], *point.support_stiffness[d], d < 3 ? "N/m" : "N m/rad", O, d + 1,
            d + 1);
  }

  const Exported* exported_;
  const Mechanism* mechanism_;
  std::vector<int> group_;  ///< group of each body; ground
  std::vector<Vector3d> nodes_;
  std::map<int, std::vector<int>> of_group_;  ///< nodes
  std::vector<std::array<int, 2>> elements_;
  std::vector<SpacarSet> sets_;
  /// By node: lines such as "fix = true", in their order.
  std::map<int, std::vector<std::string>> properties_;
};

}  // namespace

std::string spacar_script(const Exported& exported, const VectorXd& strokes) {
  SpacarModel model(exported);
  model.drive(strokes);
  ModelOptions beams = exported.model;
  beams.accuracy = Accuracy::full;
  beams.flexure = Flexure::beam;
  const PathPoint point = exported.equilibria({strokes}, beams, {Output::stiffness}).front();
  return model.script(strokes, point);
}

}  // namespace flexopt
