// Springs of a deck have the energy of what they stand for.
#include <regex>
#include <sstream>

#include "results/export/ccx_model.hpp"
#include "tests/results/export/gallery.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

using Freedom = std::pair<int, int>;  // node, degree of freedom

/// The stiffness matrix of all SPRING1 and SPRING2 elements, by degree of freedom.
std::map<std::pair<Freedom, Freedom>, double> stiffness_of(const std::string& deck) {
  static const std::regex element(
      R"(\*ELEMENT, TYPE=SPRING([12]), ELSET=(TIE\d+)\n\d+, (\d+)(?:, (\d+))?\n)"
      R"(\*SPRING, ELSET=(TIE\d+)\n(\d)(?:, (\d))?\n(\S*\.\S*)\n)");
  std::map<std::pair<Freedom, Freedom>, double> K;
  for (auto m = std::sregex_iterator(deck.begin(), deck.end(), element);
       m != std::sregex_iterator(); ++m) {
    REQUIRE((*m)[2] == (*m)[5]);
    const double k = std::stod((*m)[8]);
    const Freedom a{std::stoi((*m)[3]), std::stoi((*m)[6])};
    K[{a, a}] += k;
    if ((*m)[1] == "1") continue;
    const Freedom b{std::stoi((*m)[4]), std::stoi((*m)[7])};
    K[{b, b}] += k;
    K[{a, b}] -= k;
    K[{b, a}] -= k;
  }
  return K;
}

std::string ties_of(const CcxModel& model) {
  CcxLines lines;
  write_ties(model, 0, lines);
  return std::move(lines).text();
}

}  // namespace

TEST_CASE("The springs of a bushing are its matrix, between bodies and on the ground") {
  for (const auto& [body, other] : {std::pair{0, ground}, std::pair{ground, 0}, std::pair{0, 1}}) {
    Exported stages = test::gallery("double_parallelogram");
    Spring bushing;
    bushing.name = "rubber";
    bushing.body = body;
    bushing.other = other;
    bushing.place = Vector3d(0.01, 0.02, -0.03);
    const Matrix6d any = Matrix6d::Random();  // Eigen's own, the same each time
    bushing.matrix = Matrix6d(1000 * any * any.transpose());
    stages.mechanism.springs.push_back(bushing);
    const CcxModel model(stages, {.along = 1, .across = 1});
    const auto found = stiffness_of(ties_of(model));
    REQUIRE(model.bushings.size() == 1);
    const CcxBushing& tie = model.bushings.front();
    CHECK((tie.other == 0) == (body == ground || other == ground));
    const auto freedom = [&](int k) {  // own ones first
      const bool own = k < 6;
      const int place = own ? tie.node : tie.other, turn = own ? tie.rotation : tie.other_rotation;
      return k % 6 < 3 ? Freedom{place, k % 6 + 1} : Freedom{turn, k % 6 - 2};
    };
    const int size = tie.other == 0 ? 6 : 12;
    for (int i = 0; i < size; ++i)
      for (int j = 0; j < size; ++j) {
        const double sign = i / 6 == j / 6 ? 1 : -1;
        // sums of twelve numbers of twelve digits
        CHECK(found.at({freedom(i), freedom(j)}) ==
              Approx(sign * (*bushing.matrix)(i % 6, j % 6)).margin(1e-8));
      }
    for (const int node : {tie.node, tie.other})
      if (node > 0)
        CHECK((model.nodes[static_cast<std::size_t>(node - 1)] - bushing.place).norm() == 0);
  }
}

TEST_CASE("A ball is one pin, a hinge two on its axis, a slide holds all but its axis") {
  Exported stages = test::gallery("double_parallelogram");
  Joint joint;
  joint.name = "tie";
  joint.body = 0;
  joint.other = 1;
  joint.place = Vector3d(0.01, 0.02, 0.03);
  joint.axis = Vector3d(0.6, 0, 0.8);
  const auto pins = [&](JointType type) {
    joint.type = type;
    stages.mechanism.joints = {joint};
    const CcxModel model(stages, {.along = 1, .across = 1});
    std::vector<Vector3d> places;
    for (const CcxPin& pin : model.pins) {
      const auto at = [&](int node) { return model.nodes[static_cast<std::size_t>(node - 1)]; };
      CHECK((at(pin.node) - at(pin.other)).norm() == 0);
      places.push_back(at(pin.node));
    }
    const auto K = stiffness_of(ties_of(model));
    CHECK(K.size() == 12 * places.size());  // three directions, two nodes
    for (const auto& [at, k] : K) CHECK(std::abs(k) > 1e9);
    return places;
  };
  const auto ball = pins(JointType::spherical), hinge = pins(JointType::revolute);
  REQUIRE(ball.size() == 1);
  CHECK((ball[0] - joint.place).norm() < 1e-15);
  REQUIRE(hinge.size() == 2);
  CHECK((hinge[0] + hinge[1] - 2 * joint.place).norm() < 1e-15);
  CHECK((hinge[1] - hinge[0]).cross(joint.axis).norm() < 1e-15);
  CHECK((hinge[1] - hinge[0]).norm() > 0.01);

  stages.mechanism.drives.clear();
  joint.type = JointType::prismatic;
  joint.other = ground;
  stages.mechanism.joints = {joint};
  const CcxModel model(stages, {.along = 1, .across = 1});
  CcxLines lines;
  write_slides(model, lines);
  const CcxRigid& own = *model.rigid_of(0);
  const std::string text = std::move(lines).text();
  CHECK_THAT(text, Contains(fmt::format("*BOUNDARY\n{}, 1, 3, 0.", own.rotation)));
  CHECK_THAT(text, Contains(fmt::format("*EQUATION\n2\n{0}, 1, 1,\n{0}, 3, -0.75", own.reference)));
  CHECK_THAT(text, Contains(fmt::format("*EQUATION\n1\n{}, 2, 1\n", own.reference)));
}

TEST_CASE("An equation begins with its largest component") {
  CcxLines lines;
  write_equation(terms_along(7, Vector3d(0.6, 0, -0.8)), lines);
  const std::string text = std::move(lines).text(),
                    expected = "*EQUATION\n2\n7, 3, -0.8,\n7, 1, 0.6\n";
  CHECK(text == expected);
}
