#pragma once
// How large the triangles of a plate are to be.
#include "designs/solids/contour_curves.hpp"

namespace flexopt {

/// Sizes wanted at places; between them they grow with the distance.
class PlaneSizes {
 public:
  struct Source {
    Point2<double> place;
    double size;
  };

  /// `largest` [m]; `slope`: growth of the size by distance.
  PlaneSizes(double largest, double slope) : largest_(largest), slope_(slope) {}
  /// Eight elements around half a circle, three through the wall behind each place of a contour,
  /// and one between lines within the plate and what faces them.
  void follow(const ContoursT<double>& contours, const std::vector<Chord>& lines);
  void add(const Source& source) { sources_.push_back(source); }
  /// All sizes times this; sources that others make needless are dropped.
  void finish(double coarsening);

  double at(const Point2<double>& place) const;
  /// Ends of elements along a curve: 0 … 1.
  std::vector<double> divided(const CurveT<double>& curve) const;

 private:
  double largest_, slope_, coarsening_ = 1;
  std::vector<Source> sources_;
};

}  // namespace flexopt
