#include <fmt/format.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include "core/response/response.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/describe.hpp"
#include "designs/family.hpp"
#include "optim/job/job.hpp"
#include "support/random_design.hpp"
#include "support/random_jobs.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

constexpr std::size_t most_leaves = 6, most_leaves_quick = 3;

json numbers(const Vector3d& v) { return json::array({v[0], v[1], v[2]}); }

// To two digits: what a job is made of does not hang on the last ones of an evaluation.
double two_digits(double value) {
  if (value == 0) return 0;
  const double unit = std::pow(10, std::floor(std::log10(std::abs(value))) - 1);
  return std::round(value / unit) * unit;
}

// The largest stress of a job at its only point, over a load or a stroke that is small: on full
// leaves, as the reduced ones are what is looked at.
std::optional<double> stress_of(json job) {
  job["model"]["accuracy"] = "full";
  Job read = parse_job(job);
  read.request.outputs = {Output::equilibrium, Output::stress};
  const StrokeResponse response =
      evaluate_stroke(make_mechanism(read, read.design.parameters), read.model, read.request);
  const PathPoint& point = response.path.back();
  if (point.status != PointStatus::converged || !point.max_stress) return std::nullopt;
  return point.max_stress->value;
}

class OwnWriter {
 public:
  OwnWriter(unsigned long long seed, bool quick)
      : random_(seed * 6364136223846793005ULL + 1), quick_(quick) {}

  /// Throws SpecError where leaves cross or nothing holds a body: to be drawn again.
  json write(unsigned long long seed, bool of_design);

 private:
  struct Body {
    std::string name;
    Vector3d at;
  };

  double decades(double low, double high) { return std::pow(10, random_.between(low, high)); }
  Matrix3d turned();
  void stage(std::size_t body);
  json leaf(const std::string& base, const Vector3d& from, const std::string& tip,
            const Vector3d& to, const Vector3d& across, double thickness);
  void loop();
  void masses();
  void arm();
  void springs();
  void hold();
  void drive();
  json model();
  void add_loads(json& job);
  void add_strokes(json& job);
  void take_document(const json& flat);
  std::size_t any_body() {
    return static_cast<std::size_t>(random_.whole(0, static_cast<int>(bodies_.size()) - 1));
  }
  std::string any_leaf() {
    const json& leaves = document_["leaves"];
    return leaves[static_cast<std::size_t>(random_.whole(0, static_cast<int>(leaves.size()) - 1))]
                 ["name"];
  }
  json& item_of(const std::string& body) {
    for (json& item : document_["bodies"])
      if (item["name"] == body) return item;
    throw std::logic_error("no such body");
  }

  RandomNumbers random_;
  bool quick_;
  double length_ = 0.1, modulus_ = 2e11;
  Matrix3d axes_ = Matrix3d::Identity();  // of the mechanism
  json document_, material_;
  std::vector<Body> bodies_;  // those of the tree
  bool warm_ = false, wires_ = false;
};

// Half of all stand along the global axes, as designers draw them.
Matrix3d OwnWriter::turned() {
  if (random_.chance(0.5)) return Matrix3d::Identity();
  const auto about = [&](double angle) {
    const Vector3d axis = Vector3d::Unit(random_.whole(0, 2));
    return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  };
  Matrix3d R = about(random_.whole(0, 3) * std::numbers::pi / 2) *
               about(random_.whole(0, 3) * std::numbers::pi / 2);
  R = R.array().round().matrix().eval();
  if (random_.chance(0.5))
    R = (R * about(random_.between(-1, 1)) * about(random_.between(-1, 1))).eval();
  return R;
}

