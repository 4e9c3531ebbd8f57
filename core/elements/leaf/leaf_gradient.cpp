#include "core/elements/leaf/leaf_gradient.hpp"

namespace flexopt {

// A variation is a column of numbers, of which q of each column has covectors: one product.
template <class S>
auto LeafGradient<S>::rates(const LeafQuadratic<S>& q, const Matrix& Y,
                            const std::vector<LeafVariation<S>>& variations) const -> Matrix {
  const auto columns = q.shape.cols(), parameters = q.shape.rows(),
             count = static_cast<Eigen::Index>(variations.size());
  // Rows: the shape, then the numbers that begin at these offsets.
  constexpr Eigen::Index point = 0, weight = 2, turn = 5, length = 14, edges = 15, per_edge = 15,
                         fixed = edges + 2 * per_edge;
  Matrix numbers(parameters + fixed, count), covectors(parameters + fixed, columns);
  for (Eigen::Index p = 0; p < count; ++p) {
    const LeafVariation<S>& v = variations[static_cast<std::size_t>(p)];
    auto to = numbers.col(p);
    to.head(parameters) = v.shape.template cast<S>();
    auto rest = to.template tail<fixed>();
    rest.template segment<2>(point) = v.point.template cast<S>();
    rest.template segment<3>(weight) = weight_rate(v).template cast<S>();
    rest.template segment<9>(turn) = v.turn.reshaped().template cast<S>();
    rest[length] = v.length;
    for (int e = 0; e < 2; ++e) {
      auto edge = rest.template segment<per_edge>(edges + per_edge * e);
      edge.template head<9>() = v.edge[e].rotation.reshaped();
      edge.template segment<3>(9) = v.edge[e].position;
      edge.template tail<3>() = v.edge[e].arm.template cast<S>();
    }
  }
  for (Eigen::Index k = 0; k < columns; ++k) {
    auto to = covectors.col(k);
    to.head(parameters) = q.shape.col(k);
    auto rest = to.template tail<fixed>();
    rest.template segment<2>(point) = q.point.col(k);
    rest.template segment<3>(weight) = q.weight.col(k);
    // increments in global axes and metres turn and shrink
    Matrix3<S> by_turn = Matrix3<S>::Zero();
    S by_length = 0;
    const auto add = [&](const Vector3<S>& g, const Vector3<S>& y, bool metres) {
      by_turn += g * y.transpose();
      if (metres) by_length -= g.cwiseProduct(y).sum();
    };
    if (rows_.point > 0)
      add(2.0 * Y.template block<3, 1>(rows_.unknowns, k),
          Y.template block<3, 1>(rows_.point_body(), k), true);
    for (int e = 0; e < 2; ++e) {
      const typename LeafQuadratic<S>::Edge& g = q.edge[static_cast<std::size_t>(k)][e];
      to[ShapeParameter::width] += g.across / width_;
      add(g.displacement, Y.template block<3, 1>(rows_.body(e), k), true);
      add(g.spin, Y.template block<3, 1>(rows_.body(e) + 3, k), false);
      auto edge = rest.template segment<per_edge>(edges + per_edge * e);
      edge.template head<9>() = g.rotation.reshaped();
      edge.template segment<3>(9) = g.position;
      edge.template tail<3>() = g.arm;
    }
    rest.template segment<9>(turn) = by_turn.reshaped();
    rest[length] = by_length;
  }
  return covectors.transpose() * numbers;
}

template class LeafGradient<double>;
template class LeafGradient<Jet>;

}  // namespace flexopt
