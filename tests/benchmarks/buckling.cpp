// Critical factors of a payload over the stroke: followed, against the linear estimate; times.
#include <fmt/format.h>

#include <ctime>

#include "core/math/rotation.hpp"
#include "core/response/buckling/critical_load.hpp"
#include "core/response/models/leaf_models.hpp"
#include "support/models.hpp"
#include "support/one_stroke.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

std::string shown(const std::optional<double>& factor, double load) {
  return factor ? fmt::format("{:.1f}", *factor * load) : "–";
}

void print_rows(const char* name, const Mechanism& mechanism, double load,
                const std::vector<double>& strokes, const char* unit, double shown_unit) {
  const ModelOptions model;
  const NewtonOptions newton;
  LoadCase loads;
  loads.constant = {{.force = {-load, 0, 0}}};
  System system(mechanism, make_full_leaves(mechanism, model), loads);
  if (!step_load(system, {.constant = 1}, newton).converged) return;
  for (const double stroke : strokes) {
    const Equilibrium at = step_to(system, stroke, newton);
    if (!at.converged) return;
    std::string row =
        fmt::format("| {}, {:g} N | {:g} {} |", name, load, stroke * shown_unit, unit);
    double seconds = 0;
    for (const DriveState drive : {DriveState::locked, DriveState::free}) {
      const std::clock_t start = std::clock();
      LoadBranch branch(system, 0, 0, drive, at.drive_loads, newton);
      const CriticalLoad found = find_critical_load(branch, model, nullptr).load;
      seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
      row +=
          fmt::format(" {} | {} | {} |", shown(found.linearised, load), shown(found.factor, load),
                      !found.factor ? "none"
                      : found.fold  ? "fold"
                                    : "bifurcation");
    }
    fmt::print("{} {:.2f} s |\n", row, seconds);
  }
}

}  // namespace

int main() {
  const PageTable page("buckling strokes");
  fmt::print(
      "| mechanism, payload along −x | stroke | held: estimate [N] | followed [N] | kind | free: "
      "estimate [N] | followed [N] | kind | CPU |\n|---|---|---|---|---|---|---|---|---|\n");
  print_rows("guide", models::guide(0.1, 0.03, 5e-4, 0.1), 10, {0, 0.001, 0.005, 0.01, 0.02}, "mm",
             1e3);
  print_rows("guide", models::guide(0.1, 0.03, 5e-4, 0.1), 300, {0, 0.001, 0.005, 0.01}, "mm", 1e3);
  print_rows("cross hinge", models::hinge(0.1, 3.5e-4, {{1, 0.015, 0.02}, {-1, -0.015, 0.02}}), 10,
             {0, 0.1, 0.2, 0.4}, "rad", 1);
}