json OwnWriter::leaf(const std::string& base, const Vector3d& from, const std::string& tip,
                     const Vector3d& to, const Vector3d& across, double thickness) {
  const auto edge = [](const std::string& body, const Vector3d& at) {
    return json{{"body", body}, {"at", numbers(at)}};
  };
  json l{{"name", fmt::format("leaf {}", document_["leaves"].size())},
         {"base", edge(base, from)},
         {"tip", edge(tip, to)}};
  const double length = (to - from).norm(), kind = random_.between(0, 1);
  if (kind < 0.12) {
    wires_ = true;
    l["diameter"] = thickness * random_.between(1, 2);
    return l;
  }
  l["across"] = numbers(across);
  const double narrow = std::max(2.5 * thickness, 0.03 * length);
  const double w =
      random_.chance(0.3) ? narrow * random_.between(1, 2) : length * random_.between(0.1, 0.5);
  const double other = random_.between(0.6, 0.95);
  l["width"] = std::max(w, narrow);
  l["thickness"] = thickness;
  if (kind < 0.19)
    l["thickness"] = json::array({thickness, thickness * other});
  else if (kind < 0.26)
    l["width"] = json::array({std::max(w, narrow) / other, std::max(w, narrow)});
  else if (kind < 0.33)
    l["thickness"] = {{"profile", fmt::format("{:.6g}*(1 + {:.3g}*(s - 0.5)^2)", thickness,
                                              random_.between(0.5, 4))}};
  else if (kind < 0.43)
    l["curve"] = {{"angle", (random_.chance(0.5) ? 1 : -1) * random_.between(0.05, 1.2)}};
  else if (kind < 0.49) {
    const Vector3d along = (to - from) / length, side = across.cross(along).normalized();
    l["fold"] = {{"at", numbers(from + random_.between(0.4, 0.6) * (to - from) +
                                random_.between(0.25, 0.6) * length * side)}};
    if (random_.chance(0.4)) l["fold"]["radius"] = thickness * random_.between(0.5, 3);
  } else if (kind < 0.57) {
    l["reinforcement"] = {{"fraction", random_.between(0.3, 0.6)},
                          {"thickness", thickness * random_.between(4, 12)},
                          {"rigid", random_.chance(0.7)}};
  }
  if (random_.chance(0.08))
    l["material"] = {{"youngs_modulus", modulus_ * random_.between(0.5, 1.5)},
                     {"poissons_ratio", 0.33},
                     {"density", 4500},
                     {"thermal_expansion", 9e-6}};
  return l;
}

// A body on one to three leaves from the ground or a body before it: side by side, at angles,
// crossing, or anyhow.
void OwnWriter::stage(std::size_t body) {
  const bool grounded = body == 0 || random_.chance(0.25);
  const std::size_t parent = grounded ? 0 : body - 1;
  const std::string base = grounded ? "ground" : bodies_[parent].name;
  Matrix3d axes = axes_;
  if (body > 0 && random_.chance(0.6)) {
    const double turns[] = {std::numbers::pi, std::numbers::pi / 2, -std::numbers::pi / 2};
    axes = axes * Eigen::AngleAxisd(turns[random_.whole(0, 2)], Vector3d::Unit(random_.whole(0, 2)))
                      .toRotationMatrix();
    axes = axes.unaryExpr([](double x) { return std::abs(x) < 1e-15 ? 0.0 : x; }).eval();
  }
  const std::size_t left = (quick_ ? most_leaves_quick : most_leaves) - document_["leaves"].size();
  const int most = static_cast<int>(std::min<std::size_t>(left - (bodies_.size() - 1 - body), 3));
  const double many = random_.between(0, 1);
  const int count = std::clamp(many < 0.35 ? 1 : many < 0.75 ? 2 : 3, 1, std::max(1, most));
  Vector3d start = Vector3d::Zero();
  if (!grounded)
    start = bodies_[parent].at + 0.4 * length_ * axes.col(1) + 0.1 * length_ * random_.direction();
  else if (body > 0)
    start = length_ * random_.direction();
  const int layout = random_.whole(0, 3);
  const double apart = length_ * random_.between(0.3, 0.8), thick = length_ / decades(1.6, 2.6);
  Vector3d tips = Vector3d::Zero();
  for (int k = 0; k < count; ++k) {
    const double place = k - 0.5 * (count - 1);
    Vector3d from(0, place * apart, layout == 0 ? 0 : 0.15 * length_ * place), way(length_, 0, 0);
    Vector3d across(0, 0, 1);
    if (layout == 1) way = Vector3d(length_, -random_.between(-0.3, 0.6) * place * apart, 0);
    if (layout == 2) {  // crossing
      const double angle = (k % 2 == 0 ? 1 : -1) * random_.between(0.4, 1);
      way = length_ * Vector3d(std::cos(angle), std::sin(angle), 0);
      from = Vector3d(0, -0.5 * way[1], 0.55 * length_ * place);
    }
    if (layout == 3) {
      from += 0.2 * length_ * random_.direction();
      way = random_.between(0.6, 1.1) * length_ * random_.direction();
      across = random_.direction();
      while (std::abs(across.dot(way)) > 0.7 * way.norm()) across = random_.direction();
    }
    if (count == 1 && random_.chance(0.2)) across = Vector3d(0, 1, 0);
    const Vector3d at = start + axes * from, to = at + axes * way;
    document_["leaves"].push_back(
        leaf(base, at, bodies_[body].name, to, axes * across, thick * random_.between(0.8, 1.2)));
    tips += to / count;
  }
  bodies_[body].at = tips;
  if (random_.chance(0.5)) bodies_[body].at += 0.3 * length_ * random_.direction();
  document_["bodies"].push_back({{"name", bodies_[body].name}, {"at", numbers(bodies_[body].at)}});
}

