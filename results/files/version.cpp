#include "results/files/version.hpp"

#include "flexopt_commit.hpp"  // written at build time by commit.cmake

namespace flexopt {

std::string version() { return FLEXOPT_VERSION; }

std::string commit() { return FLEXOPT_COMMIT; }

std::string build_id() { return version() + " " + commit(); }

}  // namespace flexopt
