#pragma once
// What the places and the stresses of a plate or beam leaf change by, from its nodes.
#include <optional>
#include <vector>

#include "core/elements/leaf/leaf_fields.hpp"
#include "core/elements/plate/plate_mesh.hpp"
#include "core/elements/plate/plate_stress.hpp"

namespace flexopt {

/// Derivatives of the fields of a leaf from the nodal values of its full mesh, whichever model
/// moves the nodes.
class PlateFields final : public LeafFields {
 public:
  /// `nodal`: functions × 3 of every line, leaf axes; `rates`: functions × (3 components of each
  /// parameter); `shape`: how it changes along each parameter. The mesh must outlive this.
  PlateFields(const PlateMesh& mesh, std::vector<MatrixXd> nodal, std::vector<MatrixXd> rates,
              std::vector<ShapeRate> shape);

  MatrixXd place_rates(double along, double across) const override;
  std::optional<Vector3d> place_slope(double along, double across) const override;
  MatrixXd section_rates(const std::vector<StressPlace>& places, double modulus,
                         const VectorXd& modulus_rates) const override;

 private:
  const PlateMesh* mesh_;
  std::vector<MatrixXd> nodal_, rates_;
  std::vector<ShapeRate> shape_;
};

}  // namespace flexopt
