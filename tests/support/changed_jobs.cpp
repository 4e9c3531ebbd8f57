#include "support/changed_jobs.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "support/random_jobs.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

json& mechanism_of(json& job) { return job["design"]["mechanism"]; }
const json& mechanism_of(const json& job) { return job["design"]["mechanism"]; }

Vector3d vector(const json& v) {
  return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()};
}
json numbers(const Vector3d& v) { return json::array({v[0], v[1], v[2]}); }

template <class Matrix>
Matrix matrix(const json& rows) {
  Matrix M;
  for (int i = 0; i < static_cast<int>(M.rows()); ++i)
    for (int j = 0; j < static_cast<int>(M.cols()); ++j)
      M(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)].get<double>();
  return M;
}
template <class Matrix>
json rows(const Matrix& M) {
  json list = json::array();
  for (int i = 0; i < static_cast<int>(M.rows()); ++i) {
    json row = json::array();
    for (int j = 0; j < static_cast<int>(M.cols()); ++j) row.push_back(M(i, j));
    list.push_back(row);
  }
  return list;
}

// Principal values along the axes, or a matrix.
Matrix3d inertia(const json& written) {
  if (written[0].is_array()) return matrix<Matrix3d>(written);
  return vector(written).asDiagonal();
}

void at_each(json& item, std::initializer_list<const char*> keys,
             const std::function<Vector3d(const Vector3d&)>& change) {
  for (const char* key : keys)
    if (item.contains(key)) item[key] = numbers(change(vector(item[key])));
}

void for_all(json& mechanism, const char* list, const std::function<void(json&)>& change) {
  if (mechanism.contains(list))
    for (json& item : mechanism[list]) change(item);
}

// A size is a number, two, or a formula of s.
void grow(json& size, double by) {
  if (size.is_number())
    size = size.get<double>() * by;
  else if (size.is_array())
    for (json& one : size) grow(one, by);
  else
    size["profile"] = fmt::format("({})*{:.17g}", size["profile"].get<std::string>(), by);
}

const json* body_of(const json& job, const std::string& name) {
  for (const json& body : mechanism_of(job)["bodies"])
    if (body["name"] == name) return &body;
  return nullptr;
}

std::size_t index_of(const json& direction) {
  constexpr std::array names{"ux", "uy", "uz", "rx", "ry", "rz"};
  return static_cast<std::size_t>(std::ranges::find(names, direction.get<std::string>()) -
                                  names.begin());
}

}  // namespace

namespace {

// Pulls a body along an axis of the ground: from so far away that it does not turn.
json long_spring(const json& body, int axis, double stiffness, double length, double pull) {
  constexpr double far = 1e5;
  const Vector3d at = vector(body["at"]), other = at + far * length * Vector3d::Unit(axis);
  return {{"name", fmt::format("pulls {} along {}", body["name"].get<std::string>(), "xyz"[axis])},
          {"body", body["name"]},
          {"at", numbers(at)},
          {"other_at", numbers(other)},
          {"stiffness", stiffness},
          {"free_length", (other - at).norm() - pull}};
}

}  // namespace

json with_accuracy(json job, const std::string& accuracy) {
  job["model"]["accuracy"] = accuracy;
  return job;
}

json with_stroke(json job, const json& at) {
  job["stroke"] = {{"at", at}};
  return job;
}

json drives_of(const json& job) {
  const json& mechanism = mechanism_of(job);
  if (mechanism.contains("drives")) return mechanism["drives"];
  return json::array({mechanism["drive"]});
}

std::vector<double> strokes_of(const json& job, const json& point) {
  if (point.is_number()) return {point.get<double>()};
  std::vector<double> strokes;
  for (const json& drive : drives_of(job))
    strokes.push_back(point[drive["name"].get<std::string>()]);
  return strokes;
}

json stroke_point(const json& job, const std::vector<double>& strokes) {
  const json drives = drives_of(job);
  if (!drives[0].contains("name")) return strokes[0];
  json point = json::object();
  for (std::size_t k = 0; k < strokes.size(); ++k)
    point[drives[k]["name"].get<std::string>()] = strokes[k];
  return point;
}

