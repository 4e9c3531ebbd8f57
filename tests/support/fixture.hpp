#pragma once
// A run with the shape of a real one, from closed forms: two crossed leaves turned by the stroke.
#include <filesystem>
#include <string>

#include "results/files/run_record.hpp"

namespace flexopt::test {

/// ±20°, five points, shapes, frequencies, stress.
RunRecord evaluated_hinge();

/// The same design as the optimum of two variables with two constraints and two starts.
RunRecord optimised_hinge();

/// A folder of this test alone, empty at first, gone at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string content_of(const std::filesystem::path& file);

}  // namespace flexopt::test
