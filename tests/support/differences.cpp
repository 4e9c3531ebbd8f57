#include "support/differences.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <functional>
#include <map>
#include <numbers>
#include <optional>

#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"
#include "core/response/quantities.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job.hpp"
#include "results/files/run_record.hpp"
#include "support/changed_jobs.hpp"
#include "support/random_design.hpp"
#include "support/random_jobs.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

using End = Difference::End;

double processor_time() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

// An evaluation as the program concludes it.
struct Run {
  RunRecord record;
  double seconds = 0;
  bool ok() const { return record.status == "ok"; }
  const std::vector<PathPoint>& path() const { return record.response.path; }
};

Run run(const json& job) {
  Run done;
  RunRecord& record = done.record;
  try {
    record.job = parse_job(job);
    record.mechanism = make_mechanism(record.job, record.job.design.parameters);
  } catch (const SpecError& error) {
    record.status = "refused";
    record.message = error.what();
    return done;
  }
  const double begin = processor_time();
  record.job.request.outputs.remove({Output::clearance, Output::moving_envelope});
  record.response = evaluate_stroke(record.mechanism, record.job.model, record.job.request);
  conclude(record);
  done.seconds = processor_time() - begin;
  return done;
}

bool believed(const PathPoint& point) {
  return point.status == PointStatus::converged && point.stable && !point.other_branch;
}

double length_of(const Mechanism& mechanism) {
  double longest = 0;
  for (const LeafSpring& leaf : mechanism.leaves) longest = std::max(longest, leaf.length);
  return longest;
}

// What Newton's tolerance leaves of a place, over the length.
constexpr double of_newton = 3e-9;

// Largest errors of the kinds of numbers, relative.
struct Tolerance {
  double number = 0, stress = 0;
};

// [N]; moments over the length.
double largest_load(const Job& job, double length) {
  double largest = 0;
  for (const DeadLoad& load : job.request.loads.constant)
    largest = std::max({largest, load.force.norm(), load.moment.norm() / length});
  return largest;
}

// How the other run is to be read.
struct Twin {
  double growth = 1;
  Matrix3d Q = Matrix3d::Identity();  // what turns or mirrors vectors
  std::vector<double> signs;          // of the strokes; empty: 1
  std::vector<std::size_t> points;    // of the other run, of each of ours; empty: the same
  bool frequencies = true, motion = true, compliance = true;
  bool drives_free = true;  // the compliance with them
  double of_acting = 1e-7;  // what is unknown of a drive's load, over the loads that act beside it
};

class Comparison {
 public:
  Comparison(const Run& one, const Run& other, const Twin& twin, const Tolerance& allowed)
      : one_(one),
        other_(other),
        twin_(twin),
        allowed_(allowed),
        length_(length_of(one.record.mechanism)),
        all_(quantities(DriveList(one.record.mechanism))) {
    for (const LeafSpring& leaf : one.record.mechanism.leaves)
      modulus_ = std::max(modulus_, leaf.material.youngs_modulus);
  }

  void write(Difference& found) {
    const auto& path = one_.path();
    int compared = 0;
    find_sizes();
    for (std::size_t k = 0; k < path.size(); ++k) {
      const std::size_t there = twin_.points.empty() ? k : twin_.points.at(k);
      if (there >= other_.path().size()) continue;
      const PathPoint &a = path[k], &b = other_.path()[there];
      if (!believed(a) || !believed(b)) continue;
      ++compared;
      at_ = k;
      rows(a, b);
      if (twin_.motion) motion(a, b);
      if (twin_.compliance) compliance(a, b);
    }
    found.end = compared == 0 ? End::no_answer : worst_ <= 1 ? End::kept : End::broken;
    if (compared == 0) found.message = "no point is stable in both";
    found.error = worst_;
    found.what = what_;
  }

 private:
  void add(double a, double b, double scale, double allowed, const std::string& name) {
    const double error = a == b ? 0 : std::abs(a - b) / std::max(scale, 1e-300) / allowed;
    if (std::isfinite(error) && error <= worst_) return;
    worst_ = std::isfinite(error) ? error : 1e300;
    double check = 0;
    for (const LeafReport& leaf : one_.path()[at_].leaves) check = std::max(check, leaf.check);
    what_ = fmt::format("{} at point {}: {:.7g} and {:.7g} ({:.2g} of {:.3g}, check {:.1e})", name,
                        at_, a, b, std::abs(a - b) / std::max(scale, 1e-300), scale, check);
  }

