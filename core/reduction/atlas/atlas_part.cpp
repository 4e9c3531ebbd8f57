#include "core/reduction/atlas/atlas_part.hpp"

#include <zlib.h>

#include <cassert>
#include <mutex>
#include <utility>

namespace flexopt {

struct AtlasPart::State {
  std::string_view deflated;
  std::shared_ptr<const void> owner;
  std::size_t size = 0;
  std::once_flag inflated;
  std::string bytes;
};

AtlasPart::AtlasPart(std::string bytes) : state_(std::make_shared<State>()) {
  state_->size = bytes.size();
  std::call_once(state_->inflated, [&] { state_->bytes = std::move(bytes); });
}

AtlasPart::AtlasPart(std::string_view deflated, std::size_t size, std::shared_ptr<const void> owner)
    : state_(std::make_shared<State>()) {
  state_->deflated = deflated;
  state_->size = size;
  state_->owner = std::move(owner);
}

std::size_t AtlasPart::size() const { return state_->size; }

std::string_view AtlasPart::bytes() const {
  std::call_once(state_->inflated, [&] {
    std::string bytes(state_->size, '\0');
    uLongf size = bytes.size();
    [[maybe_unused]] const int code = ::uncompress(
        reinterpret_cast<Bytef*>(bytes.data()), &size,
        reinterpret_cast<const Bytef*>(state_->deflated.data()), state_->deflated.size());
    assert(code == Z_OK && size == bytes.size());  // the contents of the file have their hash
    state_->bytes = std::move(bytes);
  });
  return state_->bytes;
}

std::string AtlasPart::deflated() const {
  const std::string_view from = bytes();
  uLongf size = ::compressBound(from.size());
  std::string to(size, '\0');
  [[maybe_unused]] const int code =
      ::compress2(reinterpret_cast<Bytef*>(to.data()), &size,
                  reinterpret_cast<const Bytef*>(from.data()), from.size(), Z_BEST_COMPRESSION);
  assert(code == Z_OK);
  to.resize(size);
  return to;
}

}  // namespace flexopt
