// What a run says of its design, in one word and one sentence: terminal, result and page say the
// same.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "results/files/result_parts.hpp"

namespace flexopt {

namespace {

/// Stress beyond this share of what the material allows is more than the rounding of a bound.
constexpr double beyond = 1.0005;

struct Placed {
  const PathPoint* point = nullptr;
  std::string where;     ///< "at -1 mm"
  std::string unstable;  ///< unstable_text()
};

/// The points that converged, of all load cases, each with its place.
std::vector<Placed> converged_points(const RunRecord& record) {
  const DriveList drives = drives_of(record);
  const std::vector<JobCase> cases = cases_of(record.job);
  const auto responses = responses_of(record);
  std::vector<Placed> points;
  for (std::size_t k = 0; k < responses.size(); ++k)
    for (std::size_t i = 0; i < responses[k]->path.size(); ++i) {
      const PathPoint& point = responses[k]->path[i];
      if (point.status != PointStatus::converged) continue;
      const StrokeRequest& request = cases[k].request;
      std::string where = "at ";
      if (!request.loads.driven()) where += "load factor ";
      if (drives.named() && i < request.strokes.size()) {
        for (std::size_t d = 0; d < drives.items.size(); ++d)
          where +=
              fmt::format("{}{} {}", d > 0 ? ", " : "", drives.items[d].name,
                          quantity_text(request.strokes[i][static_cast<Eigen::Index>(d)],
                                        is_rotation(drives.items[d].direction) ? "rad" : "m", 3));
      } else {
        where += quantity_text(point.stroke, stroke_unit(drives, request), 3);
      }
      if (!cases[k].name.empty()) where += " of load case " + cases[k].name;
      points.push_back({&point, std::move(where), unstable_text(record.mechanism, request.loads)});
    }
  return points;
}

std::string instability(const std::vector<Placed>& points) {
  const auto unstable = [](const Placed& p) { return !p.point->stable; };
  const auto first = std::ranges::find_if(points, unstable);
  if (first == points.end()) return "";
  const auto count = std::ranges::count_if(points, unstable);
  return fmt::format(
      "{} {}{}.", first->unstable, first->where,
      count > 1 ? fmt::format(" and at {} more point{}", count - 1, count > 2 ? "s" : "") : "");
}

/// The sentence about the stress that is the largest share of what the material of its part allows;
/// `share` becomes that.
std::string stress_text(const std::vector<Placed>& points, double& share) {
  const auto share_of = [](const Placed& p) {
    return p.point->allowable_safety ? 1 / p.point->allowable_safety->value : 0;
  };
  const auto most = std::ranges::max_element(points, {}, share_of);
  if (most == points.end() || !most->point->allowable_safety) return "";
  share = share_of(*most);
  return fmt::format("the stress is {}{:.{}g} % of what the material allows, {}",
                     share > beyond ? "" : "at most ", 100 * share,
                     share > beyond && share < 1.01 ? 4 : 3, most->where);
}

}  // namespace

std::string unstable_text(const Mechanism& mechanism, const LoadCase& loads) {
  if (mechanism.drives.empty()) return "It is unstable";
  std::string names;
  for (std::size_t k = 0; k < mechanism.drives.size(); ++k)
    if (loads.held[k]) names += (names.empty() ? " " : ", ") + mechanism.drives[k].name;
  const bool several = names.empty() ? mechanism.drives.size() > 1 : loads.held.count() > 1;
  return fmt::format("With the drive{}{} {} it is unstable", several ? "s" : "", names,
                     !loads.driven()                ? "free"
                     : loads.stable_with_all_held() ? "held"
                                                    : "alone held");
}

std::string quantity_text(double value, const std::string& unit, int digits) {
  struct Shown {
    std::string_view si, unit;
    double factor, from;
  };
  static constexpr std::array shown{Shown{"m", " mm", 1e3, 0},
                                    Shown{"rad", " deg", 180 / std::numbers::pi, 0},
                                    Shown{"Pa", " MPa", 1e-6, 0}, Shown{"N/m", " N/um", 1e-6, 1e5}};
  const auto found = std::ranges::find_if(
      shown, [&](const Shown& s) { return s.si == unit && std::abs(value) >= s.from; });
  if (found != shown.end())
    return fmt::format("{:.{}g}{}", value * found->factor, digits, found->unit);
  return fmt::format("{:.{}g}{}{}", value, digits, unit.empty() || unit == "1" ? "" : " ",
                     unit == "1" ? "" : unit);
}

std::string extreme_name(const Constraint& goal, const DriveList& drives) {
  std::string name = goal.name();
  for (const Quantity& q : quantities(drives))
    if (q.name == goal.quantity) name = q.label;
  for (const std::string_view lead : {"largest ", "lowest "})
    if (name.starts_with(lead)) name.erase(0, lead.size());
  if (goal.of_design()) return name;
  switch (goal.over_stroke) {
    case OverStroke::min:
      return "lowest " + name + " over the stroke";
    case OverStroke::max:
      return "largest " + name + " over the stroke";
    case OverStroke::max_abs:
      return "largest size of the " + name + " over the stroke";
    case OverStroke::first:
      return name + " at the first point";
    case OverStroke::last:
      return name + " at the last point";
  }
  return name;
}

Verdict verdict_of(std::string status, const std::string& message) {
  if (status == "ok") return {"good", "done", message};
  std::ranges::replace(status, '_', ' ');
  return {"bad", status, message};
}

Verdict verdict_of(const RunRecord& record) {
  const Verdict plain = verdict_of(record.status, record.message);
  constexpr std::array believed{"ok", "tolerance_not_met", "estimate_beyond_limit"};
  if (record.comparison || std::ranges::find(believed, record.status) == believed.end())
    return plain;
  const std::vector<Placed> points = converged_points(record);
  const std::string unstable = instability(points);
  if (!unstable.empty())
    return {"bad", "unstable", unstable + (record.status == "ok" ? "" : " " + record.message)};
  if (record.status != "ok") return plain;
  double share = 0;
  const std::string stress = stress_text(points, share);
  Verdict verdict{"good", "works", ""};
  if (record.optimum) {
    const Optimum& optimum = *record.optimum;
    const Objective& goal = record.job.optimise->objective;
    const DriveList drives = drives_of(record);
    std::string name = extreme_name(goal, drives);
    name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
    const bool local = optimum.status == OptimumStatus::local;
    verdict = {local ? "warn" : "good", local ? "local optimum" : name_of(optimum.status),
               fmt::format("{}{}, {}: {}; all requirements are met.{}", name,
                           label_suffix(goal.margin, goal.worst_assembly),
                           goal.maximise ? "maximised" : "minimised",
                           quantity_text(optimum.objective, goal_unit(goal, drives), 4),
                           local ? " There may be a better one: try more starts." : "")};
  } else {
    verdict.text = fmt::format(
        "{} found equilibrium{}{}.",
        points.size() == 1 ? "The one point" : fmt::format("All {} points", points.size()),
        stress.empty() || share > beyond ? "" : "; ", share > beyond ? "" : stress);
  }
  if (share <= beyond) return verdict;
  return {"bad", "overstressed", fmt::format("{} But {}.", verdict.text, stress)};
}

}  // namespace flexopt