  // Of every row the largest of the path; of loads what makes a twentieth of the largest work.
  void find_sizes() {
    for (const PathPoint& p : one_.path()) {
      if (!believed(p)) continue;
      motion_ = std::max({motion_, p.displacement.norm() / length_, p.rotation.norm()});
      for (const Quantity& q : all_)
        if (const auto value = q.value(p)) {
          double& size = largest_[q.name];
          size = std::max(size, std::abs(*value));
        }
    }
    const Mechanism& m = one_.record.mechanism;
    stroke_.assign(m.drives.size(), 0);
    const double acting = largest_load(one_.record.job, length_);
    double work = 0;
    for (const PathPoint& p : one_.path())
      for (std::size_t j = 0; j < std::min(p.strokes.size(), stroke_.size()); ++j) {
        stroke_[j] = std::max(stroke_[j], std::abs(p.strokes[j]));
        if (believed(p)) work = std::max(work, std::abs(p.drive_loads[j] * p.strokes[j]));
      }
    for (std::size_t j = 0; j < stroke_.size(); ++j) {
      const bool turns = is_rotation(m.drives[j].direction);
      const double unit = turns ? 1 : length_;
      load_.push_back(0.05 * work / std::max(stroke_[j], 1e-3 * unit));
      double stiffest = 0;
      for (const PathPoint& p : one_.path())
        if (believed(p)) stiffest = std::max(stiffest, std::abs(p.drive_stiffnesses[j]));
      stiffest_.push_back(stiffest);
      known_.push_back(of_newton * unit * stiffest +
                       twin_.of_acting * acting * (turns ? length_ : 1));
    }
  }

  double scale_of(const Quantity& q, double value) const {
    const double here = std::abs(value), most = largest_.contains(q.name) ? largest_.at(q.name) : 0;
    switch (q.row->error) {
      case ErrorKind::load:
        return std::max({most, load_[static_cast<std::size_t>(q.component)],
                         known_[static_cast<std::size_t>(q.component)] / allowed_.number});
      case ErrorKind::stress:
        return std::max({here, 0.2 * most, 3 * of_newton * modulus_ / allowed_.stress});
      default:
        return std::max(here, (q.row->of_drives && !twin_.drives_free ? 1 : 0.1) * most);
    }
  }

  void rows(const PathPoint& a, const PathPoint& b) {
    for (const Quantity& q : all_) {
      const ErrorKind kind = q.row->error;
      if (kind == ErrorKind::none || kind == ErrorKind::motion) continue;
      if (!twin_.Q.isIdentity() && (q.row->of_supports)) continue;
      if (kind == ErrorKind::frequency && (!twin_.frequencies || q.name == "parasitic_frequency"))
        continue;
      if (kind == ErrorKind::stiffness && !twin_.compliance && !q.row->of_drives) continue;
      const auto x = q.value(a), y = q.value(b);
      if (!x || !y) continue;
      double there = *y / growth_of(q.unit, twin_.growth);
      const auto k = static_cast<std::size_t>(q.component);
      if (q.row->name == "drive_load" && k < twin_.signs.size()) there *= twin_.signs[k];
      add(*x, there, scale_of(q, *x), kind == ErrorKind::stress ? allowed_.stress : allowed_.number,
          q.name);
    }
  }

  void motion(const PathPoint& a, const PathPoint& b) {
    const double turn = twin_.Q.determinant();
    if (motion_ < 1e-9) return;
    const auto bodies = std::min(a.bodies.size(), b.bodies.size());
    for (std::size_t i = 0; i < bodies; ++i) {
      const Vector3d u = twin_.Q * a.bodies[i].displacement,
                     v = b.bodies[i].displacement / twin_.growth,
                     r = turn * (twin_.Q * a.bodies[i].rotation), s = b.bodies[i].rotation;
      const std::string& name = one_.record.mechanism.bodies[i].name;
      add(u.norm(), u.norm() + (u - v).norm(),
          std::max({motion_ * length_, u.norm(), of_newton * length_ / allowed_.number}),
          allowed_.number, "displacement of " + name);
      add(r.norm(), r.norm() + (r - s).norm(),
          std::max({motion_, r.norm(), of_newton / allowed_.number}), allowed_.number,
          "rotation of " + name);
    }
  }

