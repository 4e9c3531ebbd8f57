#include "support/random_jobs.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "core/spec/quantity.hpp"
#include "designs/family.hpp"
#include "support/random_design.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

// Of parameters that the families leave without default [SI].
const std::map<std::string, double> usual{
    {"length", 0.1},       {"width", 0.03},        {"thickness", 5e-4},
    {"spacing", 0.06},     {"gap", 1e-3},          {"outer_width", 0.012},
    {"inner_width", 0.03}, {"load_point_x", 0.05}, {"load_point_z", 0.01}};

bool is_thin(const std::string& name) {
  return name.ends_with("thickness") || name.ends_with("diameter");
}

class JobWriter {
 public:
  explicit JobWriter(unsigned long long seed)
      : random_(seed * 7919 + 17),
        quick_(seed >= first_quick_job),
        family_(families()[seed % families().size()]) {}

  json write();

 private:
  double decades(double low, double high) { return std::pow(10, random_.between(low, high)); }
  json number_of(const Parameter& p);
  json parameters();
  json stroke();
  json mesh();
  int points() { return quick_ ? random_.whole(1, 3) + 1 : 4; }
  json model(bool wires, bool flat);
  json force(double least, double most);

  RandomNumbers random_;
  bool quick_;
  const Family& family_;
  double size_ = 1;                           // over the usual one
  double length_ = 0, thin_ = 0, width_ = 0;  // of a leaf [m]
};

json JobWriter::number_of(const Parameter& p) {
  const double base = p.default_value.value_or(usual.contains(p.name) ? usual.at(p.name)
                                               : p.unit == "m"        ? 0.03
                                                                      : 1.0);
  if (std::ranges::find(family_.counts, p.name) != family_.counts.end())
    return random_.whole(std::max(1, static_cast<int>(p.min)), 6);
  double value = base;
  if (p.unit == "m" && p.name == "thickness")
    value = thin_;
  else if (p.unit == "m" && is_thin(p.name))
    value = p.name == "reinforcement_thickness" ? thin_ * random_.between(2, 20)
                                                : length_ / decades(std::log10(5), 3);
  else if (p.unit == "m")
    value = p.name == "length" ? length_ : base * size_ * decades(-0.4, 0.4);
  else if (p.unit == "kg")
    value = random_.chance(0.3) ? 0 : decades(-3, 1);
  else
    value = base * random_.between(0.4, 1.6);
  if (p.name == "width") width_ = value;
  return value;
}

json JobWriter::parameters() {
  double base = 0.05;
  for (const Parameter& p : family_.parameters)
    if (p.name == "length" || p.name == "chord" || p.name == "height") {
      base = p.default_value.value_or(usual.at("length"));
      break;
    }
  size_ = decades(-1.5, 1.5);
  length_ = base * size_ * decades(-0.3, 0.3);
  thin_ = length_ / decades(std::log10(5), 3);
  width_ = 0.3 * length_;
  json values = json::object();
  for (const Parameter& p : family_.parameters) {
    const json value = number_of(p);
    values[p.name] = value;
  }
  return values;
}

// To 5 lengths, or half a turn.
json JobWriter::stroke() {
  const auto furthest = [&](Direction d) {
    return is_rotation(d) ? std::min(3.1, decades(-3, 0.5)) : length_ * decades(-3.5, 0.7);
  };
  if (!family_.drives.named()) {
    const double to = furthest(family_.drives.first());
    return {{"from", random_.chance(0.3) ? -0.5 * to : 0.0}, {"to", to}, {"points", points()}};
  }
  json at = json::array();
  std::vector<double> most;
  for (const auto& item : family_.drives.items) most.push_back(furthest(item.direction));
  const int count = points();
  for (int k = 0; k < count; ++k) {
    json point = json::object();
    for (std::size_t j = 0; j < most.size(); ++j)
      point[family_.drives.items[j].name] = most[j] * random_.between(-1, 1);
    at.push_back(point);
  }
  return {{"at", at}};
}

// In parts of the buckling load of a leaf.
json JobWriter::force(double least, double most) {
  const double buckling = 3.3 * 1e11 * width_ * std::pow(thin_, 3) / (length_ * length_);
  const Vector3d f = std::min(1e11, buckling * decades(least, most)) * random_.direction();
  return json::array({f[0], f[1], f[2]});
}

// Coarse and odd ones cost little, and try the same code.
json JobWriter::mesh() {
  if (!quick_ || random_.chance(0.03)) return random_.chance(0.2) ? json{10, 4} : json{6, 2};
  const int along = random_.whole(2, 6), other = random_.whole(2, 6);
  return {std::min(along, other), random_.chance(0.25) ? 3 : 2};
}

