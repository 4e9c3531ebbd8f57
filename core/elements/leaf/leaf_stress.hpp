#pragma once
// Stress of a leaf at its present state, whichever model it has: what is read from the stresses of
// its sections.
#include <functional>
#include <optional>
#include <vector>

#include "core/elements/leaf/leaf_results.hpp"

namespace flexopt {

/// Von Mises stress on the side of the normal, 1, or opposite, −1.
double von_mises(const SectionStress& section, double side, const NotchFactors& notch = {});
/// Derivatives of the stress at a peak by the stresses of its section; zero where it is zero.
SectionStress von_mises_slopes(const StressPeak& peak);

/// Stations at which the stress of a leaf is read: all pairs of these places, each in [0, 1], but
/// for those in rectangles at the four corners. A leaf of equal segments has them in each segment.
struct StressStations {
  enum class Kind {
    plate,
    beam,  ///< one stress counts for each section, the largest
    wire   ///< that of beams, at any place around the outline
  };
  Kind kind = Kind::plate;
  std::vector<double> along, across;
  double corner_along = 0, corner_across = 0;
  int segments = 1;

  bool in_corner(double x, double y) const;
  /// Along the leaf first, those across run fastest.
  std::vector<StressPlace> places() const;
};

/// The leaf must outlive it and keep its state.
struct LeafStress {
  using Sections = std::function<MatrixXd(const std::vector<StressPlace>&)>;

  int leaf = 0;  ///< index in the mechanism
  StressStations stations;
  /// A SectionStress in each column, at any places of the leaf.
  Sections sections;
  /// Present place of a point of the mid-surface; may be empty, then positions are left open.
  std::function<Vector3d(const StressPlace&)> position;
  /// largest(), where it is known already; its leaf and position are not read.
  std::optional<StressPeak> known = {};

  /// The largest stress of all stations; of those equal but for rounding the first.
  StressPeak largest() const;
  /// The places where the stress of a surface (of beams: of a section) is larger than at all
  /// stations around, their positions left open. The largest of them is largest().
  std::vector<StressPeak> peaks() const;
  /// The largest stress along each edge that has factors,
  ///
  ///     σ = K_membrane σ_mean ± K_bending σ_bend,
  ///
  /// at the stations of the edge. Flat sections only.
  std::vector<StressPeak> at_clamps(const ClampFactors& factors) const;
  /// The larger stress of both surfaces at each place; of a wire that of the section.
  std::vector<double> on_surface(const std::vector<StressPlace>& places) const;

 private:
  /// The larger of both surfaces at each place; of a wire the largest of each section.
  std::vector<StressPeak> peaks_at(const std::vector<StressPlace>& places) const;
  std::vector<StressPeak> plate_peaks(const std::vector<StressPeak>& stations_in_order) const;
};

/// LeafStress::sections of a leaf of n equal segments, from those of segment i.
MatrixXd sections_of_segments(
    const std::vector<StressPlace>& places, int n,
    const std::function<MatrixXd(int i, const std::vector<StressPlace>&)>& sections);

}  // namespace flexopt
