#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "core/math/sparse_rank.hpp"
#include "core/math/sparse_solver.hpp"
#include "core/mechanism/drive.hpp"
#include "core/mechanism/joint.hpp"

namespace flexopt {
namespace {

// A condition of the undeflected mechanism.
struct FixedMotion {
  Vector12d gradient;
  std::array<int, 2> bodies;
  bool is_length;
};

FixedMotion condition_of(const Joint& joint, const JointConditions& c, int k) {
  return {
      c.gradient.row(k).transpose(), {joint.body, joint.other}, k < size_of(joint.type).lengths};
}

FixedMotion condition_of(const Mechanism& mechanism, const Drive& drive) {
  const DriveStroke<double> stroke = drive_stroke<double>(
      drive, undeflected_body(mechanism, drive.body), undeflected_body(mechanism, drive.other));
  return {stroke.gradient, {drive.body, drive.other}, !is_rotation(drive.direction)};
}

// Whether all conditions of joints and drives differ, for many bodies: by the rank of all of them.
bool independent(const Mechanism& mechanism, double length) {
  std::vector<SparseEntry> entries;
  int rows = 0;
  const auto add = [&](const FixedMotion& c) {
    for (int e = 0; e < 2; ++e)
      for (int b = c.bodies[e], d = 0; d < 6 && b >= 0; ++d)
        if (!mechanism.bodies[b].held[d])
          entries.push_back({rows, 6 * b + d, c.gradient[6 * e + d] * (d < 3 ? length : 1)});
    ++rows;
  };
  for (const Joint& joint : mechanism.joints) {
    const JointConditions c = undeflected_conditions(mechanism, joint);
    for (int k = 0; k < c.value.size(); ++k) add(condition_of(joint, c, k));
  }
  for (const Drive& drive : mechanism.drives) add(condition_of(mechanism, drive));
  return rank_of(rows, 6 * static_cast<int>(mechanism.bodies.size()), entries, 1e-8) == rows;
}

// Conditions one after the other, orthonormalised: what is left of a row is what none before fixes.
class FixedMotions {
 public:
  FixedMotions(const Mechanism& mechanism, double length)
      : size_(6 * static_cast<int>(mechanism.bodies.size())), length_(length) {
    for (int k = 0; k < size_; ++k)
      if (mechanism.bodies[k / 6].held[k % 6]) rows_.push_back(VectorXd::Unit(size_, k));
  }

  // Adds a condition; false where those before it fix the motion already.
  bool add(const FixedMotion& c) {
    VectorXd row = VectorXd::Zero(size_);
    for (int e = 0; e < 2; ++e)
      if (const int b = c.bodies[e]; b >= 0) {
        row.segment<3>(6 * b) = length_ * c.gradient.segment<3>(6 * e);
        row.segment<3>(6 * b + 3) = c.gradient.segment<3>(6 * e + 3);
      }
    if (c.is_length) row /= length_;
    const double size = row.norm();
    for (int pass = 0; pass < 2; ++pass)
      for (const VectorXd& fixed : rows_) row -= fixed.dot(row) * fixed;
    if (!(row.norm() > 1e-8 * size)) return false;
    rows_.push_back(row.normalized());
    return true;
  }

 private:
  int size_;
  double length_;
  std::vector<VectorXd> rows_;
};

// Rigid joints that tie a body to the ground, by their names; none where they do not.
std::vector<std::string> ties_to_ground(const Mechanism& mechanism, int body) {
  std::vector<std::vector<std::string>> ties(mechanism.bodies.size());
  std::vector<int> reached{body};
  for (std::size_t k = 0; k < reached.size(); ++k)
    for (const Joint& joint : mechanism.joints) {
      if (joint.type != JointType::rigid || (joint.body != reached[k] && joint.other != reached[k]))
        continue;
      const int next = joint.body == reached[k] ? joint.other : joint.body;
      std::vector<std::string> way = ties[static_cast<std::size_t>(reached[k])];
      way.push_back(joint.name);
      if (next == ground) return way;
      if (std::find(reached.begin(), reached.end(), next) != reached.end()) continue;
      ties[static_cast<std::size_t>(next)] = std::move(way);
      reached.push_back(next);
    }
  return {};
}

// Why a body cannot follow a drive.
std::string held_by(const Mechanism& mechanism, int body, const std::string& joints) {
  const std::vector<std::string> ties = ties_to_ground(mechanism, body);
  if (ties.empty()) return joints;
  return fmt::format("{} is one rigid body with the ground, by {}", mechanism.bodies[body].name,
                     fmt::join(ties, ", "));
}

}  // namespace

Check check_joints(const Mechanism& mechanism) {
  const std::vector<Drive>& drives = mechanism.drives;
  const bool simple = drives.empty() || (drives.size() == 1 && coordinate_of(drives[0]));
  if (mechanism.joints.empty() && simple) return {};
  const double length = longest_leaf(mechanism);
  if (6 * static_cast<int>(mechanism.bodies.size()) >= sparse_from &&
      independent(mechanism, length))
    return {};
  FixedMotions fixed(mechanism, length);
  for (const Joint& joint : mechanism.joints) {
    const JointConditions c = undeflected_conditions(mechanism, joint);
    int repeated = 0;
    for (int k = 0; k < c.value.size(); ++k) repeated += !fixed.add(condition_of(joint, c, k));
    if (repeated > 0 && is_held(joint.type))
      return Because(fmt::format(
          "{}: joints and other held directions already hold its {} {}",
          mechanism.bodies[joint.body].name,
          joint.type == JointType::held_rotation ? "rotation about" : "displacement along",
          described(joint.axis)));
    if (repeated > 0)
      return Because(fmt::format(
          "{}: {} of its {} conditions are already fixed by the joints before it; a joint that "
          "leaves more freedom will do",
          joint.name, repeated, c.value.size()));
  }
  for (std::size_t k = 0; k < drives.size(); ++k) {
    const Drive& drive = drives[k];
    if (fixed.add(condition_of(mechanism, drive))) continue;
    if (k == 0 && drive.body == mechanism.end_effector && drive.other == ground)
      return Because(held_by(mechanism, drive.body,
                             "the joints hold the end-effector in the direction of the drive"));
    const std::string who = drive.name.empty() ? "the drive" : "drive " + drive.name;
    return Because(
        who + ": " +
        held_by(mechanism, drive.body,
                k == 0 ? "the joints hold it" : "joints and other drives already hold it"));
  }
  return {};
}

}  // namespace flexopt
