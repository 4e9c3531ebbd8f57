// libFuzzer on the target FLEXOPT_FUZZ_TARGET.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "tests/fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const flexopt::fuzz::Target& target = []() -> const auto& {
    for (const auto& one : flexopt::fuzz::targets())
      if (one.name == FLEXOPT_FUZZ_TARGET) return one;
    std::abort();
  }
  ();
  target.run({reinterpret_cast<const char*>(bytes), size});
  return 0;
}
