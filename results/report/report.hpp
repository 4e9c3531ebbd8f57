#pragma once
// report.html: one file that needs nothing else, neither beside it nor from the network.
#include <filesystem>
#include <string>

#include "results/files/json_text.hpp"

namespace flexopt {

/// The page that shows this result.
std::string make_report(const OrderedJson& result);

void write_report(const std::filesystem::path& folder, const OrderedJson& result);

}  // namespace flexopt
