#include "optim/solvers/correction.hpp"

#include <cassert>

namespace flexopt {

void Correction::apply(const VectorXd& x, VectorXd& values, MatrixXd* derivatives) const {
  assert(values.size() == factor.size());
  const VectorXd d = x - at;
  const VectorXd factors = factor + factor_slope * d;
  if (derivatives)
    *derivatives = factors.asDiagonal() * *derivatives +
                   MatrixXd(values.asDiagonal() * factor_slope) + offset_slope;
  values = values.cwiseProduct(factors) + offset + offset_slope * d;
}

Correction make_correction(const VectorXd& x, const ModelValues& reduced, const ModelValues& full,
                           const std::optional<Correction>& last) {
  const Eigen::Index m = reduced.values.size(), n = x.size();
  assert(full.values.size() == m);
  Correction c{x, VectorXd::Ones(m), VectorXd::Zero(m), MatrixXd::Zero(m, n), MatrixXd::Zero(m, n)};
  const bool exact = reduced.derivatives && full.derivatives;
  for (Eigen::Index i = 0; i < m; ++i) {
    const double r = reduced.values[i], f = full.values[i];
    const bool by_factor = r != 0 && f / r > 0.5 && f / r < 2;
    (by_factor ? c.factor : c.offset)[i] = by_factor ? f / r : f - r;
    auto slope = (by_factor ? c.factor_slope : c.offset_slope).row(i);
    if (exact) {
      slope = full.derivatives->row(i) - c.factor[i] * reduced.derivatives->row(i);
      if (by_factor) slope /= r;
      continue;
    }
    if (!last) continue;
    const Eigen::RowVectorXd s = (x - last->at).transpose();
    const double change = by_factor ? c.factor[i] - last->factor[i] : c.offset[i] - last->offset[i];
    slope = (by_factor ? last->factor_slope : last->offset_slope).row(i);
    if (s.squaredNorm() > 0) slope += (change - slope.dot(s)) / s.squaredNorm() * s;
  }
  return c;
}

}  // namespace flexopt
