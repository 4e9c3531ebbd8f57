#pragma once
// The bytes of one HTTP request as they come in: whether it is whole, and what of it may go on to
// the HTTP library. What is not a plain request for this server is refused here.
#include <cstddef>
#include <string>
#include <string_view>

namespace flexopt {

inline constexpr std::size_t largest_head = 8192;   ///< request line and headers [bytes]
inline constexpr std::size_t largest_body = 65536;  ///< [bytes]

struct RequestText {
  enum class State { incomplete, whole, refused } state = State::incomplete;
  int status = 0;      ///< of a refused one
  std::string reason;  ///< of a refused one, a few words
  /// A whole request: request line, the headers that the server looks at, and the body.
  std::string text;
};

/// Looks at all bytes that have come so far. GET and POST in HTTP/1.0 or 1.1 alone, the body of a
/// length that is given once; nothing chunked, and nothing after the body. Refuses as soon as it
/// can: a body that is too large before it comes.
RequestText read_request(std::string_view bytes);

}  // namespace flexopt
