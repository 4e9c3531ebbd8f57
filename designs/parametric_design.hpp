#pragma once
// A family with everything that is decided once: its options, and its formulas compiled. What is
// left is numbers in slots: values of the parameters → mechanism, and its derivatives.
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/spec/formula.hpp"
#include "designs/family.hpp"

namespace flexopt {

/// A parameter that follows from the others.
struct DependentParameter {
  int slot = 0;
  Formula formula;  ///< over the slots
};

/// Larger moves [m] and turns [rad] of an edge, axis by axis, are taken for typing errors.
inline constexpr double largest_edge_size = 1;

/// How far a clamped edge sits other than designed along one axis, where parameters say so.
struct EdgeSize {
  int leaf = 0, end = 0;  ///< 0 base, 1 tip
  int axis = 0;           ///< of a move [m], then of a rotation vector [rad], global axes
  Formula formula;        ///< over the slots
};

/// Plain data and const functions: safe to share among threads.
class ParametricDesign {
 public:
  /// `formulas`: texts by the names of the parameters that they give; they may use the parameters
  /// without one. `nominal`: values that elastic bodies are meshed for (Family::make). Throws
  /// SpecError for wrong formulas, at /design/parameters/<name>/expression.
  ParametricDesign(std::shared_ptr<const Family> family, FamilyChoices choices,
                   const std::map<std::string, std::string>& formulas,
                   ParameterValues nominal = {});
  /// Design of one of families(), which live as long as the program.
  ParametricDesign(const Family& family, FamilyChoices choices,
                   const std::map<std::string, std::string>& formulas)
      : ParametricDesign(std::shared_ptr<const Family>(std::shared_ptr<const Family>(), &family),
                         std::move(choices), formulas) {}

  const Family& family() const { return *family_; }
  const FamilyChoices& choices() const { return choices_; }
  bool has_end_effector() const { return family_->has_end_effector(choices_); }
  const std::vector<DependentParameter>& dependents() const { return dependents_; }
  /// The design whose edges sit as these formulas say (LeafSpring::assembly_move, assembly_turn).
  ParametricDesign with_edges(std::vector<EdgeSize> edges) const;
  const std::vector<EdgeSize>& edges() const { return edges_; }
  bool is_dependent(int slot) const;

  /// Place of the parameter in the family's list, −1 for other names.
  int slot(const std::string& name) const;
  /// Values by slot. Dependent parameters may be missing and are then 0.
  std::vector<double> slots(const ParameterValues& parameters) const;

  /// Computes the dependent ones. Throws SpecError where a formula has no finite value.
  void complete(std::span<double> slots) const;
  /// Derivatives of all slots (rows) with respect to all slots (columns), the dependent ones
  /// following: 1 for the slot itself, the formula's slopes in the row of a dependent one, 0 in its
  /// column. Nothing where a slope is not finite.
  std::optional<MatrixXd> derivatives(std::span<const double> slots) const;

  /// Every parameter must be in range. Throws SpecError where they contradict each other.
  Mechanism build(const ParameterValues& parameters, const Material& material,
                  const EndEffector& payload) const;
  /// Exact derivatives of the mechanism along the named numbers alone: parameters of the family
  /// (each at constant others), `material.…` and `end_effector.…`. Throws std::invalid_argument for
  /// another name.
  std::vector<MechanismDirection> directions(const ParameterValues& parameters,
                                             const Material& material, const EndEffector& payload,
                                             const std::vector<std::string>& names) const;
  /// Every name that `directions` takes, but for the dependent parameters.
  std::vector<std::string> independent_names() const;

 private:
  std::shared_ptr<const Family> family_;
  FamilyChoices choices_;
  ParameterValues nominal_;
  std::vector<DependentParameter> dependents_;
  std::vector<EdgeSize> edges_;
};

}  // namespace flexopt
