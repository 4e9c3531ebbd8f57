#include "core/response/path/misassembly.hpp"

#include <cmath>
#include <numbers>

namespace flexopt {

double misassembly(const Mechanism& mechanism, const LoadCase& loads) {
  constexpr double pi = std::numbers::pi;
  double sum = 0;
  for (const AssemblyError& error : loads.assembly) {
    const LeafSpring& leaf = mechanism.leaves[static_cast<std::size_t>(error.leaf)];
    const double t = leaf.thickness, w = leaf.width, L = leaf.length;
    const double turn =
        2 * pi * std::sqrt(2 / (1 + leaf.material.poissons_ratio)) * t * t / (w * w);
    sum += std::abs(error.turn.dot(leaf.axes.col(2))) / turn +
           6 * std::abs(error.move.dot(leaf.axes.col(1))) / (L * turn) +
           std::abs(error.move.dot(leaf.axes.col(0))) / (pi * pi * t * t / (3 * L));
  }
  return sum;
}

}  // namespace flexopt
