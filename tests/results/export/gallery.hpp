#pragma once
// Jobs of the gallery as they are exported.
#include <array>
#include <numbers>
#include <string>
#include <vector>

#include "core/mechanism/profile.hpp"
#include "results/export/exported.hpp"

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

inline Job gallery_job(const std::string& name, const std::vector<std::string>& overrides = {}) {
  return read_job(std::string(FLEXOPT_SOURCE_DIR) + "/designs/jobs/" + name + ".json", overrides);
}

/// A leaf with an elastic fold at a right angle.
inline Exported folded_leaf(const std::vector<std::string>& at = {}) {
  return make_exported(gallery_job("folded_leaf", {"/design/fold=\"elastic\""}),
                       {.at = at, .result = {}, .load_case = ""});
}

inline Exported gallery(const std::string& name, const std::vector<std::string>& at = {}) {
  return make_exported(gallery_job(name), {.at = at, .result = {}, .load_case = ""});
}

}  // namespace flexopt::test
