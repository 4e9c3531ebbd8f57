// The section "model": its table, and what the table cannot say.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/response/path/error_estimate.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using namespace shape;

namespace {

const EnumNames<Reduction> reduction_names{
    {"mixed_potential", Reduction::mixed_potential},
    {"linear_craig_bampton", Reduction::linear_craig_bampton},
    {"modal_derivatives", Reduction::modal_derivatives},
    {"quadratic_manifold", Reduction::quadratic_manifold}};

/// Leads to a member of a ModelChoice's model.
template <class Member>
auto in_model(Member ModelOptions::*member) {
  return [member](auto& choice) -> auto& { return choice.model.*member; };
}

}  // namespace

std::string name_of(Reduction method) { return name_of(reduction_names, method); }

const RecordTable<ModelChoice>& model_table() {
  const auto read_superelements = [](const json& read, ModelChoice& choice) {
    if (read.is_array())
      read_member(read, choice.model.superelements);
    else
      choice.model.superelements = {read.get<int>(), 0};
  };
  const auto read_accuracy = [](const json& read, ModelChoice& choice) {
    choice.model.accuracy = read == "full" ? Accuracy::full : Accuracy::reduced;
    choice.accuracy.automatic = read == "auto";
  };
  static const auto table =
      RecordTable<ModelChoice>()
          .choice<Flexure>(
              "flexure", {{"plate", Flexure::plate}, {"beam", Flexure::beam}},
              in_model(&ModelOptions::flexure),
              "kinematics of a leaf: a thin plate, or a beam with straight lines across")
          .choice<Warping>("warping", {{"clamped", Warping::clamped}, {"free", Warping::free}},
                           in_model(&ModelOptions::warping),
                           "whether the ends of a beam hold the warping of its section")
          .row(shape::with_default(
                   "accuracy", shape::choice({"reduced", "full", "auto"}), "reduced",
                   "reduced: a model of few coordinates of each leaf; full: its whole mesh; auto: "
                   "that and the mesh are chosen so that estimated errors are below the "
                   "tolerance"),
               read_accuracy)
          .with_default(
              "estimate", boolean(), [](auto& choice) -> auto& { return choice.accuracy.estimate; },
              "estimated errors beside the numbers; auto has them anyway")
          .with_default(
              "largest_estimate", quantity("1", 0, 1e6, true),
              [](auto& choice) -> auto& { return choice.accuracy.largest; },
              "relative; where an estimated error is above it the status is "
              "estimate_beyond_limit, and the exit code 1; of stresses ten times as much")
          .choice<Reduction>("method", reduction_names, in_model(&ModelOptions::method),
                             "the reduction")
          .optional_choice<ModalDerivativeSet>(
              "modal_derivatives",
              {{"bending", ModalDerivativeSet::bending},
               {"all", ModalDerivativeSet::all},
               {"third_order", ModalDerivativeSet::third_order}},
              in_model(&ModelOptions::modal_derivatives),
              "of the method modal_derivatives, the fields beside the boundary modes: derivatives "
              "of the bending modes, of all modes, or third-order fields too; default all")
          .row(shape::optional("superelements",
                               one_of({integer(1, 100), list(integer(1, 100), 2, 2)}),
                               "into how many a leaf is cut along its length, by rigid lines; of "
                               "linear_craig_bampton also [along, across]; default 1, as "
                               "mixed_potential has it"),
               read_superelements)
          .with_default("mesh", list(integer(2, 128), 2, 2), in_model(&ModelOptions::mesh),
                        "elements of a leaf, [along, across]")
          .with_default(
              "free_edge_torsion", boolean(), in_model(&ModelOptions::free_edge_torsion),
              "the three-dimensional torsion layer of the free edges; off: the thin-shell limit")
          .with_default("transverse_shear", boolean(), in_model(&ModelOptions::transverse_shear),
                        "of leaves and wires; off: thin plates and slender beams")
          .with_default("degree", integer(5, 7), in_model(&ModelOptions::degree),
                        "of the reduced potential: 5 or 7")
          .choice<LeafMass>(
              "mass", {{"consistent", LeafMass::consistent}, {"constant", LeafMass::constant}},
              in_model(&ModelOptions::mass),
              "of the leaves in the frequencies: of the deflected leaf; or of the undeflected "
              "one, turned with its chord")
          .choice<AtlasUse>("atlas",
                            {{"off", AtlasUse::off},
                             {"auto", AtlasUse::automatic},
                             {"required", AtlasUse::required}},
                            in_model(&ModelOptions::atlas_use),
                            "whether the coefficients of reduced leaves are looked up in an atlas, "
                            "the one that comes along or one that flexopt atlas has made: never; "
                            "where there is one; or the job is wrong without it")
          .with_default(
              "leaf_modes", integer(0, 40), in_model(&ModelOptions::leaf_modes),
              "modes of a leaf between fixed edges kept for the frequencies, at least; 0: "
              "leaves move only as their edges make them")
          .with_default(
              "tolerance", quantity("1", 0, 1e-3, true),
              [](auto& choice) -> auto& { return choice.newton.tolerance; },
              "Newton's largest last correction, lengths divided by the leaf length; of "
              "\"accuracy\": \"auto\" the largest estimated error");
  return table;
}

ModelChoice read_model(const json& read, const JsonPointer& at, FaultList& faults) {
  ModelChoice choice = model_table().read(read);
  ModelOptions& model = choice.model;
  if (choice.accuracy.automatic)
    choice.accuracy.tolerance = std::exchange(choice.newton.tolerance, NewtonOptions{}.tolerance);
  const std::string method = name_of(model.method);
  const auto refuse = [&](const char* key, const std::string& rule) {
    faults.add(at / key, read[key].dump(), rule);
  };
  if (model.degree == 6) refuse("degree", "expected 5 or 7, the degrees of the reduced potential");
  if (!faults.sound(at / "method")) return choice;
  if (const Check has = has_estimates(model); !has && choice.accuracy.wants_estimates())
    refuse(choice.accuracy.automatic ? "accuracy" : "estimate", has.error());
  if (model.method != Reduction::modal_derivatives &&
      model.modal_derivatives != ModalDerivativeSet::all)
    refuse("modal_derivatives", fmt::format("\"method\": \"{}\" has no choice of them; expected "
                                            "\"method\": \"modal_derivatives\"",
                                            method));
  const bool one = model.superelements == std::array{1, 0}, grid = model.superelements[1] != 0;
  if (model.method == Reduction::mixed_potential && !one)
    refuse("superelements",
           "\"method\": \"mixed_potential\" makes one superelement of a leaf; expected 1, "
           "or \"method\": \"linear_craig_bampton\"");
  else if (model.method != Reduction::linear_craig_bampton && grid)
    refuse("superelements", fmt::format("\"method\": \"{}\" cuts a leaf along only: expected their "
                                        "number, or \"method\": \"linear_craig_bampton\"",
                                        method));
  if (faults.sound(at))
    if (const Check found = find_atlas(model); !found && model.atlas_use == AtlasUse::required)
      refuse("atlas", found.error());
  return choice;
}

}  // namespace flexopt
