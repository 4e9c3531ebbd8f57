// Design files: what they may hold, and that frames, repeats and parts are only other ways to write
// the same mechanism.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "designs/describe.hpp"
#include "support/families.hpp"
#include "support/refusals.hpp"
#include "support/temporary_folder.hpp"
#include "support/wrong_designs.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using nlohmann::json;
using test::cantilever, test::changed, test::wrong_designs, test::WrongDesign;

namespace {

const Material& steel() { return materials().front().material; }

std::shared_ptr<const Family> read(const json& document) {
  FaultList faults;
  auto family = read_family(document, "/design/mechanism", "", faults);
  faults.raise();
  return family;
}

Mechanism make(const json& document, const ParameterValues& values = {}) {
  const auto family = read(document);
  ParameterValues all = values;
  for (const Parameter& p : family->parameters)
    if (p.default_value) all.try_emplace(p.name, *p.default_value);
  return family->make(all, default_choices(*family), steel(), {});
}

std::string complaint(const json& document, const ParameterValues& values = {}) {
  return test::complaint_of([&] { make(document, values); });
}

void check_same(const Mechanism& a, const Mechanism& b) {
  REQUIRE(a.bodies.size() == b.bodies.size());
  REQUIRE(a.leaves.size() == b.leaves.size());
  CHECK(numbers_of(a) == numbers_of(b));
  for (std::size_t i = 0; i < a.leaves.size(); ++i) {
    CHECK(a.leaves[i].name == b.leaves[i].name);
    CHECK(a.leaves[i].base == b.leaves[i].base);
    CHECK(a.leaves[i].tip == b.leaves[i].tip);
    CHECK(a.leaves[i].may_cross == b.leaves[i].may_cross);
  }
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    CHECK(a.bodies[i].name == b.bodies[i].name);
    CHECK(a.bodies[i].held == b.bodies[i].held);
  }
}

}  // namespace

TEST_CASE("an expanded family is the same mechanism, and expanding it again changes nothing") {
  for (const Family& family : families())
    for (const FamilyChoices& choices : all_choices(family)) {
      INFO(family.name);
      const ParameterValues values = sample_values(family);
      const auto flat = expanded(family, values, choices, steel());
      const auto again = read(json::parse(flat.dump()));
      check_same(family.make(values, choices, steel(), {}), again->make({}, {}, steel(), {}));
      CHECK(expanded(*again, {}, {}, steel()).dump() == flat.dump());
    }
}

TEST_CASE("numbers of a design are SI, quantities or formulas in units") {
  json document = cantilever();
  document["let"] = {{"half", "length/2"}, {"twice", "2*half + 5 mm"}};
  document["leaves"][0]["tip"]["at"] = {"twice - 5 mm", 0, 0};
  document["leaves"][0]["width"] = "min(length, 2*10 mm)";
  const Mechanism m = make(document);
  CHECK(m.leaves[0].length == Approx(0.08).epsilon(1e-15));
  CHECK(m.leaves[0].width == 0.02);
}

TEST_CASE("usual values are defaults, and examples where there is none") {
  json document = cantilever();
  document["parameters"]["length"].erase("default");
  CHECK_THROWS_WITH(usual_values(*read(document)), Contains("length") && Contains("nor example"));
  document["parameters"]["length"]["example"] = "70 mm";
  const auto design = read(document);
  CHECK(usual_values(*design) == ParameterValues{{"length", 0.07}, {"count", 3}});
  CHECK_FALSE(design->parameters.back().default_value);  // the user still has to give it
  CHECK_THAT(describe_family(*design), Contains("required, for example 0.07 m"));
  for (const Family& family : families()) CHECK_NOTHROW(usual_values(family));
}

TEST_CASE("a design file in words has the bounds that it gives, and no others") {
  json document = cantilever();
  document["name"] = "own";
  document["parameters"]["count"]["max"] = 9;
  const std::string text = describe_family(*read(document));
  CHECK_THAT(text, Catch::StartsWith("own\n") && Contains("0 m < value; default 0.08 m") &&
                       Contains("value <= 9; default 3") && !Contains("inf"));
}

