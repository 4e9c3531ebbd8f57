#include "results/report/report.hpp"

#include <nlohmann/json.hpp>

#include "results/files/folder.hpp"

namespace flexopt {

namespace {

std::string title_of(const OrderedJson& result) {
  const auto job = result.find("job");
  const bool named = job != result.end() && job->contains("name") && job->at("name").is_string();
  return named ? job->at("name").get<std::string>() : "flexopt report";
}

}  // namespace

std::string make_report(const OrderedJson& result, const OrderedJson& scene) {
  return filled(embedded_file("page.html"), [&](const std::string& name) {
    if (name == "result") return script_json(result);
    if (name == "scene") return script_json(scene);
    if (name == "title") return html_escaped(title_of(result));
    return page_part(name);
  });
}

void write_report(const std::filesystem::path& folder, const OrderedJson& result,
                  const OrderedJson& scene) {
  write_file(folder / "report.html", make_report(result, scene));
}

}  // namespace flexopt
