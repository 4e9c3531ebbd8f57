#pragma once
// The leaf elements of a mechanism for the accuracy asked for.
#include <memory>
#include <vector>

#include "core/elements/leaf_element.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

std::vector<std::unique_ptr<LeafElement>> make_full_leaves(const Mechanism& mechanism,
                                                           const ModelOptions& model);

}  // namespace flexopt
