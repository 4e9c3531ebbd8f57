#include "support/own_leaves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string_view>

#include "support/models.hpp"

namespace flexopt {
namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_()) /
                     static_cast<double>(std::mt19937_64::max());
  }
  double logarithmic(double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  }
  int below(int end) { return static_cast<int>(uniform(0, end)) % end; }
  bool chance(double share) { return uniform(0, 1) < share; }
  Matrix3d axes() {
    const Vector3d x = Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized();
    const Vector3d y =
        x.cross(Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1))).normalized();
    Matrix3d axes;
    axes << x, y, x.cross(y);
    return axes;
  }

 private:
  std::mt19937_64 random_;
};

const char* kinds[] = {"flat", "flat", "curved", "tapered", "wire"};

std::string add_leaf(Draw& draw, bool along_axes, Mechanism& mechanism) {
  const std::string kind = kinds[draw.below(5)];
  const double length = draw.uniform(0.03, 0.1);
  const double thickness = length * draw.logarithmic(1.0 / 400, 1.0 / 40);
  const double width = std::max(2 * thickness, length * draw.logarithmic(0.08, 1.2));
  LeafSpring leaf = models::leaf({0, 0, 0}, {1, 0, 0}, length, width, thickness);
  if (!along_axes) leaf.axes = draw.axes();
  if (kind == "curved") leaf.curve = draw.uniform(0.05, 1.2) * (draw.chance(0.5) ? 1 : -1);
  if (kind == "tapered") {
    leaf.thickness_profile = {1, draw.uniform(0.6, 1.4), draw.uniform(0.6, 1.4)};
    if (draw.chance(0.5)) leaf.width_profile = {1, draw.uniform(0.5, 1.3)};
  }
  if (kind == "wire") {
    leaf.section = Section::circular;
    leaf.thickness = leaf.width = std::max(thickness, 2e-4);
  }
  if (!mechanism.leaves.empty())
    leaf.origin = Vector3d(0, draw.uniform(-0.05, 0.05), draw.uniform(-0.05, 0.05));
  mechanism.leaves.push_back(leaf);
  return fmt::format("{} {:.0f} x {:.1f} x {:.2f} mm{}", kind, 1e3 * length, 1e3 * leaf.width,
                     1e3 * leaf.thickness,
                     leaf.curve ? fmt::format(" by {:.2f} rad", *leaf.curve) : "");
}

OwnLeaves draw_one(Draw& draw) {
  OwnLeaves own;
  Mechanism& m = own.mechanism;
  const bool along_axes = draw.chance(0.6);
  own.model.flexure = draw.chance(0.3) ? Flexure::beam : Flexure::plate;
  own.model.mesh = {8, own.model.flexure == Flexure::beam ? 1 : 3};
  own.what = own.model.flexure == Flexure::beam ? "beams" : "plates";
  const int leaves = draw.chance(0.5) ? 1 : 2 + draw.below(2);
  for (int i = 0; i < leaves; ++i) own.what += ", " + add_leaf(draw, along_axes, m);
  Vector3d at = m.leaves.front().tip_middle();
  if (draw.chance(0.3)) at += Vector3d(draw.uniform(-0.03, 0.03), draw.uniform(-0.03, 0.03), 0);
  m.bodies = {models::body(at, 0.3, 3e-4)};
  double thickness = 1, length = 0;
  for (const LeafSpring& leaf : m.leaves) {
    thickness = std::min(thickness, leaf.thickness);
    length = std::max(length, leaf.length);
  }
  own.what += ":";
  const int first = draw.below(6);
  VectorXd stroke(6);
  int drives = 0;
  for (int k = 0; k < 6; ++k) {
    const int d = (first + k) % 6;
    const double role = draw.uniform(0, 1);
    if (k == 0 || role > 0.8) {
      Drive drive = make_drive(static_cast<Direction>(d));
      drive.name = direction_names[static_cast<std::size_t>(d)];
      m.drives.push_back(drive);
      stroke[drives] = draw.logarithmic(0.5, 30) * thickness * (draw.chance(0.5) ? 1 : -1);
      if (d >= 3) stroke[drives] = std::clamp(stroke[drives] / length, -0.6, 0.6);
      own.what += fmt::format(" {} by {:.3g}", drive.name, stroke[drives]);
      ++drives;
    } else if (role > 0.45) {
      m.bodies[0].held[static_cast<std::size_t>(d)] = true;
      own.what += fmt::format(" {} held", direction_names[static_cast<std::size_t>(d)]);
    }
  }
  const VectorXd end = stroke.head(drives);
  own.request.points.clear();
  for (const double part : {1.0 / 3, 2.0 / 3, 1.0}) {
    own.request.points.push_back(part * end[0]);
    if (drives > 1) own.request.strokes.emplace_back(part * end);
  }
  own.request.outputs = {Output::equilibrium, Output::stiffness};
  if (draw.chance(0.33)) {
    const double size = draw.logarithmic(0.01, 1);
    const LeafSpring& leaf = m.leaves.front();
    const double bending = leaf.material.youngs_modulus * leaf.width * std::pow(leaf.thickness, 3) /
                           12 / (leaf.length * leaf.length);
    const Vector3d force =
        size * bending * Vector3d(draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(-1, 1));
    own.request.loads.constant = {{.force = force}};
    own.what += fmt::format(", load ({:.3g}, {:.3g}, {:.3g}) N", force[0], force[1], force[2]);
  }
  return own;
}

