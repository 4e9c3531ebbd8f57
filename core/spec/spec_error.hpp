#pragma once
// What is wrong with the user's input, and where.
#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace flexopt {

using JsonPointer = nlohmann::json_pointer<std::string>;

/// One thing that is wrong with the user's input.
struct Fault {
  std::string pointer;       ///< JSON pointer of the culprit
  std::string value;         ///< what stands there
  std::string rule;          ///< what would be right
  bool of_key = false;       ///< the key is wrong, whatever its value
  std::string source;        ///< file that it stands in, or "--set"; empty: unknown
  int line = 0, column = 0;  ///< in the file, from 1, columns in letters; 0: unknown

  /// "job.json:7:12: /stroke/to = "5 N"; expected a length", without the parts that are unknown.
  std::string text() const;
};

/// The user's input is wrong in one place or in several.
class SpecError : public std::runtime_error {
 public:
  SpecError(std::string pointer, std::string value, std::string rule);
  SpecError(const JsonPointer& pointer, std::string value, std::string rule);
  /// All faults of an input, at least one. The message shows the first 50, a line each, and counts
  /// the rest.
  explicit SpecError(std::vector<Fault> faults);

  const std::vector<Fault>& faults() const { return faults_; }
  /// Pointer and value of the first fault.
  const std::string& pointer() const { return faults_.front().pointer; }
  const std::string& value() const { return faults_.front().value; }
  const std::string& rule() const { return faults_.front().rule; }

 private:
  std::vector<Fault> faults_;
};

}  // namespace flexopt
