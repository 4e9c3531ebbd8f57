// Boxes of words, and what is in their way.
#include <catch2/catch.hpp>

#include "results/export/picture.hpp"

using namespace flexopt;

TEST_CASE("A line meets a box where any of it is inside", "[results][drawing]") {
  const Box2 box(Point2(0, 0), Point2(10, 4));
  CHECK(meets(box, {-5, 2}, {20, 2}));
  CHECK(meets(box, {4, 1}, {5, 2}));
  CHECK(meets(box, {-1, 3}, {3, 7}) == false);
  CHECK(meets(box, {-1, 2}, {3, 6}));
  CHECK_FALSE(meets(box, {-5, 5}, {20, 5}));
  CHECK_FALSE(meets(box, {-5, 2}, {-1, 2}));
  CHECK(overlaps(box, Box2(Point2(9, 3), Point2(12, 6))));
  CHECK_FALSE(overlaps(box, Box2(Point2(11, 0), Point2(12, 4))));
  CHECK(overlaps(box, Box2(Point2(11, 0), Point2(12, 4)), 2));
}

TEST_CASE("Words on words weigh more than words on lines, and these more than crossing lines",
          "[results][drawing]") {
  Picture there, words, beside, line, along;
  there.labels.push_back(label_at("there", {0, 0}));
  there.dimensions.push_back({"length", "m", 1, 100, {{0, 40}, {100, 40}}, Point2::Zero()});
  words.labels.push_back(label_at("over", {5, 5}));
  beside.labels.push_back(label_around("on the line", {50, 40}));
  line.line("extension", {{60, 20}, {60, 60}});
  along.line("extension", {{20, 41}, {80, 41}});
  CHECK(conflict(words, there) >= 1000);
  CHECK(conflict(beside, there) < 1000);
  CHECK(conflict(beside, there) > conflict(line, there));
  CHECK(conflict(line, there) > 0);
  CHECK(conflict(along, there) > conflict(line, there));
  words.move({200, 200});
  CHECK(conflict(words, there) == 0);
}

TEST_CASE("Text is broken at blanks and loses nothing", "[results][drawing]") {
  const std::string text = "one Two three fourteen characters °°° end";
  for (const double width : {1.0, 60.0, 120.0, 1000.0}) {
    std::string joined;
    for (const std::string& line : wrapped(text, width, 12)) {
      if (line.find(' ') != std::string::npos) CHECK(size_of_text(line, 12)[0] <= width);
      joined += (joined.empty() ? "" : " ") + line;
    }
    CHECK(joined == text);
  }
  CHECK(size_of_text("°", 10)[0] == size_of_text("é", 10)[0]);
  CHECK(size_of_text("mm", 12)[0] > size_of_text("ii", 12)[0]);
}
