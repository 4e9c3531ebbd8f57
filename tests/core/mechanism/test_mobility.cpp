// Degrees of freedom and overconstraints that are known on paper.
#include "core/mechanism/mobility.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <set>

#include "support/models.hpp"

using namespace flexopt;

namespace {

RigidBody named(std::string name, const Vector3d& at) {
  RigidBody b = models::body(at, 0.1, 1e-5);
  b.name = std::move(name);
  return b;
}

LeafSpring named(std::string name, LeafSpring leaf, int base, int tip) {
  leaf.name = std::move(name);
  return models::between(base, tip, std::move(leaf));
}

LeafSpring wire(std::string name, const Vector3d& from, const Vector3d& along, double length) {
  LeafSpring l = named(std::move(name), models::leaf(from, along, length, 1e-3, 1e-3), ground, 0);
  if (std::abs(along.normalized()[2]) > 0.99) {
    l.axes.col(0) = along.normalized();
    l.axes.col(1) = Vector3d::UnitX();
    l.axes.col(2) = l.axes.col(0).cross(l.axes.col(1));
  }
  l.section = Section::circular;
  return l;
}

/// Degrees of freedom and overconstraints.
std::vector<int> counts(const Mobility& m) { return {m.degrees_of_freedom, m.overconstraints}; }

Mechanism named_guide() {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies[0].name = "stage";
  m.leaves[0].name = "leaf +y";
  m.leaves[1].name = "leaf -y";
  return m;
}

// Two guides in series, there and back.
Mechanism double_parallelogram() {
  Mechanism m{.bodies = {named("end_effector", {0, 0, 0}), named("stage", {0.1, 0, 0})}};
  m.bodies[1].role = BodyRole::intermediate;
  for (const double y : {0.04, -0.04})
    m.leaves.push_back(named(y > 0 ? "outer +y" : "outer -y",
                             models::leaf({0, y, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4), ground, 1));
  for (const double y : {0.02, -0.02})
    m.leaves.push_back(named(y > 0 ? "inner +y" : "inner -y",
                             models::leaf({0.1, y, 0}, {-1, 0, 0}, 0.1, 0.03, 5e-4), 1, 0));
  return m;
}

}  // namespace

TEST_CASE("a leaf holds three motions of its body, a wire one") {
  const Mobility leaf = mobility(models::single_leaf(0.1, 0.03, 5e-4));
  CHECK(counts(leaf) == std::vector{3, 0});
  CHECK(leaf.redundant.empty());
  Mechanism m = models::single_leaf(0.1, 1e-3, 1e-3);
  m.leaves[0].section = Section::circular;
  CHECK(mobility(m).degrees_of_freedom == 5);
}

TEST_CASE("two parallel leaves hold the rotation across them twice") {
  const Mobility m = mobility(named_guide());
  CHECK(m.end_effector_degrees_of_freedom == 1);
  CHECK(counts(m) == std::vector{1, 1});
  REQUIRE(m.redundant.size() == 1);
  const Redundancy& r = m.redundant[0];
  CHECK(r.body == "stage");
  CHECK(r.direction == Direction::ry);
  CHECK((r.axis - Vector3d::UnitY()).norm() < 1e-9);
  CHECK(r.shared_by == std::vector<std::string>{"leaf +y", "leaf -y"});
  CHECK(r.text == "rotation of `stage` about y is held twice, by `leaf +y` and `leaf -y`");
}

TEST_CASE("a third parallel leaf holds nothing new") {
  Mechanism m = named_guide();
  m.leaves.push_back(
      named("middle", models::leaf({0, 0.01, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4), ground, 0));
  const Mobility found = mobility(m);
  CHECK(counts(found) == std::vector{1, 4});
  REQUIRE(found.redundant.size() == 4);
  int once_too_often = 0;
  for (const Redundancy& r : found.redundant) {
    CHECK(r.shared_by.size() >= 2);
    once_too_often += r.text.find(
                          "is held once too often, by `leaf +y`, `leaf -y` and "
                          "`middle`") != std::string::npos;
  }
  CHECK(once_too_often == 2);  // along x and along z
}

TEST_CASE("leaves that cross one above the other hold the motion along their hinge twice") {
  Mechanism m = models::hinge(0.08, 3.5e-4, {{1, 0.02, 0.03}, {-1, -0.02, 0.03}});
  m.leaves[0].name = "upper", m.leaves[1].name = "lower";
  const Mobility found = mobility(m);
  REQUIRE(counts(found) == std::vector{1, 1});
  CHECK(found.redundant[0].direction == Direction::uz);
  CHECK(found.redundant[0].text ==
        "displacement of `end-effector` along z is held twice, by `upper` and `lower`");
  // three leaves: three more conditions, and none of them new
  const Mobility three = mobility(models::three_leaf_hinge(0.06, 0.04, 4e-4));
  CHECK(counts(three) == std::vector{1, 4});
}

TEST_CASE("a folded leaf holds its body along the fold alone") {
  Mechanism m{
      .bodies = {named("end_effector", {0.1, 0.1, 0}), named("fold", {0.1, 0, 0})},
      .leaves = {named("first", models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4), ground, 1),
                 named("second", models::leaf({0.1, 0, 0}, {0, 1, 0}, 0.1, 0.03, 5e-4), 1, 0)}};
  const Mobility found = mobility(m);
  CHECK(found.end_effector_degrees_of_freedom == 5);
  CHECK(counts(found) == std::vector{6, 0});  // the fold turns about itself while the body stands
}

TEST_CASE("guides in series have one overconstraint each") {
  const Mobility m = mobility(double_parallelogram());
  CHECK(m.end_effector_degrees_of_freedom == 1);
  REQUIRE(counts(m) == std::vector{2, 2});
  CHECK(m.redundant[0].text ==
        "rotation of `stage` about y is held twice, by `outer +y` and `outer -y`");
  CHECK(m.redundant[1].text ==
        "rotation of `end_effector` about y is held twice, by `inner +y` and `inner -y`");
}

TEST_CASE("wires hold a body along themselves") {
  Mechanism m{.bodies = {named("stage", {0, 0, 0})}};
  const Vector3d x = Vector3d::UnitX();
  m.leaves = {wire("a", {-0.1, 0, 0}, x, 0.1), wire("b", {-0.1, 0.05, 0}, x, 0.1),
              wire("c", {-0.1, 0, 0.05}, x, 0.1)};
  CHECK(counts(mobility(m)) == std::vector{3, 0});
  // a fourth parallel one repeats them, whatever its place
  m.leaves.push_back(wire("d", {-0.1, 0.03, 0.04}, x, 0.1));
  Mobility found = mobility(m);
  REQUIRE(counts(found) == std::vector{3, 1});
  CHECK(found.redundant[0].direction == Direction::ux);
  CHECK(found.redundant[0].shared_by.size() == 4);
  // six that do not meet hold it
  m.leaves.pop_back();
  m.leaves.push_back(wire("e", {0.02, -0.1, 0}, Vector3d::UnitY(), 0.1));
  m.leaves.push_back(wire("f", {0.02, -0.1, 0.04}, Vector3d::UnitY(), 0.1));
  m.leaves.push_back(wire("g", {0.03, 0.02, -0.1}, Vector3d::UnitZ(), 0.1));
  found = mobility(m);
  CHECK(counts(found) == std::vector{0, 0});
}

TEST_CASE("joints and held directions are conditions, springs are none") {
  Mechanism m = named_guide();
  m.springs = {{.name = "spring",
                .place = {0.1, 0, 0},
                .other_place = {0.1, 0.1, 0},
                .stiffness = 1e9,
                .free_length = 0.1}};
  CHECK(mobility(m).degrees_of_freedom == 1);
  m.bodies[0].held[index(Direction::uz)] = true;
  Mobility found = mobility(m);
  CHECK(counts(found) == std::vector{1, 2});
  m.bodies[0].held[index(Direction::uz)] = false;
  // one leaf on a hinge about y: the other alone holds that rotation
  m.bodies.push_back(named("tip", m.leaves[1].tip_middle()));
  m.leaves[1].tip = 1;
  m.joints = {{"hinge", JointType::revolute, 0, 1, m.bodies[1].reference, Vector3d::UnitY()}};
  found = mobility(m);
  CHECK(counts(found) == std::vector{1, 0});
  m.joints[0].type = JointType::rigid;
  CHECK(mobility(m).overconstraints == 1);
}

TEST_CASE("a leaf between two grounds is held at both ends") {
  Mechanism m{.bodies = {named("O", {0.05, 0, 0})}};
  m.bodies[0].held = {false, false, false, true, true, true};
  m.leaves = {named("plate", models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4), ground, ground)};
  m.leaves[0].point = LeafPoint{.body = 0, .along = 0.5, .across = 0.5};
  const Mobility found = mobility(m);
  REQUIRE(counts(found) == std::vector{1, 3});  // out of its plane
  CHECK(found.redundant[0].text == "`plate` is held at both ends along x");
  CHECK(found.redundant[0].body == "ground");
  CHECK(found.redundant[2].text == "`plate` is held at both ends about y");
}

