// What exact derivatives of all outputs cost, as a multiple of the stroke itself at full accuracy.
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "core/math/memory.hpp"
#include "core/response/stroke_gradients.hpp"
#include "designs/parametric_design.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

template <class Work>
double shortest(const Work& work) {
  double best = 1e300;
  for (int i = 0; i < 5; ++i) {
    const double start = processor_seconds();
    work();
    best = std::min(best, processor_seconds() - start);
  }
  return best;
}

}  // namespace

int main() {
  keep_freed_memory();
  const Family& family = find_family("three_flexure_cross_hinge", "");
  const ParameterValues values{{"length", 0.06},      {"thickness", 4e-4},
                               {"outer_width", 0.02}, {"inner_width", 0.04},
                               {"half_angle", 0.75},  {"crossing_fraction", 0.5},
                               {"gap", 1e-3}};
  const Material material{"steel", 210e9, 0.3, 7800, {}};
  EndEffector payload;
  payload.mass = 1;
  payload.inertia = 1e-3 * Matrix3d::Identity();
  const FamilyChoices choices = default_choices(family);
  const Mechanism mechanism = family.make(values, choices, material, payload);
  const ParametricDesign design(family, choices, {});
  const std::vector<MechanismDirection> all =
      design.directions(values, material, payload, design.independent_names());

  ModelOptions model;
  model.accuracy = Accuracy::full;
  StrokeRequest request;
  request.points.clear();
  for (int i = 0; i <= 10; ++i) request.points.push_back(0.35 * i / 10);
  // three leaves, 11 points, default mesh, stress; cost over that of the stroke alone
  const PageTable page("gradients");
  fmt::print(
      "| frequencies | 1 parameter | 12 parameters | each further one |\n|---|---|---|---|\n");
  struct Row {
    int frequencies, free;
    bool screening;
  };
  for (const auto& [frequencies, free, screening] : {Row{0, 0, false},
                                                     {4, 0, false},
                                                     {8, 0, false},
                                                     {8, 8, false},
                                                     {4, 0, true},
                                                     {8, 8, true}}) {
    request.frequencies = frequencies;
    request.outputs = Outputs::numbers();
    if (free == 0) request.outputs.remove(Output::frequencies_free);
    if (!screening) request.outputs.remove(Output::frequency_derivatives);
    const auto with = [&](std::size_t count) {
      const std::vector<MechanismDirection> some(all.begin(), all.begin() + count);
      return shortest([&] { (void)evaluate_stroke_gradients(mechanism, some, model, request); });
    };
    const double plain = shortest([&] { (void)evaluate_stroke(mechanism, model, request); });
    const double one = with(1), twelve = with(12);
    fmt::print("| {} drive free, {} locked{} | {:.2f} | {:.2f} | {:.3f} |\n", free, frequencies,
               screening ? ", screening" : "", one / plain, twelve / plain,
               (twelve - one) / 11 / plain);
  }
}
