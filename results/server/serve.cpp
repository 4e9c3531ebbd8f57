#include "results/server/serve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"
#include "results/report/report.hpp"
#include "results/server/local_server.hpp"

namespace flexopt {

namespace fs = std::filesystem;

namespace {

/// The page before it has anything to show. `kind`: "explore" or "watch", for its script; `about`:
/// what that must know.
std::string served_page(const std::string& nonce, const std::string& title,
                        const OrderedJson& about) {
  return filled(embedded_file("served.html"), [&](const std::string& name) {
    if (name == "nonce") return nonce;
    if (name == "title") return html_escaped(title);
    if (name == "about") return script_json(about);
    return page_part(name);
  });
}

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr int deepest = 2;  // folders of listed designs below that of the run

/// Files whose change is news: those of the run and of its designs.
struct Traces {
  std::string version;
  fs::file_time_type written = fs::file_time_type::min();
};

Traces traces_of(const fs::path& folder) {
  std::vector<std::string> parts;
  Traces found;
  std::error_code gone;  // a file may go while we look: the next look sees that
  for (auto it = fs::recursive_directory_iterator(
           folder, fs::directory_options::skip_permission_denied, gone);
       it != fs::recursive_directory_iterator(); it.increment(gone)) {
    if (gone) break;
    if (it.depth() >= deepest) it.disable_recursion_pending();
    const fs::path& path = it->path();
    const std::string name = path.filename().string();
    if (path.extension() != ".jsonl" && name != "job.json" && name != "result.json") continue;
    std::error_code no_size, no_time;
    const auto size = fs::file_size(path, no_size);
    const auto time = fs::last_write_time(path, no_time);
    if (no_size || no_time) continue;
    found.written = std::max(found.written, time);
    parts.push_back(fmt::format("{} {} {}", path.lexically_relative(folder).string(), size,
                                time.time_since_epoch().count()));
  }
  std::ranges::sort(parts);
  found.version =
      fmt::format("{:x}", std::hash<std::string>()(fmt::format("{}", fmt::join(parts, "\n"))));
  return found;
}

/// An unfinished run is not taken for an interrupted one: whoever watches it sees whether it goes
/// on.
void say_running(OrderedJson& result) {
  result["status"] = "running";
  const auto optimum = result.find("optimum");
  if (optimum == result.end() || !optimum->is_object()) {
    result["message"] = "The run is not finished; shown is what there is so far.";
    return;
  }
  (*optimum)["stop_reason"] = "running";
  result["message"] =
      fmt::format("{} evaluations so far, {} of them failed. {}", optimum->value("evaluations", 0),
                  optimum->value("failed_evaluations", 0),
                  optimum->value("objective", OrderedJson()).is_null()
                      ? "None has values yet."
                      : "The numbers are those of the best design so far.");
}

}  // namespace

void serve_explorer(const Job& job, int port, const SayAddress& say) {
  const Explorer explorer(job);
  NewestMove newest;
  LocalServer server(port);
  const OrderedJson about{{"kind", "explore"},
                          {"name", job.name},
                          {"full", job.model.accuracy == Accuracy::full},
                          {"sliders", explorer.slider_table()}};
  server.page([&](const std::string& nonce) { return served_page(nonce, job.name, about); });
  server.post("/evaluate", [&](const std::string& body) -> ServerAnswer {
    const ParameterValues move = read_move(body, explorer.sliders());
    const auto answer = newest.run([&] { return compact_text(explorer.evaluate(move)); });
    if (!answer) return {409, "{\"ok\":false,\"message\":\"a newer move came\"}"};
    return {200, *answer};
  });
  server.post("/job", [&](const std::string& body) -> ServerAnswer {
    return {200, explorer.job_text(read_move(body, explorer.sliders()))};
  });
  say(server.address());
  server.run();
}

void serve_watch(const std::filesystem::path& folder, int port, const SayAddress& say) {
  WatchedRun run(folder);
  LocalServer server(port);
  const std::string name = std::filesystem::weakly_canonical(folder).filename().string();
  const OrderedJson about{{"kind", "watch"}, {"name", name}};
  server.page([&](const std::string& nonce) { return served_page(nonce, name, about); });
  server.post("/state", [&](const std::string& body) -> ServerAnswer {
    return {200, run.state(read_since(body))};
  });
  say(server.address());
  server.run();
}

WatchedRun::WatchedRun(fs::path folder) : folder_(std::move(folder)) {
  if (!fs::is_directory(folder_))
    throw SpecError("", folder_.string(), "expected the output folder of a run");
}

void WatchedRun::look() {
  const auto begin = Clock::now();
  if (begin < next_look_) return;
  Traces traces = traces_of(folder_);
  written_ = traces.written;
  if (traces.version != version_) {
    try {
      ShownRun run = read_run(folder_, log_);
      if (!run.finished) say_running(*run.result);
      run.result->erase("shapes");  // the scene has them
      shown_ = fmt::format("\"finished\":{},\"result\":{},\"scene\":{}", run.finished,
                           compact_text(*run.result), compact_text(*run.scene));
    } catch (const SpecError& error) {
      shown_ = fmt::format("\"waiting\":{}", compact_text(error.what()));
    }
    version_ = std::move(traces.version);
  }
  // A long log takes its time: most of it is left to the run.
  next_look_ = Clock::now() + std::max<Clock::duration>(400ms, 4 * (Clock::now() - begin));
}

std::string WatchedRun::state(const std::string& since) {
  const std::lock_guard lock(mutex_);
  look();
  const bool dated = written_ != fs::file_time_type::min();
  const double age =
      std::chrono::duration<double>(fs::file_time_type::clock::now() - written_).count();
  return fmt::format("{{\"version\":\"{}\",\"age\":{},{}}}", version_,
                     dated ? fmt::format("{:.1f}", std::max(0.0, age)) : "null",
                     since == version_ ? "\"unchanged\":true" : shown_);
}

std::string read_since(const std::string& body) {
  const nlohmann::json document = parse_json(body, "the request");
  if (!document.is_object() || document.size() != 1 || !document.contains("since") ||
      !document["since"].is_string())
    throw SpecError("", shown(document), "expected {\"since\": version}");
  return document["since"];
}

}  // namespace flexopt
