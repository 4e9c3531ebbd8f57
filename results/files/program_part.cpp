#include "results/files/program_part.hpp"

#include <dlfcn.h>

#include <filesystem>

namespace flexopt {

namespace fs = std::filesystem;

PartFunction part_function(const std::string& library, const std::string& function,
                           PartNames names) {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  fs::path file = program / library;
  if (!fs::exists(file)) file = program.parent_path() / FLEXOPT_LIBDIR / library;
  if (!fs::exists(file)) return {nullptr, "no " + library};
  void* const loaded =
      ::dlopen(file.c_str(), RTLD_NOW | (names == PartNames::global ? RTLD_GLOBAL : RTLD_LOCAL));
  if (!loaded) return {nullptr, ::dlerror()};
  void* const address = ::dlsym(loaded, function.c_str());
  if (!address) return {nullptr, ::dlerror()};
  return {address, {}};
}

}  // namespace flexopt