// One more leaf, between two bodies or from the ground.
void OwnWriter::loop() {
  const Body& on = bodies_[any_body()];
  const Vector3d to = on.at + 0.3 * length_ * random_.direction(),
                 from = to + length_ * random_.between(0.6, 1.2) * random_.direction();
  Vector3d across = random_.direction();
  while (std::abs(across.dot((to - from).normalized())) > 0.7) across = random_.direction();
  document_["leaves"].push_back(
      leaf("ground", from, on.name, to, across, length_ / decades(1.7, 2.6)));
}

void OwnWriter::masses() {
  const double unit = 2000 * std::pow(0.2 * length_, 3);
  for (json& item : document_["bodies"]) {
    if (item["name"] == "end_effector" || random_.chance(0.4)) continue;  // massless
    const double m = unit * decades(-1, 1), i = m * length_ * length_;
    item["mass"] = m;
    item["inertia"] = json::array({0.05 * i, 0.06 * i, 0.04 * i});
    if (random_.chance(0.5)) item["center_of_mass"] = numbers(0.2 * length_ * random_.direction());
  }
}

// A body on a joint, held besides by a bushing.
void OwnWriter::arm() {
  const Body& on = bodies_[any_body()];
  const Vector3d at = on.at + 0.3 * length_ * random_.direction();
  document_["bodies"].push_back({{"name", "arm"}, {"at", numbers(at)}});
  constexpr std::array types{"rigid", "revolute", "spherical", "prismatic"};
  const std::string type = types[static_cast<std::size_t>(random_.whole(0, 3))];
  json joint{{"name", "joint"},
             {"type", type},
             {"body", "arm"},
             {"other", on.name},
             {"at", numbers(on.at + 0.2 * length_ * random_.direction())}};
  if (type == "revolute" || type == "prismatic") joint["axis"] = numbers(random_.direction());
  document_["joints"].push_back(joint);
  if (type == "rigid") return;
  json rows = json::array();
  const double k = modulus_ * length_ * decades(-8, -6);
  for (int r = 0; r < 6; ++r) {
    rows.push_back(json::array({0, 0, 0, 0, 0, 0}));
    rows.back()[static_cast<std::size_t>(r)] =
        r < 3 ? k : k * length_ * length_ * random_.between(0.05, 0.5);
  }
  document_["springs"].push_back({{"name", "holder"},
                                  {"body", "arm"},
                                  {"other", on.name},
                                  {"at", numbers(at)},
                                  {"matrix", rows}});
}

void OwnWriter::springs() {
  const Body& on = bodies_[any_body()];
  const Vector3d at = on.at + 0.1 * length_ * random_.direction(),
                 other = at + length_ * random_.between(0.3, 1) * random_.direction();
  json item{{"name", "spring"},           {"body", on.name},
            {"other", "ground"},          {"at", numbers(at)},
            {"other_at", numbers(other)}, {"stiffness", modulus_ * length_ * decades(-9, -6)}};
  if (random_.chance(0.4)) item["free_length"] = random_.between(0.9, 1.1) * (at - other).norm();
  document_["springs"].push_back(item);
}

