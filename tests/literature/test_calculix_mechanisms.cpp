// Mechanisms of several bodies, folds, wires and several drives against the same ones in CalculiX's
// solid elements: drive stiffnesses and loads, support stiffnesses, frequencies with the drives
// held, at rest and deflected.
#include "optim/job/job.hpp"
#include "solids.hpp"

using namespace flexopt;

namespace {

// A number, or one for each drive by name.
double of_drive(const nlohmann::json& numbers, const PathPoint& point, std::size_t drive) {
  return numbers.is_object() ? numbers.at(point.drive_names.at(drive)).get<double>()
                             : numbers.get<double>();
}

void compare_point(const PathPoint& ours, const nlohmann::json& theirs, double bar) {
  for (std::size_t d = 0; d < ours.drive_loads.size(); ++d) {
    CAPTURE(d);
    if (theirs.contains("drive_load"))
      CHECK(ours.drive_loads[d] == Approx(of_drive(theirs.at("drive_load"), ours, d)).epsilon(bar));
    if (theirs.contains("drive_stiffness"))
      CHECK(ours.drive_stiffnesses[d] ==
            Approx(of_drive(theirs.at("drive_stiffness"), ours, d)).epsilon(bar));
  }
  if (!theirs.contains("support_stiffness")) return;
  REQUIRE(theirs.at("frequencies").size() == 6);
  solids::compare_stiffness_and_modes(ours, theirs, bar);
}

void compare(const nlohmann::json& solid, Accuracy accuracy, double bar) {
  Job job = parse_job(solid.at("job"));
  job.model.accuracy = accuracy;
  if (accuracy == Accuracy::full && job.model.flexure == Flexure::plate) job.model.mesh = {20, 6};
  job.request.outputs.remove(Output::stress);
  const StrokeResponse response =
      evaluate_stroke(make_mechanism(job, job.design.parameters), job.model, job.request);
  REQUIRE(response.status == Status::ok);
  REQUIRE(response.path.size() >= solid.at("path").size());
  for (std::size_t k = 0; k < solid.at("path").size(); ++k) {
    CAPTURE(k);
    compare_point(response.path[k], solid.at("path").at(k), bar);
  }
}

}  // namespace

TEST_CASE("families on 20 x 6 elements are within 0.25 % of solids", "[slow]") {
  solids::each_case(solids::read("calculix_mechanisms.json"), false,
                    [](const std::string&, const nlohmann::json& solid) {
                      compare(solid, Accuracy::full, 0.0025);
                    });
}

TEST_CASE("families by default are within 0.25 % of solids", "[slow]") {
  solids::each_case(solids::read("calculix_mechanisms.json"), true,
                    [](const std::string&, const nlohmann::json& solid) {
                      compare(solid, Accuracy::reduced, 0.0025);
                    });
}
