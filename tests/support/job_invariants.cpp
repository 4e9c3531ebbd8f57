#include "support/job_invariants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "core/math/decompositions.hpp"
#include "core/math/work_limit.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/path/branch.hpp"
#include "core/response/path/error_estimate.hpp"
#include "core/response/quantities.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job.hpp"
#include "support/mirrored_mechanism.hpp"
#include "support/one_stroke.hpp"
#include "support/random_jobs.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

constexpr double limit = 1e-6;
// The nearest places of two leaves are sought from samples: rounding may choose another sample.
constexpr double limit_of_clearance = 0.05;

void check_numbers(const PathPoint& point, const std::vector<Quantity>& all, JobVerdict& verdict) {
  for (const Quantity& quantity : all)
    if (const auto value = quantity.value(point); value && !std::isfinite(*value))
      verdict.broken.push_back(
          fmt::format("{} = {} at stroke {:.6g}", quantity.name, *value, point.stroke));
  for (const auto* list : {&point.frequencies_free, &point.frequencies_locked}) {
    for (const double f : *list)
      if (!std::isfinite(f)) verdict.broken.push_back(fmt::format("a frequency is {}", f));
    if (!std::ranges::is_sorted(*list)) verdict.broken.emplace_back("frequencies do not ascend");
  }
  for (const BodyMotion& body : point.bodies)
    if (!body.displacement.allFinite() || !body.rotation.allFinite())
      verdict.broken.emplace_back("a body is nowhere");
}

// With the drives held a stable mechanism gives way to no load against it.
void check_compliance(const PathPoint& point, double length, JobVerdict& verdict) {
  Eigen::Matrix<double, 6, 1> unit = Eigen::Matrix<double, 6, 1>::Ones();
  unit.head<3>().setConstant(1 / length);
  for (const Matrix6d* C : {&point.compliance_locked, &point.compliance_free}) {
    const Matrix6d plain = unit.asDiagonal() * *C * unit.asDiagonal();
    const double size = plain.cwiseAbs().maxCoeff();
    if (!plain.allFinite()) {
      verdict.broken.emplace_back("a compliance is not finite");
      continue;
    }
    if ((plain - plain.transpose()).cwiseAbs().maxCoeff() > limit * size)
      verdict.broken.push_back(fmt::format("asymmetric compliance at {:.6g}", point.stroke));
    if (C == &point.compliance_free || !point.stable || size == 0) continue;
    const double least = symmetric_eigenvalues(plain).minCoeff();
    if (least < -limit * size)
      verdict.broken.push_back(
          fmt::format("stable at {:.6g} with a compliance of {:.2e} of the "
                      "largest",
                      point.stroke, least / size));
  }
  if (point.stable && !point.frequencies_locked.empty() &&
      point.frequencies_locked.front() < -limit * std::abs(point.frequencies_locked.back()))
    verdict.broken.push_back(fmt::format("stable at {:.6g} with a frequency of {:.3g} Hz",
                                         point.stroke, point.frequencies_locked.front()));
}

// Kronrod's rule of seven points on [-1, 1], its half, and Gauss's of three of them.
constexpr std::array<std::array<double, 3>, 4> kronrod{
    {{0.9604912687080203, 0.1046562260264673, 0},
     {0.7745966692414834, 0.2684880898683334, 5.0 / 9},
     {0.4342437493468026, 0.4013974147759622, 0},
     {0, 0.4509165386584741, 8.0 / 9}}};

// The energy of bending is that of the places of the nodes: the rigid part of these cancels, which
// leaves some eps (L/h)³ of the bending stiffness D.
double rounding_of_energy(const Mechanism& mechanism) {
  constexpr double left = 1e-10;
  double sum = 0;
  for (const LeafSpring& leaf : mechanism.leaves) {
    double thickness = leaf.thickness;
    if (!leaf.thickness_profile.empty())
      thickness *= *std::ranges::max_element(leaf.thickness_profile);
    sum += left * leaf.material.youngs_modulus * std::pow(thickness, 3);
  }
  return sum;
}

