// libFuzzer on the target FLEXOPT_FUZZ_TARGET of the list FLEXOPT_FUZZ_TARGETS.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "tests/fuzz/targets.hpp"

// UDUNITS loses the copy of a name, some bytes, in a unit that it refuses.
extern "C" const char* __lsan_default_suppressions() { return "leak:utlex\n"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const flexopt::fuzz::Target& target = []() -> const auto& {
    for (const auto& one : flexopt::fuzz::FLEXOPT_FUZZ_TARGETS())
      if (one.name == FLEXOPT_FUZZ_TARGET) return one;
    std::abort();
  }
  ();
  target.run({reinterpret_cast<const char*>(bytes), size});
  return 0;
}
