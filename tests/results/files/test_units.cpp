#include "results/files/result_parts.hpp"

#include <catch2/catch.hpp>

using namespace flexopt;

TEST_CASE("units of loads and stiffness follow the direction", "[results]") {
  CHECK(load_unit(Direction::uy) == "N");
  CHECK(load_unit(Direction::rz) == "N m");
  CHECK(stiffness_unit(Direction::ux) == "N/m");
  CHECK(stiffness_unit(Direction::rx) == "N m/rad");
}

TEST_CASE("the unit of the stroke is that of the drive", "[results]") {
  StrokeRequest request;
  CHECK(stroke_unit(Direction::uy, request) == "m");
  CHECK(stroke_unit(Direction::rz, request) == "rad");
}

TEST_CASE("the unit of a drive's quantities follows the drive, unknown ones have none",
          "[results]") {
  CHECK(quantity_unit("drive_load", Direction::uy) == "N");
  CHECK(quantity_unit("drive_load", Direction::rz) == "N m");
  CHECK(quantity_unit("max_stress", Direction::uy) == "Pa");
  CHECK(quantity_unit("parasitic_frequency", Direction::rz) == "Hz");
  CHECK(quantity_unit("no such quantity", Direction::uy).empty());
}

TEST_CASE("a family's parameters have their units, unknown ones none", "[results]") {
  const Family& hinge = find_family("cross_hinge", "");
  CHECK(parameter_unit(hinge, "length") == "m");
  CHECK(parameter_unit(hinge, "half_angle") == "rad");
  CHECK(parameter_unit(hinge, "no such parameter").empty());
}
