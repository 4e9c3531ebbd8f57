// The scripts that complete command lines, run by the shells themselves.
#include <set>

#include "designs/describe.hpp"
#include "results/cli/command_line.hpp"
#include "results/cli/printed.hpp"
#include "tests/results/results_tests.hpp"

namespace {

std::string shell(const fs::path& folder, const std::string& program, const std::string& script) {
  std::ofstream(folder / ".script") << script;
  const std::string command = "cd '" + folder.string() + "' && " + program + " .script > .out 2>&1";
  CAPTURE(script);
  const int status = std::system(command.c_str());
  const std::string out = test::content_of(folder / ".out");
  CAPTURE(out);
  CHECK(status == 0);
  return out;
}

/// What bash would offer for the last of these words.
std::set<std::string> replies(const fs::path& folder, const std::vector<std::string>& words) {
  std::string script = bash_completion() + "COMP_WORDS=(flexopt";
  for (const std::string& word : words) script += " '" + word + "'";
  script += ")\nCOMP_CWORD=" + std::to_string(words.size()) +
            "\n_flexopt\nfor reply in \"${COMPREPLY[@]}\"; do echo \"$reply\"; done\n";
  std::istringstream lines(shell(folder, "bash", script));
  std::set<std::string> all;
  for (std::string line; std::getline(lines, line);) all.insert(line);
  return all;
}

using Words = std::set<std::string>;

}  // namespace

TEST_CASE("bash completes commands, options, families, files and values") {
  const test::Workplace folder;
  for (const char* name : {"guide.json", "a hinge.json", "notes.txt"})
    std::ofstream(folder.path() / name) << "{}";
  fs::create_directory(folder / "jobs");
  const auto offered = [&](const std::vector<std::string>& words) {
    return replies(folder.path(), words);
  };
  Words commands{"-h", "--help", "--version"};
  for (const CommandShape& command : command_shapes())
    if (command.name != "flexopt") commands.insert(command.name);
  CHECK(commands.size() >= 12);
  CHECK(offered({""}) == commands);
  CHECK(offered({"co"}) == Words{"completion"});
  CHECK(offered({"run", "--"}) == Words{"--help", "--json", "--out", "--quiet", "--result",
                                        "--rigid", "--set", "--shard", "--threads"});
  CHECK(offered({"run", ""}) == Words{"guide.json", "a hinge.json", "jobs"});
  CHECK(offered({"run", "gu"}) == Words{"guide.json"});
  CHECK(offered({"run", "guide.json", "--out", ""}) == Words{"jobs"});
  CHECK(offered({"run", "guide.json", "--out", "=", "jo"}) == Words{"jobs"});
  CHECK(offered({"run", "guide.json", "--threads", ""}).empty());
  CHECK(offered({"designs", ""}) == Words(library_names().begin(), library_names().end()));
  CHECK(offered({"designs", "--export", "cross"}) == Words{"cross_hinge"});
  CHECK(offered({"export", "guide.json", "--format", "st"}) == Words{"step", "stl"});
  CHECK(offered({"export", "guide.json", "--format", "dxf,st"}) == Words{"dxf,step", "dxf,stl"});
  CHECK(offered({"completion", ""}) == Words{"bash", "zsh"});
}

TEST_CASE("The program prints its scripts, and refuses other shells") {
  const test::Workplace folder;
  CHECK(folder.run("completion bash").out == bash_completion());
  CHECK(folder.run("completion zsh").out == zsh_completion());
  const test::Outcome other = folder.run("completion fish");
  CHECK(other.code == 2);
  CHECK_THAT(other.err, Contains("fish"));
}

TEST_CASE("The script for zsh names every command and option once") {
  const std::string script = zsh_completion();
  for (const CommandShape& command : command_shapes()) {
    CAPTURE(command.name);
    if (command.name == "flexopt") continue;
    const std::size_t begin = script.find("        " + command.name + ") _arguments");
    REQUIRE(begin != std::string::npos);
    const std::string own = script.substr(begin, script.find(";;", begin) - begin);
    for (const CommandArgument& argument : command.arguments)
      for (const std::string& name : argument.names) CHECK_THAT(own, Contains(name + "["));
  }
  const test::Workplace folder;
  if (std::system("command -v zsh >/dev/null") != 0) {
    WARN("no zsh here: its script was not run");
    return;
  }
  const std::string loaded =
      shell(folder.path(), "zsh -f",
            "autoload -Uz compinit && compinit -u -D\n" + script + "print $_comps[flexopt]\n");
  CHECK(loaded == "_flexopt\n");
}
