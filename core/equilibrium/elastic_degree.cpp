#include "core/equilibrium/elastic_degree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/elements/solid/mesh_energy.hpp"
#include "core/elements/solid/quartic.hpp"
#include "core/equilibrium/free_motions.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {

std::optional<double> geometric_share(const ElasticBodies& bodies, int k) {
  const ElasticModel& model = bodies.model(k);
  const VectorXd& local = bodies.held(k).floating.local;
  const MatrixXd basis = elastic_basis(model.interfaces());
  const VectorXd e = basis.transpose() * local;
  const MatrixXd K = basis.transpose() * model.stiffness * basis;
  const double first = e.dot(K * e);
  if (first <= 0) return std::nullopt;
  const MatrixXd change = cubic_along(bodies.body(k), bodies.solid(k), local);
  if (change.size() == 0) return std::nullopt;
  const double share = SymmetricEigen(change, K).eigenvalues().cwiseAbs().maxCoeff();
  if (!model.quartic.empty()) return share;
  const VectorXd second = 0.5 * (change * e);
  return std::max(share, std::sqrt(second.dot(K.llt().solve(second)) / first));
}

namespace {

// Coordinates on the basis of a body for motions of all rigid bodies, m × columns. The mean turn
// moves no interface against the others; the basis leaves out the means.
MatrixXd elastic_motions(const ElasticBodies& bodies, int k, const MatrixXd& motions) {
  const ElasticModel& model = bodies.model(k);
  const HeldBody& held = bodies.held(k);
  const MatrixXd rows = holder_rows<double>(bodies.body(k), motions);
  MatrixXd y = motions_in_frame<double>(held, rows);
  MatrixXd turn = MatrixXd::Zero(3, y.cols());
  for (Eigen::Index a = 0; a < y.rows(); a += 6) turn += y.middleRows<3>(a + 3);
  turn *= 6.0 / static_cast<double>(y.rows());
  for (Eigen::Index a = 0; a < y.rows(); a += 6)
    y.middleRows<3>(a) += hat(Vector3d(model.origins[static_cast<std::size_t>(a) / 6] +
                                       held.floating.local.segment<3>(a))) *
                          turn;
  return elastic_basis(model.interfaces()).transpose() * y;
}

// Largest relative change of a stiffness at the end-effector by A·e, `change`, to first order.
double largest_change(const System& system, int k, const MatrixXd& change) {
  const Eigen::Index n = 6 * std::ssize(system.poses());
  MatrixXd loads = MatrixXd::Zero(n, 6);
  loads.middleRows<6>(6 * system.mechanism().end_effector).setIdentity();
  double largest = 0;
  for (const bool held : {false, true}) {
    const MatrixXd motions = TangentFactor(system, held).answer(loads);
    const MatrixXd e = elastic_motions(system.elastic_bodies(), k, motions);
    const VectorXd compliance = loads.cwiseProduct(motions).colwise().sum().cwiseAbs(),
                   left_out = e.cwiseProduct(change * e).colwise().sum().cwiseAbs();
    for (int i = 0; i < 6; ++i)
      if (const double c = compliance[i]; c > 1e-12 * compliance.segment<3>(i - i % 3).maxCoeff())
        largest = std::max(largest, left_out[i] / c);
  }
  return largest;
}

}  // namespace

double degree_error(const System& system, int k, const std::optional<double>& share) {
  constexpr double of_linear = 0.003, of_quartic = 0.2;  // share from which on it is looked at
  constexpr double by_energy = 35, by_share = 0.06;      // (U12)
  const ElasticBodies& bodies = system.elastic_bodies();
  const ElasticBody& body = bodies.body(k);
  const VectorXd& local = bodies.held(k).floating.local;
  if (!share) return 0;
  if (body.degree == ElasticDegree::linear)
    return *share < of_linear
               ? 0
               : std::max(*share * *share,
                          largest_change(system, k, cubic_along(body, bodies.solid(k), local)));
  const double error = by_share * std::pow(*share, 4);
  if (*share < of_quartic || error > largest_degree_error) return error;
  return std::max(error, by_energy * std::abs(left_out_energy(body, bodies.solid(k), local)));
}

Check check_degree(const ElasticBody& body, double error) {
  if (error <= largest_degree_error) return {};
  return Because(fmt::format(
      "{} deforms further than degree {} holds: by what it leaves out a stiffness is off by some "
      "{:.2g} %, {:g} % at most; {}",
      body.name, static_cast<int>(body.degree), 100 * error, 100 * largest_degree_error,
      body.degree == ElasticDegree::linear ? "degree 4 holds further"
                                           : "cut it into two bodies where it bends"));
}

double left_out_stiffness(const ElasticBodies& bodies, int k, const VectorXd& motion) {
  if (!bodies.model(k).quartic.empty()) return 0;
  const MatrixXd change =
      cubic_along(bodies.body(k), bodies.solid(k), bodies.held(k).floating.local);
  if (change.size() == 0) return 0;
  const VectorXd e = elastic_motions(bodies, k, motion);
  return e.dot(change * e);
}

}  // namespace flexopt
