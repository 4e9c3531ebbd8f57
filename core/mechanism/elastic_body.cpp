#include "core/mechanism/elastic_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/mechanism/mechanism.hpp"

namespace flexopt {

double extent(const ElasticBody& body) {
  Vector3d low = body.interfaces.front().origin, high = low;
  const auto reach = [&](const Vector3d& place) {
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
  };
  for (const Vector3d& node : body.nodes) reach(node);
  for (const ElasticInterface& interface : body.interfaces) reach(interface.origin);
  const double size = (high - low).maxCoeff();
  if (!body.imported) return size;
  const auto d = body.imported->stiffness.diagonal();
  return std::max(size, std::sqrt(d.segment<3>(3).maxCoeff() / d.head<3>().maxCoeff()));
}

Check check_rules(const ElasticBody& body, int bodies) {
  const std::string& name = body.name;
  if (body.interfaces.size() < 2) return Because(name + ": it needs two interfaces or more");
  if (!body.place.allFinite() || !are_right_handed(body.axes))
    return Because(name + ": its place must be finite, its axes orthonormal and right-handed");
  if ((body.cells != nullptr) == (body.imported != nullptr))
    return Because(name + ": it has a mesh or imported matrices, one of the two");
  const int nodes = body.cells ? body.cells->nodes : 0;
  if (static_cast<int>(body.nodes.size()) != nodes)
    return Because(
        fmt::format("{}: it has {} nodes, its cells {}", name, body.nodes.size(), nodes));
  for (const ElasticInterface& interface : body.interfaces) {
    if (interface.body != ground && (interface.body < 0 || interface.body >= bodies))
      return Because(fmt::format("{}: there is no body {}", name, interface.body));
    if (!interface.origin.allFinite() || !interface.face.allFinite())
      return Because(fmt::format("{}: the place of {} is not finite", name, interface.name));
    if (std::ranges::any_of(interface.patch, [&](int k) { return k < 0 || k >= nodes; }))
      return Because(fmt::format("{}: {} holds a node that is none", name, interface.name));
  }
  if (!body.cells) return {};
  constexpr double largest_ratio = 0.4999;  // at 0.5 the stiffness of the volume is infinite
  if (const double ratio = body.material.poissons_ratio; !(ratio <= largest_ratio))
    return Because(fmt::format("{}: its Poisson's ratio is {:g}; a solid's is {:g} at most", name,
                               ratio, largest_ratio));
  return check_rules(body.material, name);
}

}  // namespace flexopt
