// Errors of leaves of linear superelements, by how many there are, in a bent parallel guide.
//
// Guide of leaves 100 × 10 × 0.5 mm at 0.2 L, against full leaves on 16 × 2 elements.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "support/models.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

std::string shown(double ratio) {
  const double error = std::abs(ratio - 1);
  return error >= 1 ? fmt::format("{:.2g}×", ratio) : fmt::format("{:.2g} %", 100 * error);
}

}  // namespace

int main() {
  const Mechanism guide = models::guide(0.1, 0.01, 5e-4);
  StrokeRequest request;
  request.points = {0, 0.005, 0.01, 0.015, 0.02};
  request.outputs.remove(Output::stress);
  const auto last = [&](const ModelOptions& model) {
    return evaluate_stroke(guide, model, request).path.back();
  };
  const PathPoint full = last({.accuracy = Accuracy::full, .mesh = {16, 2}});
  const std::vector<std::array<int, 2>> cuts{{1, 0}, {2, 0}, {4, 0},  {8, 0}, {16, 0},
                                             {4, 1}, {8, 1}, {16, 1}, {32, 2}};
  std::string head = "| superelements |", rule = "|---|", load = "| drive load |",
              support = "| support stiffness ux |";
  for (const auto& [n, m] : cuts) {
    ModelOptions model;
    model.mesh = {16, 2};
    model.method = Reduction::linear_craig_bampton;
    model.superelements = {n, m};
    const PathPoint point = last(model);
    head += m == 0 ? fmt::format(" {} |", n) : fmt::format(" {}×{} |", n, m);
    rule += "---|";
    if (point.status != PointStatus::converged) {
      load += " no equilibrium |";
      support += " |";
      continue;
    }
    load += fmt::format(" {} |", shown(point.drive_load / full.drive_load));
    support +=
        fmt::format(" {} |", shown(*point.support_stiffness[0] / *full.support_stiffness[0]));
  }
  const PageTable page("superelements");
  fmt::print("{}\n{}\n{}\n{}\n", head, rule, load, support);
}
