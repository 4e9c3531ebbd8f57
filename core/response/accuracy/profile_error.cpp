#include "core/response/accuracy/profile_error.hpp"

#include <algorithm>

#include "core/mechanism/profile.hpp"

namespace flexopt {
namespace {

ProfileError error_of(const LeafSpring& leaf) {
  constexpr int samples = 10 * profile_pieces;
  double bent = 0, steep_bent = 0, stretched = 0, steep_stretched = 0;
  for (int k = 0; k < samples; ++k) {
    const double s = (k + 0.5) / samples, t = profile_at(leaf.thickness_profile, s),
                 tangent =
                     0.5 * leaf.thickness / leaf.length * profile_at(leaf.thickness_profile, s, 1),
                 share = tangent * tangent / (1 + tangent * tangent), of_bending = 1 / (t * t * t);
    bent += of_bending;
    steep_bent += share * of_bending;
    stretched += 1 / t;
    steep_stretched += share / t;
  }
  return {1.45 * steep_bent / bent, 2 * steep_stretched / stretched};
}

}  // namespace

ProfileError profile_error(const Mechanism& mechanism) {
  ProfileError largest;
  for (const LeafSpring& leaf : mechanism.leaves) {
    if (leaf.thickness_profile.empty()) continue;
    const ProfileError own = error_of(leaf);
    largest.bending = std::max(largest.bending, own.bending);
    largest.support = std::max(largest.support, own.support);
  }
  return largest;
}

}  // namespace flexopt
