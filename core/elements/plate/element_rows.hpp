#pragma once
// Rows that stand against the nodal values of an element, and sums of their squares.
#include <vector>

#include "core/elements/plate/plate_mesh.hpp"

namespace flexopt {

template <class S>
using ElementRow = Eigen::Matrix<S, 16, 1>;

// A sum of squares, or its derivative: A += w a aᵀ.
inline void add_square(PlateMesh::Matrix16& A, double w, const ElementRow<double>& a) {
  A.noalias() += (w * a) * a.transpose();
}
inline void add_square(PlateMesh::Matrix16& A, const Dual1& w, const ElementRow<Dual1>& a) {
  ElementRow<double> value, half;
  for (int k = 0; k < 16; ++k) {
    value[k] = a[k].value;
    half[k] = w.value * a[k].derivatives[0] + 0.5 * w.derivatives[0] * a[k].value;
  }
  A.noalias() += half * value.transpose();
  A.noalias() += value * half.transpose();
}

template <class S>
void set_row(PlateMesh::Matrix16& A, int row, const ElementRow<S>& a) {
  for (int k = 0; k < 16; ++k) A(row, k) = part_of(a[k]);
}

// Collects the operators of plate_curvature.hpp, point by point.
template <class S>
class CurvatureRows {
 public:
  void add(const S& weight, const ElementRow<S>& x, const ElementRow<S>& y,
           const ElementRow<S>& second) {
    points_.push_back({weight, x, y, second});
  }
  void give(PlateMesh::Element& element) const {
    const auto n = static_cast<Eigen::Index>(points_.size());
    element.curvature.resize(3 * n, 16);
    element.curvature_weight.resize(n);
    for (Eigen::Index g = 0; g < n; ++g) {
      const Point& point = points_[static_cast<std::size_t>(g)];
      element.curvature_weight[g] = part_of(point.weight);
      for (int k = 0; k < 16; ++k) {
        element.curvature(g, k) = part_of(point.x[k]);
        element.curvature(n + g, k) = part_of(point.y[k]);
        element.curvature(2 * n + g, k) = part_of(point.second[k]);
      }
    }
  }

 private:
  struct Point {
    S weight;
    ElementRow<S> x, y, second;
  };
  std::vector<Point> points_;
};

}  // namespace flexopt
