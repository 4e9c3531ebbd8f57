#include "support/difference_laws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"
#include "optim/job/job.hpp"
#include "support/changed_jobs.hpp"

namespace flexopt {

using nlohmann::json;

namespace {
using End = Difference::End;
}

void Looker::moved(const json& job, const Run& whole, bool all) {
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

double Looker::stiffest() const {
  const Job job = parse_job(job_);
  double most = 0;
  for (const LeafSpring& leaf : make_mechanism(job, job.design.parameters).leaves)
    most = std::max(most, leaf.material.youngs_modulus * leaf.width * leaf.thickness / leaf.length);
  return most;
}

// Whether a drive's stiffness falls by a third along the path, as where a leaf buckles: springs may
// then lead it to its other side.
static bool softens(const Run& run) {
  const auto& path = run.path();
  for (std::size_t k = 0; k < path.front().drive_stiffnesses.size(); ++k) {
    double least = 1e300, most = -1e300;
    for (const PathPoint& p : path)
      if (believed(p)) {
        least = std::min(least, p.drive_stiffnesses[k]);
        most = std::max(most, p.drive_stiffnesses[k]);
      }
    if (least < most - std::abs(most) / 3) return true;
  }
  return false;
}

void Looker::springs_for_held(const json& job, const Run& whole) {
  const auto look = [&](const std::string& name, const json& from, const LawTolerance& allowed) {
    law(name, [&](Difference& d) {
      const double stiffness =
          1e4 * stiffest() + 1e8 * largest_load(whole.record.job, length_) / length_;
      const auto other = with_springs_for_held(from, stiffness, length_);
      if (!other) return;
      d.other = *other;
      Twin twin;
      twin.compliance = false;
      twin.of_acting = twin.of_motion = 1e-5;
      const Run sprung = run(d.other);
      answer(whole, sprung, twin, allowed, d);
      if (d.end != End::broken) return;
      if (softens(whole)) {
        d.end = End::no_answer;
        d.message = "a leaf that buckles may lie to its other side: " + d.what;
        return;
      }
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

bool Looker::same_frequencies(const std::vector<double>& a, const std::vector<double>& b) {
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k)
    if (std::abs(a[k] - b[k]) > 0.01 * std::abs(a[k])) return false;
  return true;
}

void Looker::spring_for_drive(const json& job, const Run& whole) {
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
                 told = here.drive_loads[k] + here.drive_stiffnesses[k] * (went - here.strokes[k]);
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
    if (d.end != End::broken || !softens(whole)) return;
    d.end = End::no_answer;
    d.message = "a leaf that buckles may lie to its other side: " + d.what;
  });
}

void Looker::cut(const json& job, const Run& whole) {
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

void Looker::warm(json job) {
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
      number(0, (p.bodies[i].displacement - expected).norm(), expansion * far, 2e-3,
             "displacement of " + all[i].name + " beside free expansion", d);
      number(0, p.bodies[i].rotation.norm(), expansion, 1e-2, "rotation of " + all[i].name, d);
    }
    if (p.max_stress) number(0, p.max_stress->value, expansion * modulus, 1e-3, "max_stress", d);
  });
}

void Looker::heavy(json job) {
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
        number(list[k], expected[k], expected[k], 2e-3, fmt::format("frequency {} {}", name, k), d);
    }
  });
}

void Looker::state_space(const json& job) {
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
             std::abs(p.frequencies_free[k]), 1e-3, fmt::format("frequency {}", k), d);
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

void Looker::beam_and_plate(const Run& whole) {
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
    twin.of_acting = twin.of_motion = 5e-3;
    const Run as_beam = run(beam);
    for (const PathPoint& p : as_beam.path())
      for (const BodyMotion& body : p.bodies)
        if (body.rotation.norm() > 0.3) return;         // far beyond strokes, where theories differ
    answer(as_beam, run(plate), twin, {0.08, 1e3}, d);  // a beam knows no peaks at clamps
  });
}

void Looker::capacity(json job, const Run& whole) {
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

void Looker::buckling(json job, const Run& whole) {
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

}  // namespace flexopt
