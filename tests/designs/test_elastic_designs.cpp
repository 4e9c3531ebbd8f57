// Elastic bodies of design files: what the keys mean, what holds them, and what is refused where.
#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/mechanism/each_number.hpp"
#include "core/response/path/error_estimate.hpp"
#include "designs/describe.hpp"
#include "designs/parametric_design.hpp"
#include "support/families.hpp"
#include "support/refusals.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

const Material& leaf_steel() { return materials().front().material; }

/// Two leaves along x that end on an elastic stage, O on its far face.
json elastic_guide() {
  return json::parse(R"({
    "flexopt_design": 1,
    "parameters": {"length": {"unit": "m", "default": "60 mm"}, "h": {"unit": "m", "default": "7 mm"},
                   "pitch": {"unit": "m", "default": "80 mm"},
                   "t": {"unit": "m", "default": "0.4 mm"}},
    "bodies": [{"name": "end_effector", "at": ["length + h", "pitch/2", 0], "elastic": {
      "material": "Al-7075-T6",
      "plate": {"outline": [[0, "-10 mm"], ["h", "pitch + 10 mm"]], "thickness": "20 mm",
                "at": ["length", 0, 0]},
      "interfaces": [{"name": "O", "face": "x+", "at": ["length + h", "pitch/2", 0],
                      "size": ["16 mm", "20 mm"]}],
      "elements": {"size": "10 mm"}}}],
    "leaves": [{"name": "lower", "base": {"body": "ground", "at": [0, 0, 0]},
                "tip": {"body": "end_effector", "at": ["length", 0, 0]},
                "across": [0, 0, 1], "width": "20 mm", "thickness": "t"},
               {"name": "upper", "base": {"body": "ground", "at": [0, "pitch", 0]},
                "tip": {"body": "end_effector", "at": ["length", "pitch", 0]},
                "across": [0, 0, 1], "width": "20 mm", "thickness": "t"}],
    "drive": {"direction": "uy"}})");
}

/// A lever, a box of which nothing is given but the shape, on a notch and on a leaf.
json notched_lever() {
  return json::parse(R"({
    "flexopt_design": 1,
    "bodies": [
      {"name": "hinge", "at": [0, 0, 0], "elastic": {
        "notch": {"radius": "5 mm", "thickness": "1 mm", "width": "10 mm", "ends": "5 mm"},
        "between": ["ground", "lever"], "elements": {"size": "5 mm"}}},
      {"name": "lever", "at": ["40 mm", 0, 0], "box": ["60 mm", "20 mm", "10 mm"],
       "elastic": {"from": "box", "elements": {"size": "10 mm"}}},
      {"name": "end_effector", "at": ["40 mm", "50 mm", 0]}],
    "leaves": [{"name": "rod", "base": {"body": "lever", "at": ["40 mm", "10 mm", 0]},
                "tip": {"body": "end_effector", "at": ["40 mm", "50 mm", 0]},
                "across": [0, 0, 1], "width": "8 mm", "thickness": "0.5 mm"}],
    "springs": [{"name": "preload", "body": "lever.rod.base", "at": ["40 mm", "10 mm", 0],
                 "other_at": ["40 mm", "40 mm", 0], "stiffness": 10}],
    "drive": {"direction": "ux"}})");
}

std::shared_ptr<const Family> family_of(const json& document) {
  FaultList faults;
  auto family = read_family(document, "/design/mechanism", "", faults);
  faults.raise();
  return family;
}

ParameterValues values_of(const Family& family) {
  ParameterValues values;
  for (const Parameter& p : family.parameters) values[p.name] = *p.default_value;
  return values;
}

Mechanism made(const json& document, const FamilyChoices& choices = {},
               const EndEffector& payload = {}) {
  const auto family = family_of(document);
  FamilyChoices all = default_choices(*family);
  for (const auto& [option, choice] : choices) all[option] = choice;
  return family->make(values_of(*family), all, leaf_steel(), payload);
}

Vector3d global(const ElasticBody& body, int node) {
  return body.place + body.axes * body.nodes[static_cast<std::size_t>(node)];
}

