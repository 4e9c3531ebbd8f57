#include "core/equilibrium/elastic_degree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/elements/solid/mesh_energy.hpp"
#include "core/elements/solid/quartic.hpp"
#include "core/math/decompositions.hpp"

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

// (U12): bounds what seven notches and bars were off by, README.md of core/elements/solid.
double degree_error(const ElasticBodies& bodies, int k, const std::optional<double>& share) {
  constexpr double negligible = 0.2;  // share from which on the energy is looked at
  constexpr double by_energy = 35, by_share = 0.06;
  if (!share) return 0;
  if (bodies.body(k).degree == ElasticDegree::linear) return *share;
  const double error = by_share * std::pow(*share, 4);
  if (*share < negligible || error > largest_degree_error(bodies.body(k))) return error;
  return std::max(error, by_energy * std::abs(left_out_energy(bodies.body(k), bodies.solid(k),
                                                              bodies.held(k).floating.local)));
}

Check check_degree(const ElasticBody& body, double error) {
  const double largest = largest_degree_error(body);
  if (error <= largest) return {};
  return Because(fmt::format(
      "{} deforms further than degree {} holds: by what it leaves out a stiffness is off by some "
      "{:.2g} %, {:g} % at most; {}",
      body.name, static_cast<int>(body.degree), 100 * error, 100 * largest,
      body.degree == ElasticDegree::linear ? "degree 4 holds further"
                                           : "cut it into two bodies where it bends"));
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