// Wires are beams, and what is not flat leaves alone is reduced by the default method.
json JobWriter::model(bool wires, bool flat) {
  json model{{"mesh", mesh()}};
  if (quick_ && random_.chance(0.01)) model.erase("mesh");  // that of the family
  model["accuracy"] = random_.chance(0.5) ? "full" : "reduced";
  if (random_.chance(0.25) || wires) model["flexure"] = "beam";
  if (model["accuracy"] == "reduced" && flat && random_.chance(0.3)) {
    constexpr std::array methods{"linear_craig_bampton", "modal_derivatives", "quadratic_manifold"};
    model["method"] = methods[static_cast<std::size_t>(random_.whole(0, 2))];
  } else if (model["accuracy"] == "reduced" && random_.chance(quick_ ? 0.05 : 0.2)) {
    model["degree"] = 7;
  }
  return model;
}

json JobWriter::write() {
  json job{{"flexopt", 1}, {"name", "random"}, {"frequencies", 4}};
  json& design = job["design"];
  design["family"] = family_.name;
  FamilyChoices choices = default_choices(family_);
  for (const FamilyOption& option : family_.options) {
    choices[option.name] = option.choices[static_cast<std::size_t>(
        random_.whole(0, static_cast<int>(option.choices.size()) - 1))];
    design[option.name] = choices[option.name];
  }
  design["parameters"] = parameters();
  const std::vector<NamedMaterial>& known = materials();
  design["material"] =
      known[static_cast<std::size_t>(random_.whole(0, static_cast<int>(known.size()) - 1))]
          .material.name;
  const bool carries = family_.has_end_effector(choices);
  if (carries) {
    const double mass = decades(-3, 1) * std::pow(size_, 3),
                 inertia = 0.1 * mass * length_ * length_;
    job["end_effector"] = {{"mass", mass}, {"inertia", json::array({inertia, inertia, inertia})}};
  }
  if (family_.drives.items.empty() || random_.chance(0.1))
    job["load_path"] = {{"force", force(-2, 1.5)}, {"points", points()}};
  else
    job["stroke"] = stroke();
  if (random_.chance(0.5)) job["loads"] = json::array({{{"force", force(-3, 1)}}});
  static const std::set<std::string> other{"notch_hinge",    "curved_hinge", "curved_leaf",
                                           "tapered_leaf",   "folded_leaf",  "folded_leaf_stage",
                                           "spherical_joint"};
  bool wires = family_.is_of_wires(choices);
  for (const Parameter& p : family_.parameters) wires = wires || p.name.ends_with("diameter");
  if (choices.contains("section") && choices["section"] == "circular") {
    wires = true;
    design["parameters"].erase("width");
  }
  job["model"] = model(wires, !other.contains(family_.name));
  return job;
}

// A number of this dimension, wherever it stands: one, a list of them, or by names.
void grow(json& value, double by) {
  if (value.is_number())
    value = value.get<double>() * by;
  else
    for (json& one : value) grow(one, by);
}

}  // namespace

json random_job(unsigned long long seed) { return JobWriter(seed).write(); }

double growth_of(const std::string& unit, double factor) {
  if (unit == "1") return 1;
  const auto measure = measured(1, unit);
  assert(measure);
  const auto& powers = measure->dimension.powers;  // m, kg, s
  return std::pow(factor, powers[0] + 3 * powers[1] + powers[2]);
}

json scaled_job(json job, double factor) {
  const Family& family = find_family(job["design"]["family"], "");
  for (const Parameter& p : family.parameters)
    if (std::ranges::find(family.counts, p.name) == family.counts.end() &&
        job["design"]["parameters"].contains(p.name))
      grow(job["design"]["parameters"][p.name], growth_of(p.unit, factor));
  if (job.contains("end_effector")) {
    grow(job["end_effector"]["mass"], growth_of("kg", factor));
    grow(job["end_effector"]["inertia"], growth_of("kg m^2", factor));
  }
  const double force = growth_of("N", factor);
  if (job.contains("load_path")) grow(job["load_path"]["force"], force);
  if (job.contains("loads"))
    for (json& load : job["loads"]) grow(load["force"], force);
  if (!job.contains("stroke")) return job;
  json& stroke = job["stroke"];
  const auto of = [&](Direction d) { return is_rotation(d) ? 1.0 : factor; };
  if (stroke.contains("at")) {
    for (json& point : stroke["at"])
      for (const auto& item : family.drives.items) grow(point[item.name], of(item.direction));
  } else {
    for (const char* key : {"from", "to"}) grow(stroke[key], of(family.drives.first()));
  }
  return job;
}

}  // namespace flexopt