  void compliance(const PathPoint& a, const PathPoint& b) {
    Matrix6d T = Matrix6d::Zero();
    T.topLeftCorner<3, 3>() = twin_.Q;
    T.bottomRightCorner<3, 3>() = twin_.Q.determinant() * twin_.Q;
    Vector6d unit;
    unit << Vector3d::Ones(), Vector3d::Constant(length_);
    const Vector6d growth = (Vector6d() << Vector3d::Constant(std::sqrt(twin_.growth)),
                             Vector3d::Constant(std::sqrt(std::pow(twin_.growth, 3))))
                                .finished();
    const Vector6d back = unit.cwiseProduct(growth);
    const auto softest = [&](const Matrix6d& C) {
      return (unit.asDiagonal() * C * unit.asDiagonal()).diagonal().cwiseAbs().maxCoeff();
    };
    const double most = std::max(softest(a.compliance_locked), softest(a.compliance_free));
    const auto compare = [&](const Matrix6d& here, const Matrix6d& there, const char* name) {
      // a direction that is a hundred times stiffer than the softest one; where drives that let go
      // leave an unstable state, numbers may pass through zero
      const double least = here.diagonal().minCoeff() < 0 ? most : 1e-4 * most;
      const Matrix6d turned = T * here * T.transpose(),
                     C = unit.asDiagonal() * turned * unit.asDiagonal(),
                     D = back.asDiagonal() * there * back.asDiagonal();
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j <= i; ++j) {
          const double scale =
              std::sqrt(std::max(std::abs(C(i, i)), least) * std::max(std::abs(C(j, j)), least));
          add(C(i, j), D(i, j), scale, allowed_.number,
              fmt::format("compliance {} ({}, {}), over the length", name, i, j));
        }
    };
    compare(a.compliance_locked, b.compliance_locked, "locked");
    // stiffnesses of drives that have all but vanished are rounding, and so is what they let go
    bool balanced = false;
    for (std::size_t k = 0; k < stiffest_.size(); ++k)
      balanced = balanced || std::abs(a.drive_stiffnesses[k]) < 1e-2 * stiffest_[k];
    if (twin_.drives_free && !balanced && !one_.record.mechanism.drives.empty())
      compare(a.compliance_free, b.compliance_free, "free");
  }

  const Run &one_, &other_;
  const Twin& twin_;
  const Tolerance allowed_;
  double length_, modulus_ = 0, motion_ = 0, worst_ = 0;
  std::vector<Quantity> all_;
  std::map<std::string, double> largest_;
  // of each drive: largest stroke, load that counts, load that is known, largest stiffness
  std::vector<double> stroke_, load_, known_, stiffest_;
  std::size_t at_ = 0;
  std::string what_;
};

// What the reduction may be off by: README's accuracy of reduced leaves, three times.
constexpr Tolerance of_reduction{0.01, 0.03};
// Of the same leaves, expanded about other states.
constexpr Tolerance of_expansion{0.0075, 0.02};
// Full leaves, by Newton's tolerance and rounding.
constexpr Tolerance of_rounding{1e-4, 3e-4};

class Looker {
 public:
  Looker(const json& job, unsigned long long seed, Laws laws)
      : job_(job), random_(seed), seed_(seed), laws_(laws) {}

