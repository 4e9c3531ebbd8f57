// The atlas of tubes: errors against tubes built anew, size, times of making and looking up.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <functional>
#include <random>
#include <thread>
#include <vector>

#include "core/reduction/atlas/atlas_file.hpp"
#include "core/reduction/atlas/make_atlas.hpp"
#include "core/reduction/tube/tube_leaf.hpp"
#include "core/response/response.hpp"
#include "support/models.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

// Processor time of a call, of all threads [s]: other work on the machine does not count.
double seconds(const std::function<void()>& call) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double start = now();
  call();
  return now() - start;
}

double median(std::vector<double> x) {
  std::sort(x.begin(), x.end());
  return x[x.size() / 2];
}

constexpr unsigned cores = 2;

void on_two_cores(int count, const std::function<void(int)>& work) {
  std::atomic<int> next = 0;
  const auto run = [&] {
    for (int i = next++; i < count; i = next++) work(i);
  };
  std::vector<std::thread> others;
  for (unsigned k = 1; k < cores; ++k) others.emplace_back(run);
  run();
  for (std::thread& t : others) t.join();
}

void errors(const AtlasCheck& check) {
  const PageTable page("atlas errors");
  fmt::print(
      "| ray ρ | drive load | stiffness on the ray | off the ray | internal frequencies | stress "
      "|\n|---|---|---|---|---|---|\n");
  for (const AtlasCheck::Ray& ray : check.rays) {
    const AtlasCheck::Errors m = ray.median(), l = ray.largest();
    const auto cell = [](double a, double b) { return fmt::format("{:.1e} / {:.1e}", a, b); };
    fmt::print("| {:g} | {} | {} | {} | {} | {} |\n", ray.rho, cell(m.drive, l.drive),
               cell(m.on_ray, l.on_ray), cell(m.off_ray, l.off_ray), cell(m.frequency, l.frequency),
               cell(m.stress, l.stress));
  }
}

struct Difference {
  double drive = 0, support = 0, frequency = 0;
};

void add_difference(const StrokeResponse& a, const StrokeResponse& b, Difference& worst) {
  const auto relative = [](double x, double y) { return std::abs(x / y - 1); };
  for (std::size_t k = 0; k < b.path.size(); ++k) {
    const PathPoint &p = a.path[k], &q = b.path[k];
    if (p.status != PointStatus::converged || q.status != PointStatus::converged) continue;
    if (q.stroke != 0) worst.drive = std::max(worst.drive, relative(p.drive_load, q.drive_load));
    for (int d = 0; d < 6; ++d)
      if (q.support_stiffness[d])
        worst.support =
            std::max(worst.support, relative(*p.support_stiffness[d], *q.support_stiffness[d]));
    for (std::size_t i = 0; i < q.frequencies_locked.size(); ++i)
      worst.frequency =
          std::max(worst.frequency, relative(p.frequencies_locked[i], q.frequencies_locked[i]));
  }
}

// Three-leaf hinges of random sizes, always the same ones.
class HingeSizes {
 public:
  Mechanism next() {
    const double length = in(0.05, 0.08), width = in(0.02, 0.05), thickness = in(3e-4, 5e-4);
    Mechanism hinge = models::three_leaf_hinge(length, width, thickness);
    hinge.bodies[0].mass = 0.3;
    hinge.bodies[0].inertia = 3e-4 * Matrix3d::Identity();
    return hinge;
  }

 private:
  double in(double a, double b) {
    return a + (b - a) * (static_cast<double>(random_()) / 4294967296.0);
  }
  std::mt19937 random_{1};
};

StrokeRequest hinge_request(int frequencies, bool stress) {
  StrokeRequest request;
  request.points.clear();
  for (int k = 0; k < 11; ++k) request.points.push_back(0.5 * k / 10);
  request.frequencies = frequencies;
  request.outputs = {Output::equilibrium, Output::stiffness};
  if (frequencies > 0) request.outputs.add({Output::frequencies_free, Output::frequencies_locked});
  if (stress) request.outputs.add({Output::stress});
  return request;
}

