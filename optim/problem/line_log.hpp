#pragma once
// Checksums of the lines of a log: a line that was changed on the disk is found, not believed.
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "optim/job/job.hpp"

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

// An append-only file of JSON lines from which an interrupted run resumes.

/// One line of a log: doubles as the shortest text that reads back to the same bits.
std::string log_line(const nlohmann::ordered_json& value);

/// The first line, {"flexopt_evaluations": identity}, says whose lines they are; the others are the
/// owner's. In the file each has its checksum, which its owner does not see.
class LineLog {
 public:
  /// A log that keeps nothing on disk.
  LineLog() = default;

  /// Opens or creates the file and gives each whole line after the heading to `read`, which throws
  /// where a line is none of its own; a last line that was cut off is removed. Throws SpecError
  /// when it is the log of another job (the rule names the first difference), no log, or one with a
  /// line that does not fit its checksum, unless `overwrite` starts it anew.
  LineLog(const std::filesystem::path& path, const nlohmann::json& identity, bool overwrite,
          const std::function<void(const std::string&)>& read) {
    open(path, identity, overwrite, read);
  }
  /// Opens the log of an object that has none so far; arguments as of the constructor.
  void open(const std::filesystem::path& path, const nlohmann::json& identity, bool overwrite,
            const std::function<void(const std::string&)>& read);

  /// Adds a line (with its line break) and flushes it. Thread-safe.
  void append(const std::string& line);

  /// Replaces all lines; the old file or the new one is there at any time, never half of it.
  void finish(const std::vector<std::string>& lines);

 private:
  std::filesystem::path path_;
  std::string header_;
  std::ofstream out_;
  std::mutex mutex_;
};

/// A whole log: the heading and these lines (without line breaks), each with its checksum.
std::string log_text(const nlohmann::json& identity, const std::vector<std::string>& lines);
/// Where two identities differ first: "/job/stroke/to was 0.02 and is 0.03".
std::string first_difference(const nlohmann::json& theirs, const nlohmann::json& ours);
/// The identity in the heading of a log; null where it has none.
nlohmann::json log_identity_of(const std::filesystem::path& path);

/// The whole lines after the heading of a log that somebody else may be writing, without their
/// checksums. Throws SpecError where one does not fit.
std::vector<std::string> read_log_lines(const std::filesystem::path& path);

}  // namespace flexopt
