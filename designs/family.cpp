#include "designs/family.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "core/math/dual.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/clamped_plate.hpp"
#include "designs/cross_hinge.hpp"
#include "designs/leaf_spring.hpp"
#include "designs/parallel_guide.hpp"

namespace flexopt {

template MechanismT<double> make_leaf_spring(const LeafSpringParameters<double>&, const Material&,
                                             const EndEffector&, Tip);
template MechanismT<double> make_clamped_plate(const ClampedPlateParameters<double>&,
                                               const Material&, const EndEffector&);
template MechanismT<double> make_parallel_guide(const ParallelGuideParameters<double>&,
                                                const Material&, const EndEffector&);
template MechanismT<double> make_cross_hinge(const CrossHingeParameters<double>&, const Material&,
                                             const EndEffector&);
template MechanismT<double> make_three_flexure_cross_hinge(
    const ThreeFlexureCrossHingeParameters<double>&, const Material&, const EndEffector&);

namespace {

constexpr double largest_size = 20;  // [m]; above it millimetres were meant

Parameter size(std::string name, std::string meaning, double max = largest_size) {
  Parameter p;
  p.name = std::move(name);
  p.unit = "m";
  p.max = max;
  p.open_min = true;
  p.meaning = std::move(meaning);
  return p;
}

Parameter length() { return size("length", "length of a leaf, from clamped edge to clamped edge"); }
Parameter width() { return size("width", "width of a leaf, along z"); }
Parameter thickness() { return size("thickness", "thickness of a leaf", 1.0); }

Parameter half_angle() {
  Parameter p{.name = "half_angle", .unit = "rad", .standard = std::numbers::pi / 4};
  p.max = std::numbers::pi / 2;
  p.open_min = p.open_max = true;
  p.meaning = "angle between a leaf and x";
  return p;
}

Parameter crossing_fraction() {
  Parameter p{.name = "crossing_fraction", .unit = "1", .standard = 0.5};
  p.min = -5;
  p.max = 6;
  p.meaning =
      "part of a leaf's length between base and rotation axis; outside 0..1 the axis is virtual";
  return p;
}

Parameter gap() {
  Parameter p{.name = "gap", .unit = "m"};
  p.min = -largest_size;
  p.max = largest_size;
  p.meaning =
      "clearance along z between neighbouring leaves; negative only where they do not cross";
  return p;
}

std::string pointer_to(const std::string& parameter) { return "/design/parameters/" + parameter; }

/// A leaf is thinner than long and wide; a wire has one diameter.
void check_thin(const LeafSpring& leaf, const ParameterValues& values) {
  const bool wire = leaf.section == Section::circular;
  if (wire && std::abs(leaf.width - leaf.thickness) > 1e-9 * leaf.thickness)
    throw SpecError(pointer_to("width"), fmt::format("{:g} m", leaf.width),
                    fmt::format("a circular section has one diameter: leave the width out or give "
                                "the thickness, {:g} m",
                                leaf.thickness));
  const double smallest = wire ? leaf.length : std::min(leaf.length, leaf.width);
  if (leaf.thickness >= smallest)
    throw SpecError(pointer_to("thickness"), fmt::format("{:g} m", values.at("thickness")),
                    fmt::format("a leaf is thinner than long and wide: thickness < {:g} m ({})",
                                smallest, leaf.name));
}

/// Sets `make` and `directions` from one function of any scalar: (parameters, material, payload,
/// choices) → mechanism. `apart` is the parameter that keeps the leaves apart.
template <template <class> class Parameters, class Make>
void set_makers(Family& family, Make make, std::string apart) {
  family.make = [make, apart = std::move(apart)](
                    const ParameterValues& values, const FamilyChoices& choices,
                    const Material& material, const EndEffector& payload) {
    Parameters<double> parameters{};
    parameters.each([&](const char* name, double& value) { value = values.at(name); });
    Mechanism mechanism = make(parameters, material, payload, choices);
    const auto section = choices.find("section");
    if (section != choices.end() && section->second == "circular")
      for (LeafSpring& leaf : mechanism.leaves) leaf.section = Section::circular;
    for (const LeafSpring& leaf : mechanism.leaves) check_thin(leaf, values);
    if (const auto rule = broken_rule(mechanism))
      throw SpecError(pointer_to(apart), fmt::format("{:g} m", values.at(apart)), *rule);
    return mechanism;
  };
  // One direction after the other: what nobody wants costs nothing, and there may be any number.
  family.directions = [make](const ParameterValues& values, const FamilyChoices& choices,
                             const Material& material, const EndEffector& payload,
                             const std::vector<std::string>& wanted) {
    const auto constant = with_numbers<Dual1>(material, [](double x) { return Dual1(x); });
    std::vector<MechanismDirection> directions;
    for (const std::string& along : wanted) {
      Parameters<Dual1> parameters{};
      bool known = false;
      parameters.each([&](const char* name, Dual1& value) {
        const bool moves = along == name;
        known = known || moves;
        value = moves ? Dual1::variable(values.at(name), 0) : Dual1(values.at(name));
      });
      if (!known) throw std::invalid_argument("no parameter of the family: " + along);
      directions.push_back(
          {along, with_numbers<double>(make(parameters, constant, payload, choices),
                                       [](const Dual1& x) { return x.derivatives[0]; })});
    }
    return directions;
  };
}

Family leaf_spring() {
  Family f;
  f.name = "leaf_spring";
  f.summary = "One leaf spring, clamped at its base, with a rigid tip.";
  f.drawing = R"(
    y
    |  //|========================[#] O        thickness along y
    |  //|<------- length ------->             width along z
    +---- x
)";
  f.drive = Direction::uy;
  f.parameters = {length(), width(), thickness()};
  f.options = {
      {"tip",
       {"rigid", "free", "guided", "hinged"},
       {},
       "rigid: the edge is part of the end-effector; guided: and that moves along x and y "
       "only; hinged: the same with a hinge about z between edge and end-effector; free: O is the "
       "middle of the free edge, its load spread over it"},
      {"section",
       {"rectangular", "circular"},
       {},
       "cross-section; circular: a wire whose diameter is the thickness, for beams"}};
  f.has_end_effector = [](const FamilyChoices& choices) { return choices.at("tip") != "free"; };
  set_makers<LeafSpringParameters>(
      f,
      []<class S>(const LeafSpringParameters<S>& p, const MaterialT<S>& material,
                  const EndEffector& payload, const FamilyChoices& choices) {
        const std::string& tip = choices.at("tip");
        return make_leaf_spring<S>(p, material, payload,
                                   tip == "free"     ? Tip::free
                                   : tip == "guided" ? Tip::guided
                                   : tip == "hinged" ? Tip::hinged
                                                     : Tip::rigid);
      },
      "length");
  return f;
}

Family parallel_guide() {
  Family f;
  f.name = "parallel_guide";
  f.summary = "Two parallel leaf springs that guide the end-effector along y.";
  f.drawing = R"(
    y    //|========================|#|
    |    //|         ^              |#|
    |    //|      spacing           |#| O      width along z
    |    //|         v              |#|
    |    //|========================|#|
    +---- x |<------- length ------->|
)";
  f.drive = Direction::uy;
  f.parameters = {length(), width(), thickness(),
                  size("spacing", "distance between the mid-planes of the leaves")};
  set_makers<ParallelGuideParameters>(
      f,
      []<class S>(const ParallelGuideParameters<S>& p, const MaterialT<S>& material,
                  const EndEffector& payload,
                  const FamilyChoices&) { return make_parallel_guide<S>(p, material, payload); },
      "spacing");
  return f;
}

