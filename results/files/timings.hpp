#pragma once
// timings.json: the only file with a clock in it.
#include <filesystem>
#include <map>
#include <string>

namespace flexopt {

void write_timings(const std::filesystem::path& folder,
                   const std::map<std::string, double>& seconds);

}  // namespace flexopt
