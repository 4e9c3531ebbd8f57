// Time of one evaluation of the reduced leaf and of each of its parts, on one core.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "core/math/rotation.hpp"
#include "core/reduction/tube/mixed_condensation.hpp"
#include "support/synthetic_leaf.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

/// Least processor time of several runs [µs per call]; what f returns is summed and shown, so
/// nothing is optimised away.
template <class F>
void measure(const char* name, F&& f) {
  constexpr int calls = 20000, runs = 25;
  double best = 1e300, check = 0;
  for (int run = 0; run < runs; ++run) {
    const std::clock_t start = std::clock();
    for (int i = 0; i < calls; ++i) check += f(1e-6 * (i % 100));
    best = std::min(best, 1e6 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / calls);
  }
  std::printf("| %s | %.2f µs |\n", name, best);
  std::fprintf(stderr, "%s: sum %g\n", name, check);  // keeps the calls alive
}

template <int Degree>
TubePotential tube() {
  std::vector<TubeNode> nodes;
  for (double sigma : {0.0, 0.03, 0.1, 0.3})
    nodes.push_back(synthetic::node<Degree>(synthetic::s_ray(), sigma));
  return TubePotential(synthetic::s_ray(), synthetic::force_scale, Degree, nodes);
}

}  // namespace

int main() {
  const PageTable page("tube_kernel");
  std::printf("| part | time |\n|---|---|\n");
  const TubePotential degree5 = tube<5>(), degree7 = tube<7>();
  const double L = synthetic::length;
  EdgePoses edges{{{Vector3d::Zero(), Matrix3d::Identity()},
                   {Vector3d(0.99 * L, 1e-5, 0.12 * L), rotation_exp(Vector3d(0.01, 0.02, 2e-4))}}};
  const Vector3d f(0.1, 0.2, -0.1);
  const Vector6d g = Vector6d::LinSpaced(0.1, 1);
  const auto shaken = [&](double x) {
    EdgePoses y = edges;
    y[1].position[2] += x * L;
    return y;
  };

  measure("potential, degree 5 (66 terms)", [&](double x) {
    const PotentialValue p = degree5.evaluate(Vector3d(0.12 + x, 0.1, 0.01), f);
    return p.value + p.gradient[4] + p.hessian(5, 1);
  });
  measure("potential, degree 7 (236 terms)", [&](double x) {
    const PotentialValue p = degree7.evaluate(Vector3d(0.12 + x, 0.1, 0.01), f);
    return p.value + p.gradient[4] + p.hessian(5, 1);
  });
  measure("chord frame, e and B", [&](double x) {
    const ChordFrame c = chord_frame(shaken(x), L);
    return c.e[1] + c.B(5, 3);
  });
  measure("chord frame and geometric stiffness", [&](double x) {
    const ChordFrame c = chord_frame(shaken(x), L);
    return geometric_stiffness(c, g)(11, 2);
  });
  MixedState mixed;
  measure("potential and condensation, degree 5", [&](double x) {
    Vector6d e;
    e << -1e-4, 0.1 + x, 1e-4, 0.12, 0, 0.01;
    return condense(degree5, e, mixed).hessian(2, 3);
  });
  ReducedState state;
  ReducedResponse response;
  measure("whole leaf: energy, force, tangent, degree 5", [&](double x) {
    evaluate_reduced_leaf(degree5, L, shaken(x), state, response);
    return response.force[7] + response.tangent(10, 3);
  });
  measure("whole leaf: energy, force, tangent, degree 7", [&](double x) {
    evaluate_reduced_leaf(degree7, L, shaken(x), state, response);
    return response.force[7] + response.tangent(10, 3);
  });
}
