#include "core/math/decompositions.hpp"
#include "core/reduction/modal/modal_model_rate.hpp"

#include <Eigen/QR>
#include <catch2/catch.hpp>
#include <functional>

#include "core/math/ridders.hpp"

using namespace flexopt;

namespace {

PlateShape shape(Flexure flexure) {
  PlateShape s;
  s.flexure = flexure;
  s.mesh = flexure == Flexure::plate ? std::array{5, 2} : std::array{6, 1};
  return s;
}

PlateShape varied(PlateShape s, int p, double t) {
  (p == ShapeParameter::width       ? s.width
   : p == ShapeParameter::thickness ? s.thickness
                                    : s.poissons_ratio) *= 1 + t;
  return s;
}

ModalModel model(const PlateShape& s, Reduction method, ModalDerivativeSet set) {
  return {std::make_shared<PlateMesh>(s), method, set};
}

MatrixXd orthonormal(const MatrixXd& F) {
  return Eigen::HouseholderQR<MatrixXd>(F).householderQ() * MatrixXd::Identity(F.rows(), F.cols());
}

// On the span of the columns.
MatrixXd projector(const MatrixXd& F) {
  const MatrixXd Q = orthonormal(F);
  return Q * Q.transpose();
}

MatrixXd projector_rate(const MatrixXd& F, const MatrixXd& rate) {
  const MatrixXd Q = orthonormal(F), R = Q.transpose() * F;
  const MatrixXd out = rate - Q * (Q.transpose() * rate);
  const MatrixXd half = Lu(R.transpose()).solve(out.transpose()).transpose() * Q.transpose();
  return half + half.transpose();
}

/// Of f(t) at 0 against extrapolated differences.
void check(const char* what, const MatrixXd& exact, double tolerance,
           const std::function<MatrixXd(double)>& f) {
  const double size = std::max(f(0).cwiseAbs().maxCoeff(), exact.cwiseAbs().maxCoeff());
  const Derivatives d = ridders(
      [&](double t) -> std::vector<double> {
        const MatrixXd x = f(t);
        return {x.data(), x.data() + x.size()};
      },
      0, 0.02, 5);
  REQUIRE(d.value.size() == static_cast<std::size_t>(exact.size()));
  double worst = 0, noise = 0;
  for (std::size_t i = 0; i < d.value.size(); ++i) {
    worst = std::max(worst, std::abs(d.value[i] - exact.data()[i]) - 10 * d.error[i]);
    noise = std::max(noise, d.error[i]);
  }
  INFO(what << ": off by " << worst << ", differences good to " << noise << ", size " << size);
  CHECK(worst < tolerance * size);
  CHECK(noise < 1e3 * tolerance * size);
}

void check(Flexure flexure, Reduction method, ModalDerivativeSet set) {
  const PlateShape s = shape(flexure);
  const ModalModel at = model(s, method, set);
  const ModalModelRate rate(at, std::make_shared<PlateMeshRate>(*at.mesh()));
  for (int p = 0; p < 3; ++p) {
    INFO((flexure == Flexure::plate ? "plate, " : "beam, ") << "parameter " << p);
    const double unit = p == ShapeParameter::width       ? s.width
                        : p == ShapeParameter::thickness ? s.thickness
                                                         : s.poissons_ratio;
    const ModalModelRate::Shape& r = rate.shape[p];
    const auto near = [&](double t) { return model(varied(s, p, t), method, set); };
    check("lines that follow the edges", unit * r.follow, 1e-9,
          [&](double t) { return near(t).line_shapes(); });
    check("boundary modes", unit * r.boundary, 1e-9, [&](double t) { return near(t).boundary(); });
    check("derivatives", unit * r.theta, 1e-9, [&](double t) { return near(t).derivatives(); });
    if (at.slaved()) continue;
    check("span", unit * projector_rate(at.fields(), r.fields), 1e-7,
          [&](double t) { return projector(near(t).fields()); });
  }
}

}  // namespace

TEST_CASE("derivatives of the fields of a modal leaf are differences of rebuilt ones",
          "[reduction][slow]") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam}) {
    check(flexure, Reduction::quadratic_manifold, ModalDerivativeSet::all);
    check(flexure, Reduction::modal_derivatives, ModalDerivativeSet::bending);
    check(flexure, Reduction::modal_derivatives, ModalDerivativeSet::all);
    check(flexure, Reduction::modal_derivatives, ModalDerivativeSet::third_order);
  }
}
