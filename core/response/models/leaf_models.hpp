#pragma once
// Makes the leaf elements of a mechanism for the wanted accuracy.
#include <memory>
#include <vector>

#include "core/elements/leaf/leaf_element.hpp"
#include "core/mechanism/load_case.hpp"

namespace flexopt {

/// `reason`: why full leaves replace reduced ones, where they do.
std::vector<std::unique_ptr<LeafElement>> make_full_leaves(const Mechanism& mechanism,
                                                           const ModelOptions& model,
                                                           const std::string& reason = {});

/// What a segment of a leaf is modelled as that is cut into `model.superelements` of them: its
/// share of the elements, and warping free at the cuts of a beam, since a rigid line has no
/// coordinate for it.
ModelOptions segment_options(const ModelOptions& model);

/// Makes the reduced leaves of a mechanism by `model.method`. Linear superelements need nothing but
/// the leaf; one with a material point that is none of their nodes is full, and says so. Mixed
/// potential: one tube per distinct leaf, its ray and range from the linear kinematics of the drive
/// at the undeflected state, centred on the leaf's share of the constant loads.
/// `largest`: stroke of the path; where nothing is driven, the largest factor of the growing loads,
/// which then give the kinematics. `several`: instead, the strokes of several drives at the points
/// of the path. `poissons_ratio_moves`: whether a leaf that is looked up may be asked for
/// derivatives by its ν; they are zero otherwise. A leaf with a free tip or a material point, or
/// whose bent states are not found, is full, and says so.
std::vector<std::unique_ptr<LeafElement>> make_reduced_leaves(
    const Mechanism& mechanism, const ModelOptions& model, double largest,
    const LoadCase& loads = {}, const std::vector<VectorXd>& several = {},
    bool poissons_ratio_moves = true);

}  // namespace flexopt
