#include "support/mechanism_laws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/math/ridders.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/response/accuracy/error_estimate.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/describe.hpp"

namespace flexopt::laws {

using nlohmann::json;

void Deviation::add(double difference, double scale, const std::string& name) {
  const double relative = difference == 0 ? 0 : std::abs(difference) / scale;
  if (std::isfinite(relative) && relative <= size) return;
  size = std::isfinite(relative) ? relative : 1e300;
  what = name;
}

namespace {

std::vector<double> numbers_of(const Mechanism& mechanism) {
  std::vector<double> numbers;
  each_number(mechanism, [&](double x) { numbers.push_back(x); });
  return numbers;
}

// What number k of a mechanism is.
std::string label(const Mechanism& mechanism, std::size_t k) {
  std::string last = "a body";
  std::size_t count = 0;
  const auto entered = [&](const std::string& name, std::size_t numbers) {
    if (k >= count && k < count + numbers) last = fmt::format("{} ({})", name, k - count);
    count += numbers;
  };
  for (const RigidBody& b : mechanism.bodies) entered(b.name, b.box ? 28 : 16);
  for (const LeafSpring& l : mechanism.leaves)
    entered(l.name, 18 + l.width_profile.size() + l.thickness_profile.size() + (l.point ? 2 : 0) +
                        (l.curve ? 1 : 0) + (l.fold ? 3 : 0));
  for (const Joint& j : mechanism.joints) entered(j.name, 6);
  for (const Spring& s : mechanism.springs) entered(s.name, s.matrix ? 39 : 8);
  entered("drive", 9 * mechanism.drives.size());
  return last;
}

std::string names_of(const Mechanism& mechanism) {
  std::string names;
  for (const RigidBody& body : mechanism.bodies) {
    names += body.name + "|";
    for (const bool held : body.held) names += held ? '1' : '0';
  }
  for (const LeafSpring& leaf : mechanism.leaves)
    names += fmt::format("|{} {} {}", leaf.name, leaf.base, leaf.tip);
  for (const Joint& joint : mechanism.joints)
    names += fmt::format("|{} {} {} {}", joint.name, static_cast<int>(joint.type), joint.body,
                         joint.other);
  for (const Spring& spring : mechanism.springs)
    names += fmt::format("|{} {} {}", spring.name, spring.body, spring.other);
  return names;
}

void compare_bits(const Mechanism& a, const Mechanism& b, const std::string& how,
                  Deviation& worst) {
  if (names_of(a) != names_of(b)) worst.add(1, 1, how + ": names");
  const std::vector<double> x = numbers_of(a), y = numbers_of(b);
  for (std::size_t k = 0; k < x.size() && k < y.size(); ++k)
    if (x[k] != y[k])
      worst.add(1, 1, fmt::format("{}: {}, {:.17g} and {:.17g}", how, label(a, k), x[k], y[k]));
  if (x.size() != y.size()) worst.add(1, 1, how + ": how many numbers");
}

}  // namespace

Deviation ways_of_writing(const RandomDesign& design) {
  Deviation worst;
  const Mechanism here = design.make();
  const Material& material = materials().front().material;
  const auto flat =
      expanded(*design.family, design.values, default_choices(*design.family), material);
  const auto flat_family = read_document(json::parse(flat.dump()), design.folder);
  const Mechanism of_flat = flat_family->make({}, {}, material, random_payload());
  compare_bits(here, of_flat, "flat", worst);
  if (expanded(*flat_family, {}, {}, material).dump() != flat.dump())
    worst.add(1, 1, "expanded again");
  const auto written = read_document(without_repeats(design.document), design.folder);
  compare_bits(here,
               written->make(design.values, default_choices(*written), material, random_payload()),
               "without repeats", worst);
  return worst;
}

namespace {

// What every number of a mechanism is compared with: places with the longest leaf, entries of a
// matrix with its largest.
std::vector<double> scales_of(const Mechanism& mechanism) {
  const double length = longest_leaf(mechanism);
  std::vector<double> scales;
  const auto put = [&](std::size_t count, double scale) {
    scales.insert(scales.end(), count, scale);
  };
  for (const RigidBody& body : mechanism.bodies) {
    put(3, length);
    put(1, body.mass);
    put(3, length);
    put(9, body.inertia.cwiseAbs().maxCoeff());
    if (body.box) {
      put(3, length);
      put(9, body.box->half_edges.cwiseAbs().maxCoeff());
    }
  }
  for (const LeafSpring& leaf : mechanism.leaves) {
    put(3, length);
    put(9, 1);
    for (const double own : {leaf.length, leaf.width, leaf.thickness}) put(1, own);
    if (leaf.curve) put(1, 1);
    if (leaf.fold) put(3, 1);
    put(leaf.width_profile.size() + leaf.thickness_profile.size(), 1);
    for (const double own :
         {leaf.material.youngs_modulus, leaf.material.poissons_ratio, leaf.material.density})
      put(1, own);
    if (leaf.point) put(2, 1);
  }
  for (std::size_t k = 0; k < mechanism.joints.size(); ++k) {
    put(3, length);
    put(3, 1);
  }
  for (const Spring& spring : mechanism.springs) {
    put(3, length);
    if (spring.matrix) {
      put(36, spring.matrix->cwiseAbs().maxCoeff());
    } else {
      put(3, length);
      put(1, spring.stiffness);
      put(1, spring.free_length);
    }
  }
  put(9 * mechanism.drives.size(), 1);
  return scales;
}

// Which numbers are a choice that may jump: the direction of a wire's width is any, across the axis
// that the wire is least along.
std::vector<bool> free_choices(const Mechanism& mechanism) {
  std::vector<bool> free;
  for (const RigidBody& body : mechanism.bodies) free.insert(free.end(), body.box ? 28 : 16, false);
  for (const LeafSpring& leaf : mechanism.leaves) {
    const auto first = static_cast<std::ptrdiff_t>(free.size());
    free.insert(free.end(),
                18 + leaf.width_profile.size() + leaf.thickness_profile.size() +
                    (leaf.point ? 2 : 0) + (leaf.curve ? 1 : 0) + (leaf.fold ? 3 : 0),
                false);
    if (leaf.section == Section::circular)
      std::fill(free.begin() + first + 6, free.begin() + first + 12, true);
  }
  std::size_t all = 0;
  each_number(mechanism, [&](double) { ++all; });
  free.resize(all, false);
  return free;
}

}  // namespace

Deviation derivatives(const RandomDesign& design) {
  Deviation worst;
  const Mechanism mechanism = design.make();
  const std::vector<double> scales = scales_of(mechanism);
  const std::vector<bool> free_choice = free_choices(mechanism);
  std::vector<std::string> names;
  for (const Parameter& p : design.family->parameters) names.push_back(p.name);
  const std::vector<MechanismDirection> exact =
      design.family->directions(design.values, default_choices(*design.family),
                                materials().front().material, random_payload(), names);
  for (const MechanismDirection& direction : exact) {
    const double p = design.values.at(direction.parameter);
    const auto at = [&](double x) {
      ParameterValues near = design.values;
      near[direction.parameter] = x;
      return numbers_of(design.make(near));
    };
    // some leaf may cross another at a parameter nearby: then within shorter steps
    std::optional<Derivatives> near;
    for (double step = 2e-3 * p; !near; step /= 4) try {
        near = ridders(at, p, step, 4);
      } catch (const SpecError& error) {
        const bool crosses = std::string(error.what()).find("intersect") != std::string::npos;
        if (!crosses || step < 2e-5 * p) throw;
      }
    const Derivatives& d = *near;
    const std::vector<double> rate = numbers_of(direction.rate);
    for (std::size_t k = 0; k < rate.size(); ++k) {
      if (free_choice[k] && d.error[k] > 1e-3 * scales[k] / p) continue;
      worst.add(rate[k] - d.value[k], std::max(std::abs(rate[k]), scales[k] / p),
                fmt::format("{} along {}: {:.12g} and {:.12g}", label(direction.rate, k),
                            direction.parameter, rate[k], d.value[k]));
    }
  }
  return worst;
}

}  // namespace flexopt::laws
