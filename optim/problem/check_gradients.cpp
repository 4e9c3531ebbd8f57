#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/spec/spec_error.hpp"
#include "optim/problem/gradient_checker.hpp"
#include "optim/solvers/parallel.hpp"

namespace flexopt {
namespace {

GradientReport check_case(const Job& job, std::size_t load_case, double tolerance, int threads) {
  GradientReport report;
  GradientChecker checker(job, load_case, tolerance);
  if (Check prepared = checker.prepare(); !prepared) {
    report.message = std::move(prepared.error());
    return report;
  }
  const std::size_t parameters = checker.parameters().size();
  std::vector<std::vector<GradientCheck>> checks(parameters);
  std::vector<std::string> failed(parameters);
  parallel_for(parameters, threads, [&](int p) {
    try {
      checks[p] = checker.check(p);
    } catch (const SpecError& error) {
      failed[p] = fmt::format("{}: no differences: {}", checker.parameters()[p], error.what());
    }
  });
  int wrong = 0;
  double worst = 0;
  std::vector<std::string> kinks;
  for (const std::vector<GradientCheck>& of : checks)
    for (const GradientCheck& c : of) {
      if (c.quantity.empty()) continue;
      report.checks.push_back(c);
      wrong += !c.agrees;
      if (!c.equal_stiffnesses)
        worst = std::max(worst, c.error);
      else
        kinks.push_back(fmt::format("along {} at point {}", c.parameter, c.point));
    }
  std::erase(failed, "");
  report.ok = wrong == 0 && failed.empty() && !report.checks.empty();
  report.message = fmt::format("{} of {} derivatives agree, largest difference {:.1e}",
                               report.checks.size() - static_cast<std::size_t>(wrong),
                               report.checks.size(), worst);
  if (const auto names = checker.without_exact(); !names.empty())
    report.message += fmt::format("; no exact derivatives: {}", fmt::join(names, ", "));
  if (!kinks.empty())
    report.message += fmt::format(
        "; principal_stiffness has a derivative on either side alone, two directions are "
        "equally stiff: {}",
        fmt::join(kinks, ", "));
  for (const std::string& f : failed) report.message += "; " + f;
  return report;
}

}  // namespace

GradientReport check_gradients(const Job& job, double tolerance, int threads) {
  if (job.cases.empty()) return check_case(job, 0, tolerance, threads);
  GradientReport all;
  all.ok = true;
  for (std::size_t k = 0; k < job.cases.size(); ++k) {
    const GradientReport report = check_case(job, k, tolerance, threads);
    const std::string& name = job.cases[k].name;
    all.ok = all.ok && report.ok;
    all.message += fmt::format("{}load case {}: {}", k == 0 ? "" : "; ", name, report.message);
    for (GradientCheck check : report.checks) {
      check.load_case = name;
      all.checks.push_back(std::move(check));
    }
  }
  return all;
}

}  // namespace flexopt
