// Where beams stop being good enough: beam leaves against plate leaves.
//
// Both 16 elements along, plates 8 across, on the parallel guide to 0.15 L and the cross hinge to
// 30°, beside the estimates that every result carries (leaf_validity). Prints the table of
// core/elements/plate/beams.md.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/elements/plate/leaf_validity.hpp"
#include "core/response/response.hpp"
#include "support/models.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

struct Worst {
  double drive = 0, support = 0, parasitic = 0;
  int direction = 0;
};

void keep(double& worst, double value) {
  if (std::abs(value) > std::abs(worst)) worst = value;
}

Worst difference(const PathPoint& plate, const PathPoint& beam) {
  Worst w;
  w.drive = beam.drive_stiffness / plate.drive_stiffness - 1;
  if (plate.stroke != 0) w.drive = beam.drive_load / plate.drive_load - 1;
  for (int d = 0; d < 6; ++d)
    if (plate.support_stiffness[d]) {
      const double e = *beam.support_stiffness[d] / *plate.support_stiffness[d] - 1;
      if (std::abs(e) > std::abs(w.support)) w.support = e, w.direction = d;
    }
  w.parasitic = *beam.parasitic_frequency / *plate.parasitic_frequency - 1;
  return w;
}

// Largest differences over the stroke [%].
std::string row(const StrokeResponse& plate, const StrokeResponse& beam) {
  if (plate.status != Status::ok || beam.status != Status::ok) return " no equilibrium | | |";
  Worst all;
  for (std::size_t k = 0; k < plate.path.size(); ++k) {
    const Worst w = difference(plate.path[k], beam.path[k]);
    keep(all.drive, w.drive);
    keep(all.parasitic, w.parasitic);
    if (std::abs(w.support) > std::abs(all.support))
      all.support = w.support, all.direction = w.direction;
  }
  return fmt::format(" {:+.1f} | {:+.1f} ({}) | {:+.1f} |", 100 * all.drive, 100 * all.support,
                     direction_names[static_cast<std::size_t>(all.direction)], 100 * all.parasitic);
}

}  // namespace

int main() {
  const double L = 0.1;
  const PageTable page("beam_or_plate");
  fmt::print(
      "| | L/w | L/t | w²/(Lt) | drive load | support stiffness | parasitic frequency | estimated "
      "| "
      "free warping: drive load | support stiffness | parasitic frequency | estimated | needed |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const bool guided : {true, false})
    for (const double thinness : {100.0, 200.0, 500.0})
      for (const double aspect : {10.0, 3.3, 1.0, 0.5}) {
        const double w = L / aspect, t = L / thinness;
        const Mechanism m = guided ? models::guide(L, w, t, 0.06, 1.0)
                                   : models::hinge(L, t, {{1, 0.55 * w, w}, {-1, -0.55 * w, w}});
        StrokeRequest request;
        const double end = guided ? 0.15 * L : std::numbers::pi / 6;
        request.points = {0, end / 4, end / 2, end};
        request.frequencies = 3;
        request.outputs.remove(Output::stress);
        ModelOptions model{.accuracy = Accuracy::full, .mesh = {16, 8}};
        const StrokeResponse plate = evaluate_stroke(m, model, request);
        model.flexure = Flexure::beam;
        const StrokeResponse clamped = evaluate_stroke(m, model, request);
        model.warping = Warping::free;
        const StrokeResponse free = evaluate_stroke(m, model, request);
        const LeafValidity v = leaf_validity(m.leaves[0]);
        fmt::print("| {} | {:g} | {:g} | {:.0f} |{} {:.0f} |{} {:.0f} | {} |\n",
                   guided ? "guide" : "cross hinge", aspect, thinness, v.flatness,
                   row(plate, clamped), 100 * v.beam, row(plate, free), 100 * v.beam_free_warping,
                   v.needed);
        std::fflush(stdout);
      }
}