TEST_CASE("a fault of a parameter is told once, not at each formula that uses it") {
  for (const auto& [key, value] : {std::pair{"min", json(0)}, {"default", json("4 kg")}}) {
    CAPTURE(key);
    json document = cantilever();
    document["parameters"]["length"][key] = value;
    document["let"] = {{"half", "length/2"}, {"other", "lenght"}};
    document["rules"] = {{{"that", "length > 2*half"}, {"else", "no"}}};
    document["leaves"][0]["width"] = {{"profile", "length*s"}};
    FaultList faults;
    (void)read_family(document, "/design/mechanism", "", faults);
    std::vector<std::string> at;
    for (const Fault& fault : faults.faults()) at.push_back(fault.pointer);
    const std::string own = "/design/mechanism/parameters/length/";
    CHECK_THAT(
        at, Catch::Matchers::UnorderedEquals(std::vector<std::string>{
                own + (std::string(key) == "min" ? "above" : key), "/design/mechanism/let/other"}));
  }
}

TEST_CASE("the box of a body turns with its frame and keeps its edges when written flat") {
  json document = cantilever();
  document["frames"] =
      json::parse(R"([{"name": "arm", "turn": [["z", "30 deg"]], "at": [0, 0, 0]}])");
  document["bodies"].push_back(json::parse(
      R"({"name": "stage", "at": [0.02, 0.05, 0], "box": ["20 mm", "length/8", "4 mm"],
          "center_of_mass": ["1 mm", 0, 0], "density": "2700 kg/m^3", "frame": "arm"})"));
  document["springs"] = json::parse(
      R"([{"name": "bushing", "body": "stage", "at": [0, 0, 0], "matrix": [[1e3, 0, 0, 0, 0, 0],
          [0, "1 N/mm", 0, 0, 0, 0], [0, 0, 1e3, 0, "0 N", "0 N/rad"], [0, 0, 0, 1, 0, 0],
          [0, 0, 0, 0, "1 N m", 0], [0, 0, 0, 0, 0, "1 N m/rad"]]}])");
  const Mechanism m = make(document);
  const Eigen::Vector<double, 6> diagonal(1e3, 1e3, 1e3, 1, 1, 1);
  CHECK(*m.springs[0].matrix == Eigen::Matrix<double, 6, 6>(diagonal.asDiagonal()));
  REQUIRE(m.bodies[1].box);
  CHECK_FALSE(m.bodies[0].box);
  const BodyBoxT<double>& box = *m.bodies[1].box;
  CHECK(box.center == m.bodies[1].center_of_mass);
  const double c = std::cos(std::numbers::pi / 6), s = 0.5;
  CHECK((box.half_edges.col(0) - 0.01 * Vector3d(c, s, 0)).norm() < 1e-17);
  CHECK((box.half_edges.col(1) - 0.005 * Vector3d(-s, c, 0)).norm() < 1e-17);
  CHECK((box.half_edges.col(2) - Vector3d(0, 0, 0.002)).norm() < 1e-18);
  const auto flat = expanded(*read(document), {{"length", 0.08}, {"count", 3}}, {}, steel());
  const auto again = read(json::parse(flat.dump()));
  check_same(m, again->make({}, {}, steel(), {}));
  CHECK(expanded(*again, {}, {}, steel()).dump() == flat.dump());
  // without density too, and edges given one by one
  document["bodies"][1]["mass"] = 0.1;
  document["bodies"][1].erase("density");
  document["bodies"][1]["box"] = {{"20 mm", 0, 0}, {0, "length/8", 0}, {0, 0, "4 mm"}};
  CHECK(make(document).bodies[1].box->half_edges == box.half_edges);
  document["bodies"][1]["density"] = 2700;
  CHECK(complaint(document) != "accepted");
}

TEST_CASE("frames turn in order, each about axes as turned so far") {
  json document = cantilever();
  document["frames"] = json::parse(
      R"([{"name": "arm", "at": [0.1, 0, 0], "turn": [["z", "90 deg"], ["y", "90 deg"]]},
          {"name": "hand", "at": [0, 0, 0.2], "in": "arm"}])");
  document["leaves"][0]["frame"] = document["bodies"][0]["frame"] = "hand";
  const Mechanism m = make(document);
  // the arm's x is −z of the world, its y is −x, its z is y
  CHECK((m.leaves[0].origin - Vector3d(0.1, 0.2, 0)).norm() < 1e-15);
  CHECK((m.leaves[0].axes.col(0) - Vector3d(0, 0, -1)).norm() < 1e-15);
  CHECK((m.leaves[0].axes.col(1) - Vector3d(0, 1, 0)).norm() < 1e-15);
}

