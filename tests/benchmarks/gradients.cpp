// What exact derivatives of all outputs cost, as a multiple of the stroke itself.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <vector>

#include "core/math/memory.hpp"
#include "core/reduction/atlas/atlas_file.hpp"
#include "core/reduction/atlas/make_atlas.hpp"
#include "core/response/quantities.hpp"
#include "core/response/stroke_gradients.hpp"
#include "designs/parametric_design.hpp"
#include "support/models.hpp"
#include "tests/benchmarks/measured.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

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
  return least_seconds(
      5, [&] { (void)evaluate_stroke_gradients(of.mechanism, some, model, request); });
}

// Of all numbers f of a path along all sizes p: the largest difference of p df/dp, over the largest
// f of the path.
double largest_difference(const Subject& of, const StrokeSensitivity& a,
                          const StrokeSensitivity& b) {
  double worst = 0;
  for (const Quantity& q : quantities(DriveList(of.mechanism))) {
    if (q.row->name == "displacement" || q.row->name == "rotation") continue;
    double size = 0, difference = 0;
    for (std::size_t k = 0; k < a.response.path.size(); ++k) {
      const auto ga = q.gradient(a.response.path[k], a.gradients->path[k]),
                 gb = q.gradient(b.response.path[k], b.gradients->path[k]);
      if (!ga || !gb) continue;
      size = std::max(size, std::abs(q.value(b.response.path[k]).value_or(0)));
      for (Eigen::Index p = 0; p < gb->size(); ++p)
        difference = std::max(
            difference, std::abs(of.values[static_cast<std::size_t>(p)] * ((*ga)[p] - (*gb)[p])));
    }
    if (size > 0) worst = std::max(worst, difference / size);
  }
  return worst;
}

// The atlas that FLEXOPT_ATLAS names, or one of the hinge's rays alone.
std::shared_ptr<const TubeAtlas> atlas_of_hinge() {
  if (const char* file = std::getenv("FLEXOPT_ATLAS")) return open_atlas(file).value();
  AtlasSettings settings;
  settings.rays = {-1, 1};
  return make_atlas(settings, {.check_cells = {0, 0}, .check_rays = {}}).value();
}

// Leaves that are looked up: costs, and the derivatives against those of full leaves.
void looked_up(const Subject& of, StrokeRequest request) {
  ModelOptions model, full;
  model.atlas = atlas_of_hinge();
  full.accuracy = Accuracy::full;
  const PageTable page("gradients reduced");
  fmt::print(
      "| | stroke | with 1 parameter | with 12 parameters | the same on full leaves | largest "
      "difference of p df/dp over the largest f |\n|---|---|---|---|---|---|\n");
  struct Row {
    const char* name;
    Outputs outputs;
  };
  for (const auto& [name, outputs] :
       {Row{"load, motion, stiffness", {Output::equilibrium, Output::stiffness}},
        Row{"with 4 frequencies",
            {Output::equilibrium, Output::stiffness, Output::frequencies_locked}},
        Row{"with stress", {Output::equilibrium, Output::stiffness, Output::stress}},
        Row{"with both",
            {Output::equilibrium, Output::stiffness, Output::frequencies_locked,
             Output::stress}}}) {
    request.outputs = outputs;
    request.frequencies = 4;
    const StrokeSensitivity a = evaluate_stroke_gradients(of.mechanism, of.directions, model,
                                                          request),
                            b = evaluate_stroke_gradients(of.mechanism, of.directions, full,
                                                          request);
    const double plain =
        least_seconds(5, [&] { (void)evaluate_stroke(of.mechanism, model, request); });
    fmt::print("| {} | {:.2f} ms | {:.2f} | {:.2f} | {:.0f} | {:.1e} |\n", name, 1e3 * plain,
               cost(of, model, request, 1) / plain, cost(of, model, request, 12) / plain,
               cost(of, full, request, 12) / plain, largest_difference(of, a, b));
  }
}

// Full leaves, all outputs.
void full_leaves(const Subject& of, StrokeRequest request) {
  ModelOptions model{.accuracy = Accuracy::full};
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
    const double plain =
        least_seconds(5, [&] { (void)evaluate_stroke(of.mechanism, model, request); });
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

  StrokeRequest request{.points = models::evenly(0.35)};
  full_leaves(hinge, request);
  looked_up(hinge, request);
}