void OwnWriter::hold() {
  for (const Body& body : bodies_) {
    const bool last = body.name == "end_effector";
    if (!random_.chance(last ? 0.6 : 0.25)) continue;
    std::array<bool, 6> held{};
    const double kind = random_.between(0, 1);
    if (kind < 0.4) {  // a plane
      const int normal = random_.chance(0.7) ? 2 : random_.whole(0, 2);
      for (int d = 0; d < 3; ++d) held[static_cast<std::size_t>(d + (d == normal ? 0 : 3))] = true;
    } else {
      const double p = kind < 0.75 ? 0.35 : 0.85;
      for (bool& one : held) one = random_.chance(p);
    }
    json list = json::array();
    for (std::size_t d = 0; d < 6; ++d)
      if (held[d] && list.size() < 5) list.push_back(direction_names[d]);
    if (!list.empty()) item_of(body.name)["held"] = list;
  }
}

void OwnWriter::drive() {
  const double many = random_.between(0, 1);
  const int count = many < 0.55 ? 1 : many < 0.75 ? 2 : many < 0.87 ? 3 : random_.whole(4, 6);
  json drives = json::array();
  std::set<std::pair<std::string, int>> used;
  for (int k = 0; k < count; ++k) {
    std::string body = random_.chance(0.85) ? "end_effector" : bodies_[any_body()].name;
    if (k == 0 && count == 1 && random_.chance(0.9)) body = "end_effector";
    const int d = random_.chance(0.7) ? random_.whole(0, 2) : random_.whole(3, 5);
    if (!used.insert({body, d}).second) continue;
    bool held = false;
    const json& item = item_of(body);
    if (item.contains("held"))
      for (const json& name : item["held"])
        held = held || name == direction_names[static_cast<std::size_t>(d)];
    if (held) continue;
    json drive{{"name", fmt::format("d{}", drives.size())},
               {"body", body},
               {"direction", direction_names[static_cast<std::size_t>(d)]}};
    if (bodies_.size() > 1 && random_.chance(0.15)) {
      const std::string& other = bodies_[any_body()].name;
      if (other != body) drive["other"] = other;
    }
    if (random_.chance(0.08)) {
      const std::string frame = fmt::format("frame of d{}", drives.size());
      document_["frames"].push_back(
          {{"name", frame},
           {"turn", json::array({json::array({"z", random_.between(-1, 1)}),
                                 json::array({"x", random_.between(-1, 1)})})}});
      drive["frame"] = frame;
    }
    drives.push_back(drive);
  }
  if (drives.empty()) throw SpecError("/drives", "none", "every direction is held");
  if (drives.size() == 1 && random_.chance(0.5)) {
    drives[0].erase("name");
    document_["drive"] = drives[0];
  } else {
    document_["drives"] = drives;
  }
}

json OwnWriter::model() {
  json model;
  if (random_.chance(quick_ ? 0.6 : 0.4)) {
    model["flexure"] = "beam";
    model["mesh"] = json::array({quick_ ? random_.whole(2, 4) : random_.whole(4, 8), 2});
  } else {
    const int along = quick_ ? random_.whole(2, 3) : random_.whole(4, 7);
    model["mesh"] = json::array({along, quick_ ? 2 : random_.whole(2, 3)});
  }
  return model;
}

