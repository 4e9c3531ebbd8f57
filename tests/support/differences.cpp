#include "support/differences.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/math/rotation.hpp"
#include "support/changed_jobs.hpp"
#include "support/difference_laws.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

using End = Difference::End;

// A derivative is the limit of differences: where one with a wide step is off, because the numbers
// curve or change their branch within it, narrower ones decide.
constexpr double narrowest = 0.01;
constexpr std::array<double, 3> step_shares{1, 0.1, narrowest};

}  // namespace

Differences Looker::look() {
  Run base = run(job_);
  found_.status = base.record.status;
  found_.message = base.record.message;
  found_.seconds = base.seconds;
  found_.points = static_cast<int>(base.path().size());
  found_.leaves = static_cast<int>(base.record.mechanism.leaves.size());
  if (base.path().empty()) return std::move(found_);
  for (const LeafReport& leaf : base.path().back().leaves)
    found_.full_leaves += leaf.model == "full";
  if (!base.ok()) return std::move(found_);
  bool full = true;
  for (const PathPoint& p : base.path())
    for (const LeafReport& leaf : p.leaves) full = full && leaf.model == "full" && !leaf.replaced;
  same_leaves_ = full ? of_rounding : of_expansion;
  length_ = length_of(base.record.mechanism);
  for (const PathPoint& p : base.path())
    for (std::size_t k = 0; k < p.drive_stiffnesses.size(); ++k) {
      largest_stiffness_.resize(p.drive_stiffnesses.size());
      largest_stiffness_[k] = std::max(largest_stiffness_[k], std::abs(p.drive_stiffnesses[k]));
    }
  const bool all = laws_ == Laws::all;
  few_ = !all;
  const json full_job = with_accuracy(job_, "full");
  Run whole = run(full_job);
  law("full accuracy", [&](Difference& d) {
    d.other = full_job;
    answer(base, whole, {}, of_reduction, d);
  });
  interlacing(base);
  alone(base);
  if (all) more_points(base);
  if (!whole.ok()) return std::move(found_);
  stiffness_by_stroke("stiffness, stroke", job_, 3e-3);
  load_in_steps(whole);
  if (all) stiffness_by_stroke("stiffness, stroke, full", full_job, 1e-4);
  compliance_by_load(full_job);
  closed_way(full_job, whole);
  moved(full_job, whole, all);
  springs_for_held(full_job, whole);
  spring_for_drive(full_job, whole);
  cut(full_job, whole);
  warm(full_job);
  heavy(full_job);
  state_space(full_job);
  beam_and_plate(whole);
  // loads before the stroke lead to the unstable state where errors of assembly buckle a leaf
  const bool put_on = all && !job_.contains("assembly");
  if (put_on && random_.chance(0.2)) capacity(full_job, whole);
  if (put_on && random_.chance(0.3)) buckling(full_job, whole);
  return std::move(found_);
}

void Looker::law(const std::string& name, const std::function<void(Difference&)>& look) {
  const std::size_t number = number_++;
  if (few_ && number > 0 && (number + seed_) % 3 != 0) return;
  look_at(name, number, look);
}

void Looker::look_at(const std::string& name, std::size_t number,
                     const std::function<void(Difference&)>& look) {
  random_ = RandomNumbers(64 * seed_ + number);
  Difference d;
  d.law = name;
  try {
    look(d);
  } catch (const std::exception& error) {
    d.end = End::broken;
    d.error = 1e300;
    d.what = std::string("exception: ") + error.what();
  }
  found_.laws.push_back(std::move(d));
}

bool Looker::answered(const Run& one, Difference& d) {
  if (one.ok()) return true;
  d.end = End::no_answer;
  d.message = one.record.status + ": " + one.record.message;
  return false;
}

void Looker::answer(const Run& one, const Run& other, const Twin& twin, const LawTolerance& allowed,
                    Difference& d) {
  if (answered(one, d) && answered(other, d)) compare(one, other, twin, allowed, d);
}

