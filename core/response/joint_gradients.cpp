#include "core/response/joint_gradients.hpp"

#include "core/mechanism/joint.hpp"

namespace flexopt {
namespace {

// Joint after joint: `visit(k, row, count)`, its conditions being rows row … row + count − 1 of Ψ.
template <class Visit>
void for_each_joint(const Mechanism& mechanism, const Visit& visit) {
  int row = 0;
  for (std::size_t k = 0; k < mechanism.joints.size(); ++k) {
    const int count = size_of(mechanism.joints[k].type).conditions;
    visit(k, row, count);
    row += count;
  }
}

std::array<int, 2> sides_of(const Joint& joint) { return {joint.body, joint.other}; }

JointState present(const System& system, const Joint& joint, int row, int count) {
  const auto body = [&](int b) -> JointBody {
    if (b < 0) return {};
    return {system.pose(b).position, system.pose(b).rotation,
            system.mechanism().bodies[b].reference};
  };
  return {joint, body(joint.body), body(joint.other), system.multipliers().segment(row, count)};
}

// At constant displacements, rotations and multipliers.
JointState moving(const System& system, const Mechanism& direction, std::size_t k, int count) {
  const Joint& joint = system.mechanism().joints[k];
  const auto body = [&](int b) -> JointBody {
    const Vector3d moves = b < 0 ? Vector3d::Zero() : direction.bodies[b].reference;
    return {moves, Matrix3d::Zero(), moves};
  };
  return {direction.joints[k], body(joint.body), body(joint.other), VectorXd::Zero(count)};
}

}  // namespace

void add_joint_residual_rates(const MechanismFactor& factor,
                              const std::vector<Mechanism>& directions, MatrixXd& R) {
  const System& system = factor.system();
  const int first = factor.size() - factor.joints();
  for_each_joint(system.mechanism(), [&](std::size_t k, int row, int count) {
    const Joint& joint = system.mechanism().joints[k];
    const JointState state = present(system, joint, row, count);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const JointConditions c =
          joint_rates(state, moving(system, directions[p], k, count)).conditions;
      auto column = R.col(static_cast<Eigen::Index>(p));
      column.segment(first + row, count) += c.value;
      for (int e = 0; e < 2; ++e)
        if (const int b = sides_of(joint)[e]; b >= 0)
          column.segment<6>(6 * b) +=
              c.gradient.middleCols<6>(6 * e).transpose() * state.multipliers;
    }
  });
}

void add_joint_quadratic_rates(const MechanismFactor& factor,
                               const std::vector<Mechanism>& directions,
                               const MatrixXd& state_rates, const MatrixXd& Y, MatrixXd& rates) {
  const System& system = factor.system();
  const int first = factor.size() - factor.joints();
  for_each_joint(system.mechanism(), [&](std::size_t k, int row, int count) {
    const Joint& joint = system.mechanism().joints[k];
    const JointState state = present(system, joint, row, count);
    MatrixXd y = MatrixXd::Zero(12, Y.cols());
    for (int e = 0; e < 2; ++e)
      if (const int b = sides_of(joint)[e]; b >= 0) y.middleRows(6 * e, 6) = Y.middleRows(6 * b, 6);
    const MatrixXd y_mu = Y.middleRows(first + row, count);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const auto q = state_rates.col(static_cast<Eigen::Index>(p));
      JointState rate = moving(system, directions[p], k, count);
      rate.multipliers = q.segment(first + row, count);
      JointBody* bodies[] = {&rate.body, &rate.other};
      for (int e = 0; e < 2; ++e)
        if (const int b = sides_of(joint)[e]; b >= 0) {
          bodies[e]->position += q.segment<3>(6 * b);
          bodies[e]->rotation = hat(q.segment<3>(6 * b + 3)) * system.pose(b).rotation;
        }
      const JointRates r = joint_rates(state, rate);
      rates.col(static_cast<Eigen::Index>(p)) +=
          (y.cwiseProduct(r.curvature * y) +
           2 * y.cwiseProduct(r.conditions.gradient.transpose() * y_mu))
              .colwise()
              .sum()
              .transpose();
    }
  });
}

}  // namespace flexopt