std::vector<std::string> names_of_bodies(const Mechanism& mechanism) {
  std::vector<std::string> names;
  for (const RigidBody& body : mechanism.bodies) names.push_back(body.name);
  return names;
}

/// The smallest cuboid around the nodes of a patch, global axes.
Eigen::AlignedBox3d room(const ElasticBody& body, const ElasticInterface& interface) {
  Eigen::AlignedBox3d box;
  for (const int node : interface.patch) box.extend(global(body, node));
  return box;
}

}  // namespace

TEST_CASE("leaves end on patches of their size, and frames without mass hold these") {
  EndEffector payload;
  payload.mass = 0.2;
  payload.inertia.diagonal().setConstant(4e-5);
  const Mechanism m = made(elastic_guide(), {}, payload);
  CHECK(names_of_bodies(m) == std::vector<std::string>{"end_effector", "end_effector.lower.tip",
                                                       "end_effector.upper.tip"});
  CHECK(m.leaves[0].tip == 1);
  CHECK(m.leaves[1].tip == 2);
  CHECK(m.bodies[0].mass == 0.2);
  CHECK(m.bodies[1].mass == 0);
  CHECK((m.bodies[0].reference - Vector3d(0.067, 0.04, 0)).norm() < 1e-15);
  CHECK((m.bodies[2].reference - Vector3d(0.06, 0.08, 0)).norm() < 1e-15);
  REQUIRE(m.elastic_bodies.size() == 1);
  const ElasticBody& stage = m.elastic_bodies[0];
  CHECK(stage.material.name == "Al-7075-T6");
  CHECK(stage.degree == ElasticDegree::quartic);
  REQUIRE(stage.interfaces.size() == 3);
  const Vector3d sides[] = {{0, 0.016, 0.02}, {0, 0.0004, 0.02}, {0, 0.0004, 0.02}};
  for (std::size_t a = 0; a < 3; ++a) {
    const ElasticInterface& one = stage.interfaces[a];
    CHECK(one.body == static_cast<int>(a));
    CHECK((stage.place + stage.axes * one.face - m.bodies[a].reference).norm() < 1e-15);
    const Eigen::AlignedBox3d patch = room(stage, one);
    CHECK((patch.sizes() - sides[a]).norm() < 1e-12);
    CHECK((patch.center() - m.bodies[a].reference).norm() < 1e-12);
  }
  REQUIRE(stage.coarse);
  CHECK(stage.coarse->nodes.size() < stage.nodes.size());
  REQUIRE(m.bodies[0].box);
  CHECK((m.bodies[0].box->center - Vector3d(0.0635, 0.04, 0)).norm() < 1e-12);
  CHECK((m.bodies[0].box->half_edges.diagonal() - Vector3d(0.0035, 0.05, 0.01)).norm() < 1e-12);
}

TEST_CASE("a leaf that meets a face at an angle has a longer patch, a wire a square of its area") {
  json oblique = elastic_guide();
  oblique["leaves"][0]["base"]["at"] = {0, {}, 0};
  oblique["leaves"][0]["base"]["at"][1] = "length";  // 45 deg
  const Mechanism m = made(oblique);
  const ElasticBody& stage = m.elastic_bodies[0];
  CHECK(room(stage, stage.interfaces[1]).sizes()[1] == Approx(0.0004 * std::sqrt(2.0)));
  json wired = elastic_guide();
  json& wire = wired["leaves"][0];
  for (const char* key : {"width", "thickness", "across"}) wire.erase(key);
  wire["diameter"] = "2 mm";
  const Mechanism w = made(wired);
  const Vector3d sides = room(w.elastic_bodies[0], w.elastic_bodies[0].interfaces[1]).sizes();
  CHECK(sides[1] * sides[2] == Approx(std::acos(-1.0) * 1e-6));
}

