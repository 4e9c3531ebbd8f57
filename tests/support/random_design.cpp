#include "support/random_design.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "core/spec/spec_error.hpp"

namespace flexopt {

using nlohmann::json;

Vector3d RandomNumbers::direction() {
  for (;;) {
    const Vector3d v(between(-1, 1), between(-1, 1), between(-1, 1));
    if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
  }
}

namespace {

constexpr double size = 0.08, width = 0.02, thickness = 5e-4, tilt = 0.3;

class Writer {
 public:
  Writer(unsigned long long seed, std::string folder)
      : random_(seed), seed_(seed), folder_(std::move(folder)) {}

  RandomDesign write() {
    document_ = json::parse(R"({
      "flexopt_design": 1,
      "parameters": {"size": {"unit": "m", "above": 0, "default": "80 mm"},
                     "w": {"unit": "m", "above": 0, "default": "20 mm"},
                     "t": {"unit": "m", "above": 0, "default": "0.5 mm"},
                     "tilt": {"unit": "rad", "default": 0.3},
                     "mass": {"unit": "kg", "min": 0, "default": 0.1},
                     "k": {"unit": "N/m", "min": 0, "default": 2000}},
      "let": {"half": "size/2", "twice": "4*half"},
      "frames": [], "bodies": [], "leaves": [], "joints": [], "springs": [], "parts": []})");
    holds_ = random_.chance(0.1);
    if (!holds_ && random_.chance(0.6)) {
      frame_ = "tilted";
      document_["frames"].push_back({{"name", "tilted"},
                                     {"at", place(0.01 * random_.direction())},
                                     {"turn", json::array({turn(random_.between(-0.5, 0.5)),
                                                           turn(random_.between(-1, 1))})}});
      if (random_.chance(0.4)) {
        frame_ = "nested";
        document_["frames"].push_back({{"name", "nested"},
                                       {"in", "tilted"},
                                       {"at", place(0.01 * random_.direction())},
                                       {"turn", json::array({turn(random_.between(-1, 1))})}});
      }
    }
    tree();
    if (random_.chance(0.5)) loop();
    if (random_.chance(0.35)) legs();
    if (random_.chance(0.35)) jointed();
    if (random_.chance(0.35)) spring();
    if (random_.chance(0.25)) bushing();
    if (random_.chance(0.3)) part();
    if (random_.chance(0.3)) material_point();
    drive();
    RandomDesign design;
    design.document = document_;
    design.folder = folder_;
    design.driven = driven_;
    design.direction = direction_;
    return design;
  }

 private:
  // A number as one may write it.
  json length(double value) {
    switch (random_.whole(0, 4)) {
      case 0:
        return value;
      case 1:
        return fmt::format("{:.12g} mm", 1e3 * value);
      case 2:
        return fmt::format("({:.17g})*size", value / size);
      case 3:
        return fmt::format("{:.17g}*half - ({:.12g} mm)", 2 * (value + 0.01) / size, 10.0);
      default:
        return fmt::format("({:.17g})*twice + {:.17g}*t", (value - 4e-4) / (2 * size), 0.8);
    }
  }
  json place(const Vector3d& at) {
    return json::array({length(at[0]), length(at[1]), length(at[2])});
  }
  json angle(double value) {
    switch (random_.whole(0, 2)) {
      case 0:
        return value;
      case 1:
        return fmt::format("{:.12g} deg", value * 180 / std::numbers::pi);
      default:
        return fmt::format("({:.17g})*tilt", value / tilt);
    }
  }
  json thick(double value) {
    return random_.chance(0.3) ? json(value) : json(fmt::format("{:.17g}*t", value / thickness));
  }
  json wide(double value) {
    return random_.chance(0.3) ? json(value)
                               : json(fmt::format("{:.17g}*w*(1 + 0.1*sin(tilt))",
                                                  value / width / (1 + 0.1 * std::sin(tilt))));
  }
  json direction(const Vector3d& v) {
    return json::array({v[0], fmt::format("({:.17g})*cos(tilt)", v[1] / std::cos(tilt)), v[2]});
  }
  json turn(double by) {
    const json about = axis();
    return json::array({about, angle(by)});
  }
  json axis() { return std::string(1, "xyz"[random_.whole(0, 2)]); }

