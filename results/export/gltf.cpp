#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "results/export/exported.hpp"
#include "results/files/json_text.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

// Numbers of the specification of glTF 2.0.
constexpr int of_floats = 5126, of_indices = 5125, vertices = 34962, triangles = 34963;
constexpr double seconds_there = 3;  ///< and as many back

/// The only buffer of the file, with its accessors.
class Buffer {
 public:
  /// Rows of so many numbers. `bounds`: positions must tell theirs.
  int floats(const std::vector<float>& values, int width, int target = 0, bool bounds = false) {
    Json accessor = {{"bufferView", view(values.data(), values.size() * sizeof(float), target)},
                     {"componentType", of_floats},
                     {"count", values.size() / static_cast<std::size_t>(width)},
                     {"type", width == 1   ? "SCALAR"
                              : width == 3 ? "VEC3"
                                           : "VEC4"}};
    if (bounds) {
      Json low = Json::array(), high = Json::array();
      for (int c = 0; c < width; ++c) {
        float least = std::numeric_limits<float>::max(), most = -least;
        for (auto i = static_cast<std::size_t>(c); i < values.size();
             i += static_cast<std::size_t>(width)) {
          least = std::min(least, values[i]);
          most = std::max(most, values[i]);
        }
        low.push_back(least);
        high.push_back(most);
      }
      accessor["min"] = std::move(low);
      accessor["max"] = std::move(high);
    }
    accessors_.push_back(std::move(accessor));
    return static_cast<int>(accessors_.size()) - 1;
  }

  int indices(const std::vector<std::array<int, 3>>& list) {
    std::vector<std::uint32_t> flat;
    for (const auto& t : list)
      for (const int k : t) flat.push_back(static_cast<std::uint32_t>(k));
    accessors_.push_back(
        {{"bufferView", view(flat.data(), flat.size() * sizeof(std::uint32_t), triangles)},
         {"componentType", of_indices},
         {"count", flat.size()},
         {"type", "SCALAR"}});
    return static_cast<int>(accessors_.size()) - 1;
  }

  void add_to(Json& document) {
    document["accessors"] = std::move(accessors_);
    document["bufferViews"] = std::move(views_);
    document["buffers"] = {{{"byteLength", bytes_.size()}}};
  }
  const std::string& bytes() const { return bytes_; }

 private:
  int view(const void* data, std::size_t size, int target) {
    Json made = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}};
    if (target > 0) made["target"] = target;
    views_.push_back(std::move(made));
    bytes_.append(static_cast<const char*>(data), size);
    return static_cast<int>(views_.size()) - 1;
  }

  std::string bytes_;
  Json accessors_ = Json::array(), views_ = Json::array();
};

void add(const Vector3d& v, std::vector<float>& values) {
  for (int c = 0; c < 3; ++c) values.push_back(static_cast<float>(v[c]));
}

std::vector<float> quaternion(const Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  return {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
          static_cast<float>(q.w())};
}

class Writer3d {
 public:
  Writer3d(const Mechanism& mechanism, const PathPoint* base, const std::vector<PathPoint>& path)
      : mechanism_(&mechanism), base_(base) {
    for (const PathPoint& point : path) frames_.push_back(&point);
    for (std::size_t k = path.size(); k-- > 1;) frames_.push_back(&path[k - 1]);  // and back
    targets_ = path.size();
    if (targets_ < 2) frames_.clear();
    std::vector<float> times;
    for (std::size_t k = 0; k < frames_.size(); ++k)
      times.push_back(static_cast<float>(2 * seconds_there * static_cast<double>(k) /
                                         static_cast<double>(frames_.size() - 1)));
    if (!frames_.empty()) times_ = buffer_.floats(times, 1, 0, true);
  }

  std::string file() && {
    for (std::size_t i = 0; i < mechanism_->leaves.size(); ++i) add_leaf(i);
    for (std::size_t b = 0; b < mechanism_->bodies.size(); ++b) add_body(static_cast<int>(b));
    for (std::size_t k = 0; k < mechanism_->elastic_bodies.size(); ++k) add_elastic_body(k);
    Json roots = Json::array();
    for (std::size_t k = 0; k < nodes_.size(); ++k) roots.push_back(k);
    Json document = {
        {"asset", {{"version", "2.0"}, {"generator", "flexopt " + std::string(version())}}},
        {"scene", 0},
        {"scenes", {{{"nodes", std::move(roots)}}}},
        {"nodes", std::move(nodes_)},
        {"meshes", std::move(meshes_)},
        {"materials",
         {material("leaf", {0.62, 0.68, 0.74, 1.0}, 0.6),
          material("body", {0.20, 0.35, 0.60, 0.35}, 0.0)}}};
    if (!channels_.empty())
      document["animations"] = {{{"name", "stroke"},
                                 {"channels", std::move(channels_)},
                                 {"samplers", std::move(samplers_)}}};
    buffer_.add_to(document);
    return packed(document.dump(), buffer_.bytes());
  }

 private:
  static Json material(const char* name, const std::array<double, 4>& color, double metallic) {
    Json made = {
        {"name", name},
        {"pbrMetallicRoughness",
         {{"baseColorFactor", color}, {"metallicFactor", metallic}, {"roughnessFactor", 0.5}}},
        {"doubleSided", true}};
    if (color[3] < 1) made["alphaMode"] = "BLEND";
    return made;
  }