// A hinge of new leaves each time: looked up, built, full, looked up, …
void hinges(const std::shared_ptr<const TubeAtlas>& atlas) {
  const PageTable page("atlas hinge");
  fmt::print(
      "| asked for beside 6 × 6 | looked up | built | full | full on 16×8 | built, full, full on "
      "16×8 / looked up | drive load | support stiffness | frequencies |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  struct Case {
    const char* name;
    int frequencies;
    bool stress;
  };
  for (const Case& c : {Case{"nothing", 0, false}, Case{"8 + 8 frequencies", 8, false},
                        Case{"8 + 8 frequencies, stress", 8, true}}) {
    const StrokeRequest request = hinge_request(c.frequencies, c.stress);
    HingeSizes sizes;
    std::array<ModelOptions, 4> models{};  // looked up, built, full, full and finer
    models[0].atlas = atlas;
    models[2].accuracy = models[3].accuracy = Accuracy::full;
    models[3].mesh = {16, 8};
    std::array<std::vector<double>, 4> times;
    Difference worst;
    for (int k = 0; k < 24; ++k) {
      const Mechanism hinge = sizes.next();
      std::array<StrokeResponse, 4> found;
      for (std::size_t m = 0; m < models.size(); ++m)
        times[m].push_back(seconds([&] { found[m] = evaluate_stroke(hinge, models[m], request); }));
      add_difference(found[0], found[2], worst);
    }
    const auto ratio = [&](std::size_t m) {
      std::vector<double> all;
      for (std::size_t k = 0; k < times[m].size(); ++k) all.push_back(times[m][k] / times[0][k]);
      return median(all);
    };
    fmt::print("| {} |", c.name);
    for (const std::vector<double>& t : times) fmt::print(" {:.2f} ms |", 1e3 * median(t));
    fmt::print(" {:.1f}, {:.1f}, {:.0f} | {:.1e} | {:.1e} | {} |\n", ratio(1), ratio(2), ratio(3),
               worst.drive, worst.support,
               c.frequencies > 0 ? fmt::format("{:.1e}", worst.frequency) : "–");
  }
}

// The same with the model ready: what a path takes once its leaves are there. Least processor time
// of some runs of each in turn, less the least time that the leaves took.
void ready_hinges(const std::shared_ptr<const TubeAtlas>& atlas) {
  const PageTable page("atlas ready");
  fmt::print(
      "| asked for beside 6 × 6 | looked up | full on 10×4 | full | full on 10×4, full / looked up "
      "|\n|---|---|---|---|---|\n");
  for (const bool stress : {false, true}) {
    const StrokeRequest request = hinge_request(8, stress);
    std::array<ModelOptions, 3> models{};  // looked up, full and coarser, full
    models[0].atlas = atlas;
    models[1].accuracy = models[2].accuracy = Accuracy::full;
    models[1].mesh = {10, 4};
    std::array<std::vector<double>, 3> times, ratios;
    HingeSizes sizes;
    for (int k = 0; k < 8; ++k) {
      const Mechanism hinge = sizes.next();
      std::array<double, 3> whole{1e9, 1e9, 1e9}, leaves = whole, least{};
      for (int run = 0; run < 5; ++run)
        for (std::size_t m = 0; m < models.size(); ++m)
          for (int again = 0; again < (m == 0 ? 8 : 1); ++again) {
            StrokeResponse found;
            whole[m] = std::min(
                whole[m], seconds([&] { found = evaluate_stroke(hinge, models[m], request); }));
            leaves[m] = std::min(leaves[m], found.seconds_coefficients);
          }
      for (std::size_t m = 0; m < models.size(); ++m) least[m] = whole[m] - leaves[m];
      for (std::size_t m = 0; m < models.size(); ++m) {
        times[m].push_back(least[m]);
        ratios[m].push_back(least[m] / least[0]);
      }
    }
    fmt::print("| 8 + 8 frequencies{} | {:.2f} ms | {:.1f} ms | {:.1f} ms | {:.1f}, {:.1f} |\n",
               stress ? ", stress" : "", 1e3 * median(times[0]), 1e3 * median(times[1]),
               1e3 * median(times[2]), median(ratios[1]), median(ratios[2]));
  }
}

}  // namespace