// As large that the stress of the undeflected mechanism is `strain` times the modulus.
void OwnWriter::add_loads(json& job) {
  json loads = json::array();
  const int count = random_.chance(0.45) ? random_.whole(1, 2) : 0;
  for (int k = 0; k < count; ++k) {
    const Body& on = bodies_[random_.chance(0.6) ? bodies_.size() - 1 : any_body()];
    json load{{"name", fmt::format("F{}", k)}, {"body", on.name}};
    const double small = 1e-10 * modulus_ * length_ * length_;
    const Vector3d f = small * random_.direction(), m = 0.3 * length_ * small * random_.direction();
    const bool arm = random_.chance(0.4), moment = random_.chance(0.3);
    const Vector3d at = on.at + 0.3 * length_ * random_.direction();
    const double strain = decades(-5, -3.3);
    load["force"] = numbers(f);
    if (arm) load["at"] = numbers(at);
    if (moment) load["moment"] = numbers(m);
    json probe = job;
    probe["loads"] = json::array({load});
    const auto stress = stress_of(probe);
    if (!stress || !(*stress > 0)) continue;
    // what goes straight into a drive or a support strains no leaf: no more than one bears along
    const double most = strain * modulus_ * 5e-4 * length_ * length_;
    const double factor = two_digits(std::min(most / small, strain * modulus_ / *stress));
    load["force"] = numbers(factor * f);
    if (moment) load["moment"] = numbers(factor * m);
    loads.push_back(load);
  }
  if (!loads.empty()) job["loads"] = loads;
}

void OwnWriter::add_strokes(json& job) {
  const bool named = document_.contains("drives");
  const json drives = named ? document_["drives"] : json::array({document_["drive"]});
  const auto at = [&](const std::vector<double>& strokes) -> json {
    if (!named) return strokes[0];
    json point = json::object();
    for (std::size_t k = 0; k < strokes.size(); ++k)
      point[drives[k]["name"].get<std::string>()] = strokes[k];
    return point;
  };
  std::vector<double> most(drives.size());
  const double strain = decades(-3.5, -2);
  for (std::size_t k = 0; k < drives.size(); ++k) {
    const bool rotation = drives[k]["direction"].get<std::string>()[0] == 'r';
    const double small = rotation ? 1e-5 : 1e-5 * length_;
    std::vector<double> one(drives.size(), 0.0);
    one[k] = small;
    json probe = job;
    probe["stroke"] = {{"at", json::array({at(one)})}};
    const auto stress = stress_of(probe);
    const double cap = rotation ? 0.5 : 0.25 * length_, share = random_.between(0.2, 1);
    const double sign = random_.chance(0.5) ? 1 : -1;
    if (!stress || !(*stress > 0)) throw SpecError("/stroke", "no stress", "nothing is driven");
    most[k] = sign * two_digits(share * std::min(cap, small * strain * modulus_ / *stress));
  }
  const int points = quick_ ? 2 : random_.whole(2, 4);
  json list = json::array();
  const bool straight = drives.size() == 1 || random_.chance(0.7);
  for (int j = 0; j < points; ++j) {
    std::vector<double> strokes = most;
    for (double& s : strokes) s *= straight ? j / (points - 1.0) : random_.between(-1, 1);
    list.push_back(at(strokes));
  }
  if (drives.size() == 1 && random_.chance(0.15)) list.push_back(at({-0.5 * most[0]}));
  job["stroke"] = {{"at", list}};
}

// A random design of frames, parts and mirrors, written flat.
void OwnWriter::take_document(const json& flat) {
  document_ = flat;
  document_.erase("parameters");
  document_["parameters"] = json::object();
  for (const json& item : document_["bodies"])
    if (item.contains("at"))
      bodies_.push_back({item["name"], Vector3d(item["at"][0], item["at"][1], item["at"][2])});
  std::ranges::stable_partition(bodies_, [](const Body& b) { return b.name != "end_effector"; });
  length_ = 0.08;
}

json flat_design(unsigned long long seed) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("flexopt_own_{}", getpid());
  std::filesystem::create_directories(folder);
  const RandomDesign design = random_design(seed, folder);
  const json flat =
      json::parse(expanded(*design.family, design.values, default_choices(*design.family),
                           materials().front().material)
                      .dump());
  std::filesystem::remove_all(folder);
  return flat;
}

