#include "designs/family.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>  // before AutoDiff, which needs it

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/AutoDiff>
#include <utility>

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

using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 16, 1>>;

/// Derivative of one dual number; a constant carries none.
double along(const Dual& x, int k) { return x.derivatives().size() > k ? x.derivatives()[k] : 0.0; }

Mechanism rate_of(const MechanismT<Dual>& mechanism, int k) {
  const auto vector = [k](const Vector3<Dual>& v) {
    return Vector3d(along(v[0], k), along(v[1], k), along(v[2], k));
  };
  const auto matrix = [k](const Matrix3<Dual>& m) {
    Matrix3d r;
    for (int i = 0; i < 9; ++i) r(i / 3, i % 3) = along(m(i / 3, i % 3), k);
    return r;
  };
  Mechanism rate;
  rate.end_effector = mechanism.end_effector;
  rate.drive = mechanism.drive;
  for (const RigidBodyT<Dual>& b : mechanism.bodies)
    rate.bodies.push_back({b.name, b.role, vector(b.reference), along(b.mass, k),
                           vector(b.center_of_mass), matrix(b.inertia), b.held});
  for (const LeafSpringT<Dual>& l : mechanism.leaves) {
    LeafSpring leaf{.name = l.name,
                    .base = l.base,
                    .tip = l.tip,
                    .origin = vector(l.origin),
                    .axes = matrix(l.axes),
                    .length = along(l.length, k),
                    .width = along(l.width, k),
                    .thickness = along(l.thickness, k),
                    .material = {l.material.name, along(l.material.youngs_modulus, k),
                                 along(l.material.poissons_ratio, k), along(l.material.density, k),
                                 std::nullopt},
                    .section = l.section,
                    .point = std::nullopt};
    if (l.point)
      leaf.point = LeafPoint{l.point->body, along(l.point->along, k), along(l.point->across, k),
                             l.point->spread_over_tip};
    rate.leaves.push_back(std::move(leaf));
  }
  for (const JointT<Dual>& j : mechanism.joints)
    rate.joints.push_back({j.name, j.type, j.body, j.other, vector(j.place), vector(j.axis)});
  return rate;
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
  family.directions = [make](const ParameterValues& values, const FamilyChoices& choices,
                             const Material& material, const EndEffector& payload) {
    Parameters<Dual> parameters{};
    int count = 0;
    parameters.each([&](const char*, Dual&) { ++count; });
    int k = 0;
    parameters.each(
        [&](const char* name, Dual& value) { value = Dual(values.at(name), count, k++); });
    const MechanismT<Dual> mechanism =
        make(parameters, cast_material<Dual>(material), payload, choices);
    std::vector<MechanismDirection> directions;
    k = 0;
    parameters.each([&](const char* name, Dual&) {
      directions.push_back({name, rate_of(mechanism, k++)});
    });
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

Mechanism no_rate(const Mechanism& mechanism) {
  Mechanism rate = mechanism;
  for (RigidBody& b : rate.bodies) {
    b.reference = b.center_of_mass = Vector3d::Zero();
    b.mass = 0;
    b.inertia = Matrix3d::Zero();
  }
  for (LeafSpring& l : rate.leaves) {
    l.origin = Vector3d::Zero();
    l.axes = Matrix3d::Zero();
    l.length = l.width = l.thickness = 0;
    l.material.youngs_modulus = l.material.poissons_ratio = l.material.density = 0;
    if (l.point) l.point->along = l.point->across = 0;
  }
  for (Joint& j : rate.joints) j.place = j.axis = Vector3d::Zero();
  return rate;
}

}  // namespace

std::vector<MechanismDirection> material_directions(const Mechanism& mechanism) {
  std::vector<MechanismDirection> directions;
  for (const auto& [name, number] : {std::pair{"youngs_modulus", &Material::youngs_modulus},
                                     {"poissons_ratio", &Material::poissons_ratio},
                                     {"density", &Material::density}}) {
    directions.push_back({std::string("material.") + name, no_rate(mechanism)});
    for (LeafSpring& l : directions.back().rate.leaves) l.material.*number = 1;
  }
  return directions;
}

std::vector<MechanismDirection> payload_directions(const Mechanism& mechanism) {
  std::vector<MechanismDirection> directions;
  const auto add = [&](const std::string& name) -> RigidBody& {
    directions.push_back({"end_effector." + name, no_rate(mechanism)});
    return directions.back().rate.bodies[mechanism.end_effector];
  };
  add("mass").mass = 1;
  const std::string axes = "xyz";
  for (int i = 0; i < 3; ++i) add(std::string("center_of_mass.") + axes[i]).center_of_mass[i] = 1;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) {
      Matrix3d& inertia = add(std::string("inertia.") + axes[i] + axes[j]).inertia;
      inertia(i, j) = inertia(j, i) = 1;
    }
  return directions;
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
