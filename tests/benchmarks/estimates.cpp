// How good estimated errors are: against fine meshes, over sampled designs of ten families.
//
// bench_estimates [DESIGNS] takes so many designs of each family (8).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/math/memory.hpp"
#include "core/response/path/model_choice.hpp"
#include "core/spec/spec_error.hpp"
#include "tests/benchmarks/estimates/drawn_designs.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

StrokeRequest request_of(const Drawn& drawn) {
  StrokeRequest request{.points = {0, 0.15 * drawn.stroke, 0.5 * drawn.stroke, drawn.stroke},
                        .frequencies = 6};
  return estimate_request(request);
}

ModelOptions options(Accuracy accuracy, const std::array<int, 2>& mesh) {
  return {.accuracy = accuracy, .mesh = mesh};
}

/// A number with its estimate, all relative.
struct Judged {
  ErrorKind kind;
  std::string family;
  double error = 0, estimate = 0;
};

using Values = std::map<std::string, double>;
Values values_of(const PathPoint& point) {
  Values values;
  for (const EstimatedError& number : estimated_numbers(point)) values[number.name] = number.value;
  return values;
}

/// Values of 24 × 10 elements and of a finer mesh, extrapolated: of narrow leaves one finer along,
/// where their ends need it.
std::vector<Values> truth_of(const Mechanism& mechanism, const StrokeRequest& request) {
  double narrow = 1e300;
  for (const LeafSpring& leaf : mechanism.leaves)
    narrow = std::min(narrow, leaf.width / leaf.length);
  const bool longer = narrow < 0.3;
  // the errors of the finer mesh over its difference from the coarser one, third order
  const double rest = longer ? 0.2 : 0.5;
  const StrokeResponse coarse =
      evaluate_stroke(mechanism, options(Accuracy::full, {24, 10}), request);
  const StrokeResponse fine = evaluate_stroke(
      mechanism,
      options(Accuracy::full, longer ? std::array<int, 2>{44, 10} : std::array<int, 2>{34, 14}),
      request);
  std::vector<Values> truth;
  if (coarse.status != Status::ok || fine.status != Status::ok) return truth;
  for (std::size_t k = 0; k < fine.path.size(); ++k) {
    Values values = values_of(fine.path[k]), before = values_of(coarse.path[k]);
    for (auto& [name, value] : values)
      if (before.contains(name)) value += rest * (value - before[name]);
    truth.push_back(std::move(values));
  }
  return truth;
}

/// Numbers that have an estimate and are not zero, with their truth.
template <class Visit>
void each_with_truth(const StrokeErrors& errors, const std::vector<Values>& truth,
                     const Visit& visit) {
  for (std::size_t k = 0; k < truth.size(); ++k)
    for (const EstimatedError& number : errors.path[k])
      if (const auto found = truth[k].find(number.name);
          found != truth[k].end() && number.scale > 0)
        visit(number, found->second, k);
}

/// The numbers of a reduced path on the default mesh, estimated by full ones on this mesh and two
/// finer ones; nothing where one of the paths is not whole.
bool judge(const Mechanism& mechanism, const StrokeRequest& request,
           const std::vector<Values>& truth, const std::string& family,
           std::vector<Judged>& numbers) {
  const std::array<int, 2> mesh = default_mesh;
  const auto run = [&](Accuracy accuracy, const std::array<int, 2>& elements) {
    return std::make_shared<const StrokeResponse>(
        evaluate_stroke(mechanism, options(accuracy, elements), request));
  };
  const auto reduced = run(Accuracy::reduced, mesh), own = run(Accuracy::full, mesh),
             along = run(Accuracy::full, more_along(mesh)),
             across = run(Accuracy::full, more_across(mesh));
  for (const auto& one : {reduced, own, along, across})
    if (one->status != Status::ok) return false;
  MechanismScale scale = scale_of(mechanism, options(Accuracy::full, mesh));
  scale.theory = {};  // the truth is that of full leaves
  each_with_truth(
      errors_of(*reduced, {own, along, across, mesh, scale}), truth,
      [&](const EstimatedError& number, double true_value, std::size_t) {
        numbers.push_back({number.kind, family, std::abs(number.value - true_value) / number.scale,
                           number.relative()});
      });
  return true;
}

