#include <nlohmann/json.hpp>

#include "core/mechanism/each_number.hpp"
#include "designs/describe.hpp"
#include "designs/family.hpp"
#include "designs/flat_design.hpp"

namespace flexopt {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(const Vector3d& v) { return {v[0], v[1], v[2]}; }

template <class Matrix>
Json rows(const Matrix& matrix) {
  Json list = Json::array();
  for (int i = 0; i < static_cast<int>(matrix.rows()); ++i) {
    Json row = Json::array();
    for (int j = 0; j < static_cast<int>(matrix.cols()); ++j) row.push_back(matrix(i, j));
    list.push_back(std::move(row));
  }
  return list;
}

class Expander {
 public:
  explicit Expander(const FlatDesign<double>& design) : design_(design) {}

  Json bodies() const {
    Json list = Json::array();
    for (const FlatBody<double>& body : design_.bodies) {
      Json item{{"name", body.name}};
      if (!body.leaf.empty()) {
        item["on"] = {{"leaf", body.leaf}, {"at", numbers(body.at)}};
        list.push_back(std::move(item));
        continue;
      }
      item["at"] = numbers(body.at);
      if (body.has_mass) {
        item["mass"] = body.mass;
        item["inertia"] = rows(body.inertia);
      }
      if (!body.center_of_mass.isZero(0)) item["center_of_mass"] = numbers(body.center_of_mass);
      if (body.box_half_edges) {
        const Matrix3d edges = 2 * *body.box_half_edges;
        if (edges.isDiagonal(0) && edges.diagonal().minCoeff() > 0)
          item["box"] = numbers(edges.diagonal());
        else
          item["box"] = rows(edges.transpose());
      }
      Json held = Json::array();
      for (std::size_t i = 0; i < 6; ++i)
        if (body.held[i]) held.push_back(direction_names[i]);
      for (const FlatHeld<double>& along : body.held_along) {
        Json vector = Json::object();
        vector[along.type == JointType::held_rotation ? "rotation" : "displacement"] =
            numbers(along.axis);
        held.push_back(std::move(vector));
      }
      if (!held.empty()) item["held"] = std::move(held);
      list.push_back(std::move(item));
    }
    return list;
  }

  Json leaves() const {
    Json list = Json::array();
    for (const FlatLeaf<double>& leaf : design_.leaves) {
      Json item{{"name", leaf.name},
                {"base", {{"body", name_of(leaf.base)}, {"at", numbers(leaf.base_at)}}}};
      if (leaf.tip == free_edge)
        item["tip"] = {{"at", numbers(leaf.tip_at)}};
      else
        item["tip"] = {{"body", name_of(leaf.tip)}, {"at", numbers(leaf.tip_at)}};
      if (!leaf.across.isZero(0)) item["across"] = numbers(leaf.across);
      if (leaf.wire) {
        item["diameter"] = size(leaf.thickness);
      } else {
        item["width"] = size(leaf.width);
        item["thickness"] = size(leaf.thickness);
      }
      if (leaf.curve) item["curve"] = {{"angle", *leaf.curve}};
      if (leaf.fold) item["fold"] = {{"at", numbers(*leaf.fold)}};
      if (leaf.fold && leaf.fold_radius > 0) item["fold"]["radius"] = leaf.fold_radius;
      if (leaf.may_cross) item["may_cross"] = true;
      if (leaf.material) item["material"] = written_material(*leaf.material, false);
      list.push_back(std::move(item));
    }
    return list;
  }

  Json joints() const {
    constexpr const char* types[] = {"rigid", "revolute", "spherical", "prismatic"};
    Json list = Json::array();
    for (const FlatJoint<double>& joint : design_.joints) {
      Json item{{"name", joint.name},
                {"type", types[static_cast<int>(joint.type)]},
                {"body", name_of(joint.body)},
                {"other", name_of(joint.other)},
                {"at", numbers(joint.place)}};
      if (joint.type == JointType::revolute || joint.type == JointType::prismatic)
        item["axis"] = numbers(joint.axis);
      list.push_back(std::move(item));
    }
    return list;
  }

