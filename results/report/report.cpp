#include "results/report/report.hpp"

#include <cassert>
#include <nlohmann/json.hpp>
#include <string_view>

#include "results/files/folder.hpp"
#include "results/report/embedded.hpp"

namespace flexopt {

namespace {

/// For text between tags.
std::string html_escaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      default:
        escaped += c;
    }
  return escaped;
}

/// JSON inside a script element: there `<` may only occur in strings, where \u003c means the same;
/// so no "</script>" or "<!--" of a job's text ends the element.
std::string script_json(const OrderedJson& value) {
  const std::string text = value.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) c == '<' ? escaped += "\\u003c" : escaped += c;
  return escaped;
}

/// What stands for @name@ in the page.
std::string filling(const std::string& name, const OrderedJson& result, const OrderedJson& scene) {
  if (name == "result") return script_json(result);
  if (name == "scene") return script_json(scene);
  if (name == "title") {
    const auto job = result.find("job");
    const bool named = job != result.end() && job->contains("name") && job->at("name").is_string();
    return html_escaped(named ? job->at("name").get<std::string>() : "flexopt report");
  }
  const std::string_view file = embedded_file(name);
  assert(!file.empty());
  return name == "licences.txt" ? html_escaped(file) : std::string(file);
}

}  // namespace

std::string make_report(const OrderedJson& result, const OrderedJson& scene) {
  std::string_view page = embedded_file("page.html");  // its only @ are those of @markers@
  assert(!page.empty());
  std::string report;
  while (!page.empty()) {
    const auto open = page.find('@');
    report += page.substr(0, open);
    if (open == std::string_view::npos) break;
    const auto close = page.find('@', open + 1);
    assert(close != std::string_view::npos);
    report += filling(std::string(page.substr(open + 1, close - open - 1)), result, scene);
    page.remove_prefix(close + 1);
  }
  return report;
}

void write_report(const std::filesystem::path& folder, const OrderedJson& result,
                  const OrderedJson& scene) {
  write_file(folder / "report.html", make_report(result, scene));
}

}  // namespace flexopt
