#include "tests/results/results_tests.hpp"

TEST_CASE("timings.json holds every time in seconds, and says so") {
  const test::TemporaryFolder folder;
  write_timings(folder.path(), {{"path", 0.25}, {"whole run", 1.5}});
  const auto read = json::parse(test::content_of(folder / "timings.json"));
  CHECK(read == json{{"unit", "s"}, {"seconds", {{"path", 0.25}, {"whole run", 1.5}}}});
}
