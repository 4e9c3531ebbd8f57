#pragma once
// The design files that the program brings along.
#include <string>
#include <string_view>
#include <vector>

namespace flexopt {

/// Names of the families of the library, in the order of the documentation.
const std::vector<std::string>& library_names();

/// Text of a design file of the library, empty for an unknown name.
std::string_view library_text(std::string_view name);

}  // namespace flexopt
