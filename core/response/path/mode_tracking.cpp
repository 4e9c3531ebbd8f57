#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

#include "core/response/path/frequency_derivatives.hpp"
#include "core/response/path/stroke_ways.hpp"

namespace flexopt {
namespace {

// Modal assurance criterion below which two motions are unrelated.
constexpr double least_likeness = 0.3;

// cos² of the angle between two motions.
double likeness(const VectorXd& a, const VectorXd& b) {
  const Eigen::Index rows = std::min(a.size(), b.size());  // the bodies, where stations differ
  const double size = a.head(rows).squaredNorm() * b.head(rows).squaredNorm();
  if (size <= 0) return 0;
  const double product = a.head(rows).dot(b.head(rows));
  return product * product / size;
}

}  // namespace

std::vector<int> match_modes(const std::vector<const VectorXd*>& motions,
                             const std::vector<Mode>& candidates) {
  struct Pair {
    double likeness;
    int motion, candidate;
  };
  std::vector<Pair> pairs;
  for (int i = 0; i < static_cast<int>(motions.size()); ++i)
    for (int j = 0; motions[i] && j < static_cast<int>(candidates.size()); ++j)
      if (const double c = likeness(*motions[i], candidates[j].motion); c > least_likeness)
        pairs.push_back({c, i, j});
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.likeness > b.likeness; });
  std::vector<int> found(motions.size(), -1);
  std::vector<bool> used(candidates.size(), false);
  for (const Pair& p : pairs)
    if (found[p.motion] < 0 && !used[p.candidate]) {
      found[p.motion] = p.candidate;
      used[p.candidate] = true;
    }
  return found;
}

namespace {

void shorten(std::optional<double>& valid_to, double stroke) {
  valid_to = std::min(valid_to.value_or(stroke), stroke);
}

// A point of the path along the stroke of one drive, the others at zero, or along a way of them.
struct PointAlong {
  const PathPoint* point;
  double stroke;
};

// How far one drive is at a point; nothing where another one has left zero too.
std::optional<double> stroke_along(const PathPoint& point, int drive) {
  if (point.strokes.size() < 2) return point.stroke;
  for (std::size_t k = 0; k < point.strokes.size(); ++k)
    if (static_cast<int>(k) != drive && point.strokes[k] != 0) return std::nullopt;
  return point.strokes[drive];
}

// Follows the modes of one drive through `points`, sorted outward.
void follow(std::span<FrequencyDerivatives> modes, const std::vector<PointAlong>& points) {
  struct Trail {
    const VectorXd* motion;
    double last = 0;  ///< stroke of the last point met
    bool omega2 = true, compliance = true;
  };
  std::vector<Trail> trails;
  for (const FrequencyDerivatives& d : modes) trails.push_back({&d.mode.motion});
  for (const auto& [point, s] : points) {
    if (s == 0) continue;  // there the modes are those of the derivatives
    std::vector<const VectorXd*> motions;
    for (const Trail& t : trails) motions.push_back(t.motion);
    const std::vector<int> found = match_modes(motions, point->modes_free);
    for (std::size_t i = 0; i < modes.size(); ++i) {
      Trail& trail = trails[i];
      if (found[i] < 0) {
        trail.motion = nullptr;
        continue;
      }
      const FrequencyDerivatives& d = modes[i];
      const Mode& mode = point->modes_free[found[i]];
      const double w = 2 * std::numbers::pi * mode.frequency, omega2 = w * std::abs(w);
      const double exponent = d.d_omega2 == 0 ? 4 : 3;
      const auto check = [&, s = s](bool& valid, std::optional<double>& to, double error) {
        if (!valid || !(error > parabola_tolerance)) return;
        valid = false;
        const double reach = std::abs(s) * std::pow(parabola_tolerance / error, 1 / exponent);
        shorten(to, std::max(trail.last, reach));
      };
      const double parabola = d.omega2 + s * (d.d_omega2 + 0.5 * s * d.d2_omega2);
      const double compliance = d.compliance + s * (d.d_compliance + 0.5 * s * d.d2_compliance);
      check(trail.omega2, modes[i].omega2_valid_to, std::abs(parabola / omega2 - 1));
      check(trail.compliance, modes[i].compliance_valid_to, std::abs(compliance * omega2 - 1));
      trail.motion = &mode.motion;
      trail.last = std::abs(s);
    }
  }
}

}  // namespace

namespace {

// Sets valid_to by the points of the path that lie on the way, and their places on it.
template <class PlaceOf>
void set_validity(std::span<FrequencyDerivatives> modes, const std::vector<PathPoint>& path,
                  const PlaceOf& place_of) {
  for (const double side : {1.0, -1.0}) {
    std::vector<PointAlong> points;
    for (const PathPoint& p : path)
      if (const auto place = place_of(p);
          p.status == PointStatus::converged && place && side * *place > 0)
        points.push_back({&p, *place});
    std::ranges::stable_sort(points, {}, [](const PointAlong& p) { return std::abs(p.stroke); });
    follow(modes, points);
  }
}

}  // namespace

void set_validity(FrequencyWay& way, const std::vector<PathPoint>& path) {
  set_validity(way.modes, path,
               [&](const PathPoint& point) { return part_of_way(way.strokes, point.strokes); });
}

void set_validity(std::vector<FrequencyDerivatives>& modes, const std::vector<PathPoint>& path) {
  for (auto first = modes.begin(); first != modes.end();) {  // drive by drive
    const int drive = first->drive;
    const auto last = std::find_if(first, modes.end(),
                                   [&](const FrequencyDerivatives& d) { return d.drive != drive; });
    set_validity(std::span(first, last), path,
                 [&](const PathPoint& point) { return stroke_along(point, drive); });
    first = last;
  }
}

std::optional<double> screening_frequency(const FrequencyDerivatives& d, double stroke) {
  const double c = d.compliance + stroke * (d.d_compliance + 0.5 * stroke * d.d2_compliance);
  if (!(c > 0)) return std::nullopt;  // stiffens beyond what the parabola can tell: not the lowest
  return 1 / (2 * std::numbers::pi * std::sqrt(c));
}

std::vector<ScreeningFrequency> screening_frequencies(
    const std::vector<FrequencyDerivatives>& modes, const ParasiticRule& rule, double stroke) {
  std::vector<ScreeningFrequency> found;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    if (!rule.admits(modes[k].mode.kind)) continue;
    if (const auto value = screening_frequency(modes[k], stroke)) found.push_back({k, *value});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.value < b.value; });
  return found;
}

VectorXd screening_gradient(const FrequencyDerivatives& d, const FrequencyDerivativeGradients& g,
                            double stroke) {
  const double w2 = d.omega2, w4 = w2 * w2,
               c = d.compliance + stroke * (d.d_compliance + 0.5 * stroke * d.d2_compliance);
  const VectorXd dc = -g.omega2 / w4, dc1 = -g.d_omega2 / w4 - (2 * d.d_compliance / w2) * g.omega2,
                 dc2 = (4 * d.d_omega2 / w2 * g.d_omega2 -
                        2 * d.d_omega2 * d.d_omega2 / w4 * g.omega2 - g.d2_omega2) /
                           w4 -
                       (2 * d.d2_compliance / w2) * g.omega2;
  return -(dc + stroke * (dc1 + 0.5 * stroke * dc2)) / (4 * std::numbers::pi * c * std::sqrt(c));
}

}  // namespace flexopt