  // All of the tree is written in one frame, or that of the file.
  void in_frame(json& item) {
    if (!frame_.empty()) item["frame"] = frame_;
  }

  json edge(const std::string& body, const Vector3d& at) {
    return {{"body", body}, {"at", place(at)}};
  }

  json leaf(const std::string& name, const std::string& base, const Vector3d& from,
            const std::string& tip, const Vector3d& to) {
    json l{{"name", name}, {"base", edge(base, from)}, {"tip", edge(tip, to)}};
    in_frame(l);
    const double length = (to - from).norm();
    const int kind = random_.whole(0, 7);
    if (kind == 5) {
      l["diameter"] = thick(random_.between(8e-4, 1.5e-3));
      return l;
    }
    const Vector3d along = (to - from) / length;
    Vector3d across = random_.direction();
    while (std::abs(across.dot(along)) > 0.7) across = random_.direction();
    l["across"] = direction(across);
    const double w = random_.between(0.1, 0.25) * length, t = random_.between(3e-4, 7e-4);
    l["width"] = wide(w);
    l["thickness"] = thick(t);
    // never equal at both ends: the factors of a profile refer to the thinner one
    if (kind == 1) l["width"] = json::array({wide(w), wide(random_.between(0.5, 0.97) * w)});
    if (kind == 2)
      l["thickness"] = json::array(
          {thick(t),
           thick((random_.chance(0.4) ? random_.between(0.7, 0.97) : random_.between(1.03, 1.5)) *
                 t)});
    if (kind == 3)
      l["thickness"] = {{"profile", fmt::format("{:.17g}*t*(1 + {:.3f}*(s - 0.5)^2)", t / thickness,
                                                random_.between(0.5, 4))}};
    if (kind == 4)
      l["reinforcement"] = {{"fraction", random_.between(0.3, 0.6)},
                            {"thickness", thick(5e-3)},
                            {"rigid", random_.chance(0.7)}};
    if (kind == 7)
      l["curve"] = {{"angle", angle((random_.chance(0.5) ? 1 : -1) * random_.between(0.1, 1.2))}};
    if (kind == 0 || kind == 6) fold(l, from, to, across);
    if (kind == 6 || random_.chance(0.1))
      l["material"] = {{"youngs_modulus", random_.between(70e9, 200e9)},
                       {"poissons_ratio", random_.between(0.2, 0.4)},
                       {"density", random_.between(2700, 8000)}};
    return l;
  }

  // Some leaves have an elastic fold; their legs keep at right angles to it at all parameters.
  void fold(json& l, const Vector3d& from, const Vector3d& to, const Vector3d& across) {
    RandomNumbers own(7919 * seed_ + ++folds_);
    if (!own.chance(0.5)) return;
    const Vector3d along = (to - from).normalized(),
                   width = (across - along * along.dot(across)).normalized(),
                   at = from + own.between(0.35, 0.65) * (to - from) +
                        own.between(0.2, 0.6) * (to - from).norm() * width.cross(along);
    const auto numbers = [](const Vector3d& v) { return json::array({v[0], v[1], v[2]}); };
    l["base"]["at"] = numbers(from);
    l["tip"]["at"] = numbers(to);
    l["across"] = numbers(width);
    l["fold"] = {{"at", numbers(at)}};
    if (own.chance(0.5)) l["fold"]["radius"] = thick(own.between(1e-4, 1.5e-3));
  }

  json body(const std::string& name, const Vector3d& at) {
    json b{{"name", name}, {"at", place(at)}};
    in_frame(b);
    if (name == "end_effector") return b;  // the payload is its mass
    switch (random_.whole(0, 4)) {
      case 0:  // massless
        break;
      case 1:
        b["box"] = place({random_.between(0.005, 0.01), random_.between(0.005, 0.01),
                          random_.between(0.005, 0.01)});
        b["density"] = "2700 kg/m^3";
        break;
      case 2:
        b["mass"] = fmt::format("{:.3f}*mass", random_.between(0.3, 2));
        b["inertia"] = {{3e-5, 1e-6, -2e-6}, {1e-6, 4e-5, 3e-6}, {-2e-6, 3e-6, 5e-5}};
        b["center_of_mass"] = place(5e-3 * random_.direction());
        break;
      default:
        b["mass"] = "mass";
        b["inertia"] = json::array({"mass*(size/10)^2 + 1e-5 [kg m^2]", "mass*(size/10)^2", 1e-5});
    }
    return b;
  }