TEST_CASE("a repeated item is each of its copies") {
  json repeated = cantilever(), written = cantilever();
  repeated["leaves"][0].update(json::parse(
      R"({"name": "leaf {i}", "repeat": {"i": [1, "count"]},
          "base": {"body": "ground", "at": [0, "10 mm*i", 0]},
          "tip": {"body": "end_effector", "at": ["length", "10 mm*i", 0]}})"));
  const json one = written["leaves"][0];
  written["leaves"] = json::array();
  for (int i = 1; i <= 3; ++i) {
    json copy = one;
    copy["name"] = "leaf " + std::to_string(i);
    copy["base"]["at"] = {0, 0.01 * i, 0};
    copy["tip"]["at"] = {"length", 0.01 * i, 0};
    written["leaves"].push_back(copy);
  }
  check_same(make(repeated), make(written));
  CHECK_THAT(complaint(repeated, {{"count", 2.5}}), Contains("count") && Contains("whole number"));
  CHECK_THAT(complaint(repeated, {{"count", 2000}}), Contains("at most 1000 copies"));
}

TEST_CASE("names take formulas of indices and counts") {
  json chain = json::parse(R"({
    "flexopt_design": 1,
    "parameters": {"count": {"unit": "1", "default": 3}, "sprung": {"unit": "1", "default": 1}},
    "let": {"last": "count - 1"},
    "frames": [{"name": "f0"}, {"name": "away", "at": [0, "1 m", 0]},
               {"name": "f{i}", "in": "f{i - 1}", "at": ["20 mm", 0, 0], "repeat": {"i": [1, "count"]}}],
    "bodies": [{"name": "p{i}", "frame": "f{i}", "at": [0, 0, 0], "repeat": {"i": [1, "last"]}},
               {"name": "end_effector", "frame": "f{count}", "at": [0, 0, 0]}],
    "leaves": [
      {"name": "s1", "base": {"body": "ground", "at": [0, 0, 0]}, "tip": {"body": "p1", "at": ["20 mm", 0, 0]},
       "across": [0, 0, 1], "width": "5 mm", "thickness": "0.3 mm"},
      {"name": "s{i}", "frame": "f{i-1}", "repeat": {"i": [2, "last"]}, "base": {"body": "p{i-1}", "at": [0, 0, 0]},
       "tip": {"body": "p{i}", "at": ["20 mm", 0, 0]}, "across": [0, 0, 1], "width": "5 mm", "thickness": "0.3 mm"},
      {"name": "s{count}", "frame": "f{last}", "base": {"body": "p{count-1}", "at": [0, 0, 0]},
       "tip": {"body": "end_effector", "at": ["20 mm", 0, 0]},
       "across": [0, 0, 1], "width": "5 mm", "thickness": "0.3 mm"}],
    "springs": [{"name": "spring", "body": "p{sprung}", "at": [0, 0, 0], "other_at": [0, 0.1, 0], "stiffness": 1}],
    "parts": [{"name": "arm {2*i}", "repeat": {"i": [2, 2]}, "frame": "away", "design": "leaf_spring",
               "join": {"end_effector": "p{i-1}"},
               "parameters": {"length": "50 mm", "width": "5 mm", "thickness": "0.3 mm"}}],
    "drive": {"direction": "uy"}})");
  for (const std::size_t count : {2, 3, 6}) {
    const Mechanism m = make(chain, {{"count", double(count)}});
    REQUIRE(m.leaves.size() == count + 1);
    CHECK_THAT(m.leaves.front().name, Catch::StartsWith("arm 4/"));
    CHECK(m.leaves.front().tip == m.leaves[1].tip);
    for (std::size_t i = 1; i <= count; ++i) {
      const LeafSpring& leaf = m.leaves[i];
      CHECK(leaf.name == "s" + std::to_string(i));
      CHECK(leaf.base == (i == 1 ? ground : m.leaves[i - 1].tip));
      CHECK((leaf.origin - Vector3d(0.02 * double(i - 1), 0, 0)).norm() < 1e-15);
    }
    CHECK(m.leaves.back().tip == m.end_effector);
    CHECK(m.springs[0].body == m.leaves[1].tip);
  }
  CHECK(read(chain)->counts == std::vector<std::string>{"count", "sprung"});
  CHECK_THAT(complaint(chain, {{"sprung", 1.5}}), Contains("sprung") && Contains("whole number"));
  chain["leaves"][1]["tip"]["body"] = "p{i/4}";
  CHECK_THAT(complaint(chain), Contains("/leaves/1/tip/body = 0.5") && Contains("copy i = 2"));
}