Family cross_hinge() {
  Family f;
  f.name = "cross_hinge";
  f.summary = "Two crossing leaf springs side by side: a hinge about z.";
  f.drawing = R"(
    y      //        ##                     side view:   z
    |      // \    / ##  leaf 1 (+z)                     |  [=== leaf 1 ===]  width
    |      //   \/   ##                                  |         gap
    |      //   /\   ##  O at the crossing               |  [=== leaf 2 ===]  width
    |      // /    \ ##  leaf 2 (-z)                     +---- x
    +---- x    half_angle from x; the base end is on the left
)";
  f.drive = Direction::rz;
  f.parameters = {length(), width(), thickness(), half_angle(), crossing_fraction(), gap()};
  set_makers<CrossHingeParameters>(
      f,
      []<class S>(const CrossHingeParameters<S>& p, const MaterialT<S>& material,
                  const EndEffector& payload,
                  const FamilyChoices&) { return make_cross_hinge<S>(p, material, payload); },
      "gap");
  return f;
}

Family three_flexure_cross_hinge() {
  Family f;
  f.name = "three_flexure_cross_hinge";
  f.summary =
      "An inner leaf spring crossing two outer ones, mirror-symmetric in z: a hinge about z.";
  f.drawing = R"(
    y      //        ##                     side view:   z  [= outer =]  outer_width
    |      // \    / ##  outer leaves                    |      gap
    |      //   \/   ##                                  |  [= inner =]  inner_width
    |      //   /\   ##  O at the crossing               |      gap
    |      // /    \ ##  inner leaf                      |  [= outer =]  outer_width
    +---- x    half_angle from x; the base end is on the left
)";
  f.drive = Direction::rz;
  f.parameters = {length(),
                  thickness(),
                  size("outer_width", "width of each outer leaf, along z"),
                  size("inner_width", "width of the inner leaf, along z"),
                  half_angle(),
                  crossing_fraction(),
                  gap()};
  set_makers<ThreeFlexureCrossHingeParameters>(
      f,
      []<class S>(const ThreeFlexureCrossHingeParameters<S>& p, const MaterialT<S>& material,
                  const EndEffector& payload, const FamilyChoices&) {
        return make_three_flexure_cross_hinge<S>(p, material, payload);
      },
      "gap");
  return f;
}

