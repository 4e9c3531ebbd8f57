#pragma once
// How a function says that it has no answer. Wrong input is a SpecError of core/spec instead.
#include <string>
#include <tl/expected.hpp>

namespace flexopt {

/// What was asked for, or the reason why there is none.
template <class T, class Reason = std::string>
using Answer = tl::expected<T, Reason>;

/// Nothing where all is well, or the rule that is broken.
using Check = Answer<void>;

/// A reason with the figures, and in a few words without them.
struct Why {
  std::string message, reason;
};

/// What a function returns that has no answer.
using Because = tl::unexpected<std::string>;
using BecauseOf = tl::unexpected<Why>;

/// The reason; empty where there is an answer.
template <class T>
std::string why_not(const Answer<T>& answer) {
  return answer ? std::string() : answer.error();
}

}  // namespace flexopt