  // Bodies at random places, each on a leaf from the ground or one that is there.
  void tree() {
    const int count = random_.whole(1, 4);
    for (int k = 0; k < count; ++k) {
      const int parent = k == 0 ? -1 : random_.chance(0.7) ? k - 1 : random_.whole(-1, k - 1);
      const std::string base = parent < 0 ? "ground" : names_[static_cast<std::size_t>(parent)];
      const Vector3d from = parent < 0
                                ? Vector3d(0.15 * random_.direction())
                                : Vector3d(places_[static_cast<std::size_t>(parent)] +
                                           random_.between(0.008, 0.02) * random_.direction());
      const Vector3d to = from + random_.between(0.05, 0.1) * random_.direction();
      const std::string name = k + 1 == count ? "end_effector" : fmt::format("body {}", k);
      names_.push_back(name);
      places_.push_back(to + random_.between(0.003, 0.01) * random_.direction());
      document_["bodies"].push_back(body(name, places_.back()));
      document_["leaves"].push_back(leaf(fmt::format("leaf {}", k), base, from, name, to));
    }
  }

  std::size_t any_body() {
    return static_cast<std::size_t>(random_.whole(0, static_cast<int>(names_.size()) - 1));
  }

  // One more leaf between two bodies, or a body and the ground.
  void loop() {
    const std::size_t a = any_body(), b = any_body();
    const Vector3d to = places_[a] + 0.015 * random_.direction();
    if (a != b && (places_[a] - places_[b]).norm() > 0.06)
      document_["leaves"].push_back(
          leaf("loop", names_[b], places_[b] + 0.015 * random_.direction(), names_[a], to));
    else
      document_["leaves"].push_back(leaf(
          "loop", "ground", to + random_.between(0.05, 0.1) * random_.direction(), names_[a], to));
  }

  // Two or three equal legs around an axis through a body, each with a foot that is a body.
  void legs() {
    const std::size_t on = any_body();
    const int count = random_.whole(2, 3);
    const std::string about(1, "xyz"[random_.whole(0, 2)]);
    json frame{{"name", "leg {i}"},
               {"at", place(places_[on])},
               {"turn", json::array({json::array({about, fmt::format("{} deg*i", 360 / count)})})},
               {"repeat", {{"i", json::array({0, fmt::format("{} - 1", count)})}}}};
    if (!frame_.empty()) frame["in"] = frame_;
    const Vector3d radial = about == "x" ? Vector3d::UnitY() : Vector3d::UnitX();
    const Vector3d from = 0.02 * radial,
                   to = from + random_.between(0.04, 0.07) * (radial + 0.3 * random_.direction());
    json foot = body("foot {i}", to + 0.004 * radial);
    foot["frame"] = "leg {i}";
    json wire = leaf("upper {i}", names_[on], from, "foot {i}", to),
         lower = leaf("lower {i}", "ground", to + 0.01 * radial + Vector3d(0.05, 0.042, 0.057),
                      "foot {i}", to + 0.01 * radial);
    for (json* item : {&foot, &wire, &lower}) {
      (*item)["frame"] = "leg {i}";
      (*item)["repeat"] = frame["repeat"];
    }
    document_["frames"].push_back(frame);
    document_["bodies"].push_back(foot);
    document_["leaves"].push_back(wire);
    document_["leaves"].push_back(lower);
  }

  // A body on a joint, held besides by a bushing between the same two.
  void jointed() {
    const std::size_t on = any_body();
    const Vector3d at = places_[on] + 0.02 * random_.direction();
    document_["bodies"].push_back(body("arm", at));
    static const char* types[] = {"rigid", "revolute", "spherical", "prismatic"};
    const std::string type = types[random_.whole(0, 3)];
    json joint{{"name", "joint"},
               {"type", type},
               {"body", "arm"},
               {"other", names_[on]},
               {"at", place(at + 0.003 * random_.direction())}};
    in_frame(joint);
    if (type == "revolute" || type == "prismatic") joint["axis"] = direction(random_.direction());
    document_["joints"].push_back(joint);
    if (type != "rigid") add_bushing("holder", "arm", names_[on], at);
  }

