// Times of reduced leaves against full ones, as ratios measured in one run on an idle machine.
#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "core/elements/plate/full_leaf.hpp"
#include "core/reduction/tube/tube_leaf.hpp"
#include "core/response/response.hpp"
#include "support/models.hpp"
#include "tests/benchmarks/measured.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

void leaf_kernels() {
  const LeafSpring leaf = models::leaf({0, 0, 0}, {1, 0, 0}, 0.06, 0.04, 4e-4);
  auto mesh = [&](std::array<int, 2> m) {
    return std::make_shared<PlateMesh>(plate_shape(leaf, m, true));
  };
  const auto coarse = mesh(ModelOptions{}.mesh), fine = mesh({16, 8});
  FullLeaf full(leaf, coarse, 0), full_fine(leaf, fine, 0);
  TubeRange range;
  const double build = least_seconds(9, [&] { TubeModel model(coarse, range); });
  TubeLeaf tube(leaf, std::make_shared<TubeModel>(coarse, range), 0);
  const double t_tube = least_seconds(21,
                                      [&] {
                                        for (int k = 0; k < 1000; ++k) tube.evaluate();
                                      }) /
                        1000;
  const double t_full = least_seconds(101, [&] { full.evaluate(); });
  const double t_fine = least_seconds(41, [&] { full_fine.evaluate(); });
  // a load step of the fine leaf: 4 mm guided, from rest
  double step = 0;
  {
    StrokeRequest request{.points = {0.003}, .outputs = Outputs::numbers().remove(Output::stress)};
    ModelOptions model{.accuracy = Accuracy::full, .mesh = {16, 8}};
    step = least_seconds(
        9, [&] { evaluate_stroke(models::single_leaf(0.06, 0.04, 4e-4), model, request); });
  }
  const PageTable page("timings leaf");
  fmt::print("| one leaf | time | ratio |\n|---|---|---|\n");
  fmt::print("| reduced: energy, force, tangent | {:.2f} µs | 1 |\n", t_tube * 1e6);
  fmt::print("| full, default mesh: condensed force and tangent | {:.0f} µs | {:.0f} |\n",
             t_full * 1e6, t_full / t_tube);
  fmt::print("| full, 16×8: condensed force and tangent | {:.0f} µs | {:.0f} |\n", t_fine * 1e6,
             t_fine / t_tube);
  fmt::print(
      "| coefficients of the reduced leaf, 4 bent states | {:.1f} ms | {:.2f} load steps of the "
      "full "
      "leaf on 16×8 |\n",
      build * 1e3, build / step);
}

void hinge_paths() {
  Mechanism hinge = models::three_leaf_hinge(0.06, 0.04, 4e-4);
  StrokeRequest request;
  request.points = models::evenly(std::numbers::pi / 6);
  request.outputs = {Output::equilibrium, Output::stiffness, Output::frequencies_free,
                     Output::frequencies_locked, Output::parasitic_frequency};
  const PageTable page("timings hinge");
  fmt::print(
      "| frequencies | payload | reduced | its coefficients | full, default mesh | full, 16×8 "
      "|\n|---|---|---|---|---|---|\n");
  // one frequency of a heavy payload lies far below the leaves' own: cheaper modes suffice
  for (const auto& [frequencies, payload] : {std::pair{0, 0.3}, {8, 0.3}, {1, 300.0}}) {
    hinge.bodies[0].mass = payload;
    hinge.bodies[0].inertia = 1e-3 * payload * Matrix3d::Identity();
    request.frequencies = frequencies;
    auto path = [&](const ModelOptions& model, int runs, double* coefficients = nullptr) {
      double seconds = 1e9, build = 1e9;
      for (int k = 0; k < runs; ++k) {
        const StrokeResponse r = evaluate_stroke(hinge, model, request);
        seconds = std::min(seconds, r.seconds_path);
        build = std::min(build, r.seconds_coefficients);
      }
      if (coefficients) *coefficients = build;
      return seconds;
    };
    double build = 0;
    const double reduced = path({}, 15, &build);
    const double full = path({.accuracy = Accuracy::full}, 5);
    const double fine = path({.accuracy = Accuracy::full, .mesh = {16, 8}}, 3);
    fmt::print(
        "| {} | {} kg | {:.2f} ms | {:.1f} ms | {:.1f} ms, {:.1f} times | {:.0f} ms, {:.0f} times "
        "|\n",
        frequencies, payload, reduced * 1e3, build * 1e3, full * 1e3, full / reduced, fine * 1e3,
        fine / reduced);
  }
}

}  // namespace

int main() {
  leaf_kernels();
  hinge_paths();
}