TEST_CASE("the whole turned, in other units or with other reference points counts the same") {
  Mechanism m = double_parallelogram();
  const Matrix3d R = Eigen::AngleAxisd(0.9, Vector3d(0.3, -0.5, 0.8).normalized()).matrix();
  const double scale = GENERATE(1.0, 1e-3, 1e3);
  for (RigidBody& b : m.bodies)
    b.reference = scale * (R * (b.reference + Vector3d(0.3, -0.2, 0.7)));
  for (LeafSpring& l : m.leaves) {
    l.origin = scale * (R * l.origin);
    l.axes = R * l.axes;
    l.length *= scale;
  }
  const Mobility found = mobility(m);
  CHECK(found.end_effector_degrees_of_freedom == 1);
  REQUIRE(counts(found) == std::vector{2, 2});
  CHECK(std::abs(found.redundant[0].axis.dot(R.col(1))) == Approx(1));
}

// Linear in their number: a cubic law would not come to an end.
TEST_CASE("a chain of 4000 guides has an overconstraint for each") {
  Mechanism m;
  const int n = 4000;
  for (int b = 0; b < n; ++b) {
    m.bodies.push_back(named("stage " + std::to_string(b), {0.1 * (b + 1), 0, 0}));
    for (const double y : {0.03, -0.03})
      m.leaves.push_back(named("leaf", models::leaf({0.1 * b, y, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4),
                               b == 0 ? ground : b - 1, b));
  }
  m.end_effector = n - 1;
  const Mobility found = mobility(m);
  CHECK(found.end_effector_degrees_of_freedom == 1);
  CHECK(counts(found) == std::vector{n, n});
}

TEST_CASE("guides of a millimetre to a metre in one chain count like equal ones") {
  Mechanism m;
  const int n = 256;
  const double spacing = GENERATE(1.0, 1e-2, 1e-4);  // over the length
  double x = 0;
  for (int b = 0; b < n; ++b) {
    const double length = std::pow(10, 1.5 * std::sin(1.0 + b * b) - 1.5);
    m.bodies.push_back(named("stage " + std::to_string(b),
                             {x + length, std::cos(b), std::sin(3.0 * b)}));  // far from its leaves
    for (const double y : {0.5, -0.5})
      m.leaves.push_back(
          named("leaf " + std::to_string(b) + (y > 0 ? "+" : "-"),
                models::leaf({x, y * spacing * length, 0}, {1, 0, 0}, length, 0.03, 5e-4),
                b == 0 ? ground : b - 1, b));
    x += length;
  }
  m.end_effector = n - 1;
  const Mobility found = mobility(m);
  CHECK(found.end_effector_degrees_of_freedom == 1);
  REQUIRE(counts(found) == std::vector{n, n});
  for (int b = 0; b < n; ++b) {
    const std::string name = "leaf " + std::to_string(b);
    CHECK(found.redundant[b].shared_by == std::vector<std::string>{name + "+", name + "-"});
    CHECK(found.redundant[b].direction == Direction::ry);
  }
}

TEST_CASE("folded legs hold a body in their plane, those beyond three once too often each") {
  Mechanism m;
  const int n = 200;
  m.bodies = {named("end_effector", {0, 0, 0})};
  for (int i = 0; i < n; ++i) {
    const std::string leg = std::to_string(i);
    const double angle = 2.4 * i;
    const Vector3d out(std::cos(angle), std::sin(angle), 0);
    const Vector3d along_fold = Vector3d::UnitZ().cross(out);
    m.bodies.push_back(named("fold " + leg, 0.2 * out));
    LeafSpring low = models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4), up = low;
    low.origin = 0.2 * out - 0.1 * Vector3d::UnitZ();
    low.axes << Vector3d::UnitZ(), along_fold, Vector3d::UnitZ().cross(along_fold);
    up.origin = 0.2 * out;
    up.axes << -out, along_fold, -out.cross(along_fold);
    m.leaves.push_back(named("low " + leg, low, ground, i + 1));
    m.leaves.push_back(named("up " + leg, up, i + 1, 0));
  }
  const Mobility found = mobility(m);
  CHECK(found.end_effector_degrees_of_freedom == 3);
  REQUIRE(counts(found) == std::vector{3 + n, n - 3});  // each fold turns about itself
  for (const Redundancy& r : found.redundant) {
    CHECK(r.shared_by.size() <= 8);  // four legs
    CHECK(std::abs(r.axis.z()) < 1e-6);
  }
}

