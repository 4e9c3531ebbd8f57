#include "optim/problem/gradient_checker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/response/path/frequency_derivatives.hpp"
#include "core/response/principal_stiffness.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/problem/goals.hpp"
#include "optim/solvers/sampled_rounding.hpp"

namespace flexopt {

namespace {

// The job with one of its numbers changed, possibly to a value that no real body has.
Job moved(const Job& job, const std::string& name, double value) {
  Job other = job;
  if (find_job_number(name))
    set_number(other.design.material, other.end_effector, name, value);
  else
    other.design.parameters[name] = value;
  return other;
}

void add_quantities(const Job& job, StrokeResponse& response,
                    StrokeGradients* gradients = nullptr) {
  add_defined_quantities(job, complete_numbers(job, job.design.parameters), response, gradients);
}

double present(const Job& job, const std::string& name) {
  if (!find_job_number(name)) return job.design.parameters.at(name);
  return numbers_of(job.design.material, job.end_effector).at(name);
}

// Whether a number may not be less than it is: a mass of nothing, a parameter at its least value.
bool at_lower_edge(const Job& job, const std::string& name, double x) {
  if (find_job_number(name))
    return x == 0 && (name == "end_effector.mass" || name == "end_effector.inertia.xx" ||
                      name == "end_effector.inertia.yy" || name == "end_effector.inertia.zz");
  const Parameter* parameter = find_parameter(resolve(job.design)->family(), name);
  return parameter && x <= parameter->min;
}

// What a number that is zero is moved by.
double unit(const Job& job, const std::string& name) {
  if (!find_job_number(name)) {
    const Parameter* parameter = find_parameter(resolve(job.design)->family(), name);
    if (parameter && parameter->unit != "m") return parameter->unit == "kg" ? 1e-2 : 0.1;
  }
  const Mechanism mechanism = make_mechanism(job, job.design.parameters);
  const double length = longest_leaf(mechanism);
  double leaves = 0;  // about their mass
  for (const LeafSpring& l : mechanism.leaves)
    leaves += l.material.density * l.length * l.width * l.thickness;
  if (name.starts_with("end_effector.center_of_mass")) return 0.1 * length;
  if (name.starts_with("end_effector.inertia")) {
    const double mass = std::max(job.end_effector.mass, leaves);
    return std::max(1e-2 * mass * length * length,
                    0.1 * job.end_effector.inertia.diagonal().cwiseAbs().maxCoeff());
  }
  if (name == "end_effector.mass") return 1e-2;
  return 0.1 * length;
}

// What does not agree, or is known less well than this, is differenced again with steps that are
// smaller by these.
constexpr double known_well = 1e-4;
constexpr std::array finer_steps{1e-2, 1e-4};

constexpr const char* screening = "parasitic_frequency_screening";

// At each point, the mode to which the screening frequency belongs; nothing where another mode has
// an equal frequency.
std::vector<std::optional<std::size_t>> screening_modes(const StrokeResponse& response,
                                                        const StrokeRequest& request) {
  std::vector<std::optional<std::size_t>> modes;
  for (const PathPoint& point : response.path) {
    modes.emplace_back();
    const auto to_point = modes_to_point(response, nullptr, point);
    if (!to_point) continue;
    const std::vector<FrequencyDerivatives>& all = *to_point->modes;
    const auto equal = [&](std::size_t a, std::size_t b) {
      return b < all.size() && std::abs(all[a].omega2 - all[b].omega2) < 1e-6 * all[a].omega2;
    };
    const auto found = screening_frequencies(all, request.parasitic, to_point->at);
    if (found.empty()) continue;
    const std::size_t k = found.front().mode;
    if (!equal(k, k + 1) && !equal(k, k - 1)) modes.back() = k;
  }
  return modes;
}

// Whether several directions are the softest: which of them it is changes at this design.
bool is_tied(const PathPoint& point) {
  const std::vector<PrincipalStiffness> all = principal_stiffnesses(point, false);
  return all.size() > 1 && std::abs(all[1].value - all[0].value) <= 1e-6 * std::abs(all[0].value);
}

// Order in which checks of several points are reported: wrong ones first, then those without a
// derivative.
int weight(const GradientCheck& c) {
  return c.quantity.empty() ? 0 : !c.agrees ? 3 : c.equal_stiffnesses ? 2 : 1;
}

}  // namespace

GradientChecker::GradientChecker(const Job& job, std::size_t load_case, double tolerance)
    : job_(job), tolerance_(tolerance) {
  request_ = job.optimise ? request_of_goals(job, make_goals(job), load_case)
                          : cases_of(job)[load_case].request;
  request_.values = PathValues::differentiable;
  request_.outputs.add({Output::equilibrium, Output::stiffness})
      .remove({Output::shapes, Output::stable_states, Output::state_space});
  request_.newton.tolerance = std::min(request_.newton.tolerance, 1e-12);
  // the last of a list may change places with one that is not listed
  listed_ = request_.frequencies;
  if (listed_ > 0) request_.frequencies += 2;
  parameters_ = differentiable_parameters(job);
  through_ = through_formulas(job, job.design.parameters, parameters_);
  const DriveList drives = drives_of(job, make_mechanism(job, job.design.parameters));
  names_ = quantities(drives);
  turns_ = is_rotation(drives.first());
}

Check GradientChecker::prepare() {
  exact_ = stroke_sensitivity(job_, complete_parameters(job_.design, job_.design.parameters),
                              through_.names, job_.model, request_);
  if (exact_.response.status != Status::ok || !exact_.gradients)
    return Because(exact_.gradients ? exact_.response.message : exact_.message);
  add_quantities(job_, exact_.response, &*exact_.gradients);
  screened_ = screening_modes(exact_.response, request_);
  here_ = values(exact_.response);
  const std::string& first = parameters().front();
  try {
    noise_ =
        rounding_of([&](double by) { return values_at(first, present(job_, first) * (1 + by)); });
  } catch (const SpecError& error) {
    return Because(fmt::format("no differences: {}", error.what()));
  }
  for (const PathPoint& point : exact_.response.path)
    stroke_ = std::max(stroke_, request_.loads.driven()
                                    ? std::abs(point.stroke)
                                    : (turns_ ? point.rotation : point.displacement).norm());
  for (const LeafSpring& l : make_mechanism(job_, job_.design.parameters).leaves)
    leaf_length_ = std::max(leaf_length_, l.length);
  // at rest alone: what moves or resists less than in such a stroke is rounding
  if (stroke_ == 0) {
    stroke_ = 1e-3 * (turns_ ? 1.0 : leaf_length_);
    for (const PathPoint& point : exact_.response.path)
      for (const double k : point.drive_stiffnesses)
        load_at_rest_ = std::max(load_at_rest_, std::abs(k) * stroke_);
  }
  largest_.assign(names_.size(), 0.0);
  for (std::size_t i = 0; i < here_.size(); ++i) {
    double& largest = largest_[i % names_.size()];
    largest = std::max(largest, std::abs(here_[i].value_or(0)));
  }
  return {};
}

std::vector<std::string> GradientChecker::without_exact() const {
  std::vector<std::string> names;
  for (std::size_t q = 0; q < names_.size(); ++q) {
    const bool frequency = names_[q].name.starts_with("frequencies.");
    if (frequency && rank_of(names_[q]) >= listed_) continue;
    for (std::size_t k = 0; k < exact_.gradients->path.size(); ++k)
      if (here_[k * names_.size() + q] &&
          !names_[q].gradient(exact_.response.path[k], exact_.gradients->path[k])) {
        names.push_back(names_[q].name);
        break;
      }
  }
  return names;
}

MaybeNumbers GradientChecker::values(const StrokeResponse& response) const {
  MaybeNumbers all;
  for (std::size_t k = 0; k < response.path.size(); ++k) {
    const auto to_point = modes_to_point(response, nullptr, response.path[k]);
    for (const Quantity& q : names_) {
      if (q.name != screening)
        all.push_back(q.value(response.path[k]));
      else if (to_point && screened_[k] && *screened_[k] < to_point->modes->size())
        all.push_back(screening_frequency((*to_point->modes)[*screened_[k]], to_point->at));
      else
        all.push_back(std::nullopt);
    }
  }
  return all;
}

std::vector<double> GradientChecker::values_at(const std::string& parameter, double value) const {
  const Job other = moved(job_, parameter, value);
  StrokeResponse response =
      evaluate_stroke(make_mechanism(other, other.design.parameters), job_.model, request_);
  if (response.status != Status::ok)
    throw SpecError("/design", fmt::format("{} = {:g}", parameter, value), response.message);
  add_quantities(other, response);
  std::vector<double> numbers;
  for (const auto& v : values(response)) numbers.push_back(v.value_or(0));
  return numbers;
}

std::vector<double> GradientChecker::rounding_of_slopes(std::size_t parameter) const {
  const std::string& name = parameters().front();  // a length: other places round otherwise
  return rounding_beside([&](double by) {
    const Job near = moved(job_, name, present(job_, name) * (1 + by));
    StrokeSensitivity exact =
        stroke_sensitivity(near, complete_parameters(near.design, near.design.parameters),
                           through_.names, job_.model, request_);
    std::vector<double> slopes(here_.size(), 0.0);
    if (exact.response.status != Status::ok || !exact.gradients) return slopes;
    add_quantities(near, exact.response, &*exact.gradients);
    const MaybeNumbers found = slopes_along(parameter, exact);
    for (std::size_t i = 0; i < slopes.size(); ++i) slopes[i] = found[i].value_or(0);
    return slopes;
  });
}

MaybeNumbers GradientChecker::slopes_along(std::size_t parameter,
                                           const StrokeSensitivity& exact) const {
  const auto p = static_cast<Eigen::Index>(parameter);
  const Eigen::Index formulas = through_.by.rows() - through_.by.cols();
  const auto along = [&](const VectorXd& by) {  // with the formulas that follow the parameter
    return by[p] + through_.by.col(p).tail(formulas).dot(by.tail(formulas));
  };
  MaybeNumbers slopes;
  for (std::size_t k = 0; k < exact.gradients->path.size(); ++k)
    for (const Quantity& q : names_) {
      const auto g = q.gradient(exact.response.path[k], exact.gradients->path[k]);
      slopes.push_back(g ? std::optional(along(*g)) : std::nullopt);
      // a stress that is nothing but rounding
      const std::size_t i = slopes.size() - 1;
      if ((q.name == "max_stress" || q.name == "notch_stress") &&
          here_[i].value_or(0) < std::max(1e-6 * largest_[i % names_.size()],
                                          1e-12 * job_.design.material.youngs_modulus))
        slopes[i].reset();
    }
  return slopes;
}

// Groups of quantities that may meet within `step`. The slope of each member becomes the slope of
// their mean; what has kinks or is beyond the list gets no slope.
std::vector<FrequencyGroup> GradientChecker::groups_along(double step, MaybeNumbers& slopes) const {
  std::vector<FrequencyGroup> groups;
  for (std::size_t first = 0; first < here_.size(); first += names_.size())
    for (FrequencyGroup& g : groups_of(names_, here_, slopes, first, step)) {
      for (std::size_t q = 0; q < names_.size(); ++q)  // the lowest of a group has kinks
        for (const std::size_t i : g)
          if (names_[q].name == "parasitic_frequency" && here_[i] == here_[first + q])
            slopes[first + q].reset();
      groups.push_back(std::move(g));
    }
  average_slopes(groups, here_, slopes);
  for (const FrequencyGroup& g : groups)
    if (rank_of(names_[g.back() % names_.size()]) + 1 == request_.frequencies)
      for (const std::size_t i : g) slopes[i].reset();
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    const Quantity& q = names_[i % names_.size()];
    if (q.name.starts_with("frequencies.") && rank_of(q) >= listed_) slopes[i].reset();
    if (q.row != &row_of_named_quantities()) continue;
    // a formula, behind its terms, has none where one of these has none or is in a group
    const std::size_t first = i - i % names_.size();
    for (const std::string& term : terms_of(q)) {
      const std::size_t at =
          first + (std::ranges::find(names_, term, &Quantity::name) - names_.begin());
      if (!slopes[at] || std::ranges::any_of(groups, [&](const FrequencyGroup& g) {
            return std::ranges::find(g, at) != g.end();
          }))
        slopes[i].reset();
    }
  }
  return groups;
}

