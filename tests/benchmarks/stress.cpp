// Stress of the reduced leaf from its tables: errors against full leaves, and times.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <numbers>

#include "core/elements/leaf/leaf_scale.hpp"
#include "core/reduction/tube/tube_leaf.hpp"
#include "core/response/response.hpp"
#include "support/models.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

const double pi = std::numbers::pi;

struct Row {
  std::string name;
  Mechanism mechanism;
  double stroke;
  double load = 0;  ///< on O, out of the plane of the motion [N]
};

std::vector<Row> rows() {
  std::vector<Row> all;
  const auto add = [&](const std::string& name, const Mechanism& mechanism, double stroke,
                       double load) {
    all.push_back({name, mechanism, stroke, 0});
    all.push_back({name + ", loaded", mechanism, stroke, load});
  };
  const auto guide = [&](double length, double width, double thickness, double load) {
    add(fmt::format("guide {:g} × {:g} × {:g} mm, 0.3 L", 1e3 * length, 1e3 * width,
                    1e3 * thickness),
        models::guide(length, width, thickness, length), 0.3 * length, load);
  };
  guide(0.1, 0.01, 5e-4, 0.2);
  guide(0.1, 0.03, 5e-4, 2);
  guide(0.06, 0.04, 4e-4, 2);
  guide(0.06, 0.06, 2.5e-4, 1);
  add("cross hinge 100 × 20 × 0.35 mm, 45°",
      models::hinge(0.1, 3.5e-4, {{1, 0.0125, 0.02}, {-1, -0.0125, 0.02}}), pi / 4, 1);
  add("three leaves 60 × 60 × 0.4 mm, 30°", models::three_leaf_hinge(0.06, 0.06, 4e-4), pi / 6, 3);
  add("three leaves 60 × 60 × 0.25 mm, 45°", models::three_leaf_hinge(0.06, 0.06, 2.5e-4), pi / 4,
      1);
  return all;
}

void errors() {
  const PageTable page("stress errors");
  fmt::print(
      "| mechanism | w²/(Lt) | median | largest | leaves from tables |\n|---|---|---|---|---|\n");
  for (const Row& row : rows()) {
    StrokeRequest request;
    request.points.clear();
    for (int k = -10; k <= 10; ++k)
      if (k != 0) request.points.push_back(row.stroke * k / 10);
    request.outputs = {Output::equilibrium, Output::stress};
    if (row.load > 0) {
      DeadLoad load;
      load.force = {0, 0, -row.load};
      request.loads.constant.push_back(load);
    }
    ModelOptions full;
    full.accuracy = Accuracy::full;
    const StrokeResponse found = evaluate_stroke(row.mechanism, {}, request),
                         truth = evaluate_stroke(row.mechanism, full, request);
    std::vector<double> error;
    int from_tables = 0, leaves = 0;
    for (std::size_t k = 0; k < std::min(found.path.size(), truth.path.size()); ++k) {
      if (!found.path[k].max_stress || !truth.path[k].max_stress) continue;
      error.push_back(
          std::abs(found.path[k].max_stress->value / truth.path[k].max_stress->value - 1));
      for (const LeafReport& leaf : found.path[k].leaves) {
        ++leaves;
        from_tables += leaf.model == "tube" && leaf.reason.empty();
      }
    }
    std::sort(error.begin(), error.end());
    const LeafSpring& leaf = row.mechanism.leaves[row.mechanism.leaves.size() / 2];
    fmt::print("| {} | {:.0f} | {:.3f} % | {:.3f} % | {} of {} |\n", row.name,
               leaf.width * leaf.width / (leaf.length * leaf.thickness),
               100 * error[error.size() / 2], 100 * error.back(), from_tables, leaves);
  }
}

/// Least processor time of several runs [µs per call].
double microseconds(int calls, const std::function<double(int)>& f) {
  constexpr int runs = 9;
  double best = 1e300, check = 0;
  for (int run = 0; run < runs; ++run) {
    const std::clock_t start = std::clock();
    for (int i = 0; i < calls; ++i) check += f(i);
    best = std::min(best, 1e6 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / calls);
  }
  fmt::print(stderr, "sum {}\n", check);  // keeps the calls alive
  return best;
}

void times() {
  const PlateShape shape{0.67, 0.0067, 0.3, {10, 4}, true};
  const auto mesh = std::make_shared<PlateMesh>(shape);
  const TubeRange range{.ray = {1, 1}, .sigma_max = 0.4};
  TubeModel model(mesh, range);
  const double with = microseconds(2, [&](int) {
    TubeModel fresh(mesh, range);
    return fresh.stress()->last_sigma();
  });
  const double without =
      microseconds(2, [&](int) { return TubeModel(mesh, range).potential().last_sigma(); });
  const auto place = [](int k) {
    return TubeStress::Place{0.1 + 1e-4 * (k % 1000), 0.01, 0.003, {0.5, 0.1, 0.2}};
  };
  const TubeStress& tables = *model.stress();
  const double strains =
      microseconds(2000, [&](int k) { return tables.evaluate(place(k)).change; });
  const double peak = microseconds(2000, [&](int k) {
    return largest_stress(tables.evaluate(place(k)).strains, shape, 1, 0).value;
  });
  const LeafSpring spring = models::leaf({0, 0, 0}, {1, 0, 0}, 1, shape.width, shape.thickness);
  const LeafScale scale(spring);
  PlateLeaf plate(mesh);
  const ChordLeaf leaf(mesh);
  const auto rebuild = [&](int k) {
    const TubeStress::Place at = place(k);
    const Vector3d s(at.sigma + at.tau, at.sigma - at.tau, at.twist);
    const VectorXd y = model.fields(s, at.f);
    plate.set_state({leaf.edges(s, y.tail<3>()), y.head(y.size() - 3)});
  };
  const auto stress = [&] {
    return plate_max_stress(*mesh, plate.nodal(), spring, scale, 0).value;
  };
  const double rebuilt = microseconds(200, [&](int k) {
    rebuild(k);
    return stress();
  });
  const double stepped = microseconds(50, [&](int k) {
    rebuild(k);
    plate.assemble();
    PlateLeaf::State state = plate.state();
    state.x += plate.internal_step(Vector12d::Zero());
    plate.set_state(state);
    return stress();
  });
  const PageTable page("stress times");
  fmt::print("| part | time |\n|---|---|\n");
  fmt::print("| strains of a leaf and state from tables, with (T3) | {:.1f} µs |\n", strains);
  fmt::print("| and the largest stress of both surfaces | {:.1f} µs |\n", peak);
  fmt::print("| the same of a rebuilt leaf | {:.1f} µs |\n", rebuilt);
  fmt::print("| the same after a Newton step | {:.0f} µs |\n", stepped);
  fmt::print("| making the tables, beside {:.0f} ms for the tube | {:.1f} ms |\n", 1e-3 * without,
             1e-3 * (with - without));
}

}  // namespace

int main() {
  errors();
  times();
  return 0;
}
