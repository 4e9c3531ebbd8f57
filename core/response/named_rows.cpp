// Numbers that a request names: of points, transfers, strain gauges and bridges.
#include "core/response/quantity_readers.hpp"

namespace flexopt {
namespace {

// "m/N", "rad/(N m)", or "m/rad" of a motion by a motion.
std::string transfer_unit(bool to_turns, bool from_turns, bool of_motion) {
  const std::string to = to_turns ? "rad" : "m";
  if (of_motion) return to_turns == from_turns ? "1" : to + (from_turns ? "/rad" : "/m");
  return to + (from_turns ? "/(N m)" : "/N");
}

template <bool Bandwidth>
std::optional<double> of_transfer(const PathPoint& p, int k) {
  if (k >= std::ssize(p.transfers)) return std::nullopt;
  return Bandwidth ? p.transfers[k].bandwidth : p.transfers[k].compliance;
}

std::vector<QuantityRow> rows_of_points() {
  return {{.name = "point",
           .label = "motion of point",
           .meaning = "displacement of a named point from its undeflected place along its "
                      "direction, or component of the rotation vector of its body",
           .needs = {Output::equilibrium, Output::leaf_points},
           .value = entry<&PathPoint::motions_along>,
           .gradient = entry<&PointGradients::motions_along>,
           .of_names = true,
           .in_csv = false,  // the points have columns of their own
           .in_report = true},
          {.name = "transfer",
           .label = "transfer at rest",
           .meaning = "motion of a named point by a unit load, or a unit motion, of another or of "
                      "the ground, at the frequency zero",
           .needs = {Output::equilibrium, Output::transfers},
           .value = of_transfer<false>,
           .gradient = entry<&PointGradients::transfers>,
           .of_names = true,
           .in_report = true},
          {.name = "transfer_bandwidth",
           .label = "bandwidth of transfer",
           .meaning = "of a load the frequency at which the mass that it feels leaves that at rest "
                      "by the square root of 2, up or down; of a motion that at which the ratio of "
                      "motions first is 3 dB below that at rest",
           .needs = {Output::equilibrium, Output::transfers},
           .value = of_transfer<true>,
           .gradient = entry<&PointGradients::transfer_bandwidths>,
           .at_least = [](const PathPoint& p, int k) -> std::optional<double> {
             if (k >= std::ssize(p.transfers)) return std::nullopt;
             return p.transfers[k].no_bandwidth.at_least;
           },
           .of_names = true,
           .in_report = true}};
}

}  // namespace

std::vector<QuantityRow> named_rows() {
  std::vector<QuantityRow> rows = rows_of_points();
  rows.push_back({.name = "gauge",
                  .label = "strain of gauge",
                  .meaning = "strain by stress of a leaf's surface in the direction of a gauge",
                  .needs = {Output::equilibrium, Output::gauges},
                  .value = [](const PathPoint& p, int k) -> std::optional<double> {
                    if (k >= std::ssize(p.gauges)) return std::nullopt;
                    return p.gauges[k].strain;
                  },
                  .gradient = rate_row<&PointGradients::gauges>,
                  .of_names = true,
                  .in_report = true});
  rows.push_back({.name = "bridge",
                  .label = "output of bridge",
                  .meaning = "output over supply voltage of a Wheatstone bridge: a quarter of the "
                             "gauge factor times the sum of its strains with their signs",
                  .needs = {Output::equilibrium, Output::gauges},
                  .value = entry<&PathPoint::bridges>,
                  .gradient = rate_row<&PointGradients::bridges>,
                  .of_names = true,
                  .in_report = true});
  for (QuantityRow& row : rows) row.layout = Layout::object;
  return rows;
}

std::vector<NamedNumber> named_numbers(const StrokeRequest& request) {
  std::vector<NamedNumber> all;
  const auto& points = request.named_points;
  for (std::size_t k = 0; k < points.size(); ++k)
    if (points[k].direction)
      all.push_back(
          {"point", points[k].name, points[k].turns() ? "rad" : "m", static_cast<int>(k)});
  const std::vector<TransferRule> transfers =
      request.dynamics ? request.dynamics->transfers : std::vector<TransferRule>();
  for (int k = 0; k < std::ssize(transfers); ++k) {
    const TransferRule& rule = transfers[k];
    all.push_back({"transfer", rule.name,
                   transfer_unit(points[rule.to].turns(), rule.from && points[*rule.from].turns(),
                                 rule.of_motion),
                   k});
    all.push_back({"transfer_bandwidth", rule.name, "Hz", k});
  }
  for (int k = 0; k < std::ssize(request.gauges); ++k)
    all.push_back({"gauge", request.gauges[k].name, "1", k});
  for (int k = 0; k < std::ssize(request.bridges); ++k)
    all.push_back({"bridge", request.bridges[k].name, "1", k});
  return all;
}

}  // namespace flexopt
