#include <cctype>
#include <string>
#include <vector>

#include "results/files/scene.hpp"
#include "results/report/report.hpp"
#include "tests/results/results_tests.hpp"

namespace {

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

/// All that begins like a tag, up to the next angle bracket.
std::vector<std::string> tags(const std::string& page) {
  std::vector<std::string> all;
  for (auto at = page.find('<'); at != std::string::npos; at = page.find('<', at + 1))
    if (at + 1 < page.size() && page[at + 1] >= 'a' && page[at + 1] <= 'z')
      all.push_back(page.substr(at, page.find_first_of("<>", at + 1) - at));
  return all;
}

std::string page_of(const RunRecord& record) {
  return make_report(make_result(record), make_scene(record));
}

/// The JSON of an element of the page.
OrderedJson data_of(const std::string& page, const std::string& id) {
  const auto begin = page.find('>', page.find("id=\"" + id + "\"")) + 1;
  return OrderedJson::parse(page.substr(begin, page.find("</script", begin) - begin));
}

}  // namespace

TEST_CASE("The report loads nothing from outside the file") {
  const std::string page = page_of(test::optimised_hinge());
  for (const std::string& tag : tags(page))
    for (const std::string attribute : {" src=", " srcset=", " action=", " href="})
      CHECK(count(tag, attribute) == count(tag, attribute + "\"#"));
  for (const std::string name : {"link", "iframe", "object", "embed", "base", "img"})
    CHECK(count(page, "<" + name + " ") + count(page, "<" + name + ">") == 0);
  CHECK(count(page, "@import") == 0);
  CHECK(count(page, "url(http") == 0);
  // And the page itself forbids it, whatever a library might try.
  CHECK_THAT(page, Contains("Content-Security-Policy\" content=\"default-src 'none';"));
}

TEST_CASE("No text of a job can end the page's data") {
  const std::string page = page_of(test::evaluated_hinge());
  CHECK(count(page, "<script") == 3);
  CHECK(count(page, "</script") == 3);
  CHECK_THAT(page, Contains("<title>hinge &lt;/script&gt; &amp; &lt;b&gt;bold&lt;/b&gt;<"));
  const OrderedJson result = data_of(page, "result");
  CHECK(result["job"]["name"] == test::evaluated_hinge().job.name);
  CHECK(result == OrderedJson::parse(json_text(make_result(test::evaluated_hinge()))));
  CHECK(data_of(page, "scene") == make_scene(test::evaluated_hinge()));
}

TEST_CASE("The plotting libraries and their licences are inside") {
  const std::string page = page_of(test::evaluated_hinge());
  for (const char* file : {"bundle.js", "report.css"}) {
    CAPTURE(file);
    const std::string content(embedded_file(file));
    REQUIRE(content.size() > 1000);
    CHECK(page.find(content) != std::string::npos);
  }
  // What the modules of the page and each of the libraries bring, whatever the bundler calls it.
  const std::string bundle(embedded_file("bundle.js"));
  for (const char* sign :
       {"Principal support stiffness", "Each line is an evaluated design", "against full accuracy",
        "Copy as PNG", "Copy as ", "this browser has no WebGL", "aria-label", "WebGLRenderer",
        "invalid block type"}) {
    CAPTURE(sign);
    CHECK(std::ranges::search(bundle, std::string_view(sign), [](char a, char b) {
            return std::tolower(a) == std::tolower(b);
          }).begin() != bundle.end());
  }
  for (const char* library : {"three ====", "fflate ====", "d3 ===="}) {
    CAPTURE(library);
    CHECK_THAT(page, Contains(std::string("==== ") + library));
  }
  CHECK_THAT(page, Contains("@observablehq/plot ===="));
  CHECK_THAT(page, Contains("Permission to use, copy, modify, and/or distribute"));
  CHECK(embedded_file("no such file").empty());
}

TEST_CASE("Even an odd result gives a page") {
  CHECK_THAT(make_report(OrderedJson::object(), nullptr),
             Contains("<title>flexopt report</title>"));
  const OrderedJson odd = {{"job", {{"name", 7}}}};
  CHECK_THAT(make_report(odd, nullptr), Contains("<title>flexopt report</title>"));
}
