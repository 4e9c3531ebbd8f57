#pragma once

#include <cstdio>
#include <string>

namespace flexopt {

/// What is printed while it lives goes into every page that has the same markers:
///
///     <!-- bench NAME PART -->
///     <!-- end bench -->
///
/// NAME: the benchmark; PART: one word that tells its tables apart. `bench.sh` writes the pages.
class PageTable {
 public:
  explicit PageTable(const std::string& name) {
    std::printf("<!-- bench %s -->\n\n", name.c_str());
  }
  ~PageTable() {
    std::printf("\n<!-- end bench -->\n");
    std::fflush(stdout);
  }
  PageTable(const PageTable&) = delete;
  PageTable& operator=(const PageTable&) = delete;
};

}  // namespace flexopt
