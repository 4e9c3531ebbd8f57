
#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "core/equilibrium/stroke_path.hpp"

namespace flexopt {
namespace {

std::string name_of(const Mechanism& mechanism, const Drive& drive) {
  const std::string motion = fmt::format("{} of {}", direction_names[index(drive.direction)],
                                         mechanism.bodies[drive.body].name);
  return drive.name.empty() ? motion : fmt::format("{} ({})", drive.name, motion);
}

std::string held_directions(const Mechanism& mechanism) {
  std::string text;
  const auto add = [&](std::string_view direction, const std::string& body) {
    text += fmt::format("{}{} of {}", text.empty() ? "" : ", ", direction, body);
  };
  for (const RigidBody& body : mechanism.bodies)
    for (std::size_t d = 0; d < 6; ++d)
      if (body.held[d]) add(direction_names[d], body.name);
  for (const Joint& joint : mechanism.joints)
    if (is_held(joint.type))
      add((joint.type == JointType::held_rotation ? "rotation about " : "displacement along ") +
              described(joint.axis),
          mechanism.bodies[joint.body].name);
  return text;
}

}  // namespace

std::string held_meanwhile(const System& system, bool drives_held) {
  const Mechanism& mechanism = system.mechanism();
  std::string text;
  const VectorXd strokes = present_strokes(system);
  drives_held = drives_held && system.loads().driven();
  for (std::size_t k = 0; drives_held && k < mechanism.drives.size(); ++k) {
    const Drive& drive = mechanism.drives[k];
    const bool turns = is_rotation(drive.direction);
    const double load = system.drive_load(k), stroke = strokes[k],
                 rest = 1e-12 * (turns ? 1 : system.length());
    text += fmt::format("; meanwhile {} is held at {:.4g} {}", name_of(mechanism, drive),
                        std::abs(stroke) < rest ? 0 : stroke, turns ? "rad" : "m");
    if (load != 0)
      text += fmt::format(" against {:.4g} {}, and would have to give towards {}{}", std::abs(load),
                          turns ? "N m" : "N", load > 0 ? '-' : '+',
                          direction_names[index(drive.direction)]);
  }
  const std::string directions = held_directions(mechanism);
  if (!directions.empty()) text += "; always held: " + directions;
  return text;
}

}  // namespace flexopt
