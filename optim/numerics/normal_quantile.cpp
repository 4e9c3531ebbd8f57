#include <boost/math/special_functions/erf.hpp>
#include <cassert>
#include <numbers>

#include "optim/numerics/unit_points.hpp"

namespace flexopt {

double normal_quantile(double u) {
  assert(u > 0 && u < 1);
  return -std::numbers::sqrt2 * boost::math::erfc_inv(2 * u);
}

}  // namespace flexopt
