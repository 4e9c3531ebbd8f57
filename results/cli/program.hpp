#pragma once
// The whole command line: in the program itself, or in the shared library that it then starts.

/// What main returns: an ExitCode.
extern "C" [[gnu::visibility("default")]] int flexopt_program(int argc, char** argv);
