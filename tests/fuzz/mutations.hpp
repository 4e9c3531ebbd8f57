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

/// The texts of a reader's corpus in the order of their names; of jobs and designs those of the
/// gallery and the library too. `root`: of the repository.
std::vector<std::string> corpus_of(const std::string& target, const std::filesystem::path& root);

/// One of the texts with a few changes.
std::string mutated(const std::vector<std::string>& texts, RandomNumbers& random);

}  // namespace flexopt::fuzz