TEST_CASE("a leaf that may cross others does so repeated, mirrored, reinforced and written flat") {
  json inner = cantilever();
  inner["leaves"][0].update(json::parse(
      R"({"name": "leaf {i}", "repeat": {"i": [0, 1]}, "may_cross": true,
          "reinforcement": {"fraction": 0.4, "thickness": "1 mm"}})"));
  inner.erase("drive");
  json outer = cantilever();
  outer["leaves"][0]["width"] = "10 mm";
  outer["parts"] = {{{"name", "x"},
                     {"design", inner},
                     {"mirror", "y"},
                     {"join", {{"end_effector", "end_effector"}}}}};
  const Mechanism m = make(outer);
  REQUIRE(m.leaves.size() == 5);
  for (const LeafSpring& leaf : m.leaves) CHECK(leaf.may_cross == (leaf.name != "leaf"));
  const auto flat = expanded(*read(outer), {{"length", 0.08}, {"count", 3}}, {}, steel());
  check_same(m, make(json::parse(flat.dump())));
  outer["parts"][0]["design"]["leaves"][0].erase("may_cross");
  CHECK_THAT(complaint(outer), Contains("leaves with \"may_cross\" may"));
}

TEST_CASE("a part is its items in its frame, with the bodies that it shares") {
  json document = json::parse(R"({
    "flexopt_design": 1,
    "bodies": [{"name": "end_effector", "at": [0, 0, 0]}, {"name": "stage", "at": [0.1, 0, 0]}],
    "parts": [
      {"name": "outer", "design": "parallel_guide", "join": {"end_effector": "stage"},
       "parameters": {"length": "100 mm", "width": "30 mm", "thickness": "0.4 mm", "spacing": 0.08}},
      {"name": "inner", "design": "parallel_guide", "mirror": "y", "frame": "back",
       "join": {"ground": "stage", "end_effector": "end_effector"},
       "parameters": {"length": "100 mm", "width": "30 mm", "thickness": "0.4 mm", "spacing": 0.06}}],
    "frames": [{"name": "back", "at": [0.1, 0, 0], "turn": [["y", "180 deg"]]}],
    "drive": {"direction": "uy"}})");
  const Mechanism m = make(document);
  REQUIRE(m.bodies.size() == 2);
  REQUIRE(m.leaves.size() == 4);
  CHECK(m.leaves[0].name == "outer/leaf +y");
  CHECK(m.leaves[2].name == "inner/leaf +y");
  CHECK(m.leaves[0].tip == 1);
  CHECK(m.leaves[2].base == 1);
  CHECK(m.leaves[2].tip == 0);
  CHECK((m.leaves[2].origin - Vector3d(0.1, -0.03, 0)).norm() < 1e-15);  // mirrored in y
  CHECK((m.leaves[2].tip_middle() - Vector3d(0, -0.03, 0)).norm() < 1e-15);
  CHECK((m.leaves[2].axes.transpose() * m.leaves[2].axes - Matrix3d::Identity()).norm() < 1e-14);
  CHECK(m.leaves[2].axes.determinant() == Approx(1));
}

TEST_CASE("a reinforced leaf is two leaves and a box of their material") {
  json document = cantilever();
  document["leaves"][0]["reinforcement"] = {{"fraction", 0.5}, {"thickness", "2 mm"}};
  const Mechanism m = make(document);
  REQUIRE(m.leaves.size() == 2);
  REQUIRE(m.bodies.size() == 2);
  CHECK(m.leaves[0].length == Approx(0.02));
  CHECK(m.leaves[1].length == Approx(0.02));
  const double mass = steel().density * 0.04 * 0.02 * 0.002;
  CHECK(m.bodies[1].mass == Approx(mass));
  CHECK(m.bodies[1].inertia(1, 1) == Approx(mass * (0.04 * 0.04 + 0.02 * 0.02) / 12));
  CHECK(m.bodies[1].inertia(2, 2) == Approx(mass * (0.04 * 0.04 + 0.002 * 0.002) / 12));
}

