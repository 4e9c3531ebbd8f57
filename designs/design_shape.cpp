#include <initializer_list>
#include <nlohmann/json.hpp>

#include "designs/describe.hpp"
#include "designs/family.hpp"

namespace flexopt {
namespace {

using namespace shape;

constexpr std::size_t longest_list = 2000;

/// An SI number, a quantity, or a formula.
Shape number() { return quantity(""); }
Shape vector() { return list(number(), 3, 3); }
Shape reference() { return text(200); }

Shape direction() { return choice({direction_names.begin(), direction_names.end()}); }

/// Schema of a held direction: along an axis of the item's frame, or along (about) a vector in it.
Shape held_direction() {
  return one_of(
      {direction(), record({optional("displacement", vector(), "the direction that cannot move"),
                            optional("rotation", vector(), "about which it cannot turn")})});
}

/// The fields of an item, behind those that any item may have.
Shape item(std::initializer_list<Field> own) {
  std::vector<Field> fields{
      optional("name", text(200),
               "what it is called; {i} is the index i of repeat, {i - 1} the one before"),
      optional("when", text(), "only under these choices: \"tip == guided\""),
      optional("repeat", map(list(number(), 2, 2)),
               "copies by index: {\"i\": [0, \"n - 1\"]}, both ends included"),
      optional("frame", reference(), "the frame that it is written in")};
  fields.insert(fields.end(), own.begin(), own.end());
  return record(std::move(fields));
}

Shape items(std::initializer_list<Field> own) { return list(item(own), 0, longest_list); }

Shape parameters() {
  return map(record({
      required("unit", text(50), "SI unit; \"1\" for a plain number"),
      optional("default", quantity(""), "required when missing"),
      optional("example", quantity(""), "of one without default: a usual value, for drawings"),
      optional("min", quantity(""), "least value, allowed itself"),
      optional("max", quantity(""), "largest value, allowed itself"),
      optional("above", quantity(""), "values lie above"),
      optional("below", quantity(""), "values lie below"),
      optional("meaning", text(), "for the user"),
  }));
}

Shape options() {
  return map(record({required("choices", list(text(50), 1, 50), "the first is the default"),
                     optional("meaning", text(1000), "for the user")}));
}

Shape edge(bool free) {
  const Field body = free ? optional("body", reference(), "that holds the edge; none: it is free")
                          : required("body", reference(), "that holds the edge");
  return record({body, required("at", vector(), "middle of the edge")});
}

Shape size_along() {
  return one_of(
      {number(), list(number(), 2, 2),
       record({required("profile", text(), "formula of s = 0 at the base to 1 at the tip")})});
}

Shape matrix(std::size_t n) { return list(list(number(), n, n), n, n); }

Shape frames() {
  return items({
      with_default("at", vector(), nlohmann::json{0, 0, 0}, "its origin"),
      with_default(
          "turn", list(list(number(), 2, 2), 0, 20), nlohmann::json::array(),
          "turns in their order, each about an axis as turned so far: [[\"z\", \"30 deg\"]]"),
      optional("in", reference(), "the frame that it is written in"),
  });
}

Shape bodies() {
  return items({
      optional("at", vector(), "reference point, undeflected"),
      optional("on",
               record({required("leaf", reference(), "which leaf"),
                       required("at", vector(), "where on it")}),
               "a material point of a leaf, instead of a rigid body"),
      optional("mass", number(), "mass"),
      optional("center_of_mass", vector(), "relative to the reference point"),
      optional("inertia", one_of({vector(), matrix(3)}),
               "about the centre of mass: three principal values or a symmetric 3x3"),
      optional("box", one_of({vector(), matrix(3)}),
               "the room it takes, around the centre of mass: three lengths, or three edges of a "
               "turned box"),
      optional("density", number(), "of the box, instead of mass and inertia"),
      optional("held", list(held_direction(), 0, 6), "directions that cannot move"),
  });
}

Shape leaves() {
  return items({
      required("base", edge(false), "the edge that it begins at"),
      required("tip", edge(true), "the edge that it ends at"),
      optional("across", vector(), "direction of the width"),
      optional("width", size_along(), "across"),
      optional("thickness", size_along(), "normal to length and width"),
      optional("diameter", number(), "of a wire, instead of width and thickness"),
      optional("material", material_shape(false), "of this leaf alone"),
      optional("curve", record({required("angle", number(), "subtended by the circular arc")}),
               "initially curved about its width, bulging to its normal"),
      optional(
          "fold",
          record({required("at", vector(), "the middle of the fold line"),
                  optional("radius", number(), "inner radius of the bend; 0: a mitred corner")}),
          "elastic fold: the leaf runs from its base to the fold line and from there to its tip"),
      with_default("may_cross", boolean(), false,
                   "it may run through other leaves, as in planar models"),
      optional("reinforcement",
               record({required("fraction", number(), "of the length, in the middle"),
                       required("thickness", number(), "in all"),
                       with_default("rigid", boolean(), true, "a rigid box, or an elastic plate")}),
               "a thicker middle"),
  });
}

Shape joints() {
  return items({
      required("type", choice({"rigid", "revolute", "spherical", "prismatic"}),
               "what it lets move"),
      required("body", reference(), "one of its bodies"),
      with_default("other", reference(), "ground", "the other one"),
      required("at", vector(), "its place"),
      optional("axis", vector(), "of a revolute or prismatic joint"),
  });
}

Shape springs() {
  return items({
      required("body", reference(), "one of its bodies"),
      with_default("other", reference(), "ground", "the other one"),
      required("at", vector(), "its end on the body; of a bushing its place"),
      optional("other_at", vector(), "its end on the other body"),
      optional("stiffness", number(), "force a length"),
      optional("free_length", number(), "without force; default: as built"),
      optional("line", list(list(number(), 2, 2), 2, 100),
               "instead of them: lengths, ascending, each with the force that pulls there"),
      optional("matrix", matrix(6), "of a bushing, about its place"),
  });
}

Shape parts() {
  return items({
      required("design", one_of({reference(), object()}),
               "a family, a file relative to this one, or the content of such a file"),
      optional("mirror", choice({"x", "y", "z"}), "axis of the part that is reflected"),
      with_default("parameters", map(number()), nlohmann::json::object(),
                   "of the part: numbers, formulas in the names of this file, and choices"),
      with_default("join", map(reference()), nlohmann::json::object(),
                   "bodies of the part that are bodies of this file"),
  });
}

std::vector<Field> drive_fields() {
  return {with_default("body", reference(), "end_effector", "what is driven"),
          with_default("other", reference(), "ground", "against what"),
          required("direction", direction(), "along or about which axis of its frame"),
          optional("frame", reference(), "the frame that it is written in"),
          optional("voice_coil",
                   record({required("motor_constant", number(), "force or moment a current"),
                           required("resistance", number(), "of its winding")}),
                   "a voice coil makes the load"),
          optional("piezo",
                   record({optional("at", vector(), "where it pushes; default: the body's place"),
                           required("free_stroke", number(), "at full voltage, without load"),
                           required("blocking_force", number(), "at full voltage, held")}),
                   "a piezo stack pushes the body: its stroke without load is prescribed"),
          optional("when", text(), "only under these choices")};
}

}  // namespace

const Shape& design_file_shape() {
  static const Shape shape = [] {
    std::vector<Field> named = drive_fields();
    named.insert(named.begin(), required("name", text(50), "in results"));
    return record({
        required("flexopt_design", integer(1, 1), "version of the format"),
        optional("name", text(200), "of the design"),
        optional("summary", text(500), "one sentence"),
        optional("drawing", list(text(200), 0, 100), "lines of a sketch in letters"),
        optional("mesh", list(integer(1, 200), 2, 2),
                 "elements along and across a leaf that the design wants"),
        with_default("parameters", parameters(), nlohmann::json::object(), "what its user chooses"),
        with_default("let", map(number()), nlohmann::json::object(), "names for formulas"),
        with_default("rules",
                     list(record({required("that", text(), "a comparison that must hold"),
                                  required("else", text(), "what the user reads otherwise")}),
                          0, 200),
                     nlohmann::json::array(), "what parameters must keep to"),
        with_default("options", options(), nlohmann::json::object(), "choices by name"),
        with_default("frames", frames(), nlohmann::json::array(), "axes to write items in"),
        with_default("bodies", bodies(), nlohmann::json::array(), "rigid bodies"),
        with_default("leaves", leaves(), nlohmann::json::array(), "leaf springs and wires"),
        with_default("joints", joints(), nlohmann::json::array(), "ideal joints"),
        with_default("springs", springs(), nlohmann::json::array(), "springs and bushings"),
        with_default("parts", parts(), nlohmann::json::array(), "other designs as parts"),
        optional("drive", record(drive_fields()), "what the stroke prescribes"),
        optional("drives", list(record(named), 1, 6), "several of them"),
    });
  }();
  return shape;
}

nlohmann::json design_file_schema() {
  nlohmann::json schema = json_schema(design_file_shape());
  schema["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  schema["title"] = "A design of flexopt";
  return schema;
}

}  // namespace flexopt
