#pragma once
// Libraries that the program loads only where they are wanted: what few runs need and all would
// have to wait for, or what a machine may not have.
#include <string>

namespace flexopt {

/// Whether what the library loads by itself later may look for names in it.
enum class PartNames { own, global };

/// A C function of a library beside the program, or where it was installed (lib/flexopt).
struct PartFunction {
  void* address = nullptr;
  std::string missing;  ///< why there is none
};

/// A function of a library, which is loaded at the first call and kept.
PartFunction part_function(const std::string& library, const std::string& function,
                           PartNames names = PartNames::own);

}  // namespace flexopt
