#include "results/server/guard.hpp"

#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <cerrno>
#include <stdexcept>

namespace flexopt {

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

}  // namespace flexopt
