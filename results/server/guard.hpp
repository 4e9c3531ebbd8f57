#pragma once
// What comes in: the bytes of a request, and who may ask.
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace flexopt {

// The bytes of one HTTP request as they come in: whether it is whole, and what of it may go on to
// the HTTP library. What is not a plain request for this server is refused here.

inline constexpr std::size_t largest_head = 8192;   ///< request line and headers [bytes]
inline constexpr std::size_t largest_body = 65536;  ///< [bytes]

struct RequestText {
  enum class State { incomplete, whole, refused } state = State::incomplete;
  int status = 0;      ///< status of a refused request
  std::string reason;  ///< why a request is refused, a few words
  /// A whole request: request line, the headers that the server looks at, and the body.
  std::string text;
};

/// Looks at all bytes that have come so far. GET and POST in HTTP/1.0 or 1.1 alone, the body of a
/// length that is given once; nothing chunked, and nothing after the body. Refuses as soon as it
/// can: a body that is too large before it comes.
RequestText read_request(std::string_view bytes);

// Who may ask this server: the page that it gave out itself, and nobody else.

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
