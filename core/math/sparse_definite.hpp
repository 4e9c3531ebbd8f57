#pragma once
// Large sparse symmetric positive definite equations with many right-hand sides, by the
// multifrontal factorisation of MUMPS (CeCILL-C).
#include <memory>
#include <mutex>

#include "core/math/answer.hpp"
#include "core/math/sparse_matrix.hpp"

namespace flexopt {

/// MUMPS keeps global state: whoever calls it, or a library that does, holds this mutex.
std::mutex& mumps_mutex();

/// A = L D Lᵀ. Several threads may solve, one after the other.
class DefiniteFactor {
 public:
  /// Reads the lower triangle of A; entries at the same place are added. Tells that A is not
  /// positive definite. Throws std::bad_alloc.
  static Answer<std::shared_ptr<const DefiniteFactor>> of(const SparseMatrix& A);
  ~DefiniteFactor();
  DefiniteFactor(const DefiniteFactor&) = delete;
  DefiniteFactor& operator=(const DefiniteFactor&) = delete;

  /// Replaces B by A⁻¹ B. Throws std::bad_alloc.
  void solve(MatrixXd& B) const;
  std::size_t bytes() const;  ///< of memory that the factor takes

 private:
  DefiniteFactor();
  struct Mumps;
  std::unique_ptr<Mumps> mumps_;
};

}  // namespace flexopt