// The quantities of a formula; else the quantity itself.
std::vector<std::string> GradientChecker::terms_of(const Quantity& q) const {
  if (q.row != &row_of_named_quantities()) return {q.name};
  return job_.quantities[static_cast<std::size_t>(q.component)].formula->quantities();
}

// What errors of number i are relative to.
double GradientChecker::size_of(std::size_t i, double x, double difference, double steepest) const {
  const std::size_t q = i % names_.size();
  const double motion = names_[q].row->name == "drive_load" ? load_at_rest_
                        : names_[q].unit == "m"   ? stroke_ * (turns_ ? leaf_length_ : 1.0)
                        : names_[q].unit == "rad" ? stroke_ / (turns_ ? 1.0 : leaf_length_)
                                                  : 0.0;
  const double ratio = !names_[q].row->needs.has(Output::gain) ? 0.0
                       : names_[q].unit == "m/rad"             ? leaf_length_
                       : names_[q].unit == "rad/m"             ? 1 / leaf_length_
                                                               : 1.0;
  const double floor = std::max({1e-2 * largest_[q], 0.1 * motion, 0.1 * ratio});
  return std::max({std::abs(difference), 1e-2 * steepest,
                   0.1 * std::max(std::abs(*here_[i]), floor) / x, 1e-300});
}

