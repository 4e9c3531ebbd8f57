#include "support/compared_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>

#include "core/response/quantities.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job.hpp"
#include "support/random_jobs.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

using End = Difference::End;

double processor_time() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

}  // namespace

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

double largest_load(const Job& job, double length) {
  double largest = 0;
  for (const DeadLoad& load : job.request.loads.constant)
    largest = std::max({largest, load.force.norm(), load.moment.norm() / length});
  return largest;
}

namespace {

class SideBySide {
 public:
  SideBySide(const Run& one, const Run& other, const Twin& twin, const LawTolerance& allowed)
      : one_(one),
        other_(other),
        twin_(twin),
        allowed_(allowed),
        length_(length_of(one.record.mechanism)),
        all_(quantities(DriveList(one.record.mechanism))) {
    for (const LeafSpring& leaf : one.record.mechanism.leaves) {
      const double E = leaf.material.youngs_modulus;
      modulus_ = std::max(modulus_, E);
      rounding_ = std::max(rounding_, of_force * E * leaf.width * leaf.thickness);
    }
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

  // Finds the largest value of each row along the path, and of loads what makes a twentieth of
  // the largest work.
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
      known_.push_back((of_newton + twin_.of_motion * motion_) * unit * stiffest +
                       (twin_.of_acting * acting + rounding_) * (turns ? length_ : 1));
    }
  }

  // Stiffnesses of drives that have all but vanished are rounding, and so is what they let go.
  bool is_balanced(const PathPoint& point) const {
    for (std::size_t k = 0; k < stiffest_.size(); ++k)
      if (std::abs(point.drive_stiffnesses[k]) < 1e-2 * stiffest_[k]) return true;
    return false;
  }

  double scale_of(const Quantity& q, double value, const PathPoint& point) const {
    double here = std::abs(value);
    const double most = largest_.contains(q.name) ? largest_.at(q.name) : 0;
    switch (q.row->error) {
      case ErrorKind::load:
        return std::max({most, load_[static_cast<std::size_t>(q.component)],
                         known_[static_cast<std::size_t>(q.component)] / allowed_.number});
      case ErrorKind::stress:
        return std::max({here, 0.2 * most, 3 * of_newton * modulus_ / allowed_.stress});
      case ErrorKind::frequency:
        // of a motion that is all but free Newton's tolerance of the next stiffness is left
        for (const auto* list : {&point.frequencies_free, &point.frequencies_locked})
          for (std::size_t k = 0; k + 1 < list->size(); ++k)
            if ((*list)[k] == value)
              here = std::max(here, of_newton * std::pow((*list)[k + 1], 2) /
                                        std::max(std::abs(value), 1e-300) / allowed_.number);
        [[fallthrough]];
      default:
        return std::max(
            here,
            (q.row->of_drives && (!twin_.drives_free || is_balanced(point)) ? 1 : 0.1) * most);
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
      add(*x, there, scale_of(q, *x, a),
          kind == ErrorKind::stress ? allowed_.stress : allowed_.number, q.name);
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
          std::max({motion_ * length_, u.norm(), of_place * length_ / allowed_.number}),
          allowed_.number, "displacement of " + name);
      add(r.norm(), r.norm() + (r - s).norm(),
          std::max({motion_, r.norm(), of_place / allowed_.number}), allowed_.number,
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
    if (twin_.drives_free && !is_balanced(a) && !one_.record.mechanism.drives.empty())
      compare(a.compliance_free, b.compliance_free, "free");
  }

  const Run &one_, &other_;
  const Twin& twin_;
  const LawTolerance allowed_;
  double length_, modulus_ = 0, rounding_ = 0, motion_ = 0, worst_ = 0;
  std::vector<Quantity> all_;
  std::map<std::string, double> largest_;
  // of each drive: largest stroke, load that counts, load that is known, largest stiffness
  std::vector<double> stroke_, load_, known_, stiffest_;
  std::size_t at_ = 0;
  std::string what_;
};

}  // namespace

void compare(const Run& one, const Run& other, const Twin& twin, const LawTolerance& allowed,
             Difference& found) {
  SideBySide(one, other, twin, allowed).write(found);
}

}  // namespace flexopt
