#include <regex>
#include <stack>

#include "results/files/result_parts.hpp"
#include "support/vtu.hpp"
#include "tests/results/results_tests.hpp"

using test::data_array;

namespace {

/// Every tag that opens is closed in order, and nothing but tags, the head and numbers is there.
bool well_formed(const std::string& xml) {
  static const std::regex tag("<(/?)([A-Za-z]+)((?: [A-Za-z_]+=\"[^\"<>&]*\")*)(/?)>");
  const std::string head = "<?xml version=\"1.0\"?>\n";
  if (xml.rfind(head, 0) != 0) return false;
  std::stack<std::string> open;
  const std::string body = xml.substr(head.size());
  auto last = body.cbegin();
  int roots = 0;
  for (std::sregex_iterator it(body.begin(), body.end(), tag), end; it != end; ++it) {
    if (std::string(last, (*it)[0].first).find_first_of("<>&") != std::string::npos) return false;
    last = (*it)[0].second;
    if ((*it)[1] == "/") {
      if (open.empty() || open.top() != (*it)[2]) return false;
      open.pop();
    } else if ((*it)[4] != "/") {
      if (open.empty()) ++roots;
      open.push((*it)[2]);
    }
  }
  return open.empty() && roots == 1 &&
         std::string(last, body.cend()).find_first_not_of(" \n") == std::string::npos;
}

}  // namespace

TEST_CASE("The check of well-formedness finds what is not") {
  CHECK(well_formed("<?xml version=\"1.0\"?>\n<a b=\"c\"><d/></a>\n"));
  CHECK_FALSE(well_formed("<?xml version=\"1.0\"?>\n<a><b></a></b>\n"));
  CHECK_FALSE(well_formed("<?xml version=\"1.0\"?>\n<a> < </a>\n"));
}

TEST_CASE("A shape file holds all leaves' points, displacements and stresses") {
  const RunRecord record = test::evaluated_hinge();
  const auto& shapes = record.response.path.back().shapes;
  const std::string xml = shape_vtu(record.response.path.back());
  REQUIRE(well_formed(xml));
  const auto points = data_array(xml, "Points"), moved = data_array(xml, "displacement"),
             stress = data_array(xml, "von_mises"), cells = data_array(xml, "connectivity"),
             offsets = data_array(xml, "offsets"), leaf = data_array(xml, "leaf");
  REQUIRE(points.size() == 3 * 2 * 36);
  REQUIRE(moved.size() == points.size());
  REQUIRE(stress.size() == 2 * 36);
  REQUIRE(cells.size() == 4 * 2 * 24);
  CHECK(offsets.back() == cells.size());
  CHECK(leaf.front() == 0);
  CHECK(leaf.back() == 1);
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t i = 0; i < 36; ++i)
      for (std::size_t d = 0; d < 3; ++d) {
        const std::size_t row = 3 * (36 * k + i) + d;
        CHECK(points[row] == shapes[k].undeflected[i][static_cast<int>(d)]);
        CHECK(points[row] + moved[row] ==
              Approx(shapes[k].deflected[i][static_cast<int>(d)]).margin(1e-15));
      }
  // Facets of the flat leaf: corners in order round it, areas summing to length × width.
  double area = 0;
  for (std::size_t c = 0; c < 24; ++c) {
    const auto corner = [&](std::size_t n) {
      const auto at = 3 * static_cast<std::size_t>(cells[4 * c + n]);
      return Vector3d(points[at], points[at + 1], points[at + 2]);
    };
    area += 0.5 * (corner(2) - corner(0)).cross(corner(3) - corner(1)).norm();
  }
  CHECK(area == Approx(0.08 * 0.03).epsilon(1e-12));
}

TEST_CASE("The collection names every shape file that is written") {
  RunRecord record = test::evaluated_hinge();
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "shape_005.vtu") << "of an earlier, longer path";
  record.response.path[1].shapes.clear();
  write_shapes(folder.path(), record.response.path);
  const std::string pvd = test::content_of(folder.path() / "shapes.pvd");
  REQUIRE(well_formed(pvd));
  std::size_t named = 0;
  const std::regex file("timestep=\"([^\"]+)\" part=\"0\" file=\"([^\"]+)\"");
  for (std::sregex_iterator it(pvd.begin(), pvd.end(), file), end; it != end; ++it, ++named)
    CHECK(fs::exists(folder.path() / (*it)[2].str()));
  CHECK(named == 4);
  CHECK_FALSE(fs::exists(folder.path() / "shape_001.vtu"));
  CHECK_FALSE(fs::exists(folder.path() / "shape_005.vtu"));
}
