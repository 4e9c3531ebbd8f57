#include "core/spec/spec_error.hpp"

#include <utility>

namespace flexopt {

SpecError::SpecError(std::string pointer, std::string value, std::string rule)
    : std::runtime_error((pointer.empty() ? "/" : pointer) + " = " + value + "; " + rule),
      pointer_(std::move(pointer)),
      value_(std::move(value)),
      rule_(std::move(rule)) {}

}  // namespace flexopt
