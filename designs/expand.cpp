#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/mechanism/each_number.hpp"
#include "designs/describe.hpp"
#include "designs/elastic_item.hpp"
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
    const auto shapes = design_.elastic_bodies.begin(), behind = design_.elastic_bodies.end();
    auto shape = shapes;
    // those without a frame of their name stand where they stood among the others
    const auto add_shared = [&] {
      for (; shape != behind && shape->frame == no_body; ++shape)
        list.push_back({{"name", shape->name},
                        {"at", numbers(shape->place)},
                        {"elastic", elastic(*shape, shape->place)}});
    };
    for (const FlatBody<double>& body : design_.bodies) {
      if (body.of_interface) continue;
      add_shared();
      Json item{{"name", body.name}};
      if (!body.leaf.empty())
        item["on"] = {{"leaf", body.leaf}, {"at", numbers(body.at)}};
      else
        add_rigid(body, item);
      if (shape != behind && shape->frame == static_cast<int>(&body - design_.bodies.data()))
        item["elastic"] = elastic(*shape++, body.at);
      list.push_back(std::move(item));
    }
    add_shared();
    return list;
  }

  Json leaves() const {
    Json list = Json::array();
    for (const FlatLeaf<double>& leaf : design_.leaves) {
      Json item{{"name", leaf.name}, {"base", edge(leaf, 0)}, {"tip", edge(leaf, 1)}};
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
      if (joint.source.pointer.find("/elastic/") != std::string::npos) continue;  // of a rigid one
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
  static void add_rigid(const FlatBody<double>& body, Json& item) {
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
  }

  /// `at`: place of the body.
  static Json elastic(const FlatElastic<double>& body, const Vector3d& at) {
    Json item = Json::object();
    if (body.material) item["material"] = written_material(*body.material, false);
    if (body.file)
      add_file(body, item);
    else
      std::visit([&](const auto& shape) { add_shape(shape, body, at, item); }, body.shape);
    const bool notch = std::holds_alternative<NotchShapeT<double>>(body.shape);
    Json interfaces = Json::array();
    for (const FlatInterface<double>& interface : body.interfaces) {
      if (interface.implied) continue;
      if (notch) {
        if (!interface.carrier.empty()) item["between"].push_back(interface.carrier);
      } else {
        Json one{{"name", interface.name}};
        if (!interface.carrier.empty()) one["body"] = interface.carrier;
        one["at"] = numbers(interface.at);
        if (!body.file) {
          one["normal"] = numbers(interface.normal);
          one["size"] = interface.sides;
          one["along"] = numbers(interface.along);
        }
        interfaces.push_back(std::move(one));
      }
      if (body.frame != no_body && interface.carrier.empty() && !item.contains("payload"))
        item["payload"] = interface.name;
    }
    if (!interfaces.empty()) item["interfaces"] = std::move(interfaces);
    if (body.rigid) item["rigid"] = true;
    if (body.file) return item;
    if (body.given_degree) item["degree"] = static_cast<int>(*body.given_degree);
    const MeshDensity& density = body.density;
    item["elements"] = {{"size", density.size}, {"root", density.root}, {"growth", density.growth}};
    if (density.through > 0) item["elements"]["through"] = density.through;
    return item;
  }

  /// The file stays as it is.
  static void add_file(const FlatElastic<double>& body, Json& item) {
    const auto& file = std::get<ElasticItem::Imported>(body.file->shape);
    if (body.mirrored)
      throw located(body.source,
                    SpecError(body.source.pointer, body.name,
                              "a file cannot be written mirrored: it is a part's to be expanded"));
    Json own{{"file", file.file}};
    if (file.mesh) own["units"] = file.unit == 1 ? "m" : file.unit == 1e-3 ? "mm" : "um";
    own["axis"] = numbers(body.axes.col(0));
    own["across"] = numbers(body.axes.col(1));
    item[file.mesh ? "mesh" : "import"] = std::move(own);
  }

  /// Along the global axes, to either side; else as the plate that it is.
  static void add_shape(const BoxShapeT<double>& box, const FlatElastic<double>& body,
                        const Vector3d& at, Json& item) {
    if (body.axes.cwiseAbs().isIdentity(0)) {
      item["box"] = box.lengths;
      if (const Vector3d center = body.place - at; !center.isZero(0))
        item["center"] = numbers(center);
      return;
    }
    const double x = box.lengths[0] / 2, y = box.lengths[1] / 2;
    add_shape(
        PlateShapeT<double>{
            .outline = {{{-x, -y}, 0, {}}, {{x, -y}, 0, {}}, {{x, y}, 0, {}}, {{-x, y}, 0, {}}},
            .windows = {},
            .holes = {},
            .thickness = box.lengths[2]},
        body, at, item);
  }

  static Json contour(const ContourT<double>& corners) {
    Json list = Json::array();
    for (const ContourCornerT<double>& corner : corners) {
      Json one{{"at", corner.at}};
      if (corner.fillet > 0) one["fillet"] = corner.fillet;
      if (corner.through) one["through"] = *corner.through;
      list.push_back(std::move(one));
    }
    return list;
  }

  static void add_shape(const PlateShapeT<double>& plate, const FlatElastic<double>& body,
                        const Vector3d&, Json& item) {
    Json own{{"outline", contour(plate.outline)}};
    for (const ContourT<double>& window : plate.windows) own["windows"].push_back(contour(window));
    for (const auto& hole : plate.holes)
      own["holes"].push_back({{"at", hole.center}, {"radius", hole.radius}});
    own["thickness"] = plate.thickness;
    own["normal"] = numbers(body.axes.col(2));
    own["along"] = numbers(body.axes.col(0));
    own["at"] = numbers(body.place);
    item["plate"] = std::move(own);
  }

  static void add_shape(const NotchShapeT<double>& notch, const FlatElastic<double>& body,
                        const Vector3d&, Json& item) {
    constexpr const char* contours[] = {"circular", "elliptic", "corner_filleted", "v", "power"};
    Json own{{"contour", contours[static_cast<int>(notch.contour)]}};
    if (notch.contour == NotchContour::circular) {
      own["radius"] = notch.half_length;
    } else {
      own["half_length"] = notch.half_length;
      own["depth"] = notch.depth;
    }
    if (notch.contour == NotchContour::corner_filleted || notch.contour == NotchContour::v_shaped)
      own["fillet"] = notch.fillet;
    if (notch.contour == NotchContour::power) own["exponent"] = notch.exponent;
    own["thickness"] = notch.thickness;
    own["width"] = notch.width;
    own["ends"] = notch.end_length;
    own["axis"] = numbers(body.axes.col(0));
    own["across"] = numbers(body.axes.col(1));
    if (notch.two_axes) own["two_axes"] = true;
    item["notch"] = std::move(own);
  }

  std::string name_of(int body) const {
    return body == ground ? "ground" : design_.bodies[static_cast<std::size_t>(body)].name;
  }

  Json edge(const FlatLeaf<double>& leaf, std::size_t end) const {
    const int body = end == 0 ? leaf.base : leaf.tip;
    Json item = Json::object();
    if (body != free_edge)
      item["body"] = leaf.held_by[end].empty() ? name_of(body) : leaf.held_by[end];
    item["at"] = numbers(end == 0 ? leaf.base_at : leaf.tip_at);
    if (const auto& clamp = leaf.clamps[end])
      item["clamp"] = {{"length", clamp->length}, {"normal", numbers(clamp->normal)}};
    return item;
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