TurnedJob turned_job(json job, double about_z, double about_x) {
  const Matrix3d R = (Eigen::AngleAxisd(about_z, Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(about_x, Vector3d::UnitX()))
                         .toRotationMatrix();
  json& m = mechanism_of(job);
  for (json& frame : m["frames"])
    if (!frame.contains("in")) frame["in"] = "whole";
  m["frames"].push_back(
      {{"name", "whole"},
       {"turn", json::array({json::array({"z", about_z}), json::array({"x", about_x})})}});
  for (const char* list : {"bodies", "leaves", "joints", "springs", "drives"})
    for_all(m, list, [](json& item) {
      if (!item.contains("frame")) item["frame"] = "whole";
    });
  if (m.contains("drive") && !m["drive"].contains("frame")) m["drive"]["frame"] = "whole";
  const auto turn = [&](const Vector3d& v) { return Vector3d(R * v); };
  if (job.contains("end_effector")) {
    json& payload = job["end_effector"];
    if (payload.contains("inertia"))
      payload["inertia"] = rows(Matrix3d(R * inertia(payload["inertia"]) * R.transpose()));
    at_each(payload, {"center_of_mass"}, turn);
  }
  for_all(job, "loads", [&](json& load) { at_each(load, {"force", "moment", "at"}, turn); });
  for_all(job, "assembly", [&](json& error) { at_each(error, {"move", "turn"}, turn); });
  at_each(job, {"gravity"}, turn);
  return {job, R};
}

std::optional<MirroredJob> mirrored_job(json job, int normal) {
  json& m = mechanism_of(job);
  MirroredJob result;
  for (const json& drive : drives_of(job)) {
    if (drive.contains("frame")) return std::nullopt;
    const auto d = static_cast<int>(index_of(drive["direction"]));
    result.signs.push_back(d < 3 ? (d == normal ? -1 : 1) : (d - 3 == normal ? 1 : -1));
  }
  Vector3d q = Vector3d::Ones();
  q[normal] = -1;
  const auto polar = [&](const Vector3d& v) { return Vector3d(q.cwiseProduct(v)); };
  const auto axial = [&](const Vector3d& v) { return Vector3d(-q.cwiseProduct(v)); };
  const auto mirror_inertia = [&](json& item) {
    if (item.contains("inertia"))
      item["inertia"] = rows(Matrix3d(q.asDiagonal() * inertia(item["inertia"]) * q.asDiagonal()));
    at_each(item, {"center_of_mass"}, polar);
  };
  for_all(m, "bodies", [&](json& body) {
    at_each(body, {"at"}, polar);
    if (body.contains("on")) at_each(body["on"], {"at"}, polar);
    mirror_inertia(body);
    if (!body.contains("held")) return;
    for (json& held : body["held"])
      if (held.is_object()) {
        at_each(held, {"displacement"}, polar);
        at_each(held, {"rotation"}, axial);
      }
  });
  for_all(m, "leaves", [&](json& leaf) {
    for (const char* end : {"base", "tip"}) at_each(leaf[end], {"at"}, polar);
    at_each(leaf, {"across"}, polar);
    // the normal across × along turns round
    if (leaf.contains("curve")) leaf["curve"]["angle"] = -leaf["curve"]["angle"].get<double>();
    if (leaf.contains("fold")) at_each(leaf["fold"], {"at"}, polar);
  });
  for_all(m, "joints", [&](json& joint) { at_each(joint, {"at", "axis"}, polar); });
  for_all(m, "springs", [&](json& spring) {
    at_each(spring, {"at", "other_at"}, polar);
    if (!spring.contains("matrix")) return;
    Eigen::Matrix<double, 6, 1> T;
    T << q, -q;
    spring["matrix"] =
        rows(Matrix6d(T.asDiagonal() * matrix<Matrix6d>(spring["matrix"]) * T.asDiagonal()));
  });
  if (job.contains("end_effector")) mirror_inertia(job["end_effector"]);
  for_all(job, "loads", [&](json& load) {
    at_each(load, {"force", "at"}, polar);
    at_each(load, {"moment"}, axial);
  });
  for_all(job, "assembly", [&](json& error) {
    at_each(error, {"move"}, polar);
    at_each(error, {"turn"}, axial);
  });
  at_each(job, {"gravity"}, polar);
  for (json& point : job["stroke"]["at"]) {
    std::vector<double> strokes = strokes_of(job, point);
    for (std::size_t k = 0; k < strokes.size(); ++k) strokes[k] *= result.signs[k];
    point = stroke_point(job, strokes);
  }
  result.job = job;
  return result;
}

json grown_job(json job, double factor) {
  const auto by = [&](const char* unit) { return growth_of(unit, factor); };
  json& m = mechanism_of(job);
  const auto times = [&](const char* unit) {
    return [growth = by(unit)](const Vector3d& v) { return Vector3d(growth * v); };
  };
  const auto grow_mass = [&](json& item) {
    if (item.contains("mass")) item["mass"] = item["mass"].get<double>() * by("kg");
    if (item.contains("inertia"))
      item["inertia"] = rows(Matrix3d(by("kg m^2") * inertia(item["inertia"])));
    at_each(item, {"center_of_mass"}, times("m"));
  };
  for_all(m, "frames", [&](json& frame) { at_each(frame, {"at"}, times("m")); });
  for_all(m, "bodies", [&](json& body) {
    at_each(body, {"at"}, times("m"));
    if (body.contains("on")) at_each(body["on"], {"at"}, times("m"));
    if (body.contains("box"))
      for (json& edge : body["box"]) grow(edge, factor);
    grow_mass(body);
  });
  for_all(m, "leaves", [&](json& leaf) {
    for (const char* end : {"base", "tip"}) at_each(leaf[end], {"at"}, times("m"));
    for (const char* size : {"width", "thickness", "diameter"})
      if (leaf.contains(size)) grow(leaf[size], factor);
    if (leaf.contains("fold")) {
      at_each(leaf["fold"], {"at"}, times("m"));
      if (leaf["fold"].contains("radius")) grow(leaf["fold"]["radius"], factor);
    }
    if (leaf.contains("reinforcement")) grow(leaf["reinforcement"]["thickness"], factor);
  });
  for_all(m, "joints", [&](json& joint) { at_each(joint, {"at"}, times("m")); });
  for_all(m, "springs", [&](json& spring) {
    at_each(spring, {"at", "other_at"}, times("m"));
    if (spring.contains("stiffness")) grow(spring["stiffness"], by("N/m"));
    if (spring.contains("free_length")) grow(spring["free_length"], factor);
    if (!spring.contains("matrix")) return;
    Eigen::Matrix<double, 6, 1> T;  // N/m, N, N m
    T << Vector3d::Constant(std::sqrt(by("N/m"))), Vector3d::Constant(std::sqrt(by("N m")));
    spring["matrix"] =
        rows(Matrix6d(T.asDiagonal() * matrix<Matrix6d>(spring["matrix"]) * T.asDiagonal()));
  });
  if (job.contains("end_effector")) grow_mass(job["end_effector"]);
  for_all(job, "loads", [&](json& load) {
    at_each(load, {"force"}, times("N"));
    at_each(load, {"moment"}, times("N m"));
    at_each(load, {"at"}, times("m"));
  });
  for_all(job, "assembly", [&](json& error) { at_each(error, {"move"}, times("m")); });
  at_each(job, {"gravity"}, times("m/s^2"));
  const json drives = drives_of(job);
  for (json& point : job["stroke"]["at"]) {
    std::vector<double> strokes = strokes_of(job, point);
    for (std::size_t k = 0; k < strokes.size(); ++k)
      if (index_of(drives[k]["direction"]) < 3) strokes[k] *= factor;
    point = stroke_point(job, strokes);
  }
  return job;
}

std::optional<json> with_springs_for_held(json job, double stiffness, double length) {
  json& m = mechanism_of(job);
  bool any = false;
  for (json& body : m["bodies"]) {
    if (!body.contains("held")) continue;
    Matrix6d K = Matrix6d::Zero();
    for (const json& held : body["held"]) {
      if (held.is_object()) return std::nullopt;
      const auto d = static_cast<int>(index_of(held));
      if (d < 3)
        m["springs"].push_back(long_spring(body, d, stiffness, length, 0));
      else
        K(d, d) = stiffness * length * length;
    }
    if (!K.isZero(0))
      m["springs"].push_back({{"name", "for held turns of " + body["name"].get<std::string>()},
                              {"body", body["name"]},
                              {"at", body["at"]},
                              {"matrix", rows(K)}});
    body.erase("held");
    any = true;
  }
  return any ? std::optional(job) : std::nullopt;
}

std::optional<json> with_cut_leaf(json job) {
  json& m = mechanism_of(job);
  for (json& leaf : m["leaves"]) {
    if (leaf.contains("curve") || leaf.contains("fold") || leaf.contains("reinforcement")) continue;
    const bool wire = leaf.contains("diameter");
    if (!leaf["tip"].contains("body")) continue;
    if (wire ? !leaf["diameter"].is_number()
             : !leaf["width"].is_number() || !leaf["thickness"].is_number())
      continue;
    bool named = false;  // by a material point, a warm leaf, an error of assembly
    for (const json& body : m["bodies"])
      named = named || (body.contains("on") && body["on"]["leaf"] == leaf["name"]);
    for (const char* key : {"assembly", "temperature"}) named = named || job.contains(key);
    if (named) continue;
    const json middle = numbers(0.5 * (vector(leaf["base"]["at"]) + vector(leaf["tip"]["at"])));
    json second = leaf;
    second["name"] = leaf["name"].get<std::string>() + " cut";
    second["base"] = {{"body", "between halves"}, {"at", middle}};
    leaf["tip"] = second["base"];
    m["leaves"].push_back(second);
    m["bodies"].push_back({{"name", "between halves"}, {"at", middle}});
    return job;
  }
  return std::nullopt;
}

std::optional<SprungJob> with_spring_for_drive(json job, const json& point, double stiffness,
                                               double length, std::size_t drive) {
  const json drives = drives_of(job);
  if (drives.size() < 2) return std::nullopt;
  const json own = drives[drive];
  const std::size_t d = index_of(own["direction"]);
  if (d >= 3 || own.contains("other") || own.contains("frame")) return std::nullopt;
  const std::string name = own["body"];
  const json* body = body_of(job, name);
  if (!body || !body->contains("at")) return std::nullopt;
  json& m = mechanism_of(job);
  const json spring = long_spring(*body, static_cast<int>(d), stiffness, length,
                                  point[own["name"].get<std::string>()]);
  m["springs"].push_back(spring);
  m["drives"].erase(drive);
  json rest = point;
  rest.erase(own["name"].get<std::string>());
  job["stroke"] = {{"at", json::array({rest})}};
  return SprungJob{.job = job,
                   .body = name,
                   .anchor = vector(spring["other_at"]) - vector(spring["at"]),
                   .free_length = spring["free_length"],
                   .stiffness = stiffness};
}

}  // namespace flexopt