// From 0.9 to 1 of a point's stroke: work of the drive against the change of stored energy and
// potential of the loads, on full leaves where the point has them. Nothing where the drive's load
// does other work, or the way is not smooth.
std::optional<double> energy_error(const Job& job, const Mechanism& mechanism,
                                   const PathPoint& far) {
  const double stroke = far.stroke;
  const auto& request = job.request;
  if (mechanism.drives.size() != 1 || !request.loads.driven() || stroke == 0) return std::nullopt;
  auto leaves = job.model.accuracy == Accuracy::full
                    ? make_full_leaves(mechanism, job.model)
                    : make_reduced_leaves(mechanism, job.model, std::abs(stroke), request.loads);
  System system(mechanism, std::move(leaves), request.loads);
  for (int i = 0; i < system.leaves(); ++i)
    if (far.leaves.at(static_cast<std::size_t>(i)).model == "full" && !system.leaf(i).is_full())
      system.replace_leaf(i, system.leaf(i).full_model("as on the path"));
  const NewtonOptions& newton = request.newton;
  if (system.loaded_at_rest() && !mount(system, newton).converged) return std::nullopt;
  // with bent states as on the path: beyond the last one rounding grows with a high power
  constexpr int most_refinements = 12;
  for (int round = 0; round < most_refinements; ++round)
    if (!step_to(system, stroke, newton).converged || !refine_leaves(system)) break;
  struct At {
    double potential, load;
    bool smooth;
  };
  const auto at = [&](double share) {
    const Equilibrium e = step_to(system, share * stroke, newton);
    const JointBody& pose = system.pose(mechanism.drives[0].body);
    bool pure = true;  // a rotation about another axis is no turn by the stroke
    if (const int d = index(mechanism.drives[0].direction); d >= 3)
      for (int k = 0; k < 3; ++k)
        pure = pure && (k == d - 3 || std::abs(pose.rotation(k, d - 3)) < 1e-12);
    return At{system.energy() + system.load_energy(), e.drive_load,
              e.converged && e.sub_steps == 1 && pure};
  };
  if (!at(0.5).smooth && !at(0.9).smooth) return std::nullopt;
  const At first = at(0.9);
  if (!first.smooth) return std::nullopt;
  // by more and more panels, until the rule of fewer points says the same
  constexpr int most_panels = 64;
  double work = 0, turnover = 0, coarse = 0;
  for (int panels = 1;; panels *= 2) {
    work = turnover = coarse = 0;
    for (int panel = 0; panel < panels; ++panel)
      for (int i = -3; i <= 3; ++i) {
        const auto& [place, weight, of_three] = kronrod[static_cast<std::size_t>(3 - std::abs(i))];
        const At here = at(0.9 + 0.1 * (panel + 0.5 + (i < 0 ? -0.5 : 0.5) * place) / panels);
        if (!here.smooth) return std::nullopt;
        const double whole = 0.5 * here.load * 0.1 * stroke / panels;
        work += weight * whole;
        coarse += of_three * whole;
        turnover += weight * std::abs(whole);
      }
    if (std::abs(work - coarse) <= 0.1 * limit * turnover) break;
    if (panels == most_panels) return std::nullopt;
    at(0.9);
  }
  const At last = at(1);
  if (!last.smooth) return std::nullopt;
  const double stored = last.potential - first.potential;
  const double rounding = 1e-10 * (std::abs(last.potential) + std::abs(system.energy())) +
                          rounding_of_energy(mechanism);
  return std::max(0.0, std::abs(work - stored) - rounding) /
         std::max(std::max(turnover, std::abs(stored)), 1e-300);
}

void check_energy(const Job& job, const Mechanism& mechanism, const StrokeResponse& response,
                  JobVerdict& verdict) {
  double furthest = 0;
  for (const PathPoint& point : response.path)
    furthest = std::max(furthest, std::abs(point.stroke));
  const PathPoint* far = nullptr;
  for (const PathPoint& point : response.path)
    if (point.status == PointStatus::converged && point.stable &&
        (!far || std::abs(point.stroke) > std::abs(far->stroke)))
      far = &point;
  if (!far || std::abs(far->stroke) < 1e-3 * furthest) return;
  const std::optional<double> error = energy_error(job, mechanism, *far);
  if (!error) return;
  verdict.energy_checked = true;
  verdict.energy_error = *error;
  if (!(*error <= limit))
    verdict.broken.push_back(
        fmt::format("work and energy differ by {:.2e} up to stroke {:.6g}", *error, far->stroke));
}

