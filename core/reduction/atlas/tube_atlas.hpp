#pragma once
// Tube potentials of all flat leaves of uniform width and thickness, looked up instead of built:
// coefficients at Chebyshev points of (log w/L, log t/L), bending rays and Poisson's ratios.
// Equations (A1) to (A4) of core/reduction/README.md.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/elements/plate/plate_mesh.hpp"
#include "core/reduction/atlas/coded_tables.hpp"
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
  std::array<int, 2> points{15, 11};                      ///< along either, at least 2
  std::vector<double> poissons_ratios{0.25, 0.30, 0.35};  ///< ascending
  std::vector<double> rays{-1, -0.7, -0.55, -0.38, -0.2,  // ρ, ascending, both ends ±1
                           0,  0.19, 0.38,  0.7,   1};
  std::vector<double> sigmas{0, 0.03, 0.1, 0.22, 0.45, 0.8};  ///< bent states [rad], from 0
  bool dynamics = true;      ///< with tables of the internal dynamics
  int stress_patterns = 80;  ///< StressAtlasSettings::patterns; 0: no tables of stress
  int stress_samples = 150;  ///< StressAtlasSettings::samples

  bool operator==(const AtlasSettings&) const = default;
};

/// Shapes of the leaves of an atlas.
ShapeGrid shape_grid(const AtlasSettings& settings);
/// The leaf at a place of a grid.
PlateShape shape_at(const AtlasSettings& settings, const Vector3d& place);

/// The monomials (polynomial.hpp, 6 variables, degree ≤ 5) of which an atlas holds the Taylor
/// coefficients about a bent state: those that the mirrors of a leaf allow.
std::vector<int> atlas_terms(double sigma);
/// The tables of the internal dynamics about a bent state.
TableForm dynamics_form();
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

    static constexpr std::array parts{&Errors::drive, &Errors::on_ray, &Errors::off_ray,
                                      &Errors::frequency, &Errors::stress};
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
  /// Coefficients of the potentials, in the order of atlas_terms(); numbers of the internal
  /// dynamics and of the motion of stations, null without dynamics.
  struct Tables {
    std::shared_ptr<const CodedTables> potentials, dynamics, stations;
  };
  /// `stress`: null for none.
  TubeAtlas(AtlasSettings settings, Tables tables, AtlasCheck check = {},
            std::string fingerprint = {}, std::shared_ptr<const StressAtlas> stress = {});

  const AtlasSettings& settings() const { return settings_; }
  const Tables& tables() const { return tables_; }
  const AtlasCheck& check() const { return check_; }
  const std::shared_ptr<const StressAtlas>& stress() const { return stress_; }
  /// Fingerprint that tells contents apart; only for an atlas from a file.
  const std::string& fingerprint() const { return fingerprint_; }
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
  std::vector<std::vector<std::vector<double>>> taylor(int ray, const CodedTables::Place& at,
                                                       int nodes) const;
  std::vector<Tube> assemble(const PlateShape& shape, const Eigen::Vector2d& ray, int nodes,
                             ShapeSlopes slopes) const;

  AtlasSettings settings_;
  Tables tables_;
  AtlasCheck check_;
  std::string fingerprint_;
  std::shared_ptr<const StressAtlas> stress_;
};

}  // namespace flexopt
