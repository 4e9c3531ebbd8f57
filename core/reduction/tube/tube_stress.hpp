#pragma once
// Strains and places of a tube leaf from tables: polynomials of its state about its bent states,
// joined along the ray as the fields are. Equations (T1) to (T4) of core/reduction/README.md.
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "core/elements/plate/plate_stress.hpp"
#include "core/reduction/expansion/stress_expansion.hpp"
#include "core/reduction/tube/state_table.hpp"
#include "core/reduction/tube/strain_patterns.hpp"
#include "core/reduction/tube/tube_dynamics.hpp"
#include "core/reduction/tube/tube_view.hpp"

namespace flexopt {

/// Largest change of a surface stress by the last degree of its tables, over the largest stress:
/// beyond it that may be off by more than about 1 %.
inline constexpr double largest_stress_change = 0.05;

/// The tables about the bent state `sigma` of the ray, the first column of `ray`, where `leaf`
/// stands or was moved to; rows as of StressPlaces. `fields`: its expand_fields().
StateTable stress_node(const ChordLeaf& leaf, double sigma, const Eigen::Matrix2d& ray,
                       const MatrixXd& fields);

/// Returns what the table about a bent state, counted from 0, changes by with w/L, t/L and ν, one
/// after the other; of a last one that does not move nothing is there.
using StressRateSource = std::function<const std::vector<StateTable>&(std::size_t node)>;

class TubeStress {
 public:
  using Place = TubeDynamics::Place;

  /// Stress tables of a flat leaf of uniform width and thickness. `view`: how the tables see the
  /// leaf; places and answers refer to the leaf. `patterns`: P of (A6), whose coefficients the
  /// tables hold; null where the tables hold the rows themselves.
  TubeStress(const PlateShape& shape, double force_centre, TubeView view = {},
             std::shared_ptr<const StrainPatterns> patterns = nullptr);

  /// Adds a bent state beyond the others.
  void add(StateTable node);
  double last_sigma() const { return nodes_.back().sigma; }

  struct Answer {
    StrainField strains;
    /// What the last degree changes, the largest one: von Mises stress of the change over the
    /// largest von Mises stress. Of patterns an upper bound of it where that is within
    /// largest_stress_change.
    double change = 0;
  };
  /// Needs two bent states; sigma inside of them or their mirror images.
  Answer evaluate(const Place& place) const;

  /// What the strains at a place change by along (σ, τ, twist, N, M1, M2) of it, then with (w/L,
  /// t/L, ν).
  class Slopes {
   public:
    /// `rates`: of these tables, which must outlive it and have patterns.
    Slopes(const TubeStress& tables, const Place& place, const StressRateSource& rates);
    struct Station {
      Strains value;
      Eigen::Matrix<double, 6, 9> slopes;
    };
    /// Strains and their slopes at a station of StrainField.
    Station at(int along, int across) const;

   private:
    using Terms = Eigen::Matrix<double, 10, Eigen::Dynamic>;
    const TubeStress* tables_;
    bool mirrored_;
    /// What a pattern is multiplied with for the value, its slopes by the state of the tables and
    /// those by the shape: of the half that is tabulated and of its image, stretching and bending.
    std::array<std::array<Terms, 2>, 2> terms_;
  };

  /// Place of the point (along, across) of the mid-surface seen from the middle of the edge that
  /// the tables call the base, in the chord frame, over L.
  Vector3d material_point(const Place& place, double along, double across) const;
  /// Places of all nodes of the mesh as seen in material_point(), along first.
  std::vector<Vector3d> nodes(const Place& place) const;
  const StressPlaces& places() const { return places_; }
  TubeView view() const { return view_; }

 private:
  using Weights = StressWeights;
  using Local = TubeDynamics::Local;
  /// Even and odd parts of rows on the half of the leaf that is tabulated, where a number is even +
  /// odd. On the other half it is even − odd.
  using Parts = Eigen::Ref<const MatrixXd>;  ///< even, odd
  Local locate(const Place& place) const;
  Weights weights(const Local& at, int total) const;
  /// Reads the even and odd parts of some rows.
  MatrixXd read(const Local& at, const Weights& weights, Eigen::Index first,
                Eigen::Index rows) const;
  /// Coefficients of `count` rows of the tables from `first` on: the even parts for each of the
  /// weights, then the odd ones.
  template <std::size_t sets>
  MatrixXd coefficients(const Local& at, const std::array<Weights, sets>& weights,
                        Eigen::Index first, Eigen::Index count) const;
  MatrixXd strains(const Local& at, const Parts& parts) const;
  /// Upper bound on the von Mises stress over Young's modulus, where the coefficients of stretching
  /// and bending, even and odd, have norms of these sums.
  double stress_bound(double stretching, double bending) const;
  /// The largest von Mises stress over Young's modulus; rows as of StrainField.
  double largest(const Eigen::Ref<const MatrixXd>& strains) const;
  /// Turns a vector from the axes of the tables into those of the leaf.
  Vector3d seen(const Vector3d& r) const;
  Vector3d node_place(const Local& at, const Parts& parts, int line, int node) const;

  PlateShape shape_;
  StressPlaces places_;
  TubeView view_;
  double force_centre_;
  std::shared_ptr<const StrainPatterns> patterns_;
  std::vector<StateTable> nodes_;
};

}  // namespace flexopt
