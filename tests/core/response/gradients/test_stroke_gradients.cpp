// Every quantity has its place among the derivatives, and no two have the same.
#include <catch2/catch.hpp>

#include "core/response/quantities.hpp"

using namespace flexopt;

TEST_CASE("every quantity has a derivative of its own") {
  const int n = 3;
  double next = 1;
  const auto numbered = [&](Eigen::Index rows) {
    MatrixXd m(rows, n);
    for (Eigen::Index i = 0; i < rows; ++i)
      for (int j = 0; j < n; ++j) m(i, j) = next++;
    return m;
  };
  const auto vector = [&] { return VectorXd(numbered(1).row(0)); };
  PointGradients point;
  point.drive_load = vector();
  point.drive_stiffness = vector();
  point.displacement = numbered(3);
  point.rotation = numbered(3);
  for (auto& d : point.support_stiffness) d = vector();
  point.frequencies_free = numbered(12);
  point.frequencies_locked = numbered(12);
  point.parasitic_frequency = vector();
  point.parasitic_frequency_screening = vector();
  point.max_stress = vector();
  point.notch_stress = vector();
  point.yield_safety = vector();
  point.fatigue_safety = vector();
  point.fatigue_life = vector();
  point.envelope = numbered(4);
  point.moving_envelope = numbered(4);
  point.leaf_mass = vector();
  point.clearance = vector();
  point.buckling_locked = vector();
  point.buckling_free = vector();
  point.bandwidths = {vector()};
  point.transmissibility = vector();
  for (auto& d : point.load_capacity) d = vector();
  point.stroke_capacity = {vector(), vector()};

  point.gain = numbered(6);
  point.cross_coupling = numbered(6);

  PathPoint at;  // with a derivative of its own behind every number that is made of others
  at.compliance_locked = (Vector6d() << 2, 3, 4, 5, 6, 7).finished().asDiagonal();
  at.support_stiffness.fill(1.0);
  point.translation_compliance.assign(n, next * Matrix3d::Identity());

  std::vector<double> seen;
  for (const Quantity& q : quantities(Direction::rz)) {
    INFO(q.name);
    const std::optional<VectorXd> gradient = q.gradient(at, point);
    REQUIRE(gradient);
    REQUIRE(gradient->size() == n);
    if (q.name == "buckling.drive_locked") {  // another name of a quantity
      CHECK(*gradient == *gradient_of(at, point, "buckling_load_factor"));
      continue;
    }
    for (const double first : seen) CHECK(first != (*gradient)[0]);
    seen.push_back((*gradient)[0]);
    CHECK_FALSE(q.gradient(at, PointGradients{}));
  }
  CHECK(seen.size() + 1 == quantities(Direction::rz).size());
  CHECK(*gradient_of(at, point, "rotation.z") == VectorXd(point.rotation.row(2)));
  CHECK(*gradient_of(at, point, "frequencies.drive_locked.11") ==
        VectorXd(point.frequencies_locked.row(11)));
  CHECK(*gradient_of(at, point, "support_stiffness.ry") == *point.support_stiffness[4]);
  CHECK(*gradient_of(at, point, "gain.ry") == VectorXd(point.gain.row(4)));
  point.frequencies_free = numbered(2);
  CHECK_FALSE(gradient_of(at, point, "frequencies.drive_free.2"));
}

TEST_CASE("a name that no quantity has is refused, in release builds too") {
  for (const char* name : {"drive_laod", "", "support_stiffness", "displacement.w",
                           "frequencies.drive_free.99", "rotation."}) {
    CAPTURE(name);
    CHECK_THROWS_WITH(value_of(PathPoint{}, name), Catch::Contains("'" + std::string(name) + "'"));
    CHECK_THROWS_AS(gradient_of(PathPoint{}, PointGradients{}, name), std::invalid_argument);
    CHECK_THROWS_AS(needs_of(name), std::invalid_argument);
  }
}

TEST_CASE("every row of the table of quantities is whole") {
  for (const QuantityRow& row : quantity_rows()) {
    INFO(row.name);
    CHECK_FALSE(row.label.empty());
    CHECK_FALSE(row.needs.empty());
    REQUIRE((row.unit || row.of_names));
    REQUIRE(row.value);
    REQUIRE(row.gradient);
    CHECK((row.layout == Layout::number) == (row.components.empty() && !row.of_names));
    if (row.in_summary == SummaryLine::weakest) CHECK(row.components.size() == 6);
  }
}
