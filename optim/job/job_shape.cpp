#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/spec/names.hpp"
#include "designs/describe.hpp"
#include "optim/job/compared_quantity.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using namespace shape;

namespace {

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
      fields.push_back(p.default_value ? with_default(p.name, shape, *p.default_value, p.meaning)
                                       : required(p.name, shape, p.meaning));
  }
  for (const FamilyOption& option : family.options)
    fields.push_back(
        with_default(option.name, choice(option.choices), option.choices.front(), option.meaning));
  return record(std::move(fields));
}

/// What any design may hold; which parameters there must be is for the design to say.
Shape any_parameters_shape() { return map(number_or_formula(quantity(""))); }

/// The shape of a record with these fields, and more behind them.
Shape with_fields(std::vector<Field> fields, const std::vector<Field>& more) {
  fields.insert(fields.end(), more.begin(), more.end());
  return record(std::move(fields));
}

/// Whether there are parameters without default.
bool demands_parameters(const Family* family) {
  return family && std::ranges::any_of(family->parameters, [](const Parameter& p) {
           return !p.default_value.has_value();
         });
}

Shape design_shape(const Family* family) {
  std::vector<Field> fields{
      optional("family", choice(library_names()), "a design that the program brings along"),
      optional("file", text(), "or a design file, relative to the job"),
      optional("mechanism", design_file_shape(), "or a design that is written here"),
      optional(
          "result", text(),
          "or the output folder of a run, relative to the job: what it found, with its material"),
      demands_parameters(family)
          ? required("parameters", parameters_shape(*family), "what the design leaves open")
          : with_default("parameters", family ? parameters_shape(*family) : any_parameters_shape(),
                         json::object(), "what the design leaves open"),
      required("material", material_shape(true), "a built-in material by name, or its constants"),
  };
  const auto add_options = [&](const Family& known) {
    for (const FamilyOption& option : known.options)
      if (std::none_of(fields.begin(), fields.end(),
                       [&](const Field& field) { return field.name == option.name; }))
        fields.push_back(optional(option.name, choice(option.choices), option.meaning));
  };
  if (family)
    add_options(*family);
  else
    for (const Family& known : families()) add_options(known);
  return record(std::move(fields));
}

/// Names of quantities where the table of the section leaves any text. A job may define others.
Shape with_quantities(Shape section, const Family* family) {
  if (!family) return section;
  for (Field& field : section.fields)
    if (field.name == "quantity")  // a name that the job gives, or one of the table
      field.shape = one_of({text(), choice(names_in(quantities(family->drives)))});
  return section;
}

Shape variable_shape(const Family* family) {
  return record({
      required("parameter", family ? choice(parameter_names(*family)) : text(),
               "which parameter of the family, or number of the material or the end-effector"),
      required("min", quantity(""), "lower bound"),
      required("max", quantity(""), "upper bound"),
      optional("start", quantity(""), "where the first start begins; default: the job's value"),
      optional("stock", list(quantity(""), 1, 1000),
               "sizes there are to buy: the optimum takes one of them"),
      optional("step", quantity(""), "or: the optimum is a multiple of this"),
  });
}

Shape optimise_shape(const Family* family) {
  return with_fields(
      {
          required("variables", list(variable_shape(family), 1, 50), "what may change"),
          required("objective", objective_table().shape(), "what should become best"),
          with_default("constraints",
                       list(with_quantities(constraint_table().shape(), family), 0, 200),
                       json::array(), "what must hold"),
          with_default("algorithm", algorithm_table().shape(), json::object(), "who searches"),
          optional("pareto", with_quantities(pareto_table().shape(), family),
                   "a second objective: the front of both"),
          optional("verify", verify_table().shape(), "the optimum is to be that of full accuracy"),
      },
      search_table().fields());
}

Shape map_shape(const Family* family) {
  const Shape axis = record(
      {required("parameter", family ? choice(parameter_names(*family)) : text(),
                "which parameter of the family, or number of the material or the end-effector"),
       optional("min", quantity(""),
                "where it begins; default: where it does as a variable of \"optimise\""),
       optional("max", quantity(""), "where it ends; default: as min")});
  Shape measure =
      with_quantities(constraint_table().shape(), family);  // without bounds and tolerances
  std::erase_if(measure.fields, [](const Field& field) {
    return field.name != "quantity" && field.name != "expression" && field.name != "over_stroke" &&
           field.name != "case";
  });
  return with_fields({required("parameters", list(axis, 2, 2), "the two that vary, across and up"),
                      optional("quantities", list(measure, 1, 50),
                               "what is drawn; default: objective and constraints")},
                     map_table().fields());
}