TEST_CASE("a clamp is a patch on the face that the leaf lies on, on from its edge") {
  json document = elastic_guide();
  document["leaves"][1]["base"]["at"] = {0, "pitch + 10 mm + t/2", 0};
  document["leaves"][1]["tip"] = {{"body", "end_effector"},
                                  {"at", {"length", "pitch + 10 mm + t/2", 0}},
                                  {"clamp", {{"length", "5 mm"}, {"side", "y+"}}}};
  const Mechanism m = made(document);
  const ElasticBody& stage = m.elastic_bodies[0];
  const Eigen::AlignedBox3d patch = room(stage, stage.interfaces[2]);
  CHECK((patch.min() - Vector3d(0.06, 0.09, -0.01)).norm() < 1e-12);
  CHECK((patch.max() - Vector3d(0.065, 0.09, 0.01)).norm() < 1e-12);
}

TEST_CASE("a notch shares frames with the bodies that it is between, its points in its middle") {
  const Mechanism m = made(notched_lever());
  CHECK(names_of_bodies(m) == std::vector<std::string>{"lever", "end_effector", "lever.rod.base"});
  REQUIRE(m.elastic_bodies.size() == 2);
  const ElasticBody &hinge = m.elastic_bodies[0], &lever = m.elastic_bodies[1];
  CHECK(hinge.degree == ElasticDegree::quartic);
  CHECK(hinge.interfaces[0].body == ground);
  CHECK(hinge.interfaces[1].body == 0);
  for (std::size_t a = 0; a < 2; ++a) {
    CHECK(hinge.interface_place(a).norm() < 1e-15);
    const Vector3d face(a == 0 ? -0.01 : 0.01, 0, 0);  // a radius and an end
    CHECK((hinge.interfaces[a].face - face).norm() < 1e-15);
  }
  CHECK(lever.interfaces[0].body == 0);
  CHECK(lever.interfaces[1].body == 2);
  const Eigen::AlignedBox3d end = room(hinge, hinge.interfaces[1]),
                            face = room(lever, lever.interfaces[0]);
  CHECK((end.min() - face.min()).norm() < 1e-12);
  CHECK((end.max() - face.max()).norm() < 1e-12);
  CHECK((end.sizes() - Vector3d(0, 0.011, 0.01)).norm() < 1e-12);
  CHECK(m.springs[0].body == 2);
}

TEST_CASE("rigid ones are held by one frame, which joints tie to the bodies they name") {
  const Mechanism m = made(elastic_guide(), {{"elastic_bodies", "rigid"}});
  CHECK(names_of_bodies(m) == std::vector<std::string>{"end_effector"});
  for (const ElasticInterface& one : m.elastic_bodies[0].interfaces) CHECK(one.body == 0);
  CHECK(m.leaves[0].tip == 0);
  const Mechanism lever = made(notched_lever(), {{"elastic_bodies", "rigid"}});
  CHECK(lever.elastic_bodies[0].interfaces[1].body == 0);
  CHECK(lever.elastic_bodies[1].interfaces[1].body == 0);
  CHECK(lever.joints.empty());
  json tied = elastic_guide();
  tied["bodies"].push_back({{"name", "block"}, {"at", {"length", "pitch/2", 0}}, {"mass", 1}});
  tied["bodies"][0]["elastic"]["interfaces"].push_back({{"name", "seat"},
                                                        {"body", "block"},
                                                        {"face", "x-"},
                                                        {"at", {"length", "pitch/2", 0}},
                                                        {"size", {"10 mm", "20 mm"}}});
  tied["bodies"][0]["elastic"]["rigid"] = true;
  const Mechanism joined = made(tied);
  REQUIRE(joined.joints.size() == 1);
  CHECK(joined.joints[0].type == JointType::rigid);
  CHECK(joined.joints[0].body == 0);
  CHECK(joined.joints[0].other == 1);
}

