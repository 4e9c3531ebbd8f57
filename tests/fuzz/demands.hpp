#pragma once
// What is demanded of every reader.
#include <fmt/format.h>

#include <cstdlib>

#include "core/spec/spec_error.hpp"

namespace flexopt::fuzz {

inline void demand(bool holds, const char* what) {
  if (holds) return;
  fmt::print(stderr, "broken: {}\n", what);
  std::abort();
}

// A refusal says where and what would be right.
inline void check(const SpecError& error) {
  demand(!error.faults().empty(), "a refusal without a fault");
  for (const Fault& fault : error.faults()) {
    demand(!fault.rule.empty() || !fault.value.empty(), "a refusal without a word");
    demand(!fault.text().empty(), "a refusal without a text");
  }
}

template <class Work>
void refusing(const Work& work) {
  try {
    work();
  } catch (const SpecError& error) {
    check(error);
  }
}

}  // namespace flexopt::fuzz
