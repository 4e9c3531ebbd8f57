// What exact derivatives of all outputs cost, as a multiple of the stroke itself.
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "core/math/memory.hpp"
#include "core/reduction/atlas/make_atlas.hpp"
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

struct Subject {
  Mechanism mechanism;
  std::vector<MechanismDirection> directions;
  std::vector<double> values;  ///< of its sizes; 0 for other parameters
};

// Of the stroke of each: what its derivatives by so many parameters cost.
double cost(const Subject& of, const ModelOptions& model, const StrokeRequest& request,
            std::size_t parameters) {
  const std::vector<MechanismDirection> some(
      of.directions.begin(), of.directions.begin() + static_cast<std::ptrdiff_t>(parameters));
  return shortest([&] { (void)evaluate_stroke_gradients(of.mechanism, some, model, request); });
}

// Leaves that are looked up: load, motion and stiffness; the derivatives against those of full
// leaves.
void looked_up(const Subject& of, StrokeRequest request) {
  AtlasSettings settings;
  settings.rays = {-1, 1};  // those of the hinge
  ModelOptions model;
  model.atlas = make_atlas(settings, {.check_cells = {0, 0}, .check_rays = {}}).atlas;
  ModelOptions full;
  full.accuracy = Accuracy::full;
  request.outputs = {Output::equilibrium, Output::stiffness};
  const StrokeSensitivity a = evaluate_stroke_gradients(of.mechanism, of.directions, model,
                                                        request),
                          b = evaluate_stroke_gradients(of.mechanism, of.directions, full, request);
  double worst = 0;  // of all stiffnesses along all sizes
  for (std::size_t k = 0; k < request.points.size(); ++k)
    for (int d = 0; d < 6; ++d) {
      const auto &ga = a.gradients->path[k].support_stiffness[static_cast<std::size_t>(d)],
                 &gb = b.gradients->path[k].support_stiffness[static_cast<std::size_t>(d)];
      if (!ga || !gb) continue;
      const double value = *b.response.path[k].support_stiffness[static_cast<std::size_t>(d)];
      for (Eigen::Index p = 0; p < gb->size(); ++p) {
        const double by = of.values[static_cast<std::size_t>(p)];
        worst = std::max(worst, std::abs(by * ((*ga)[p] - (*gb)[p]) / value));
      }
    }
  const double plain = shortest([&] { (void)evaluate_stroke(of.mechanism, model, request); });
  const double full_plain = shortest([&] { (void)evaluate_stroke(of.mechanism, full, request); });
  const PageTable page("gradients reduced");
  fmt::print(
      "| | looked-up leaves | full leaves |\n|---|---|---|\n"
      "| stroke | 1 | {:.0f} |\n| with 1 parameter | {:.1f} | {:.0f} |\n"
      "| with 12 parameters | {:.1f} | {:.0f} |\n"
      "| largest difference of p/k dk/dp of the support stiffnesses k | {:.1e} | |\n",
      full_plain / plain, cost(of, model, request, 1) / plain, cost(of, full, request, 1) / plain,
      cost(of, model, request, 12) / plain, cost(of, full, request, 12) / plain, worst);
}

// Full leaves, all outputs.
void full_leaves(const Subject& of, StrokeRequest request) {
  ModelOptions model;
  model.accuracy = Accuracy::full;
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
    const double plain = shortest([&] { (void)evaluate_stroke(of.mechanism, model, request); });
    const double one = cost(of, model, request, 1), twelve = cost(of, model, request, 12);
    fmt::print("| {} drive free, {} locked{} | {:.2f} | {:.2f} | {:.3f} |\n", free, frequencies,
               screening ? ", screening" : "", one / plain, twelve / plain,
               (twelve - one) / 11 / plain);
  }
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
  Subject hinge{mechanism, {}, {}};
  for (const std::string& name : design.independent_names()) {
    hinge.directions.push_back(design.directions(values, material, payload, {name}).front());
    const auto at = values.find(name);
    hinge.values.push_back(at == values.end() ? 0 : at->second);
  }

  StrokeRequest request;
  request.points.clear();
  for (int i = 0; i <= 10; ++i) request.points.push_back(0.35 * i / 10);
  full_leaves(hinge, request);
  looked_up(hinge, request);
}