TEST_CASE("an expanded elastic design is the same mechanism, and so it stays") {
  json turned = elastic_guide();
  turned["frames"] = {{{"name", "f"}, {"turn", json::array({json::array({"y", "90 deg"})})}}};
  for (const char* list : {"bodies", "leaves"})
    for (json& item : turned[list]) item["frame"] = "f";
  json clamped = elastic_guide();
  clamped["leaves"][1]["base"]["at"] = {0, "pitch + 10 mm", 0};
  clamped["leaves"][1]["tip"] = {{"body", "end_effector"},
                                 {"at", {"length", "pitch + 10 mm", 0}},
                                 {"clamp", {{"length", "5 mm"}, {"side", "y+"}}}};
  for (const json& document : {elastic_guide(), notched_lever(), turned, clamped})
    for (const char* choice : {"elastic", "rigid"}) {
      INFO(document.dump() << choice);
      const auto family = family_of(document);
      const FamilyChoices choices{{"elastic_bodies", choice}};
      const auto flat = expanded(*family, values_of(*family), choices, leaf_steel());
      const auto again = family_of(json::parse(flat.dump()));
      const Mechanism one = family->make(values_of(*family), choices, leaf_steel(), {}),
                      two = again->make({}, default_choices(*again), leaf_steel(), {});
      CHECK(names_of_bodies(one) == names_of_bodies(two));
      const std::vector<double> a = numbers_of(one), b = numbers_of(two);
      REQUIRE(a.size() == b.size());
      double apart = 0;
      for (std::size_t i = 0; i < a.size(); ++i) apart = std::max(apart, std::abs(a[i] - b[i]));
      CHECK(apart < 1e-15);
      CHECK(expanded(*again, {}, default_choices(*again), leaf_steel()).dump() == flat.dump());
    }
}

TEST_CASE("cells are those of the nominal design, nodes follow the parameters with exact rates") {
  const auto family = family_of(elastic_guide());
  const ParameterValues nominal = values_of(*family);
  const ParametricDesign design(family, default_choices(*family), {}, nominal);
  ParameterValues other = nominal;
  other["h"] = 0.011;
  other["pitch"] = 0.07;
  const auto at = [&](const ParameterValues& values) {
    return design.build(values, leaf_steel(), {});
  };
  const Mechanism first = at(nominal), second = at(other);
  CHECK(first.elastic_bodies[0].cells == second.elastic_bodies[0].cells);
  CHECK(at(nominal).elastic_bodies[0].cells == first.elastic_bodies[0].cells);
  const std::vector<std::string> names{"length", "h", "pitch", "t"};
  const auto rates = design.directions(other, leaf_steel(), {}, names);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const double step = 1e-6 * other[names[k]];
    ParameterValues low = other, high = other;
    low[names[k]] -= step;
    high[names[k]] += step;
    const std::vector<double> a = numbers_of(at(low)), b = numbers_of(at(high)),
                              rate = numbers_of(rates[k].rate);
    double error = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
      error = std::max(error, std::abs((b[i] - a[i]) / (2 * step) - rate[i]));
    INFO(names[k]);
    CHECK(error < 1e-7);
  }
}

TEST_CASE("a mirrored part has the mirrored nodes in right-handed axes") {
  json part = notched_lever();
  for (const char* key : {"drive", "springs"}) part.erase(key);
  part["bodies"][1]["frame"] = "up";  // nothing about it is symmetric
  part["bodies"][0]["frame"] = part["leaves"][0]["frame"] = part["bodies"][2]["frame"] = "up";
  part["frames"] = {{{"name", "up"},
                     {"at", {0, 0, "30 mm"}},
                     {"turn", json::array({json::array({"x", "20 deg"})})}}};
  part["bodies"][2]["name"] = "rod_end";
  part["leaves"][0]["tip"]["body"] = "rod_end";
  const json whole{{"flexopt_design", 1},
                   {"bodies", {{{"name", "end_effector"}, {"at", {0.04, 0, 0}}}}},
                   {"parts",
                    {{{"name", "a"}, {"design", part}, {"join", {{"rod_end", "end_effector"}}}},
                     {{"name", "b"},
                      {"design", part},
                      {"mirror", "z"},
                      {"join", {{"rod_end", "end_effector"}}}}}},
                   {"drive", {{"direction", "ux"}}}};
  const Mechanism m = made(whole);
  REQUIRE(m.elastic_bodies.size() == 4);
  for (std::size_t i = 0; i < 2; ++i) {
    const ElasticBody &one = m.elastic_bodies[i], &other = m.elastic_bodies[i + 2];
    CHECK(other.axes.determinant() == Approx(1));
    REQUIRE(one.nodes.size() == other.nodes.size());
    for (const ElasticInterface& interface : one.interfaces) {
      const auto& mate =
          other.interfaces[static_cast<std::size_t>(&interface - one.interfaces.data())];
      Eigen::AlignedBox3d expected, found;
      for (const int node : interface.patch)
        expected.extend(global(one, node).cwiseProduct(Vector3d(1, 1, -1)));
      for (const int node : mate.patch) found.extend(global(other, node));
      CHECK((expected.min() - found.min()).norm() < 1e-12);
      CHECK((expected.max() - found.max()).norm() < 1e-12);
    }
    for (int node = 0; node < one.cells->nodes; ++node) {
      const Vector3d image = global(one, node).cwiseProduct(Vector3d(1, 1, -1));
      double nearest = 1;
      for (int k = 0; k < other.cells->nodes; ++k)
        nearest = std::min(nearest, (global(other, k) - image).norm());
      REQUIRE(nearest < 1e-12);
    }
  }
}

