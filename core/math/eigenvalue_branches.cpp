#include "core/math/eigenvalue_branches.hpp"

#include "core/math/decompositions.hpp"

namespace flexopt {

MatrixXd branch_rates(const std::vector<MatrixXd>& blocks) {
  const Eigen::Index size = blocks.front().rows();
  MatrixXd rates(size, blocks.size());
  if (size == 1) {
    for (std::size_t p = 0; p < blocks.size(); ++p) rates(0, p) = blocks[p](0, 0);
    return rates;
  }
  MatrixXd mixed = MatrixXd::Zero(size, size);  // a common basis is its own, if there is one
  for (std::size_t p = 0; p < blocks.size(); ++p)
    if (const double norm = blocks[p].norm(); norm > 0)
      mixed += (1 + 0.37 * static_cast<double>(p)) / norm * blocks[p];
  const MatrixXd U = SymmetricEigen(mixed).eigenvectors();
  for (std::size_t p = 0; p < blocks.size(); ++p)
    rates.col(p) = (U.transpose() * blocks[p] * U).diagonal();
  return rates;
}

}  // namespace flexopt
