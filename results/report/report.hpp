#pragma once
// report.html: one file that needs nothing else, neither beside it nor from the network.
#include <filesystem>
#include <string>

#include "results/files/json_text.hpp"

namespace flexopt {

/// The page that shows this result. `scene`: what it draws in three dimensions, of make_scene();
/// null where there is nothing to draw.
std::string make_report(const OrderedJson& result, const OrderedJson& scene);

void write_report(const std::filesystem::path& folder, const OrderedJson& result,
                  const OrderedJson& scene);

}  // namespace flexopt