// The largest value of each row along the path: what is next to nothing beside it is rounding. All
// motions are measured by the largest of them.
std::map<std::string, double> sizes_of(const StrokeResponse& response,
                                       const std::vector<Quantity>& all, double length) {
  std::map<std::string, double> largest;
  double motion = 0;  // over the length of a leaf
  for (const PathPoint& point : response.path)
    if (point.status == PointStatus::converged)
      motion = std::max({motion, point.displacement.norm() / length, point.rotation.norm()});
  for (const Quantity& q : all) {
    double& size = largest[q.row->name];
    if (q.row->error == ErrorKind::motion) size = q.unit == "m" ? motion * length : motion;
    if (q.row->needs.has(Output::gain)) size = std::max({size, 1.0, length, 1 / length});
    for (const PathPoint& point : response.path)
      if (const auto value = q.value(point)) size = std::max(size, std::abs(*value));
  }
  // the place of a drive is known to some 1e-13
  for (const Quantity& q : all)
    if (q.row->name == "drive_load") {
      const double known = 1e-13 * (q.unit == "N" ? length : 1) * largest["drive_stiffness"];
      largest["drive_load"] = std::max(largest["drive_load"], known / limit);
    }
  return largest;
}

// The series of frequencies from rest, where the frequency itself tells that it does not hold any
// more: its powers of the stroke make any number of it.
bool out_of_range(const Quantity& quantity, const PathPoint& point) {
  constexpr double holds = 0.1;
  if (quantity.name != "parasitic_frequency_screening" || !point.parasitic_frequency) return false;
  const auto value = quantity.value(point);
  return value && !(std::abs(*value / *point.parasitic_frequency - 1) <= holds);
}

// Another way to the same answer, but for the signs that a mirror reverses.
struct Twin {
  const char* name;   // of what is done to the mechanism
  double growth = 1;  // lengths and times double, masses are eight times as large
  bool mirror = false;
};

// Of all numbers of the stable points: rounding may lead to another state beside an unstable one.
struct Difference {
  std::string quantity;
  double size;  // infinite: there or not, or a point that ends otherwise
  std::string words;
};
struct Differences {
  double worst = 0;                // of numbers
  std::vector<Difference> beyond;  // the limit
  std::vector<std::string> modelled_otherwise;
};
constexpr double infinite = std::numeric_limits<double>::infinity();
// Where Newton's method fails with reduced leaves on the way, full ones take over from there:
// rounding may decide whether it does.
bool modelled_alike(const PathPoint& a, const PathPoint& b) {
  const auto gave_up = [](const PathPoint& point) {
    return std::ranges::any_of(point.leaves, [](const LeafReport& leaf) {
      return leaf.reason.starts_with("no equilibrium");
    });
  };
  return gave_up(a) == gave_up(b);
}
Differences differences(const StrokeResponse& one, const StrokeResponse& other, const Twin& twin,
                        const std::vector<Quantity>& all, double length, double allowed = limit) {
  Differences found;
  const auto largest = sizes_of(one, all, length);
  double motion = 0;  // over the length of a leaf
  for (const PathPoint& point : one.path)
    motion = std::max({motion, point.displacement.norm() / length, point.rotation.norm()});
  const bool moves = motion > 1e-9;
  const auto is_rounding = [&](ErrorKind kind) {  // of a mechanism that stays at rest
    return !moves &&
           (kind == ErrorKind::load || kind == ErrorKind::motion || kind == ErrorKind::stress);
  };
  const auto plain = [&](double value) { return twin.mirror ? std::abs(value) : value; };
  // a point that ends otherwise takes the envelope of all points with it
  for (std::size_t k = 0; k < one.path.size(); ++k)
    if (const PathPoint& a = one.path[k], &b = other.path[k]; a.status != b.status) {
      found.beyond.push_back({fmt::format("end of point {}", k), infinite,
                              fmt::format("{} point {} ends otherwise: \"{}\" and \"{}\"",
                                          twin.name, k, a.message, b.message)});
      return found;
    }
  for (std::size_t k = 0; k < one.path.size(); ++k) {
    const PathPoint &a = one.path[k], &b = other.path[k];
    if (a.status != PointStatus::converged || !a.stable || !b.stable) continue;
    if (!modelled_alike(a, b)) {
      found.modelled_otherwise.push_back(
          fmt::format("{} point {} has full leaves in the place of reduced ones", twin.name, k));
      continue;
    }
    for (const Quantity& q : all) {
      const auto small = q.value(a), big = q.value(b);
      if (small.has_value() != big.has_value()) {
        found.beyond.push_back(
            {q.name, infinite, fmt::format("{} {} is there or not", twin.name, q.name)});
        continue;
      }
      const double size = largest.at(q.row->name);
      if (!small || size == 0 || is_rounding(q.row->error) || out_of_range(q, a)) continue;
      const double error =
          std::abs(plain(*big / growth_of(q.unit, twin.growth)) - plain(*small)) / size;
      const bool sought = q.name == "clearance";
      if (!sought) found.worst = std::max(found.worst, error);
      if (!(error <= (sought ? limit_of_clearance : allowed)))
        found.beyond.push_back(
            {q.name, error,
             fmt::format("{} {} differs by {:.2e} at point {}", twin.name, q.name, error, k)});
    }
  }
  return found;
}

