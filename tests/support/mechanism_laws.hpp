#pragma once
// Laws that every mechanism keeps, whatever it is made of. Each answers by how much it is broken,
// relative to the scale of what is compared.
#include <array>
#include <string>

#include "support/random_design.hpp"

namespace flexopt::laws {

struct Deviation {
  double size = 0;
  std::string what;     ///< the number that deviates most
  double rounding = 0;  ///< what rounding alone may make of it

  void add(double difference, double scale, const std::string& name);
};

/// What rounding comes to in series of soft leaves that are stiff along. The range that a reduced
/// leaf is fitted over is rounded, and with it its fit.
inline double known(const Deviation& d, bool reduced) { return (reduced ? 2e4 : 1e3) * d.rounding; }

/// Every second of beams, others of plates.
inline ModelOptions coarse(unsigned long long seed, bool reduced) {
  return {.accuracy = reduced ? Accuracy::reduced : Accuracy::full,
          .flexure = seed % 2 == 1 ? Flexure::beam : Flexure::plate,
          .mesh = seed % 2 == 1 ? std::array{3, 1} : std::array{2, 2}};
}

/// Moved and turned as a whole, mirrored before where `mirror` is an axis, drive, loads and payload
/// with it: every answer at rest and at a deflected state is the moved one. `seed`: of the motion.
/// Rounding: that of numbers over the condition of the tangent in units of its diagonal or, where
/// that does not tell, a hundredth of what its places and axes do that are rounded otherwise.
Deviation motion_of_the_whole(const RandomDesign& design, unsigned long long seed,
                              const std::string& mirror, const ModelOptions& model);

/// At a deflected state: the force is the gradient of the energy, the tangent its Hessian.
/// Rounding: a hundredth of that of the energy, over the step of the differences.
Deviation energy(const RandomDesign& design, unsigned long long seed, const ModelOptions& model);

/// Written flat, and with its repeats written out, it is the same mechanism to the last bit: 0
/// or 1.
Deviation ways_of_writing(const RandomDesign& design);

/// Exact derivatives of every number along every parameter, against differences.
Deviation derivatives(const RandomDesign& design);

}  // namespace flexopt::laws
