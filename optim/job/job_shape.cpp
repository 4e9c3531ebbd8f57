#include "optim/job/job_shape.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <numbers>

#include "optim/job/job_numbers.hpp"

namespace flexopt {

using nlohmann::json;
using namespace shape;

namespace {

constexpr double most = 1e12;  // SI; larger forces, masses, stiffnesses are slips of the pen

/// An SI number or a formula of the other parameters.
Shape number_or_formula(const Shape& number) {
  return one_of(
      {number, record({required("expression", text(), "formula of the other parameters, in SI")})});
}

Shape parameters_shape(const Family& family) {
  std::vector<Field> fields;
  const bool wires = std::any_of(family.options.begin(), family.options.end(),
                                 [](const FamilyOption& o) { return o.name == "section"; });
  for (const Parameter& p : family.parameters) {
    const Shape shape = number_or_formula(parameter_shape(p));
    if (wires && p.name == "width")  // the job's reader demands it where it must be
      fields.push_back(optional(p.name, shape, p.meaning + "; a circular section needs none"));
    else
      fields.push_back(p.standard ? standard(p.name, shape, *p.standard, p.meaning)
                                  : required(p.name, shape, p.meaning));
  }
  for (const FamilyOption& option : family.options)
    fields.push_back(standard(option.name, choice(option.choices, option.later),
                              option.choices.front(), option.meaning));
  return record(std::move(fields));
}

/// What any family may hold; which parameters there must be is for the family to say.
Shape any_parameters_shape() {
  std::vector<Field> fields;
  for (const Family& family : families())
    for (Field field : parameters_shape(family).fields)
      if (std::none_of(fields.begin(), fields.end(),
                       [&](const Field& known) { return known.name == field.name; })) {
        field.required = false;
        fields.push_back(std::move(field));
      }
  return record(std::move(fields));
}

Shape material_shape() {
  std::vector<std::string> names;
  for (const NamedMaterial& named : materials()) names.push_back(named.material.name);
  return one_of(
      {choice(names),
       record({
           optional("name", text(), "for the report"),
           required("youngs_modulus", quantity("Pa", 0, most * 10, true), "Young's modulus E"),
           optional("poissons_ratio", quantity("1", -1, 0.5, true),
                    "Poisson's ratio; or give shear_modulus"),
           optional("shear_modulus", quantity("Pa", 0, most * 10, true),
                    "shear modulus G = E / (2 (1 + nu)); or give poissons_ratio"),
           required("density", quantity("kg/m^3", 0, 1e5, true), "density"),
           optional("allowable_stress", quantity("Pa", 0, most, true),
                    "von Mises stress a leaf may see; for the report"),
       })});
}

Shape design_shape(const Family* family) {
  std::vector<std::string> names;
  for (const Family& known : families()) names.push_back(known.name);
  std::vector<Field> fields{
      required("family", choice(names), "which parametric geometry"),
      required("parameters", family ? parameters_shape(*family) : any_parameters_shape(),
               "sizes of the family"),
      required("material", material_shape(), "a built-in material by name, or its constants"),
  };
  for (const Family& known : families()) {
    if (family && known.name != family->name) continue;
    for (const FamilyOption& option : known.options)
      if (std::none_of(fields.begin(), fields.end(),
                       [&](const Field& field) { return field.name == option.name; }))
        fields.push_back(
            optional(option.name, choice(option.choices, option.later), option.meaning));
  }
  return record(std::move(fields));
}

Shape vector3(const std::string& unit, double largest) {
  return list(quantity(unit, -largest, largest), 3, 3);
}

Shape end_effector_shape() {
  const Shape inertia = quantity("kg m^2", -most, most);
  const json zeros = json::array({0, 0, 0});
  return record({
      standard("mass", quantity("kg", 0, most), 0, "mass of the rigid end-effector"),
      standard("inertia",
               one_of({list(quantity("kg m^2", 0, most), 3, 3), list(list(inertia, 3, 3), 3, 3)}),
               zeros,
               "about its centre of mass, global axes: three principal values or a symmetric 3x3"),
      standard("center_of_mass", vector3("m", 1e3), zeros, "relative to O"),
  });
}

Shape stroke_shape(const Family* family) {
  constexpr double farthest = 100;  // [m]
  Shape place = quantity("");
  if (family && is_rotation(family->drive))
    place = quantity("rad", -std::numbers::pi, std::numbers::pi, true, true);
  else if (family)
    place = quantity("m", -farthest, farthest);
  return record({
      optional("from", place, "first point of the stroke; default 0"),
      optional("to", place, "last point of the stroke"),
      optional("points", integer(1, 10001), "how many, both ends included; default 11"),
      optional("at", list(place, 1, 10001), "the points one by one, instead of from, to, points"),
  });
}

/// What may differ from design to design.
std::vector<std::string> names_of(const Family& family) {
  std::vector<std::string> names;
  for (const Parameter& p : family.parameters) names.push_back(p.name);
  for (const Parameter& p : job_numbers()) names.push_back(p.name);
  return names;
}

Shape optimise_shape(const Family* family) {
  const OptimiseSpec defaults;
  std::vector<std::string> parameter_names;
  if (family) parameter_names = names_of(*family);
  const Shape variable = record({
      required("parameter", parameter_names.empty() ? text() : choice(parameter_names),
               "which parameter of the family, or number of the material or the end-effector"),
      required("min", quantity(""), "lower bound"),
      required("max", quantity(""), "upper bound"),
      optional("start", quantity(""), "where the first start begins; default: the job's value"),
      optional("stock", list(quantity(""), 1, 1000),
               "sizes there are to buy: the optimum takes one of them"),
      optional("step", quantity(""), "or: the optimum is a multiple of this"),
  });
  const Shape objective = record({
      optional("maximise", text(), "a quantity of a path point, or a formula of the parameters"),
      optional("minimise", text(), "the same, to be made small"),
      optional("over_stroke", choice(over_stroke_names()),
               "how its values over the stroke become one; default: the worst"),
  });
  const Shape constraint = record({
      optional("quantity", text(), "a quantity of a path point"),
      optional("expression", text(), "or a formula of the parameters, in SI"),
      optional("over_stroke", choice(over_stroke_names()),
               "how a quantity's values over the stroke become one; default: the worst"),
      optional("min", quantity(""), "lower bound"),
      optional("max", quantity(""), "upper bound"),
  });
  const Algorithm algorithm;
  const ParetoSpec front;
  const VerifySpec verification;
  const Shape pareto = record({
      optional("quantity", text(), "a quantity of a path point"),
      optional("expression", text(), "or a formula of the parameters"),
      optional("over_stroke", choice(over_stroke_names()),
               "how a quantity's values over the stroke become one; default: the worst"),
      standard("sense", choice({"minimise", "maximise"}), "minimise", "which way is better"),
      standard("points", integer(2, 200), front.points, "designs on the front, both ends included"),
  });
  const Shape verify = record({
      standard("tolerance", quantity("1", 0, 0.1, true), verification.tolerance,
               "largest difference to full accuracy, relative, of objective and constraints"),
      standard("max_full_evaluations", integer(1, 1000), verification.max_full_evaluations,
               "evaluations at full accuracy"),
  });
  return record({
      required("variables", list(variable, 1, 50), "what may change"),
      required("objective", objective, "what should become best"),
      standard("constraints", list(constraint, 0, 200), json::array(), "what must hold"),
      standard(
          "algorithm",
          record({
              standard("library", choice({"nlopt", "ipopt"}), algorithm.library, "optimiser"),
              optional("name", text(), "NLopt's name of the algorithm; default " + algorithm.name),
              optional("local", text(), "what runs inside AUGLAG or MLSL, by NLopt's name"),
          }),
          json::object(), "who searches"),
      standard("starts", integer(1, 1000), defaults.starts,
               "starts: the first at the job's values, the others spread over the box"),
      standard("spread", choice({"sobol", "latin_hypercube"}), "sobol",
               "how the starts but the first are spread"),
      standard("seed", integer(0, 4294967295.0), defaults.seed, "of the spread of the starts"),
      optional("pareto", pareto, "a second objective: the front of both"),
      optional("verify", verify, "the optimum is to be that of full accuracy"),
      standard("max_evaluations", integer(1, 1000000), defaults.max_evaluations, "for each start"),
      standard("tolerance", quantity("1", 0, 0.1, true), defaults.tolerance,
               "relative change of scaled variables and objective that ends a start"),
      standard("constraint_tolerance", quantity("1", 0, 0.1, true), defaults.constraint_tolerance,
               "allowed violation, relative to the bound"),
  });
}

/// Sampled numbers and formulas of a job "compare".
Shape samples_shape(const Family* family) {
  const SamplesSpec defaults;
  std::vector<std::string> parameter_names;
  std::vector<Field> listed;
  if (family) {
    parameter_names = names_of(*family);
    for (const std::string& name : parameter_names) {
      const Parameter& p = *find_parameter(*family, name);
      listed.push_back(optional(name, parameter_shape(p), p.meaning));
    }
  }
  const Shape vary = record({
      optional("parameter", parameter_names.empty() ? text() : choice(parameter_names),
               "which parameter of the family, or number of the material or the end-effector, "
               "differs from design to design"),
      optional("symbol", text(50), "or a name of its own, for formulas"),
      optional("min", quantity(""), "least value"),
      optional("max", quantity(""), "largest value"),
      optional("scale", choice({"linear", "log"}), "even in the value (default) or its logarithm"),
      optional("points", integer(1, 1000), "of a grid, instead of samples.points"),
      optional("expression", text(),
               "formula for the parameter instead of a range: of symbols, and of parameters that "
               "have no formula or one further up, in SI"),
  });
  return record({
      standard("method", choice({"sobol", "latin_hypercube", "grid", "list"}), "sobol",
               "how the designs spread over their box, or a list of designs"),
      optional("count", integer(1, 100000), "designs; default 64; not of a grid or list"),
      optional("seed", integer(0, 4294967295.0), "of the spread; default 1; not of a grid or list"),
      optional("points", integer(1, 1000), "of a grid, for each sampled number; default 5"),
      standard("vary", list(vary, 0, 50), json::array(), "what differs from design to design"),
      optional("designs",
               list(family ? record(std::move(listed)) : any_parameters_shape(), 1, 100000),
               "of a list: parameters that differ from the job's own"),
      optional("largest_stroke", text(),
               "formula of parameters and symbols, in SI: the job's stroke points are multiplied "
               "so that the furthest gets there; default: the same stroke for all designs"),
  });
}

}  // namespace

Shape model_shape() {
  const ModelOptions model;
  const NewtonOptions newton;
  return record({
      standard("flexure", choice({"plate", "beam"}), "plate",
               "kinematics of a leaf: a thin plate, or a beam with straight lines across"),
      standard("warping", choice({"clamped", "free"}), "clamped",
               "whether the ends of a beam hold the warping of its section"),
      standard("accuracy", choice({"reduced", "full"}), "reduced",
               "superelements, or the discretisation they were made from"),
      standard("method",
               choice({"mixed_potential", "linear_craig_bampton", "modal_derivatives",
                       "quadratic_manifold"}),
               "mixed_potential", "the reduction"),
      optional("modal_derivatives", choice({"bending", "all", "third_order"}),
               "of the method modal_derivatives, the fields beside the boundary modes: derivatives "
               "of the bending modes, of all modes, or third-order fields too; default all"),
      optional("superelements", one_of({integer(1, 100), list(integer(1, 100), 2, 2)}),
               "n of two edges along a leaf, between rigid lines; of linear_craig_bampton also "
               "[along, across] of four nodes; default 1, as mixed_potential has it"),
      standard("mesh", list(integer(2, 128), 2, 2), model.mesh,
               "elements of a leaf, [along, across]"),
      standard("free_edge_torsion", boolean(), model.free_edge_torsion,
               "the three-dimensional torsion layer of the free edges; off: the thin-shell limit"),
      standard("degree", integer(5, 7), model.degree, "of the reduced potential: 5 or 7"),
      standard("mass", choice({"consistent", "constant"}), "consistent",
               "of the leaves in the frequencies: of the deflected leaf; or of the undeflected "
               "one, turned with its chord"),
      standard("leaf_modes", integer(0, 40), model.leaf_modes,
               "modes of a leaf between fixed edges kept for the frequencies, at least; 0: leaves "
               "move only as their edges make them"),
      standard("tolerance", quantity("1", 0, 1e-3, true), newton.tolerance,
               "Newton's largest last correction, lengths divided by the leaf length"),
  });
}

Shape model_entry_shape() {
  std::vector<Field> fields{required("name", text(100), "for the results; each its own")};
  for (Field field : model_shape().fields) {
    field.standard = nullptr;  // the job's own model is the default
    fields.push_back(std::move(field));
  }
  return record(std::move(fields));
}

Shape parameter_shape(const Parameter& p) {
  return quantity(p.unit, p.min, p.max, p.open_min, p.open_max);
}

const std::vector<std::string>& over_stroke_names() {
  static const std::vector<std::string> names{"min", "max", "max_abs", "first", "last"};
  return names;
}

OverStroke over_stroke_of(const std::string& name) {
  const std::vector<std::string>& names = over_stroke_names();
  return static_cast<OverStroke>(std::find(names.begin(), names.end(), name) - names.begin());
}

Shape job_shape(const Family* family) {
  const json zeros = json::array({0, 0, 0});
  const Shape load = record({
      standard("force", vector3("N", most), zeros, "dead force at O"),
      standard("moment", vector3("N m", most), zeros, "dead moment at O"),
  });
  const Shape load_path = record({
      standard("force", vector3("N", most), zeros, "dead force at O at its end"),
      standard("moment", vector3("N m", most), zeros, "dead moment at O at its end"),
      standard("points", integer(2, 10001), 11, "how many, zero and the whole load included"),
  });
  const Shape probe = record({
      required("name", text(100), "in the results"),
      required("at", vector3("m", 1e3),
               "place on an undeflected leaf; its foot on the mid-surface"),
  });
  const Shape parasitic = record({
      standard("drive", choice({"locked", "free"}), "locked", "which list of frequencies"),
      standard("skip", list(choice({"leaf", "intermediate_body"}), 0, 2), json::array(),
               "kinds of modes to leave out"),
  });
  const Shape expectation = record({
      required("pointer", text(), "into the result"),
      required("value", quantity("1"), "expected, SI"),
      required("tolerance", quantity("1", 0, Shape::infinity), "largest difference, SI"),
      standard("source", text(2000), "unnamed", "where the value comes from"),
  });
  return record({
      standard("flexopt", integer(1, 1), 1, "version of the job format"),
      standard("name", text(200), "job", "for the report"),
      standard("job", choice({"evaluate", "optimise", "compare"}), "evaluate", "what to do"),
      required("design", design_shape(family), "the mechanism"),
      standard("end_effector", end_effector_shape(), json::object(), "what the leaves carry"),
      optional("stroke", stroke_shape(family), "where the drive goes; or give load_path"),
      optional("load_path", load_path,
               "a dead load at O that grows from zero, beside loads; nothing is driven, and stroke "
               "in the results is the load factor"),
      standard("probes", list(probe, 0, 100), json::array(),
               "material points of the undeflected leaves whose displacement is wanted"),
      standard("loads", list(load, 0, 100), json::array(),
               "dead loads at O in global axes, applied before the stroke"),
      standard("model", model_shape(), json::object(), "how the mechanism is modelled"),
      standard("frequencies", integer(0, 100), 6, "how many, drive free and drive locked each"),
      standard("parasitic", parasitic, json::object(), "what the parasitic frequency is"),
      optional("optimise", optimise_shape(family), "the search, for job optimise"),
      optional("samples", samples_shape(family), "the designs, for job compare"),
      optional("models", list(model_entry_shape(), 1, 20),
               "what is compared with full accuracy, for job compare; keys left out are those of "
               "model; default: the reduced one"),
      standard("expect", list(expectation, 0, 1000), json::array(),
               "values the result must have; a job in the repository is a test"),
  });
}

}  // namespace flexopt
