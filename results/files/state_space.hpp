#pragma once
// Linear models about points of the stroke: in result.json, and for MATLAB and Octave.
#include <filesystem>
#include <string>

#include "core/response/response.hpp"
#include "results/files/json_text.hpp"

namespace flexopt {

/// Inputs and outputs with their units; null where no point has a model.
OrderedJson signals_json(const StrokeResponse& response);
/// Squares of the frequencies, damping, and the matrices by rows: those of StateSpace.
OrderedJson state_space_json(const StateSpace& model);

/// A script that leaves the models in an array of structs: strokes, frequencies [Hz], A, B, C, D,
/// and as `sys` the objects of a control toolbox, where there is one.
std::string state_space_script(const StrokeResponse& response, const std::string& title);

/// state_space.m, or nothing in its place where no point has a model.
void write_state_space(const std::filesystem::path& folder, const StrokeResponse& response,
                       const std::string& title);

}  // namespace flexopt