  void add_bushing(const std::string& name, const std::string& of, const std::string& other,
                   const Vector3d& at) {
    json rows = json::array();
    for (int r = 0; r < 6; ++r) {
      json row = json::array();
      for (int c = 0; c < 6; ++c) row.push_back(0);
      row[static_cast<std::size_t>(r)] = r < 3 ? json("20*k") : json(random_.between(1, 4));
      rows.push_back(row);
    }
    rows[0][4] = rows[4][0] = 15;
    rows[1][2] = rows[2][1] = 900;
    json item{{"name", name}, {"body", of}, {"other", other}, {"at", place(at)}, {"matrix", rows}};
    in_frame(item);
    document_["springs"].push_back(item);
  }

  void spring() {
    const std::size_t a = any_body(), b = any_body();
    const Vector3d at = places_[a] + 0.01 * random_.direction();
    const Vector3d other = a == b ? Vector3d(at + 0.05 * random_.direction())
                                  : Vector3d(places_[b] + 0.01 * random_.direction());
    json item{{"name", "spring"},
              {"body", names_[a]},
              {"other", a == b ? std::string("ground") : names_[b]},
              {"at", place(at)},
              {"other_at", place(other)},
              {"stiffness", "k"}};
    if (random_.chance(0.5))
      item["free_length"] = random_.between(0.97, 1.03) * (at - other).norm();
    in_frame(item);
    document_["springs"].push_back(item);
  }

  void bushing() {
    const std::size_t a = any_body();
    add_bushing("bushing", names_[a], "ground", places_[a] + 0.01 * random_.direction());
  }

  // A parallel guide of the library, or a file of our own, on one of the bodies.
  void part() {
    const std::size_t on = any_body();
    json frame{{"name", "side"},
               {"at", place(places_[on] + 0.03 * random_.direction())},
               {"turn", json::array({turn(random_.between(-3, 3)), turn(0.4)})}};
    if (!frame_.empty()) frame["in"] = frame_;
    document_["frames"].push_back(frame);
    json item{{"name", "side"}, {"frame", "side"}, {"join", {{"end_effector", names_[on]}}}};
    if (random_.chance(0.5)) item["mirror"] = axis();
    if (random_.chance(0.5)) {
      item["design"] = "parallel_guide";
      item["parameters"] = {
          {"length", "0.8*size"}, {"width", "w"}, {"thickness", "t"}, {"spacing", "half/2"}};
    } else {
      const std::string file = fmt::format("part_{}.json", seed_);
      json inner = json::parse(R"({
        "flexopt_design": 1,
        "parameters": {"length": {"unit": "m", "default": "50 mm"}, "thick": {"unit": "m", "default": "0.4 mm"}},
        "frames": [{"name": "arm {i}", "turn": [["x", "180 deg*i"], ["y", "20 deg"]], "repeat": {"i": [0, 1]}}],
        "bodies": [{"name": "end_effector", "at": [0, 0, 0]},
                   {"name": "mid {i}", "frame": "arm {i}", "repeat": {"i": [0, 1]}, "at": ["-length", "3 mm", "12 mm"],
                    "mass": 0.02, "inertia": [1e-6, 2e-6, 3e-6], "center_of_mass": [1e-3, 0, 2e-3]}],
        "leaves": [{"name": "in {i}", "frame": "arm {i}", "repeat": {"i": [0, 1]}, "across": [0.3, 1, 0.1],
                    "base": {"body": "mid {i}", "at": ["-length", "5 mm", "10 mm"]},
                    "tip": {"body": "end_effector", "at": [0, "5 mm", "10 mm"]},
                    "width": [0.008, "length/5"], "thickness": "thick"},
                   {"name": "out {i}", "frame": "arm {i}", "repeat": {"i": [0, 1]},
                    "base": {"body": "ground", "at": ["-length", "8 mm", "50 mm"]},
                    "tip": {"body": "mid {i}", "at": ["-length", "8 mm", "14 mm"]}, "diameter": "2.5*thick"}],
        "springs": [{"name": "soft", "body": "mid 0", "other": "mid 1", "at": ["-length", 0, 0.02],
                     "other_at": ["-length", 0.005, -0.02], "stiffness": 300}],
        "drive": {"direction": "uy"}})");
      std::ofstream(std::filesystem::path(folder_) / file) << inner.dump(1);
      item["design"] = file;
      item["parameters"] = {{"length", "0.6*size"}, {"thick", "0.9*t"}};
    }
    document_["parts"].push_back(item);
  }

