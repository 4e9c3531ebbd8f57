#pragma once
// Writes pictures as SVG.
#include <string>

#include "results/drawing/picture.hpp"

namespace flexopt {

/// A document of its own, with colours for light and dark. Each dimension is a group with its
/// parameter, value [SI] and pixels a metre as `data-` attributes; a named part of the picture is a
/// `<view>`; words are exactly as wide as
/// planned, whatever the letters of the reader are.
std::string svg_of(const Picture& picture, const std::string& title);

}  // namespace flexopt
