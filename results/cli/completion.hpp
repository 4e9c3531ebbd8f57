#pragma once
// Scripts that complete a command line in a shell.
#include <string>

namespace flexopt {

/// Functions for bash, to be sourced (source <(flexopt completion bash)).
std::string bash_completion();
/// Completion for zsh: to be sourced, or as the file _flexopt in a folder of $fpath.
std::string zsh_completion();

}  // namespace flexopt
