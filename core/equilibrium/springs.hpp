#pragma once
// The springs of a mechanism as part of its energy: README.md (Q6).
#include <vector>

#include "core/math/block_matrix.hpp"
#include "core/mechanism/spring.hpp"

namespace flexopt {

class Springs {
 public:
  /// Springs at first without preload, as if their free lengths were the built ones. The mechanism
  /// must outlive this.
  explicit Springs(const Mechanism& mechanism);

  /// Whether one of them pulls or pushes in the undeflected state.
  bool preloaded() const { return preloaded_; }
  /// Lets so much of the difference between free and built lengths of a spring act, 0 … 1.
  void apply(std::size_t spring, double share);

  /// Adds energy, forces on the bodies and tangent at these poses. False where a bushing is turned
  /// by more than half a turn, beyond which it has none.
  bool add(const std::vector<JointBody>& poses, double& energy, VectorXd& force,
           BlockMatrix& tangent) const;

 private:
  const Mechanism* mechanism_;
  std::vector<Spring> acting_;
  bool preloaded_ = false;
};

/// Forces on the bodies in the undeflected state, preload acting.
VectorXd preload_forces(const Mechanism& mechanism);

}  // namespace flexopt
