#pragma once
// Stresses of a beam from its section, whichever model the nodal values came from.
#include <vector>

#include "core/elements/leaf/leaf_stress.hpp"
#include "core/elements/plate/strain_field.hpp"

namespace flexopt {

/// Strains of a beam: those of its present shape, or small ones of nodal displacements.
enum class BeamStrain { finite, linear };

/// The von Mises stress of a section is √(σ² + 3τ²). Rectangle, at y across and on the surfaces
/// z = ±t/2:
///
///     σ = E (ε0 + y κ3 + ½ y² |d,x|² + z (κ2 + y κ2′)),   τ = G (1.5 k γ (1 − (2y/w)²) + 2 z θ′ f)
///
/// with κ3 and k γ those of the whole moment and force in the plane, (B3) of beams.md, θ′ the
/// twist, κ2′ the restrained warping and f the torsion_stress_factor. Circle: σ = E (|ε0| + ½ d
/// |κ|), τ = ½ G d θ′. Both ends included: a beam has no singular corners. Of a wire, 64 places
/// around its outline.
StressStations beam_stations(const PlateShape& shape);
/// LeafStress::sections of a beam. The mesh must outlive it.
LeafStress::Sections beam_sections(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                                   double youngs_modulus, BeamStrain strain = BeamStrain::finite);
/// Derivatives of the section stresses, one place after the other.
VectorXd beam_section_rates(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                            const std::vector<StressPlace>& places, double youngs_modulus,
                            const StressRate& rate);

}  // namespace flexopt
