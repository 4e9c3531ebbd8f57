#include "results/report/report.hpp"

#include <cassert>
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

std::string filled(std::string_view page,
                   const std::function<std::string(const std::string& name)>& filling) {
  assert(!page.empty());
  std::string whole;
  while (!page.empty()) {
    const auto open = page.find('@');
    whole += page.substr(0, open);
    if (open == std::string_view::npos) break;
    const auto close = page.find('@', open + 1);
    assert(close != std::string_view::npos);
    whole += filling(std::string(page.substr(open + 1, close - open - 1)));
    page.remove_prefix(close + 1);
  }
  return whole;
}

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

std::string script_json(const OrderedJson& value) {
  const std::string text = compact_text(value);
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) c == '<' ? escaped += "\\u003c" : escaped += c;
  return escaped;
}

std::string page_part(const std::string& name) {
  const std::string_view file = embedded_file(name);
  assert(!file.empty());
  return name == "licences.txt" ? html_escaped(file) : std::string(file);
}

}  // namespace flexopt
