#pragma once
// A design file as read: checked, its formulas compiled, ready to be evaluated as often as wanted.
// Numbers lie in slots: first the parameters, then what "let" names, then the indices of the item's
// own "repeat".
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/mechanism/mechanism.hpp"
#include "core/spec/formula.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/family.hpp"

namespace flexopt {

/// A number of a design file.
struct DesignNumber {
  double constant = 0;
  std::shared_ptr<const Formula> formula;  ///< instead of the constant
};
using DesignVector = std::array<DesignNumber, 3>;
using DesignMatrix = std::vector<DesignNumber>;  ///< row by row

/// "when": choices that options must have; all conditions of one alternative, any alternative.
struct ChoiceCondition {
  struct Term {
    std::string option, choice;
    bool equal = true;
  };
  std::vector<std::vector<Term>> alternatives;  ///< empty: always

  bool holds(const FamilyChoices& choices) const;
};

/// One index of "repeat", both bounds included.
struct RepeatIndex {
  std::string name;
  DesignNumber first, last;
};

/// What every item of a design file may have.
struct DesignItem {
  std::string pointer;  ///< into the file
  std::string name;     ///< this and all names of other items: with formulas in braces, {i - 1}
  std::string frame;    ///< empty: that of the file
  ChoiceCondition when;
  std::vector<RepeatIndex> repeat;
  std::map<std::string, DesignNumber> braces;  ///< whole numbers of the item's names, by their text
};

struct FrameItem : DesignItem {
  struct Turn {
    int axis = 0;        ///< 0 x, 1 y, 2 z, as turned so far
    DesignNumber angle;  ///< [rad]
  };
  DesignVector at;
  std::vector<Turn> turns;
};

/// A place on a body, in the item's frame.
struct HeldPlace {
  std::string body;  ///< empty: none
  DesignVector at;
  struct Clamp {
    DesignNumber length;
    DesignVector normal;  ///< out of the face that the leaf lies on
  };
  std::optional<Clamp> clamp = std::nullopt;  ///< of a leaf on an elastic body
};

/// A direction that a body holds, in the item's frame: one of its axes, or that of a vector.
struct HeldDirection {
  std::optional<Direction> direction;
  DesignVector along;     ///< instead of it
  bool rotation = false;  ///< about `along`
  std::string key;        ///< behind the pointer of the body
};

struct ElasticItem;

struct BodyItem : DesignItem {
  DesignVector at;   ///< place of a material point on the leaf
  std::string leaf;  ///< leaf of which it is a material point; empty: a rigid body
  std::optional<DesignNumber> mass, density;
  DesignVector center_of_mass;  ///< relative to `at`
  DesignMatrix inertia;         ///< none, 3 principal values or 9
  DesignMatrix box;             ///< none, 3 lengths along the frame's axes or 3 edges, 9
  std::vector<HeldDirection> held;
  std::shared_ptr<const ElasticItem> elastic;  ///< elastic_item.hpp; null: rigid
};

/// A size along a leaf.
struct DesignSize {
  DesignNumber base;
  std::optional<DesignNumber> tip;  ///< linear from base to tip
  /// A formula of s = 0 at the base … 1 at the tip, the slot after all others.
  std::shared_ptr<const Formula> profile;
};

struct LeafItem : DesignItem {
  HeldPlace base, tip;  ///< a tip without body is free
  DesignVector across;
  bool wire = false;
  bool may_cross = false;       ///< other leaves
  DesignSize width, thickness;  ///< width; the diameter of a wire, as `thickness`
  std::optional<Material> material;
  std::optional<DesignNumber> curve;        ///< subtended angle [rad]
  std::optional<DesignVector> fold;         ///< middle of its fold line
  std::optional<DesignNumber> fold_radius;  ///< inner radius of its bend; none: sharp
  struct Reinforcement {
    DesignNumber fraction, thickness;
    bool rigid = true;  ///< a box; else an elastic plate between rigid lines
  };
  std::optional<Reinforcement> reinforcement;
};

struct JointItem : DesignItem {
  JointType type = JointType::rigid;
  std::string body, other;
  DesignVector at, axis;
};

struct SpringItem : DesignItem {
  std::string body, other;
  DesignVector at, other_at;
  DesignNumber stiffness;
  std::optional<DesignNumber> free_length;
  std::vector<std::array<DesignNumber, 2>> line;  ///< length and force, instead of both
  DesignMatrix matrix;                            ///< 36 numbers of a bushing, else none
};

struct DriveItem : DesignItem {
  std::string body, other;
  Direction direction = Direction::uy;
  struct VoiceCoil {
    DesignNumber motor_constant, resistance;
  };
  std::optional<VoiceCoil> voice_coil;
  struct Piezo {
    std::optional<DesignVector> at;  ///< where it pushes; none: the reference point of the body
    DesignNumber free_stroke, blocking_force;
  };
  std::optional<Piezo> piezo;
};

struct DesignPlan;

struct PartItem : DesignItem {
  std::shared_ptr<const DesignPlan> design;
  int mirror = -1;                       ///< axis that is reflected, −1: none
  std::vector<DesignNumber> parameters;  ///< parameters of the part, in its order
  FamilyChoices choices;
  std::vector<std::pair<std::string, std::string>> join;  ///< body of the part → body of this file
};

struct DesignRule {
  std::string pointer;
  Formula that;
  std::string otherwise;  ///< what the user reads when it does not hold
};

/// Source of a design file.
struct DesignSource {
  enum class Kind {
    library,  ///< one of the program's families
    file,     ///< a file of the user
    job       ///< written into a job
  };
  Kind kind = Kind::library;
  JsonText text;       ///< text of a file
  std::string folder;  ///< that paths in it start from
  std::string lead;    ///< pointer of the design in a job, or of a part's in the design around it
};

/// Option of every design with elastic bodies: "rigid" makes rigid ones of all but notches.
inline constexpr const char* elastic_bodies_option = "elastic_bodies";

struct DesignPlan {
  DesignSource source;
  std::string name, summary, drawing;  ///< empty where the file does not say
  std::vector<int> mesh;               ///< elements along and across, or empty
  std::vector<Parameter> parameters;
  ParameterValues examples;         ///< examples of parameters without default
  std::vector<std::string> unused;  ///< pointers of parameters and lets that no formula uses
  std::vector<FamilyOption> options;
  std::vector<FormulaName> lets;  ///< in an order in which each needs earlier ones alone
  std::vector<DesignNumber> let_numbers;
  std::vector<DesignRule> rules;
  std::vector<FrameItem> frames;
  std::vector<BodyItem> bodies;
  std::vector<LeafItem> leaves;
  std::vector<JointItem> joints;
  std::vector<SpringItem> springs;
  std::vector<PartItem> parts;
  std::vector<DriveItem> drives;
  bool named_drives = false;  ///< "drives" instead of "drive"

  /// Parameters that the bounds of a "repeat" or numbers in names use, directly or by "let".
  std::vector<std::string> counts() const;
  /// Whether elastic bodies, other than notches, are in it or in its parts.
  bool has_elastic_bodies() const;
  /// The material point or body that carries O under these choices; null if there is none.
  const BodyItem* end_effector(const FamilyChoices& choices) const;
  /// Whether there are leaves of this kind under these choices: of circular section, or others.
  bool has_leaves(bool wires, const FamilyChoices& choices) const;
};

/// Whether a place is one of the job, whose reader knows it, and none of a design file.
bool is_of_job(const Fault& fault);
/// Puts a fault of one of the program's families, which the reader does not see, at `pointer`.
void show_at(const std::string& pointer, const DesignSource& family, Fault& fault);
/// The fault with its place: line and column of a file of the user, a pointer into the job for a
/// design that is written there.
SpecError located(const DesignSource& source, const SpecError& error);

}  // namespace flexopt