std::map<std::string, double> numbers_of(const PathPoint& point) {
  std::map<std::string, double> numbers;
  const auto add_list = [&](const char* name, const auto& list) {
    for (std::size_t k = 0; k < std::size(list); ++k)
      numbers[fmt::format("{}.{}", name, k)] = list[k];
  };
  add_list("drive_load",
           point.drive_loads.empty() ? std::vector{point.drive_load} : point.drive_loads);
  add_list("drive_stiffness", point.drive_stiffnesses.empty() ? std::vector{point.drive_stiffness}
                                                              : point.drive_stiffnesses);
  for (std::size_t d = 0; d < 6; ++d) {
    const auto i = static_cast<Eigen::Index>(d);
    numbers[fmt::format("compliance_free.{}", direction_names[d])] = point.compliance_free(i, i);
    numbers[fmt::format("compliance_locked.{}", direction_names[d])] =
        point.compliance_locked(i, i);
  }
  return numbers;
}

}  // namespace

OwnLeaves own_leaves(unsigned seed) {
  Draw draw(seed);
  for (;;) {
    OwnLeaves own = draw_one(draw);
    if (check_rules(own.mechanism)) return own;
  }
}

Disagreement largest_disagreement(const StrokeResponse& found, const StrokeResponse& expected) {
  std::map<std::string, double> largest;
  for (const PathPoint& point : expected.path)
    if (point.status == PointStatus::converged)
      for (const auto& [name, value] : numbers_of(point))
        largest[name] = std::max(largest[name], std::abs(value));
  Disagreement worst;
  for (std::size_t k = 0; k < expected.path.size(); ++k) {
    const PathPoint &a = found.path[k], &b = expected.path[k];
    if (a.status != PointStatus::converged || b.status != PointStatus::converged) continue;
    const std::map<std::string, double> of = numbers_of(a);
    for (const auto& [name, value] : numbers_of(b)) {
      const auto at = of.find(name);
      double scale = std::max(std::abs(value), 0.01 * largest[name]);
      // what a drive nearly holds is a remainder
      constexpr std::string_view locked = "compliance_locked.";
      if (name.starts_with(locked))
        scale = std::max(scale, 1e-3 * largest["compliance_free." + name.substr(locked.size())]);
      if (at == of.end() || scale == 0) continue;
      const double relative = std::abs(at->second - value) / scale;
      if (relative > worst.relative) worst = {name, k, at->second, value, relative};
    }
  }
  return worst;
}

}  // namespace flexopt
