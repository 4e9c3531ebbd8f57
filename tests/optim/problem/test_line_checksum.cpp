#include "optim/problem/line_log.hpp"
#include "tests/optim/optim_tests.hpp"

using namespace flexopt::test;

namespace {

const json identity{{"version", "1"}, {"job", {{"stroke", 0.02}}}};
// as screening, evaluations and shared units write them
const std::vector<std::string> lines{"[0,1.25,[0.5,-3e-7]]", R"({"design":4,"points":[0.1]})",
                                     R"(["maps 1",7,{"ok":true}])"};

std::vector<std::string> opened(const std::filesystem::path& file) {
  std::vector<std::string> seen;
  const LineLog log(file, identity, false, [&](const std::string& line) { seen.push_back(line); });
  return seen;
}

// As the program wrote it before there were checksums.
std::string without_checksums() {
  std::string text = json{{"flexopt_evaluations", identity}}.dump() + "\n";
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

}  // namespace

TEST_CASE("a checksum is the CRC-32 of the line, which stays JSON") {
  // sums by Python's zlib.crc32
  CHECK(with_checksum("[123456789]") == R"([123456789,"crc32:c68c30fa"])");
  CHECK(with_checksum(R"({"a":1})") == R"({"a":1,"crc32":"561bacaf"})");
  for (const std::string& line : lines) {
    CHECK(json::accept(with_checksum(line)));
    CHECK(CheckedLines("log").next(with_checksum(line)) == line);
  }
}

TEST_CASE("a log with a bit changed anywhere is refused, or read up to where it is torn") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "log.jsonl";
  const std::string whole = log_text(identity, lines);
  put(file, whole);
  REQUIRE(opened(file) == lines);
  CHECK(read_log_lines(file) == lines);
  int refused = 0, torn = 0, believed = 0;
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      std::string spoilt = whole;
      spoilt[at] = static_cast<char>(spoilt[at] ^ (1 << bit));
      put(file, spoilt);
      try {
        // only the last line break is not within a line
        believed += opened(file) != std::vector(lines.begin(), lines.end() - 1);
        ++torn;
        CHECK(at == whole.size() - 1);
      } catch (const SpecError& error) {
        ++refused;
        CHECK(error.pointer() == file.string());
      }
    }
  CHECK(believed == 0);
  CHECK(torn == 8);
  CHECK(refused == 8 * static_cast<int>(whole.size() - 1));
}

TEST_CASE("what is nothing but a checksum is no line") {
  for (const char* line : {R"(,"crc32":"00000000"})", R"({,"crc32":"00000000"})",
                           R"({"crc32":"00000000"})", R"([,"crc32:00000000"])", "}", ""}) {
    CAPTURE(line);
    CheckedLines lines_of_log{"evaluations.jsonl"};
    if (std::string(line).find("crc32") == std::string::npos)
      CHECK(lines_of_log.next(line) == line);
    else
      CHECK_THROWS_AS(lines_of_log.next(line), SpecError);
  }
}

TEST_CASE("a refused line is named with its file") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "log.jsonl";
  std::string text = log_text(identity, lines);
  text[text.find("1.25") + 2] = '3';
  put(file, text);
  CHECK_THROWS_WITH(opened(file), Contains("log.jsonl") && Contains("line 2: [0,1.35") &&
                                      Contains("remove the line"));
  CHECK_THROWS_WITH(read_log_lines(file), Contains("line 2"));
  CHECK(content_of(file) == text);
  // removing the line is what helps
  const std::size_t second = text.find('\n') + 1;
  put(file, text.substr(0, second) + text.substr(text.find('\n', second) + 1));
  CHECK(opened(file) == std::vector(lines.begin() + 1, lines.end()));
}

TEST_CASE("a log from before there were checksums is read, and then has them") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "log.jsonl";
  put(file, without_checksums());
  CHECK(read_log_lines(file) == lines);
  CHECK(log_identity_of(file) == identity);
  {
    std::vector<std::string> seen, again;
    LineLog log(file, identity, false, [&](const std::string& line) { seen.push_back(line); });
    CHECK(seen == lines);
    log.append("[8,9]\n");
    CHECK(content_of(file) == without_checksums() + with_checksum("[8,9]") + "\n");
    for (const std::string& line : read_log_lines(file)) again.push_back(line + "\n");
    REQUIRE(again.size() == lines.size() + 1);
    log.finish(again);
  }
  std::vector<std::string> more = lines;
  more.emplace_back("[8,9]");
  CHECK(content_of(file) == log_text(identity, more));
}

TEST_CASE("a line without checksum in a log that has them is refused") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "log.jsonl";
  put(file, log_text(identity, lines) + "[8,9]\n");
  CHECK_THROWS_WITH(opened(file), Contains("line 5"));
  put(file, log_text(identity, lines) + "\n");
  CHECK_THROWS_WITH(opened(file), Contains("line 5"));
}
