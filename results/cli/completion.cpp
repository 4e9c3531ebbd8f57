#include <fmt/format.h>
#include <fmt/ranges.h>

#include "designs/describe.hpp"
#include "results/cli/command_line.hpp"
#include "results/cli/commands.hpp"
#include "results/cli/printed.hpp"
#include "results/export/exported.hpp"

namespace flexopt {

namespace {

/// Values that an argument of this type may have; empty where no list has them.
std::vector<std::string> values_of(const CommandArgument& argument) {
  if (!argument.values.empty()) return argument.values;
  std::vector<std::string> values;
  if (argument.type == "FAMILY") return library_names();
  if (argument.type == "FORMATS")
    for (const ExportFormat& format : export_formats()) values.push_back(format.name);
  return values;
}

/// The call that fills COMPREPLY with values of the argument; ":" where nothing is known of them.
std::string bash_values(const CommandArgument& argument) {
  if (argument.type == "FILE") return "_flexopt_files";
  if (argument.type == "DIR") return "_flexopt_folders";
  const std::vector<std::string> values = values_of(argument);
  if (values.empty()) return ":";
  return fmt::format("{} {}", argument.type == "FORMATS" ? "_flexopt_list" : "_flexopt_words",
                     fmt::join(values, " "));
}

constexpr const char* bash_begin =
    R"~(# Completes flexopt in bash: source <(flexopt completion bash)
_flexopt_fill() { mapfile -t COMPREPLY < <(compgen "$@" -- "$cur"); }
_flexopt_words() { _flexopt_fill -W "$*"; }
_flexopt_folders() {
  compopt -o filenames 2>/dev/null
  _flexopt_fill -d
}
_flexopt_files() {
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(
    compgen -d -- "$cur"
    compgen -f -X '!*.json' -- "$cur"
  )
}
_flexopt_list() {
  local before=
  [[ $cur == *,* ]] && before=${cur%,*},
  cur=${cur##*,} _flexopt_fill -P "$before" -W "$*"
}
_flexopt() {
  local cur=${COMP_WORDS[COMP_CWORD]} at=$((COMP_CWORD - 1))
  COMPREPLY=()
  # bash splits --out=DIR
  [[ $cur == = ]] && cur=
  [[ ${COMP_WORDS[at]} == = && $at -gt 1 ]] && at=$((at - 1))
)~";

/// First line of a help text for use between single quotes in zsh, without characters that
/// _arguments reads otherwise.
std::string zsh_help(const std::string& help) {
  std::string text;
  for (const char c : help.substr(0, help.find('\n'))) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') text += '\\';
    text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return text;
}

/// "FILE:_files -g "*.json"": name and action of a value.
std::string zsh_values(const CommandArgument& argument) {
  if (argument.type == "FILE") return R"~(file:_files -g "*.json(-.)")~";
  if (argument.type == "DIR") return "folder:_files -/";
  const std::vector<std::string> values = values_of(argument);
  if (values.empty()) return zsh_help(argument.type) + ": ";
  if (argument.type == "FORMATS")
    return fmt::format("formats:_values -s , format {}", fmt::join(values, " "));
  return fmt::format("value:({})", fmt::join(values, " "));
}

std::string zsh_arguments(const CommandShape& command) {
  std::string text;
  for (const CommandArgument& argument : command.arguments) {
    if (argument.names.empty()) text += fmt::format(" \\\n          '1:{}'", zsh_values(argument));
    for (const std::string& name : argument.names)
      text += fmt::format(" \\\n          '*{}[{}]{}'", name, zsh_help(argument.help),
                          argument.flag ? "" : ":" + zsh_values(argument));
  }
  return text;
}

}  // namespace

std::string bash_completion() {
  const std::vector<CommandShape> commands = command_shapes();
  std::vector<std::string> first;
  for (std::size_t k = 1; k < commands.size(); ++k) first.push_back(commands[k].name);
  for (const CommandArgument& argument : commands.front().arguments)
    first.insert(first.end(), argument.names.begin(), argument.names.end());
  std::string text = bash_begin;
  text += fmt::format(
      "  if ((COMP_CWORD == 1)); then\n    _flexopt_words {}\n    return\n  fi\n"
      "  case ${{COMP_WORDS[1]}}:${{COMP_WORDS[at]}} in\n",
      fmt::join(first, " "));
  for (std::size_t k = 1; k < commands.size(); ++k)
    for (const CommandArgument& argument : commands[k].arguments)
      for (const std::string& name : argument.names)
        if (!argument.flag)
          text += fmt::format("    {}:{}) {}; return ;;\n", commands[k].name, name,
                              bash_values(argument));
  text += "  esac\n  case ${COMP_WORDS[1]}:$cur in\n";
  for (std::size_t k = 1; k < commands.size(); ++k) {
    std::vector<std::string> options;
    std::string rest;
    for (const CommandArgument& argument : commands[k].arguments) {
      options.insert(options.end(), argument.names.begin(), argument.names.end());
      if (argument.names.empty()) rest = bash_values(argument);
    }
    text +=
        fmt::format("    {}:-*) _flexopt_words {} ;;\n", commands[k].name, fmt::join(options, " "));
    if (!rest.empty()) text += fmt::format("    {}:*) {} ;;\n", commands[k].name, rest);
  }
  return text + "  esac\n}\ncomplete -F _flexopt flexopt\n";
}

std::string zsh_completion() {
  const std::vector<CommandShape> commands = command_shapes();
  std::string text =
      "#compdef flexopt\n# Completes flexopt in zsh: source <(flexopt completion zsh)\n"
      "_flexopt() {\n  local curcontext=$curcontext state line\n  local -a commands\n"
      "  commands=(\n";
  for (std::size_t k = 1; k < commands.size(); ++k)
    text += fmt::format("    '{}:{}'\n", commands[k].name, zsh_help(commands[k].help));
  text += fmt::format(
      "  )\n  _arguments -C{} \\\n          '1:command:->command' '*::argument:->argument'\n"
      "  case $state in\n    command) _describe command commands ;;\n    argument)\n"
      "      case $words[1] in\n",
      zsh_arguments(commands.front()));
  for (std::size_t k = 1; k < commands.size(); ++k)
    text +=
        fmt::format("        {}) _arguments{} ;;\n", commands[k].name, zsh_arguments(commands[k]));
  return text +
         "      esac ;;\n  esac\n}\n"
         "if [[ $funcstack[1] == _flexopt ]]; then _flexopt \"$@\"; else compdef _flexopt flexopt; "
         "fi\n";
}

int print_completion(const CommandLine& line) {
  fmt::print("{}", line.shell == "bash" ? bash_completion() : zsh_completion());
  return exit_usable;
}

}  // namespace flexopt
