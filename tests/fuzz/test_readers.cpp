// Every reader of texts from outside answers or refuses in words, for the texts of the corpus and
// thousands of changes of them, the same ones every time. With libFuzzer: README.md.
#include <catch2/catch.hpp>

#include "tests/fuzz/mutations.hpp"
#include "tests/fuzz/targets.hpp"

using namespace flexopt;
using namespace flexopt::fuzz;

TEST_CASE("readers answer or refuse in words") {
  const std::filesystem::path root = FLEXOPT_SOURCE_DIR;
  for (const Target& target : targets()) {
    CAPTURE(target.name);
    const std::vector<std::string> texts = corpus_of(target.name, root);
    REQUIRE(!texts.empty());
    for (const std::string& text : texts) target.run(text);
    const bool whole_mechanisms = target.name == "job" || target.name == "design";
    RandomNumbers random(1);
    for (int k = 0; k < (whole_mechanisms ? 2000 : 5000); ++k) {
      const std::string text = mutated(texts, random);
      CAPTURE(k, text);
      target.run(text);
    }
  }
}

TEST_CASE("changes of texts are the same every time, and of all kinds") {
  const std::vector<std::string> texts{R"({"stroke": {"to": "5 mm"}, "at": [1, 2, 3]})", "a b"};
  RandomNumbers once(7), again(7);
  int shorter = 0, longer = 0;
  for (int k = 0; k < 200; ++k) {
    const std::string text = mutated(texts, once);
    CHECK(text == mutated(texts, again));
    (text.size() < texts[0].size() ? shorter : longer) += 1;
  }
  CHECK(shorter > 20);
  CHECK(longer > 20);
  CHECK(dictionary().size() > 300);
}
