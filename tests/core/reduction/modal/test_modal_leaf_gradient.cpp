#include "core/math/decompositions.hpp"
#include "core/reduction/modal/modal_leaf_gradient.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/reduction/modal/modal_leaf_linear.hpp"
#include "support/held_leaf.hpp"

using namespace flexopt;
using namespace flexopt::held;
using flexopt::synthetic::Random;

namespace {

// From rest in steps, balanced.
std::unique_ptr<ModalLeaf> bent(const Design& d, const ModelOptions& model) {
  const auto mesh = std::make_shared<const PlateMesh>(leaf_shape(d.leaf, model));
  auto leaf = std::make_unique<ModalLeaf>(
      d.leaf, std::make_shared<const ModalModel>(mesh, model.method, model.modal_derivatives), 0);
  leaf->evaluate();
  EdgePoses now = edges(d, 0);
  const auto step = [&](double share) {
    const EdgePoses next = edges(d, share);
    Vector12d dq;
    for (int e = 0; e < 2; ++e)
      dq.segment<6>(6 * e) << next[e].position - now[e].position,
          rotation_log(next[e].axes * now[e].axes.transpose());
    leaf->move(next, dq);
    leaf->evaluate();
    now = next;
  };
  for (int s = 1; s <= 8; ++s)
    for (int i = 0; i < 12; ++i) step(s / 8.0);
  return leaf;
}

// Force on the bodies, and yᵀ(K − λM)y with the amplitudes where they are stationary.
std::vector<double> answer(const Design& d, const ModelOptions& model, const MatrixXd& Y,
                           const VectorXd& lambda) {
  const auto leaf = bent(d, model);
  const Matrix12d map = edge_map(d, edges(d, 1));
  const VectorXd force = map.transpose() * leaf->evaluation().force;
  std::vector<double> all(force.begin(), force.end());
  const int m = leaf->model().amplitudes();
  const LeafDynamics dynamics = leaf->dynamics(m);
  for (int k = 0; k < lambda.size(); ++k) {
    const MatrixXd D = dynamics.stiffness - lambda[k] * dynamics.mass;
    const Vector12d y = map * Y.col(k);
    double q = y.dot(D.topLeftCorner<12, 12>() * y);
    const VectorXd b = D.bottomLeftCorner(m, 12) * y;
    if (m > 0) q -= b.dot(VectorXd(Lu(D.bottomRightCorner(m, m)).solve(b)));
    for (int e = 0; e < 2; ++e) {  // the lever arms turn
      const Vector3d w = Y.block<3, 1>(6 * e + 3, k),
                     arm = edges(d, 1)[e].position - d.reference[e] - d.displacement[e];
      q += leaf->evaluation().force.segment<3>(6 * e).dot(w.cross(w.cross(arm)));
    }
    all.push_back(q);
  }
  return all;
}

void check(Flexure flexure, Reduction method, ModalDerivativeSet set, double thickness = 2e-3) {
  Random random(7);
  ModelOptions model;
  model.flexure = flexure;
  model.method = method;
  model.modal_derivatives = set;
  model.mesh = flexure == Flexure::plate ? std::array{5, 2} : std::array{6, 1};
  const Design design =
      random_design(models::leaf({0.3, -0.2, 0.1}, {2, 1, 0}, 0.1, 0.05, thickness), random);
  const LeafSpring& leaf = design.leaf;
  const double L = leaf.length;
  const LeafScale scale(leaf, flexure);
  MatrixXd Y(12, 3);
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 12; i += 3) Y.block<3, 1>(i, k) = random.vector<3>(i % 6 == 0 ? L : 1.0);
  const VectorXd lambda = Eigen::Vector3d(0, 40, 500) * scale.energy / scale.mass,
                 mu = lambda * scale.mass / scale.energy;

  const auto at = bent(design, model);
  const ModalLeafLinear linear(*at);
  const int m = linear.unknowns();
  LeafRows rows;
  rows.unknowns = m;
  const EdgePoses now = edges(design, 1);
  for (int e = 0; e < 2; ++e)
    rows.lever[e] = leaf.axes.transpose() *
                    (now[e].position - design.reference[e] - design.displacement[e]) / L;
  const auto rate = std::make_shared<const ModalModelRate>(
      at->model(), std::make_shared<const PlateMeshRate>(*at->model().mesh()));
  const ModalLeafGradient gradient(*at, rate, rows);

  // scaled increments, the amplitudes where the forms are stationary
  MatrixXd y = MatrixXd::Zero(rows.size(), 3);
  for (int k = 0; k < 3; ++k) {
    for (int e = 0; e < 2; ++e) {
      y.block<3, 1>(rows.body(e), k) = leaf.axes.transpose() * Y.block<3, 1>(6 * e, k) / L;
      y.block<3, 1>(rows.body(e) + 3, k) = leaf.axes.transpose() * Y.block<3, 1>(6 * e + 3, k);
    }
    if (m == 0) continue;
    MatrixXd V = MatrixXd::Zero(m + 12, m + 1);
    V.topLeftCorner(m, m).setIdentity();
    V.bottomRightCorner(12, 1) = rows.edge_rows(y.col(k)).bottomRows(12);
    const MatrixXd M = linear.mass_times(V).topRows(m), &H = at->generalised_tangent();
    const VectorXd b =
        H.bottomLeftCorner(m, 6) * (at->frame().B * V.bottomRightCorner(12, 1)) - mu[k] * M.col(m);
    y.col(k).head(m) = -Lu(H.bottomRightCorner(m, m) - mu[k] * M.leftCols(m)).solve(b);
  }
  check_derivatives({design, flexure, linear, gradient, rows, y, lambda,
                     [&](const Design& d) { return answer(d, model, Y, lambda); }},
                    random);
}

}  // namespace

TEST_CASE("derivatives of a leaf on the quadratic manifold agree with differences of rebuilt ones",
          "[reduction][slow]") {
  check(Flexure::plate, Reduction::quadratic_manifold, ModalDerivativeSet::all);
  check(Flexure::beam, Reduction::quadratic_manifold, ModalDerivativeSet::all);
}

TEST_CASE("derivatives of a leaf of modal derivatives agree with differences of rebuilt ones",
          "[reduction][slow]") {
  check(Flexure::plate, Reduction::modal_derivatives, ModalDerivativeSet::all);
  check(Flexure::plate, Reduction::modal_derivatives, ModalDerivativeSet::bending);
  check(Flexure::beam, Reduction::modal_derivatives, ModalDerivativeSet::all);
}

TEST_CASE("derivatives of a plate with third-order fields agree with differences of rebuilt ones",
          "[reduction][slow]") {
  check(Flexure::plate, Reduction::modal_derivatives, ModalDerivativeSet::third_order);
}

TEST_CASE("derivatives of a beam with third-order fields agree with differences of rebuilt ones",
          "[reduction][slow]") {
  // at 2 mm a field stands at the threshold of being kept
  check(Flexure::beam, Reduction::modal_derivatives, ModalDerivativeSet::third_order, 2.3e-3);
}
