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

Shape face() { return choice({"x+", "x-", "y+", "y-", "z+", "z-"}); }

Shape edge(bool free) {
  const Field body = free ? optional("body", reference(), "that holds the edge; none: it is free")
                          : required("body", reference(), "that holds the edge");
  return record(
      {body, required("at", vector(), "middle of the edge"),
       optional("clamp",
                record({required("length", number(), "of the patch, on from the edge"),
                        optional("side", face(), "face of the body that the leaf lies on"),
                        optional("normal", vector(), "out of that face, instead")}),
                "of a leaf on an elastic body: it lies on a face that it does not end at")});
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

Shape point() { return list(number(), 2, 2); }

/// Corners of a closed line in a plane.
Shape contour() {
  const Shape rounded = record(
      {required("at", point(), "the corner"), optional("fillet", number(), "radius that rounds it"),
       optional("through", point(), "the way to it from the corner before is an arc")});
  return list(one_of({point(), rounded}), 2, 500);
}

Shape elastic_plate() {
  return record({
      required("outline", contour(), "its corners; two are those of a rectangle"),
      with_default("windows", list(contour(), 0, 100), nlohmann::json::array(), "cut out of it"),
      with_default("holes",
                   list(record({required("at", point(), "its centre"),
                                required("radius", number(), "of the hole")}),
                        0, 100),
                   nlohmann::json::array(), "round ones"),
      required("thickness", number(), "half of it to either side of the plane"),
      with_default(
          "normal", vector(), nlohmann::json{0, 0, 1},
          "of the plane, whose coordinates are along the other two of x, y, z, in this order"),
      optional("along", vector(), "direction of the first coordinate, instead"),
      with_default("at", vector(), nlohmann::json{0, 0, 0}, "origin of the plane's coordinates"),
  });
}

Shape elastic_notch() {
  return record({
      with_default("contour", choice({"circular", "elliptic", "corner_filleted", "v", "power"}),
                   "circular", "the line of the cut"),
      optional("radius", number(), "of a circular notch"),
      optional("half_length", number(), "of the notch, along its axis"),
      optional("depth", number(), "of the cut from one side"),
      optional("fillet", number(), "radius of a corner-filleted or V notch"),
      optional("exponent", number(), "of a power-function contour"),
      required("thickness", number(), "thinnest one, in the middle"),
      required("width", number(), "at right angles to axis and thickness"),
      required("ends", number(), "length of the body beyond the notch, at each end"),
      with_default("axis", vector(), nlohmann::json{1, 0, 0}, "from base to tip"),
      with_default("across", vector(), nlohmann::json{0, 1, 0}, "direction of the thickness"),
      with_default("two_axes", boolean(), false, "the width is cut as the thickness is"),
  });
}

/// A file of another program; `more`: what is said of it besides.
Shape elastic_file(std::initializer_list<Field> more) {
  std::vector<Field> fields{
      required("file", text(500), "relative to this file"),
      with_default("axis", vector(), nlohmann::json{1, 0, 0}, "direction of its x"),
      with_default("across", vector(), nlohmann::json{0, 1, 0}, "direction of its y")};
  fields.insert(fields.end(), more.begin(), more.end());
  return record(std::move(fields));
}

Shape elastic_interface() {
  return record({
      required("name", text(200), "of the rigid frame, behind the name of the body and a dot"),
      optional("body", reference(), "the body that it is a part of; none: a frame of its own"),
      optional("face", face(), "face that the patch is on, along axes of the frame"),
      optional("normal", vector(), "out of that face, instead"),
      optional("at", vector(), "middle of the patch; default: of the face"),
      optional("size", point(), "sides of the patch; default: the whole face"),
      optional("along", vector(),
               "direction of the first side; default: sides are along those of x, y, z that the "
               "normal is not, in this order"),
  });
}

Shape elastic() {
  return record({
      optional("material", material_shape(false), "default: that of the design"),
      optional("box", vector(), "a cuboid: lengths along the axes of the frame"),
      optional("center", vector(), "of that box, relative to the place of the body"),
      optional("from", choice({"box"}), "the box of the body itself is elastic"),
      optional("plate", elastic_plate(), "a plate with windows and holes"),
      optional("notch", elastic_notch(), "a notch hinge; the body's place is its middle"),
      optional("mesh",
               elastic_file({required("units", choice({"m", "mm", "um"}), "of its places")}),
               "a mesh, .inp or .msh, with node sets as interfaces"),
      optional("import", elastic_file({}), "stiffness and mass of another program"),
      optional("between", list(reference(), 2, 2), "bodies that base and tip of a notch are of"),
      optional("interfaces", list(elastic_interface(), 0, 100),
               "patches that rigid frames hold; leaves add their own"),
      optional("payload", reference(),
               "interface that carries the name of the body, its mass, "
               "what it holds; default: the first"),
      with_default("rigid", boolean(), false, "weighs the same and does not bend; not of a notch"),
      optional("degree", integer(2, 4), "of its energy in the deformation: 2 or 4"),
      optional("elements",
               record({optional("size", number(), "of an element"),
                       optional("through", integer(1, 20), "number through the thickness"),
                       optional("root", number(), "size at the edges of patches"),
                       optional("growth", shape::quantity("1", 1, 10, true),
                                "largest ratio of neighbours")}),
               "how fine its mesh is"),
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
      optional("elastic", elastic(), "it bends: its shape, and the rigid frames that hold it"),
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
        with_default("bodies", bodies(), nlohmann::json::array(), "rigid and elastic bodies"),
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
