#pragma once
// The numbers of a path as numpy sees them: one row for each stroke point, read-only.
#include <pybind11/pybind11.h>

#include "results/library/runs.hpp"

namespace flexopt {

/// Names the class Path, and as `path` of a run that of one of its load cases.
void add_path(pybind11::module_& module, pybind11::class_<FinishedRun>& run);

}  // namespace flexopt
