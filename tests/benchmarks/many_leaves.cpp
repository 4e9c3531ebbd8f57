// Time and memory against the number of leaves, in series and in parallel.
#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/mechanism/mobility.hpp"
#include "core/response/response.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/family.hpp"
#include "tests/benchmarks/measured.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;
using nlohmann::json;

namespace {

// Largest memory of a call [MB], in a process of its own.
double peak_memory(const std::function<void()>& call) {
  std::fflush(stdout);
  malloc_trim(0);  // what earlier calls have freed is not the child's
  const pid_t child = fork();
  if (child == 0) {
    call();
    _exit(0);
  }
  rusage usage{};
  int status = 0;
  wait4(child, &status, 0, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

json design(const char* text) { return json::parse(text); }

// Leaves in series along x, or between the ground and one body.
json chain() {
  return design(R"json({
    "flexopt_design": 1,
    "parameters": {"n": {"unit": "1"}, "length": {"unit": "m", "default": "50 mm"},
                   "thickness": {"unit": "m", "default": "0.5 mm"}},
    "frames": [{"name": "at {i}", "at": ["i*length", 0, 0], "repeat": {"i": [1, "n - 1"]}}],
    "bodies": [
               {"name": "body {i}", "frame": "at {i}", "repeat": {"i": [1, "n - 1"]}, "at": [0, 0, 0],
                "mass": "10 g", "inertia": [1e-6, 1e-6, 1e-6]},
               {"name": "end_effector", "at": ["n*length", 0, 0]}],
    "leaves": [],
    "drive": {"direction": "uy"}})json");
}

// References have an index, but no formula of one: written out here.
json chain_of(int n) {
  json d = chain();
  for (int i = 1; i <= n; ++i) {
    const auto name = [&](int k) {
      return k == 0 ? std::string("ground") : k == n ? "end_effector" : fmt::format("body {}", k);
    };
    d["leaves"].push_back(
        {{"name", fmt::format("leaf {}", i)},
         {"base", {{"body", name(i - 1)}, {"at", {fmt::format("{}*length", i - 1), 0, 0}}}},
         {"tip", {{"body", name(i)}, {"at", {fmt::format("{}*length", i), 0, 0}}}},
         {"across", {0, 0, 1}},
         {"width", "30 mm"},
         {"thickness", "thickness"}});
  }
  return d;
}

json stack_of(int) {
  return design(R"json({
    "flexopt_design": 1,
    "parameters": {"n": {"unit": "1"}, "length": {"unit": "m", "default": "50 mm"},
                   "thickness": {"unit": "m", "default": "0.5 mm"}},
    "bodies": [{"name": "end_effector", "at": ["length", 0, 0]}],
    "leaves": [{"name": "leaf {i}", "repeat": {"i": [1, "n"]},
                "base": {"body": "ground", "at": [0, "20 mm*(i - (n + 1)/2)", 0]},
                "tip": {"body": "end_effector", "at": ["length", "20 mm*(i - (n + 1)/2)", 0]},
                "across": [0, 0, 1], "width": "30 mm", "thickness": "thickness"
}],
    "drive": {"direction": "uy"}
})json");
}

EndEffector payload() {
  EndEffector e;
  e.mass = 1;
  e.inertia = 8e-4 * Matrix3d::Identity();
  return e;
}

struct Case {
  const char* name;
  json (*of)(int);
};
constexpr Case cases[] = {{"in series", chain_of}, {"in parallel", stack_of}};

struct Made {
  std::shared_ptr<const Family> family;
  ParameterValues values;
  Mechanism mechanism;
  std::vector<MechanismDirection> directions;
};

Made make(const Case& c, int n) {
  FaultList faults;
  Made made;
  made.family = read_family(c.of(n), "/design/mechanism", "", faults);
  faults.raise();
  made.values = {{"n", n}, {"length", 0.05}, {"thickness", 5e-4}};
  const Material& steel = materials().front().material;
  made.mechanism = made.family->make(made.values, {}, steel, payload());
  made.directions = made.family->directions(made.values, {}, steel, payload(),
                                            {"length", "thickness", "material.density"});
  return made;
}

StrokeRequest request() {
  StrokeRequest r{.points = {0, 5e-4, 1e-3}, .frequencies = 6};
  r.outputs.remove(Output::frequency_derivatives);
  return r;
}

void times() {
  const PageTable page("many_leaves times");
  fmt::print(
      "| leaves | | design | its constraints | coefficients of reduced leaves | stroke point, "
      "reduced | full | with gradients, full | memory, reduced | full |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Case& c : cases) {
    std::vector<double> before;
    std::vector<double> last;
    for (int n = 2; n <= 512; n *= 2) {
      Made made;
      const double of_design = seconds([&] { made = make(c, n); });
      const double of_mobility = seconds([&] { (void)mobility(made.mechanism); });
      const StrokeRequest r = request();
      const auto points = static_cast<double>(r.points.size());
      StrokeResponse reduced;
      const double all = seconds([&] { reduced = evaluate_stroke(made.mechanism, {}, r); });
      const double share =
          reduced.seconds_coefficients / (reduced.seconds_coefficients + reduced.seconds_path);
      const ModelOptions full{.accuracy = Accuracy::full};
      const double of_full =
          seconds([&] { (void)evaluate_stroke(made.mechanism, full, r); }) / points;
      const double of_gradients =
          seconds(
              [&] { (void)evaluate_stroke_gradients(made.mechanism, made.directions, full, r); }) /
          points;
      before = last;
      last = {of_design, of_mobility, share * all, (1 - share) * all / points,
              of_full,   of_gradients};
      fmt::print("| {} | {} |", n, c.name);
      for (const double t : last) fmt::print(" {:.3g} ms |", 1e3 * t);
      StrokeRequest everything = r;
      everything.outputs = Outputs::numbers();
      for (const ModelOptions& model : {ModelOptions{}, full}) {
        last.push_back(
            peak_memory([&] { (void)evaluate_stroke(made.mechanism, model, everything); }));
        fmt::print(" {:.0f} MB |", last.back());
      }
      fmt::print("{}\n", reduced.status == Status::ok ? "" : " no equilibrium");
    }
    fmt::print("| slope | {} |", c.name);
    for (std::size_t k = 0; k < last.size(); ++k)
      fmt::print(" {:.2f} |", std::log2(last[k] / before[k]));
    fmt::print("\n");
  }
}

}  // namespace

int main() { times(); }
