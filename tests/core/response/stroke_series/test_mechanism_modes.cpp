#include "core/response/stroke_series/mechanism_modes.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/elements/plate/full_leaf.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/stroke_series/mechanism_series.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

Mechanism lopsided() {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies[0].mass = 0.3;
  m.bodies[0].inertia = Vector3d(1e-4, 2e-4, 3e-4).asDiagonal();
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.004, -0.003);
  return m;
}

System system_of(const Mechanism& m) {
  ModelOptions model;
  model.accuracy = Accuracy::full;
  model.flexure = Flexure::beam;
  model.mesh = {6, 1};
  System system(m, make_full_leaves(m, model));
  system.assemble();
  return system;
}

/// All degrees of freedom moved by y, leaf interiors too.
System moved(const Mechanism& m, const VectorXd& y) {
  System system = system_of(m);
  system.move(y.head(system.size()));
  int offset = system.size();
  for (int i = 0; i < system.leaves(); ++i) {
    PlateLeaf& plate = static_cast<FullLeaf&>(system.leaf(i)).plate();
    PlateLeaf::State state = PlateLeaf::undeflected(plate.mesh());
    state.edges = plate.state().edges;
    state.x += y.segment(offset, plate.unknowns());
    plate.set_state(state);
    offset += plate.unknowns();
  }
  system.invalidate();
  system.assemble();
  return system;
}

}  // namespace

TEST_CASE("modal derivatives of a mechanism are the differences of its modes",
          "[response][modal_derivatives]") {
  const Mechanism m = lopsided();
  System system = system_of(m);
  const int count = 3;
  const auto kept = mechanism_modes(system, count, ModalInertia::kept);
  const auto left_out = mechanism_modes(system, count);
  REQUIRE(kept);
  REQUIRE(left_out);
  double inertia = 0;
  for (int j = 0; j < count; ++j) {
    const VectorXd phi = kept->modes.col(j);
    // the leaves' unknowns are lengths over L, and slopes
    const double h = 3e-5 / phi.tail(phi.size() - 6).cwiseAbs().maxCoeff();
    const auto modes_at = [&](double step) {
      System at = moved(m, step * phi);
      const auto found = mechanism_modes(at, count);
      REQUIRE(found);
      MatrixXd shapes = found->modes;
      for (int i = 0; i < count; ++i)
        if (shapes.col(i).dot(kept->modes.col(i)) < 0) shapes.col(i) *= -1;
      return shapes;
    };
    const MatrixXd difference =
        (8 * (modes_at(h) - modes_at(-h)) - (modes_at(2 * h) - modes_at(-2 * h))) / (12 * h);
    for (int i = 0; i < count; ++i) {
      const VectorXd theta = kept->derivatives.col(count * i + j);
      INFO("i " << i << ", j " << j << ", |theta| " << theta.norm());
      CHECK((difference.col(i) - theta).norm() / (theta.norm() + 1) < 1e-5);
      inertia = std::max(
          inertia, (theta - left_out->derivatives.col(count * i + j)).norm() / (theta.norm() + 1));
    }
  }
  CHECK(inertia > 1e-4);
}
