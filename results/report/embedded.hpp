#pragma once
#include <string_view>

namespace flexopt {

/// A file that was put into the binary at build time; empty if there is none of that name.
std::string_view embedded_file(std::string_view name);

}  // namespace flexopt
