#pragma once
// Built-in materials.
#include <array>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/mechanism/s_n_curve.hpp"
#include "core/response/quantities.hpp"
#include "core/response/stroke_gradients.hpp"
#include "core/spec/fault_list.hpp"
#include "designs/end_effector.hpp"

namespace flexopt {

/// A built-in material with the source of its values.
struct NamedMaterial {
  Material material;
  std::string source;
};
const std::vector<NamedMaterial>& materials();

/// The material that stands at `at` of a design file or a job: the name of a built-in one, or its
/// constants, which have passed material_shape. Throws SpecError where its S-N curve is none.
Material material_of(const nlohmann::json& read, const nlohmann::json_pointer<std::string>& at,
                     bool of_job);
/// JSON that reads as this material, its keys in the order of the documentation.
nlohmann::ordered_json written_material(const Material& material, bool of_job);
/// JSON that reads as this curve.
nlohmann::json written_s_n_curve(const SnCurve& curve);

// What a design lets its user choose.

/// One geometric parameter of a design.
struct Parameter {
  std::string name;
  std::string unit;                     ///< SI unit: "m", "rad", "1"
  std::optional<double> default_value;  ///< required when there is none
  /// Allowed range; an end is excluded where it is `open`.
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool open_min = false, open_max = false;
  std::string meaning;
};

/// A choice that a design offers by name, next to its numbers.
struct FamilyOption {
  std::string name;
  std::vector<std::string> choices;  ///< the first is the default
  std::string meaning;
};

/// Values by the names of parameters. Under a name_of_one_leaf stands what is added to the
/// parameter for that leaf alone; without such a name nothing is.
using ParameterValues = std::map<std::string, double>;
using FamilyChoices = std::map<std::string, std::string>;  ///< option → choice

/// "thickness of leaf +y": the parameter, or the number of its material, as one leaf of the design
/// file has it. Its place and sizes follow; bodies, joints, springs and other leaves stay.
std::string name_of_one_leaf(const std::string& parameter, const std::string& leaf);
struct OfLeaf {
  std::string parameter, leaf;  ///< no leaf: the parameter of all
};
/// The two parts of such a name, or a plain parameter.
OfLeaf parts_of_name(const std::string& name);

// A family: a design file with its parameters → a mechanism. Nothing downstream knows families.

struct DesignPlan;

/// Plain data and const functions: safe to share among threads.
struct Family {
  std::string name;
  std::string summary;  ///< one sentence
  std::string drawing;  ///< ASCII sketch with the parameters
  DriveList drives;     ///< what the stroke prescribes
  std::vector<Parameter> parameters;
  std::vector<FamilyOption> options;
  std::array<int, 2> mesh = ModelOptions{}.mesh;  ///< that its leaves want when none is asked for
  /// Parameters that say how many there are of something: whole, and nothing to optimise.
  std::vector<std::string> counts;
  std::shared_ptr<const DesignPlan> plan;

  /// Whether a rigid end-effector carries O; else O is a material point of a leaf: no mass, no
  /// moments.
  bool has_end_effector(const FamilyChoices& choices) const;
  /// Whether all of its leaves are wires.
  bool is_of_wires(const FamilyChoices& choices) const;
  /// Values must hold every parameter, in range, and choices every option. Elastic bodies have the
  /// meshes of the nominal values, or of `values` where there are none. Throws SpecError with all
  /// that is wrong: at /design/parameters/… where parameters contradict each other, else with the
  /// place in the design file.
  Mechanism make(const ParameterValues& values, const FamilyChoices& choices,
                 const Material& material, const EndEffector& payload,
                 const ParameterValues& nominal = {}) const;
  /// Exact derivative of every number of the mechanism along each of the named ones: parameters,
  /// `material.youngs_modulus`, `.poissons_ratio`, `.density`, `end_effector.mass`,
  /// `.center_of_mass.x` …, `.inertia.xx`, `.inertia.xy` …, and those of one leaf. For what `make`
  /// accepts. Throws std::invalid_argument for another name.
  std::vector<MechanismDirection> directions(const ParameterValues& values,
                                             const FamilyChoices& choices, const Material& material,
                                             const EndEffector& payload,
                                             const std::vector<std::string>& names,
                                             const ParameterValues& nominal = {}) const;
  /// Names of the leaves of the design file of which some number depends on the parameter.
  std::vector<std::string> leaves_along(const ParameterValues& values, const FamilyChoices& choices,
                                        const Material& material,
                                        const std::string& parameter) const;
};

/// The first choice of every option.
FamilyChoices default_choices(const Family& family);

/// The families that the program brings along, in the order of the documentation.
const std::vector<Family>& families();

/// The family of that name. Throws SpecError(pointer) that lists the known ones.
const Family& find_family(const std::string& name, const std::string& pointer);

/// A design file of the user. Throws SpecError with all that is wrong, each with line and column.
std::shared_ptr<const Family> read_family_file(const std::string& file);

/// The content of a design file; the contents of the files of its parts stand in their places, and
/// it has a name. `document`: such a content whose parts are files relative to `folder`. Throws
/// SpecError.
nlohmann::json whole_design_file(const std::string& file);
nlohmann::json whole_design(nlohmann::json document, const std::string& folder);

/// A design that is written into a job, at `pointer` of it; paths in it start from `folder`. Null
/// where something is wrong, which is added to `faults`.
std::shared_ptr<const Family> read_family(const nlohmann::json& document,
                                          const std::string& pointer, const std::string& folder,
                                          FaultList& faults);

}  // namespace flexopt
