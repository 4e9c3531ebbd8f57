// Times of reduced leaves against full ones, as ratios measured in one run on an idle machine.
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <numbers>
#include <vector>

#include "core/elements/plate/full_leaf.hpp"
#include "core/reduction/tube/tube_leaf.hpp"
#include "core/response/response.hpp"
#include "support/models.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

// Least processor time of `runs` calls [s]: other work on the machine does not count.
double least_seconds(int runs, const std::function<void()>& call) {
  double least = 1e9;
  for (int k = 0; k < runs; ++k) {
    const std::clock_t start = std::clock();
    call();
    least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return least;
}

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
    StrokeRequest request;
    request.points = {0.003};
    request.outputs.remove(Output::stress);
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
  request.points.clear();
  for (int k = 0; k < 11; ++k) request.points.push_back(std::numbers::pi / 6 * k / 10);
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

// Frequency derivatives, as a screening uses them, against the full path that they stand for.
void screening() {
  const PageTable page("timings screening");
  fmt::print(
      "| | frequencies | derivatives | full path of 11 points | ratio |\n|---|---|---|---|---|\n");
  struct Case {
    const char* name;
    Mechanism mechanism;
    double stroke;
  };
  Mechanism leaf = models::single_leaf(0.1, 0.03, 5e-4);
  leaf.bodies[0] = models::body({0.1, 0, 0}, 0.3, 3e-4);
  const Case cases[] = {
      {"leaf spring", leaf, 0.02},
      {"guide", models::guide(0.1, 0.03, 5e-4), 0.02},
      {"cross hinge", models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.02}}), 0.5},
      {"three-leaf hinge", models::three_leaf_hinge(0.06, 0.04, 4e-4), 0.5}};
  for (const Case& c : cases)
    for (const int frequencies : {2, 4, 8}) {
      StrokeRequest path;
      path.points.clear();
      for (int k = 0; k < 11; ++k) path.points.push_back(c.stroke * k / 10);
      path.frequencies = frequencies;
      path.outputs.remove(Output::frequency_derivatives);
      StrokeRequest derivatives = path;
      derivatives.outputs = {Output::frequency_derivatives};
      const ModelOptions full{.accuracy = Accuracy::full};
      const auto least_cpu = [&](const StrokeRequest& request) {
        return least_seconds(9, [&] { evaluate_stroke(c.mechanism, full, request); });
      };
      const double t_path = least_cpu(path), t_derivatives = least_cpu(derivatives);
      fmt::print("| {} | {} | {:.2f} ms | {:.1f} ms | {:.3f} |\n", c.name, frequencies,
                 t_derivatives * 1e3, t_path * 1e3, t_derivatives / t_path);
    }
}

}  // namespace

int main() {
  leaf_kernels();
  hinge_paths();
  screening();
}
