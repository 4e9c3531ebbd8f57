#pragma once
// Which leaves can be made of superelements; what a reader of jobs asks before anything is made.
#include <optional>

#include "core/math/answer.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"

namespace flexopt {

/// The interface node at a place in [0, 1], if one is there: place × intervals is whole.
std::optional<int> node_at(double place, int intervals);

/// Whether a leaf can be made of these superelements: its material point must be one of
/// their nodes.
Check check_rules(const LeafSpring& leaf, const ModelOptions& model);

}  // namespace flexopt