StrokeResponse evaluate(const Job& job, Accuracy accuracy, bool mirror = false) {
  const Mechanism mechanism = make_mechanism(job, job.design.parameters);
  ModelOptions model = job.model;
  model.accuracy = accuracy;
  if (!mirror) return evaluate_stroke(mechanism, model, job.request);
  // the sides of the stroke are gone along in the same order
  const int normal = mirror_of_stroke(mechanism);
  return evaluate_stroke(mirrored(mechanism, normal), model,
                         mirrored(job.request, mechanism, normal));
}

std::optional<Job> grown(const json& document, double factor) {
  try {
    return parse_job(scaled_job(document, factor));
  } catch (const SpecError&) {
    return std::nullopt;  // there are largest and smallest lengths
  }
}

// How far each quantity moves where all sizes grow by some 1e-13: what its rounding is multiplied
// by. Thin leaves, nearly equal modes and series beyond their range make it large. Steps of
// Newton's method that are thrown about multiply it by any number: then it decides whether a point
// is found, perhaps in one of twenty such sizes: for what is there or not more of them are looked
// at.
class Rounding {
 public:
  Rounding(const json& document, const StrokeResponse& exact, const std::vector<Quantity>& all,
           double length, Accuracy accuracy)
      : document_(&document), exact_(&exact), all_(&all), length_(length), accuracy_(accuracy) {
    for (int i = 1; i <= few; ++i) look_at(i);
  }

  double of(const Difference& difference) {
    for (; std::isinf(difference.size) && looked_at_ < many && !moves_[difference.quantity];)
      look_at(looked_at_ + 1);
    return moves_[difference.quantity];
  }

 private:
  static constexpr int few = 4, many = 40;
  // Sizes that grow and shrink by steps of 2^-43.
  void look_at(int i) {
    looked_at_ = i;
    const double change = (i % 2 ? 0x1p-43 : -0x1p-43) * ((i + 1) / 2);
    const auto beside = grown(*document_, 1 + change);
    if (!beside) return;
    const StrokeResponse other = evaluate(*beside, accuracy_);
    if (other.path.size() != exact_->path.size()) return;
    for (const Difference& d :
         differences(*exact_, other, {"", 1 + change}, *all_, length_, 0).beyond)
      moves_[d.quantity] = std::max(moves_[d.quantity], d.size);
  }

