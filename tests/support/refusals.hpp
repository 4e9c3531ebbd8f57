#pragma once
// How wrong input is refused.
#include <catch2/catch.hpp>
#include <string>

#include "core/spec/spec_error.hpp"

namespace flexopt::test {

/// The SpecError of a call, which must throw one.
template <class Call>
SpecError refusal_of(const Call& call) {
  try {
    call();
  } catch (const SpecError& error) {
    return error;
  }
  FAIL("it was accepted");
  return {"", "", ""};
}

/// What the SpecError of a call says, "accepted" where it throws none.
template <class Call>
std::string complaint_of(const Call& call) {
  try {
    call();
  } catch (const SpecError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace flexopt::test
