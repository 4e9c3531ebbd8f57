#include "core/equilibrium/elastic_degree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/elements/solid/quartic.hpp"
#include "core/math/decompositions.hpp"

namespace flexopt {
namespace {

// A body of degree 4 misses terms of degree 5 and more: a link of two notches in one body is 1 %
// off in its drive stiffness at a share of 3, and 40 % at eight times as much.
constexpr double largest_share(ElasticDegree degree) {
  return degree == ElasticDegree::linear ? 0.3 : 3;
}

}  // namespace

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
  if (!model.quartic.empty()) return SymmetricEigen(change, K).eigenvalues().cwiseAbs().maxCoeff();
  const VectorXd second = 0.5 * (change * e);
  return std::sqrt(second.dot(K.llt().solve(second)) / first);
}

double share_over_limit(const ElasticBody& body, double share) {
  return share / largest_share(body.degree);
}

Check check_share(const ElasticBody& body, double share) {
  if (share_over_limit(body, share) <= 1) return {};
  return Because(fmt::format(
      "{} deforms further than degree {} holds: its geometric share is {:.3g}, {:g} at most; {}",
      body.name, static_cast<int>(body.degree), share, largest_share(body.degree),
      body.degree == ElasticDegree::linear ? "degree 4 holds further"
                                           : "cut it into bodies and hinges"));
}

double left_out_stiffness(const ElasticBodies& bodies, int k, const VectorXd& motion) {
  const ElasticModel& model = bodies.model(k);
  const HeldBody& held = bodies.held(k);
  if (!model.quartic.empty()) return 0;
  const MatrixXd change = cubic_along(bodies.body(k), bodies.solid(k), held.floating.local);
  if (change.size() == 0) return 0;
  const MatrixXd rows = holder_rows<double>(bodies.body(k), motion);
  VectorXd y = motions_in_frame<double>(held, rows);
  // the mean turn moves no interface against the others; the basis leaves out the means
  Vector3d turn = Vector3d::Zero();
  for (Eigen::Index a = 0; a < y.size(); a += 6) turn += y.segment<3>(a + 3);
  turn *= 6.0 / static_cast<double>(y.size());
  for (Eigen::Index a = 0; a < y.size(); a += 6)
    y.segment<3>(a) -= turn.cross(model.origins[static_cast<std::size_t>(a) / 6] +
                                  held.floating.local.segment<3>(a));
  const VectorXd e = elastic_basis(model.interfaces()).transpose() * y;
  return e.dot(change * e);
}

}  // namespace flexopt