  // A point on the middle line of a flat leaf, held by a spring besides.
  void material_point() {
    const json* on = nullptr;
    for (const json& l : document_["leaves"]) {
      const bool flat = !l.contains("diameter") && !l.contains("curve") && !l.contains("fold") &&
                        !l.contains("reinforcement") && !l.contains("repeat");
      if (flat && (!on || random_.chance(0.5))) on = &l;
    }
    if (!on) return;
    const double along = random_.between(0.25, 0.75);
    const auto written = [](const json& number) {
      return number.is_number() ? fmt::format("({:.17g} m)", number.get<double>())
                                : "(" + number.get<std::string>() + ")";
    };
    json at = json::array(), away = json::array();
    for (std::size_t c = 0; c < 3; ++c) {
      const std::string from = written((*on)["base"]["at"][c]), to = written((*on)["tip"]["at"][c]);
      at.push_back(fmt::format("{0} + {2:.17g}*({1} - {0})", from, to, along));
      away.push_back(at.back().get<std::string>() + (c == 0 ? " + 20 mm" : " - 15 mm"));
    }
    json point{{"name", "point"}, {"on", {{"leaf", (*on)["name"]}, {"at", at}}}};
    in_frame(point);
    document_["bodies"].push_back(point);
    json item{{"name", "holds the point"}, {"body", "point"},    {"other", "ground"}, {"at", at},
              {"other_at", away},          {"stiffness", "k/10"}};
    in_frame(item);
    document_["springs"].push_back(item);
    has_point_ = true;
  }

  void drive() {
    static const char* directions[] = {"ux", "uy", "uz", "rx", "ry", "rz"};
    direction_ = directions[random_.chance(0.7) ? random_.whole(0, 2) : random_.whole(3, 5)];
    driven_ = names_[random_.chance(0.7) ? names_.size() - 1 : any_body()];
    if (has_point_ && random_.chance(0.3)) {
      driven_ = "point";
      direction_ = directions[random_.whole(0, 2)];
    }
    document_["drive"] = {{"body", driven_}, {"direction", direction_}};
    if (!holds_) return;
    const std::size_t held = any_body();
    const std::string along = directions[random_.whole(0, 5)];
    if (names_[held] != driven_ || along != direction_)
      document_["bodies"][held]["held"] = json::array({along});
  }

  RandomNumbers random_;
  unsigned long long seed_, folds_ = 0;
  std::string folder_;
  json document_;
  std::vector<std::string> names_;  // of the tree's bodies, in its frame
  std::vector<Vector3d> places_;
  std::string driven_, direction_;
  std::string frame_;
  bool holds_ = false, has_point_ = false;
};

}  // namespace

EndEffector random_payload() {
  EndEffector payload;
  payload.mass = 0.3;
  payload.inertia << 2e-4, 1e-5, -2e-5, 1e-5, 3e-4, 3e-5, -2e-5, 3e-5, 2.5e-4;
  payload.center_of_mass = {0.004, -0.002, 0.003};
  return payload;
}

std::shared_ptr<const Family> read_document(const json& document, const std::string& folder) {
  FaultList faults;
  auto family = read_family(document, "/design/mechanism", folder, faults);
  faults.raise();
  return family;
}

ParameterValues default_values(const Family& family) {
  ParameterValues values;
  for (const Parameter& p : family.parameters) values[p.name] = p.default_value.value();
  return values;
}

Mechanism RandomDesign::make(const ParameterValues& at) const {
  return family->make(at, default_choices(*family), materials().front().material, random_payload());
}