GradientCheck GradientChecker::compare(std::size_t i, const std::string& parameter, double slope,
                                       const Derivatives& differences, double size) const {
  GradientCheck c{names_[i % names_.size()].name,
                  parameter,
                  static_cast<int>(i / names_.size()),
                  slope,
                  differences.value[i],
                  std::abs(slope - differences.value[i]) / size,
                  differences.error[i] / size,
                  false};
  c.agrees = c.error <= std::max(tolerance_, 5 * c.known_to);
  const auto accept = [&](double d, double known) {
    c.difference = d;
    c.error = std::abs(c.exact - d) / size;
    c.known_to = known / size;
    c.agrees = true;
  };
  // where a stress peak jumps from leaf to leaf there is a derivative on each side
  const auto one_sided = [&](double d, double known) {
    if (c.agrees || std::abs(d - differences.value[i]) < 20 * known) return;
    if (std::abs(c.exact - d) <= std::max(tolerance_ * size, 5 * known)) accept(d, known);
  };
  one_sided(differences.forward[i], differences.forward_error[i]);
  one_sided(differences.backward[i], differences.backward_error[i]);
  // a size between two points, each as far as another one: its ends may be of different sides;
  // and the smallest of equal stiffnesses has a derivative on each side, and between them those of
  // what does not stay the smallest along all parameters
  bool tied = false, of_sizes = false;
  for (const std::string& term : terms_of(names_[i % names_.size()])) {
    tied |= term == "principal_stiffness" && is_tied(exact_.response.path[c.point]);
    of_sizes |= term.starts_with("envelope");
  }
  if (!c.agrees && (tied || of_sizes)) {
    const auto [low, high] = std::minmax(differences.forward[i], differences.backward[i]);
    const double known = std::max(differences.forward_error[i], differences.backward_error[i]);
    if (c.exact >= low - 5 * known && c.exact <= high + 5 * known) accept(c.exact, known);
  }
  c.equal_stiffnesses = c.agrees && tied &&
                        std::abs(differences.forward[i] - differences.backward[i]) >
                            std::max(tolerance_ * size, 20 * (differences.forward_error[i] +
                                                              differences.backward_error[i]));
  // a material point on a line of the mesh: the second derivative jumps
  if (!c.agrees && std::abs(c.exact - differences.rough[i]) <= 5 * differences.rough_error[i])
    accept(differences.rough[i], differences.rough_error[i]);
  return c;
}