  Differences look() {
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
        stiffest_.resize(p.drive_stiffnesses.size());
        stiffest_[k] = std::max(stiffest_[k], std::abs(p.drive_stiffnesses[k]));
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

 private:
  const json& points() const { return job_["stroke"]["at"]; }

  // Of few laws each mechanism is looked at by every third one, from another one on.
  void law(const std::string& name, const std::function<void(Difference&)>& look) {
    const std::size_t number = number_++;
    if (few_ && number > 0 && (number + seed_) % 3 != 0) return;
    look_at(name, number, look);
  }

  void look_at(const std::string& name, std::size_t number,
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

  static bool answered(const Run& one, Difference& d) {
    if (one.ok()) return true;
    d.end = End::no_answer;
    d.message = one.record.status + ": " + one.record.message;
    return false;
  }

  static void answer(const Run& one, const Run& other, const Twin& twin, const Tolerance& allowed,
                     Difference& d) {
    if (answered(one, d) && answered(other, d)) Comparison(one, other, twin, allowed).write(d);
  }

  // One number against another one.
  static void number(double one, double other, double scale, double allowed,
                     const std::string& name, Difference& d) {
    const double error = std::abs(one - other) / std::max(scale, 1e-300) / allowed;
    if (d.end == End::skipped) d.end = End::kept;
    if (std::isfinite(error) && error <= d.error) return;
    d.error = std::isfinite(error) ? error : 1e300;
    d.what = fmt::format("{}: {:.7g} and {:.7g} ({:.2g} of {:.3g})", name, one, other,
                         std::abs(one - other) / std::max(scale, 1e-300), scale);
    d.end = d.error <= 1 ? End::kept : End::broken;
  }

  // The k-th frequency with d drives held lies between the k-th and the (k + d)-th with them free.
  // This costs nothing and is looked at for every mechanism.
  void interlacing(const Run& base) {
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

  void alone(const Run& base) {
    const std::size_t count = points().size();
    law("alone", [&](Difference& d) {
      d.other = with_stroke(job_, json::array({points().back()}));
      Twin twin;
      twin.points.assign(count, count);
      twin.points.back() = 0;
      answer(base, run(d.other), twin, same_leaves_, d);
    });
    law("other order", [&](Difference& d) {
      json reversed = points();
      std::ranges::reverse(reversed);
      d.other = with_stroke(job_, reversed);
      Twin twin;
      for (std::size_t k = 0; k < count; ++k) twin.points.push_back(count - 1 - k);
      answer(base, run(d.other), twin, same_leaves_, d);
    });
  }

  // With two points more on the way from each point to the next.
  void more_points(const Run& base) {
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
      answer(base, run(d.other), twin, same_leaves_, d);
    });
  }

  // A force at O that grows, nothing driven: at once, and by steps that are told.
  void load_in_steps(const Run& whole) {
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

  // A derivative is the limit of differences: where one with a wide step is off, because the
  // numbers curve or change their branch within it, narrower ones decide.
  static constexpr double narrowest = 0.01;
  static constexpr std::array<double, 3> step_shares{1, 0.1, narrowest};

  // Each drive's load at both sides of the last point, the other drives held.
  void stiffness_by_stroke(const std::string& name, const json& job, double allowed) {
    law(name, [&](Difference& d) {
      const Difference empty = d;
      for (const double share : step_shares) {
        d = empty;
        compare_stiffness(job, share, allowed, d);
        if (d.end != End::broken) return;
      }
    });
  }

  // A leaf that has changed its model between two points makes loads leap by what it was off.
  static bool other_models(const PathPoint& a, const PathPoint& b) {
    return !std::ranges::equal(a.leaves, b.leaves, [](const LeafReport& x, const LeafReport& y) {
      return x.model == y.model && x.degree == y.degree && x.reason == y.reason;
    });
  }

  void compare_stiffness(json job, double share, double allowed, Difference& d) {
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
             std::max({std::abs(told), 0.1 * stiffest_[k],
                       std::abs(path[0].drive_loads[k]) * 0.01 /
                           std::max(std::abs(last[k]), steps[k] / share),
                       known / steps[k] / allowed}),
             allowed, fmt::format("drive_stiffness.{}", k), d);
    }
  }

