#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numeric>
#include <regex>
#include <sstream>

#include "core/math/rotation.hpp"
#include "results/export/ccx_model.hpp"
#include "results/export/exported.hpp"
#include "tests/results/export/gallery.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

std::string deck_of(const Exported& exported) {
  return ccx_deck(exported, exported.largest_strokes(), {.along = 2, .across = 1});
}

std::string refused(const Exported& exported) {
  return test::complaint_of([&] { (void)deck_of(exported); });
}

}  // namespace

// Longer ones are cut off, their exponents with them.
TEST_CASE("No number of a deck has more than the 20 characters that CalculiX reads") {
  for (const char* name : {"parallel_guide", "crooked_guide", "curved_hinge"}) {
    std::istringstream lines(deck_of(test::gallery(name)));
    std::size_t longest = 0;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("*")) continue;
      std::istringstream fields(line);
      for (std::string field; std::getline(fields, field, ',');)
        longest =
            std::max(longest, field.size() - std::min(field.find_first_not_of(' '), field.size()));
    }
    CHECK(longest > 8);
    CHECK(longest <= 20);
  }
}

// Three inclined leaves carry a weight, so that the way turns sharply where the stroke begins.
TEST_CASE("The stroke of a deck goes in steps as short as those that found its end") {
  const Exported exported =
      make_exported(parse_job(nlohmann::json::parse(R"({"job": "evaluate", "design": {
        "material": {"youngs_modulus": 2e11, "poissons_ratio": 0.3, "density": 7800},
        "mechanism": {"flexopt_design": 1,
          "bodies": [{"name": "end_effector", "at": [0.04, 0.02, 0.07]}],
          "leaves": [{"name": "a", "base": {"body": "ground", "at": [0, 0, 0]},
              "tip": {"body": "end_effector", "at": [0.01, 0, 0.06]},
              "across": [0, 1, 0], "width": 0.015, "thickness": 4e-4},
            {"name": "b", "base": {"body": "ground", "at": [0.08, 0, 0]},
              "tip": {"body": "end_effector", "at": [0.06, 0.01, 0.06]},
              "across": [0, 1, 0], "width": 0.015, "thickness": 3e-4},
            {"name": "c", "base": {"body": "ground", "at": [0.04, 0.05, 0]},
              "tip": {"body": "end_effector", "at": [0.045, 0.05, 0.05]},
              "across": [0, 1, 0], "width": 0.01, "thickness": 4e-4}],
          "drive": {"direction": "ux"}}},
        "end_effector": {"mass": 3, "inertia": [0.003, 0.002, 0.001],
                         "center_of_mass": [0.005, 0.01, 0.01]},
        "gravity": [0, 0, -9.81], "stroke": {"to": 0.004}, "model": {"mesh": [8, 4]}})")),
                    {});
  const auto first_step = [&](double stroke) {
    const std::string deck =
        ccx_deck(exported, VectorXd::Constant(1, stroke), {.along = 2, .across = 1});
    const std::string static_step = "*STATIC\n";
    return std::stod(
        deck.substr(deck.find(static_step, deck.find("** the stroke")) + static_step.size()));
  };
  ModelOptions full = exported.model;
  full.accuracy = Accuracy::full;
  const int steps = exported.equilibria({VectorXd::Constant(1, 0.001)}, full).front().sub_steps;
  CHECK(steps > 1);
  CHECK(first_step(0.004) == Approx(0.25 / steps));
  CHECK(first_step(0) == 0.25);
}

