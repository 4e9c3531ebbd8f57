#pragma once
// A design as a labelled drawing: plan views with dimensions, a slanting view, its parameters.
#include "results/export/measures.hpp"
#include "results/export/picture.hpp"

namespace flexopt {

struct DesignDrawing {
  Picture picture;
  /// Lengths that move the geometry but are no distance in it; they have a note instead.
  std::vector<std::string> without_dimension;
};

/// Throws SpecError as Family::make.
DesignDrawing draw_design(const Family& family, const ParameterValues& values,
                          const FamilyChoices& choices);

/// The drawing as an SVG file.
std::string svg_of_design(const Family& family, const ParameterValues& values,
                          const FamilyChoices& choices);

}  // namespace flexopt