TEST_CASE("an elastic reinforcement is a thicker leaf between lines without mass") {
  json document = cantilever();
  document["leaves"][0]["reinforcement"] = {
      {"fraction", 0.5}, {"thickness", "2 mm"}, {"rigid", false}};
  const Mechanism m = make(document);
  REQUIRE(m.leaves.size() == 3);
  REQUIRE(m.bodies.size() == 3);
  double length = 0, mass = 0;
  for (const LeafSpring& leaf : m.leaves) length += leaf.length;
  for (const RigidBody& body : m.bodies) mass += body.mass;
  CHECK(length == Approx(0.08));
  CHECK(mass == 0);
  CHECK(m.leaves[1].length == Approx(0.04));
  CHECK(m.leaves[1].thickness == 0.002);
  CHECK(m.leaves[0].thickness == m.leaves[2].thickness);
  CHECK(m.leaves[1].base == m.leaves[0].tip);
  CHECK(m.leaves[1].tip == m.leaves[2].base);
}

TEST_CASE("a curved leaf bulges to its normal, a mirrored one to the reflected side") {
  json document = cantilever();
  document["leaves"][0]["curve"] = {{"angle", "60 deg"}};
  const auto top_of = [](const LeafSpring& leaf) {
    const ArcPoint<double> at = leaf.middle(0.5);
    return Vector3d(leaf.origin + leaf.axes * Vector3d(at.x, 0, at.z) * leaf.length);
  };
  const double radius = 0.08, rise = radius * (1 - std::sqrt(0.75));  // of 60 deg
  const LeafSpring leaf = make(document).leaves[0];
  CHECK(leaf.length == Approx(radius * M_PI / 3));
  CHECK(leaf.chord() == Approx(0.08));
  CHECK((leaf.tip_middle() - Vector3d(0.08, 0, 0)).norm() < 1e-15);
  // z × x
  CHECK((top_of(leaf) - Vector3d(0.04, rise, 0)).norm() < 1e-12);
  document["leaves"][0]["curve"]["angle"] = "-60 deg";
  CHECK((top_of(make(document).leaves[0]) - Vector3d(0.04, -rise, 0)).norm() < 1e-12);
  document["leaves"][0]["across"] = {0, 0, -1};
  CHECK((top_of(make(document).leaves[0]) - Vector3d(0.04, rise, 0)).norm() < 1e-12);

  const auto part = [&](const char* mirror) {
    json whole = json::parse(R"({
      "flexopt_design": 1, "bodies": [{"name": "end_effector", "at": [0.06, 0, 0]}],
      "parts": [{"name": "p", "design": "curved_leaf", "mirror": "y",
                 "join": {"end_effector": "end_effector"},
                 "parameters": {"chord": "60 mm", "angle": "60 deg"}}],
      "drive": {"direction": "rz"}})");
    if (mirror)
      whole["parts"][0]["mirror"] = mirror;
    else
      whole["parts"][0].erase("mirror");
    return top_of(make(whole).leaves[0]);
  };
  const double sag = 0.75 * rise;
  CHECK((part(nullptr) - Vector3d(0.03, sag, 0)).norm() < 1e-12);
  CHECK((part("y") - Vector3d(0.03, -sag, 0)).norm() < 1e-12);
  CHECK((part("z") - Vector3d(0.03, sag, 0)).norm() < 1e-12);
}

TEST_CASE("a material point of a curved leaf lies on its arc") {
  json document = cantilever();
  document["leaves"][0]["curve"] = {{"angle", "60 deg"}};
  document["leaves"][0]["tip"]["body"] = "ground";
  document["let"] = {{"top", "length*(1 - sqrt(0.75))"}};
  document["bodies"][0] = {{"name", "end_effector"},
                           {"on", {{"leaf", "leaf"}, {"at", {"length/2", "top", "5 mm"}}}}};
  const LeafSpring leaf = make(document).leaves[0];
  REQUIRE(leaf.point);
  CHECK(leaf.point->along == Approx(0.5));
  CHECK(leaf.point->across == Approx(0.75));
  document["bodies"][0]["on"]["at"] = {"length/2", 0, 0};
  CHECK_THAT(complaint(document), Contains("/bodies/0/on/at") && Contains("middle surface"));
}

TEST_CASE("arcs that meet intersect, their chords need not") {
  json document = cantilever();
  document["leaves"].push_back(document["leaves"][0]);
  json& second = document["leaves"][1];
  second["name"] = "second";
  second["base"]["at"] = {0, "3 mm", 0};
  second["tip"]["at"] = {"length", "3 mm", 0};
  CHECK(complaint(document) == "accepted");
  document["leaves"][0]["curve"] = {{"angle", "40 deg"}};
  CHECK_THAT(complaint(document), Contains("intersect"));
  second["curve"] = {{"angle", "40 deg"}};  // one above the other
  CHECK(complaint(document) == "accepted");
}