TEST_CASE("A deck has the mass and the inertia of the bodies") {
  const Exported exported = test::gallery("double_parallelogram");
  const CcxModel model(exported, {.along = 1, .across = 1});
  for (std::size_t b = 0; b < exported.mechanism.bodies.size(); ++b) {
    const RigidBody& body = exported.mechanism.bodies[b];
    const auto& nodes = model.rigid_of(static_cast<int>(b))->nodes;
    double mass = 0;
    Vector3d center = Vector3d::Zero();
    Matrix3d inertia = Matrix3d::Zero();
    for (const CcxMass& point : model.masses) {
      if (std::find(nodes.begin(), nodes.end(), point.node) == nodes.end()) continue;
      const Vector3d at = model.nodes[static_cast<std::size_t>(point.node - 1)];
      const Vector3d arm = at - body.center_of_mass;
      mass += point.mass;
      center += point.mass * at;
      inertia += point.mass * (arm.squaredNorm() * Matrix3d::Identity() - arm * arm.transpose());
    }
    REQUIRE(body.mass > 0);
    CHECK(mass == Approx(body.mass));
    CHECK((center / mass - body.center_of_mass).norm() < 1e-12);
    CHECK((inertia - body.inertia).norm() < 1e-9 * (1 + body.inertia.norm()));
  }
}

TEST_CASE("What a deck cannot carry is refused by name") {
  CHECK_THAT(refused(test::gallery("clamped_plate")), Contains("material point of leaf plate"));
  CHECK_THAT(refused(test::gallery("flat_blades")), Contains("assembly in steps"));
  Exported guide = test::gallery("parallel_guide");
  guide.request.loads.body_expansion = {1e-3, 0};
  guide.request.loads.assembly.push_back({.leaf = 0, .end = 1, .move = Vector3d(1e-5, 0, 0)});
  const std::string all = refused(guide);  // every item, not only the first
  CHECK_THAT(all, Contains("temperature of bodies"));
  CHECK_THAT(all, Contains("assembly error of leaf leaf +y"));

  Exported stages = test::gallery("double_parallelogram");
  Joint slide;
  slide.name = "rail";
  slide.type = JointType::prismatic;
  slide.body = 0;
  slide.other = 1;
  stages.mechanism.joints.push_back(slide);
  CHECK_THAT(refused(stages), Contains("joint rail") && Contains("turns with a body that moves"));
  stages.mechanism.joints.back().other = ground;  // along z, while y is driven
  CHECK_THAT(refused(stages), Contains("joint rail") && Contains("held or driven otherwise"));
}

TEST_CASE("An elastic body is in a deck with its mesh, which its frames hold at the patches") {
  Exported guide = test::elastic_guide();
  guide.request.loads.gravity = Vector3d(0, -9.81, 0);
  const CcxModel model(guide, {.along = 1, .across = 1});
  for (std::size_t k = 0; k < 2; ++k) {
    const ElasticBody& body = guide.mechanism.elastic_bodies[k];
    const auto number = [&](int node) { return model.nodes_before[k] + node + 1; };
    const auto place = [&](int node) {
      return model.nodes[static_cast<std::size_t>(number(node) - 1)];
    };
    for (int node = 0; node < body.cells->nodes; ++node)
      CHECK((place(node) - body.place - body.axes * body.nodes[static_cast<std::size_t>(node)])
                .norm() < 1e-12);
    for (const ElasticInterface& face : body.interfaces) {
      const auto& held = face.body == ground ? model.fixed : model.rigid_of(face.body)->nodes;
      REQUIRE(face.patch.size() > 2);
      for (const int node : face.patch) CHECK(std::ranges::count(held, number(node)) == 1);
    }
  }
  CHECK(guide.mechanism.elastic_bodies[1].interfaces[0].body == ground);
  const std::string deck = deck_of(guide);
  CHECK_THAT(deck, Contains("*ELEMENT, TYPE=C3D20R, ELSET=ELASTIC1") &&
                       Contains("*SOLID SECTION, ELSET=ELASTIC2, MATERIAL=MATERIAL2") &&
                       Contains("ELASTIC1, GRAV, 9.81, 0, -1, 0"));
}

