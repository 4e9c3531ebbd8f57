#pragma once
// Tables of stress of flat leaves of any shape, looked up instead of expanded: a few patterns of
// strains, their coefficients compressed over the shapes. Equation (A6) of
// core/reduction/README.md.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/reduction/atlas/packed_table.hpp"
#include "core/reduction/tube/tube_stress.hpp"

namespace flexopt {

/// What a stress atlas is made of.
struct StressAtlasSettings {
  ShapeGrid grid;
  std::vector<double> rays, sigmas;
  std::array<int, 2> mesh = default_mesh;
  bool free_edge_torsion = true;
  int patterns = 80;        ///< of each family of strains (StrainPatterns)
  int place_patterns = 16;  ///< of places in the plane of the flat leaf, and of those off it
  int samples = 150;        ///< leaves that they are found from
  double tolerance = 7e-5;  ///< of a coefficient's share in the stress, root mean square over the
                            ///< leaf, over the largest stress; on the grid
};

/// The patterns that carry most of the tables of leaves at random places of the box.
StrainPatterns find_patterns(const StressAtlasSettings& settings);

class StressAtlas {
 public:
  /// `tables`: of each ray all bent states. `owner`: keeps their numbers alive.
  StressAtlas(StressAtlasSettings settings, std::shared_ptr<const StrainPatterns> patterns,
              std::vector<PackedTable> tables, std::shared_ptr<const void> owner)
      : settings_(std::move(settings)),
        patterns_(std::move(patterns)),
        tables_(std::move(tables)),
        owner_(std::move(owner)) {}

  const StressAtlasSettings& settings() const { return settings_; }
  const std::shared_ptr<const StrainPatterns>& patterns() const { return patterns_; }
  /// Coefficients of the patterns about the first `nodes` bent states of a leaf in the box on the
  /// ray (1, rho), rho within the rays.
  std::vector<StateTable> look_up(const PlateShape& shape, double rho, int nodes) const;
  /// Source of the derivatives of the coefficients for the same leaf. The atlas must outlive it.
  StressRateSource rates(const PlateShape& shape, double rho,
                         ShapeSlopes slopes = ShapeSlopes::all) const;

  /// Packs the tables into one block of numbers for a file, and unpacks such a block. `data` is
  /// aligned to 64 bytes and kept by `owner`; null where the block does not match these settings.
  std::string pack() const;
  static std::shared_ptr<const StressAtlas> unpack(const StressAtlasSettings& settings,
                                                   const char* data, std::size_t size,
                                                   std::shared_ptr<const void> owner);

 private:
  template <class LookUp>
  StateTable coefficients(double rho, std::size_t n, const LookUp& look_up) const;

  StressAtlasSettings settings_;
  std::shared_ptr<const StrainPatterns> patterns_;
  std::vector<PackedTable> tables_;
  std::shared_ptr<const void> owner_;
};

/// Collects the tables of a stress atlas, one ray after the other.
class StressAtlasMaker {
 public:
  explicit StressAtlasMaker(const StressAtlasSettings& settings);

  /// Adds the tables of shape k of the grid on the present ray; each k once, from any thread.
  void put(int k, const std::vector<StateTable>& nodes);
  /// Call when all shapes of a ray have been added.
  void end_ray();
  /// Call when all rays have ended.
  std::shared_ptr<const StressAtlas> finish();

 private:
  StressAtlasSettings settings_;
  std::shared_ptr<const StrainPatterns> patterns_;
  std::vector<MatrixXd> values_;  ///< of each bent state: numbers × shapes
  std::shared_ptr<std::vector<PackedNumbers>> made_ =
      std::make_shared<std::vector<PackedNumbers>>();
};

}  // namespace flexopt
