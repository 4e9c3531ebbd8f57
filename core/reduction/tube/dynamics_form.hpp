#pragma once
// The form rᵀ(K − μM)r of a leaf's rates by its tables of dynamics, and what it changes by with the
// state and the shape. Equations (D8) and (D9) of core/reduction/README.md.
#include "core/reduction/tube/dynamics_entries.hpp"

namespace flexopt {

/// Quadratic form of the dynamics at one state; a plain value.
class DynamicsForm {
 public:
  static constexpr int R = TubeDynamics::rates, P = TubeDynamics::amplitudes;
  using Rates = Eigen::Matrix<double, R, 1>;  ///< those of TubeDynamics::Answer::mass

  /// Form at a place where `tables` are valid, that is, TubeDynamics::Answer::reason is empty.
  /// `rates`: derivatives of these tables; may be empty where nothing is asked by the shape.
  DynamicsForm(const TubeDynamics& tables, const TubeDynamics::Place& place,
               const DynamicsRates& rates);

  struct Value {
    double stiffness = 0, mass = 0;  ///< rᵀK r, rᵀM r
    Rates along_mass;                ///< M r
    Vector6d state;  ///< ∂(rᵀ(K − μM)r)/∂(σ, τ, twist, N, M1, M2) of TubeDynamics::Place
    Vector3d shape;  ///< by w/L, t/L and ν
  };
  Value at(const Rates& r, double mu) const;
  /// ∂(rᵀ(K − μM)r) by every number of the layout, the even ones first.
  VectorXd by_numbers(const Rates& r, double mu) const;

 private:
  /// Rates r of the tables, and what they bring about.
  struct Motion {
    Rates r, fields, moved;
    Vector3d x;
  };
  Motion motion(const Rates& r) const;
  using Covector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, R*(R + 1), 1>;
  Covector covector(const Motion& motion, double mu) const;

  DynamicsEntries entries_;
  DynamicsEntries::Square factor_;  ///< of k
  DynamicsEntries::Flat X_;         ///< F′⁻¹ G
  Matrix3d F_inverse_;
  Eigen::Matrix<double, P, 6> static_;  ///< k⁻¹ (g, Gᵀ)
  Rates mirror_;                        ///< from the leaf to the tables
  /// Derivatives of every number of the layout, the even ones first: with respect to the state,
  /// then to the shape.
  Eigen::Matrix<double, Eigen::Dynamic, 9> slopes_;
};

}  // namespace flexopt
