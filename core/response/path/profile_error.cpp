#include "core/response/path/error_estimate.hpp"

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
  const double of_bent = steep_bent / bent, of_stretched = steep_stretched / stretched;
  return {1.45 * of_bent, 2.6 * of_stretched, std::max(2.6 * of_stretched, 10 * of_bent)};
}

}  // namespace

ProfileError profile_error(const Mechanism& mechanism) {
  ProfileError largest;
  for (const LeafSpring& leaf : mechanism.leaves) {
    if (leaf.thickness_profile.empty()) continue;
    const ProfileError own = error_of(leaf);
    largest.bending = std::max(largest.bending, own.bending);
    largest.translation = std::max(largest.translation, own.translation);
    largest.rotation = std::max(largest.rotation, own.rotation);
  }
  return largest;
}

double narrow_plate_error(const Mechanism& mechanism, const ModelOptions& model) {
  double largest = 0;
  for (const LeafSpring& leaf : mechanism.leaves) {
    if (flexure_of(leaf, model) != Flexure::plate) continue;
    const double nu = leaf.material.poissons_ratio, square = nu * nu,
                 ratio = leaf.thickness * profile_mean(leaf.thickness_profile) /
                         (leaf.width * profile_mean(leaf.width_profile)),
                 r = ratio * ratio;
    largest =
        std::max(largest, 0.7 * (3 - 2 * nu + 3 * square) / (1 - square) * std::max(r - 0.25, 0.0) +
                              (0.012 + 1.15 * square) * r * r);
  }
  return largest;
}

}  // namespace flexopt
