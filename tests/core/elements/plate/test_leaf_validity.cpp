// Estimates of what a cheaper model of a leaf would cost.
#include <catch2/catch.hpp>

#include "core/elements/plate/leaf_validity.hpp"
#include "core/response/response.hpp"
#include "support/models.hpp"

using namespace flexopt;

TEST_CASE("slender leaves are beams, wide ones plates, wires always beams") {
  const auto needed = [](double length, double width, double thickness,
                         Section section = Section::rectangular) {
    LeafSpring leaf = models::leaf({0, 0, 0}, {1, 0, 0}, length, width, thickness);
    leaf.section = section;
    return leaf_validity(leaf).needed;
  };
  CHECK(needed(0.1, 1e-3, 2e-4) == "beam");
  CHECK(needed(0.1, 0.01, 5e-4) == "beam_with_warping");
  CHECK(needed(0.1, 0.03, 5e-4) == "plate");
  CHECK(needed(0.1, 0.2, 5e-4) == "plate");
  CHECK(needed(0.01, 1e-3, 1e-3, Section::circular) == "beam");
}

TEST_CASE(
    "the estimated error of a beam's support stiffness is within a factor of three of the "
    "difference to the plate") {
  for (const double width : {0.03, 0.1}) {
    const Mechanism m = models::guide(0.1, width, 5e-4);
    StrokeRequest request;
    request.points = {0, 0.0075, 0.015};
    request.outputs.remove(Output::stress);
    ModelOptions model;
    model.accuracy = Accuracy::full;
    const StrokeResponse plate = evaluate_stroke(m, model, request);
    model.flexure = Flexure::beam;
    const StrokeResponse beam = evaluate_stroke(m, model, request);
    REQUIRE(plate.status == Status::ok);
    REQUIRE(beam.status == Status::ok);
    double worst = 0;
    for (std::size_t k = 0; k < plate.path.size(); ++k)
      for (int d = 0; d < 6; ++d)
        if (plate.path[k].support_stiffness[d])
          worst = std::max(worst, std::abs(*beam.path[k].support_stiffness[d] /
                                               *plate.path[k].support_stiffness[d] -
                                           1));
    const double estimated = leaf_validity(m.leaves[0]).beam;
    CAPTURE(width, worst, estimated);
    CHECK(estimated < 3 * worst);
    CHECK(worst < 3 * estimated);
  }
}

TEST_CASE("a narrow plate bends in its plane as its beam does") {
  for (const double ratio : {3.0, 4.0, 5.0, 7.0, 10.0}) {
    const Mechanism m = models::guide(0.1, ratio * 1e-3, 1e-3);
    StrokeRequest request;
    request.points = {0};
    request.outputs.remove(Output::stress);
    ModelOptions model;
    model.accuracy = Accuracy::full;
    model.mesh = {24, 8};
    const StrokeResponse plate = evaluate_stroke(m, model, request);
    model.flexure = Flexure::beam;
    const StrokeResponse beam = evaluate_stroke(m, model, request);
    REQUIRE(plate.status == Status::ok);
    REQUIRE(beam.status == Status::ok);
    for (const Direction d : {Direction::uz, Direction::ry}) {
      CAPTURE(ratio, direction_names[index(d)]);
      // the clamps hinder the section, which only the plate knows
      CHECK(*plate.path[0].support_stiffness[index(d)] ==
            Approx(*beam.path[0].support_stiffness[index(d)]).epsilon(2.5e-3));
    }
  }
}