json OwnWriter::write(unsigned long long seed, bool of_design) {
  material_ = json{{"youngs_modulus", 2e11},
                   {"poissons_ratio", 0.3},
                   {"density", 7800},
                   {"thermal_expansion", 1.1e-5}};
  switch (random_.whole(0, 3)) {
    case 0:
      material_ = json{{"youngs_modulus", 7e10},
                       {"poissons_ratio", 0.33},
                       {"density", 2700},
                       {"thermal_expansion", 2.3e-5}};
      break;
    case 1:
      material_ = json{{"youngs_modulus", 2.2e9},
                       {"poissons_ratio", 0.38},
                       {"density", 1200},
                       {"thermal_expansion", 7e-5}};
      break;
    default:
      break;
  }
  modulus_ = material_["youngs_modulus"];
  document_ = json{{"flexopt_design", 1},          {"name", fmt::format("own {}", seed)},
                   {"parameters", json::object()}, {"frames", json::array()},
                   {"bodies", json::array()},      {"leaves", json::array()},
                   {"joints", json::array()},      {"springs", json::array()}};
  if (of_design) {
    take_document(flat_design(seed));
  } else {
    length_ = two_digits(decades(-2, -0.5));
    axes_ = turned();
    const double many = random_.between(0, 1);
    const int count = many < 0.5 ? 1 : many < 0.75 ? 2 : many < 0.9 || quick_ ? 3 : 4;
    for (int b = 0; b < count; ++b)
      bodies_.push_back({b + 1 == count ? "end_effector" : fmt::format("body {}", b), {}});
    for (std::size_t b = 0; b < bodies_.size(); ++b) stage(b);
    if (!quick_ && document_["leaves"].size() < most_leaves && random_.chance(0.15)) loop();
    masses();
    if (random_.chance(0.1)) arm();
    if (random_.chance(0.15)) springs();
    hold();
    drive();
  }
  json job{{"flexopt", 1},
           {"name", fmt::format("own {}", seed)},
           {"job", "evaluate"},
           {"design",
            {{"mechanism", document_}, {"parameters", json::object()}, {"material", material_}}},
           {"frequencies", 4},
           {"model", model()}};
  const bool named = document_.contains("drives");
  json rest = 0.0;
  if (named) {
    rest = json::object();
    for (const json& one : document_["drives"]) rest[one["name"].get<std::string>()] = 0.0;
  }
  job["stroke"] = {{"at", json::array({rest})}};
  const double mass = 2000 * std::pow(0.2 * length_, 3) * decades(-1, 1),
               inertia = 0.05 * mass * length_ * length_;
  if (random_.chance(0.85)) {
    job["end_effector"] = {{"mass", mass},
                           {"inertia", json::array({inertia, 1.3 * inertia, 0.9 * inertia})}};
    if (random_.chance(0.3))
      job["end_effector"]["center_of_mass"] = numbers(0.2 * length_ * random_.direction());
  }
  parse_job(job);  // throws
  add_loads(job);
  add_strokes(job);
  if (random_.chance(0.15)) job["gravity"] = numbers(9.81 * random_.direction());
  if (random_.chance(0.1)) {
    json& warm = job["temperature"];
    warm = {{"change", (random_.chance(0.7) ? 1 : -1) * decades(-0.5, 1.5)}};
    if (random_.chance(0.3)) warm["leaves"][any_leaf()] = decades(-0.5, 1.5);
  }
  if (random_.chance(0.12))
    job["assembly"] =
        json::array({{{"leaf", any_leaf()},
                      {"end", random_.chance(0.5) ? "base" : "tip"},
                      {"move", numbers(length_ * decades(-6, -4) * random_.direction())},
                      {"turn", numbers(decades(-4, -2.7) * random_.direction())}}});
  parse_job(job);
  return job;
}

}  // namespace

json random_own_job(unsigned long long seed) {
  constexpr int most_tries = 60;
  for (int tries = 0;; ++tries) {
    try {
      const bool quick = seed >= first_quick_job;
      OwnWriter writer(seed + 1000003ULL * static_cast<unsigned long long>(tries), quick);
      return writer.write(seed, !quick && seed % 6 == 5);
    } catch (const SpecError&) {  // leaves that cross, bodies that nothing holds
      if (tries == most_tries) throw;
    }
  }
}

}  // namespace flexopt
