#pragma once
// A family: named parameters with units and ranges → a mechanism. Nothing downstream knows
// families.
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

/// One geometric parameter of a family.
struct Parameter {
  std::string name;
  std::string unit;                ///< SI unit: "m", "rad", "1"
  std::optional<double> standard;  ///< default; required when missing
  double min = 0, max = 0;         ///< allowed range, ends excluded where `open`
  bool open_min = false, open_max = false;
  std::string meaning;
};

/// A choice that a family offers by name, next to its numbers.
struct FamilyOption {
  std::string name;
  std::vector<std::string> choices;  ///< the first is the default
  std::vector<std::string> later;    ///< of the job format, but not offered by this version
  std::string meaning;
};

using ParameterValues = std::map<std::string, double>;
using FamilyChoices = std::map<std::string, std::string>;  ///< option → choice

/// The rigid end-effector that the leaves carry.
struct EndEffector {
  double mass = 0;                             ///< [kg]
  Matrix3d inertia = Matrix3d::Zero();         ///< about its centre of mass, global axes [kg m²]
  Vector3d center_of_mass = Vector3d::Zero();  ///< relative to O [m]
};

struct Family {
  std::string name;
  std::string summary;  ///< one sentence
  std::string drawing;  ///< ASCII sketch with the parameters
  Direction drive = Direction::uy;
  std::vector<Parameter> parameters;
  std::vector<FamilyOption> options;
  std::array<int, 2> mesh = ModelOptions{}.mesh;  ///< that its leaves want when none is asked for
  /// Whether a rigid end-effector carries O; else O is a material point of a leaf: no mass, no
  /// moments.
  std::function<bool(const FamilyChoices&)> has_end_effector = [](const FamilyChoices&) {
    return true;
  };
  /// Values must hold every parameter, in range, and choices every option. Throws SpecError
  /// (pointer /design/parameters/…) when they contradict each other.
  std::function<Mechanism(const ParameterValues&, const FamilyChoices&, const Material&,
                          const EndEffector&)>
      make;
  /// Exact derivative of every number of the mechanism along each of the named parameters. For what
  /// `make` accepts. Throws std::invalid_argument for a name that no parameter has.
  std::function<std::vector<MechanismDirection>(const ParameterValues&, const FamilyChoices&,
                                                const Material&, const EndEffector&,
                                                const std::vector<std::string>& names)>
      directions;
};

/// The direction of a number of a mechanism's material (`material.youngs_modulus`,
/// `.poissons_ratio`, `.density`) or of its end-effector (`end_effector.mass`,
/// `.center_of_mass.x` …, `.inertia.xx`, `.inertia.xy` …). Throws std::invalid_argument for another
/// name.
MechanismDirection number_direction(const Mechanism& mechanism, const std::string& name);

/// The first choice of every option.
FamilyChoices standard_choices(const Family& family);

/// All families, in the order of the documentation.
const std::vector<Family>& families();

/// The family of that name. Throws SpecError(pointer) that lists the known ones.
const Family& find_family(const std::string& name, const std::string& pointer);

/// Built-in materials with the source of their values.
struct NamedMaterial {
  Material material;
  std::string source;
};
const std::vector<NamedMaterial>& materials();

}  // namespace flexopt