TEST_CASE("A deck has wedges and tetrahedra of elastic bodies, at most 16 numbers in a line") {
  Exported guide = test::elastic_guide();
  SolidCells cells = *guide.mechanism.elastic_bodies[1].cells;
  const auto first_nodes = [](int count) {
    std::vector<int> nodes(static_cast<std::size_t>(count));
    std::iota(nodes.begin(), nodes.end(), 0);
    return nodes;
  };
  cells.blocks = {{SolidCell::hexahedron, first_nodes(20)},
                  {SolidCell::wedge, first_nodes(15)},
                  {SolidCell::tetrahedron, first_nodes(10)}};
  guide.mechanism.elastic_bodies[1].cells = std::make_shared<SolidCells>(cells);
  const CcxModel model(guide, {.along = 1, .across = 1});
  CcxLines lines;
  const int stage = guide.mechanism.elastic_bodies[0].cells->blocks[0].count();
  CHECK(write_cells(model, 7, lines) == 7 + stage + 3);
  const auto list = [&](int from, int to) {
    std::vector<int> numbers;
    for (int k = from; k < to; ++k) numbers.push_back(model.nodes_before[1] + k + 1);
    return fmt::format("{}", fmt::join(numbers, ", "));
  };
  const std::string text = std::move(lines).text();
  CHECK_THAT(text, Contains(fmt::format("TYPE=C3D20R, ELSET=ELASTIC2\n{}, {},\n{}\n", 8 + stage,
                                        list(0, 15), list(15, 20))));
  CHECK_THAT(text,
             Contains(fmt::format("TYPE=C3D15, ELSET=ELASTIC2\n{}, {}\n", 9 + stage, list(0, 15))));
  CHECK_THAT(
      text, Contains(fmt::format("TYPE=C3D10, ELSET=ELASTIC2\n{}, {}\n", 10 + stage, list(0, 10))));
}

TEST_CASE("A deck refuses matrices of another program, and elastic bodies that are warm") {
  Exported guide = test::elastic_guide();
  guide.request.loads.elastic_expansion = {0, 1e-4};
  test::forget_mesh(guide.mechanism.elastic_bodies[0]);
  CHECK_THAT(refused(guide), Contains("elastic body end_effector") && Contains("no mesh") &&
                                 Contains("temperature of elastic body foot"));
}

// Axes of a deck stay where they are.
TEST_CASE("What turns with bodies is refused where it turns far, and carried where it does not") {
  CHECK_THAT(refused(test::gallery("bridge_amplifier")),
             Contains("the drive is not carried") && Contains("load times distance"));
  CHECK(refused(test::gallery("xy_stage")) == "accepted");
  for (const char* name : {"cross_hinge", "parallel_guide"}) {
    Exported exported = test::gallery(name);
    Spring bushing;
    bushing.name = "rubber";
    bushing.matrix = Matrix6d::Zero();
    bushing.matrix->diagonal() << 100, 1000, 100, 0.1, 0.1, 0.1;
    exported.mechanism.springs.push_back(bushing);
    CHECK((refused(exported) == "accepted") == (std::string(name) == "parallel_guide"));
    bushing.matrix->setZero();  // about the axis of the hinge it may turn
    (*bushing.matrix)(5, 5) = 0.1;
    exported.mechanism.springs = {bushing};
    CHECK(refused(exported) == "accepted");
  }
  Exported hinge = test::gallery("cartwheel_hinge");
  hinge.request.loads.constant.push_back(
      {.moment = Vector3d(1e-3, 0, 0), .body = 1, .name = "motor"});
  REQUIRE(hinge.mechanism.bodies.size() > 1);
  CHECK_THAT(refused(hinge), Contains("moment of load motor"));
  hinge.request.loads.constant.back().moment = Vector3d(0, 0, 1e-3);
  CHECK(refused(hinge) == "accepted");
}

