#pragma once
// A part of an atlas: bytes that are stored deflated and inflated when they are first asked for.
#include <memory>
#include <string>
#include <string_view>

namespace flexopt {

/// Shared by its copies and by threads.
class AtlasPart {
 public:
  explicit AtlasPart(std::string bytes);
  /// `deflated` is kept alive by `owner`; `size`: of its bytes.
  AtlasPart(std::string_view deflated, std::size_t size, std::shared_ptr<const void> owner);

  std::size_t size() const;
  std::string_view bytes() const;
  std::string deflated() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace flexopt
