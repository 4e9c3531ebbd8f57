#include "optim/solvers/correction.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

/// A model and a truth that differ by a factor, by an offset, and by nothing.
ModelValues model(const VectorXd& x, bool truth, bool gradients) {
  const double a = x[0], b = x[1];
  ModelValues m;
  m.values.resize(3);
  MatrixXd d(3, 2);
  m.values[0] = 2 + std::sin(a) + b * b;
  d.row(0) << std::cos(a), 2 * b;
  m.values[1] = 0.01 * (a - b);  // the truth is far from it: an offset
  d.row(1) << 0.01, -0.01;
  m.values[2] = 3 + a;
  d.row(2) << 1, 0;
  if (truth) {
    const double f = 1.05 + 0.1 * a - 0.05 * b;
    d.row(0) = f * d.row(0) + m.values[0] * Eigen::RowVector2d(0.1, -0.05);
    m.values[0] *= f;
    m.values[1] += 1 + a * b;
    d.row(1) += Eigen::RowVector2d(b, a);
  }
  if (gradients) m.derivatives = d;
  return m;
}

VectorXd point(double a, double b) { return (VectorXd(2) << a, b).finished(); }

double error(const Correction& c, const VectorXd& x, Eigen::Index row) {
  VectorXd v = model(x, false, false).values;
  c.apply(x, v, nullptr);
  return std::abs(v[row] - model(x, true, false).values[row]);
}

}  // namespace

TEST_CASE("a correction with derivatives is consistent to first order") {
  const VectorXd x = point(0.3, 0.4);
  const Correction c = make_correction(x, model(x, false, true), model(x, true, true));
  const ModelValues truth = model(x, true, true);
  VectorXd values = model(x, false, false).values;
  MatrixXd derivatives = *model(x, false, true).derivatives;
  c.apply(x, values, &derivatives);
  CHECK((values - truth.values).norm() < 1e-14);
  CHECK((derivatives - *truth.derivatives).norm() < 1e-14);
  // beside x: the factor is linear here, so the first row is exact; the offset is not: rate 2
  for (const double h : {0.1, 0.05}) CHECK(error(c, point(0.3 + h, 0.4 - h), 0) < 1e-13);
  const double far = error(c, point(0.4, 0.3), 1), near = error(c, point(0.35, 0.35), 1);
  CHECK(far > 0);
  CHECK(far / near == Approx(4).epsilon(0.01));
  // derivatives of the corrected values are those of what it gives
  const VectorXd y = point(0.5, 0.1);
  VectorXd at_y = model(y, false, false).values;
  MatrixXd slopes = *model(y, false, true).derivatives;
  c.apply(y, at_y, &slopes);
  for (Eigen::Index j = 0; j < 2; ++j) {
    VectorXd up = y, down = y;
    up[j] += 1e-6, down[j] -= 1e-6;
    VectorXd a = model(up, false, false).values, b = model(down, false, false).values;
    c.apply(up, a, nullptr);
    c.apply(down, b, nullptr);
    CHECK((slopes.col(j) - (a - b) / 2e-6).norm() < 1e-8);
  }
}

TEST_CASE("without derivatives a correction holds at this design and at the last ones") {
  const VectorXd x0 = point(0.3, 0.4), x1 = point(0.4, 0.35), x2 = point(0.42, 0.5);
  const auto at = [](const VectorXd& x, const std::optional<Correction>& last = {}) {
    return make_correction(x, model(x, false, false), model(x, true, false), last);
  };
  const Correction c0 = at(x0);
  CHECK(c0.factor_slope.isZero(0));
  CHECK(error(c0, x0, 0) < 1e-14);
  const Correction c1 = at(x1, c0);
  for (Eigen::Index row = 0; row < 3; ++row) {
    CHECK(error(c1, x1, row) < 1e-14);
    CHECK(error(c1, x0, row) < 1e-14);
  }
  const Correction c2 = at(x2, c1);
  CHECK(error(c2, x2, 0) < 1e-14);
  CHECK(error(c2, x1, 0) < 1e-14);
  CHECK(error(c2, x0, 0) < 0.5 * error(at(x2), x0, 0));  // and learns
}
