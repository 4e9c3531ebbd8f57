#pragma once
// Making an atlas: every leaf of its grid is solved and expanded, in any order and on any threads.
#include <functional>

#include "core/reduction/atlas/expanded_leaf.hpp"
#include "core/reduction/atlas/tube_atlas.hpp"

namespace flexopt {

/// Runs work(0) … work(count − 1), in any order, and returns when all are done.
using WorkLoop = std::function<void(int count, const std::function<void(int)>& work)>;
/// Work loop that runs one unit after the other.
void run_in_order(int count, const std::function<void(int)>& work);

struct AtlasOptions {
  WorkLoop loop = run_in_order;
  /// Called after each finished leaf with the number of finished leaves, from any thread.
  std::function<void(int done, int total)> progress;
  std::array<int, 2> check_cells{6, 4};  ///< along log w/L and log t/L; 0: no check
  /// Rays that are checked: S, C and some between those of the atlas.
  std::vector<double> check_rays{1, -1, 0.85, 0.54, 0.1, -0.1, -0.29, -0.85};
};

/// None where a leaf of the grid has no bent states.
Answer<std::shared_ptr<const TubeAtlas>> make_atlas(const AtlasSettings& settings,
                                                    const AtlasOptions& options = {});

/// Errors of an atlas of a leaf (whose own errors are not looked at) on the ray (1, rho), against
/// the leaf that is built.
AtlasCheck::Errors atlas_errors(const TubeAtlas& atlas, double rho,
                                const AtlasCheck::Sample& sample);

/// Errors of a potential against another one of the same leaf, `truth`.
AtlasCheck::Errors difference(const TubePotential& found, const TubePotential& truth,
                              const PlateShape& shape);

/// The potential that TubeModel makes from bent states.
TubePotential tube_potential(const PlateShape& shape, const Eigen::Matrix2d& directions,
                             std::vector<TubeNode> nodes);

}  // namespace flexopt