  const json* document_;
  const StrokeResponse* exact_;
  const std::vector<Quantity>* all_;
  double length_;
  Accuracy accuracy_;
  int looked_at_ = 0;
  std::map<std::string, double> moves_;
};

// Differences of twins that rounding does not explain.
void judge(const json& document, const StrokeResponse& exact, const Differences& found,
           const std::vector<Quantity>& all, double length, Accuracy accuracy,
           JobVerdict& verdict) {
  constexpr double of_rounding = 10;
  if (found.beyond.empty()) return;
  Rounding rounding(document, exact, all, length, accuracy);
  for (const Difference& d : found.beyond) {
    const double left = rounding.of(d);
    if (d.size <= of_rounding * left)
      verdict.rounded.push_back(
          std::isinf(d.size) ? fmt::format("{}, as rounding decides", d.words)
                             : fmt::format("{}, of which rounding makes {:.1e}", d.words, left));
    else
      verdict.broken.push_back(d.words);
  }
}

// The same mechanism larger, and its mirror image.
void check_twins(const json& document, const Job& job, const StrokeResponse& response,
                 const std::vector<Quantity>& all, double length, JobVerdict& verdict) {
  const auto ended = [](const StrokeResponse& r) { return r.status == Status::limit_reached; };
  if (ended(response)) return;
  auto four = grown(document, 4);
  const Twin as_modelled{"four times as large", four ? 4.0 : 0.25};
  if (!four) four = grown(document, as_modelled.growth);
  if (four)
    if (const StrokeResponse other = evaluate(*four, job.model.accuracy); !ended(other)) {
      verdict.scale_checked = true;
      const Differences found = differences(response, other, as_modelled, all, length);
      verdict.scale_error = found.worst;
      verdict.rounded = found.modelled_otherwise;
      judge(document, response, found, all, length, job.model.accuracy, verdict);
    }
  const bool full = job.model.accuracy == Accuracy::full;
  const StrokeResponse exact = full ? response : evaluate(job, Accuracy::full);
  const StrokeResponse image = evaluate(job, Accuracy::full, true);
  if (ended(exact) || ended(image)) return;
  verdict.full_checked = true;
  const auto compare = [&](const StrokeResponse& other, const Twin& twin) {
    const Differences found = differences(exact, other, twin, all, length);
    judge(document, exact, found, all, length, Accuracy::full, verdict);
    return found.worst;
  };
  verdict.mirror_error = compare(image, {"mirrored", 1, true});
  const auto twice = grown(document, 2);
  if (!twice) return;
  const StrokeResponse large = evaluate(*twice, Accuracy::full);
  if (ended(large)) return;
  verdict.twice_error = compare(large, {"twice as large", 2});
}

}  // namespace

JobVerdict verdict_of(const json& document) {
  JobVerdict verdict;
  std::optional<Job> job;
  try {
    job = parse_job(document);
  } catch (const SpecError& error) {
    verdict.message = error.what();
    if (verdict.message.empty()) verdict.broken.emplace_back("refused without a word");
    return verdict;
  }
  const Mechanism mechanism = make_mechanism(*job, job->design.parameters);
  const StrokeResponse response = evaluate_stroke(mechanism, job->model, job->request);
  verdict.end = response.status == Status::ok              ? JobVerdict::End::ok
                : response.status == Status::limit_reached ? JobVerdict::End::limit_reached
                                                           : JobVerdict::End::no_equilibrium;
  verdict.message = response.message;
  const std::vector<Quantity> all = quantities(DriveList(mechanism));
  const double length = longest_leaf(mechanism);
  for (const PathPoint& point : response.path) {
    ++verdict.points;
    if (point.status != PointStatus::converged) {
      if (point.message.empty() && response.message.empty())
        verdict.broken.emplace_back("no answer, and no word why");
      continue;
    }
    ++verdict.converged;
    verdict.stable += point.stable;
    check_numbers(point, all, verdict);
    check_compliance(point, length, verdict);
  }
  if (verdict.converged > 0) check_energy(*job, mechanism, response, verdict);
  check_twins(document, *job, response, all, length, verdict);
  return verdict;
}

}  // namespace flexopt
