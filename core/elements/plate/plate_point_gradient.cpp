// The share of the material point in PlateGradient: equation (S12) of core/response/README.md.
#include "core/elements/plate/plate_gradient.hpp"

namespace flexopt {

// The energy f·(u − Σ w N) of the material point, with its force f.
template <class S>
void PlateGradient<S>::add_point_force() {
  const Eigen::RowVector3<S> f = state_.point_force.transpose();
  for (const NodalWeight& w : plate_->support().point)
    nodal_force_[w.line].row(w.function) -= w.weight * f;
  for (int p = 0; p < directions(); ++p)
    for (const NodalWeight& w : point_rates_[p])
      shape_force_[p][w.line].row(w.function) -= w.weight * f;
}

// The row of the condition u − Σ w N + c0, c0 the undeflected place, and what moving weights do.
template <class S>
void PlateGradient<S>::add_point_rates(const std::array<Matrix, 2>& edge_rates,
                                       const std::vector<LeafVariation<S>>& variations,
                                       Matrix& rows) const {
  if (rows_.point == 0) return;
  // of the undeflected place, along the leaf, across it and by the shape
  const auto rest = [&](const NodalWeight& w) {
    return Vector3d(plate_->place_ratio() * mesh_->undeflected(w.line).row(w.function).transpose());
  };
  std::array<Vector3d, 2> by_place{Vector3d::Zero(), Vector3d::Zero()};
  for (int a = 0; a < 2; ++a)
    for (const NodalWeight& w : plate_->support().point_slopes[a])
      by_place[a] += w.weight * rest(w);
  std::vector<Vector3d> by_shape(static_cast<std::size_t>(directions()), Vector3d::Zero());
  for (int p = 0; p < directions(); ++p) {
    for (const NodalWeight& w : point_rates_[p]) by_shape[p] += w.weight * rest(w);
    if (rate_->shape[p].undeflected.empty()) continue;
    for (const NodalWeight& w : plate_->support().point)
      by_shape[p] += plate_->place_ratio() * w.weight *
                     rate_->shape[p].undeflected[w.line].row(w.function).transpose();
  }
  const auto nodal = [&](const NodalWeight& w) -> Vector3<S> {
    return state_.nodal[w.line].row(w.function).transpose();
  };
  for (int k = 0; k < static_cast<int>(variations.size()); ++k) {
    const LeafVariation<S>& v = variations[k];
    const Vector3<S>& u = state_.point;
    Vector3<S> rate = v.turn * u - v.length * u;
    for (int a = 0; a < 2; ++a) rate += (v.point[a] * by_place[a]).template cast<S>();
    for (int p = 0; p < directions(); ++p) {
      rate += (v.shape[p] * by_shape[p]).template cast<S>();
      for (const NodalWeight& w : point_rates_[p]) rate -= v.shape[p] * w.weight * nodal(w);
    }
    for (const NodalWeight& w : plate_->support().point) {
      if (const int e = edge_at(w.line); e >= 0)
        rate -= w.weight * edge_rates[e].template block<1, 3>(w.function, 3 * k).transpose();
    }
    for (int a = 0; a < 2; ++a)
      for (const NodalWeight& w : plate_->support().point_slopes[a])
        rate -= v.point[a] * w.weight * nodal(w);
    rows.template block<3, 1>(rows_.unknowns, k) += rate;
  }
}

// q += 2 y_f·y_u − 2 y_f·Σ w N1 − f·Σ w N2
template <class S>
void PlateGradient<S>::add_point_quadratic(const Matrix& Y, const std::vector<Matrix>& N1,
                                           const std::vector<Matrix>& N2, LeafQuadratic<S>& q,
                                           std::vector<Matrix>& n1) const {
  if (rows_.point == 0) return;
  const Vector3<S>& f = state_.point_force;
  for (int k = 0; k < static_cast<int>(Y.cols()); ++k) {
    const Vector3<S> y_f = Y.template block<3, 1>(rows_.unknowns, k);
    q.stiffness[k] += 2.0 * y_f.dot(Y.template block<3, 1>(rows_.point_body(), k));
    const auto product = [&](const NodalWeight& w) {
      const int e = edge_at(w.line);
      S sum = 2.0 * y_f.dot(N1[w.line].template block<1, 3>(w.function, 3 * k).transpose());
      if (e >= 0) sum += f.dot(N2[w.line].template block<1, 3>(w.function, 3 * k).transpose());
      return sum;
    };
    for (const NodalWeight& w : plate_->support().point) {
      const S share = product(w);
      q.stiffness[k] -= w.weight * share;
      const int e = edge_at(w.line);
      if (e < 0) continue;
      n1[w.line].template block<1, 3>(w.function, 3 * k) -= (2.0 * w.weight) * y_f.transpose();
      q.state.template block<3, 1>(rows_.unknowns, k) -=
          w.weight * N2[w.line].template block<1, 3>(w.function, 3 * k).transpose();
    }
    for (int p = 0; p < q.shape.rows(); ++p)
      for (const NodalWeight& w : point_rates_[p]) q.shape(p, k) -= w.weight * product(w);
    for (int a = 0; a < 2; ++a)
      for (const NodalWeight& w : plate_->support().point_slopes[a])
        q.point(a, k) -= w.weight * product(w);
  }
}

#define INSTANTIATE(S)                                                                          \
  template void PlateGradient<S>::add_point_force();                                            \
  template void PlateGradient<S>::add_point_rates(                                              \
      const std::array<Matrix, 2>&, const std::vector<LeafVariation<S>>&, Matrix&) const;       \
  template void PlateGradient<S>::add_point_quadratic(                                          \
      const Matrix&, const std::vector<Matrix>&, const std::vector<Matrix>&, LeafQuadratic<S>&, \
      std::vector<Matrix>&) const;
INSTANTIATE(double)
INSTANTIATE(Jet)
#undef INSTANTIATE

}  // namespace flexopt
