#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mechanism/joint.hpp"
#include "core/response/modes/frequencies.hpp"
#include "core/response/modes/full_modes.hpp"

namespace flexopt {
namespace {

// A mode from its shares of the kinetic energy; those beside the drive's need not be normalised.
Mode mode_of_shares(double omega2, double drive, double end_effector, double intermediate_body,
                    double leaf) {
  Mode mode;
  mode.frequency = hertz(omega2);
  const double sum = end_effector + intermediate_body + leaf;
  const double factor = sum > 0 ? (1 - drive) / sum : 0;
  mode.drive = drive;
  mode.end_effector = end_effector * factor;
  mode.intermediate_body = intermediate_body * factor;
  mode.leaf = leaf * factor;
  const double largest =
      std::max({mode.drive, mode.end_effector, mode.intermediate_body, mode.leaf});
  mode.kind = largest == mode.drive          ? ModeKind::drive
              : largest == mode.end_effector ? ModeKind::end_effector
              : largest == mode.leaf         ? ModeKind::leaf
                                             : ModeKind::intermediate_body;
  return mode;
}

// Groups of bodies that rigid joints tie together; an elastic frame that holds the end-effector is
// one with it.
std::vector<int> groups_of(const Mechanism& mechanism) {
  std::vector<int> group = rigid_groups(mechanism);
  const int end = mechanism.end_effector;
  for (const ElasticBody& elastic : mechanism.elastic_bodies) {
    const auto& interfaces = elastic.interfaces;
    if (elastic.degree != ElasticDegree::linear ||
        std::ranges::none_of(interfaces,
                             [&](const ElasticInterface& i) { return i.body == end; }) ||
        std::ranges::any_of(interfaces, [](const ElasticInterface& i) { return i.body < 0; }))
      continue;
    for (const ElasticInterface& i : interfaces)
      std::ranges::replace(group, int(group[i.body]), end);
  }
  return group;
}

}  // namespace

MatrixXd stacked(const std::vector<MatrixXd>& parts) {
  Eigen::Index rows = 0;
  for (const MatrixXd& part : parts) rows += part.rows();
  MatrixXd all(rows, parts.front().cols());
  rows = 0;
  for (const MatrixXd& part : parts) {
    all.middleRows(rows, part.rows()) = part;
    rows += part.rows();
  }
  return all;
}

double hertz(double omega2) {
  return std::copysign(std::sqrt(std::abs(omega2)), omega2) / (2 * std::numbers::pi);
}

std::vector<Mode> classified_modes(const Mechanism& mechanism, const VectorXd& omega2,
                                   const MatrixXd& phi, const MatrixXd& M_phi, MatrixXd shapes,
                                   const LinearMap& mass, const LinearMap& carried) {
  std::vector<Mode> modes;
  if (omega2.size() == 0) return modes;
  MatrixXd rest = phi, M_rest = M_phi, M_shapes;
  VectorXd of_drive = VectorXd::Zero(omega2.size());
  if (shapes.cols() > 0) M_shapes = mass(shapes);
  VectorXd masses(shapes.cols());
  for (Eigen::Index k = 0; k < shapes.cols(); ++k) {
    const double whole = shapes.col(k).dot(M_shapes.col(k));
    for (Eigen::Index j = 0; j < k; ++j) {  // M-orthogonal, one after the other
      if (masses[j] == 0) continue;
      const double by = M_shapes.col(j).dot(shapes.col(k)) / masses[j];
      shapes.col(k) -= by * shapes.col(j);
      M_shapes.col(k) -= by * M_shapes.col(j);
    }
    const double b = shapes.col(k).dot(M_shapes.col(k));
    masses[k] = b > 1e-12 * whole ? b : 0;  // else it moves no mass, or that of drives before
    if (masses[k] == 0) continue;
    const Eigen::RowVectorXd a = shapes.col(k).transpose() * M_phi;
    of_drive += (a.cwiseAbs2() / b).transpose();
    rest -= shapes.col(k) * (a / b);
    M_rest -= M_shapes.col(k) * (a / b);
  }
  of_drive = of_drive.cwiseMin(1.0);
  const VectorXd all = rest.cwiseProduct(M_rest).colwise().sum();
  const MatrixXd forces = carried(M_rest);
  const std::vector<int> group = groups_of(mechanism);
  for (Eigen::Index k = 0; k < omega2.size(); ++k) {
    double end_effector = 0, intermediate = 0, bodies = 0;
    for (std::size_t b = 0; b < group.size(); ++b) {
      const auto row = static_cast<Eigen::Index>(6 * b);
      const double e = rest.col(k).segment<6>(row).dot(forces.col(k).segment<6>(row));
      bodies += e;
      (group[b] == mechanism.end_effector ? end_effector : intermediate) += std::max(0.0, e);
    }
    modes.push_back(mode_of_shares(omega2[k], of_drive[k], end_effector, intermediate,
                                   std::max(0.0, all[k] - bodies)));
  }
  return modes;
}

std::vector<Mode> classified_modes(const MechanismFactor& factor, bool drive_locked,
                                   const VectorXd& lambda, const MatrixXd& phi,
                                   const MatrixXd& M_phi, ModeMotions motions) {
  std::vector<Mode> modes =
      classified_modes(factor.system().mechanism(), lambda, phi, M_phi,
                       drive_locked                          ? MatrixXd(factor.size(), 0)
                       : factor.system().loads().held.none() ? factor.drive_answers()
                                                             : factor.free_drives().shapes,
                       factor.masses(), [&](const MatrixXd& B) { return factor.condensed(B); });
  if (motions == ModeMotions::no || modes.empty()) return modes;
  const MatrixXd motion = factor.motion(phi);
  for (std::size_t k = 0; k < modes.size(); ++k)
    modes[k].motion = motion.col(static_cast<Eigen::Index>(k));
  return modes;
}

}  // namespace flexopt
