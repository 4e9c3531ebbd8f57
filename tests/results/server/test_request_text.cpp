#include "results/server/guard.hpp"
#include "tests/results/results_tests.hpp"

using State = RequestText::State;

namespace {

int status_of(const std::string& bytes) {
  const RequestText request = read_request(bytes);
  REQUIRE(request.state == State::refused);
  CHECK(!request.reason.empty());
  CHECK(request.text.empty());
  return request.status;
}

std::string with_headers(const std::string& headers) {
  return "POST /job HTTP/1.1\r\nHost: here\r\n" + headers + "\r\n";
}

}  // namespace

TEST_CASE("A request is whole at its last byte, not before") {
  const std::string bytes = "POST /job HTTP/1.1\r\nHost: here\r\nContent-Length: 4\r\n\r\n{\"\"}";
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    CAPTURE(n);
    CHECK(read_request(bytes.substr(0, n)).state == State::incomplete);
  }
  const RequestText whole = read_request(bytes);
  REQUIRE(whole.state == State::whole);
  CHECK(whole.text == "POST /job HTTP/1.1\r\nhost: here\r\ncontent-length: 4\r\n\r\n{\"\"}");
  CHECK(status_of(bytes + "x") == 400);
  CHECK(read_request("GET / HTTP/1.0\r\n\r\n").state == State::whole);
}

TEST_CASE("Headers that the server does not look at go no further") {
  const RequestText whole = read_request(
      "GET /?token=1 HTTP/1.1\r\nHost: here\r\nRange: bytes=0-,0-\r\nAccept-Encoding: gzip\r\n"
      "Expect: 100-continue\r\nCookie: a\r\nORIGIN:  http://x \r\nX-Flexopt-Token:\tabc\r\n\r\n");
  REQUIRE(whole.state == State::whole);
  CHECK(whole.text ==
        "GET /?token=1 HTTP/1.1\r\nhost: here\r\norigin: http://x\r\nx-flexopt-token: abc\r\n\r\n");
}

TEST_CASE("A body too large is refused before it comes") {
  CHECK(status_of(with_headers("Content-Length: 1000000000\r\n")) == 413);
  CHECK(status_of(with_headers("Content-Length: " + std::to_string(largest_body + 1) + "\r\n")) ==
        413);
  CHECK(read_request(with_headers("Content-Length: " + std::to_string(largest_body) + "\r\n"))
            .state == State::incomplete);
  for (const char* length :
       {"-1", "1e3", "0x10", " ", "+4", "4,4", "99999999999999999999", "4 4"}) {
    CAPTURE(length);
    CHECK(status_of(with_headers(std::string("Content-Length: ") + length + "\r\n")) == 400);
  }
  CHECK(status_of(with_headers("Content-Length: 2\r\ncontent-length: 2\r\n")) == 400);
  CHECK(status_of(with_headers("")) == 411);
  CHECK(status_of(with_headers("Transfer-Encoding: chunked\r\n")) == 501);
  CHECK(status_of(with_headers("Content-Length: 2\r\nTransfer-Encoding: chunked\r\n")) == 501);
  CHECK(status_of("GET / HTTP/1.1\r\nContent-Length: 5\r\n\r\n") == 400);
}

TEST_CASE("What is no plain request is refused as soon as that is seen") {
  CHECK(status_of("PUT / HTTP/1.1\r\n") == 405);
  CHECK(status_of("get / HTTP/1.1\r\n") == 405);
  CHECK(status_of("GET / HTTP/2.0\r\n") == 505);
  CHECK(status_of("GET http://elsewhere/ HTTP/1.1\r\n") == 400);
  CHECK(status_of("GET  / HTTP/1.1\r\n") == 400);
  CHECK(status_of("GET /a b HTTP/1.1\r\n") == 400);
  CHECK(status_of("\r\n\r\n") == 400);
  CHECK(status_of(std::string("GET /\0 HTTP/1.1\r\n", 17)) == 400);
  CHECK(status_of("GET / HTTP/1.1\r\nno header\r\n\r\n") == 400);
  CHECK(status_of("GET / HTTP/1.1\r\nHost : here\r\n\r\n") == 400);
  CHECK(status_of("GET / HTTP/1.1\r\nHost: a\nb: c\r\n\r\n") == 400);
  CHECK(status_of("GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n") == 400);
  CHECK(status_of("GET /" + std::string(3000, 'x')) == 414);
  CHECK(status_of("GET / HTTP/1.1\r\nX: " + std::string(largest_head, 'x')) == 431);
}
