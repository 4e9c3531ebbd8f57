#pragma once
// Drawings for cutting, DXF R12 in millimetres.
#include <optional>
#include <string>

#include "core/response/response.hpp"

namespace flexopt {

/// The leaves laid flat, a closed outline of true size for each on a layer of its own, folds on the
/// layer FOLDS, beside them name and thickness on TEXT. Nothing where all leaves are wires.
std::optional<std::string> dxf_leaves(const Mechanism& mechanism);

/// Contours of a mechanism all whose leaves have their width along one direction: the thickness of
/// the leaves seen along it, closed outlines in the plane across, each on a layer of its own. At a
/// point of a path, or undeflected (null). Nothing for other mechanisms.
std::optional<std::string> dxf_contour(const Mechanism& mechanism, const PathPoint* point);

}  // namespace flexopt
