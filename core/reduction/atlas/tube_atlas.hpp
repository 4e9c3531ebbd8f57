#pragma once
// Tube potentials of all flat leaves of uniform width and thickness, looked up instead of built:
// coefficients at Chebyshev points of (log w/L, log t/L), bending rays and Poisson's ratios.
// Equations (A1) to (A4) of core/reduction/README.md.
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/elements/plate/plate_mesh.hpp"
#include "core/reduction/atlas/stress_atlas.hpp"
#include "core/reduction/tube/tube_dynamics.hpp"
#include "core/reduction/tube/tube_potential.hpp"
#include "core/reduction/tube/tube_view.hpp"

namespace flexopt {

/// What an atlas is made of: two atlases of equal settings hold the same numbers.
struct AtlasSettings {
  std::array<int, 2> mesh = default_mesh;  ///< elements along and across of the leaves in it
  bool free_edge_torsion = true;
  std::array<double, 2> width{0.1, 2.5};                  ///< smallest and largest w/L
  std::array<double, 2> thickness{1.0 / 700, 1.0 / 50};   ///< smallest and largest t/L
  std::array<int, 2> points{17, 9};                       ///< along either, at least 2
  std::vector<double> poissons_ratios{0.25, 0.30, 0.35};  ///< ascending
  std::vector<double> rays{-1,   -0.92, -0.70, -0.38, 0,  // ρ, ascending, both ends ±1
                           0.38, 0.70,  0.92,  1};
  std::vector<double> sigmas{0, 0.03, 0.1, 0.22, 0.45, 0.8};  ///< bent states [rad], from 0
  bool dynamics = true;      ///< with tables of the internal dynamics
  int stress_patterns = 80;  ///< StressAtlasSettings::patterns; 0: no tables of stress
  int stress_samples = 150;  ///< StressAtlasSettings::samples

  int shapes() const { return points[0] * points[1]; }
  int tables() const { return static_cast<int>(poissons_ratios.size() * rays.size()); }
  bool operator==(const AtlasSettings&) const = default;
};

/// Shapes of the leaves of an atlas.
ShapeGrid shape_grid(const AtlasSettings& settings);

/// The Taylor coefficients that an atlas holds of a ray: of every bent state the monomials
/// (polynomial.hpp, 6 variables, degree ≤ 5) that the mirrors of a leaf allow.
struct AtlasTerm {
  int node = 0, monomial = 0;
};
std::vector<AtlasTerm> atlas_terms(const std::vector<double>& sigmas);
/// Whether a term is of the highest degree. These terms add least and are stored as integers of 16
/// bits.
bool is_highest(const AtlasTerm& term);
/// How many of the terms are not of the highest degree, and how many are.
std::array<int, 2> term_counts(const std::vector<AtlasTerm>& terms);
/// Settings of the stress tables of an atlas, which have every other ray.
StressAtlasSettings stress_settings(const AtlasSettings& settings);

/// How well an atlas agrees with tubes of the same bent states that were built anew, over random
/// shapes, one in each cell of its box.
struct AtlasCheck {
  struct Errors {
    double drive = 0;  ///< relative, of the moment along the ray
    double on_ray = 0;  ///< relative, of the worst stiffness or compliance of the leaf: |L⁻¹ΔKL⁻ᵀ|
    double off_ray = 0;    ///< as on_ray, at bending off the ray, twist, axial force, plane moments
    double frequency = 0;  ///< relative, of the six lowest internal ones on the ray and off it
    double stress = 0;     ///< relative, of the largest stress, at both; 0 without tables of it
  };
  struct Sample {
    double width = 0, thickness = 0, poissons_ratio = 0;
    Errors errors;
  };
  struct Ray {
    double rho = 0;
    std::vector<Sample> samples;  ///< cells with ascending width, then ascending thickness
    Errors largest() const;
    Errors median() const;
  };
  std::array<int, 2> cells{0, 0};  ///< of the box along log w/L and log t/L
  std::vector<Ray> rays;
};

/// Read-only; shared by threads.
class TubeAtlas {
 public:
  /// Numbers of the atlas in memory. `exponents`: two half-integers, doubled, for each ray and
  /// term: (p, q) of (A1). `values`: for each Poisson's ratio and ray a matrix of `stride` ×
  /// shapes, rows the terms below the highest degree, padded; shapes with ascending width, then
  /// ascending thickness. `highest`: the terms of the highest degree in the same layout, over
  /// `units`, one for each ray and term.
  struct Numbers {
    const std::int8_t* exponents = nullptr;
    const float* values = nullptr;
    const std::int16_t* highest = nullptr;
    const float* units = nullptr;
    /// Tables for each ray over the shapes of shape_grid(); none without dynamics.
    std::vector<CompressedTable> dynamics, stations;
    std::shared_ptr<const void> owner;  ///< keeps both alive
  };
  /// `stress`: null for none.
  TubeAtlas(AtlasSettings settings, Numbers numbers, AtlasCheck check = {},
            std::string fingerprint = {}, std::shared_ptr<const StressAtlas> stress = {});

