// Mechanisms of several bodies, folds, wires and several drives against the same ones in CalculiX's
// solid elements: drive stiffnesses and loads, support stiffnesses, frequencies with the drives
// held, at rest and deflected. How the numbers were made: tests/benchmarks/calculix/README.md.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/response/response.hpp"
#include "optim/job/job.hpp"
#include "support/nightly.hpp"

using namespace flexopt;

namespace {

nlohmann::json mechanisms() {
  std::ifstream file(FLEXOPT_LITERATURE "/calculix_mechanisms.json");
  return nlohmann::json::parse(file);
}

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
  for (const auto& [name, value] : theirs.at("support_stiffness").items()) {
    CAPTURE(name);
    const auto found = std::find(direction_names.begin(), direction_names.end(), name);
    REQUIRE(found != direction_names.end());
    const auto& stiffness =
        ours.support_stiffness[static_cast<std::size_t>(found - direction_names.begin())];
    REQUIRE(stiffness.has_value());
    CHECK(*stiffness == Approx(value.get<double>()).epsilon(bar));
  }
  REQUIRE(theirs.at("frequencies").size() == 6);
  for (std::size_t i = 0; i < 6; ++i) {
    CAPTURE(i);
    CHECK(ours.frequencies_locked.at(i) ==
          Approx(theirs.at("frequencies").at(i).get<double>()).epsilon(bar));
  }
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
  const nlohmann::json all = mechanisms();
  int number = 0;
  for (const auto& [name, solid] : all.items()) {
    if (number++ % 3 != 0 && !test::nightly()) continue;
    CAPTURE(name);
    compare(solid, Accuracy::full, 0.0025);
  }
}

TEST_CASE("families by default are within 0.25 % of solids", "[slow]") {
  const nlohmann::json all = mechanisms();
  for (const auto& [name, solid] : all.items()) {
    CAPTURE(name);
    compare(solid, Accuracy::reduced, 0.0025);
  }
}
