#pragma once
// Who may ask this server: the page that it gave out itself, and nobody else.
#include <optional>
#include <string>
#include <string_view>

namespace flexopt {

/// 32 hexadecimal digits from the system's random numbers.
std::string random_token();

/// Compares in a time that does not depend on where the texts differ.
bool is_same_secret(std::string_view a, std::string_view b);

/// What a request says of where it comes from; empty where it says nothing.
struct RequestOrigin {
  std::string host, origin, token;
};

struct Refusal {
  int status = 403;
  std::string reason;  ///< a sentence for the user, if it is one
};

/// Refuses another host's name (a foreign name that was made to point here), another origin than
/// the server's own (a foreign page), and a wrong token.
std::optional<Refusal> refusal(const RequestOrigin& asked, int port, std::string_view token);

}  // namespace flexopt