RandomDesign random_design(unsigned long long seed, const std::string& folder) {
  for (int tries = 0;; ++tries) {
    RandomDesign design =
        Writer(seed + 1000003ULL * static_cast<unsigned long long>(tries), folder).write();
    try {
      design.family = read_document(design.document, folder);
      design.values = default_values(*design.family);
      design.make();
      for (const auto& [name, value] : design.values)  // and those near it, for differences
        for (const double by : {0.997, 1.003}) {
          ParameterValues near = design.values;
          near[name] = by * value;
          design.make(near);
        }
    } catch (const SpecError& error) {
      // leaves that cross, or are too short for their thickness: drawn again; anything else is a
      // fault of the generator
      const std::string what = error.what();
      if (tries < 40 && (what.find("intersect") != std::string::npos ||
                         what.find("thinner than long") != std::string::npos))
        continue;
      throw;
    }
    design.refused = tries;
    return design;
  }
}

json wrapped(const RandomDesign& design, const json& frame, const std::string& mirror) {
  const std::string file =
      fmt::format("whole_{}.json", std::hash<std::string>{}(design.document.dump()));
  std::ofstream(std::filesystem::path(design.folder) / file) << design.document.dump();
  json outer{{"flexopt_design", 1}, {"parameters", design.document["parameters"]}};
  json whole = frame;
  whole["name"] = "whole";
  outer["frames"] = json::array({whole});
  json part{{"name", "all"}, {"design", file}, {"frame", "whole"}, {"parameters", json::object()}};
  for (const auto& [name, value] : design.document["parameters"].items())
    part["parameters"][name] = name;
  if (!mirror.empty()) part["mirror"] = mirror;
  part["join"] = {{"end_effector", "end_effector"}};
  outer["parts"] = json::array({part});
  // a part's end-effector is the one that it is joined to
  const Mechanism here = design.make();
  Vector3d at = here.bodies[static_cast<std::size_t>(here.end_effector)].reference;
  if (!mirror.empty()) at[mirror[0] - 'x'] *= -1;
  outer["bodies"] = json::array(
      {{{"name", "end_effector"}, {"frame", "whole"}, {"at", json::array({at[0], at[1], at[2]})}}});
  for (const json& own : design.document["bodies"])
    if (own["name"] == "end_effector" && own.contains("held"))
      outer["bodies"][0]["held"] = own["held"];
  const std::string body = design.driven == "end_effector" ? design.driven : "all/" + design.driven;
  outer["drive"] = {{"body", body}, {"direction", design.direction}, {"frame", "whole"}};
  return outer;
}

namespace {

// The text with the index in formulas and names replaced by its value.
std::string with_index(const std::string& text, const std::string& index, int value) {
  std::string result;
  for (std::size_t k = 0; k < text.size();) {
    const std::string braces = "{" + index + "}";
    if (text.compare(k, braces.size(), braces) == 0) {
      result += std::to_string(value);
      k += braces.size();
      continue;
    }
    const auto word = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
    };
    if (word(text[k])) {
      std::size_t end = k;
      while (end < text.size() && word(text[end])) ++end;
      const std::string token = text.substr(k, end - k);
      result += token == index ? "(" + std::to_string(value) + ")" : token;
      k = end;
    } else {
      result += text[k++];
    }
  }
  return result;
}

// Of every text but those that are names alone.
void put_index(json& item, const std::string& index, int value) {
  if (item.is_string()) item = with_index(item.get<std::string>(), index, value);
  if (item.is_structured())
    for (json& inner : item) put_index(inner, index, value);
}

}  // namespace

json without_repeats(const json& document) {
  json result = document;
  for (const char* list : {"frames", "bodies", "leaves", "joints", "springs", "parts"}) {
    if (!document.contains(list)) continue;
    json written = json::array();
    for (const json& item : document[list]) {
      if (!item.contains("repeat")) {
        written.push_back(item);
        continue;
      }
      const json bounds = item["repeat"]["i"];
      const auto bound = [](const json& b) {
        return b.is_number() ? b.get<int>() : std::stoi(b.get<std::string>()) - 1;  // "3 - 1"
      };
      for (int i = bound(bounds[0]); i <= bound(bounds[1]); ++i) {
        json copy = item;
        copy.erase("repeat");
        put_index(copy, "i", i);
        written.push_back(copy);
      }
    }
    result[list] = written;
  }
  return result;
}

}  // namespace flexopt