TEST_CASE("a leaf in three parts with links between them counts as one") {
  const Mechanism whole = named_guide();
  Mechanism m = whole;
  for (const double cut : {0.7, 0.3}) {  // from the tip on
    LeafSpring &first = m.leaves[0], second = first;
    RigidBody link = named("link", first.origin + cut * 0.1 * first.axes.col(0));
    link.mass = 0;
    link.inertia.setZero();
    second.length = first.length - cut * 0.1;
    second.origin = link.reference;
    second.base = first.tip = static_cast<int>(m.bodies.size());
    second.tip = whole.leaves[0].tip;
    if (cut < 0.5) second.tip = second.base - 1;
    first.length = cut * 0.1;
    first.name = "leaf +y/base", second.name = "leaf +y/tip";
    link.role = BodyRole::intermediate;
    m.bodies.push_back(link);
    m.leaves.push_back(second);
  }
  CHECK(counts(mobility(m)) == counts(mobility(whole)));
  CHECK(mobility(m).end_effector_degrees_of_freedom ==
        mobility(whole).end_effector_degrees_of_freedom);
  REQUIRE(mobility(m).redundant.size() == mobility(whole).redundant.size());
  for (std::size_t k = 0; k < mobility(m).redundant.size(); ++k)
    CHECK(mobility(m).redundant[k].text == mobility(whole).redundant[k].text);
  m.bodies[1].mass = 0.01;  // a body of its own
  CHECK(mobility(m).degrees_of_freedom == mobility(whole).degrees_of_freedom + 3);
}