Family clamped_plate() {
  Family f;
  f.name = "clamped_plate";
  f.summary = "A plate clamped along two opposite edges, loaded across at a point.";
  f.drawing = R"(
    z    //+--------------------------+//   the other two edges are free
    |    //|                          |//   thickness along y
    |    //|            x O           |//
    |    //|     (load_point_x, _z)   |//   width along z
    |    //+--------------------------+//
    +---- x |<-------- length ------->|
)";
  f.drive = Direction::uy;
  f.parameters = {length(), width(), thickness(),
                  size("load_point_x", "place of O, from the clamped edge x = 0"),
                  size("load_point_z", "place of O, from the free edge z = 0")};
  f.parameters.back().open_min = false;
  f.has_end_effector = [](const FamilyChoices&) { return false; };
  f.mesh = {20, 20};  // the load may stand anywhere
  set_makers<ClampedPlateParameters>(
      f,
      []<class S>(const ClampedPlateParameters<S>& p, const MaterialT<S>& material,
                  const EndEffector& payload,
                  const FamilyChoices&) { return make_clamped_plate<S>(p, material, payload); },
      "load_point_x");
  f.make = [make = f.make](const ParameterValues& values, const FamilyChoices& choices,
                           const Material& material, const EndEffector& payload) {
    for (const auto& [name, side] :
         {std::pair{"load_point_x", "length"}, {"load_point_z", "width"}})
      if (values.at(name) > values.at(side))
        throw SpecError(pointer_to(name), fmt::format("{:g} m", values.at(name)),
                        fmt::format("the load point lies on the plate: at most {} = {:g} m", side,
                                    values.at(side)));
    return make(values, choices, material, payload);
  };
  return f;
}

}  // namespace

MechanismDirection number_direction(const Mechanism& mechanism, const std::string& name) {
  MechanismDirection direction{name, zero_rate(mechanism)};
  bool known = false;
  const auto along = [&](const std::string& section) {
    return [&name, &known, section](std::string_view number, double& x) {
      if (name != section + std::string(number)) return;
      x = 1;
      known = true;
    };
  };
  for (LeafSpring& leaf : direction.rate.leaves)
    each_material_number(leaf.material, along("material."));
  each_payload_number(direction.rate.bodies[static_cast<std::size_t>(mechanism.end_effector)],
                      along("end_effector."));
  if (!known) throw std::invalid_argument("no number of material or end-effector: " + name);
  return direction;
}

FamilyChoices standard_choices(const Family& family) {
  FamilyChoices choices;
  for (const FamilyOption& option : family.options) choices[option.name] = option.choices.front();
  return choices;
}

const std::vector<Family>& families() {
  static const std::vector<Family> all{leaf_spring(), parallel_guide(), cross_hinge(),
                                       three_flexure_cross_hinge(), clamped_plate()};
  return all;
}

const Family& find_family(const std::string& name, const std::string& pointer) {
  std::vector<std::string> names;
  for (const Family& family : families()) {
    if (family.name == name) return family;
    names.push_back(family.name);
  }
  throw SpecError(pointer, '"' + name + '"', "unknown family; " + known_names(name, names));
}

}  // namespace flexopt
