// The tables of "optimise", "maps" and "samples".
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using namespace shape;

namespace {

const EnumNames<OverStroke> over_stroke_names{{"min", OverStroke::min},
                                              {"max", OverStroke::max},
                                              {"max_abs", OverStroke::max_abs},
                                              {"first", OverStroke::first},
                                              {"last", OverStroke::last}};

const EnumNames<SampleMethod> sample_method_names{
    {"sobol", SampleMethod::sobol},
    {"latin_hypercube", SampleMethod::latin_hypercube},
    {"grid", SampleMethod::grid},
    {"list", SampleMethod::list}};

Shape seed_shape() { return integer(0, 4294967295.0); }

constexpr const char* case_meaning = "the load case that counts; default: the worst of all";

/// Which number a constraint or the second objective of a front is about.
template <class Goal>
RecordTable<Goal> measure_table(const char* formula) {
  return RecordTable<Goal>()
      .optional("quantity", text(), &Goal::quantity, "a quantity of a path point")
      .optional("expression", text(), &Goal::expression, formula)
      .template optional_choice<OverStroke>(
          "over_stroke", over_stroke_names, &Goal::over_stroke,
          "how the values over the stroke become one; default: the worst")
      .optional("case", text(100), &Goal::load_case, case_meaning)
      .other(under_field())
      .other(margin_field());
}

}  // namespace

std::string name_of(OverStroke over) { return name_of(over_stroke_names, over); }
std::string name_of(SampleMethod method) { return name_of(sample_method_names, method); }

const RecordTable<OptimiseSpec>& search_table() {
  static const auto table =
      RecordTable<OptimiseSpec>()
          .choice<SearchKind>("search",
                              {{"starts", SearchKind::starts}, {"global", SearchKind::global}},
                              &OptimiseSpec::search,
                              "where the starts are from: the job's values and a spread over the "
                              "box, or the best of the clusters of many screened designs")
          .optional("screened_designs", integer(2, 1000000), &OptimiseSpec::screened_designs,
                    "of a global search, on reduced leaves, before the starts; default: 2000 for "
                    "each variable, rounded up to a power of two, at most 65536")
          .optional("starts", integer(1, 1000), &OptimiseSpec::starts,
                    "starts: the first at the job's values, the others spread over the box; of a "
                    "global search, from as many clusters; default 1, of a global search 8")
          .choice<Spread>("spread",
                          {{"sobol", Spread::sobol}, {"latin_hypercube", Spread::latin_hypercube}},
                          &OptimiseSpec::spread, "how the starts but the first are spread")
          .with_default("seed", seed_shape(), &OptimiseSpec::seed, "of the spread of the starts")
          .with_default("max_evaluations", integer(1, 1000000), &OptimiseSpec::max_evaluations,
                        "for each start")
          .with_default(
              "tolerance", quantity("1", 0, 0.1, true), &OptimiseSpec::tolerance,
              "a start with gradients ends where kkt_residual is at most a tenth of this, one "
              "without where scaled variables and objective change by less, relative")
          .with_default("constraint_tolerance", quantity("1", 0, 0.1, true),
                        &OptimiseSpec::constraint_tolerance,
                        "allowed violation, relative to the bound");
  return table;
}

const RecordTable<Objective>& objective_table() {
  static const auto table =
      RecordTable<Objective>()
          .other(shape::optional(
              "maximise", text(),
              "a quantity of a path point, or a formula of quantities and parameters"))
          .other(shape::optional("minimise", text(), "the same, to be made small"))
          .optional_choice<OverStroke>(
              "over_stroke", over_stroke_names, &Objective::over_stroke,
              "how its values over the stroke become one; default: the worst")
          .optional("case", text(100), &Objective::load_case, case_meaning)
          .other(under_field())
          .other(margin_field());
  return table;
}

const RecordTable<Constraint>& constraint_table() {
  static const auto table = measure_table<Constraint>("or a formula of quantities and parameters")
                                .other(shape::optional("min", shape::quantity(""), "lower bound"))
                                .other(shape::optional("max", shape::quantity(""), "upper bound"));
  return table;
}

const RecordTable<Algorithm>& algorithm_table() {
  static const auto table =
      RecordTable<Algorithm>()
          .with_default("library", shape::choice({"nlopt", "ipopt"}), &Algorithm::library,
                        "optimiser")
          .optional(
              "name", text(), &Algorithm::name,
              "NLopt's name of the algorithm; default LD_SLSQP, or LN_COBYLA where the model of "
              "the leaves has no exact derivatives")
          .optional("local", text(), &Algorithm::local,
                    "what runs inside AUGLAG or MLSL, by NLopt's name");
  return table;
}

const RecordTable<VerifySpec>& verify_table() {
  static const auto table =
      RecordTable<VerifySpec>()
          .with_default(
              "tolerance", quantity("1", 0, 0.1, true), &VerifySpec::tolerance,
              "largest difference to full accuracy, relative, of objective and constraints")
          .with_default("max_full_evaluations", integer(1, 1000), &VerifySpec::max_full_evaluations,
                        "evaluations at full accuracy");
  return table;
}

const RecordTable<ParetoSpec>& pareto_table() {
  static const auto table = measure_table<ParetoSpec>("or a formula of quantities and parameters")
                                .choice<bool>("sense", {{"minimise", false}, {"maximise", true}},
                                              &ParetoSpec::maximise, "which way is better")
                                .with_default("points", integer(2, 200), &ParetoSpec::points,
                                              "designs on the front, both ends included");
  return table;
}

const RecordTable<MapSpec>& map_table() {
  static const auto table = RecordTable<MapSpec>().with_default(
      "points", list(integer(2, 1000), 2, 2), &MapSpec::points, "values of each, ends included");
  return table;
}

const RecordTable<SamplesSpec>& samples_table() {
  static const auto table =
      RecordTable<SamplesSpec>()
          .choice<SampleMethod>("method", sample_method_names, &SamplesSpec::method,
                                "how the designs spread over their box, or a list of designs")
          .optional("count", integer(1, 100000), &SamplesSpec::count,
                    "designs; default 64; not of a grid or list")
          .optional("seed", seed_shape(), &SamplesSpec::seed,
                    "of the spread; default 1; not of a grid or list");
  return table;
}

const RecordTable<SampleRange>& range_table() {
  static const auto table =
      RecordTable<SampleRange>()
          .optional_choice<bool>("scale", {{"linear", false}, {"log", true}},
                                 &SampleRange::logarithmic,
                                 "even in the value (default) or its logarithm")
          .optional("points", integer(1, 1000), &SampleRange::points,
                    "of a grid, instead of samples.points");
  return table;
}

}  // namespace flexopt
