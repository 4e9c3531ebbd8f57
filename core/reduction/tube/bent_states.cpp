#include "core/reduction/tube/bent_states.hpp"

#include <algorithm>
#include <cmath>

namespace flexopt {

double bend(ChordLeaf& leaf, const Eigen::Vector2d& ray, double from, double to) {
  constexpr int most_halvings = 6;
  const Vector3d f = leaf.forces();
  const double smallest = std::abs(to - from) / (1 << most_halvings);
  double at = from, step = to - from;
  while (at != to) {
    const Vector3d s = leaf.soft();
    const VectorXd unknowns = leaf.unknowns();
    const double next = std::abs(step) >= std::abs(to - at) ? to : at + step;
    if (leaf.solve({ray[0] * next, ray[1] * next, 0}, f).converged &&
        leaf.plate().negative_pivots() == 0) {
      at = next;
      continue;
    }
    leaf.stand_at(s, f, unknowns);
    step *= 0.5;
    if (std::abs(step) < smallest) break;
  }
  return at;
}

}  // namespace flexopt
