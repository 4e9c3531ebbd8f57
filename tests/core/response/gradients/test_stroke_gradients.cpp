// Every quantity has its place among the derivatives, and no two have the same.
#include <catch2/catch.hpp>

#include "core/response/stroke_gradients.hpp"

using namespace flexopt;

TEST_CASE("every quantity has a derivative of its own", "[response][gradients]") {
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

  std::vector<double> seen;
  for (const Quantity& q : quantities(Direction::rz)) {
    INFO(q.name);
    const std::optional<VectorXd> gradient = gradient_of(point, q.name);
    REQUIRE(gradient);
    REQUIRE(gradient->size() == n);
    for (const double first : seen) CHECK(first != (*gradient)[0]);
    seen.push_back((*gradient)[0]);
    CHECK_FALSE(gradient_of(PointGradients{}, q.name));
  }
  CHECK(seen.size() == quantities(Direction::rz).size());
  CHECK(*gradient_of(point, "rotation.z") == VectorXd(point.rotation.row(2)));
  CHECK(*gradient_of(point, "frequencies.drive_locked.11") ==
        VectorXd(point.frequencies_locked.row(11)));
  CHECK(*gradient_of(point, "support_stiffness.ry") == *point.support_stiffness[4]);
  point.frequencies_free = numbered(2);
  CHECK_FALSE(gradient_of(point, "frequencies.drive_free.2"));
}
