#include "results/files/program_part.hpp"
#include "tests/results/results_tests.hpp"

TEST_CASE("a part that is not there is named") {
  const PartFunction none = part_function("flexopt_no_such_part.so", "anything");
  CHECK(none.address == nullptr);
  CHECK(none.missing == "no flexopt_no_such_part.so");
}

TEST_CASE("a file beside the program that is no library says what the loader says") {
  const fs::path file = fs::read_symlink("/proc/self/exe").parent_path() / "flexopt_spoilt_part.so";
  std::ofstream(file) << "no library";
  const PartFunction spoilt = part_function(file.filename().string(), "anything");
  fs::remove(file);
  CHECK(spoilt.address == nullptr);
  CHECK_THAT(spoilt.missing, Contains("flexopt_spoilt_part.so"));
}