  // A dead moment has no potential, and compliances are those of the part that has one: without it.
  void compliance_by_load(json job) {
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

  void compare_compliance(const json& job, const PathPoint& here, const Vector6d& w, double share,
                          Difference& d) {
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
                   turned = rotation_log(rotation_exp(p.rotation) *
                                         rotation_exp(m.rotation).transpose()) /
                            (2 * by);
    for (int i = 0; i < 3; ++i) {
      number(motion[i], moved[i], size, 1e-3, fmt::format("motion u{} over load", "xyz"[i]), d);
      number(length_ * motion[3 + i], length_ * turned[i], size, 1e-3,
             fmt::format("motion r{} over load, times length", "xyz"[i]), d);
    }
  }

  // The work of two drives around a rectangle, from 0.7 to 1 of the last point's strokes: by
  // Gauss's five points on each edge, and where loads change too sharply for these, on each quarter
  // or sixteenth of it.
  void closed_way(json job, const Run& whole) {
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

  void work_around(const json& job, const std::vector<double>& last,
                   std::array<std::size_t, 2> pair, int parts, Difference& d) {
    constexpr std::array<std::array<double, 2>, 5> gauss{
        {{-0.9061798459386640, 0.2369268850561891},
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
            strokes[pair[i]] *=
                corners[edge][i] + share * (corners[edge + 1][i] - corners[edge][i]);
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

  // Whether the load of a drive leaps from one point of a row to the next by what its stiffness
  // does not tell: each point lies at the end of its own way, and ways at both sides of a
  // bifurcation part. Then small steps along both ways must end where the points are.
  bool leaps(const json& job, const json& at, const Run& row, Difference& d) {
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

  void moved(const json& job, const Run& whole, bool all) {
    law("turned", [&](Difference& d) {
      const TurnedJob turned = turned_job(job, random_.between(-3, 3), random_.between(-3, 3));
      d.other = turned.job;
      Twin twin;
      twin.Q = turned.R;
      answer(whole, run(d.other), twin, of_rounding, d);
    });
    law("mirrored", [&](Difference& d) {
      const int normal = random_.whole(0, 2);
      const auto mirrored = mirrored_job(job, normal);
      if (!mirrored) return;
      d.other = mirrored->job;
      Twin twin;
      twin.Q(normal, normal) = -1;
      twin.signs = mirrored->signs;
      answer(whole, run(d.other), twin, of_rounding, d);
    });
    if (!all) return;
    law("grown", [&](Difference& d) {
      d.other = grown_job(job, 3);
      Twin twin;
      twin.growth = 3;
      answer(whole, run(d.other), twin, of_rounding, d);
    });
  }

  // What the stiffest leaf could carry: E A / L [N/m].
  double stiffest() const {
    const Job job = parse_job(job_);
    double most = 0;
    for (const LeafSpring& leaf : make_mechanism(job, job.design.parameters).leaves)
      most =
          std::max(most, leaf.material.youngs_modulus * leaf.width * leaf.thickness / leaf.length);
    return most;
  }

  void springs_for_held(const json& job, const Run& whole) {
    const auto look = [&](const std::string& name, const json& from, const Tolerance& allowed) {
      law(name, [&](Difference& d) {
        const double stiffness =
            1e4 * stiffest() + 1e8 * largest_load(whole.record.job, length_) / length_;
        const auto other = with_springs_for_held(from, stiffness, length_);
        if (!other) return;
        d.other = *other;
        Twin twin;
        twin.compliance = false;
        twin.of_acting = 1e-5;
        const Run sprung = run(d.other);
        answer(whole, sprung, twin, allowed, d);
        if (d.end != End::broken) return;
        // softer springs tell whether these yield, or round
        Difference own;
        answer(sprung, run(*with_springs_for_held(from, 0.1 * stiffness, length_)), twin,
               {0.5 * allowed.number, 0.5 * allowed.stress}, own);
        if (own.end == End::kept) return;
        d.end = End::no_answer;
        d.message = "springs of other stiffness tell other numbers: " + own.what;
      });
    };
    look("springs for held", job, {5e-3, 0.1});
    if (laws_ == Laws::all) look("springs for held, reduced", job_, {0.015, 0.05});
  }

  // Largest distance of a body's places, and of its rotations times the length.
  double apart(const PathPoint& a, const PathPoint& b) const {
    double apart = 0;
    for (std::size_t i = 0; i < a.bodies.size(); ++i) {
      const BodyMotion &x = a.bodies[i], &y = b.bodies[i];
      apart = std::max({apart, (x.displacement - y.displacement).norm(),
                        length_ * (x.rotation - y.rotation).norm()});
    }
    return apart;
  }

  // Bodies apart by more than this share of what they move.
  bool far_apart(const PathPoint& a, const PathPoint& b, double share) const {
    double size = 0;
    for (const BodyMotion& x : a.bodies)
      size = std::max({size, x.displacement.norm(), length_ * x.rotation.norm()});
    return apart(a, b) > share * size;
  }

  // Leaves that have buckled to their other sides hardly move bodies.
  static bool same_frequencies(const std::vector<double>& a, const std::vector<double>& b) {
    for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k)
      if (std::abs(a[k] - b[k]) > 0.01 * std::abs(a[k])) return false;
    return true;
  }

  // The drive gives way a little; its load is compared there.
  void spring_for_drive(const json& job, const Run& whole) {
    law("spring for drive", [&](Difference& d) {
      const PathPoint& here = whole.path().back();
      if (!believed(here) || here.drive_loads.size() < 2) return;
      const auto k =
          static_cast<std::size_t>(random_.whole(0, static_cast<int>(here.drive_loads.size()) - 1));
      // what Newton's tolerance leaves of the place costs the more, the stiffer it is
      const double stiffness = std::max(1e3 * std::abs(here.drive_stiffnesses[k]),
                                        1e5 * std::abs(here.drive_loads[k]) / length_);
      const auto other = with_spring_for_drive(job, points().back(), stiffness, length_, k);
      if (!other) return;
      d.other = other->job;
      const Run sprung = run(d.other);
      if (!answered(sprung, d) || !believed(sprung.path()[0])) return;
      // the spring is there from the start, so that another branch may be met
      if (far_apart(here, sprung.path()[0], 0.1) ||
          !same_frequencies(here.frequencies_locked, sprung.path()[0].frequencies_locked)) {
        d.message = "another branch";
        return;
      }
      const auto& bodies = sprung.record.mechanism.bodies;
      const auto body = std::ranges::find(bodies, other->body, &RigidBody::name) - bodies.begin();
      const Vector3d& moved = sprung.path()[0].bodies[static_cast<std::size_t>(body)].displacement;
      const double load = other->load(moved), went = here.strokes[k] - load / stiffness,
                   told =
                       here.drive_loads[k] + here.drive_stiffnesses[k] * (went - here.strokes[k]);
      const double known = of_newton * length_ * stiffness,
                   scale = std::max({std::abs(told), known / 2e-3,
                                     std::abs(here.drive_stiffnesses[k] * here.strokes[k])});
      number(told, load, scale, 2e-3, fmt::format("drive_load.{}", k), d);
      // the other drives' loads
      for (std::size_t j = 0, i = 0; j < here.drive_loads.size(); ++j) {
        if (j == k) continue;
        const double size = std::max({std::abs(here.drive_loads[j]),
                                      std::abs(here.drive_stiffnesses[j] * here.strokes[j]), known,
                                      std::abs(here.drive_loads[k])});
        number(here.drive_loads[j], sprung.path()[0].drive_loads[i++], size, 3e-2,
               fmt::format("drive_load.{} beside it", j), d);
      }
    });
  }

  // The common edge of the halves does not warp: narrow beams and wires, on fine meshes.
  void cut(const json& job, const Run& whole) {
    law("cut leaf", [&](Difference& d) {
      const auto other = with_cut_leaf(job);
      if (!other) return;
      double narrow = 0;
      bool beams = true;
      for (const LeafSpring& leaf : whole.record.mechanism.leaves)
        if (leaf.section == Section::rectangular) {
          narrow = std::max(narrow, leaf.width / leaf.length);
          beams = beams && flexure_of(leaf, whole.record.job.model) == Flexure::beam;
        }
      if (narrow > 0 && (!beams || narrow > 0.02)) return;
      d.other = *other;
      json fine = job;
      fine["model"]["mesh"] = d.other["model"]["mesh"] = json::array({24, 2});
      const double allowed = 2e-3 + narrow;
      Twin twin;
      twin.frequencies = false;
      // stresses of warping at clamps are those of the mesh
      answer(run(fine), run(d.other), twin, {allowed, 0.3}, d);
    });
  }

  // Of one material, nothing joined, sprung, held or driven.
  void warm(json job) {
    law("warm as a whole", [&](Difference& d) {
      json& m = job["design"]["mechanism"];
      for (const char* list : {"joints", "springs"})
        if (m.contains(list) && !m[list].empty()) return;
      json bodies{{"ground", 40}};
      for (json& body : m["bodies"]) {
        if (body.contains("held") || body.contains("on")) return;
        bodies[body["name"].get<std::string>()] = 40;
      }
      for (json& leaf : m["leaves"]) leaf.erase("material");
      for (const char* key : {"loads", "gravity", "assembly"}) job.erase(key);
      job["temperature"] = {{"change", 40}, {"bodies", bodies}};
      m.erase("drive");
      m.erase("drives");
      job.erase("stroke");
      const double expansion = job["design"]["material"]["thermal_expansion"].get<double>() * 40,
                   modulus = job["design"]["material"]["youngs_modulus"];
      // a path of a load that is nothing
      job["load_path"] = {{"force", json::array({1e-18 * modulus * length_ * length_, 0, 0})},
                          {"points", 2}};
      d.other = job;
      const Run warm = run(job);
      if (!answered(warm, d)) return;
      const PathPoint& p = warm.path()[0];
      const auto& all = warm.record.mechanism.bodies;
      double far = length_;
      for (const RigidBody& body : all) far = std::max(far, body.reference.norm());
      for (std::size_t i = 0; i < all.size(); ++i) {
        const Vector3d expected = expansion * all[i].reference;
        // rounding of the forces of stiff leaves turns what hangs on a soft one
        number(0, (p.bodies[i].displacement - expected).norm(), expansion * far, 3e-3,
               "displacement of " + all[i].name + " beside free expansion", d);
        number(0, p.bodies[i].rotation.norm(), expansion, 3e-2, "rotation of " + all[i].name, d);
      }
      if (p.max_stress) number(0, p.max_stress->value, expansion * modulus, 1e-3, "max_stress", d);
    });
  }

  void heavy(json job) {
    law("heavy body", [&](Difference& d) {
      for (json& body : job["design"]["mechanism"]["bodies"])
        for (const char* key : {"mass", "inertia", "center_of_mass", "box", "density"})
          body.erase(key);
      job.erase("gravity");
      const double m = 1e6 * 8000 * std::pow(length_, 3), i = 0.1 * m * length_ * length_;
      job["end_effector"] = {{"mass", m}, {"inertia", json::array({i, 1.5 * i, 0.8 * i})}};
      job = with_stroke(job, json::array({points().back()}));
      job["frequencies"] = 6;
      d.other = job;
      const Run done = run(job);
      if (!answered(done, d)) return;
      const PathPoint& p = done.path()[0];
      if (!believed(p)) return;
      const Matrix3d R = rotation_exp(p.rotation);
      Matrix6d M = Matrix6d::Zero();
      M.topLeftCorner<3, 3>() = m * Matrix3d::Identity();
      M.bottomRightCorner<3, 3>() = R * Vector3d(i, 1.5 * i, 0.8 * i).asDiagonal() * R.transpose();
      for (const auto& [C, list, name] :
           {std::tuple{p.compliance_locked, p.frequencies_locked, "locked"},
            {p.compliance_free, p.frequencies_free, "free"}}) {
        if (list.empty() || list.front() <= 0) continue;  // unstable where its drives are free
        // 1/ω² are the eigenvalues of L'CL, M = LL'
        const MatrixXd L = Cholesky(M).lower();
        const MatrixXd A = L.transpose() * C * L;
        const VectorXd values = symmetric_eigenvalues(0.5 * (A + A.transpose()));
        std::vector<double> expected;
        for (int k = 5; k >= 0; --k)
          if (values[k] > 1e-7 * values[5])
            expected.push_back(1 / std::sqrt(values[k]) / (2 * std::numbers::pi));
        for (std::size_t k = 0; k < std::min(expected.size(), list.size()); ++k)
          number(list[k], expected[k], expected[k], 2e-3, fmt::format("frequency {} {}", name, k),
                 d);
      }
    });
  }

  void state_space(const json& job) {
    law("state space", [&](Difference& d) {
      json one = with_stroke(job, json::array({points().back()}));
      one["export"]["state_space"] = {{"modes", 4}};
      d.other = one;
      const Run done = run(one);
      if (!answered(done, d)) return;
      const PathPoint& p = done.path()[0];
      if (!believed(p) || !p.state_space) return;
      const StateSpace& model = *p.state_space;
      for (std::size_t k = 0;
           k < std::min<std::size_t>(p.frequencies_free.size(),
                                     static_cast<std::size_t>(model.omega2.size()));
           ++k) {
        const double w2 = model.omega2[static_cast<Eigen::Index>(k)];
        if (w2 < 0) continue;  // of growing motions a few modes of each leaf know the sign alone
        number(p.frequencies_free[k],
               std::copysign(std::sqrt(std::abs(w2)), w2) / (2 * std::numbers::pi),
               std::abs(p.frequencies_free[k]), 2e-3, fmt::format("frequency {}", k), d);
      }
      // static answers: of the drives' loads on their strokes
      const MatrixXd still =
          model.motions * model.omega2.cwiseInverse().asDiagonal() * model.forces + model.residual;
      const json drives = drives_of(job);
      for (Eigen::Index i = 0; i < still.cols(); ++i)
        for (Eigen::Index o = 0; o < still.rows(); ++o) {
          const std::string &in = model.inputs[static_cast<std::size_t>(i)].name,
                            &out = model.outputs[static_cast<std::size_t>(o)].name;
          if (in != "drive_load" || out != "stroke" || drives.size() != 1) continue;
          number(p.drive_stiffness, 1 / still(o, i), std::abs(p.drive_stiffness), 1e-5,
                 "drive stiffness", d);
        }
    });
  }

  void beam_and_plate(const Run& whole) {
    law("beam and plate", [&](Difference& d) {
      double narrow = 0;
      for (const LeafSpring& leaf : whole.record.mechanism.leaves) {
        if (leaf.section == Section::circular || leaf.fold) continue;
        narrow = std::max(narrow, leaf.width / leaf.length);
        if (leaf.curve) return;
      }
      if (narrow == 0 || narrow > 0.05) return;
      json beam = job_, plate = with_accuracy(job_, "full");
      beam["model"]["flexure"] = "beam";
      plate["model"]["flexure"] = "plate";
      beam["model"]["mesh"] = json::array({12, 2});
      plate["model"]["mesh"] = json::array({12, 3});
      d.other = plate;
      Twin twin;
      twin.frequencies = twin.drives_free = false;  // drives may all but balance
      twin.of_acting = 5e-3;
      answer(run(beam), run(plate), twin, {0.08, 1e3}, d);  // a beam knows no peaks at clamps
    });
  }

  // With the load at O put on: stable, and below the stress.
  void capacity(json job, const Run& whole) {
    law("capacity", [&](Difference& d) {
      const PathPoint& here = whole.path().back();
      if (!believed(here) || !here.max_stress) return;
      const double modulus = job["design"]["material"]["youngs_modulus"],
                   limit = std::max(2 * here.max_stress->value, 3e-3 * modulus);
      job = with_stroke(job, json::array({points().back()}));
      const int direction = random_.whole(0, 2);
      if (!(here.compliance_locked(direction, direction) > 0)) return;  // held or driven
      const double sign = random_.chance(0.5) ? 1 : -1;
      const std::string name = std::string(sign < 0 ? "-" : "") +
                               std::string(direction_names[static_cast<std::size_t>(direction)]);
      json asked = job;
      asked["load_capacity"] = {{"directions", json::array({name})}, {"stress", limit}};
      d.other = asked;
      const Run done = run(asked);
      if (!answered(done, d)) return;
      const auto& found =
          done.path()[0].load_capacity[static_cast<std::size_t>(direction + (sign < 0 ? 6 : 0))];
      if (!found || found->limit == CapacityLimit::none || !(found->value > 0)) return;
      const bool by_stress = found->limit == CapacityLimit::stress;
      const auto carried = [&](double share) -> std::optional<bool> {
        json loaded = job;
        if (!loaded.contains("loads")) loaded["loads"] = json::array();
        Vector3d force = Vector3d::Zero();
        force[direction] = sign * share * found->value;
        loaded["loads"].push_back(
            {{"name", "put on"}, {"force", json::array({force[0], force[1], force[2]})}});
        const Run one = run(loaded);
        if (!one.ok()) return std::nullopt;
        const PathPoint& p = one.path()[0];
        return p.stable && p.max_stress && p.max_stress->value <= limit;
      };
      d.end = End::kept;
      d.error = 0;
      const auto below = carried(0.97), above = carried(1.03);
      if ((below && !*below) || (above && *above)) {
        d.end = End::broken;
        d.error = 1e3;
        d.what = fmt::format("capacity {} of {:.5g} N by {}{}: at 0.97 of it {}, at 1.03 {}", name,
                             found->value, by_stress ? "stress" : "instability",
                             found->fold ? " (fold)" : "",
                             below ? (*below ? "carried" : "not carried") : "no answer",
                             above ? (*above ? "carried" : "not carried") : "no answer");
      }
    });
  }

  void buckling(json job, const Run& whole) {
    law("buckling", [&](Difference& d) {
      if (!job.contains("loads") || !believed(whole.path().back())) return;
      job = with_stroke(job, json::array({points().back()}));
      json asked = job;
      asked["buckling"] = {{"load", job["loads"][0]["name"]}};
      d.other = asked;
      const Run done = run(asked);
      if (!answered(done, d) || !done.path()[0].buckling) return;
      const CriticalLoad& critical = done.path()[0].buckling->drive_locked;
      if (!critical.factor) return;
      const auto loaded = [&](double share) {
        json other = job;
        for (const char* key : {"force", "moment"})
          if (other["loads"][0].contains(key))
            for (json& x : other["loads"][0][key]) x = x.get<double>() * share * *critical.factor;
        return run(other);
      };
      // the load is there before the stroke, and may lead it to another branch
      const Run slightly = loaded(0.1);
      if (slightly.ok() && far_apart(done.path()[0], slightly.path()[0], 0.5)) {
        d.message = "another branch";
        return;
      }
      const auto stable = [&](double share) -> std::optional<bool> {
        const Run one = loaded(share);
        if (!one.ok()) return std::nullopt;
        return one.path()[0].stable;
      };
      d.end = End::kept;
      const auto below = stable(0.97), above = stable(1.03);
      if ((below && !*below) || (above && *above)) {
        d.end = End::broken;
        d.error = 1e3;
        d.what = fmt::format("factor {:.5g}{}: at 0.97 of it {}, at 1.03 {}", *critical.factor,
                             critical.fold ? " (fold)" : "",
                             below ? (*below ? "stable" : "unstable") : "no answer",
                             above ? (*above ? "stable" : "unstable") : "no answer");
      }
    });
  }

  json job_;
  RandomNumbers random_;
  std::size_t seed_, number_ = 0;
  Laws laws_;
  bool few_ = false;
  Differences found_;
  Tolerance same_leaves_;
  double length_ = 1;
  std::vector<double> stiffest_;  // of each drive
};

}  // namespace

Differences differences_of(const json& job, unsigned long long seed, Laws laws) {
  return Looker(job, seed, laws).look();
}

}  // namespace flexopt
