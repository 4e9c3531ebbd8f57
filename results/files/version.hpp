#pragma once
#include <string>

namespace flexopt {

/// Versions of the two file formats (docs/versions.md). They are raised when existing files change
/// their meaning.
inline constexpr int job_format = 1;     ///< "flexopt" of a job
inline constexpr int result_format = 1;  ///< "format" of result.json

std::string version();  ///< version of the project: "0.1.0"
std::string commit();   ///< that was built, with "-dirty-…" if files were changed; or "unknown"
/// Version and commit of the build. Logs of another build are refused.
std::string build_id();

}  // namespace flexopt
