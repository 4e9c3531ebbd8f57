#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>

/// Open CASCADE keeps what it has made for its readers and writers to the end.
extern "C" const char* __lsan_default_suppressions() { return "leak:libTK"; }
