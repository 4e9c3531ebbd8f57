#include "results/cli/printed.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "designs/describe.hpp"
#include "results/cli/command_line.hpp"
#include "results/export/exported.hpp"
#include "results/files/result_json.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

/// An object with these members of another, null where it has none.
Json picked(const Json& from, std::initializer_list<const char*> keys) {
  Json some = Json::object();
  for (const char* key : keys) some[key] = from.contains(key) ? from.at(key) : Json();
  return some;
}

Json table_json(const StrokeResponse& response, const DriveList& drives,
                const StrokeRequest& request) {
  Json table = Json::array();
  for (const StrokeRow& row : stroke_table(response, drives, request)) {
    Json json = {{"quantity", row.quantity}, {"label", row.label}, {"unit", row.unit}};
    Json values = Json::array(), directions = Json::array(), at_least = Json::array();
    bool directed = false, bound = false;
    for (const StrokeCell& cell : row.cells) {
      values.push_back(optional_json(cell.value));
      directions.push_back(cell.direction.empty() ? Json() : Json(cell.direction));
      at_least.push_back(cell.at_least);
      bound = bound || cell.at_least;
      directed = directed || !cell.direction.empty();
    }
    json["values"] = std::move(values);
    if (directed) json["directions"] = std::move(directions);
    if (bound) json["at_least"] = std::move(at_least);
    table.push_back(std::move(json));
  }
  return table;
}

Json optimum_json(const Json& optimum) {
  Json json = picked(optimum, {"status", "stop_reason", "objective", "goal", "parameters"});
  json["constraints"] = Json::array();
  for (const Json& constraint : optimum.at("constraints"))
    json["constraints"].push_back(
        picked(constraint, {"label", "unit", "value", "min", "max", "margin", "active"}));
  json["verified"] = nullptr;
  if (const Json& verified = optimum.at("verified"); verified.is_object())
    json["verified"] =
        picked(verified, {"status", "objective", "objective_difference", "constraints"});
  json.update(picked(optimum, {"evaluations", "failed_evaluations"}));
  return json;
}

Json comparison_json(const Json& comparison) {
  Json json = picked(comparison, {"designs", "failed_designs"});
  json["models"] = Json::array();
  for (const Json& model : comparison.at("models")) {
    Json shown = picked(model, {"name", "failures", "fallbacks", "speed_up"});
    for (const auto& [quantity, figures] : model.at("errors").items())
      if (figures.at("count") != 0)
        shown["errors"][quantity] = picked(figures, {"worst", "p99", "median", "worst_at"});
    json["models"].push_back(std::move(shown));
  }
  return json;
}

/// Listed designs without their whole results.
Json list_json(const Json& list) {
  Json entries = Json::array();
  for (const Json& entry : list) {
    Json shown = entry;
    shown.erase("result");
    entries.push_back(std::move(shown));
  }
  return entries;
}

void add_tables(const RunRecord& record, Json& json) {
  const DriveList drives = drives_of(record);
  if (record.job.cases.empty()) {
    json["table"] = table_json(response_of(record), drives, record.job.request);
    return;
  }
  const auto responses = responses_of(record);
  for (std::size_t k = 0; k < responses.size(); ++k)
    json["cases"][record.job.cases[k].name]["table"] =
        table_json(*responses[k], drives, record.job.cases[k].request);
}

Json error_json(const Fault& fault) {
  Json json = {{"pointer", fault.pointer},
               {"value", fault.value},
               {"rule", fault.rule},
               {"message", fault.text()}};
  if (!fault.source.empty()) json["source"] = fault.source;
  if (fault.line > 0) json.update({{"line", fault.line}, {"column", fault.column}});
  return json;
}

Json failure_json(const std::string& status, const std::string& message) {
  return {{"flexopt", version()},
          {"status", status},
          {"usable", false},
          {"error", {{"pointer", ""}, {"value", ""}, {"rule", ""}, {"message", message}}}};
}

/// Prints a document on one line.
void print(Json document) {
  remove_non_finite(document);
  fmt::print("{}\n", compact_text(document));
}

