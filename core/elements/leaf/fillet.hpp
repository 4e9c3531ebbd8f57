#pragma once
// Stress concentration where a leaf spring meets a body with a fillet.
#include "core/elements/leaf/leaf_results.hpp"

namespace flexopt {

/// Range of the radius over the thickness: the formula's lower end, and a fillet as high as the
/// shoulder.
inline constexpr double least_fillet = 0.1, largest_fillet = 2;

/// Theoretical stress concentration factors of a flat bar of thickness t with a shoulder of height
/// h on both sides and fillets of radius r, for tension (membrane) and for bending:
///
///     K = C1 + C2 x + C3 x² + C4 x³,   x = 2h/D,   D = t + 2h,   Cn = an + bn √(h/r) + cn h/r
///
/// with the constants of W. C. Young, R. G. Budynas, Roark's Formulas for Stress and Strain, 7th
/// ed., table 17.1, cases 5a and 5b, for 0.1 ≤ h/r ≤ 2 and for 2 ≤ h/r ≤ 20. The shoulder is that
/// of a thick body, h = 2 t; h = 5 t gives up to 3 % more.
///
/// `radius`: r/t in [least_fillet, largest_fillet].
NotchFactors fillet_factors(double radius);
/// Derivatives of the notch factors by r/t. Where the two ranges meet, those of the smaller radius.
NotchFactors fillet_factor_slopes(double radius);

}  // namespace flexopt
