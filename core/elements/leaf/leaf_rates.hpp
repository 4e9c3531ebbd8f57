#pragma once
// Derivatives that equal leaves share, each made once in an evaluation.
#include <compare>
#include <cstddef>
#include <map>
#include <memory>
#include <typeindex>
#include <typeinfo>
#include <utility>
#include <vector>

#include "core/math/types.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Parameters of a leaf's shape, in this order: the sizes that every leaf has, over its length
/// where they are lengths; then the directions of its profiles and of its arc (ProfileDirections).
struct ShapeParameter {
  static constexpr int width = 0, thickness = 1, poissons_ratio = 2, sizes = 3;
};

/// Derivatives of the factors of a leaf's profiles along one direction, as many as there are
/// factors or none where they are constant, of the angle of its arc, and of its fold. Also these
/// themselves.
struct ProfileRate {
  std::vector<double> width_profile{}, thickness_profile{};
  double curve = 0;
  LeafFold fold{};
  auto operator<=>(const ProfileRate&) const = default;
};

/// The different directions in which design parameters change the profiles and the arcs of equal
/// leaves.
class ProfileDirections {
 public:
  ProfileDirections() = default;
  /// `directions`: derivative of every number of the mechanism along each parameter.
  ProfileDirections(const Mechanism& mechanism, const std::vector<Mechanism>& directions);

  /// Derivatives for leaves that have these profiles up to rounding; such leaves share what is
  /// derived from a shape.
  const std::vector<ProfileRate>& of(const ProfileRate& profiles) const;
  /// Coordinates of a leaf's change along one of the parameters: 1 for its direction.
  VectorXd coordinates(const LeafSpring& leaf, const LeafSpring& direction) const;

 private:
  struct Leaves {
    ProfileRate profiles;
    std::vector<ProfileRate> directions;
  };
  /// Index of these profiles in leaves_; its size where they are not listed.
  std::size_t find(const ProfileRate& profiles) const;
  std::vector<Leaves> leaves_;
};

/// A store that leaves fill themselves: every model of a leaf keeps there what it derives from the
/// data that it shares with others (a mesh, a reduced model), under these data.
class LeafRates {
 public:
  LeafRates() = default;
  explicit LeafRates(ProfileDirections profiles) : profiles_(std::move(profiles)) {}
  const ProfileDirections& profiles() const { return profiles_; }

  /// The T that belongs to `data`. Where there is none yet, `make()` makes it.
  template <class T, class Make>
  std::shared_ptr<const T> of(const std::shared_ptr<const void>& data, const Make& make) {
    std::shared_ptr<const void>& kept = kept_[{data, typeid(T)}];
    if (!kept) kept = std::make_shared<const T>(make());
    return std::static_pointer_cast<const T>(kept);
  }

 private:
  ProfileDirections profiles_;
  std::map<std::pair<std::shared_ptr<const void>, std::type_index>, std::shared_ptr<const void>>
      kept_;
};

}  // namespace flexopt
