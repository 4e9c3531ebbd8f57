#include "core/response/modes/point_forces.hpp"

#include <fmt/format.h>

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

// Forces along x, y, z on a material point of a leaf: the motion of its place by each unknown of
// the leaf, transposed.
Check add_on_leaf(const MechanismFactor& factor, const NamedPoint& point, LeafRates& rates,
                  MatrixXd& forces) {
  const MechanismFactor::Leaf& leaf = factor.leaves()[point.leaf];
  const auto gradient = leaf.linear->gradient(rates, leaf.rows);
  if (!gradient) return Because(gradient.error());
  LeafVariation<double> none;  // a leaf as it is: only its state moves
  none.shape = VectorXd::Zero(
      ShapeParameter::sizes +
      rates.profiles().coordinates(factor.system().mechanism().leaves[point.leaf], {}).size());
  const int unknowns = leaf.rows.size();
  const auto fields = (*gradient)->fields(
      MatrixXd::Identity(unknowns, unknowns),
      std::vector<LeafVariation<double>>(static_cast<std::size_t>(unknowns), none));
  const LeafScale& scale = leaf.linear->scale();
  const MatrixXd motion =
      scale.length * scale.axes * fields->place_rates(point.along, point.across);
  factor.add_leaf_force(leaf, 1, motion.transpose(), forces);
  return {};
}

// Forces and moments on the reference point of the body.
MatrixXd point_on_body_forces(const MechanismFactor& factor, const NamedPoint& point) {
  MatrixXd forces = MatrixXd::Zero(factor.size(), point.motions());
  auto on_body = forces.middleRows<6>(6 * *point.body);
  if (point.direction)
    on_body.col(0) = *point.direction;
  else
    on_body.topRows<3>().setIdentity();
  on_body.bottomRows<3>() +=
      hat(point.lever(factor.system().pose(*point.body))) * on_body.topRows<3>();
  factor.clear_held(forces);
  return forces;
}

}  // namespace

Answer<MatrixXd> point_forces(const MechanismFactor& factor, const std::vector<NamedPoint>& points,
                              LeafRates& rates) {
  MatrixXd all(factor.size(), 0);
  for (const NamedPoint& point : points) {
    MatrixXd forces = MatrixXd::Zero(factor.size(), 3);
    if (point.body)
      forces = point_on_body_forces(factor, point);
    else if (const Check known = add_on_leaf(factor, point, rates, forces); !known)
      return Because(fmt::format("{} {}: {}", point.kind, point.name, known.error()));
    if (point.direction && !point.body) forces = (forces * point.direction->head<3>()).eval();
    all.conservativeResize(Eigen::NoChange, all.cols() + forces.cols());
    all.rightCols(forces.cols()) = forces;
  }
  factor.clear_held(all);
  return all;
}

}  // namespace flexopt
