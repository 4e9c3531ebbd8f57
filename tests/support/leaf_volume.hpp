#pragma once
// The volume of a leaf by quadrature: independent of the meshes and solids made of it.
#include <array>
#include <numbers>

#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/profile.hpp"

namespace flexopt::test {

/// Volume of the leaf [m³]; of a fold with its mitre.
inline double leaf_volume(const LeafSpring& leaf) {
  // Gauss points of each piece of a profile, which is a polynomial there.
  constexpr int points = 8, pieces = profile_pieces;
  constexpr std::array<double, 4> place{0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                        0.9602898564975363};
  constexpr std::array<double, 4> weight{0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                         0.1012285362903763};
  double volume = 0;
  for (int p = 0; p < pieces; ++p)
    for (int k = 0; k < points; ++k) {
      const double s = (p + 0.5 + (k < 4 ? 0.5 : -0.5) * place[k % 4]) / pieces;
      const double w = leaf.width * profile_at(leaf.width_profile, s),
                   t = leaf.thickness * profile_at(leaf.thickness_profile, s);
      const double area = leaf.section == Section::circular ? std::numbers::pi / 4 * w * w : w * t;
      volume += 0.5 * weight[k % 4] / pieces * area;
    }
  return volume * leaf.length;
}

}  // namespace flexopt::test
