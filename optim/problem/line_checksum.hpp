#pragma once
// Checksums of the lines of a log: a line that was changed on the disk is found, not believed.
#include <filesystem>
#include <string>
#include <string_view>

namespace flexopt {

/// A JSON object or array, not empty, with the CRC-32 (zlib's) of its text as its last member:
/// {"a":1} becomes {"a":1,"crc32":"1a2b3c4d"}, and [1] becomes [1,"crc32:1a2b3c4d"].
std::string with_checksum(std::string_view line);

/// The lines of one log in their order, as they were before with_checksum(). If the first line has
/// a checksum all have; in logs from before there were any, a line may have none.
class CheckedLines {
 public:
  CheckedLines() = default;
  explicit CheckedLines(std::filesystem::path file) : file_(std::move(file)) {}

  /// Throws SpecError with file and number of a line that is not as it was written.
  std::string next(std::string_view line);
  /// Number of the last line, counted from 1.
  int number() const { return number_; }

 private:
  std::filesystem::path file_;
  int number_ = 0;
  bool all_have_ = false;
};

}  // namespace flexopt
