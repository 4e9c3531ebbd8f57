#pragma once
// A bent mechanism with K⁻¹ and M of all its unknowns written out: what answers are compared with.
#include <Eigen/LU>
#include <complex>
#include <memory>

#include "core/response/models/leaf_models.hpp"
#include "core/response/modes/mechanism_factor.hpp"
#include "support/one_stroke.hpp"

namespace flexopt::test {

struct BentMechanism {
  std::unique_ptr<System> system;
  std::unique_ptr<MechanismFactor> factor;
};

inline BentMechanism bent(const Mechanism& mechanism, double stroke, const ModelOptions& model) {
  BentMechanism result;
  result.system = std::make_unique<System>(mechanism, make_full_leaves(mechanism, model));
  REQUIRE(step_to(*result.system, stroke, {}).converged);
  auto linear = MechanismFactor::of(*result.system);
  REQUIRE(linear);
  result.factor = std::make_unique<MechanismFactor>(std::move(*linear));
  return result;
}

/// (K − σM)⁻¹ f, drives free or held.
inline Eigen::VectorXcd pencil_answer(const MechanismFactor& factor, bool locked,
                                      std::complex<double> sigma, const VectorXd& f) {
  const MatrixXd unit = MatrixXd::Identity(factor.size(), factor.size());
  const auto solve = [&](const MatrixXd& B) {
    return locked ? factor.solve_locked(B) : factor.solve(B);
  };
  const Eigen::MatrixXcd A = unit.cast<std::complex<double>>() -
                             sigma * solve(factor.mass(unit)).cast<std::complex<double>>();
  return Eigen::PartialPivLU<Eigen::MatrixXcd>(A).solve(
      Eigen::VectorXcd(solve(f).col(0).cast<std::complex<double>>()));
}

}  // namespace flexopt::test
