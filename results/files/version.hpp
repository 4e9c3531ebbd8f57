#pragma once
#include <string>

namespace flexopt {

std::string version();  ///< of the project: "0.1.0"
std::string commit();   ///< that was built, with "-dirty-…" if files were changed; or "unknown"
/// Both: logs of another build are refused.
std::string build_id();

}  // namespace flexopt
