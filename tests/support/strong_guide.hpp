#pragma once
// A guide of strong steel, whose stresses have strengths to be compared with.
#include <utility>
#include <vector>

#include "support/models.hpp"
#include "support/strokes.hpp"

namespace flexopt::models {

inline Material strong_steel(SnCurve curve) {
  Material m = steel();
  m.yield_strength = 1400e6;
  m.ultimate_strength = 1700e6;
  m.endurance_limit = 500e6;
  m.s_n_curve = std::move(curve);
  return m;
}

inline Mechanism strong_guide(const Material& material, double thickness = 0.5e-3) {
  Mechanism m = guide(0.1, 0.03, thickness);
  for (LeafSpring& leaf : m.leaves) leaf.material = material;
  return m;
}

/// By length, width, thickness and modulus, its first leaf thicker: that one decides.
inline Mechanism uneven_guide(const std::vector<double>& p, const Material& material) {
  Mechanism m = guide(p[0], p[1], p[2]);
  for (LeafSpring& leaf : m.leaves) {
    leaf.material = material;
    leaf.material.youngs_modulus = p[3];
  }
  m.leaves[0].thickness *= 1.1;
  return m;
}

/// Plates reduced by every method that knows stresses.
inline std::vector<ModelOptions> reduced_plates() {
  std::vector<ModelOptions> all(3, coarse(Flexure::plate, Accuracy::reduced));
  all[1].method = Reduction::modal_derivatives;
  all[2].method = Reduction::linear_craig_bampton;
  all[2].superelements = {8, 0};
  return all;
}

}  // namespace flexopt::models