std::vector<GradientCheck> GradientChecker::check(std::size_t parameter) const {
  const std::string& name = parameters()[parameter];
  const double x = present(job_, name), size_of_x = x != 0 ? std::abs(x) : unit(job_, name),
               step = 0.02 * size_of_x;
  MaybeNumbers slopes = slopes_along(parameter, exact_);
  const std::vector<FrequencyGroup> groups = groups_along(step, slopes);
  const bool at_edge = at_lower_edge(job_, name, x);
  const auto differences_of = [&](double h, const std::vector<double>& noise) {
    return ridders(
        [&](double value) {
          std::vector<double> numbers = values_at(name, value);
          average_values(groups, numbers);
          return numbers;
        },
        x, h, 5, noise, at_edge);
  };
  const Derivatives differences = differences_of(step, noise_);
  // where a kink, a pole or a nearly equal frequency lies within the first steps
  std::array<std::optional<Derivatives>, finer_steps.size()> finer;
  // where they do not agree, what the rounding along this very parameter leaves open
  std::optional<Derivatives> rounded;
  std::vector<double> slope_noise;
  std::vector<GradientCheck> worst(names_.size());
  for (std::size_t q = 0; q < names_.size(); ++q) {
    double steepest = 0;
    for (std::size_t i = q; i < here_.size(); i += names_.size())
      steepest = std::max(steepest, std::abs(differences.value[i]));
    for (std::size_t i = q; i < here_.size(); i += names_.size()) {
      if (!slopes[i] || !here_[i]) continue;
      GradientCheck c = compare(i, name, *slopes[i], differences,
                                size_of(i, size_of_x, differences.value[i], steepest));
      for (std::size_t f = 0; f < finer.size(); ++f) {
        if (c.agrees && c.known_to <= known_well) break;
        if (!finer[f]) finer[f] = differences_of(finer_steps[f] * step, noise_);
        const double slope = finer[f]->value[i];
        const GradientCheck again =
            compare(i, name, *slopes[i], *finer[f], size_of(i, size_of_x, slope, std::abs(slope)));
        const bool settled = again.agrees && again.known_to <= known_well;
        if (settled || again.known_to < c.known_to) c = again;
      }
      if (!c.agrees) {
        if (!rounded) {
          std::vector<double> noise =
              rounding_beside([&](double by) { return values_at(name, x * (1 + by)); });
          for (std::size_t n = 0; n < noise.size(); ++n) noise[n] = std::max(noise[n], noise_[n]);
          rounded = differences_of(step, noise);
          slope_noise = rounding_of_slopes(parameter);
        }
        const double size = size_of(i, size_of_x, rounded->value[i], steepest);
        GradientCheck again = compare(i, name, *slopes[i], *rounded, size);
        again.known_to += slope_noise[i] / size;
        again.agrees |= again.error <= std::max(tolerance_, 5 * again.known_to);
        if (again.agrees && again.known_to <= known_well) c = again;
      }
      GradientCheck& most = worst[q];
      if (weight(c) > weight(most) || (weight(c) == weight(most) && c.error > most.error)) most = c;
    }
  }
  return worst;
}

}  // namespace flexopt
