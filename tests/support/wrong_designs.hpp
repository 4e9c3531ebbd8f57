#pragma once
// Design files with one thing wrong each.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace flexopt::test {

/// A sound design: one leaf along x with a rigid tip.
nlohmann::json cantilever();

/// The cantilever with one value put in.
nlohmann::json changed(const char* pointer, const nlohmann::json& value);

struct WrongDesign {
  const char* pointer;  ///< what is put into the cantilever, where
  nlohmann::json value;
  const char* at;    ///< where it is complained of, the pointer's beginning at least
  const char* rule;  ///< words of the complaint
};

const std::vector<WrongDesign>& wrong_designs();

}  // namespace flexopt::test
