#include "results/server/guard.hpp"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <stdexcept>
#include <vector>

namespace flexopt {

namespace {

constexpr std::size_t longest_line = 2048;  // the request line
constexpr std::size_t most_digits = 15;     // digits of a length that is read at all

RequestText refused(int status, std::string reason) {
  return {RequestText::State::refused, status, std::move(reason), {}};
}

std::string lower(std::string_view text) {
  std::string made(text);
  std::ranges::transform(made, made.begin(), [](unsigned char c) { return std::tolower(c); });
  return made;
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// Letters that a request line or a header may have: no control characters.
bool is_plain(std::string_view text) {
  return std::ranges::all_of(text,
                             [](unsigned char c) { return c == '\t' || (c >= 32 && c != 127); });
}

struct Header {
  std::string name;  ///< in small letters
  std::string_view value;
};

/// Headers of a request; nothing where a line is no header.
std::optional<std::vector<Header>> headers_of(std::string_view lines) {
  std::vector<Header> headers;
  while (!lines.empty()) {
    const std::size_t end = lines.find("\r\n");
    const std::string_view line = lines.substr(0, end);
    lines.remove_prefix(end == std::string_view::npos ? lines.size() : end + 2);
    const std::size_t colon = line.find(':');
    if (colon == 0 || colon == std::string_view::npos || !is_plain(line)) return std::nullopt;
    if (line.substr(0, colon).find_first_of(" \t") != std::string_view::npos) return std::nullopt;
    headers.push_back({lower(line.substr(0, colon)), trimmed(line.substr(colon + 1))});
  }
  return headers;
}

bool is_number(std::string_view text) {
  return !text.empty() && text.size() <= most_digits &&
         std::ranges::all_of(text, [](unsigned char c) { return c >= '0' && c <= '9'; });
}

/// What is wrong with "GET /path HTTP/1.1".
std::optional<RequestText> wrong_line(std::string_view line) {
  if (line.size() > longest_line) return refused(414, "the address is too long");
  const std::size_t first = line.find(' '), last = line.rfind(' ');
  if (!is_plain(line) || first == std::string_view::npos || first == last ||
      line.find(' ', first + 1) != last)
    return refused(400, "no request line");
  const std::string_view method = line.substr(0, first), version = line.substr(last + 1);
  if (version != "HTTP/1.1" && version != "HTTP/1.0") return refused(505, "expected HTTP/1.1");
  if (method != "GET" && method != "POST") return refused(405, "expected GET or POST");
  if (line[first + 1] != '/') return refused(400, "expected a path of this server");
  return std::nullopt;
}

}  // namespace

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  std::size_t got = 0;
  while (got < bytes.size()) {
    const ssize_t more = ::getrandom(bytes.data() + got, bytes.size() - got, 0);
    if (more < 0 && errno != EINTR) throw std::runtime_error("the system has no random numbers");
    if (more > 0) got += static_cast<std::size_t>(more);
  }
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

bool is_same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;  // the length is no secret
  unsigned char difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference = static_cast<unsigned char>(difference | (a[i] ^ b[i]));
  volatile unsigned char kept = difference;  // keeps the compiler from stopping early
  return kept == 0;
}

std::optional<Refusal> refusal(const RequestOrigin& asked, int port, std::string_view token) {
  const auto is_here = [&](const std::string& name, const char* before) {
    return name == fmt::format("{}127.0.0.1:{}", before, port) ||
           name == fmt::format("{}localhost:{}", before, port);
  };
  if (!is_here(asked.host, "")) return Refusal{421, "this server answers for 127.0.0.1 alone"};
  if (!asked.origin.empty() && !is_here(asked.origin, "http://"))
    return Refusal{403, "another page may not ask this server"};
  if (!is_same_secret(asked.token, token))
    return Refusal{403, "the token is wrong or missing: open the address that flexopt printed"};
  return std::nullopt;
}

RequestText read_request(std::string_view bytes) {
  const std::size_t end = bytes.find("\r\n\r\n");
  if (std::min(end, bytes.size()) > largest_head) return refused(431, "the headers are too long");
  const std::size_t line_end = bytes.find("\r\n");
  const std::string_view line = bytes.substr(0, line_end);
  if (line_end == std::string_view::npos && line.size() > longest_line)
    return refused(414, "the address is too long");
  if (line_end != std::string_view::npos)
    if (auto wrong = wrong_line(line)) return *wrong;
  if (end == std::string_view::npos) return {};

  const auto headers = headers_of(end == line_end ? std::string_view()
                                                  : bytes.substr(line_end + 2, end - line_end - 2));
  if (!headers) return refused(400, "no headers");
  constexpr std::array kept{"host", "origin", "x-flexopt-token", "content-length"};
  RequestText request;
  request.text = std::string(line) + "\r\n";
  for (const Header& header : *headers) {
    if (header.name == "transfer-encoding") return refused(501, "expected a body of given length");
    const auto is_same = [&](const Header& other) { return other.name == header.name; };
    if (std::ranges::find(kept, header.name) == kept.end()) continue;
    if (std::ranges::count_if(*headers, is_same) > 1)
      return refused(400, "the header " + header.name + " stands twice");
    request.text += header.name + ": " + std::string(header.value) + "\r\n";
  }
  const auto length = std::ranges::find(*headers, "content-length", &Header::name);
  const bool posts = line.starts_with("POST");
  if (length == headers->end() && posts) return refused(411, "expected a body of given length");
  std::size_t body = 0;
  if (length != headers->end()) {
    if (!is_number(length->value)) return refused(400, "the length of the body is no number");
    body = std::stoull(std::string(length->value));
  }
  if (body > largest_body) return refused(413, "the body is too large");
  if (!posts && body > 0) return refused(400, "GET has no body");
  const std::string_view rest = bytes.substr(end + 4);
  if (rest.size() > body) return refused(400, "one request at a time");
  if (rest.size() < body) return {};
  request.text += "\r\n" + std::string(rest);
  request.state = RequestText::State::whole;
  return request;
}

}  // namespace flexopt
