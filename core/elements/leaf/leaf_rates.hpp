#pragma once
// Derivatives that equal leaves share, each made once in an evaluation.
#include <map>
#include <memory>
#include <typeindex>
#include <typeinfo>
#include <utility>

namespace flexopt {

/// A store that leaves fill themselves: every model of a leaf keeps there what it derives from the
/// data that it shares with others (a mesh, a reduced model), under these data.
class LeafRates {
 public:
  /// The T of `data`. Where there is none yet, `make()` makes it, as a T.
  template <class T, class Make>
  std::shared_ptr<const T> of(const std::shared_ptr<const void>& data, const Make& make) {
    std::shared_ptr<const void>& kept = kept_[{data, typeid(T)}];
    if (!kept) kept = std::make_shared<const T>(make());
    return std::static_pointer_cast<const T>(kept);
  }

 private:
  std::map<std::pair<std::shared_ptr<const void>, std::type_index>, std::shared_ptr<const void>>
      kept_;
};

}  // namespace flexopt