  /// Binary file of two chunks: the document filled up with spaces, the buffer with zeros.
  static std::string packed(std::string json, std::string bytes) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
    std::string file;
    const auto number = [&](std::size_t value) {
      const auto n = static_cast<std::uint32_t>(value);
      for (int k = 0; k < 4; ++k) file += static_cast<char>(n >> (8 * k) & 0xff);
    };
    file += "glTF";
    number(2);
    number(12 + 8 + json.size() + 8 + bytes.size());
    number(json.size());
    file += "JSON" + json;
    number(bytes.size());
    file += std::string("BIN\0", 4) + bytes;
    return file;
  }

  void animate(const char* path, const std::vector<float>& values, int width) {
    samplers_.push_back({{"input", times_},
                         {"output", buffer_.floats(values, width)},
                         {"interpolation", "LINEAR"}});
    channels_.push_back({{"sampler", samplers_.size() - 1},
                         {"target", {{"node", nodes_.size() - 1}, {"path", path}}}});
  }

  /// Mesh of leaf i at a point of the path, or undeflected. All shapes are interpolated alike, so
  /// that their points correspond.
  TriangleMesh bent(std::size_t i, const PathPoint* point) const {
    if (point) return closed_leaf(drawn_surface(*mechanism_, point, i));
    if (frames_.empty()) return closed_leaf(undeflected_surface(mechanism_->leaves[i]));
    const LeafShape& shape = frames_.front()->shapes[i];
    return closed_leaf(surface_of_shape(mechanism_->leaves[i], shape, shape.undeflected));
  }

  int positions_of(const std::vector<Vector3d>& points) {
    std::vector<float> values;
    for (const Vector3d& p : points) add(p, values);
    return buffer_.floats(values, 3, vertices, true);
  }

  Json primitive_of(const TriangleMesh& mesh, int material) {
    return {{"attributes", {{"POSITION", positions_of(mesh.points)}}},
            {"indices", buffer_.indices(mesh.triangles)},
            {"material", material}};
  }

  void add_leaf(std::size_t i) {
    const std::string& name = mechanism_->leaves[i].name;
    add_bending(name, "leaf " + name, 0, [&](const PathPoint* point) { return bent(i, point); });
  }
  void add_elastic_body(std::size_t k) {
    const auto at = [&](const PathPoint* point) { return elastic_solid(*mechanism_, point, k); };
    const std::string& name = mechanism_->elastic_bodies[k].name;
    if (mechanism_->elastic_bodies[k].cells) add_bending(name, "body " + name, 1, at);
  }

  /// A part whose shape changes; mesh_at(point): its mesh, with the same points everywhere.
  template <class MeshAt>
  void add_bending(const std::string& name, const std::string& node, int material,
                   const MeshAt& mesh_at) {
    const TriangleMesh rest = mesh_at(base_);
    Json primitive = primitive_of(rest, material);
    Json mesh = {{"name", name}};
    if (!frames_.empty()) {
      primitive["targets"] = Json::array();
      for (std::size_t k = 0; k < targets_; ++k) {
        std::vector<Vector3d> ways = mesh_at(frames_[k]).points;
        for (std::size_t p = 0; p < ways.size(); ++p) ways[p] -= rest.points[p];
        primitive["targets"].push_back({{"POSITION", positions_of(ways)}});
      }
      mesh["weights"] = std::vector<double>(targets_, 0.0);
    }
    mesh["primitives"] = {std::move(primitive)};
    nodes_.push_back({{"name", node}, {"mesh", meshes_.size()}});
    meshes_.push_back(std::move(mesh));
    if (frames_.empty()) return;
    std::vector<float> weights;
    for (std::size_t k = 0; k < frames_.size(); ++k)
      for (std::size_t t = 0; t < targets_; ++t)
        weights.push_back(frames_[k] == frames_[t] ? 1.0F : 0.0F);
    animate("weights", weights, 1);
  }

  void add_body(int b) {
    TriangleMesh mesh = body_solid(*mechanism_, b);
    if (mesh.triangles.empty()) return;
    const BodyPose at = body_pose(*mechanism_, base_, b);
    for (Vector3d& p : mesh.points) p -= at.reference;
    Json primitive = primitive_of(mesh, 1);
    const Vector3d place = at.reference + at.displacement;
    nodes_.push_back({{"name", "body " + mesh.name},
                      {"mesh", meshes_.size()},
                      {"translation", {place[0], place[1], place[2]}},
                      {"rotation", quaternion(at.rotation)}});
    meshes_.push_back({{"name", mesh.name}, {"primitives", {std::move(primitive)}}});
    if (frames_.empty()) return;
    std::vector<float> places, turns;
    for (const PathPoint* frame : frames_) {
      const BodyPose pose = body_pose(*mechanism_, frame, b);
      add(pose.reference + pose.displacement, places);
      const std::vector<float> q = quaternion(pose.rotation);
      turns.insert(turns.end(), q.begin(), q.end());
    }
    animate("translation", places, 3);
    animate("rotation", turns, 4);
  }

  const Mechanism* mechanism_;
  const PathPoint* base_;
  std::vector<const PathPoint*> frames_;
  std::size_t targets_ = 0;
  int times_ = 0;
  Buffer buffer_;
  Json nodes_ = Json::array(), meshes_ = Json::array(), channels_ = Json::array(),
       samplers_ = Json::array();
};

}  // namespace

std::string glb(const Mechanism& mechanism, const PathPoint* base,
                const std::vector<PathPoint>& path) {
  return Writer3d(mechanism, base, path).file();
}

}  // namespace flexopt
