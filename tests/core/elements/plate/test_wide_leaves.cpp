// Wide leaves in their plane: (E16) and (E17) of core/elements/README.md.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/response/response.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

/// Stiffness over the thickness of a leaf that is moved along one direction, all others held.
double per_thickness(double width, double thickness, Direction along, std::array<int, 2> mesh) {
  constexpr double length = 0.06;
  Mechanism mechanism;
  mechanism.drives = {make_drive(along)};
  mechanism.bodies = {models::body({length, 0, 0}, 1, 1e-4)};
  mechanism.leaves = {models::leaf({0, 0, 0}, {1, 0, 0}, length, width, thickness)};
  for (int d = 0; d < 6; ++d)
    mechanism.bodies[0].held[static_cast<std::size_t>(d)] = d != index(along);
  ModelOptions model;
  model.accuracy = Accuracy::full;
  model.mesh = mesh;
  StrokeRequest request;
  request.points = {0};
  request.outputs = {Output::equilibrium, Output::stiffness};
  const StrokeResponse response = evaluate_stroke(mechanism, model, request);
  REQUIRE(response.status == Status::ok);
  return 1 / response.path[0].compliance_free(index(along), index(along)) / thickness;
}

}  // namespace

TEST_CASE("in its plane a guided leaf is as stiff as it is thick", "[plate]") {
  const double aspect = GENERATE(1.0, 1.5, 2.0, 3.0, 5.0), w = 0.06 / aspect;
  const Direction along = GENERATE(Direction::uz, Direction::ux);
  for (const std::array<int, 2>& mesh : {default_mesh, std::array{20, 8}}) {
    const double thin = per_thickness(w, w / 400, along, mesh);
    for (const double ratio : {50.0, 25.0, 12.0}) {
      CAPTURE(aspect, ratio, along, mesh[0]);
      CHECK(per_thickness(w, w / ratio, along, mesh) == Approx(thin).epsilon(1e-3));
    }
  }
}
