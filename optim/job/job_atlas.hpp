#pragma once
// The atlas that a job's leaves are looked up in.
#include <string>

#include "core/mechanism/model_options.hpp"

namespace flexopt {

/// Opens the atlas of a model that wants one, unless it has it. Returns why there is none; empty if
/// there is, or if the model wants none or is of full accuracy.
std::string find_atlas(ModelOptions& model);

/// What is odd about the atlas of a model, for the user's eyes; empty if nothing is.
std::string note_on_atlas(ModelOptions model);

/// The model with reduced leaves, looked up where it allows that and there is a look-up table.
ModelOptions on_reduced_leaves(ModelOptions model);

}  // namespace flexopt