void Looker::answer_again(const Run& base, const Twin& twin, Difference& d) const {
  const Run other = run(d.other);
  bool others = false;
  for (std::size_t k = 0; k < twin.points.size(); ++k)
    if (base.ok() && other.ok() && twin.points[k] < other.path().size())
      others = others || other_models(base.path()[k], other.path()[twin.points[k]]);
  answer(base, other, twin, others ? of_reduction : same_leaves_, d);
}

void Looker::number(double one, double other, double scale, double allowed, const std::string& name,
                    Difference& d) {
  const double error = std::abs(one - other) / std::max(scale, 1e-300) / allowed;
  if (d.end == End::skipped) d.end = End::kept;
  if (std::isfinite(error) && error <= d.error) return;
  d.error = std::isfinite(error) ? error : 1e300;
  d.what = fmt::format("{}: {:.7g} and {:.7g} ({:.2g} of {:.3g})", name, one, other,
                       std::abs(one - other) / std::max(scale, 1e-300), scale);
  d.end = d.error <= 1 ? End::kept : End::broken;
}

void Looker::interlacing(const Run& base) {
  look_at("drives raise frequencies", 0, [&](Difference& d) {
    for (const PathPoint& p : base.path()) {
      if (!believed(p)) continue;
      const std::vector<double>&free = p.frequencies_free, &held = p.frequencies_locked;
      const std::size_t drives = p.drive_loads.size();
      const auto at_most = [&](double below, double above, std::size_t k) {
        const double size = std::max(std::abs(below), std::abs(above));
        number(std::max(0.0, below - above), 0, size, 1e-4,
               fmt::format("frequency {}: {:.6g} above {:.6g}", k, below, above), d);
      };
      for (std::size_t k = 0; k < std::min(free.size(), held.size()); ++k)
        at_most(free[k], held[k], k);
      for (std::size_t k = 0; k + drives < free.size() && k < held.size(); ++k)
        at_most(held[k], free[k + drives], k);
    }
  });
}

void Looker::alone(const Run& base) {
  const std::size_t count = points().size();
  law("alone", [&](Difference& d) {
    d.other = with_stroke(job_, json::array({points().back()}));
    Twin twin;
    twin.points.assign(count, count);
    twin.points.back() = 0;
    answer_again(base, twin, d);
  });
  law("other order", [&](Difference& d) {
    json reversed = points();
    std::ranges::reverse(reversed);
    d.other = with_stroke(job_, reversed);
    Twin twin;
    for (std::size_t k = 0; k < count; ++k) twin.points.push_back(count - 1 - k);
    answer_again(base, twin, d);
  });
}

void Looker::more_points(const Run& base) {
  law("more points", [&](Difference& d) {
    json at = json::array();
    Twin twin;
    for (std::size_t k = 0; k < points().size(); ++k) {
      const std::vector<double> to = strokes_of(job_, points()[k]),
                                from = k == 0 ? to : strokes_of(job_, points()[k - 1]);
      for (const double share : {1 / 3.0, 2 / 3.0, 1.0}) {
        std::vector<double> strokes = to;
        for (std::size_t i = 0; i < to.size(); ++i)
          strokes[i] = share == 1 ? to[i] : from[i] + share * (to[i] - from[i]);
        at.push_back(stroke_point(job_, strokes));
      }
      twin.points.push_back(at.size() - 1);
    }
    d.other = with_stroke(job_, at);
    answer_again(base, twin, d);
  });
}