/// An entry of "vary".
Shape vary_shape(const Family* family) {
  return with_fields(
      {
          optional("parameter", family ? choice(parameter_names(*family)) : text(),
                   "which parameter of the family, or number of the material or the end-effector, "
                   "differs from design to design"),
          optional("symbol", text(50), "or a name of its own, for formulas"),
          optional("min", quantity(""), "least value"),
          optional("max", quantity(""), "largest value"),
          optional(
              "expression", text(),
              "formula for the parameter instead of a range: of symbols, and of parameters that "
              "have no formula or one further up, in SI"),
      },
      range_table().fields());
}

/// Schema of the stroke of a design whose drives are not known here: strokes of one drive, or of
/// several by name.
json any_stroke(const json& of_one) {
  const json number{{"anyOf", json::array({{{"type", "number"}}, {{"type", "string"}}})}};
  const json point{{"type", "object"}, {"additionalProperties", number}};
  const json axis{{"type", "object"},
                  {"properties", {{"from", number}, {"to", number}, {"points", number}}},
                  {"additionalProperties", false}};
  const json named{
      {"type", "object"},
      {"properties",
       {{"at", {{"type", "array"}, {"minItems", 1}, {"maxItems", 10001}, {"items", point}}},
        {"grid", {{"type", "object"}, {"additionalProperties", axis}}}}},
      {"additionalProperties", false}};
  return {{"description", of_one.value("description", "")},
          {"anyOf", json::array({of_one, named})}};
}

Shape parasitic_shape() {
  return record({
      with_default("drive", choice({"locked", "free"}), "locked", "which list of frequencies"),
      with_default("skip", list(choice({"leaf", "intermediate_body"}), 0, 2), json::array(),
                   "kinds of modes to leave out"),
  });
}

/// Sampled numbers and formulas of a job "compare".
Shape samples_shape(const Family* family) {
  std::vector<Field> listed;
  if (family)
    for (const std::string& name : parameter_names(*family)) {
      const Parameter& p = *find_parameter(*family, name);
      listed.push_back(optional(name, parameter_shape(p), p.meaning));
    }
  return with_fields(
      samples_table().fields(),
      {optional("points", integer(1, 1000), "of a grid, for each sampled number; default 5"),
       with_default("vary", list(vary_shape(family), 0, 50), json::array(),
                    "what differs from design to design"),
       optional("designs",
                list(family ? record(std::move(listed)) : any_parameters_shape(), 1, 100000),
                "of a list: parameters that differ from the job's own"),
       optional("largest_stroke", text(),
                "formula of parameters and symbols, in SI: the job's stroke points are multiplied "
                "so that the furthest gets there; default: the same stroke for all designs")});
}

/// An entry of "models": a name and any keys of the model.
Shape model_entry_shape() {
  std::vector<Field> fields{required("name", text(100), "for the results; each its own")};
  for (Field field : model_shape().fields) {
    field.default_value = nullptr;  // the job's own model is the default
    fields.push_back(std::move(field));
  }
  return record(std::move(fields));
}

}  // namespace

Shape model_shape() { return model_table().shape(); }

Shape parameter_shape(const Parameter& p) {
  return quantity(p.unit, p.min, p.max, p.open_min, p.open_max);
}

bool chooses_accuracy(const json& document) {
  const auto model = document.is_object() ? document.find("model") : document.end();
  return model != document.end() && model->is_object() && model->contains("accuracy") &&
         (*model)["accuracy"] == "auto";
}

Shape with_error_tolerance(Shape job) {
  constexpr double largest = 0.1;
  const auto field = [](Shape& of, const char* name) -> Field& {
    return *std::ranges::find(of.fields, name, &Field::name);
  };
  Field& tolerance = field(field(job, "model").shape, "tolerance");
  tolerance = with_default("tolerance", quantity("1", 0, largest, true), AccuracySpec{}.tolerance,
                           tolerance.meaning);
  return job;
}