TEST_CASE("a drive is held where leaves would have to stretch, and free where they bend") {
  Mechanism m = named_guide();
  const auto held = [&](Direction direction) {
    m.drives = {{.name = "drive", .body = 0, .direction = direction}};
    return held_drives(m);
  };
  for (const Direction d :
       {Direction::ux, Direction::uz, Direction::rx, Direction::ry, Direction::rz}) {
    REQUIRE(held(d).size() == 1);
    CHECK(held(d)[0].drive == 0);
  }
  CHECK(held(Direction::uy).empty());
  const std::vector<std::string> by = held(Direction::rx)[0].held_by;
  CHECK(std::set(by.begin(), by.end()) == std::set<std::string>{"leaf +y", "leaf -y"});
  // axes of its own: oblique ones are free in part
  m.drives = {{.name = "drive", .body = 0, .direction = Direction::ux}};
  m.drives[0].axes = Eigen::AngleAxisd(0.3, Vector3d::UnitZ()).toRotationMatrix();
  CHECK(held_drives(m).empty());
  // an arc gives way along its chord
  for (LeafSpring& leaf : m.leaves) leaf.curve = 0.5;
  CHECK(held(Direction::ux).empty());
}

TEST_CASE("a drive between two bodies is held by what is between them") {
  Mechanism m = double_parallelogram();
  m.drives = {{.name = "along", .body = 0, .other = 1, .direction = Direction::ux},
              {.name = "across", .body = 0, .other = 1, .direction = Direction::uy}};
  const auto held = held_drives(m);
  REQUIRE(held.size() == 1);
  CHECK(held[0].drive == 0);
  for (const std::string& name : held[0].held_by) CHECK(name.starts_with("inner"));
}
