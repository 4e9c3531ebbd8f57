#pragma once
// Stresses of sections with their signs: what the history of stress at a place is made of.
#include <vector>

#include "core/elements/plate/beam_stress.hpp"
#include "core/elements/plate/plate_stress.hpp"

namespace flexopt {

/// Places where the section stresses of a plate or a beam of this shape are read.
std::vector<StressPlace> section_places(const PlateShape& shape);

/// A SectionStress in each column, of a plate's strains:
///
///     σ11 = E/(1 − ν²) (ε11 + ν ε22),  σ22 likewise,  σ12 = G 2ε12;   ε = e, then t/2 κ
MatrixXd section_stresses(const StrainField& field, const PlateShape& shape, double youngs_modulus,
                          const std::vector<StressPlace>& places);
/// Section stresses at places of a plate or a beam, from the nodal values of its mesh.
MatrixXd section_stresses(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                          double youngs_modulus, const std::vector<StressPlace>& places);

/// Derivatives of the section stresses, one place after the other: for a plate whose stations move,
/// and for a leaf.
VectorXd section_rates(const PlateShape& shape, const MovingStations& stations,
                       const std::vector<StressPlace>& places, double youngs_modulus,
                       const StressRate& rate);
VectorXd section_rates(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                       const std::vector<StressPlace>& places, double youngs_modulus,
                       const StressRate& rate);

}  // namespace flexopt