void Looker::load_in_steps(const Run& whole) {
  law("load in steps", [&](Difference& d) {
    const double modulus = job_["design"]["material"]["youngs_modulus"];
    const Vector3d way = random_.direction();
    const double most =
                     modulus * 5e-4 * length_ * length_ * std::pow(10, random_.between(-5, -2.5)),
                 soft = (whole.path()[0].compliance_free.topLeftCorner<3, 3>() * way).norm();
    const Vector3d force = std::min(most, 0.1 * length_ / std::max(soft, 1e-300)) * way;
    json job = job_;
    job.erase("stroke");
    job["design"]["mechanism"].erase("drive");
    job["design"]["mechanism"].erase("drives");
    const auto by = [&](int count) {
      job["load_path"] = {{"force", json::array({force[0], force[1], force[2]})},
                          {"points", count}};
      return run(job);
    };
    const Run one = by(2), other = by(8);
    d.other = job;
    Twin twin;
    twin.points = {0, 7};
    const bool others = one.ok() && other.ok() && other_models(one.path()[1], other.path()[7]);
    answer(one, other, twin, others ? of_reduction : same_leaves_, d);
  });
}

void Looker::stiffness_by_stroke(const std::string& name, const json& job, double allowed) {
  law(name, [&](Difference& d) {
    const Difference empty = d;
    for (const double share : step_shares) {
      d = empty;
      compare_stiffness(job, share, allowed, d);
      if (d.end != End::broken) return;
    }
  });
}

bool Looker::other_models(const PathPoint& a, const PathPoint& b) {
  return !std::ranges::equal(a.leaves, b.leaves, [](const LeafReport& x, const LeafReport& y) {
    return x.model == y.model && x.degree == y.degree && x.reason == y.reason;
  });
}

void Looker::compare_stiffness(json job, double share, double allowed, Difference& d) {
  if (job.contains("loads"))  // dead moments have no potential
    for (json& load : job["loads"]) load.erase("moment");
  const std::vector<double> last = strokes_of(job, points().back());
  json at = json::array({points().back()});
  std::vector<double> steps;
  const json drives = drives_of(job);
  for (std::size_t k = 0; k < last.size(); ++k) {
    const bool turns = drives[k]["direction"].get<std::string>()[0] == 'r';
    steps.push_back(share * std::max(5e-3 * std::abs(last[k]), 1e-5 * (turns ? 1 : length_)));
    for (const double sign : {-1.0, 1.0}) {
      std::vector<double> strokes = last;
      strokes[k] += sign * steps.back();
      at.push_back(stroke_point(job, strokes));
    }
  }
  d.other = with_stroke(job, at);
  const Run near = run(d.other);
  if (!answered(near, d)) return;
  const auto& path = near.path();
  for (const PathPoint& p : path)
    if (!believed(p)) {
      d.end = End::no_answer;
      d.message = "unstable";
      return;
    }
  for (std::size_t k = 0; k < last.size(); ++k) {
    const PathPoint &below = path[1 + 2 * k], &above = path[2 + 2 * k];
    if (other_models(path[0], below) || other_models(path[0], above)) continue;
    const double slope = (above.drive_loads[k] - below.drive_loads[k]) / (2 * steps[k]),
                 told = path[0].drive_stiffnesses[k],
                 known = 1e-8 * largest_load(near.record.job, length_) *
                         (is_rotation(near.record.mechanism.drives[k].direction) ? length_ : 1);
    number(told, slope,
           std::max({std::abs(told), 0.1 * largest_stiffness_[k],
                     std::abs(path[0].drive_loads[k]) * 0.01 /
                         std::max(std::abs(last[k]), steps[k] / share),
                     known / steps[k] / allowed}),
           allowed, fmt::format("drive_stiffness.{}", k), d);
  }
}

void Looker::compliance_by_load(json job) {
  law("compliance, load", [&](Difference& d) {
    if (job.contains("loads"))
      for (json& load : job["loads"]) load.erase("moment");
    job = with_stroke(job, json::array({points().back()}));
    const Run still = run(job);
    if (!answered(still, d)) return;
    const PathPoint& here = still.path()[0];
    if (!believed(here)) return;
    Vector6d w;
    w << random_.direction(), length_ * random_.direction();
    const Difference empty = d;
    // wide ones first: of soft mechanisms rounding makes much of small loads
    for (const double share : {100.0, 10.0, 1.0, 0.1, narrowest}) {
      d = empty;
      compare_compliance(job, here, w, share, d);
      if (d.end != End::broken) return;
    }
  });
}

