// Error of full beam leaves against elements per leaf, 40 elements the reference: parallel guide to
// 0.2 L and cross hinge to 30°, the undeflected state included. Largest over the stroke in %:
// drive load / support stiffness in z / worst support stiffness (direction). Prints the table of
// core/elements/beams.md.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/response/response.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

struct Errors {
  double drive = 0, support = 0, lateral = 0;  ///< lateral: uz
  int direction = 0;
};

Errors errors(const StrokeResponse& coarse, const StrokeResponse& fine) {
  Errors e;
  for (std::size_t k = 0; k < fine.path.size(); ++k) {
    const PathPoint &a = coarse.path[k], &b = fine.path[k];
    if (b.stroke != 0) e.drive = std::max(e.drive, std::abs(a.drive_load / b.drive_load - 1));
    for (int d = 0; d < 6; ++d)
      if (b.support_stiffness[d]) {
        const double error = std::abs(*a.support_stiffness[d] / *b.support_stiffness[d] - 1);
        if (error > e.support) e.support = error, e.direction = d;
        if (d == index(Direction::uz)) e.lateral = std::max(e.lateral, error);
      }
  }
  return e;
}

StrokeResponse evaluate(const Mechanism& m, double end, int elements) {
  StrokeRequest request;
  request.points = {0, end / 4, end / 2, 0.75 * end, end};
  request.stress = false;
  return evaluate_stroke(
      m, {.accuracy = Accuracy::full, .flexure = Flexure::beam, .mesh = {elements, 1}}, request);
}

}  // namespace

int main() {
  constexpr int counts[] = {2, 4, 8, 10, 16};
  const double L = 0.1;
  fmt::print("| | L/w | L/t |");
  for (const int n : counts) fmt::print(" {} elements |", n);
  fmt::print("\n|---|---|---|");
  for ([[maybe_unused]] const int n : counts) fmt::print("---|");
  fmt::print("\n");
  for (const bool guided : {true, false})
    for (const double thinness : {100.0, 200.0, 500.0})
      for (const double aspect : {10.0, 3.3, 1.0}) {
        const double w = L / aspect, t = L / thinness;
        const Mechanism m = guided ? models::guide(L, w, t)
                                   : models::hinge(L, t, {{1, 0.55 * w, w}, {-1, -0.55 * w, w}});
        const double end = guided ? 0.2 * L : std::numbers::pi / 6;
        const StrokeResponse fine = evaluate(m, end, 40);
        fmt::print("| {} | {:g} | {:g} |", guided ? "guide" : "cross hinge", aspect, thinness);
        for (const int n : counts) {
          const StrokeResponse coarse = evaluate(m, end, n);
          if (coarse.status != Status::ok || fine.status != Status::ok) {
            fmt::print(" no equilibrium |");
            continue;
          }
          const Errors e = errors(coarse, fine);
          fmt::print(" {:.2g} / {:.2g} / {:.2g} ({}) |", 100 * e.drive, 100 * e.lateral,
                     100 * e.support, direction_names[static_cast<std::size_t>(e.direction)]);
        }
        fmt::print("\n");
        std::fflush(stdout);
      }
}
