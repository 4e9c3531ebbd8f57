#include "core/elements/plate/leaf_validity.hpp"

#include <algorithm>
#include <cmath>

#include "core/elements/plate/beam_section.hpp"
#include "core/mechanism/profile.hpp"

namespace flexopt {

LeafValidity leaf_validity(const LeafSpring& leaf) {
  const double L = leaf.length, w = leaf.width * profile_mean(leaf.width_profile),
               t = leaf.thickness * profile_mean(leaf.thickness_profile),
               nu = leaf.material.poissons_ratio;
  LeafValidity v;
  v.aspect = L / w;
  v.flatness = w * w / (L * t);
  if (leaf.section == Section::circular) {
    v.needed = "beam";
    return v;
  }
  v.warping_length = warping_length(beam_section(Section::rectangular, w, t, nu), nu);
  // torsion lost without the clamps' restraint of warping, and what bending makes of it
  const double lost = 2 * v.warping_length / L * std::tanh(0.5 * L / v.warping_length);
  // fitted to measured differences, see beams.md
  v.beam_drive = nu * nu / (1 + 0.25 * v.aspect);
  v.beam = std::max(v.beam_drive, 0.02 + 0.15 * v.flatness / (v.flatness + 25));
  v.beam_free_warping = std::max(v.beam, 1 - std::pow(1 - lost, 4));
  // (E9) as far as it goes, and what the clamps make of it
  const double ratio = t / w, counted = std::min(ratio, 0.5);
  if (nu <= 0.5)
    v.plate = 0.1 * ratio * ratio +
              (3 - 2 * nu + 3 * nu * nu) / (1 - nu * nu) * (ratio * ratio - counted * counted);
  if (v.beam_free_warping <= LeafValidity::accepted)
    v.needed = "beam";
  else if (v.beam <= LeafValidity::accepted || !v.plate || v.beam < *v.plate)
    v.needed = "beam_with_warping";
  else
    v.needed = "plate";
  return v;
}

}  // namespace flexopt
