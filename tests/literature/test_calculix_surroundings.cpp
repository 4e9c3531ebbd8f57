// Guides and hinges that are bolted down crooked, warm or heavy against the same ones in CalculiX's
// solid elements.
#include "designs/family.hpp"
#include "solids.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

Vector3d vector_of(const nlohmann::json& read) {
  return {read.at(0).get<double>(), read.at(1).get<double>(), read.at(2).get<double>()};
}

Mechanism build(const nlohmann::json& solid) {
  const Family& family = find_family(solid.at("design").at("family"), "");
  ParameterValues values;
  for (const Parameter& p : family.parameters)
    if (p.default_value) values[p.name] = *p.default_value;
  for (const auto& [name, value] : solid.at("design").at("parameters").items())
    values[name] = value;
  EndEffector payload;
  payload.mass = solid.at("mass");
  payload.inertia = solid.at("inertia").get<double>() * Matrix3d::Identity();
  Material material{
      "steel", solid.at("youngs_modulus"), solid.at("poissons_ratio"), solid.at("density"), {}};
  material.thermal_expansion = solid.at("thermal_expansion");
  return family.make(values, default_choices(family), material, payload);
}

LoadCase loads_of(const nlohmann::json& solid) {
  LoadCase loads;
  const Vector3d turn = vector_of(solid.at("turn")), move = vector_of(solid.at("move"));
  if (!turn.isZero(0) || !move.isZero(0)) loads.assembly = {{0, 0, move, turn}};
  loads.temperature = solid.at("warmth").get<std::vector<double>>();
  loads.gravity = vector_of(solid.at("gravity"));
  return loads;
}

/// Relative differences of every quantity at every stroke stay below `bar`; motions relative to the
/// largest of the case.
void compare(const nlohmann::json& solid, const ModelOptions& model, double bar) {
  const Mechanism mechanism = build(solid);
  StrokeRequest request;
  request.points.clear();
  for (const auto& point : solid.at("path")) request.points.push_back(point.at("stroke"));
  request.frequencies = 6;
  request.loads = loads_of(solid);
  request.outputs.remove(Output::stress);
  request.outputs.remove(Output::frequency_derivatives);
  const StrokeResponse response = evaluate_stroke(mechanism, model, request);
  INFO(response.message);
  REQUIRE(response.status == Status::ok);
  const int drive = index(drive_direction(mechanism));
  Vector6d largest;  // of less than that nothing can be said
  largest << Vector3d::Constant(1e-7), Vector3d::Constant(1e-6);
  for (const PathPoint& ours : response.path) {
    Vector6d motion;
    motion << ours.displacement, ours.rotation;
    motion[drive] = 0;
    largest.head<3>() = largest.head<3>().cwiseMax(motion.head<3>().cwiseAbs().maxCoeff());
    largest.tail<3>() = largest.tail<3>().cwiseMax(motion.tail<3>().cwiseAbs().maxCoeff());
  }
  double load = 0;
  for (const auto& theirs : solid.at("path"))
    load = std::max(load, std::abs(theirs.at("drive_load").get<double>()));
  for (std::size_t k = 0; k < response.path.size(); ++k) {
    const PathPoint& ours = response.path[k];
    const auto& theirs = solid.at("path").at(k);
    CAPTURE(ours.stroke);
    const double force = theirs.at("drive_load");
    // forces of weight and stroke may all but cancel
    CHECK(std::abs(ours.drive_load - force) < bar * std::max(std::abs(force), 0.05 * load));
    for (int i = 0; i < 6; ++i) {
      if (i == drive) continue;
      CAPTURE(i);
      const double moved =
          theirs.at(i < 3 ? "displacement" : "rotation").at(static_cast<std::size_t>(i % 3));
      const double own = i < 3 ? ours.displacement[i] : ours.rotation[i - 3];
      CHECK(std::abs(own - moved) < bar * largest[i]);
    }
    if (theirs.contains("support_stiffness"))
      solids::compare_stiffness_and_modes(ours, theirs, bar);
  }
}

}  // namespace

TEST_CASE("crooked, warm and heavy mechanisms are within 1 % of solids", "[slow]") {
  ModelOptions full;
  full.accuracy = Accuracy::full;
  full.mesh = {16, 4};
  const nlohmann::json cases = solids::read("calculix_surroundings.json");
  REQUIRE(cases.size() > 10);
  solids::each_case(cases, false, [&](const std::string&, const nlohmann::json& solid) {
    compare(solid, full, 0.01);
  });
  solids::each_case(cases, true, [](const std::string&, const nlohmann::json& solid) {
    compare(solid, {}, 0.01);
  });
}