TEST_CASE("a body of an interface, a leaf of a part and joins name elastic bodies alike") {
  json document = elastic_guide();
  document["parts"] = {{{"name", "more"},
                        {"join", {{"stage", "end_effector"}}},
                        {"design",
                         {{"flexopt_design", 1},
                          {"bodies", {{{"name", "stage"}, {"at", {0, 0, 0}}}}},
                          {"leaves", {document["leaves"][1]}}}}}};
  json& leaf = document["parts"][0]["design"]["leaves"][0];
  leaf["tip"] = {{"body", "stage"}, {"at", {0.06, 0.06, 0}}};
  leaf["base"]["at"] = {0, 0.06, 0};
  leaf["thickness"] = 4e-4;
  const Mechanism m = made(document);
  CHECK(names_of_bodies(m)[1] == "end_effector.more/upper.tip");
  CHECK(m.elastic_bodies[0].interfaces.size() == 4);
}

TEST_CASE("a body with a mass or a shape of its own is not joined to another one") {
  json part = elastic_guide();
  part.erase("drive");
  part["bodies"][0].update({{"mass", 0.1}, {"inertia", {1e-6, 1e-6, 1e-6}}});
  json whole{
      {"flexopt_design", 1},
      {"bodies", {{{"name", "end_effector"}, {"at", {0.067, 0.04, 0}}}}},
      {"parts", {{{"name", "p"}, {"design", part}, {"join", {{"end_effector", "end_effector"}}}}}},
      {"drive", {{"direction", "uy"}}}};
  const auto keys = [&] {
    std::string found;
    try {
      made(whole);
    } catch (const SpecError& error) {
      for (const Fault& fault : error.faults()) {
        CHECK_THAT(fault.rule, Catch::Contains("joined to"));
        found += fault.pointer.substr(fault.pointer.rfind('/'));
      }
    }
    return found;
  };
  CHECK(keys() == "/elastic/mass/inertia");
  json& joined = whole["parts"][0]["design"]["bodies"][0];
  for (const char* key : {"elastic", "inertia"}) joined.erase(key);
  CHECK(keys() == "/mass");
  joined["mass"] = 0;
  CHECK(keys().empty());
  joined = {{"name", "end_effector"}, {"on", {{"leaf", "upper"}, {"at", {0.03, 0.08, 0}}}}};
  CHECK(keys() == "/on");
}