  Json springs() const {
    Json list = Json::array();
    for (const FlatSpring<double>& spring : design_.springs) {
      Json item{{"name", spring.name},
                {"body", name_of(spring.body)},
                {"other", name_of(spring.other)},
                {"at", numbers(spring.place)}};
      if (spring.matrix) {
        item["matrix"] = rows(*spring.matrix);
      } else {
        item["other_at"] = numbers(spring.other_place);
        if (spring.line.empty()) {
          item["stiffness"] = spring.stiffness;
          item["free_length"] = spring.free_length;
        } else {
          item["line"] = spring.line;
        }
      }
      list.push_back(std::move(item));
    }
    return list;
  }

  /// Frames of drives that do not stand along the global axes.
  Json frames() const {
    Json list = Json::array();
    for (std::size_t i = 0; i < design_.drives.size(); ++i)
      if (!design_.drives[i].axes.isIdentity(0))
        list.push_back({{"name", frame_of(i)}, {"turn", turns(design_.drives[i].axes)}});
    return list;
  }

  Json drives() const {
    Json list = Json::array();
    for (std::size_t i = 0; i < design_.drives.size(); ++i) {
      const FlatDrive<double>& drive = design_.drives[i];
      Json item = Json::object();
      if (!drive.name.empty()) item["name"] = drive.name;
      item["body"] = name_of(drive.body);
      if (drive.other != ground) item["other"] = name_of(drive.other);
      item["direction"] = direction_names[static_cast<std::size_t>(index(drive.direction))];
      if (!drive.axes.isIdentity(0)) item["frame"] = frame_of(i);
      if (const auto& coil = drive.voice_coil)
        item["voice_coil"] = {{"motor_constant", coil->motor_constant},
                              {"resistance", coil->resistance}};
      if (const auto& piezo = drive.piezo) {
        const Vector3d at = drive.axes.transpose() * drive.piezo_at;
        item["piezo"] = {{"at", numbers(at)},
                         {"free_stroke", piezo->free_stroke},
                         {"blocking_force", piezo->blocking_force}};
      }
      list.push_back(std::move(item));
    }
    return list;
  }

 private:
  std::string name_of(int body) const {
    return body == ground ? "ground" : design_.bodies[static_cast<std::size_t>(body)].name;
  }

  static Json size(const FlatSize<double>& along) {
    if (!along.formula.empty()) return {{"profile", along.formula}};
    if (along.values.size() == 2) return {along.values[0], along.values[1]};
    return along.values.front();
  }

  static std::string frame_of(std::size_t drive) { return "drive " + std::to_string(drive + 1); }

  /// Turns about z, y, x in this order that make these axes.
  static Json turns(const Matrix3d& axes) {
    const double y = std::asin(std::clamp(-axes(2, 0), -1.0, 1.0));
    Json list = Json::array();  // a list of pairs in braces would be an object
    list.push_back(Json::array({"z", std::atan2(axes(1, 0), axes(0, 0))}));
    list.push_back(Json::array({"y", y}));
    list.push_back(Json::array({"x", std::atan2(axes(2, 1), axes(2, 2))}));
    return list;
  }

  const FlatDesign<double>& design_;
};

}  // namespace

Json expanded(const Family& family, const ParameterValues& values, const FamilyChoices& choices,
              const Material& material) {
  DesignInput<double> input;
  for (const Parameter& p : family.parameters) input.parameters.push_back(values.at(p.name));
  input.choices = &choices;
  input.material = material;
  const FlatDesign<double> design = flatten(*family.plan, input);
  const Expander expand(design);
  Json file{{"flexopt_design", 1}, {"name", family.name}};
  if (!family.summary.empty()) file["summary"] = family.summary;
  file["mesh"] = family.mesh;
  const auto add = [&](const char* key, Json list) {
    if (!list.empty()) file[key] = std::move(list);
  };
  add("frames", expand.frames());
  add("bodies", expand.bodies());
  add("leaves", expand.leaves());
  add("joints", expand.joints());
  add("springs", expand.springs());
  Json drives = expand.drives();
  if (design.named_drives)
    add("drives", std::move(drives));
  else if (!drives.empty())
    file["drive"] = drives[0];
  return file;
}

}  // namespace flexopt
