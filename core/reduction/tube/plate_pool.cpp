#include "core/reduction/tube/plate_pool.hpp"

#include <algorithm>

namespace flexopt {

ChordLeaf& PlatePool::chord() {
  if (!chord_) chord_ = std::make_unique<ChordLeaf>(mesh_);
  return *chord_;
}

PlateLeaf* PlatePool::find(std::uint64_t state) {
  const auto place = std::ranges::find(places_, state, &Place::state);
  if (place == places_.end()) return nullptr;
  places_.splice(places_.begin(), places_, place);
  return &place->plate;
}

PlateLeaf& PlatePool::take(std::uint64_t state) {
  if (places_.size() < most)
    places_.push_front({state, PlateLeaf(mesh_)});
  else
    places_.splice(places_.begin(), places_, std::prev(places_.end()));
  places_.front().state = state;
  return places_.front().plate;
}

}  // namespace flexopt
