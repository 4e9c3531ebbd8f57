// Frequencies of every method against full order over the stroke.
//
// The table of core/response/modes/README.md. Full order: the full leaf with 40 of its own modes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "support/models.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

struct Case {
  std::string name;
  Mechanism mechanism;
  std::vector<double> strokes;
};

std::vector<Case> cases() {
  const double degree = std::numbers::pi / 180;
  const std::vector<double> turns{0, 5 * degree, 10 * degree, 20 * degree, 30 * degree};
  std::vector<Case> made;
  for (const auto& [name, mass, inertia] :
       {std::tuple{"1 kg", 1.0, 6e-4}, std::tuple{"10 g", 0.01, 6e-7}}) {
    made.push_back({fmt::format("guide, {}", name),
                    models::guide(0.1, 0.03, 5e-4, 0.06, mass, inertia),
                    {0, 0.005, 0.01, 0.015, 0.02}});
    Mechanism hinge = models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.02}});
    Mechanism three = models::three_leaf_hinge(0.1, 0.04, 3.5e-4);
    for (Mechanism* m : {&hinge, &three}) m->bodies[0] = models::body({0, 0, 0}, mass, inertia);
    made.push_back({fmt::format("cross hinge, {}", name), hinge, turns});
    made.push_back({fmt::format("three-flexure hinge, {}", name), three, turns});
  }
  return made;
}

constexpr int wanted = 6;  // drive free and drive locked each

StrokeResponse path(const Case& c, const ModelOptions& model) {
  StrokeRequest request{.points = c.strokes, .frequencies = wanted};
  request.outputs.remove(Output::frequency_derivatives);
  request.outputs.remove(Output::stress);
  return evaluate_stroke(c.mechanism, model, request);
}

// Worst relative error of the frequencies that are there; how many are not.
struct Error {
  double worst = 0;
  int missing = 0;
};
Error error(const PathPoint& found, const PathPoint& truth) {
  Error e;
  const auto compare = [&](const std::vector<double>& a, const std::vector<double>& b) {
    for (std::size_t i = 0; i < b.size(); ++i)
      if (i < a.size())
        e.worst = std::max(e.worst, std::abs(a[i] / b[i] - 1));
      else
        ++e.missing;
  };
  compare(found.frequencies_free, truth.frequencies_free);
  compare(found.frequencies_locked, truth.frequencies_locked);
  return e;
}

std::string percent(double x) {
  const double p = 100 * x;
  return p < 0.01 ? fmt::format("{:.4f}", p)
         : p < 1  ? fmt::format("{:.2f}", p)
         : p < 10 ? fmt::format("{:.1f}", p)
                  : fmt::format("{:.0f}", p);
}

struct Variant {
  std::string name;
  ModelOptions model;
};

/// The two options of a model's mass.
struct MassOptions {
  LeafMass mass;
  int modes;
  std::string text() const {
    return fmt::format("{} | {}", mass == LeafMass::constant ? "constant" : "consistent",
                       modes > 0 ? "yes" : "no");
  }
  ModelOptions model() const { return {.mass = mass, .leaf_modes = modes}; }
};
constexpr MassOptions mass_options[] = {{LeafMass::consistent, 2},
                                        {LeafMass::consistent, 0},
                                        {LeafMass::constant, 2},
                                        {LeafMass::constant, 0}};

std::vector<Variant> variants() {
  std::vector<Variant> made;
  for (const auto& [name, accuracy] :
       {std::pair{"full", Accuracy::full}, {"mixed_potential", Accuracy::reduced}})
    for (const MassOptions& options : mass_options) {
      ModelOptions model = options.model();
      model.accuracy = accuracy;
      made.push_back({fmt::format("{} | {}", name, options.text()), model});
    }
  for (const auto& [method, name] :
       {std::pair{Reduction::linear_craig_bampton, "linear_craig_bampton"},
        {Reduction::modal_derivatives, "modal_derivatives"},
        {Reduction::quadratic_manifold, "quadratic_manifold"}})
    for (const int n : {1, 2, 4}) {
      ModelOptions model = mass_options[0].model();
      model.method = method;
      model.superelements = {n, 0};
      made.push_back({fmt::format("{}, n = {} | {}", name, n, mass_options[0].text()), model});
    }
  return made;
}

}  // namespace

int main() {
  const std::vector<Case> all = cases();
  const PageTable page("frequencies plate");
  fmt::print("| method | mass | internal modes |");
  for (const Case& c : all) fmt::print(" {} |", c.name);
  fmt::print("\n|---|---|---|");
  for (std::size_t k = 0; k < all.size(); ++k) fmt::print("---|");
  fmt::print("\n");
  std::vector<StrokeResponse> truths;
  for (const Case& c : all) {
    ModelOptions model{.accuracy = Accuracy::full, .leaf_modes = 40};
    truths.push_back(path(c, model));
  }
  for (const Variant& v : variants()) {
    fmt::print("| {} |", v.name);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const StrokeResponse found = path(all[k], v.model);
      Error worst;
      int lost = 0;  // points without an equilibrium
      for (std::size_t i = 0; i < found.path.size(); ++i) {
        if (found.path[i].status != PointStatus::converged) {
          ++lost;
          continue;
        }
        const Error e = error(found.path[i], truths[k].path[i]);
        worst.worst = std::max(worst.worst, e.worst);
        worst.missing = std::max(worst.missing, e.missing);
      }
      fmt::print(" {}{}{} |", percent(worst.worst),
                 worst.missing > 0 ? fmt::format(", {} absent", worst.missing) : "",
                 lost > 0 ? fmt::format(", {} points lost", lost) : "");
    }
    fmt::print("\n");
  }
}
