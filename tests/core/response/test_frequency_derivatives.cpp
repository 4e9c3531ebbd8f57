// Derivatives of the frequencies along the stroke against differences of the path.
#include <catch2/catch.hpp>

#include "core/response/frequency_derivatives.hpp"
#include "core/response/response.hpp"
#include "support/models.hpp"
using namespace flexopt;
TEST_CASE("probe", "[response]") {
  for (const Mechanism& m : {models::guide(0.1, 0.03, 5e-4), models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.02}}), models::three_leaf_hinge(0.06, 0.04, 4e-4)}) {
    const ModelOptions model{.accuracy = Accuracy::full, .leaf_modes = 12};
    const double L = m.leaves[0].length;
    const double h = is_rotation(m.drive) ? 1e-3 : 1e-3 * L;
    StrokeRequest r;
    r.points = {-2*h, -h, 0, h, 2*h, 5 * h, 10 * h, 20 * h, 50 * h, 100 * h};
    r.frequencies = 8;
    r.stress = false;
    const StrokeResponse response = evaluate_stroke(m, model, r);
    WARN(response.message << " path " << response.seconds_path << " derivatives " << response.seconds_derivatives);
    for (const auto& d : response.frequency_derivatives) {
      auto w2 = [&](int k) { return std::pow(2 * M_PI * response.path[k].frequencies_free[d.index], 2); };
      const double d1 = (w2(3) - w2(1)) / (2 * h), d2 = (w2(3) - 2 * w2(2) + w2(1)) / (h * h),
                   d2b = (w2(4) - 2 * w2(2) + w2(0)) / (4 * h * h);
      WARN(d.index << " kind " << (int)d.mode.kind << "/" << (int)response.path[2].modes_free[d.index].kind << " w2 " << d.omega2 << " path " << w2(2) << " d1 " << d.d_omega2 << " " << d1 << " d2 " << d.d2_omega2 << " " << (4 * d2 - d2b) / 3 << " ratio-1 " << (4 * d2 - d2b) / 3 / d.d2_omega2 - 1 << " valid " << d.omega2_valid_to.value_or(-1) << " " << d.compliance_valid_to.value_or(-1));
    }
  }
}