/// What a row costs beside the equilibrium, which every number needs.
std::string cost_of(const QuantityRow& row) {
  constexpr std::pair<Output, const char*> words[] = {
      {Output::stiffness, "stiffness"},
      {Output::gain, "stiffness"},
      {Output::stress, "stress"},
      {Output::gauges, "stress"},
      {Output::frequencies_free, "frequencies"},
      {Output::frequencies_locked, "frequencies"},
      {Output::parasitic_frequency, "frequencies"},
      {Output::frequency_derivatives, "one expansion at rest"},
      {Output::envelope, "surfaces at rest"},
      {Output::moving_envelope, "surfaces"},
      {Output::clearance, "surfaces"},
      {Output::buckling, "buckling, full leaves"},
      {Output::load_capacity, "growing loads, full leaves"},
      {Output::stroke_capacity, "ways of their own"},
      {Output::dynamics, "harmonic motion, full leaves"},
      {Output::transfers, "harmonic motion, full leaves"}};
  for (const auto& [output, word] : words)
    if (row.needs.has(output)) return word;
  return row.needs.has(Output::equilibrium) ? "equilibrium" : "the design";
}

/// How the errors of a quantity are estimated.
const char* estimate_of(const QuantityRow& row) {
  return row.error == ErrorKind::none     ? "-"
         : row.error == ErrorKind::motion ? "of path"
         : row.error == ErrorKind::stress ? "coarse"
                                          : "yes";
}

/// The units of these quantities, each once.
std::string units_of(const std::vector<const Quantity*>& quantities) {
  std::vector<std::string> all;
  for (const Quantity* q : quantities)
    if (std::ranges::find(all, q->unit) == all.end()) all.push_back(q->unit);
  return fmt::format("{}", fmt::join(all, ", "));
}

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

void print_run(const WrittenRun& written, const std::string& folder, const RunRecord* record) {
  const Json& result = *written.result;
  Json json = {{"flexopt", version()}};
  json.update(picked(result, {"status", "message"}));
  json["usable"] = usable(result);
  json["folder"] = folder;
  json.update(picked(result.at("job"), {"name", "job"}));
  json["failed_expectations"] = written.failed_expectations;
  for (const char* list : {"ranking", "designs"})
    if (result.contains(list)) json[list] = list_json(result.at(list));
  if (!record) return print(std::move(json));
  if (record->comparison) {
    json["comparison"] = comparison_json(result.at("comparison"));
    return print(std::move(json));
  }
  if (record->optimum) json["optimum"] = optimum_json(result.at("optimum"));
  if (record->tolerances)
    json["tolerances"] =
        picked(result.at("tolerances"), {"message", "goals", "room", "yield", "widest"});
  if (record->assembly)
    json["assembly_tolerances"] =
        picked(result.at("assembly_tolerances"), {"message", "worst_case", "critical"});
  add_tables(*record, json);
  print(std::move(json));
}

void print_shard(const Shard& shard, const std::vector<SharedLoop>& loops,
                 const std::string& folder) {
  Json json = {{"flexopt", version()},  {"status", "shard"},     {"usable", true},
               {"folder", folder},      {"shard", shard.number}, {"of", shard.of},
               {"loops", Json::array()}};
  for (const SharedLoop& loop : loops)
    json["loops"].push_back({{"what", loop.what}, {"here", loop.here}, {"all", loop.all}});
  print(std::move(json));
}

void print_wrong_input(const SpecError& error) {
  Json json = failure_json("wrong_input", error.what());
  json["error"] = error_json(error.faults().front());
  json["errors"] = Json::array();
  for (const Fault& fault : error.faults()) json["errors"].push_back(error_json(fault));
  print(std::move(json));
}

void print_failure(const std::string& status, const std::string& message) {
  print(failure_json(status, message));
}

std::string describe_quantities(const DriveList& drives) {
  // rows whose components are offered for these drives, in the order of the table
  std::string text = fmt::format("{:<46} {:<13} {:<22} {:<9} {}\n", "quantity", "unit", "needs",
                                 "estimate", "meaning");
  const std::vector<Quantity> all = quantities(drives);
  for (const QuantityRow& row : quantity_rows()) {
    std::vector<const Quantity*> own;
    for (const Quantity& q : all)
      if (q.row == &row) own.push_back(&q);
    if (own.empty()) continue;
    std::string name = own.front()->name;
    if (own.size() > 1) {
      const std::string& last = own.back()->name;
      name += fmt::format(" … {}", last.substr(last.rfind('.')));
    }
    std::string meaning = row.meaning.empty() ? row.label : row.meaning;
    if (meaning.ends_with(',')) meaning.pop_back();  // a label that its components complete
    const std::string unit = units_of(own);
    text += fmt::format("{:<46} {:<13} {:<22} {:<9} {}\n", name, unit == "1" ? "-" : unit,
                        cost_of(row), estimate_of(row), meaning);
  }
  return text;
}

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