TEST_CASE("faults of elastic bodies are told at their places") {
  struct Wrong {
    const char* pointer;
    json value;
    const char *at, *rule;
  };
  const std::string elastic = "/bodies/0/elastic";
  const Wrong of_guide[] = {
      {"/plates", 1, "/bodies/0/elastic/plates", "unknown key"},
      {"/box", {1, 1, 1}, "/bodies/0/elastic/plate", "give one of the keys"},
      {"/from", "box", "/bodies/0/elastic/plate", "give one of the keys"},
      {"/center", {0, 0, 0}, "/bodies/0/elastic/center", "of a box"},
      {"/between", {"ground", "ground"}, "/bodies/0/elastic/between", "of a notch alone"},
      {"/material", "cheese", "/bodies/0/elastic/material", ""},
      {"/material",
       {{"youngs_modulus", 1e6}, {"poissons_ratio", 0.5}, {"density", 1000}},
       "/bodies/0",
       "0.5; a solid's is 0.4999 at most"},
      {"/degree", 3, "/bodies/0/elastic/degree", "no least energy"},
      {"/degree", 5, "/bodies/0/elastic/degree", "<= 4"},
      {"/payload", "P", "/bodies/0/elastic/payload", "no such interface"},
      {"/elements/size", "-1 mm", "/bodies/0/elastic/elements/size", "not negative"},
      {"/elements/size", "1 m", "/bodies/0/elastic/elements/size", "no larger than the faces"},
      {"/elements/growth", 1, "/bodies/0/elastic/elements/growth", "< value"},
      {"/plate/outline", json::array({{0, 0}}), "/bodies/0/elastic/plate/outline", "2 to 500"},
      {"/plate/outline/0/0", "1 kg", "/bodies/0/elastic/plate/outline/0/0", "expected a length"},
      {"/plate/outline",
       {{0, -0.01}, {0.007, -0.01}, {0, 0.09}, {0.007, 0.09}},
       "/bodies/0/elastic/plate",
       "cross or touch: the line from (7, -10) to (0, 90) mm and the line from (7, 90) to (0, "
       "-10)"},
      {"/plate/thickness", 0, "/bodies/0/elastic/plate/thickness", "must be positive"},
      {"/plate/normal", {0, 0, 0}, "/bodies/0/elastic/plate/normal", "direction"},
      {"/plate/along", {0, 0, 2}, "/bodies/0/elastic/plate/along", "lies in the plane"},
      {"/plate/holes",
       {{{"at", {0.001, 0}}, {"radius", 0}}},
       "/bodies/0/elastic/plate/holes/0/radius",
       "must be positive"},
      {"/interfaces/0/face", "w+", "/bodies/0/elastic/interfaces/0/face", ""},
      {"/interfaces/0/normal",
       {1, 0, 0},
       "/bodies/0/elastic/interfaces/0/normal",
       "give one of the keys"},
      {"/interfaces/0/at/0", "length + h + 1 um", "/bodies/0/elastic/interfaces/0/at",
       "flat face of the body"},
      {"/interfaces/0/at/0", "length", "/bodies/0/elastic/interfaces/0/at", "flat face"},
      {"/interfaces/0/face", "z+", "/bodies/0/elastic/interfaces/0/at", "flat face"},
      {"/interfaces/0/size/1", 0, "/bodies/0/elastic/interfaces/0/size/1", "must be positive"},
      {"/interfaces/0/along",
       {3, 0, 0},
       "/bodies/0/elastic/interfaces/0/along",
       "lies in the face"},
      {"/interfaces/0/body", "nobody", "/bodies/0/elastic", ""},
      {"/interfaces/0/name", "lower.tip", "/leaves/0/tip", "another"},
      {"/interfaces", json::array(), "/bodies/0/elastic/payload", "carries O"},
  };
  for (const Wrong& wrong : of_guide) {
    json document = elastic_guide();
    document[json::json_pointer(elastic + wrong.pointer)] = wrong.value;
    INFO(wrong.pointer << " = " << wrong.value.dump());
    const std::string complaint = test::complaint_of([&] { made(document); });
    CHECK_THAT(complaint, Contains("/design/mechanism" + std::string(wrong.at)));
    CHECK_THAT(complaint, Contains(wrong.rule));
  }
}

