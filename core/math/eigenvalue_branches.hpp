#pragma once
// Derivatives of eigenvalues that are equal but for rounding.
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// `blocks[p]`: VᵀA′V of the rate A′ of a symmetric matrix along parameter p, V an orthonormal
/// basis of the eigenvalues' common space; size × size, at least one block. Row k, column p: the
/// derivative of branch k along parameter p, the diagonal of the blocks in the basis that makes
/// all of them as diagonal as they get, so that branches which cross keep their derivatives.
MatrixXd branch_rates(const std::vector<MatrixXd>& blocks);

}  // namespace flexopt
