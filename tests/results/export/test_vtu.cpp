#include "results/export/exported.hpp"
#include "results/files/result_parts.hpp"
#include "support/vtu.hpp"
#include "tests/results/export/gallery.hpp"

using namespace flexopt;
using test::data_array;

TEST_CASE("A VTU file has displacement, stress and every mode of its point") {
  const Exported exported = test::gallery("parallel_guide", {"20 mm"});
  const PathPoint point = exported.standing({Output::frequencies_locked});
  const std::string xml = point_vtu(exported.mechanism, point);
  REQUIRE(point.modes_locked.size() == 6);
  std::size_t points = 0;
  for (const LeafShape& shape : point.shapes) points += shape.undeflected.size();
  const auto displacement = data_array(xml, "displacement");
  CHECK(displacement.size() == 3 * points);
  CHECK(*std::max_element(displacement.begin(), displacement.end()) == Approx(0.02).epsilon(1e-3));
  CHECK(data_array(xml, "von_mises").size() == points);
  for (int k = 1; k <= 6; ++k) {
    const auto mode = data_array(xml, "mode " + std::to_string(k) + ", drive locked, ");
    REQUIRE(mode.size() == 3 * points);
    double largest = 0;
    for (std::size_t i = 0; i < mode.size(); i += 3)
      largest = std::max(largest, std::hypot(mode[i], mode[i + 1], mode[i + 2]));
    CHECK(largest == Approx(1));
  }
}

TEST_CASE("Undeflected there is neither load nor displacement") {
  Exported exported = test::gallery("payload_on_guide");
  const PathPoint point = exported.standing();
  CHECK(point.displacement.norm() < 1e-12);
  for (const double s : data_array(point_vtu(exported.mechanism, point), "von_mises"))
    CHECK(s < 1.0);
  exported.undeflected = false;  // at rest, under the payload
  CHECK(data_array(point_vtu(exported.mechanism, exported.standing()), "von_mises").at(1) > 1e3);
}
