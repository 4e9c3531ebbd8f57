#pragma once
// What the residual and the quadratic forms yᵀ(K − λM)y of a mechanism change by
// when a design parameter moves: at one equilibrium (S = double) or along the stroke from it (S =
// Jet). Equations (S6), (S8)–(S12) of core/response/README.md.
#include <memory>
#include <utility>
#include <vector>

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/leaf/leaf_rates.hpp"
#include "core/math/answer.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/response/gradients/mechanism_state.hpp"

namespace flexopt {

/// Along which a design is differentiated: derivative of every number of the mechanism, direction
/// by direction, and what equal leaves share of theirs. Stays where it is.
struct DesignDirections {
  std::vector<Mechanism> list;
  LeafRates rates;
  /// What the strokes change by along each: drives × directions. Without columns they stay.
  MatrixXd strokes;

  DesignDirections() = default;
  DesignDirections(const Mechanism& mechanism, std::vector<Mechanism> directions)
      : list(std::move(directions)), rates(ProfileDirections(mechanism, list)) {}
};

/// Gradients of the leaves, one by one.
template <class S>
using LeafGradients = std::vector<std::unique_ptr<LeafGradient<S>>>;

/// Columns of translations of the ground beside columns of motions that are relative to it.
struct GroundShare {
  MatrixXd translations;  ///< 3 × columns
  MatrixXd carried;       ///< motion of all unknowns with them: rows × columns
};

template <class S>
class DesignRates {
 public:
  using Vector = Eigen::VectorX<S>;
  using Matrix = Eigen::MatrixX<S>;

  /// `leaves` and `state`: at the factor's state, or along a path from it. `directions`: derivative
  /// of every number of the mechanism along each parameter. Both they and the factor must outlive
  /// this.
  DesignRates(const MechanismFactor& factor, LeafGradients<S> leaves, MechanismState<S> state,
              const std::vector<Mechanism>& directions, const ModelOptions& model);

  /// (S6): of the residual of every row at a constant state, rows × parameters.
  Matrix residual() const;
  /// (S8)–(S10): of q = yᵀ(K − λM)y of every column y of Y, columns × parameters, while the state
  /// moves by `state_rates` (rows × parameters). `ground`: of absolute motions; nothing gives way
  /// to what is carried, but it has mass.
  Matrix quadratic(const Matrix& Y, const Vector& lambda, const Matrix& state_rates,
                   const GroundShare* ground = nullptr) const;

  const std::vector<Mechanism>& directions() const { return *directions_; }
  const LeafGradient<S>& leaf(int i) const { return *leaves_[i]; }
  /// Variations of a leaf along every parameter.
  const std::vector<LeafVariation<S>>& variations(int i) const { return variations_[i]; }

 private:
  LeafVariation<S> variation(int leaf, const Mechanism& direction,
                             const ProfileDirections& profiles, const ModelOptions& model) const;
  S body_mass_rate(const Mechanism& direction, const Vector& y, const Vector& state_rate) const;

  const MechanismFactor* factor_;
  const std::vector<Mechanism>* directions_;
  MechanismState<S> state_;
  LeafGradients<S> leaves_;
  std::vector<std::vector<LeafVariation<S>>> variations_;  ///< leaf by leaf
};

extern template class DesignRates<double>;
extern template class DesignRates<Jet>;

/// Rates at the state of the factor. None where a leaf has no exact derivatives; full leaves have
/// them.
Answer<DesignRates<double>> design_rates(const MechanismFactor& factor,
                                         DesignDirections& directions, const ModelOptions& model);

}  // namespace flexopt
