#pragma once
// A run with the shape of a real one, from closed forms: two crossed leaves turned by the stroke.
#include "results/files/run_record.hpp"
#include "support/temporary_folder.hpp"

namespace flexopt::test {

/// ±20°, five points, shapes, frequencies, stress.
RunRecord evaluated_hinge();

/// The same design as the optimum of two variables with two constraints and two starts.
RunRecord optimised_hinge();

}  // namespace flexopt::test
