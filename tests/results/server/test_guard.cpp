#include <set>

#include "results/server/guard.hpp"
#include "tests/results/results_tests.hpp"

namespace {

constexpr int port = 4242;
const std::string token = "0123456789abcdef0123456789abcdef";

int status_of(const RequestOrigin& asked) {
  const auto refused = refusal(asked, port, token);
  return refused ? refused->status : 200;
}

}  // namespace

TEST_CASE("Tokens are 128 bits that do not come again") {
  std::set<std::string> seen;
  for (int i = 0; i < 100; ++i) {
    const std::string one = random_token();
    CHECK(one.size() == 32);
    CHECK(one.find_first_not_of("0123456789abcdef") == std::string::npos);
    seen.insert(one);
  }
  CHECK(seen.size() == 100);
}

TEST_CASE("A secret is the same in every letter, or another one") {
  CHECK(is_same_secret(token, token));
  CHECK(is_same_secret("", ""));
  for (std::size_t i = 0; i < token.size(); ++i) {
    std::string other = token;
    other[i] = 'x';
    CHECK_FALSE(is_same_secret(token, other));
  }
  CHECK_FALSE(is_same_secret(token, token + "0"));
  CHECK_FALSE(is_same_secret(token, token.substr(1)));
  CHECK_FALSE(is_same_secret(token, ""));
}

TEST_CASE("Only the page that the server gave out may ask") {
  CHECK(status_of({"127.0.0.1:4242", "", token}) == 200);
  CHECK(status_of({"localhost:4242", "http://localhost:4242", token}) == 200);
  CHECK(status_of({"127.0.0.1:4242", "http://127.0.0.1:4242", token}) == 200);
  for (const char* host : {"", "127.0.0.1", "127.0.0.1:4243", "evil.example:4242", "[::1]:4242",
                           "127.0.0.1:4242.evil.example", "127.0.0.1:42420"})
    CHECK(status_of({host, "", token}) == 421);
  for (const char* origin :
       {"null", "https://127.0.0.1:4242", "http://127.0.0.1:4243", "http://evil.example"})
    CHECK(status_of({"127.0.0.1:4242", origin, token}) == 403);
  CHECK(status_of({"127.0.0.1:4242", "", ""}) == 403);
  CHECK(status_of({"127.0.0.1:4242", "", token + "0"}) == 403);
}
