// Estimates of what a cheaper model of a leaf would cost.
#include "core/elements/plate/leaf_validity.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

struct PlateAndBeam {
  StrokeResponse plate, beam;
};
PlateAndBeam plate_and_beam(const Mechanism& m, const std::vector<double>& strokes,
                            std::array<int, 2> mesh) {
  const StrokeRequest request{.points = strokes, .outputs = test::without_stress()};
  ModelOptions model{.accuracy = Accuracy::full, .mesh = mesh};
  const StrokeResponse plate = test::evaluated(m, model, request);
  model.flexure = Flexure::beam;
  return {plate, test::evaluated(m, model, request)};
}

}  // namespace

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
    "a beam's support stiffness has an estimate within three times its difference to the plate") {
  for (const double width : {0.03, 0.1}) {
    const Mechanism m = models::guide(0.1, width, 5e-4);
    const auto [plate, beam] = plate_and_beam(m, {0, 0.0075, 0.015}, default_mesh);
    double worst = 0;
    for (std::size_t k = 0; k < plate.path.size(); ++k)
      worst = std::max(worst, test::support_error(beam.path[k], plate.path[k]));
    const double estimated = leaf_validity(m.leaves[0]).beam;
    CAPTURE(width, worst, estimated);
    CHECK(estimated < 3 * worst);
    CHECK(worst < 3 * estimated);
  }
}

TEST_CASE("a narrow plate bends in its plane as its beam does") {
  for (const double ratio : {3.0, 4.0, 5.0, 7.0, 10.0}) {
    const Mechanism m = models::guide(0.1, ratio * 1e-3, 1e-3);
    const auto [plate, beam] = plate_and_beam(m, {0}, {24, 8});
    for (const Direction d : {Direction::uz, Direction::ry}) {
      CAPTURE(ratio, direction_names[index(d)]);
      // the clamps hinder the section, which only the plate knows
      CHECK(*plate.path[0].support_stiffness[index(d)] ==
            Approx(*beam.path[0].support_stiffness[index(d)]).epsilon(2.5e-3));
    }
  }
}
