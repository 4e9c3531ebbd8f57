#pragma once
#include <cstdlib>

namespace flexopt::test {

/// Whether tests look at every case: FLEXOPT_NIGHTLY is set, as `.ci/run nightly` does. Else those
/// that would take long look at a smaller one of the same law.
inline bool nightly() { return std::getenv("FLEXOPT_NIGHTLY") != nullptr; }

}  // namespace flexopt::test
