#include <catch2/catch.hpp>

#include "core/spec/names.hpp"

using namespace flexopt;

TEST_CASE("the edit distance counts insertions, deletions and replacements") {
  CHECK(edit_distance("", "") == 0);
  CHECK(edit_distance("leaf", "leaf") == 0);
  CHECK(edit_distance("", "leaf") == 4);
  CHECK(edit_distance("lenght", "length") == 2);
  CHECK(edit_distance("kitten", "sitting") == 3);
  CHECK(edit_distance("sitting", "kitten") == 3);
}

TEST_CASE("a slip finds the name that was meant, nonsense finds none") {
  const std::vector<std::string> known{"length", "width", "thickness", "half_angle"};
  CHECK(nearest_name("lenght", known) == "length");
  CHECK(nearest_name("Thickness", known) == "thickness");
  CHECK(nearest_name("halfangle", known) == "half_angle");
  CHECK_FALSE(nearest_name("colour", known));
  CHECK_FALSE(nearest_name(std::string(100000, 'x'), known));
  CHECK(known_names("widht", known) ==
        "did you mean 'width'? known: length, width, thickness, half_angle");
  CHECK(known_names("colour", {"length"}) == "known: length");
}
