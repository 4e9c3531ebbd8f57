#pragma once
// Results of long work that is asked for again with the same numbers.
#include <algorithm>
#include <exception>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <vector>

#include "core/math/types.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// The exact bytes of what a result depends on.
class ContentKey {
 public:
  template <class T>
  void add(const T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&count), sizeof count);
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }
  void add(const std::vector<Vector3d>& places) {
    add(places.empty() ? nullptr : places.front().data(), 3 * places.size());
  }
  void add(const MatrixXd& a) { add(a.data(), static_cast<std::size_t>(a.size())); }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// What a condensed body depends on, cells apart: sizes, or their rates.
inline void add_sizes(const ElasticBody& body, ContentKey& key) {
  key.add(body.nodes);
  for (const ElasticInterface& i : body.interfaces) key.add(i.origin.data(), 3);
  const double material[] = {body.material.youngs_modulus, body.material.poissons_ratio,
                             body.material.density};
  key.add(material, 3);
}
/// All that it depends on.
inline void add_content(const ElasticBody& body, ContentKey& key) {
  add_sizes(body, key);
  key.add(&body.degree, 1);
  for (const ElasticInterface& i : body.interfaces) key.add(i.patch.data(), i.patch.size());
  if (body.imported) {
    key.add(body.imported->stiffness);
    key.add(body.imported->mass);
  } else {
    for (const SolidCells::Block& block : body.cells->blocks) {
      key.add(&block.cell, 1);
      key.add(block.nodes.data(), block.nodes.size());
    }
  }
}

/// Keeps the values that were asked for last, within a bound of memory. Thread-safe: a thread that
/// asks for what another one is making waits for it.
template <class Value>
class KeptByContent {
 public:
  using Kept = std::shared_ptr<const Value>;

  explicit KeptByContent(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  /// The value of this key; `make` returns one where there is none, `bytes_of` its memory. Where
  /// `make` throws, those who wait get the exception too, and nothing is kept.
  template <class Make, class BytesOf>
  Kept get(std::string key, Make&& make, BytesOf&& bytes_of) {
    std::promise<Kept> promise;
    {
      std::unique_lock lock(mutex_);
      const auto at = std::ranges::find(entries_, key, &Entry::key);
      if (at != entries_.end()) {
        entries_.splice(entries_.begin(), entries_, at);
        const std::shared_future<Kept> value = at->value;
        lock.unlock();
        return value.get();
      }
      entries_.push_front({key, promise.get_future().share(), 0});
    }
    try {
      const Kept value = make();
      promise.set_value(value);
      keep(key, bytes_of(*value) + key.size());
      return value;
    } catch (...) {
      promise.set_exception(std::current_exception());
      const std::lock_guard lock(mutex_);
      std::erase_if(entries_, [&](const Entry& e) { return e.key == key; });
      throw;
    }
  }

 private:
  struct Entry {
    std::string key;
    std::shared_future<Kept> value;
    std::size_t bytes;  ///< 0 while it is made
  };

  // Writes down what an entry takes, and drops those that were asked for longest ago.
  void keep(const std::string& key, std::size_t bytes) {
    std::list<Entry> dropped;  // freed without the mutex
    const std::lock_guard lock(mutex_);
    std::ranges::find(entries_, key, &Entry::key)->bytes = bytes;
    std::size_t all = 0;
    for (auto at = entries_.begin(); at != entries_.end();) {
      const auto here = at++;
      all += here->bytes;
      if (all > most_bytes_ && here->bytes > 0 && here != entries_.begin())
        dropped.splice(dropped.end(), entries_, here);
    }
  }

  std::size_t most_bytes_;
  std::mutex mutex_;
  std::list<Entry> entries_;  ///< the latest first
};

}  // namespace flexopt
