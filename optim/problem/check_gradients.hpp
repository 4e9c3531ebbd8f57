#pragma once
// Every exact derivative of a job's outputs against differences of the whole path.
#include <string>
#include <vector>

#include "optim/job/job.hpp"

namespace flexopt {

/// The worst agreement of one quantity along one parameter over the points.
struct GradientCheck {
  std::string quantity, parameter;
  int point = 0;          ///< index on the path
  double exact = 0;       ///< SI per SI
  double difference = 0;  ///< Ridders' extrapolated difference
  double error = 0;       ///< |exact − difference|, relative: see check_gradients
  double known_to = 0;    ///< what the difference itself is known to, relative
  bool agrees = false;
  /// Two directions are equally stiff here, but not beside this point: the smallest stiffness has
  /// one derivative on each side, and `exact` is one of them or lies between.
  bool equal_stiffnesses = false;
  std::string load_case;  ///< load case of a job with several
};

struct GradientReport {
  bool ok = false;                    ///< every number could be compared and agrees
  std::string message;                ///< the outcome, or why nothing could be compared
  std::vector<GradientCheck> checks;  ///< each quantity and parameter, in their order
};

/// For each load case, compares every derivative with respect to the family's parameters (formulas
/// follow the others), the material and the payload, at every stroke point, with extrapolated
/// differences of the path, the default reduction finished on full leaves. Errors are relative to
/// the derivative, or to 1e-2 of the steepest along the path or a tenth of value/parameter where
/// that is more (values below 1e-2 of the quantity's largest, or a tenth of the stroke, count as
/// that).
/// A derivative agrees where its error is at most `tolerance`, or at most five times the error of
/// the difference: by its extrapolation, and by the rounding of the numbers, which is measured. One
/// that does not agree, or whose difference is known to less than 1e-4, is differenced again with
/// steps a hundredth and a ten-thousandth as large (a kink, a pole or a nearly equal frequency may
/// lie near). If it does not agree then, the rounding along this parameter is measured, that of the
/// exact derivative too, and must be below 1e-4 to explain the error.
/// Members of a cluster of equal frequencies are compared by their sum. Where equal stiffnesses
/// leave `principal_stiffness` no derivative, the check and the message say so.
GradientReport check_gradients(const Job& job, double tolerance, int threads);

}  // namespace flexopt