TEST_CASE("A moment at the end-effector does its work on the rotation vector of the deck") {
  Exported hinge = test::gallery("cross_hinge");
  const Vector3d moment(0.1, -0.05, 0.02);
  hinge.request.loads.constant.push_back({.moment = moment, .body = std::nullopt, .name = ""});
  const std::string deck = deck_of(hinge);
  const auto point = [&] {
    ModelOptions full = hinge.model;
    full.accuracy = Accuracy::full;
    return hinge.equilibria({hinge.largest_strokes()}, full).front();
  }();
  const CcxModel model(hinge, {.along = 1, .across = 1});
  const int node = model.rigid_of(hinge.mechanism.end_effector)->rotation;
  // d(spin) = J dv, so moment · d(spin) = (Jᵀ moment) · dv
  const Vector3d v = point.rotation;
  const double h = 1e-6;
  REQUIRE(v.norm() > 0.3);
  for (int c = 0; c < 3; ++c) {
    const Matrix3d R = rotation_exp(v + h * Vector3d::Unit(c)) *
                       rotation_exp(v - h * Vector3d::Unit(c)).transpose();
    const double work = moment.dot(rotation_log(R)) / (2 * h);
    const std::regex line(fmt::format("\\*CLOAD\n{}, {}, (\\S+)\n", node, c + 1));
    std::smatch found;
    REQUIRE(std::regex_search(deck, found, line));  // the first: before the stroke
    CHECK(std::stod(found[1]) == Approx(work).epsilon(1e-7));
  }
  CHECK_THAT(deck, Contains("less 0.1 -0.05 0.02"));
}

TEST_CASE("A deck has what acts: gravity, warmth, edges placed elsewhere, springs") {
  Exported guide = test::gallery("parallel_guide");
  LoadCase& loads = guide.request.loads;
  loads.gravity = Vector3d(0, 0, -9.81);
  loads.temperature = {2.0, 0.0};
  for (LeafSpring& leaf : guide.mechanism.leaves) leaf.material.thermal_expansion = 11e-6;
  loads.assembly.push_back(
      {.leaf = 1, .end = 0, .move = Vector3d(1e-5, 0, 0), .turn = Vector3d(0, 0.001, 0)});
  Spring spring;
  spring.name = "return";
  spring.place = Vector3d(0.1, 0.05, 0);
  spring.other_place = Vector3d(0.1, 0.08, 0);
  spring.stiffness = 100;
  spring.free_length = 0.03;
  guide.mechanism.springs.push_back(spring);
  const std::string deck = deck_of(guide);
  CHECK_THAT(deck, Contains("LEAF1, GRAV, 9.81, 0, 0, -1"));
  CHECK_THAT(deck, Contains("*EXPANSION, ZERO=0.\n1.1e-05"));
  CHECK_THAT(deck, Contains("*TEMPERATURE\nWARM1, 2\n"));
  CHECK_THAT(deck, Contains("edge of leaf -y"));
  CHECK_THAT(deck, Contains("*SPRING, ELSET=SPRING1\n\n100."));
  CHECK(std::regex_search(deck, std::regex("\\d+, 2, 2, 0\\.001")));
  guide.mechanism.springs.front().free_length = 0.02;  // pulls as built
  CHECK_THAT(deck_of(guide),
             Contains("*SPRING, NONLINEAR") && Contains("1.00000000000, 0.00000000000\n"));
}

TEST_CASE("The usual mesh is within 0.3 %, and a deck says how far a coarser one is not") {
  for (const char* name : {"parallel_guide", "cross_hinge", "xy_stage", "curved_leaf"})
    CHECK(solid_excess(test::gallery(name).mechanism, {}) < 0.003);
  Mechanism folded = test::folded_leaf().mechanism;
  for (const double thickness : {0.1e-3, 0.3e-3, 0.5e-3, 1e-3}) {
    folded.leaves[0].thickness = thickness;
    if (thickness < 1e-3) CHECK(solid_excess(folded, {}) < 0.003);
    // elements beside the mitre are whole: the nodes of each row follow each other along both legs
    const SolidMesh mesh = solid_mesh(folded.leaves[0], {});
    for (const auto& e : mesh.elements) {
      const Vector3d along = mesh.nodes[e[1]] - mesh.nodes[e[0]],
                     other = mesh.nodes[e[2]] - mesh.nodes[e[3]];
      CHECK(along.dot(other) > 0);
    }
  }
  const Exported guide = test::gallery("parallel_guide");
  const double coarse = solid_excess(guide.mechanism, {.along = 2, .across = 1});
  CHECK(coarse > 0.1);
  CHECK_THAT(deck_of(guide), Contains("** 2 x 1 x 1 solids") &&
                                 Contains(fmt::format("up to {:.2g} % stiffer", 100 * coarse)));
}
