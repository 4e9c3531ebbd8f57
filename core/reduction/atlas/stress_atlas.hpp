#pragma once
// Tables of stress of flat leaves of any shape, looked up instead of expanded: a few patterns of
// strains, and tables of their coefficients. Equation (A6) of core/reduction/README.md.
#include <memory>
#include <utility>
#include <vector>

#include "core/reduction/atlas/state_look_up.hpp"
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
  double unit = 6e-5;  ///< in which the coefficients are whole: of a coefficient's share in the
                       ///< stress, root mean square over the leaf, over the largest stress
};

/// The patterns that carry most of the tables of leaves at random places of the box.
StrainPatterns find_patterns(const StressAtlasSettings& settings);

class StressAtlas {
 public:
  /// `tables`: of each ray of the settings all bent states.
  StressAtlas(StressAtlasSettings settings, std::shared_ptr<const StrainPatterns> patterns,
              std::shared_ptr<const CodedTables> tables)
      : settings_(std::move(settings)),
        patterns_(std::move(patterns)),
        tables_(std::move(tables)) {}

  const StressAtlasSettings& settings() const { return settings_; }
  const std::shared_ptr<const StrainPatterns>& patterns() const { return patterns_; }
  const CodedTables& tables() const { return *tables_; }
  /// Coefficients of the patterns about the first `nodes` bent states of a leaf in the box on the
  /// ray (1, rho), rho within the rays.
  std::vector<StateTable> look_up(const PlateShape& shape, double rho, int nodes) const;
  /// Source of the derivatives of the coefficients for the same leaf. The atlas must outlive it.
  StressRateSource rates(const PlateShape& shape, double rho,
                         ShapeSlopes slopes = ShapeSlopes::all) const;

 private:
  std::vector<StateTable> look_up(const CodedTables::Place& at, double rho, std::size_t n) const;

  StressAtlasSettings settings_;
  std::shared_ptr<const StrainPatterns> patterns_;
  std::shared_ptr<const CodedTables> tables_;
};

/// Numbers about each bent state in the tables of an atlas with so many patterns in all.
std::vector<int> stress_counts(const StressAtlasSettings& settings, Eigen::Index patterns);

/// The patterns as bytes, and from them.
AtlasPart pack(const StrainPatterns& patterns);
std::shared_ptr<const StrainPatterns> unpack_patterns(const StressAtlasSettings& settings,
                                                      const AtlasPart& part);

/// Collects the tables of a stress atlas, one ray after the other.
class StressAtlasMaker {
 public:
  StressAtlasMaker(const StressAtlasSettings& settings,
                   std::shared_ptr<const StrainPatterns> patterns);

  void begin_ray();
  /// Adds the tables of shape k of the grid on the present ray; each k once, from any thread.
  void put(int k, const std::vector<StateTable>& nodes);
  /// Call when all rays have ended, once.
  std::shared_ptr<const StressAtlas> finish();

 private:
  StressAtlasSettings settings_;
  std::shared_ptr<const StrainPatterns> patterns_;
  std::vector<std::vector<NumbersOfShapes>> values_;  ///< of each ray all bent states
};

}  // namespace flexopt
