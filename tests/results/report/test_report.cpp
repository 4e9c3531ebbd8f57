#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <regex>

#include "results/files/result_json.hpp"
#include "results/report/embedded.hpp"
#include "results/report/report.hpp"
#include "support/fixture.hpp"

using namespace flexopt;

namespace {

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

}  // namespace

TEST_CASE("The report loads nothing from outside the file", "[results][report]") {
  const std::string page = make_report(make_result(test::optimised_hinge()));
  CHECK_FALSE(std::regex_search(page, std::regex("<[a-z]+[^<>]* (src|href|srcset|action)=")));
  CHECK_FALSE(std::regex_search(page, std::regex("<(link|iframe|object|embed|base|img)[ >]")));
  CHECK(count(page, "@import") == 0);
  CHECK(count(page, "url(http") == 0);
  // And the page itself forbids it, whatever a library might try.
  CHECK_THAT(page, Catch::Contains("Content-Security-Policy\" content=\"default-src 'none';"));
}

TEST_CASE("No text of a job can end the page's data", "[results][report]") {
  const std::string page = make_report(make_result(test::evaluated_hinge()));
  CHECK(count(page, "<script") == 4);
  CHECK(count(page, "</script") == 4);
  CHECK_THAT(page, Catch::Contains("<title>hinge &lt;/script&gt; &amp; &lt;b&gt;bold&lt;/b&gt;<"));
  const auto begin = page.find('>', page.find("id=\"result\"")) + 1;
  const auto result = OrderedJson::parse(page.substr(begin, page.find("</script", begin) - begin));
  CHECK(result["job"]["name"] == test::evaluated_hinge().job.name);
  CHECK(result == OrderedJson::parse(json_text(make_result(test::evaluated_hinge()))));
}

TEST_CASE("The plotting libraries and their licences are inside", "[results][report]") {
  const std::string page = make_report(make_result(test::evaluated_hinge()));
  for (const char* file : {"d3.js", "plot.js", "figures.js", "shapes.js", "comparison.js",
                           "stages.js", "designs.js", "report.js", "report.css"}) {
    CAPTURE(file);
    const std::string content(embedded_file(file));
    REQUIRE(content.size() > 1000);
    CHECK(page.find(content) != std::string::npos);
  }
  CHECK_THAT(page, Catch::Contains("@observablehq/plot ===="));
  CHECK_THAT(page, Catch::Contains("Permission to use, copy, modify, and/or distribute"));
  CHECK(embedded_file("no such file").empty());
}

TEST_CASE("Even an odd result gives a page", "[results][report]") {
  CHECK_THAT(make_report(OrderedJson::object()), Catch::Contains("<title>flexopt report</title>"));
  const OrderedJson odd = {{"job", {{"name", 7}}}};
  CHECK_THAT(make_report(odd), Catch::Contains("<title>flexopt report</title>"));
}
