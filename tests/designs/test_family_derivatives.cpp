// Families are templates on the scalar: with dual numbers they give exact derivatives of every
// frame with respect to every parameter. Checked against central differences.
#include <catch2/catch.hpp>

#include "core/math/dual.hpp"
#include "core/mechanism/each_number.hpp"
#include "designs/cross_hinge.hpp"
#include "designs/leaf_spring.hpp"
#include "designs/parallel_guide.hpp"

using namespace flexopt;

namespace {

constexpr int most_parameters = 7;
using Duals = Dual<most_parameters>;

template <class S>
std::vector<S> numbers(const MechanismT<S>& mechanism) {
  std::vector<S> all;
  each_number(mechanism, [&](const S& x) { all.push_back(x); });
  return all;
}

/// `make` is a generic lambda: parameters → mechanism.
template <template <class> class Parameters, class Make>
void check_derivatives(const std::vector<double>& at, Make make) {
  Parameters<Duals> duals;
  int count = 0;
  duals.each([&](const char*, Duals& p) {
    p = Duals::variable(at[static_cast<std::size_t>(count)], count);
    ++count;
  });
  REQUIRE(count == static_cast<int>(at.size()));
  const std::vector<Duals> exact = numbers(make(duals));
  const auto plain = [&](int moved, double by) {
    Parameters<double> values;
    int i = 0;
    values.each([&](const char*, double& p) {
      p = at[static_cast<std::size_t>(i)] + (i == moved ? by : 0);
      ++i;
    });
    return numbers(make(values));
  };
  for (int k = 0; k < count; ++k) {
    const double h = 1e-6 * at[static_cast<std::size_t>(k)];
    const std::vector<double> up = plain(k, h), down = plain(k, -h), here = plain(k, 0);
    double largest = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      INFO("parameter " << k << ", number " << i);
      CHECK(exact[i].value == here[i]);
      // h² of the third derivative and rounding/h, both below 1e-9 for these sizes
      CHECK(exact[i].derivatives[std::size_t(k)] ==
            Approx((up[i] - down[i]) / (2 * h)).margin(2e-9));
      largest = std::max(largest, std::abs(exact[i].derivatives[std::size_t(k)]));
    }
    CHECK(largest > 0.01);  // every parameter moves something
  }
}

template <class S>
MaterialT<S> steel() {
  Material m;
  m.youngs_modulus = 210e9;
  m.poissons_ratio = 0.3;
  m.density = 7800;
  return with_numbers<S>(m, [](double x) { return S(x); });
}

}  // namespace

TEST_CASE("a leaf spring's frames have exact derivatives", "[designs][derivatives]") {
  check_derivatives<LeafSpringParameters>({0.08, 0.02, 3e-4}, [](const auto& p) {
    return make_leaf_spring(p, steel<std::decay_t<decltype(p.length)>>(), {});
  });
}

TEST_CASE("a parallel guide's frames have exact derivatives", "[designs][derivatives]") {
  check_derivatives<ParallelGuideParameters>({0.1, 0.03, 5e-4, 0.06}, [](const auto& p) {
    return make_parallel_guide(p, steel<std::decay_t<decltype(p.length)>>(), {});
  });
}

TEST_CASE("a cross hinge's frames have exact derivatives", "[designs][derivatives]") {
  check_derivatives<CrossHingeParameters>({0.08, 0.03, 3e-4, 0.6, 0.3, 1e-3}, [](const auto& p) {
    return make_cross_hinge(p, steel<std::decay_t<decltype(p.length)>>(), {});
  });
}

TEST_CASE("a three-flexure hinge's frames have exact derivatives", "[designs][derivatives]") {
  check_derivatives<ThreeFlexureCrossHingeParameters>(
      {0.08, 3e-4, 0.02, 0.05, 0.7, 0.4, 1e-3}, [](const auto& p) {
        return make_three_flexure_cross_hinge(p, steel<std::decay_t<decltype(p.length)>>(), {});
      });
}
