#include "core/elements/leaf/leaf_gradient.hpp"

namespace flexopt {

template <class S>
S LeafGradient<S>::rate(const LeafQuadratic<S>& q, const Matrix& Y, int k,
                        const LeafVariation<S>& v) const {
  S sum = q.shape.col(k).cwiseProduct(v.shape).sum() + q.point.col(k).cwiseProduct(v.point).sum();
  if (!weight_.isZero(0)) sum += q.weight.col(k).dot(weight_rate(v).template cast<S>());
  const Matrix3d grows = v.turn - v.length * Matrix3d::Identity();
  if (rows_.point > 0) {
    const Vector3<S> y_u = grows * Y.template block<3, 1>(rows_.point_body(), k);
    sum += 2.0 * Y.template block<3, 1>(rows_.unknowns, k).dot(y_u);
  }
  for (int e = 0; e < 2; ++e) {
    const typename LeafQuadratic<S>::Edge& g = q.edge[static_cast<std::size_t>(k)][e];
    const auto body = Y.col(k).template segment<6>(rows_.body(e));
    const Vector3<S> displacement = grows * body.template head<3>(),
                     spin = v.turn * body.template tail<3>();
    sum += g.rotation.cwiseProduct(v.edge[e].rotation).sum() + g.position.dot(v.edge[e].position) +
           g.arm.cwiseProduct(v.edge[e].arm).sum() +
           g.across * (v.shape[ShapeParameter::width] / width_) + g.displacement.dot(displacement) +
           g.spin.dot(spin);
  }
  return sum;
}

template class LeafGradient<double>;
template class LeafGradient<Jet>;

}  // namespace flexopt
