#include "core/elements/leaf/leaf_rates.hpp"

#include <algorithm>

#include "core/math/alike.hpp"

namespace flexopt {
namespace {

ProfileRate rate_of(const LeafSpring& direction) {
  const auto changes = [](const std::vector<double>& factors) {
    return std::any_of(factors.begin(), factors.end(), [](double x) { return x != 0; });
  };
  ProfileRate rate;
  if (changes(direction.width_profile)) rate.width_profile = direction.width_profile;
  if (changes(direction.thickness_profile)) rate.thickness_profile = direction.thickness_profile;
  rate.curve = direction.curve.value_or(0);
  rate.fold = direction.fold.value_or(LeafFold{});
  return rate;
}

bool is_shaped(const LeafSpring& leaf) { return leaf.has_profile() || leaf.curve || leaf.fold; }

ProfileRate profiles_of(const LeafSpring& leaf) {
  return {leaf.width_profile, leaf.thickness_profile, leaf.curve.value_or(0),
          leaf.fold.value_or(LeafFold{})};
}

}  // namespace

ProfileDirections::ProfileDirections(const Mechanism& mechanism,
                                     const std::vector<Mechanism>& directions) {
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    const LeafSpring& leaf = mechanism.leaves[i];
    if (!is_shaped(leaf)) continue;
    const ProfileRate profiles = profiles_of(leaf);
    const std::size_t place = find(profiles);
    if (place == leaves_.size()) leaves_.push_back({profiles, {}});
    std::vector<ProfileRate>& own = leaves_[place].directions;
    for (const Mechanism& direction : directions) {
      ProfileRate rate = rate_of(direction.leaves[i]);
      if (rate != ProfileRate{} && std::find(own.begin(), own.end(), rate) == own.end())
        own.push_back(std::move(rate));
    }
  }
}

std::size_t ProfileDirections::find(const ProfileRate& profiles) const {
  const auto same = [&](const Leaves& known) {
    const ProfileRate& of = known.profiles;
    return of.width_profile == profiles.width_profile &&
           of.thickness_profile == profiles.thickness_profile && alike(of.curve, profiles.curve) &&
           alike(of.fold.place, profiles.fold.place) && alike(of.fold.angle, profiles.fold.angle) &&
           alike(of.fold.radius, profiles.fold.radius);
  };
  return static_cast<std::size_t>(std::ranges::find_if(leaves_, same) - leaves_.begin());
}

const std::vector<ProfileRate>& ProfileDirections::of(const ProfileRate& profiles) const {
  static const std::vector<ProfileRate> none;
  const std::size_t place = find(profiles);
  return place < leaves_.size() ? leaves_[place].directions : none;
}

VectorXd ProfileDirections::coordinates(const LeafSpring& leaf, const LeafSpring& direction) const {
  if (!is_shaped(leaf)) return {};
  const std::vector<ProfileRate>& own = of(profiles_of(leaf));
  VectorXd along = VectorXd::Zero(static_cast<Eigen::Index>(own.size()));
  const auto found = std::find(own.begin(), own.end(), rate_of(direction));
  if (found != own.end()) along[found - own.begin()] = 1;
  return along;
}

}  // namespace flexopt
