#include "core/mechanism/load_case.hpp"

#include <fmt/format.h>

namespace flexopt {

std::optional<std::string> broken_rule(const LoadCase& loads, const Mechanism& mechanism) {
  const int bodies = static_cast<int>(mechanism.bodies.size());
  for (const std::vector<DeadLoad>* list : {&loads.constant, &loads.growing})
    for (const DeadLoad& load : *list) {
      const int body = load.body.value_or(mechanism.end_effector);
      if (body < 0 || body >= bodies)
        return fmt::format("a load acts on body {}, but there are {} bodies", body, bodies);
      if (!load.force.allFinite() || !load.moment.allFinite() || !load.arm.allFinite() ||
          !load.place.value_or(load.arm).allFinite())
        return fmt::format("a load on body {} is not finite", body);
    }
  return std::nullopt;
}

}  // namespace flexopt
