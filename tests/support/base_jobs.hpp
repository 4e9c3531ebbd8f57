#pragma once
// Jobs that tests of their readers begin with, and those of the library.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "core/spec/json_file.hpp"

namespace flexopt {

inline constexpr double degree = std::numbers::pi / 180;

/// Reads and parses a file. Throws SpecError.
inline nlohmann::json read_json_file(const std::string& file) {
  const JsonText text = read_text(file);
  return parse_json(text.text, text.origin);
}

/// "evaluate" or "optimise": a job that is right.
inline nlohmann::json base_job(const std::string& name) {
  return read_json_file(FLEXOPT_SOURCE_DIR "/tests/jobs/wrong/cases.json")["bases"][name];
}

inline std::vector<std::filesystem::path> shipped_jobs() {
  std::vector<std::filesystem::path> files;
  for (const char* folder : {"/designs/jobs", "/designs/studies"})
    for (const auto& entry :
         std::filesystem::directory_iterator(std::string(FLEXOPT_SOURCE_DIR) + folder))
      if (entry.path().extension() == ".json") files.push_back(entry.path());
  return files;
}

}  // namespace flexopt
