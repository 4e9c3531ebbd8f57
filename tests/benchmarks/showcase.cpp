// What the two jobs of README.md print: the parallel guide and the three-flexure cross hinge.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/benchmarks/page.hpp"

namespace {

/// The numbers of the summary: its lines that begin with a blank.
void show(const std::string& job) {
  const std::string command =
      "out=$(mktemp -d); \"" FLEXOPT_PROGRAM "\" run \"" FLEXOPT_SOURCE_DIR "/designs/jobs/" + job +
      ".json\" --quiet --out \"$out\"; code=$?; rm -r \"$out\"; exit $code";
  std::FILE* said = popen(command.c_str(), "r");
  if (!said) std::exit(1);
  {
    const flexopt::PageTable page("showcase " + job);
    char line[400];
    while (std::fgets(line, sizeof line, said))
      if (line[0] == ' ') std::printf("    %s", line);
  }
  if (pclose(said) != 0) std::exit(1);
}

}  // namespace

int main() {
  show("parallel_guide");
  show("three_flexure_cross_hinge");
}
