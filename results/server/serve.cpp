#include "results/server/serve.hpp"

#include <nlohmann/json.hpp>

#include "results/report/report.hpp"
#include "results/server/explorer.hpp"
#include "results/server/local_server.hpp"
#include "results/server/watched_run.hpp"

namespace flexopt {

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

}  // namespace flexopt