TEST_CASE("faults of what holds an elastic body are told at their places") {
  const auto told = [](json document, const char* pointer, const json& value) {
    document[json::json_pointer(pointer)] = value;
    return test::complaint_of([&] { made(document); });
  };
  const json guide = elastic_guide(), lever = notched_lever();
  CHECK_THAT(told(guide, "/leaves/0/tip/at/0", "length - 0.1 mm"),
             Contains("/leaves/0/tip/at = 0.0001 m from the nearest face"));
  CHECK_THAT(told(guide, "/leaves/0/tip/at/1", "-12 mm"), Contains("/leaves/0/tip/at"));
  CHECK_THAT(told(guide, "/leaves/0/across", {0, 1, 1}), Contains("end_effector.lower.tip"));
  json through = guide;  // it ends behind the stage
  through["bodies"].push_back({{"name", "behind"}, {"at", {"length + 20 mm", "20 mm", 0}}});
  json strip = guide["leaves"][0];
  strip["name"] = "strip";
  strip["base"]["at"][1] = "20 mm";
  strip["tip"] = {{"body", "behind"}, {"at", {"length + 20 mm", "20 mm", 0}}};
  through["leaves"].push_back(strip);
  CHECK_THAT(told(through, "/name", "through"), Contains("strip runs through end_effector"));
  CHECK(told(through, "/leaves/2/may_cross", true) == "accepted");
  CHECK_THAT(told(guide, "/leaves/0/width", "21 mm"), Contains("/leaves/0/tip"));
  CHECK_THAT(told(guide, "/leaves/1/tip/at/1", "0.2 mm"), Contains("overlap"));
  CHECK_THAT(told(guide, "/leaves/0/base/clamp", {{"length", 0.01}, {"side", "y+"}}),
             Contains("/leaves/0/base/clamp") && Contains("elastic body alone"));
  CHECK_THAT(told(guide, "/leaves/0/tip/clamp", {{"length", 0.01}, {"side", "y+"}}),
             Contains("/leaves/0/tip/clamp/side"));
  CHECK_THAT(told(guide, "/leaves/0/tip/clamp", {{"length", 0.01}}),
             Contains("/leaves/0/tip/clamp/side = nothing"));
  json two = guide;
  two["bodies"][0]["elastic"]["interfaces"].push_back({{"name", "P"}, {"face", "y+"}});
  CHECK_THAT(told(two, "/name", "two"), Contains("/bodies/0/elastic/payload = nothing"));
  CHECK(told(two, "/bodies/0/elastic/payload", "P") == "accepted");
  json lone = guide;
  lone["leaves"][0]["tip"]["body"] = lone["leaves"][1]["tip"]["body"] = "end_effector.O";
  CHECK_THAT(told(lone, "/name", "lone"), Contains("/bodies/0/elastic/interfaces = 1 interface;"));
  CHECK_THAT(told(lever, "/bodies/1/mass", 1), Contains("/bodies/1/mass"));
  CHECK_THAT(told(lever, "/bodies/1/box", {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}),
             Contains("/bodies/1/box"));
  CHECK_THAT(told(lever, "/bodies/0/mass", 1),
             Contains("/bodies/0/mass") && Contains("parts of other bodies"));
  CHECK_THAT(told(lever, "/bodies/0/elastic/rigid", true), Contains("/bodies/0/elastic/rigid"));
  CHECK_THAT(told(lever, "/bodies/0/elastic/between/1", "hinge"), Contains("another body"));
  CHECK_THAT(told(lever, "/bodies/0/elastic/between/1", "levr"),
             Contains("/bodies/0/elastic/between/1") && Contains("did you mean 'lever'"));
  CHECK_THAT(told(lever, "/bodies/1/at/0", "41 mm"),
             Contains("/bodies/0/elastic/between/1") && Contains("face to face"));
  CHECK_THAT(told(lever, "/bodies/0/elastic/notch/depth", 0.001),
             Contains("/bodies/0/elastic/notch/depth") && Contains("a radius alone"));
  CHECK_THAT(told(lever, "/bodies/0/elastic/notch/contour", "v"),
             Contains("/bodies/0/elastic/notch/") && Contains("half_length, depth and fillet"));
  CHECK_THAT(told(lever, "/springs/0/body", "hinge"),
             Contains("/springs/0/body") && Contains("parts of other bodies"));
}

