// Every exact derivative of every family against extrapolated differences of the whole path.
//
// At rest, at a small and at a large stroke; the design of the family's defaults, or a symmetric
// one, and random ones.
//   bench_gradient_checks [random designs a family = 1] [seed = 1] [families: these alone]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "core/math/memory.hpp"
#include "optim/problem/check_gradients.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;
using Json = nlohmann::json;

namespace {

struct Case {
  std::string family, flexure;
  Json options = Json::object();
  bool defaults = false;  ///< sizes around those of the family
};

/// The family's own sizes, or random ones around them; strokes of a tenth of a radian and of a
/// hundredth of the first length.
template <class Uniform>
Json job_around_defaults(const Case& of, Uniform&& u, bool as_they_are) {
  const Family& family = find_family(of.family, "");
  Json p = Json::object();
  double length = 0;
  for (const Parameter& parameter : family.parameters) {
    if (length == 0 && parameter.unit == "m") length = *parameter.default_value;
    const bool counts = std::ranges::find(family.counts, parameter.name) != family.counts.end();
    const double factor = as_they_are || counts ? 1 : 0.96 + 0.08 * u();
    p[parameter.name] = *parameter.default_value * factor;
  }
  Json points = Json::array();
  for (const double share : {0.0, 0.1, 1.0}) {
    Json named = Json::object();
    double at = 0;
    for (const DriveList::Item& drive : family.drives.items)
      named[drive.name] = at = share * (is_rotation(drive.direction) ? 0.1 : 0.01 * length);
    points.push_back(family.drives.items.size() > 1 ? named : Json(at));
  }
  Json design{{"family", of.family}, {"parameters", p}, {"material", "stavax"}};
  design.update(of.options);
  return {{"flexopt", 1},
          {"name", of.family},
          {"job", "evaluate"},
          {"design", design},
          {"stroke", {{"at", points}}},
          {"model", {{"flexure", of.flexure}, {"accuracy", "full"}}},
          {"end_effector", {{"mass", 0.1}, {"inertia", {2e-5, 3e-5, 4e-5}}}},
          {"frequencies", 6}};
}

// Sizes in SI from numbers u in [0, 1): a leaf of 40 to 120 mm.
template <class Uniform>
Json random_job(const Case& of, Uniform&& u, bool symmetric) {
  const double length = 0.04 + 0.08 * u();
  const bool wire = of.options.value("section", "") == "circular";
  Json p{{"length", length}};
  const double width = length * (0.15 + 0.6 * u()), thickness = length / (120 + 300 * u());
  if (wire) {
    p["diameter"] = length / (40 + 80 * u());
  } else {
    p["thickness"] = thickness;
    if (of.family != "three_flexure_cross_hinge") p["width"] = width;
  }
  if (of.family == "parallel_guide") p["spacing"] = length * (0.3 + u());
  if (of.family == "cross_hinge" || of.family == "three_flexure_cross_hinge") {
    p["half_angle"] = symmetric ? std::atan(1.0) : 0.55 + 0.5 * u();
    p["crossing_fraction"] = symmetric ? 0.5 : 0.35 + 0.3 * u();
    p["gap"] = length * (0.01 + 0.05 * u());
  }
  if (of.family == "three_flexure_cross_hinge") {
    p["inner_width"] = width;
    p["outer_width"] = symmetric ? width / 2 : width * (0.3 + 0.4 * u());
  }
  const bool turns = of.family.find("hinge") != std::string::npos;
  const double furthest = turns ? 0.5 : 0.2 * length, mass = 0.05 + u();
  const double j = mass * length * length;
  Json design{{"family", of.family},
              {"parameters", p},
              {"material",
               {{"name", "m"},
                {"youngs_modulus", (70 + 140 * u()) * 1e9},
                {"poissons_ratio", 0.25 + 0.1 * u()},
                {"density", 2700 + 5000 * u()}}}};
  design.update(of.options);
  Json job{{"flexopt", 1},
           {"name", of.family},
           {"job", "evaluate"},
           {"design", design},
           {"stroke", {{"at", {0.0, 0.1 * furthest, furthest}}}},
           {"model", {{"flexure", of.flexure}, {"accuracy", "full"}}},
           {"frequencies", 6}};
  if (of.options.value("tip", "") != "free")
    job["end_effector"] = {
        {"mass", mass},
        {"inertia", {j * (0.1 + 0.1 * u()), j * (0.1 + 0.1 * u()), j * (0.12 + 0.1 * u())}}};
  return job;
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  const int designs = argc > 1 ? std::atoi(argv[1]) : 1;
  const unsigned seed = argc > 2 ? static_cast<unsigned>(std::atoi(argv[2])) : 1U;
  const std::vector<std::string> only(argv + std::min(argc, 3), argv + argc);
  std::mt19937 numbers;
  const auto u = [&] { return static_cast<double>(numbers()) / 4294967296.0; };
  std::vector<Case> cases;
  for (const char* flexure : {"plate", "beam"}) {
    for (const char* tip : {"rigid", "guided", "hinged", "free"})
      cases.push_back({"leaf_spring", flexure, {{"tip", tip}}});
    for (const char* family : {"parallel_guide", "cross_hinge", "three_flexure_cross_hinge"})
      cases.push_back({family, flexure});
  }
  for (const Family& family : families()) {
    const bool known =
        std::ranges::any_of(cases, [&](const Case& of) { return of.family == family.name; });
    if (known || family.name == "clamped_plate") continue;  // a plate without rigid end-effector
    const bool wires = family.is_of_wires(default_choices(family));
    const Json options = family.name == "notch_hinge" ? Json{{"model", "beam"}} : Json::object();
    cases.push_back({family.name, wires ? "beam" : "plate", options, true});
  }
  const PageTable page("gradient_checks");
  fmt::print(
      "| family | flexure | derivatives | agree | within 1e-8 | 1e-9 | largest error not explained "
      "|\n|---|---|---|---|---|---|---|\n");
  for (const Case& of : cases) {
    if (!only.empty() && std::ranges::find(only, of.family) == only.end()) continue;
    numbers.seed(seed);  // the same designs whatever other families are run
    std::string name = of.family;
    for (const auto& [option, choice] : of.options.items()) name += " " + choice.get<std::string>();
    std::size_t all = 0, agree = 0, close = 0, closer = 0;
    double worst = 0;
    for (int k = 0; k <= designs; ++k) {
      const Json document =
          of.defaults ? job_around_defaults(of, u, k == 0) : random_job(of, u, k == 0);
      const GradientReport report = check_gradients(parse_job(document), 1e-8, 2);
      if (!report.ok) fmt::print(stderr, "{}, design {}: {}\n", name, k, report.message);
      all += report.checks.size();
      for (const GradientCheck& c : report.checks) {
        agree += c.agrees;
        close += c.error <= 1e-8;
        closer += c.error <= 1e-9;
        if (c.error > 5 * c.known_to) worst = std::max(worst, c.error);
        if (!c.agrees)
          fmt::print(stderr, "  {} {} point {}: {:.9e} {:.9e} error {:.1e} known to {:.1e}\n",
                     c.quantity, c.parameter, c.point, c.exact, c.difference, c.error, c.known_to);
      }
    }
    fmt::print("| {} | {} | {} | {} | {:.1f} % | {:.1f} % | {:.0e} |\n", name, of.flexure, all,
               agree, 100.0 * close / all, 100.0 * closer / all, worst);
    std::fflush(stdout);
  }
}
