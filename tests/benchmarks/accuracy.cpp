// How far a mesh is from a fine one, and a reduced leaf from the full one on the same mesh.
//
//   bench_accuracy [mesh | reduced]     one table; both without an argument
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "support/models.hpp"
#include "tests/benchmarks/measured.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

const double pi = std::numbers::pi;

struct Leaf {
  double length, width, thickness;  // mm
  double slenderness() const { return width * width / (length * thickness); }
};
const std::vector<Leaf> leaves{{100, 10, .5}, {100, 30, .5}, {100, 30, .2},
                               {60, 40, .4},  {60, 60, .5},  {60, 60, .25}};

struct Errors {
  double drive = 0, motion = 0, support = 0, free = 0, locked = 0;
  int fallbacks = 0, iterations = 0;
};

Errors differences(const StrokeResponse& reference, const StrokeResponse& tried) {
  Errors e;
  double motion = 0;
  for (const PathPoint& p : reference.path) motion = std::max(motion, p.displacement.norm());
  for (std::size_t k = 0; k < reference.path.size(); ++k) {
    const PathPoint &a = reference.path[k], &b = tried.path[k];
    if (a.status != PointStatus::converged || b.status != PointStatus::converged) {
      fmt::print("  point {} did not converge\n", k);
      continue;
    }
    if (a.stroke != 0) e.drive = std::max(e.drive, std::abs(b.drive_load / a.drive_load - 1));
    e.motion = std::max(e.motion, (a.displacement - b.displacement).norm() / motion);
    for (int d = 0; d < 6; ++d)
      if (a.support_stiffness[d])
        e.support =
            std::max(e.support, std::abs(*b.support_stiffness[d] / *a.support_stiffness[d] - 1));
    for (std::size_t i = 0; i < a.frequencies_free.size(); ++i) {
      e.free = std::max(e.free, std::abs(b.frequencies_free[i] / a.frequencies_free[i] - 1));
      e.locked =
          std::max(e.locked, std::abs(b.frequencies_locked[i] / a.frequencies_locked[i] - 1));
    }
    e.iterations = std::max(e.iterations, b.newton_iterations);
    for (const LeafReport& l : b.leaves) e.fallbacks += !l.reason.empty();
  }
  return e;
}

struct Case {
  std::string name;
  Mechanism mechanism;
  StrokeRequest request;
};

std::vector<Case> cases(const Leaf& l, int frequencies) {
  const double L = l.length * 1e-3, w = l.width * 1e-3, t = l.thickness * 1e-3;
  auto to = [&](double end, int points) {
    StrokeRequest r{.points = models::evenly(end, points)};
    r.outputs.remove(Output::stress);
    r.frequencies = frequencies;
    return r;
  };
  return {{"guided 0.3 L", models::guide(L, w, t, 1.0), to(0.3 * L, 11)},
          {"rotated 45°", models::single_leaf(L, w, t, Direction::rz), to(pi / 4, 10)},
          {"hinge 45°", models::three_leaf_hinge(L, w, t), to(pi / 4, 10)},
          {"hinge -45°", models::three_leaf_hinge(L, w, t), to(-pi / 4, 10)}};
}

void mesh_table() {
  const PageTable page("accuracy mesh");
  const std::vector<std::array<int, 2>> meshes{{10, 4}, {12, 5}, {16, 4}, {16, 8}};
  fmt::print("| w²/(Lt) | path |");
  for (const auto& mesh : meshes) fmt::print(" {}×{} |", mesh[0], mesh[1]);
  fmt::print("\n|---|---|---|---|---|---|\n");
  for (const Leaf& l : leaves)
    for (const Case& c : cases(l, 0)) {
      if (c.name == "hinge -45°") continue;
      fmt::print("| {:.0f} | {} |", l.slenderness(), c.name);
      const StrokeResponse fine =
          evaluate_stroke(c.mechanism, {.accuracy = Accuracy::full, .mesh = {28, 14}}, c.request);
      for (const auto& mesh : meshes) {
        const Errors e = differences(
            fine,
            evaluate_stroke(c.mechanism, {.accuracy = Accuracy::full, .mesh = mesh}, c.request));
        fmt::print(" {:.2f} / {:.2f} / {:.2f} |", 100 * e.drive, 100 * e.motion, 100 * e.support);
      }
      fmt::print("\n");
      std::fflush(stdout);
    }
}

void reduced_table() {
  const PageTable page("accuracy reduced");
  fmt::print(
      "| w²/(Lt) | path | drive load | motion of O | support stiffness | frequencies, drive free | "
      "drive locked | iterations | full leaves |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const Leaf& l : leaves)
    for (const Case& c : cases(l, 6)) {
      const StrokeResponse full =
          evaluate_stroke(c.mechanism, {.accuracy = Accuracy::full}, c.request);
      const Errors e = differences(full, evaluate_stroke(c.mechanism, {}, c.request));
      fmt::print("| {:.0f} | {} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {} | {} |\n",
                 l.slenderness(), c.name, e.drive, e.motion, e.support, e.free, e.locked,
                 e.iterations, e.fallbacks);
      std::fflush(stdout);
    }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string table = argc > 1 ? argv[1] : "";
  if (table.empty() || table == "reduced") reduced_table();
  if (table.empty() || table == "mesh") mesh_table();
}
