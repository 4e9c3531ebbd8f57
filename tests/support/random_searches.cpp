#include "support/random_searches.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "optim/search/search.hpp"
#include "optim/solvers/unit_points.hpp"
#include "support/guide.hpp"
#include "support/random_design.hpp"

namespace flexopt {
namespace {

using nlohmann::json;

class Draw : public RandomNumbers {
 public:
  explicit Draw(unsigned seed) : RandomNumbers(seed * 7919ULL + 12345ULL) {}
  double even_in_log(double a, double b) { return std::exp(between(std::log(a), std::log(b))); }
  int below(int n) { return std::min(n - 1, static_cast<int>(between(0, n))); }
};

struct Size {
  const char* name;
  double least, most;
};
constexpr Size sizes[] = {{"length", 0.02, 0.2},
                          {"thickness", 0.05e-3, 3e-3},
                          {"width", 0.005, 0.08},
                          {"material.youngs_modulus", 70e9, 210e9}};

struct Guide {
  double length = 0, thickness = 0, width = 0, modulus = 0;
  double stress(double x) const { return 3 * modulus * thickness * x / (length * length); }
  double load(double x) const { return 2 * modulus * width * std::pow(thickness / length, 3) * x; }
};

Guide guide_of(const std::vector<double>& of) { return {of[0], of[1], of[2], of[3]}; }

}  // namespace

RandomSearch random_search(unsigned seed, const std::string& algorithm) {
  Draw draw(seed);
  RandomSearch search;
  std::vector<double> fixed, low, high;
  for (const Size& size : sizes) {
    const double least = draw.even_in_log(size.least, size.most / 2),
                 most = std::min(size.most, least * draw.even_in_log(2, 50));
    low.push_back(least);
    high.push_back(most);
    fixed.push_back(draw.between(least, most));
  }
  std::vector<std::size_t> which{0, 1, 2, 3};
  for (std::size_t i = 0; i < 3; ++i)
    std::swap(which[i], which[i + static_cast<std::size_t>(draw.below(4 - static_cast<int>(i)))]);
  which.resize(static_cast<std::size_t>(2 + draw.below(3)));
  const double stroke = draw.even_in_log(0.5e-3, 10e-3);

  json job = guide::stiff_guide();
  job["name"] = fmt::format("random search {}", seed);
  job["stroke"]["to"] = stroke;
  json& design = job["design"];
  design["parameters"] = {
      {"length", fixed[0]}, {"thickness", fixed[1]}, {"width", fixed[2]}, {"spacing", 0.06}};
  design["material"]["youngs_modulus"] = fixed[3];
  json variables = json::array();
  std::sort(which.begin(), which.end());
  std::vector<double> keeps = fixed;  // a design that keeps all constraints
  for (const std::size_t k : which) {
    variables.push_back({{"parameter", sizes[k].name}, {"min", low[k]}, {"max", high[k]}});
    keeps[k] = draw.between(low[k], high[k]);
  }
  job["optimise"]["variables"] = variables;
  const Guide kept = guide_of(keeps);

  const double factor = draw.even_in_log(1e-9, 1e9);
  const std::string formulas[] = {"length*width*thickness",
                                  "length^2*width*thickness*(1 + 0.01/width)",
                                  "material.youngs_modulus*width*(thickness/length)^3",
                                  "width/thickness + length/thickness/10 + thickness/length*2e4"};
  json objective;
  switch (draw.below(6)) {
    case 0:
      objective = {{"minimise", "drive_load"}};
      break;
    case 1:
      objective = {{"maximise", "support_stiffness.ux"}};
      break;
    case 2:
      objective = {{"minimise", "max_stress"}};
      break;
    default: {
      const double at = draw.below(4);
      objective = {
          {"minimise", fmt::format("{:.6e}*({})", factor, formulas[static_cast<std::size_t>(at)])}};
    }
  }
  if (objective.contains("minimise") &&
      (objective["minimise"] == "drive_load" || objective["minimise"] == "max_stress"))
    objective["over_stroke"] = "max_abs";
  job["optimise"]["objective"] = objective;

  json constraints = json::array();
  const auto slack = [&] { return draw.between(1.0, 1.5); };
  const double stiffness =
      guide::support(kept.modulus, kept.width, kept.thickness, kept.length, stroke);
  const int count = draw.below(4);
  std::vector<int> kinds{0, 1, 2, 3, 4};
  for (int i = 0; i < count; ++i) {
    const int at = draw.below(static_cast<int>(kinds.size()));
    const int kind = kinds[static_cast<std::size_t>(at)];
    kinds.erase(kinds.begin() + at);
    switch (kind) {
      case 0:
        constraints.push_back({{"quantity", "max_stress"}, {"max", slack() * kept.stress(stroke)}});
        break;
      case 1:
        constraints.push_back({{"quantity", "drive_load"},
                               {"over_stroke", "max_abs"},
                               {"max", slack() * kept.load(stroke)}});
        break;
      case 2:
        constraints.push_back({{"quantity", "support_stiffness.ux"}, {"min", stiffness / slack()}});
        break;
      case 3:
        constraints.push_back({{"expression", "length + 40*thickness"},
                               {"max", slack() * (kept.length + 40 * kept.thickness)}});
        break;
      default:
        constraints.push_back({{"expression", "length*width*thickness"},
                               {"min", kept.length * kept.width * kept.thickness / slack()}});
    }
  }
  job["optimise"]["constraints"] = constraints;
  guide::set_algorithm(job, algorithm);
  job["optimise"]["starts"] = 1 + draw.below(3);
  job["optimise"]["seed"] = 1 + draw.below(1000);
  job["optimise"]["max_evaluations"] = algorithm.starts_with("LN") ? 2000 : 300;
  search.job = std::move(job);
  search.breaks_at = draw.below(2) ? 1e99 : kept.stress(stroke) * draw.even_in_log(1.05, 10);
  return search;
}

Evaluators closed_forms(double breaks_at) {
  static guide::Calls calls;
  return {guide::evaluator(calls, breaks_at), guide::gradient_evaluator(calls, breaks_at)};
}

std::optional<double> dense_search(const RandomSearch& of, int points, int searches) {
  json document = of.job;
  guide::set_algorithm(document, "LD_SLSQP");
  const Job job = parse_job(document);
  const DesignProblem problem(job, closed_forms(of.breaks_at));
  const Pose pose = job_pose(problem);
  const Scales scales = problem.scales(nullptr);
  std::vector<Candidate> seen;
  for (const VectorXd& x : sobol_points(problem.size(), points, 1)) {
    const DesignValues values = problem.evaluate(problem.variables(x));
    if (values.ok) seen.push_back(weigh(problem, scales, pose, x, values));
  }
  const double within = job.optimise->constraint_tolerance;
  const auto is_better = [&](const Candidate& a, const Candidate& b) {
    return better({a.objective, a.violation}, {b.objective, b.violation}, pose.maximise, within);
  };
  const auto most = std::min<std::size_t>(seen.size(), static_cast<std::size_t>(searches));
  std::partial_sort(seen.begin(), seen.begin() + static_cast<std::ptrdiff_t>(most), seen.end(),
                    is_better);
  EvaluationLog log(job);
  ProgressBoard board({}, 1, pose.maximise, within);
  std::optional<double> best;
  const auto take = [&](const Candidate& c) {
    if (c.violation > within) return;
    if (!best || (pose.maximise ? c.objective > *best : c.objective < *best)) best = c.objective;
  };
  for (std::size_t k = 0; k < most; ++k) {
    take(seen[k]);
    EvaluationBook book(problem, log, board, Stage::search, 0, true);
    book.set_scales(scales);
    const SearchResult end = search(book, pose, seen[k].x, 300);
    if (end.best) take(*end.best);
  }
  return best;
}

double shortfall(const RandomSearch& search, double objective, double best) {
  const bool maximise = search.job["optimise"]["objective"].contains("maximise");
  return (maximise ? best - objective : objective - best) / std::abs(best);
}

}  // namespace flexopt
