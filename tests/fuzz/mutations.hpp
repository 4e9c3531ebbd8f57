#pragma once
// Changes of texts that a reader is tried with: of bytes, and of JSON values. The same for the same
// numbers.
#include <filesystem>
#include <string>
#include <vector>

#include "support/random_design.hpp"

namespace flexopt::fuzz {

/// Keys, names, units and functions that the readers know: from the schemas of jobs and designs.
const std::vector<std::string>& dictionary();

/// The texts of a folder, in the order of their names.
std::vector<std::string> texts_in(const std::filesystem::path& folder);

/// One of the texts with a few changes.
std::string mutated(const std::vector<std::string>& texts, RandomNumbers& random);

}  // namespace flexopt::fuzz
