#pragma once
// Full leaves that the reduced ones of a mechanism borrow: a full leaf with its factor takes a
// megabyte, which hundreds of reduced leaves need not each have.
#include <algorithm>
#include <cstdint>
#include <list>
#include <memory>

#include "core/reduction/expansion/tube_expansion.hpp"

namespace flexopt {

/// Working copies of a plate of one mesh. Not for several threads at once.
class PlatePool {
 public:
  explicit PlatePool(std::shared_ptr<const PlateMesh> mesh) : mesh_(std::move(mesh)) {}

  /// Plate for expansions, in the state in which its last borrower left it.
  ChordLeaf& chord() {
    if (!chord_) chord_ = std::make_unique<ChordLeaf>(mesh_);
    return *chord_;
  }

  /// A new number that identifies a state of a leaf.
  std::uint64_t new_state() { return ++last_state_; }
  /// The full leaf that was condensed at this state; null where it has been overwritten.
  PlateLeaf* find(std::uint64_t state) {
    const auto place = std::ranges::find(places_, state, &Place::state);
    if (place == places_.end()) return nullptr;
    places_.splice(places_.begin(), places_, place);
    return &place->plate;
  }
  /// A full leaf to be condensed at this state; of `most`, the one that was not used for longest.
  PlateLeaf& take(std::uint64_t state) {
    if (places_.size() < most)
      places_.push_front({state, PlateLeaf(mesh_)});
    else
      places_.splice(places_.begin(), places_, std::prev(places_.end()));
    places_.front().state = state;
    return places_.front().plate;
  }

 private:
  static constexpr std::size_t most = 8;
  struct Place {
    std::uint64_t state;
    PlateLeaf plate;
  };
  std::shared_ptr<const PlateMesh> mesh_;
  std::unique_ptr<ChordLeaf> chord_;
  std::list<Place> places_;  ///< the last used first
  std::uint64_t last_state_ = 0;
};

}  // namespace flexopt