double percentile(std::vector<double> sorted, double share) {
  if (sorted.empty()) return 0;
  std::ranges::sort(sorted);
  return sorted[std::min(sorted.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
}

void row(const std::string& name, const std::vector<Judged>& numbers,
         const std::function<bool(const Judged&)>& counts) {
  // an error below this is rounding or zero by symmetry: it must be covered, nothing else
  constexpr double exact = 1e-6;
  int all = 0, covered = 0, sharp = 0, judged = 0;
  std::vector<double> errors, estimates;
  for (const Judged& n : numbers) {
    if (!counts(n)) continue;
    ++all;
    covered += n.error <= std::max(n.estimate, exact);
    if (n.error <= exact) continue;
    ++judged;
    sharp += n.estimate <= 5 * n.error;
    errors.push_back(n.error);
    estimates.push_back(n.estimate);
  }
  if (judged == 0) return;
  const auto share = [](int part, int of) { return 100.0 * part / of; };
  fmt::print("| {} | {} | {:.2g} | {:.2g} | {:.2g} | {:.2f} % | {:.1f} % |\n", name, all,
             percentile(errors, 0.5), percentile(errors, 0.99), percentile(estimates, 0.5),
             share(covered, all), share(sharp, judged));
}

constexpr const char* columns =
    "| | numbers | error, median | 99 % | estimate, median | error below it | it within 5 times |\n"
    "|---|---|---|---|---|---|---|\n";

void kinds_table(const std::vector<Judged>& numbers) {
  const PageTable page("estimates reduced");
  fmt::print("{}", columns);
  constexpr std::pair<ErrorKind, const char*> kinds[] = {{ErrorKind::load, "drive load"},
                                                         {ErrorKind::stiffness, "stiffness"},
                                                         {ErrorKind::motion, "motion"},
                                                         {ErrorKind::frequency, "frequencies"}};
  for (const auto& [kind, text] : kinds)
    row(text, numbers, [kind = kind](const Judged& n) { return n.kind == kind; });
  row("all of these", numbers, [](const Judged& n) { return n.kind != ErrorKind::stress; });
  row("stress", numbers, [](const Judged& n) { return n.kind == ErrorKind::stress; });
}

void families_table(const std::vector<Judged>& numbers) {
  const PageTable page("estimates families");
  fmt::print("{}", columns);
  std::vector<std::string> names;
  for (const Judged& n : numbers)
    if (std::ranges::find(names, n.family) == names.end()) names.push_back(n.family);
  for (const std::string& name : names)
    row("`" + name + "`", numbers,
        [&](const Judged& n) { return n.family == name && n.kind != ErrorKind::stress; });
}

/// What "auto" makes of a tolerance.
struct Chosen {
  double tolerance = 0;
  int designs = 0, met = 0, kept = 0, full = 0;  ///< kept: no number of them is off by more
  std::size_t numbers = 0, within = 0;
  std::map<std::array<int, 2>, int> meshes;
};

void choose(const Mechanism& mechanism, const StrokeRequest& request,
            const std::vector<Values>& truth, Chosen& of) {
  const ChosenModel chosen = choose_model(mechanism, {}, {request}, of.tolerance);
  ++of.designs;
  if (!chosen.met) return;
  ++of.met;
  ++of.meshes[chosen.model.mesh];
  of.full += chosen.model.accuracy == Accuracy::full;
  const StrokeResponse response = evaluate_stroke(mechanism, chosen.model, request);
  const StrokeErrors errors = errors_of(response, chosen.full.front());
  bool kept = true;
  each_with_truth(errors, truth, [&](const EstimatedError& number, double true_value, std::size_t) {
    if (number.kind == ErrorKind::stress) return;
    const bool within = std::abs(number.value - true_value) <= of.tolerance * number.scale;
    kept = kept && within;
    ++of.numbers;
    of.within += within;
  });
  of.kept += kept;
}

void chosen_table(const std::vector<Chosen>& all) {
  const PageTable page("estimates chosen");
  fmt::print(
      "| tolerance | designs | met | of these without a number beyond it | numbers within it | "
      "full "
      "leaves | meshes |\n|---|---|---|---|---|---|---|\n");
  for (const Chosen& c : all) {
    std::string meshes;
    for (const auto& [mesh, count] : c.meshes)
      meshes += fmt::format("{}{} × {}: {}", meshes.empty() ? "" : ", ", mesh[0], mesh[1], count);
    fmt::print("| {:g} % | {} | {} | {} | {:.2f} % | {} | {} |\n", 100 * c.tolerance, c.designs,
               c.met, c.kept,
               100.0 * static_cast<double>(c.within) /
                   static_cast<double>(std::max<std::size_t>(c.numbers, 1)),
               c.full, meshes);
  }
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  const int designs = argc > 1 ? std::atoi(argv[1]) : 8;
  std::vector<Judged> numbers;
  std::vector<Chosen> chosen{{.tolerance = 0.01}, {.tolerance = 0.003}};
  int failed = 0;
  for (int i = 0; i < designs; ++i)
    for (std::size_t f = 0; f < draws().size(); ++f) {
      Random random(static_cast<unsigned>(1000 * f + static_cast<std::size_t>(i) + 1));
      Drawn drawn = draws()[f](random);
      drawn.mass = random.even_in_logarithm(0.01, 1);
      const StrokeRequest request = request_of(drawn);
      try {
        const Mechanism mechanism = mechanism_of(drawn);
        const std::vector<Values> truth = truth_of(mechanism, request);
        const bool whole =
            !truth.empty() && judge(mechanism, request, truth, drawn.family, numbers);
        failed += !whole;
        if (whole && i < 2)  // they take long
          for (Chosen& of : chosen) choose(mechanism, request, truth, of);
      } catch (const SpecError&) {
        ++failed;  // sizes that make no mechanism
      }
      fmt::print(stderr, "\r{} designs", static_cast<std::size_t>(i) * draws().size() + f + 1);
    }
  fmt::print(stderr, ", {} without a whole path\n", failed);
  kinds_table(numbers);
  families_table(numbers);
  chosen_table(chosen);
}