void Looker::compare_compliance(const json& job, const PathPoint& here, const Vector6d& w,
                                double share, Difference& d) {
  const Vector6d motion = here.compliance_locked * w;
  const double size = std::max(motion.head<3>().norm(), length_ * motion.tail<3>().norm());
  if (!(size > 0)) return;
  const double by = share * 1e-5 * length_ / size;
  const auto loaded = [&](double sign) {
    json one = job;
    if (!one.contains("loads")) one["loads"] = json::array();
    json load{{"name", "small"}};
    for (const char* key : {"force", "moment"}) {
      const Vector3d v = sign * by * (key[0] == 'f' ? w.head<3>() : w.tail<3>());
      load[key] = json::array({v[0], v[1], v[2]});
    }
    one["loads"].push_back(load);
    return one;
  };
  d.other = loaded(1);
  const Run plus = run(d.other), minus = run(loaded(-1));
  if (!answered(plus, d) || !answered(minus, d)) return;
  const PathPoint &p = plus.path()[0], &m = minus.path()[0];
  if (!believed(p) || !believed(m)) return;
  if (share == narrowest && (far_apart(here, p, 0.01) || far_apart(here, m, 0.01))) {
    d.end = End::no_answer;
    d.message = "another branch";  // a force that moves next to nothing decides on it
    return;
  }
  const Vector3d moved = (p.displacement - m.displacement) / (2 * by),
                 turned =
                     rotation_log(rotation_exp(p.rotation) * rotation_exp(m.rotation).transpose()) /
                     (2 * by);
  for (int i = 0; i < 3; ++i) {
    number(motion[i], moved[i], size, 1e-3, fmt::format("motion u{} over load", "xyz"[i]), d);
    number(length_ * motion[3 + i], length_ * turned[i], size, 1e-3,
           fmt::format("motion r{} over load, times length", "xyz"[i]), d);
  }
}

void Looker::closed_way(json job, const Run& whole) {
  law("closed way", [&](Difference& d) {
    if (job.contains("loads"))  // dead moments have no potential
      for (json& load : job["loads"]) load.erase("moment");
    const std::vector<double> last = strokes_of(job, points().back());
    if (!believed(whole.path().back())) return;
    std::vector<std::size_t> pair;
    for (std::size_t k = 0; k < last.size(); ++k)
      if (last[k] != 0) pair.push_back(k);
    if (pair.size() < 2) return;
    while (pair.size() > 2)
      pair.erase(pair.begin() + random_.whole(0, static_cast<int>(pair.size()) - 1));
    const Difference empty = d;
    for (const int parts : {1, 4, 16}) {
      d = empty;
      work_around(job, last, {pair[0], pair[1]}, parts, d);
      if (d.end != End::broken) return;
    }
  });
}

