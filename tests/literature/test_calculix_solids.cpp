// Mechanisms of leaves against the same ones in CalculiX's solid elements (C3D20R, geometrically
// nonlinear): drive load, parasitic motion, support stiffnesses and frequencies with the drive
// locked.
#include "optim/job/job.hpp"
#include "solids.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

/// The job of a case.
Job job_of(const nlohmann::json& solid) {
  nlohmann::json job{{"flexopt", 1}, {"name", "solid"}, {"job", "evaluate"}};
  job["design"] = solid.at("design");
  for (const char* number : {"youngs_modulus", "poissons_ratio", "density"})
    job["design"]["material"][number] = solid.at(number);
  const auto& inertia = solid.at("inertia");
  job["end_effector"] = {{"mass", solid.at("mass")}, {"inertia", {inertia, inertia, inertia}}};
  for (const auto& point : solid.at("path")) job["stroke"]["at"].push_back(point.at("stroke"));
  job["frequencies"] = solid.at("path").at(0).at("frequencies").size();
  return parse_job(job);
}

/// Relative differences of every quantity at every stroke stay below `bar`.
void compare(const nlohmann::json& solid, const ModelOptions& model, double bar) {
  Job job = job_of(solid);
  const Mechanism mechanism = make_mechanism(job, job.design.parameters);
  StrokeRequest request = job.request;
  request.outputs.remove(Output::stress);
  const StrokeResponse response = evaluate_stroke(mechanism, model, request);
  REQUIRE(response.status == Status::ok);
  for (std::size_t k = 0; k < response.path.size(); ++k) {
    const PathPoint& ours = response.path[k];
    const auto& theirs = solid.at("path").at(k);
    CAPTURE(ours.stroke);
    CHECK(ours.drive_load == Approx(theirs.at("drive_load").get<double>()).epsilon(bar));

    // Parasitic motion of O, relative to its largest component.
    Vector3d shift = ours.displacement, reference;
    for (int i = 0; i < 3; ++i) reference(i) = theirs.at("displacement").at(i);
    const Direction drive = drive_direction(mechanism);
    if (!is_rotation(drive)) shift(index(drive)) = reference(index(drive)) = 0;
    CHECK((shift - reference).cwiseAbs().maxCoeff() < bar * reference.cwiseAbs().maxCoeff());

    CHECK(theirs.at("support_stiffness").size() == 5);
    solids::compare_stiffness_and_modes(ours, theirs, bar);
  }
}

}  // namespace

TEST_CASE("full accuracy on 16 x 4 elements is within 0.3 % of solids", "[slow]") {
  ModelOptions model{.accuracy = Accuracy::full, .mesh = {16, 4}};
  solids::each_case(
      solids::read("calculix_solids.json").at("cases"), false,
      [&](const std::string&, const nlohmann::json& solid) { compare(solid, model, 0.003); });
}

TEST_CASE("the default model is within 0.25 % of solids", "[slow]") {
  solids::each_case(solids::read("calculix_solids.json").at("cases"), true,
                    [](const std::string&, const nlohmann::json& solid) {
                      compare(solid, ModelOptions(), 0.0025);
                    });
}

TEST_CASE("folds with bent corners are within 0.25 % of solids") {
  // but one whose corner takes 5.4 t of each leg of 100 and 125 t, and the sixth frequency of a
  // wide one, of its leaf alone
  solids::each_case(solids::read("calculix_bent_folds.json").at("cases"), true,
                    [](const std::string& name, const nlohmann::json& solid) {
                      const bool large =
                          name == "acute_fold, r = 2 t" || name == "wide_folded_leaf, r = 2 t";
                      compare(solid, ModelOptions(), large ? 0.0065 : 0.0025);
                    });
}
