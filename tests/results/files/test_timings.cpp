#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "results/files/result_json.hpp"
#include "support/temporary_folder.hpp"

using namespace flexopt;

TEST_CASE("timings.json holds every time in seconds, and says so", "[results]") {
  const test::TemporaryFolder folder;
  write_timings(folder.path(), {{"path", 0.25}, {"whole run", 1.5}});
  const auto read = nlohmann::json::parse(test::content_of(folder / "timings.json"));
  CHECK(read == nlohmann::json{{"unit", "s"}, {"seconds", {{"path", 0.25}, {"whole run", 1.5}}}});
}
