// A guide with its derivatives, and a few steps of an optimiser of one's own: the example of
// docs/library.md. Exit code 0 if the numbers are sound.
#include <flexopt.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace {

/// Minus the gradient in the unit box, as far as the constraints let.
bool improves(const flexopt::Problem& problem) {
  std::vector<double> x = problem.start();
  const flexopt::Goals first = problem.at(x, true);
  if (!first.ok) return false;
  for (std::size_t j = 0; j < x.size(); ++j) x[j] = std::clamp(x[j] - 1e-3 * first.df[j], 0.0, 1.0);
  const flexopt::Goals then = problem.at(x);
  std::printf("objective %g, a step later %g\n", first.f, then.f);
  return then.ok && then.f < first.f;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return 2;
  const auto guide = flexopt::Design::of_family("parallel_guide", {{"length", "100 mm"},
                                                                   {"width", "30 mm"},
                                                                   {"thickness", 0.5e-3},
                                                                   {"spacing", "100 mm"},
                                                                   {"material", "stavax"}});
  const auto job = flexopt::Job::of_design(guide, R"({
    "end_effector": {"mass": "1 kg", "inertia": ["9.08e-4 kg m^2", "8.33e-5 kg m^2", "8.42e-4 kg m^2"]},
    "stroke": {"from": 0, "to": "20 mm", "points": 3}, "frequencies": 3
  })");
  flexopt::Options options;
  options.gradients = {"thickness"};
  const flexopt::Path path = flexopt::evaluate(job, options).path();
  const auto load = path.values("drive_load");
  const auto by_thickness = path.gradient("drive_load");
  for (std::size_t k = 0; k < path.size(); ++k)
    std::printf("%g m: %g N, %g N/m, %g Hz\n", path.stroke()[k], load[k].value_or(0),
                by_thickness(k, 0), path.frequencies(k, flexopt::Drive::held).at(0));
  // A guide's load goes nearly with the third power of the thickness.
  const double power = by_thickness(2, 0) * 0.5e-3 / load[2].value();
  const bool sound = path.converged(2) && power > 2.5 && power < 3.5;
  return sound && improves(flexopt::Problem(flexopt::Job::of_file(argv[1]))) ? 0 : 1;
} catch (const flexopt::JobError& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