void Looker::work_around(const json& job, const std::vector<double>& last,
                         std::array<std::size_t, 2> pair, int parts, Difference& d) {
  constexpr std::array<std::array<double, 2>, 5> gauss{{{-0.9061798459386640, 0.2369268850561891},
                                                        {-0.5384693101056831, 0.4786286704993665},
                                                        {0, 0.5688888888888889},
                                                        {0.5384693101056831, 0.4786286704993665},
                                                        {0.9061798459386640, 0.2369268850561891}}};
  constexpr std::array<std::array<double, 2>, 5> corners{
      {{1, 1}, {0.7, 1}, {0.7, 0.7}, {1, 0.7}, {1, 1}}};
  json at = json::array();
  std::vector<std::array<double, 2>> weights;  // of the drives' loads in the work
  for (std::size_t edge = 0; edge < 4; ++edge)
    for (int part = 0; part < parts; ++part)
      for (const auto& [place, weight] : gauss) {
        const double share = (part + 0.5 * (1 + place)) / parts;
        std::vector<double> strokes = last;
        for (std::size_t i = 0; i < 2; ++i)
          strokes[pair[i]] *= corners[edge][i] + share * (corners[edge + 1][i] - corners[edge][i]);
        at.push_back(stroke_point(job, strokes));
        std::array<double, 2>& w = weights.emplace_back();
        for (std::size_t i = 0; i < 2; ++i)
          w[i] = 0.5 * weight / parts * (corners[edge + 1][i] - corners[edge][i]) * last[pair[i]];
      }
  d.other = with_stroke(job, at);
  const Run around = run(d.other);
  if (!answered(around, d)) return;
  double work = 0, turnover = 0;
  for (std::size_t n = 0; n < weights.size(); ++n) {
    const PathPoint& p = around.path()[n];
    if (!believed(p)) {
      d.end = End::no_answer;
      d.message = "unstable";
      return;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      work += weights[n][i] * p.drive_loads[pair[i]];
      turnover += std::abs(weights[n][i] * p.drive_loads[pair[i]]);
    }
  }
  if (parts > 1 && leaps(job, at, around, d)) return;
  number(0, work, turnover, 1e-4, fmt::format("work around strokes {} and {}", pair[0], pair[1]),
         d);
}

bool Looker::leaps(const json& job, const json& at, const Run& row, Difference& d) {
  const auto& path = row.path();
  const auto leap = [&](const PathPoint& a, const PathPoint& b) {
    std::vector<std::size_t> moved;
    for (std::size_t k = 0; k < a.strokes.size(); ++k)
      if (a.strokes[k] != b.strokes[k]) moved.push_back(k);
    if (moved.size() != 1) return false;  // around a corner
    const std::size_t k = moved[0];
    const double told = 0.5 * (a.drive_stiffnesses[k] + b.drive_stiffnesses[k]) *
                        (b.strokes[k] - a.strokes[k]),
                 grown = b.drive_loads[k] - a.drive_loads[k];
    return std::abs(grown - told) > std::max(0.2 * std::max(std::abs(grown), std::abs(told)),
                                             1e-4 * std::abs(a.drive_loads[k]));
  };
  for (std::size_t n = 0; n + 1 < path.size(); ++n) {
    if (!leap(path[n], path[n + 1])) continue;
    for (const std::size_t end : {n, n + 1}) {
      constexpr int steps = 24;
      const std::vector<double> strokes = strokes_of(job, at[end]);
      json way = json::array();
      for (int k = 1; k <= steps; ++k) {
        std::vector<double> part = strokes;
        for (double& stroke : part) stroke *= static_cast<double>(k) / steps;
        way.push_back(stroke_point(job, part));
      }
      d.other = with_stroke(job, way);
      d.other["stroke"]["in_order"] = true;
      const Run slowly = run(d.other);
      if (!answered(slowly, d)) return true;
      if (far_apart(path[end], slowly.path().back(), 0.01)) {
        d.end = End::broken;
        d.error = 1e3;
        d.what = fmt::format("small steps end elsewhere than point {}", end);
        return true;
      }
    }
    d.end = End::no_answer;
    d.message = fmt::format("another branch from point {} to the next", n);
    return true;
  }
  return false;
}

double Looker::apart(const PathPoint& a, const PathPoint& b) const {
  double apart = 0;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    const BodyMotion &x = a.bodies[i], &y = b.bodies[i];
    apart = std::max({apart, (x.displacement - y.displacement).norm(),
                      length_ * (x.rotation - y.rotation).norm()});
  }
  return apart;
}

bool Looker::far_apart(const PathPoint& a, const PathPoint& b, double share) const {
  double size = 0;
  for (const BodyMotion& x : a.bodies)
    size = std::max({size, x.displacement.norm(), length_ * x.rotation.norm()});
  return apart(a, b) > share * size;
}

Differences differences_of(const json& job, unsigned long long seed, Laws laws) {
  return Looker(job, seed, laws).look();
}

}  // namespace flexopt
