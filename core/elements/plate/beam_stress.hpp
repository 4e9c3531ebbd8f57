#pragma once
// Stresses and shape of a beam leaf from its nodal dofs, whichever model they came from.
#include <vector>

#include "core/elements/leaf/leaf_element.hpp"
#include "core/elements/plate/plate_mesh.hpp"

namespace flexopt {

struct LeafScale;

/// Linear strains are those of nodal displacements about the undeflected beam; the places that come
/// with them mean nothing.
enum class BeamStrain { finite, linear };

/// Largest von Mises stress √(σ² + 3τ²) of the section formulas. Rectangle, at y across and on the
/// surfaces z = ±t/2:
///
///     σ = E (ε0 + y κ3 + ½ y² |d,x|² + z (κ2 + y κ2′)),   τ = G (1.5 k γ (1 − (2y/w)²) + 2 z θ′ f)
///
/// with γ the shear of the plane, θ′ the twist, κ2′ the restrained warping and f the
/// torsion_stress_factor. Circle: σ = E (|ε0| + ½ d |κ|), τ = ½ G d θ′. Both ends included: a beam
/// has no singular corners.
StressPeak beam_max_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                           const LeafSpring& leaf, const LeafScale& scale, int index,
                           BeamStrain strain = BeamStrain::finite);

struct StressRate;
/// The places along a beam where the largest stress of the section is larger than at the stations
/// beside them, as plate_stress_peaks.
std::vector<StressPeak> beam_stress_peaks(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                                          const LeafSpring& leaf, int index,
                                          BeamStrain strain = BeamStrain::finite);

/// The largest stress of the end sections that have factors, as plate_clamp_stresses: stresses that
/// are even in z times the membrane's, odd ones times the bending's. Rectangular sections only.
/// Positions left open.
std::vector<StressPeak> beam_clamp_stresses(const PlateMesh& mesh,
                                            const std::vector<MatrixXd>& nodal,
                                            const LeafSpring& leaf, int index,
                                            const ClampFactors& factors,
                                            BeamStrain strain = BeamStrain::finite);

/// Derivative of the stress at a peak found by beam_max_stress or beam_clamp_stresses, at the same
/// place, with the same notch factors.
double beam_stress_rate(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                        const StressPeak& peak, double youngs_modulus, const StressRate& rate);

/// Places of all stations of the section formulas, as plate_stress_places has them; of a wire, 64
/// around its outline.
std::vector<StressPlace> beam_stress_places(const PlateShape& shape);
/// A SectionStress in each column.
MatrixXd beam_section_stresses(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               double youngs_modulus, const std::vector<StressPlace>& places,
                               BeamStrain strain = BeamStrain::finite);
/// Derivatives of the section stresses, one place after the other.
VectorXd beam_section_rates(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                            const std::vector<StressPlace>& places, double youngs_modulus,
                            const StressRate& rate);

/// The deflected ribbon of width w, two points across.
LeafShape beam_deformed_shape(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                              const LeafSpring& leaf, const LeafScale& scale,
                              BeamStrain strain = BeamStrain::finite);

}  // namespace flexopt