TEST_CASE("the end-effector weighs what the file and the job say together") {
  json document = cantilever();
  document["bodies"][0].update({{"mass", 2}, {"center_of_mass", {0, 0.1, 0}}});
  EndEffector payload;
  payload.mass = 2;
  const auto family = read(document);
  const Mechanism m = family->make({{"length", 0.08}, {"count", 1}}, {}, steel(), payload);
  CHECK(m.bodies[0].mass == 4);
  CHECK((m.bodies[0].center_of_mass - Vector3d(0.08, 0.05, 0)).norm() < 1e-15);
  CHECK(m.bodies[0].inertia(0, 0) == Approx(4 * 0.05 * 0.05));
}

TEST_CASE("let takes quantities whose units have several symbols") {
  json document = changed("/let", {{"k", "50 N/mm"}, {"J", "1e-3 kg m^2"}, {"s", "2 m"}});
  CHECK(complaint(document) == "accepted");
  document["bodies"][0]["inertia"] = {"J", "J", "J"};
  document["springs"] = {{{"name", "k"},
                          {"body", "end_effector"},
                          {"at", {0, 0, 0}},
                          {"other_at", {0, 0.01, 0}},
                          {"stiffness", "k"}}};
  CHECK(complaint(document) == "accepted");
  document["let"]["t"] = "3 m/s";  // s is a name here: a number
  document["let"]["u"] = "t + 1";
  CHECK(complaint(document) == "accepted");
}

TEST_CASE("wrong design files are refused with the rule, at a place of the file that is read") {
  const test::TemporaryFolder folder;
  const std::string file = (folder / "own.json").string();
  for (const WrongDesign& c : wrong_designs()) {
    const json document = changed(c.pointer, c.value);
    INFO(c.pointer << " = " << c.value.dump());
    CHECK_THAT(complaint(document), Contains(c.at) && Contains(c.rule));
    const auto in_job = [](const Fault& f) { return f.pointer.starts_with("/design/parameters"); };
    try {
      make(document);
    } catch (const SpecError& error) {
      for (const Fault& f : error.faults()) {
        INFO(f.text());
        CHECK((f.pointer.starts_with("/design/mechanism/") || in_job(f)));
        CHECK_FALSE(f.pointer.starts_with("/design/mechanism/design"));
      }
    }
    try {
      test::put(file, document.dump(1));
      const auto family = read_family_file(file);
      (void)family->make(sample_values(*family), default_choices(*family), steel(), {});
    } catch (const SpecError& error) {
      for (const Fault& f : error.faults()) {
        INFO(f.text());
        CHECK((f.source == file || in_job(f)));
        CHECK((f.line > 0 || in_job(f)));
        CHECK((!f.pointer.starts_with("/design/") || in_job(f)));
      }
    }
  }
}

TEST_CASE("a leaf that crosses another is refused, one that begins at its edge is not") {
  json fold = cantilever();
  fold["bodies"].push_back({{"name", "fold"}, {"at", {"length", 0, 0}}});
  fold["leaves"][0]["tip"]["body"] = "fold";
  fold["leaves"].push_back(fold["leaves"][0]);
  fold["leaves"][1].update({{"name", "second"},
                            {"base", {{"body", "fold"}, {"at", {"length", 0, 0}}}},
                            {"tip", {{"body", "end_effector"}, {"at", {"length", "length", 0}}}}});
  CHECK(complaint(fold) == "accepted");
  fold["leaves"][1]["base"]["at"] = {"length/2", "-length/2", 0};
  fold["leaves"][1]["tip"]["at"] = {"length/2", "length", 0};
  CHECK_THAT(complaint(fold), Contains("intersect"));
  fold["leaves"][1]["base"]["at"] = {"length", 0, 0};
  fold["leaves"][1]["tip"]["at"] = {0, "length*0.001", 0};  // folded back onto itself
  CHECK_THAT(complaint(fold), Contains("intersect"));
}

TEST_CASE("a drive that options take away is refused") {
  json document = cantilever();
  document["options"] = {{"motor", {{"choices", {"none", "one"}}}}};
  document["drive"]["when"] = "motor == one";
  CHECK_THAT(complaint(document), Contains("drives do not depend on options"));
}

TEST_CASE("a family's text is the design file that --export prints") {
  for (const std::string& name : library_names()) {
    const auto again = read(json::parse(library_text(name)));
    CHECK(again->name == name);
  }
  CHECK(library_text("nothing").empty());
}
