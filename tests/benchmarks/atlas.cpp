// The atlas that comes along: errors against tubes built anew, times of mechanisms with and without
// it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/reduction/atlas/atlas_file.hpp"
#include "core/response/response.hpp"
#include "support/models.hpp"
#include "tests/benchmarks/measured.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

double median(std::vector<double> x) {
  std::sort(x.begin(), x.end());
  return x[x.size() / 2];
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
  StrokeRequest request{.points = models::evenly(0.5),
                        .outputs = {Output::equilibrium, Output::stiffness},
                        .frequencies = frequencies};
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

}  // namespace

int main() {
  errors(shipped_atlas()->check());
  hinges(shipped_atlas());
}