int main(int argc, char** argv) {
  // An atlas that is there spares the making.
  OpenedAtlas opened;
  double making = 0;
  std::filesystem::path file =
      std::filesystem::temp_directory_path() / "flexopt_bench_atlas" / "tubes.atlas";
  if (argc > 1) {
    file = argv[1];
  } else {
    MadeAtlas made;
    making = seconds([&] { made = make_atlas({}, {.loop = on_two_cores}); });
    if (!made.atlas || !write_atlas(*made.atlas, file).empty()) return 1;
  }
  const double opening = seconds([&] { opened = open_atlas(file); });
  if (!opened.atlas) return 1;
  const TubeAtlas& atlas = *opened.atlas;
  errors(atlas.check());

  {
    const PageTable page("atlas times");
    const AtlasSettings& s = atlas.settings();
    std::mt19937 random(3);
    const auto in = [&](double a, double b) {
      return a + (b - a) * (static_cast<double>(random()) / 4294967296.0);
    };
    const auto shape = [&](double nu) {
      return PlateShape{in(0.15, 2), in(1.0 / 500, 1.0 / 60), nu, s.mesh, s.free_edge_torsion};
    };
    double sum = 0;
    const auto each = [&](int runs, const std::function<void()>& call) {
      std::vector<double> all;
      for (int k = 0; k < runs; ++k) all.push_back(seconds(call));
      return 1e3 * median(all);
    };
    const auto look_up = [&](const Eigen::Vector2d& ray, double nu) {
      return each(400, [&] { sum += atlas.look_up(shape(nu), ray).nodes[1].W[30]; });
    };
    fmt::print("| | |\n|---|---|\n");
    if (making > 0)
      fmt::print("| made, {} leaves, check included | {:.0f} s of processor time |\n",
                 s.shapes() * s.tables(), making);
    fmt::print("| size | {:.1f} MB |\n",
               1e-6 * static_cast<double>(std::filesystem::file_size(file)));
    fmt::print("| opened, contents checked | {:.0f} ms |\n", 1e3 * opening);
    fmt::print("| look-up on a ray of the atlas, ν of the atlas | {:.3f} ms |\n",
               look_up({1, -1}, 0.3));
    fmt::print("| … between rays | {:.3f} ms |\n", look_up({1, -0.3}, 0.3));
    fmt::print("| … between rays, ν = 0.33 | {:.3f} ms |\n", look_up({1, -0.3}, 0.33));
    fmt::print("| look-up and potential, ready for use | {:.3f} ms |\n", each(200, [&] {
                 const PlateShape one = shape(0.3);
                 const TubeAtlas::Tube tube = atlas.look_up(one, {1, -1});
                 sum += TubeModel(one, {.ray = {1, -1}, .sigma_max = 0.4},
                                  KnownTube{tube.directions, tube.nodes, {}, {}, {}})
                            .potential()
                            .last_sigma();
               }));
    const auto dynamics = [&](const Eigen::Vector2d& ray, StationsWanted stations) {
      return each(
          200, [&] { sum += atlas.dynamics(shape(0.3), ray, 0.4, stations)[1].table.even(0, 0); });
    };
    fmt::print("| tables of the dynamics, on a ray | {:.3f} ms |\n",
               dynamics({1, -1}, StationsWanted::no));
    fmt::print("| … between rays | {:.3f} ms |\n", dynamics({1, -0.3}, StationsWanted::no));
    fmt::print("| … with motions of the stations | {:.3f} ms |\n",
               dynamics({1, -0.3}, StationsWanted::yes));
    const auto stress = [&](const Eigen::Vector2d& ray) {
      return each(200, [&] { sum += atlas.look_up_stress(shape(0.3), ray)[1].even(0, 0); });
    };
    fmt::print("| tables of stress, on a ray | {:.3f} ms |\n", stress({1, -1}));
    fmt::print("| … between rays | {:.3f} ms |\n", stress({1, -0.3}));
    fmt::print("| the potential built | {:.1f} ms |\n", each(12, [&] {
                 sum += TubeModel(std::make_shared<PlateMesh>(shape(0.3)),
                                  {.ray = {1, -1}, .sigma_max = 0.4})
                            .potential()
                            .last_sigma();
               }));
    fmt::print(stderr, "sum {}\n", sum);  // keeps the calls alive
  }
  hinges(opened.atlas);
  ready_hinges(opened.atlas);
  if (argc == 1) std::filesystem::remove_all(file.parent_path());
}
