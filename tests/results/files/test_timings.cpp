#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "results/files/result_json.hpp"

using namespace flexopt;

TEST_CASE("timings.json holds every time in seconds, and says so", "[results]") {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("flexopt_timings_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  write_timings(folder, {{"path", 0.25}, {"whole run", 1.5}});
  const auto read = nlohmann::json::parse(std::ifstream(folder / "timings.json"));
  std::filesystem::remove_all(folder);
  CHECK(read == nlohmann::json{{"unit", "s"}, {"seconds", {{"path", 0.25}, {"whole run", 1.5}}}});
}