  const AtlasSettings& settings() const { return settings_; }
  const Numbers& numbers() const { return numbers_; }
  const AtlasCheck& check() const { return check_; }
  const std::vector<AtlasTerm>& terms() const { return terms_; }
  const std::shared_ptr<const StressAtlas>& stress() const { return stress_; }
  /// Fingerprint that tells contents apart; only for an atlas from a file.
  const std::string& fingerprint() const { return fingerprint_; }
  /// Number of terms, padded so that every shape starts on a cache line.
  static int stride(int terms) { return (terms + 15) / 16 * 16; }

  /// Whether there are coefficients for leaves of this shape that bend so.
  Check covers(const PlateShape& shape, const TubeRange& range) const;

  /// Number of bent states, from the first on, that reach sigma; at least two.
  int nodes_to(double sigma) const;

  /// Tables of the dynamics about the first bent states, so many as reach sigma (at least two).
  /// Where there is no gap() and the settings have dynamics.
  std::vector<DynamicsNode> dynamics(const PlateShape& shape, const Eigen::Vector2d& ray,
                                     double sigma,
                                     StationsWanted stations = StationsWanted::yes) const;
  /// What they change by with (w/L, t/L, ν), each with the other two and the ray held.
  DynamicsRates dynamics_rates(const PlateShape& shape, const Eigen::Vector2d& ray, double sigma,
                               ShapeSlopes slopes = ShapeSlopes::all) const;

  /// Bent states of a leaf, in the form of TubeModel.
  struct Tube {
    Eigen::Matrix2d directions;  ///< D; its first column is the ray
    std::vector<TubeNode> nodes;
  };
  /// Looks up a leaf for which gap() is empty. `ray`: as in TubeRange, ray[0] ≥ 0; within 1e-3 of a
  /// ray of the atlas, that ray is used. `nodes`: number of bent states from the first on; 0: all.
  Tube look_up(const PlateShape& shape, const Eigen::Vector2d& ray, int nodes = 0) const;

  /// Tables of stress about the same bent states, which see the leaf as view() says. Needs
  /// stress().
  std::vector<StateTable> look_up_stress(const PlateShape& shape, const Eigen::Vector2d& ray,
                                         int nodes = 0) const;
  /// Source of the derivatives of the stress tables, for one thread. The atlas must outlive it.
  StressRateSource stress_rates(const PlateShape& shape, const Eigen::Vector2d& ray,
                                ShapeSlopes slopes = ShapeSlopes::all) const;
  static TubeView view(const Eigen::Vector2d& ray);

  /// What the bent states change by with (w/L, t/L, ν), each with the other two and the ray held,
  /// in the scaled units of the leaf: exact derivatives of the same interpolant.
  TubeNodeRates look_up_rates(const PlateShape& shape, const Eigen::Vector2d& ray, int nodes = 0,
                              ShapeSlopes slopes = ShapeSlopes::all) const;

 private:
  ShapeWeights weights(const PlateShape& shape, ShapeSlopes slopes) const;
  template <class Number>
  MatrixXd sums(const Number* numbers, int all_terms, int ray, int terms,
                const ShapeWeights& weights) const;
  std::vector<std::vector<std::vector<double>>> taylor(int ray, const ShapeWeights& weights,
                                                       int nodes) const;
  std::vector<Tube> assemble(const PlateShape& shape, const Eigen::Vector2d& ray, int nodes,
                             ShapeSlopes slopes) const;

  AtlasSettings settings_;
  Numbers numbers_;
  AtlasCheck check_;
  std::string fingerprint_;
  std::shared_ptr<const StressAtlas> stress_;
  std::vector<AtlasTerm> terms_;
  std::array<int, 2> counts_;  ///< of the terms below the highest degree, of those of it
  ShapeGrid grid_;
};

}  // namespace flexopt
