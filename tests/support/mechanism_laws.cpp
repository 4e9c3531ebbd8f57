#include "support/mechanism_laws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/math/ridders.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/response/path/error_estimate.hpp"
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

// What every number of a mechanism is, and what it is compared with: places with the longest leaf,
// entries of a matrix with its largest.
struct Kind {
  std::string name;
  double scale;
  bool may_jump = false;  ///< a choice: the direction of a wire's width is any across the wire
};

std::vector<Kind> kinds_of(const Mechanism& mechanism) {
  std::vector<Kind> kinds;
  const double length = longest_leaf(mechanism);
  std::size_t first = 0;  // of an item
  const auto begin = [&] { first = kinds.size(); };
  const auto put = [&](const std::string& of, std::size_t count, double scale) {
    for (std::size_t k = 0; k < count; ++k)
      kinds.push_back({fmt::format("{} ({})", of, kinds.size() - first), scale});
  };
  for (const RigidBody& body : mechanism.bodies) {
    begin();
    put(body.name, 3, length);
    put(body.name, 1, body.mass);
    put(body.name, 3, length);
    put(body.name, 9, body.inertia.cwiseAbs().maxCoeff());
    if (!body.box) continue;
    put(body.name, 3, length);
    put(body.name, 9, body.box->half_edges.cwiseAbs().maxCoeff());
  }
  for (const LeafSpring& leaf : mechanism.leaves) {
    begin();
    put(leaf.name, 3, length);
    put(leaf.name, 9, 1);
    if (leaf.section == Section::circular)
      for (std::size_t k = 6; k < 12; ++k) kinds[first + k].may_jump = true;
    for (const double own : {leaf.length, leaf.width, leaf.thickness}) put(leaf.name, 1, own);
    if (leaf.curve) put(leaf.name, 1, 1);
    if (leaf.fold) put(leaf.name, 3, 1);
    put(leaf.name, leaf.width_profile.size() + leaf.thickness_profile.size(), 1);
    each_material_number(leaf.material, [&](auto, double own) { put(leaf.name, 1, own); });
    if (leaf.point) put(leaf.name, 2, 1);
  }
  for (const Joint& joint : mechanism.joints) {
    begin();
    put(joint.name, 3, length);
    put(joint.name, 3, 1);
  }
  for (const Spring& spring : mechanism.springs) {
    begin();
    put(spring.name, 3, length);
    if (spring.matrix) {
      put(spring.name, 36, spring.matrix->cwiseAbs().maxCoeff());
    } else {
      put(spring.name, 3, length);
      put(spring.name, 1, spring.stiffness);
      put(spring.name, 1, spring.free_length);
    }
  }
  begin();
  put("drive", 9 * mechanism.drives.size(), 1);
  return kinds;
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
      worst.add(
          1, 1,
          fmt::format("{}: {}, {:.17g} and {:.17g}", how, kinds_of(a).at(k).name, x[k], y[k]));
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

Deviation derivatives(const RandomDesign& design) {
  Deviation worst;
  const Mechanism mechanism = design.make();
  const std::vector<Kind> kinds = kinds_of(mechanism);
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
      const auto& [name, scale, may_jump] = kinds.at(k);
      if (may_jump && d.error[k] > 1e-3 * scale / p) continue;
      worst.add(rate[k] - d.value[k], std::max(std::abs(rate[k]), scale / p),
                fmt::format("{} along {}: {:.12g} and {:.12g}", name, direction.parameter, rate[k],
                            d.value[k]));
    }
  }
  return worst;
}

}  // namespace flexopt::laws
