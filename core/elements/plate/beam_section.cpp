#include "core/elements/plate/beam_section.hpp"

#include <cmath>

namespace flexopt {

double warping_length(const BeamSection& s, double nu) {
  return std::sqrt(s.C_w / (shear_ratio(nu) * s.J));
}

}  // namespace flexopt
