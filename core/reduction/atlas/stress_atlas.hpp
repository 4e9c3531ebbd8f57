#pragma once
// Tables of stress of flat leaves of any shape, looked up instead of expanded: a few patterns of
// strains, their coefficients compressed over the shapes. Equation (A6) of
// core/reduction/README.md.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/reduction/atlas/compressed_table.hpp"
#include "core/reduction/tube/tube_stress.hpp"

namespace flexopt {

/// What a stress atlas is made of.
struct StressAtlasSettings {
  ShapeGrid grid;
  std::vector<double> rays, sigmas;
  std::array<int, 2> mesh = default_mesh;
  bool free_edge_torsion = true;
  int patterns = 120;       ///< of strains and places over the leaf
  int samples = 150;        ///< leaves that they are found from
  double tolerance = 5e-3;  ///< of a coefficient's part in the largest stress, on the grid
};

/// Patterns of the rows of StressPlaces: strains e = t P a, κ = 2 P a, places P a.
class StressPatterns {
 public:
  /// `P`: rows × patterns, orthonormal columns.
  StressPatterns(std::array<int, 2> mesh, MatrixXd P);
  /// From leaves at random places of the box.
  explicit StressPatterns(const StressAtlasSettings& settings);

  const MatrixXd& P() const { return P_; }
  /// P for the tables that look_up() answers with.
  const std::shared_ptr<const PatternRows>& rows() const { return rows_of_P_; }
  /// A table of coefficients a, from one of a leaf.
  StateTable coefficients(const StateTable& node, double thickness) const;
  /// Adds what the strains of a table, `end` of two put together with these weights, change by with
  /// (w/L, t/L, ν), from what its coefficients do.
  void add_rates(const StateTable& coefficients, const std::array<StateTable, 3>& by_shape,
                 double thickness, const StateWeights<double>& weights, std::size_t end,
                 StressRates& to) const;

 private:
  VectorXd scale(double thickness) const;

  Eigen::Index rows_, half_;  ///< all, and so many of e and of κ
  MatrixXd P_;
  std::shared_ptr<const PatternRows> rows_of_P_;
};

class StressAtlas {
 public:
  /// `tables`: of each ray all bent states. `owner`: keeps their numbers alive.
  StressAtlas(StressAtlasSettings settings, StressPatterns patterns,
              std::vector<CompressedTable> tables, std::shared_ptr<const void> owner)
      : settings_(std::move(settings)),
        patterns_(std::move(patterns)),
        tables_(std::move(tables)),
        owner_(std::move(owner)) {}

  const StressAtlasSettings& settings() const { return settings_; }
  const StressPatterns& patterns() const { return patterns_; }
  const std::vector<CompressedTable>& tables() const { return tables_; }
  /// Coefficients of the patterns about the first `nodes` bent states of a leaf in the box on the
  /// ray (1, rho), rho within the rays.
  std::vector<StateTable> look_up(const PlateShape& shape, double rho, int nodes) const;
  /// Of the same leaf; this must outlive it.
  StressRateSource rates(const PlateShape& shape, double rho,
                         ShapeSlopes slopes = ShapeSlopes::all) const;

  /// As one block of numbers for a file, and from it. `data` is aligned to 64 bytes and kept by
  /// `owner`; null where the block is not one of these settings.
  std::string pack() const;
  static std::shared_ptr<const StressAtlas> unpack(const StressAtlasSettings& settings,
                                                   const char* data, std::size_t size,
                                                   std::shared_ptr<const void> owner);

 private:
  template <class LookUp>
  StateTable coefficients(double rho, std::size_t n, const LookUp& look_up) const;

  StressAtlasSettings settings_;
  StressPatterns patterns_;
  std::vector<CompressedTable> tables_;
  std::shared_ptr<const void> owner_;
};

/// Collects the tables of a stress atlas, one ray after the other.
class StressAtlasMaker {
 public:
  explicit StressAtlasMaker(const StressAtlasSettings& settings);

  /// Those of shape k of the grid on the present ray; each k once, by any thread.
  void put(int k, const std::vector<StateTable>& nodes);
  /// All shapes of the ray are there.
  void end_ray();
  /// All rays are.
  std::shared_ptr<const StressAtlas> finish();

 private:
  StressAtlasSettings settings_;
  StressPatterns patterns_;
  std::vector<MatrixXd> values_;  ///< of each bent state: numbers × shapes
  std::shared_ptr<std::vector<CompressedNumbers>> made_ =
      std::make_shared<std::vector<CompressedNumbers>>();
};

}  // namespace flexopt
