#pragma once
// Stresses of a plate leaf from its strains, whichever model they came from, and of any leaf from
// the nodal values of its mesh.
#include <vector>

#include "core/elements/leaf/leaf_stress.hpp"
#include "core/elements/plate/strain_field.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

struct LeafScale;

/// Von Mises stress [Pa] on the side of the normal, and opposite, at many places: one row of
/// strains for each; thickness over L.
struct SurfaceStresses {
  Eigen::ArrayXd positive, negative;
};
SurfaceStresses surface_stresses(const MatrixXd& strains, const Eigen::ArrayXd& thickness,
                                 double poissons_ratio, double youngs_modulus);

/// Stations that do not depend on the mesh. Of a plate they leave out squares of a tenth of the
/// shorter side at the four corners: where a clamped edge meets a free one plate theory is
/// singular, and the value there would only tell the size of the element. Beams: beam_stress.hpp.
StressStations stress_stations(const PlateShape& shape);

/// Stress of a plate's section where it has the thickness of the place `along` in [0, 1]:
///
///     σ11 = E/(1 − ν²) (ε11 + ν ε22),  σ22 likewise,  σ12 = G 2ε12;   ε = e, then t/2 κ
///
/// with κ_ab = −r,ab · n.
SectionStress section_stress(const PlateShape& shape, const Strains& e, double youngs_modulus,
                             double along = 0);

/// Stress of a plate with these strains, positions left open. `index`: of the leaf. The shape must
/// outlive it.
LeafStress plate_stress(StrainField field, const PlateShape& shape, double youngs_modulus,
                        int index);
/// Stress of a plate or a beam, with strains recovered from the elements' superconvergent points.
/// Mesh and scale must outlive it.
LeafStress leaf_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                       const LeafSpring& leaf, const LeafScale& scale, int index);

/// Derivatives of the section stresses, one place after the other, which keep their places in
/// [0, 1]² unless they stand at the border of a corner zone: for a plate whose stations move, and
/// for a leaf.
VectorXd section_rates(const PlateShape& shape, const MovingStations& stations,
                       const std::vector<StressPlace>& places, double youngs_modulus,
                       const StressRate& rate);
VectorXd section_rates(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                       const std::vector<StressPlace>& places, double youngs_modulus,
                       const StressRate& rate);

}  // namespace flexopt
