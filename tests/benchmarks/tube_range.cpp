// Reduced leaves that are believed everywhere, against full ones, of sampled designs (no table).
//
// What the range test (R5) of core/reduction/README.md is calibrated on.
//   bench_tube_range [THREADS [believed] JOB.json…] > states.csv
// Without arguments one thread and compare_parallel_guide.json. Jobs are of kind compare.
//
// A row for each stroke point, of leaves as the program evaluates them ("degree" 0, "held" their
// highest degree, "tubes" whether none was replaced) and, where asked for, of leaves of degree 5
// and 7 that are believed everywhere: the test in the mechanism, and the errors.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <numbers>

#include "core/equilibrium/edge_compliance.hpp"
#include "core/reduction/tube/tube_leaf.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/path/stiffness.hpp"
#include "optim/compare/comparison.hpp"
#include "optim/numerics/parallel.hpp"
#include "support/one_stroke.hpp"

using namespace flexopt;

namespace {

/// Of the leaves of a state.
struct Changes {
  double held = 0, sum = 0;  ///< in the mechanism: the largest, and their sum
  /// Likewise: drives free, the leaf's own forces, drive loads; the largest.
  double free = 0, own = 0, load = 0;
  bool tubes = true;  ///< every leaf is one
  /// Forces off those about which a leaf was expanded, the largest: axial over the buckling load
  /// between held edges, and the moment with such stress at a side.
  double axial = 0, moment = 0;
};

Changes changes_of(System& system) {
  Changes c;
  EdgeCompliance compliance(system);
  for (int i = 0; i < system.leaves(); ++i) {
    const auto* tube = dynamic_cast<const TubeLeaf*>(&system.leaf(i));
    if (!tube) {
      c.tubes = false;
      continue;
    }
    const auto about = compliance.of(i);
    TubeLeaf::DegreeChanges changes{INFINITY, INFINITY, INFINITY, INFINITY};
    if (about) changes = tube->changes_in(*about);
    const double held = changes.held;
    c.free = std::max(c.free, changes.free);
    c.own = std::max(c.own, changes.own);
    c.load = std::max(c.load, changes.load);
    const double buckling = 4 * std::numbers::pi * std::numbers::pi;
    const Vector3d off = (tube->forces() - tube->model()->range().centre()) / buckling;
    c.axial = std::max(c.axial, std::abs(off[0]));
    c.moment = std::max({c.moment, 6 * std::abs(off[1]), 6 * std::abs(off[2])});
    c.held = std::max(c.held, held);
    c.sum += held;
  }
  return c;
}

/// Solves; tubes grow, but are not replaced.
bool solve(System& system, const std::function<Equilibrium()>& step, Equilibrium& equilibrium) {
  for (int round = 0; round < 8; ++round) {
    equilibrium = step();
    if (!equilibrium.converged) return false;
    bool grown = false;
    for (int i = 0; i < system.leaves(); ++i) {
      auto* tube = dynamic_cast<TubeLeaf*>(&system.leaf(i));
      if (!tube || tube->location().beyond <= 1e-9 * std::abs(tube->location().sigma)) continue;
      auto refinement = tube->refine([] { return std::nullopt; });
      if (refinement.replacement) return false;
      grown = true;
    }
    if (!grown) return true;
    system.invalidate();
  }
  return false;
}

/// Largest relative error of a support stiffness, and of which.
std::pair<double, int> support_error(const std::array<std::optional<double>, 6>& found,
                                     const std::array<std::optional<double>, 6>& exact) {
  std::pair<double, int> worst{0, -1};
  for (int d = 0; d < 6; ++d)
    if (found[d] && exact[d]) worst = std::max(worst, {std::abs(*found[d] / *exact[d] - 1), d});
  return worst;
}

std::string row(const Job& job, int design, std::size_t point, int degree, const LeafSpring& leaf,
                bool stable, bool found, const Changes& c, std::pair<double, int> support,
                double drive) {
  return fmt::format(
      "\"{}\",{},{},{},{:.4g},{:.4g},{},{},{},{:.4g},{:.4g},{:.4g},{},{:.4g},"
      "{:.4g},{:.4g},{:.4g},{:.4g},{:.4g}\n",
      job.name, design, point, degree, leaf.width / leaf.length, leaf.thickness / leaf.length,
      stable ? 1 : 0, found ? 1 : 0, c.tubes ? 1 : 0, c.held, c.sum, support.first, support.second,
      drive, c.axial, c.moment, c.free, c.own, c.load);
}

/// Paths of leaves that are believed everywhere.
std::string believed(const Job& job, int design, const Mechanism& mechanism,
                     const StrokeRequest& request, const StrokeResponse& full, double drive) {
  std::string text;
  double largest = 0;
  for (const double s : request.points) largest = std::max(largest, std::abs(s));
  for (const int degree : {5, 7}) {
    ModelOptions model = job.model;
    model.degree = degree;
    System system(mechanism, make_reduced_leaves(mechanism, model, largest, request.loads),
                  request.loads);
    Equilibrium at;
    bool ok = !system.loaded_at_rest() ||
              solve(
                  system, [&] { return step_load(system, {.constant = 1}, request.newton); }, at);
    for (std::size_t k = 0; k < request.points.size(); ++k) {
      const PathPoint& p = full.path[k];
      if (p.status != PointStatus::converged) break;
      ok =
          ok && solve(
                    system, [&] { return step_to(system, request.points[k], request.newton); }, at);
      Changes c;
      std::pair<double, int> support{INFINITY, -1};
      double load = INFINITY;
      if (ok) {
        c = changes_of(system);
        const EndEffectorCompliance e = end_effector_compliance(system);
        std::array<std::optional<double>, 6> stiffness;
        for (int d = 0; d < 6; ++d)
          if (!e.still[d]) stiffness[d] = 1 / e.drive_locked(d, d);
        support = support_error(stiffness, p.support_stiffness);
        load = std::abs(at.drive_load - p.drive_load) / drive;
      }
      text += row(job, design, k, degree, mechanism.leaves.front(), p.stable, ok, c, support, load);
    }
  }
  return text;
}

std::string rows(const Job& job, const Sample& sample, int design, bool all) {
  const Mechanism mechanism = make_mechanism(job, sample);
  StrokeRequest request = job.request;
  request.points = sample.stroke;
  request.outputs = {Output::equilibrium, Output::stiffness};
  ModelOptions model = job.model;
  model.accuracy = Accuracy::full;
  const StrokeResponse full = evaluate_stroke(mechanism, model, request);
  double drive = 0;
  for (const PathPoint& p : full.path) drive = std::max(drive, std::abs(p.drive_load));
  std::string text;
  if (all) text = believed(job, design, mechanism, request, full, drive);
  const StrokeResponse reduced = evaluate_stroke(mechanism, job.model, request);
  for (std::size_t k = 0; k < request.points.size(); ++k) {
    const PathPoint &p = full.path[k], &r = reduced.path[k];
    if (p.status != PointStatus::converged) break;
    const bool ok = r.status == PointStatus::converged;
    Changes c;
    int degree = 5;
    for (const LeafReport& leaf : r.leaves) {
      c.tubes = c.tubes && !leaf.replaced;
      degree = std::max(degree, leaf.degree);
    }
    c.held = degree;
    text += row(job, design, k, 0, mechanism.leaves.front(), p.stable, ok, c,
                ok ? support_error(r.support_stiffness, p.support_stiffness)
                   : std::pair{static_cast<double>(INFINITY), -1},
                ok ? std::abs(r.drive_load - p.drive_load) / drive : INFINITY);
    for (const LeafReport& leaf : r.leaves)
      if (leaf.replaced) fmt::print(stderr, "{} {} {}: {}\n", job.name, design, k, leaf.reason);
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  const int threads = argc > 1 ? std::atoi(argv[1]) : 1;
  std::vector<std::string> jobs(argv + std::min(argc, 2), argv + argc);
  const bool all = !jobs.empty() && jobs.front() == "believed";
  if (all) jobs.erase(jobs.begin());
  if (jobs.empty())
    jobs.emplace_back(FLEXOPT_SOURCE_DIR "/designs/jobs/compare_parallel_guide.json");
  fmt::print(
      "job,design,point,degree,w/L,t/"
      "L,stable,found,tubes,held,sum,support,direction,drive,axial,moment,free,own,load\n");
  for (const std::string& path : jobs) {
    const Job job = read_job(path);
    const std::vector<Sample> samples = make_samples(job);
    std::mutex mutex;
    parallel_for(static_cast<int>(samples.size()), threads, [&](int i) {
      const Sample& sample = samples[static_cast<std::size_t>(i)];
      if (!sample.refused.empty()) {
        fmt::print(stderr, "{} {}: {}\n", job.name, i, sample.refused);
        return;
      }
      const std::string text = rows(job, sample, i, all);
      const std::lock_guard lock(mutex);
      fmt::print("{}", text);
    });
  }
}
