#include "core/math/eigen_layout.hpp"

namespace flexopt {

template <>
const char EigenLayout::as_the_library_is = 0;

}  // namespace flexopt
