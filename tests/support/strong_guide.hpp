#pragma once
// A guide of strong steel, whose stresses have strengths to be compared with.
#include <array>
#include <utility>

#include "support/models.hpp"

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

/// Few elements: what is compared is one mesh with itself.
inline ModelOptions coarse(Flexure flexure, Accuracy accuracy = Accuracy::full) {
  ModelOptions model;
  model.accuracy = accuracy;
  model.flexure = flexure;
  model.mesh = flexure == Flexure::plate ? std::array{6, 2} : std::array{8, 1};
  return model;
}

}  // namespace flexopt::models
