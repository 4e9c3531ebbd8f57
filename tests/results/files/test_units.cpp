#include "results/files/result_parts.hpp"
#include "tests/results/results_tests.hpp"

TEST_CASE("units follow the direction of the drive, unknown quantities have none") {
  StrokeRequest request;
  struct Row {
    Direction along;
    const char *load, *stiffness, *stroke;
  };
  for (const Row& row : {Row{Direction::uy, "N", "N/m", "m"},
                         {Direction::ux, "N", "N/m", "m"},
                         {Direction::rz, "N m", "N m/rad", "rad"},
                         {Direction::rx, "N m", "N m/rad", "rad"}}) {
    CHECK(load_unit(row.along) == row.load);
    CHECK(stiffness_unit(row.along) == row.stiffness);
    CHECK(stroke_unit(row.along, request) == row.stroke);
    CHECK(quantity_unit("drive_load", row.along) == row.load);
    CHECK(quantity_unit("max_stress", row.along) == "Pa");
    CHECK(quantity_unit("parasitic_frequency", row.along) == "Hz");
    CHECK(quantity_unit("no such quantity", row.along).empty());
  }
}

TEST_CASE("a family's parameters have their units, unknown ones none") {
  const Family& hinge = find_family("cross_hinge", "");
  CHECK(parameter_unit(hinge, "length") == "m");
  CHECK(parameter_unit(hinge, "half_angle") == "rad");
  CHECK(parameter_unit(hinge, "no such parameter").empty());
}
