// Reduced beams against full ones on the same mesh.
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

void compare(const Mechanism& mechanism, double end, Warping warping) {
  const StrokeRequest request{.points = models::evenly(end, 6), .frequencies = 6};
  const ModelOptions model{.flexure = Flexure::beam, .warping = warping};
  const StrokeResponse reduced = test::evaluated(mechanism, model, request),
                       full = test::evaluated(mechanism, test::full(model), request);
  for (std::size_t k = 0; k < full.path.size(); ++k) {
    const PathPoint &a = reduced.path[k], &b = full.path[k];
    CHECK(a.leaves[0].model == "tube");
    CHECK(a.drive_load == Approx(b.drive_load).epsilon(1e-4).margin(1e-9));
    CHECK((a.displacement - b.displacement).norm() <= 1e-5 * std::abs(end));
    CHECK(test::support_error(a, b) < 3e-3);
    CHECK(test::frequency_error(a.frequencies_locked, b.frequencies_locked) < 3e-3);
    if (k > 0) CHECK(a.max_stress->value == Approx(b.max_stress->value).epsilon(1e-3));
  }
}

}  // namespace

TEST_CASE("a reduced beam agrees with the full one, its load to 1e-4, the rest to 0.3 %") {
  for (const Warping warping : {Warping::clamped, Warping::free}) {
    compare(models::guide(0.1, 0.03, 5e-4, 0.06, 1.0), 0.02, warping);
    compare(models::three_leaf_hinge(0.06, 0.02, 4e-4), -M_PI / 6, warping);
  }
  compare(models::single_leaf(0.1, 0.01, 5e-4, Direction::rz), M_PI / 4, Warping::clamped);
}

TEST_CASE("a reduced wire agrees with the full one") {
  // four wires on the corners of a square carry a stage, driven in y and in z
  for (const Direction drive : {Direction::uy, Direction::uz}) {
    Mechanism m;
    m.drives = {make_drive(drive)};
    m.bodies = {models::body({0.08, 0, 0}, 0.2, 1e-4)};
    for (const double y : {-0.03, 0.03})
      for (const double z : {-0.03, 0.03}) {
        m.leaves.push_back(models::leaf({0, y, z}, {1, 0, 0}, 0.08, 1e-3, 1e-3));
        m.leaves.back().section = Section::circular;
      }
    // in z the leaves bend about their width only if that is where the drive bends them
    if (drive == Direction::uz)
      for (LeafSpring& l : m.leaves) {
        l.axes.col(1) = -Vector3d::UnitY();
        l.axes.col(2) = Vector3d::UnitZ();
      }
    compare(m, 0.008, Warping::clamped);
  }
}
