#pragma once
// The room that a mechanism takes: its leaves with their width and thickness and the boxes of its
// bodies, in one state. Equations (S19) and (S20) of core/response/README.md.
#include <array>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/mechanism/joint.hpp"
#include "core/mechanism/profile.hpp"
#include "core/response/response.hpp"

namespace flexopt {

/// Derivatives of the place of a body along parameters: 3 × parameters each.
struct BodyPlaceRate {
  MatrixXd position, spin;
};

/// Places of points (along, across) in [0, 1]² of a leaf's mid-surface [m].
using LeafPlaces = std::function<std::vector<Vector3d>(
    int leaf, const std::vector<std::array<double, 2>>& points)>;

/// What all places change by along parameters.
struct PlaceRates {
  /// Derivatives of the place of a leaf's point, which moves along the leaf by `along_rates`
  /// (empty: not at all): 3 × parameters.
  std::function<MatrixXd(int leaf, double along, double across, const VectorXd& along_rates)> leaf;
  std::vector<BodyPlaceRate> bodies;
  const std::vector<Mechanism>* directions = nullptr;  ///< of the mechanism's own numbers
};

/// A leaf, one leg of a folded leaf, or the box of a body.
struct SolidPart {
  int leaf = -1, body = -1;   ///< one of both
  double begin = 0, end = 1;  ///< of a leaf: from here to there along it
};
/// The leaves, of folded ones both legs, then the boxes in the order of their bodies.
std::vector<SolidPart> solid_parts(const Mechanism& mechanism);

/// Solids are numbered as solid_parts(). Each is an image of three coordinates u (SolidPoint::at):
///     leaf  along ∈ [0, 1] (of a leg: along that), across ∈ [0, 1], through the thickness ∈ [−1,
///     1] wire  along ∈ [0, 1], angle about the centre line [rad], 1 (0: on the centre line) box ∈
///     [−1, 1]³ along its edges
/// Leaves are interpolated between stations of their surfaces (S19).
class Solids {
 public:
  /// The mechanism must outlive this; `places` is called in the constructor alone.
  Solids(const Mechanism& mechanism, const LeafPlaces& places,
         const std::vector<JointBody>& bodies);
  /// Solids of the undeflected mechanism.
  static Solids undeflected(const Mechanism& mechanism);

  int count() const { return static_cast<int>(solids_.size()); }
  const Mechanism& mechanism() const { return *mechanism_; }
  const SolidPart& part(int solid) const { return solids_[solid].part; }
  bool is_leaf(int solid) const { return part(solid).leaf >= 0; }
  bool is_wire(int solid) const {
    return is_leaf(solid) && leaf_of(solid).section == Section::circular;
  }
  int body_of_box(int solid) const { return part(solid).body; }
  const std::string& name(int solid) const;

  /// Bounds of the coordinates.
  Vector3d lower(int solid) const;
  Vector3d upper(int solid) const;
  /// Place of a point and its derivatives along the coordinates; second ones in the order 00, 01,
  /// 02, 11, 12, 22.
  struct Local {
    Vector3d place = Vector3d::Zero();
    Matrix3d slopes = Matrix3d::Zero();
    std::array<Vector3d, 6> curvatures;
  };
  Local local(const SolidPoint& point) const;
  Vector3d place(const SolidPoint& point) const { return local(point).place; }
  /// Place of a point of a leaf's mid-surface or of a wire's centre line.
  Vector3d middle_place(int leaf, double along, double across) const;

  /// A sample point; samples lie all over the solid.
  struct Sample {
    Vector3d at, place;
  };
  /// Samples of a leaf's mid-surface or of a wire's centre line.
  std::vector<Sample> inner_samples(int solid) const;
  /// Grid of samples: `counts` along three coordinates, neighbours along the last one follow each
  /// other. `steps`: from one sample to the next along each of the coordinates of a point.
  struct SampleGrid {
    std::array<int, 3> counts{};
    Vector3d steps = Vector3d::Zero();
    std::vector<Sample> samples;
  };
  SampleGrid surface_samples(int solid) const;
  /// Points of the solid are not farther than half of this from a sample.
  double spacing(int solid) const;
  /// Half of the thickness of a leaf [m]; `along`: first coordinate of its solid.
  double half_thickness(int solid, double along) const;
  double half_thickness_rate(int solid, double along, const Mechanism& direction) const;
  /// Corners of a box along the global axes that holds the solid.
  const Vector3d& lowest(int solid) const { return solids_[solid].lowest; }
  const Vector3d& highest(int solid) const { return solids_[solid].highest; }

  /// Derivatives of the place of a point that keeps its coordinates: 3 × parameters.
  MatrixXd place_rates(const SolidPoint& point, const PlaceRates& rates) const;

 private:
  /// A point is Σ w_k(u) P_k.
  struct Solid {
    SolidPart part;
    std::vector<Vector3d> nodes;
    Vector3d lowest, highest;
    Vector3d reference = Vector3d::UnitZ();    ///< of a wire: its angles count from here
    Matrix3d rotation = Matrix3d::Identity();  ///< of a box
  };
  struct Weight {
    int node = 0;
    double value = 0;
    Vector3d slope = Vector3d::Zero();
    std::array<double, 6> curvature{};
  };
  std::vector<Weight> weights(const SolidPoint& point) const;
  const LeafSpring& leaf_of(int solid) const { return mechanism_->leaves[part(solid).leaf]; }
  void add_leaf(const SolidPart& part, const LeafPlaces& places);
  void add_box(const SolidPart& part, const JointBody& place);
  MatrixXd sum_of_rates(int solid, const std::vector<std::pair<int, double>>& weights,
                        const PlaceRates& rates) const;
  MatrixXd node_rates(const Solid& solid, int node, const PlaceRates& rates,
                      std::map<int, MatrixXd>& known) const;

  const Mechanism* mechanism_;
  std::vector<Solid> solids_;
};

// Places of the undeflected mechanism, and what they change by along parameters.

/// Place of a point of a leaf's undeflected mid-surface [m].
Vector3d undeflected_place(const LeafSpring& leaf, double along, double across);
/// What it changes by while the leaf's numbers change by those of `direction`, and the point moves
/// along it by `along_rate`.
Vector3d undeflected_place_rate(const LeafSpring& leaf, const LeafSpring& direction, double along,
                                double across, double along_rate = 0);
/// Derivatives of all places of the undeflected mechanism. `mechanism` and `directions` must
/// outlive the result.
PlaceRates undeflected_rates(const Mechanism& mechanism, const std::vector<Mechanism>& directions);

/// A profile of rates; factors of a profile that stays as it is have none.
inline double profile_rate(const std::vector<double>& rates, double along) {
  return rates.empty() ? 0 : profile_at(rates, along);
}

}  // namespace flexopt
