#include <functional>

#include "optim/problem/worst_assembly_goals.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

using Function = std::function<double(const VectorXd&)>;

/// Numbers by functions whose slopes are differences of high order, exact for polynomials.
LookInBox looking(const std::vector<Function>& functions) {
  return [=](const VectorXd& z) {
    BoxLook look;
    const auto count = static_cast<Eigen::Index>(functions.size());
    look.values.resize(count);
    look.rates.resize(count, z.size());
    for (Eigen::Index k = 0; k < count; ++k) {
      const Function& f = functions[static_cast<std::size_t>(k)];
      look.values[k] = f(z);
      for (Eigen::Index i = 0; i < z.size(); ++i) {
        const auto beside = [&](double h) {
          VectorXd moved = z;
          moved[i] += h;
          return f(moved);
        };
        const double h = 0.05;
        look.rates(k, i) =
            (8 * (beside(h) - beside(-h)) - (beside(2 * h) - beside(-2 * h))) / 12 / h;
      }
    }
    return look;
  };
}

}  // namespace

TEST_CASE("a number that is linear in many errors is worst in the corner of its slopes") {
  const VectorXd slopes = VectorXd{{3, -1, 0.5, 2, -4, 1}};
  int looks = 0;
  const LookInBox look = looking({[&](const VectorXd& z) { return z.dot(slopes); }});
  const auto found = worst_places({6, 2, 1, 1}, {0}, [&](const VectorXd& z) {
    ++looks;
    return look(z);
  });
  REQUIRE(found);
  CHECK(found->places[0][0] == VectorXd(slopes.cwiseSign()));
  CHECK(looks < 10);
}

TEST_CASE("a place inside the box is found to rounding, and the other sides are at their bounds") {
  const VectorXd top = VectorXd{{0.3, -0.7}};
  const auto hill = [&](const VectorXd& z) {
    const VectorXd d = z.head(2) - top;
    return 5 - 2 * d[0] * d[0] - d[1] * d[1] - d[0] * d[1] -
           0.3 * d.squaredNorm() * d.squaredNorm() + 0.2 * z[2];
  };
  const auto found = worst_places({3, 3, 1, 1}, {0}, looking({hill}));
  REQUIRE(found);
  CHECK((found->places[0][0].head(2) - top).norm() < 1e-8);
  CHECK(found->places[0][0][2] == 1);
}

TEST_CASE("a side along which a number is hardly bent is not left where the number is least") {
  const auto saddle = [](const VectorXd& z) {
    const double x = z[0] - 0.02, y = z[1] - 0.15;
    return 2 + 1e-4 * x * x - 0.05 * y * y;
  };
  const auto found = worst_places({2, 2, 1, 1}, {0}, looking({saddle}));
  REQUIRE(found);
  CHECK(found->places[0][0][0] == -1);
  CHECK(found->places[0][0][1] == Approx(0.15).epsilon(1e-8));
}

TEST_CASE("several numbers share what is looked at, and have their own places") {
  int looks = 0;
  const LookInBox both = looking({[](const VectorXd& z) { return z[0] + 0.1 * z[1]; },
                                  [](const VectorXd& z) { return -1e-6 * (z[0] - z[1]); }});
  const auto counted = [&](const VectorXd& z) {
    ++looks;
    return both(z);
  };
  const auto found = worst_places({2, 2, 1, 1}, {0, 1}, counted);
  REQUIRE(found);
  CHECK(found->places[0][0] == VectorXd{{1, 1}});
  CHECK(found->places[1][0] == VectorXd{{-1, 1}});
  CHECK(looks == 6);  // the middle, a start and four corners
}

TEST_CASE("places that are as bad, or nearly so, come after the worst") {
  const auto bowl = [](const VectorXd& z) { return z[0] * z[0] + 0.01 * z[0] + 0.2 * z[1]; };
  const auto found = worst_places({2, 2, 1, 3}, {0}, looking({bowl}));
  REQUIRE(found);
  REQUIRE(found->places[0].size() == 2);
  CHECK(found->places[0][0] == VectorXd{{1, 1}});
  CHECK(found->places[0][1] == VectorXd{{-1, 1}});
}

TEST_CASE("a box with a place that has no numbers says so") {
  const LookInBox look = looking({[](const VectorXd& z) { return z[0]; }});
  const auto broken = [&](const VectorXd& z) -> Answer<BoxLook, Why> {
    if (z[0] < 1) return look(z);
    return BecauseOf({"unstable at 1", "unstable"});
  };
  const auto found = worst_places({1, 2, 1, 1}, {0}, broken);
  REQUIRE_FALSE(found);
  CHECK(found.error().message == "unstable at 1");
  CHECK(found.error().reason == "unstable");
}