Shape job_shape(const Family* family) {
  const DriveList drives = family ? family->drives : DriveList();
  std::vector<Field> fields{with_default("flexopt", integer(1, 1), 1, "version of the job format")};
  const std::vector<Field>& head = head_table().fields();
  fields.insert(fields.end(), head.begin(), head.end());
  const std::vector<Field> sections{
      required("design", design_shape(family), "the mechanism"),
      with_default("end_effector", end_effector_table().shape(), json::object(),
                   "what the leaves carry"),
      optional("stroke", stroke_shape(family ? &drives : nullptr),
               "where the drive goes; or give load_path"),
      optional("load_path", load_path_table().shape(),
               "a load at O that grows from zero, beside loads; nothing is driven, and stroke "
               "in the results is the load factor"),
      with_default("loads", list(load_table().shape(), 0, 100), json::array(),
                   "loads on bodies in global axes, applied before the stroke"),
      optional("gravity", vector3("m/s^2", 1e6),
               "acceleration that acts on bodies and leaves, global axes, before the stroke"),
      optional("temperature", temperature_shape(),
               "how much warmer leaves are than the bodies that hold them, before the stroke"),
      with_default("assembly", mounting_shape(), json::array(),
                   "edges that sit in their bodies other than designed, before the stroke; or the "
                   "steps in which these and the loads come"),
      optional("buckling",
               record({required("load", text(100),
                                "name of the dead load that grows, all else kept, until the "
                                "tangent is singular"),
                       with_default("largest_factor", quantity("1", 1, no_critical_factor), 50,
                                    "up to which it grows, and is reversed: larger factors are "
                                    "not looked for")}),
               "at every point the factor of a load at which the mechanism becomes unstable"),
      load_capacity_field(),
      stroke_capacity_field(family ? &drives : nullptr),
      optional("held", list(text(100), 1, 6),
               "drives that keep their strokes in all that is said of free drives, and for "
               "stability: the others carry constant loads"),
      with_default("branch", choice({"primary", "stable"}), "primary",
                   "where branches of equilibria meet: the one that the path comes along, or the "
                   "one that is stable"),
      with_default("stable_states", boolean(), false,
                   "whether every point lists the stable equilibria that are found, with energies"),
      with_default("model", model_shape(), json::object(), "how the mechanism is modelled"),
      optional("limits", limits_table().shape(),
               "what the evaluation of one design may take, for each load case and model: beyond "
               "it the design counts as one without an answer"),
      with_default("parasitic", parasitic_shape(), json::object(),
                   "what the parasitic frequency is"),
      optional("optimise", optimise_shape(family), "the search, for job optimise"),
      optional("samples", samples_shape(family), "the designs, for job compare"),
      optional("models", list(model_entry_shape(), 1, 20),
               "what is compared with full accuracy, for job compare; keys left out are those of "
               "model; default: the reduced one"),
      optional("quantities",
               list(one_of({choice(comparable_quantities()),
                            record({required("name", text(50), "what results and goals call it"),
                                    required("expression", text(),
                                             "a formula of quantities, parameters and quantities "
                                             "that are defined further up")})}),
                    1, 100),
               "quantities that the job defines; and names of those whose errors are wanted, for "
               "job compare, by default drive load, motion, stiffness, stress, frequencies, and "
               "what other sections of the job ask for"),
      with_default("expect", list(expectation_table().shape(), 0, 1000), json::array(),
                   "values the result must have; a job in the repository is a test"),
  };
  fields.insert(fields.end(), sections.begin(), sections.end());
  for (Field& field : point_fields()) fields.push_back(std::move(field));
  for (Field& field : stress_fields()) fields.push_back(std::move(field));
  for (Field& field : dynamics_fields()) fields.push_back(std::move(field));
  return with_fields(
      std::move(fields),
      {cases_field(sections),
       optional("maps", list(map_shape(family), 1, 20),
                "quantities over two parameters, on reduced leaves, all else as in the design or, "
                "of an optimisation, at the optimum"),
       tolerances_field(), assembly_tolerances_field(), tolerance_samples_field()});
}

json job_schema() {
  json schema = json_schema(with_error_tolerance(job_shape(nullptr)));
  json& cases = schema["properties"]["cases"]["anyOf"];  // by their names, or a list
  for (json* of : {&schema["properties"], &cases[0]["additionalProperties"]["properties"],
                   &cases[1]["items"]["properties"]})
    (*of)["stroke"] = any_stroke((*of)["stroke"]);
  schema["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  schema["title"] = "A job of flexopt";
  schema["properties"]["design"]["additionalProperties"] = {
      {"type", "string"}, {"description", "an option of the design file"}};
  json by_family = json::array();  // each family's own parameters and unit of the stroke
  for (const Family& family : families()) {
    const json whole = json_schema(job_shape(&family));
    const json is_family{{"properties",
                          {{"design",
                            {{"properties", {{"family", {{"const", family.name}}}}},
                             {"required", json::array({"family"})}}}}},
                         {"required", json::array({"design"})}};
    const json then{{"properties",
                     {{"design", whole["properties"]["design"]},
                      {"stroke", whole["properties"]["stroke"]},
                      {"cases", whole["properties"]["cases"]},
                      {"optimise", whole["properties"]["optimise"]},
                      {"samples", whole["properties"]["samples"]},
                      {"maps", whole["properties"]["maps"]}}}};
    by_family.push_back({{"if", is_family}, {"then", then}});
  }
  schema["allOf"] = std::move(by_family);
  add_designs_to_schema(schema);
  return schema;
}

}  // namespace flexopt
