#include "core/equilibrium/elastic_stress.hpp"

#include <algorithm>

#include "core/elements/solid/solid_element.hpp"

namespace flexopt {

ElasticStress::ElasticStress(const ElasticBodies& bodies, int k)
    : bodies_(&bodies),
      k_(k),
      displacements_(solid_displacements(bodies.solid(k), bodies.held(k).floating.local)),
      stress_(solid_stress(bodies.body(k), surface(), displacements_)) {}

StressPeak ElasticStress::peak(int node, double von_mises) const {
  StressPeak peak;
  peak.value = von_mises;
  peak.position = place(node);
  peak.elastic_body = k_;
  peak.node = node;
  return peak;
}

std::optional<StressPeak> ElasticStress::largest() const {
  if (!stress_.largest) return std::nullopt;
  return peak(stress_.largest->node, stress_.largest->von_mises);
}

// The first of stresses that differ by rounding alone counts as the larger one.
std::vector<StressPeak> ElasticStress::peaks() const {
  const auto n = static_cast<std::size_t>(bodies_->body(k_).cells->nodes);
  std::vector<double> value(n, -1);  // −1: does not count
  for (std::size_t k = 0; k < surface().nodes.size(); ++k)
    if (!surface().beside_patch[k])
      value[static_cast<std::size_t>(surface().nodes[k])] = stress_.von_mises[k];
  std::vector<bool> below(n);
  const auto larger = [&](int a, int b) {
    const double x = value[static_cast<std::size_t>(a)], y = value[static_cast<std::size_t>(b)];
    return x > y * (1 + 1e-9) || (x * (1 + 1e-9) >= y && a < b);
  };
  for_each_cell(*bodies_->body(k_).cells, [&](SolidCell, std::span<const int> nodes) {
    const int most = *std::ranges::min_element(nodes, larger);
    for (const int node : nodes)
      if (node != most) below[static_cast<std::size_t>(node)] = true;
  });
  std::vector<StressPeak> peaks;
  for (std::size_t k = 0; k < n; ++k)
    if (value[k] >= 0 && !below[k]) peaks.push_back(peak(static_cast<int>(k), value[k]));
  return peaks;
}

std::vector<StressPlace> ElasticStress::places() const {
  std::vector<StressPlace> places;
  for (std::size_t k = 0; k < surface().nodes.size(); ++k)
    if (!surface().beside_patch[k]) places.push_back({.node = surface().nodes[k]});
  return places;
}

MatrixXd ElasticStress::sections(const std::vector<StressPlace>& places) const {
  MatrixXd sections(6, places.size());
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto at = std::ranges::lower_bound(surface().nodes, places[k].node);
    sections.col(static_cast<Eigen::Index>(k)) =
        stress_.at_nodes[static_cast<std::size_t>(at - surface().nodes.begin())];
  }
  return sections;
}

Vector3d ElasticStress::place(int node) const {
  const FramePose& frame = bodies_->held(k_).floating.frame;
  const ElasticBody& body = bodies_->body(k_);
  const double growth = 1 + bodies_->action().warmth * (body.growth - 1);
  return frame.position +
         frame.axes * (growth * body.nodes[static_cast<std::size_t>(node)] +
                       displacements_.segment<3>(3 * static_cast<Eigen::Index>(node)));
}

Vector3d ElasticStress::undeflected_place(int node) const {
  const ElasticBody& body = bodies_->body(k_);
  return body.place + body.axes * body.nodes[static_cast<std::size_t>(node)];
}

}  // namespace flexopt
