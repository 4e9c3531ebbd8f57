#pragma once
#include <cstdlib>
#include <string>

namespace flexopt::test {

/// The program of this build, or the one that FLEXOPT_BINARY names in the environment.
inline std::string binary() {
  const char* other = std::getenv("FLEXOPT_BINARY");
  return other ? other : FLEXOPT_BINARY;
}

}  // namespace flexopt::test
