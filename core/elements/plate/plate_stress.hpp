#pragma once
// Stresses of a plate leaf from its strains, whichever model they came from.
#include <array>
#include <functional>
#include <vector>

#include "core/elements/leaf/leaf_element.hpp"
#include "core/elements/plate/strain_field.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

struct LeafScale;

/// Von Mises stress [Pa] on the side of the normal, and opposite.
struct SurfaceStress {
  double positive = 0, negative = 0;
};
/// Surface stress where the leaf has the thickness of the place `along` in [0, 1].
SurfaceStress surface_stress(const PlateShape& shape, const Strains& e, double youngs_modulus,
                             double along = 0);

/// Surface stresses at many places: one row of strains for each; thickness over L.
struct SurfaceStresses {
  Eigen::ArrayXd positive, negative;
};
SurfaceStresses surface_stresses(const MatrixXd& strains, const Eigen::ArrayXd& thickness,
                                 double poissons_ratio, double youngs_modulus);

/// The stations at which stresses of a plate are read, corners left out.
std::vector<StressPlace> plate_stress_places(const PlateShape& shape);

/// Largest von Mises stress of a strain field, its position left open; stations and corners as
/// below.
StressPeak largest_stress(const StrainField& field, const PlateShape& shape, double youngs_modulus,
                          int index);

/// The places where the stress of a surface is larger than at all stations around, their positions
/// left open.
std::vector<StressPeak> stress_peaks(const StrainField& field, const PlateShape& shape,
                                     double youngs_modulus, int index);

/// Largest von Mises stress on both surfaces,
///
///     σ = E/(1 − ν²) [(1 − ν) ε_ab + ν ε_cc δ_ab],   ε = e ± t/2 κ,   κ_ab = −r,ab · n,
///
/// with strains recovered from the elements' superconvergent points, at stations that do not depend
/// on the mesh, outside squares of a tenth of the shorter side at the four corners: where a clamped
/// edge meets a free one plate theory is singular, and the value there would only tell the size of
/// the element.
StressPeak plate_max_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                            const LeafSpring& leaf, const LeafScale& scale, int index);

/// stress_peaks() of a leaf. The largest of these peaks is plate_max_stress.
std::vector<StressPeak> plate_stress_peaks(const PlateMesh& mesh,
                                           const std::vector<MatrixXd>& nodal,
                                           const LeafSpring& leaf, int index);

/// The largest stress along each clamped edge that has factors: those of a section times them,
///
///     ε = K_membrane e ± K_bending t/2 κ
///
/// at the stations of the edge, corners left out as above. Positions left open.
std::vector<StressPeak> clamp_stresses(const StrainField& field, const PlateShape& shape,
                                       double youngs_modulus, int index,
                                       const ClampFactors& factors);
/// Largest stresses at the clamped edges of a leaf, with positions.
std::vector<StressPeak> plate_clamp_stresses(const PlateMesh& mesh,
                                             const std::vector<MatrixXd>& nodal,
                                             const LeafSpring& leaf, const LeafScale& scale,
                                             int index, const ClampFactors& factors);

/// Derivative of the stress at a peak found by plate_max_stress or plate_clamp_stresses: at the
/// same station, which keeps its place in [0, 1]² unless it stands at the border of a corner zone.
/// The notch factors of the peak are constants here.
double plate_stress_rate(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                         const StressPeak& peak, double youngs_modulus, const StressRate& rate);

/// Derivative of the stress at a peak for any strain field: stations x and y, and the strains with
/// their derivatives at a pair of stations. The stations across move with the width.
double stress_rate(const PlateShape& shape, const std::vector<Dual1>& x,
                   const std::vector<double>& y, const std::function<StrainRate(int, int)>& strains,
                   const StressPeak& peak, double youngs_modulus, const StressRate& rate);

/// Strains at a place, and half the thickness there over L, with their derivatives.
struct MovingSection {
  StrainsT<Dual1> strains;
  Dual1 half;
};
MovingSection moving_section(const PlateShape& shape, const std::vector<Dual1>& x,
                             const std::vector<double>& y,
                             const std::function<StrainRate(int, int)>& strains, double along,
                             double across, const ShapeRate& rate);

}  // namespace flexopt