TEST_CASE("estimated errors of elastic bodies bound the true ones", "[slow]") {
  const json stage = elastic_guide()["bodies"][0]["elastic"]["plate"];
  const auto outlined = [&](const json& outline, const json& windows) {
    json plate = stage;
    plate["outline"] = outline;
    plate["windows"] = windows;
    return plate;
  };
  const json shapes[] = {stage, outlined({{0, -0.01}, {0.06, 0.09}}, {{{0.01, 0}, {0.05, 0.08}}}),
                         outlined({{0, -0.01},
                                   {"h", -0.01},
                                   {"h", 0.09},
                                   {0, 0.09},
                                   {0, 0.064},
                                   {0.004, 0.064},
                                   {0.004, 0.06},
                                   {0, 0.06}},
                                  json::array())};
  for (const json& plate : shapes) {
    json document = elastic_guide();
    json& elastic = document["bodies"][0]["elastic"];
    elastic["plate"] = plate;
    elastic.erase("elements");
    if (plate.contains("windows") && !plate["windows"].empty())
      elastic["interfaces"][0]["at"][0] = document["bodies"][0]["at"][0] = "length + 60 mm";
    const Mechanism own = made(document);
    elastic["elements"] = {{"size", "5 mm"}, {"root", "0.1 mm"}};
    const ModelOptions beams{.flexure = Flexure::beam};
    const StrokeRequest request{.points = {0}};
    const StrokeResponse r = evaluate_stroke(own, beams, request),
                         fine = evaluate_stroke(made(document), beams, request);
    REQUIRE(r.path[0].status == PointStatus::converged);
    const StrokeErrors errors = estimate_errors(own, beams, request, r);
    for (std::size_t d = 0; d < 6; ++d) {
      if (!r.path[0].support_stiffness[d]) continue;
      const std::string name = "support_stiffness." + std::string(direction_names[d]);
      CAPTURE(plate.dump(), name);
      const double k = *r.path[0].support_stiffness[d],
                   off = std::abs(k - *fine.path[0].support_stiffness[d]),
                   told = errors.find(0, name)->solids;
      CHECK(told > off);
      if (off > 1e-3 * k) CHECK(told < 7.2 * off);
    }
  }
}

TEST_CASE("estimated errors of a thin frame, clamped at one side, bound the true ones") {
  const json frame = json::parse(R"({
    "flexopt_design": 1,
    "bodies": [{"name": "end_effector", "at": [0.06, 0.02, 0], "elastic": {
      "material": {"youngs_modulus": "210 GPa", "poissons_ratio": 0.3, "density": "7800 kg/m^3"},
      "plate": {"outline": [[0, 0], [0.06, 0.04]], "windows": [[[0.01, 0.01], [0.05, 0.03]]],
                "thickness": 0.0015},
      "interfaces": [
        {"name": "O", "face": "x+", "at": [0.06, 0.02, 0], "size": [0.01, 0.0015]},
        {"name": "g", "face": "x-", "at": [0, 0.02, 0], "size": [0.04, 0.0015],
         "body": "ground"}]}}],
    "drive": {"direction": "uz"}})");
  const Mechanism m = made(frame);
  const ModelOptions beams{.flexure = Flexure::beam};
  const StrokeRequest request{.points = {0}};
  const StrokeResponse r = evaluate_stroke(m, beams, request);
  REQUIRE(r.path[0].status == PointStatus::converged);
  const StrokeErrors errors = estimate_errors(m, beams, request, r);
  // "elements": {"size": "0.7 mm", "through": 6, "root": "0.15 mm"}
  const double fine[] = {51.707e6, 3.5912e6, 0, 34.171, 67.636, 4705.9};
  for (const std::size_t d : {0, 1, 3, 4, 5}) {
    const std::string name = "support_stiffness." + std::string(direction_names[d]);
    CAPTURE(name);
    CHECK(errors.find(0, name)->solids > std::abs(*r.path[0].support_stiffness[d] - fine[d]));
  }
}
