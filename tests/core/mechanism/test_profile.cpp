#include "core/mechanism/profile.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "support/models.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using models::sampled;

TEST_CASE("stations of a profile lie inside, in order and mirrored") {
  const auto s = profile_stations();
  REQUIRE(s.size() == 144);
  CHECK(s.front() > 0);
  for (std::size_t k = 0; k + 1 < s.size(); ++k) CHECK(s[k] < s[k + 1]);
  for (std::size_t k = 0; k < s.size(); ++k)
    CHECK(s[k] + s[s.size() - 1 - k] == Approx(1).epsilon(1e-15));
}

TEST_CASE("a profile follows a smooth formula and its derivatives") {
  const auto p = sampled([](double s) { return 2 + std::sin(2 * M_PI * s); });
  double error[3] = {0, 0, 0};
  for (int i = 0; i <= 1000; ++i) {
    const double s = i / 1000.0, a = 2 * M_PI * s;
    error[0] = std::max(error[0], std::abs(profile_at(p, s) - 2 - std::sin(a)));
    error[1] = std::max(error[1], std::abs(profile_at(p, s, 1) - 2 * M_PI * std::cos(a)));
    error[2] = std::max(error[2], std::abs(profile_at(p, s, 2) + 4 * M_PI * M_PI * std::sin(a)));
  }
  CHECK(error[0] < 1e-9);
  CHECK(error[1] < 3e-7);
  CHECK(error[2] < 3e-4);
}

TEST_CASE("a profile is exact for polynomials of the degree of a piece") {
  const auto quintic = [](double s) { return 1 + s - 3 * s * s + std::pow(s, 5); };
  const auto p = sampled(quintic);
  for (const double s : {0.0, 1e-3, 0.25, 0.5, 0.73, 1.0}) {
    CHECK(profile_at(p, s) == Approx(quintic(s)).epsilon(1e-13).margin(1e-14));
    CHECK(profile_at(p, s, 1) ==
          Approx(1 - 6 * s + 5 * std::pow(s, 4)).epsilon(1e-11).margin(1e-11));
    CHECK(profile_at(p, s, 2) == Approx(-6 + 20 * std::pow(s, 3)).epsilon(1e-9));
  }
}

TEST_CASE("two numbers are a linear profile, none a uniform one") {
  const std::vector<double> p{1.0, 0.25};
  CHECK(profile_at(p, 0.2) == Approx(0.85));
  CHECK(profile_at(p, 0.2, 1) == Approx(-0.75));
  CHECK(profile_at(p, 0.2, 2) == 0);
  CHECK(profile_at({}, 0.3) == 1);
  CHECK(profile_at({}, 0.3, 1) == 0);
  CHECK(profile_weights(0, 0.3).count == 0);
}

TEST_CASE("the weights of a profile give its value") {
  const auto p = sampled([](double s) { return 1 + 4 * (s - 0.5) * (s - 0.5); });
  for (const double s : {0.0, 0.3, 0.5, 1.0})
    for (int order = 0; order < 3; ++order) {
      const ProfileWeights w = profile_weights(p.size(), s, order);
      double sum = 0;
      for (int k = 0; k < w.count; ++k) sum += w.weight[k] * p[w.first + k];
      CHECK(sum == Approx(profile_at(p, s, order)).margin(1e-9));
    }
}

TEST_CASE("between two pieces a profile is the mean of both sides") {
  const auto p = sampled([](double s) { return s < 0.5 ? 1.0 : 3.0; });
  CHECK(profile_at(p, 0.5) == Approx(2));
  CHECK(profile_at(p, 0.5 - 1e-6) == Approx(1));
  CHECK(profile_at(p, 0.5 + 1e-6) == Approx(3));
}

TEST_CASE("each rule of a profile is named when broken") {
  const auto broken = [](auto change) {
    Mechanism m = models::single_leaf(0.1, 0.03, 0.5e-3);
    change(m.leaves[0]);
    return why_not(check_rules(m));
  };
  CHECK(broken([](LeafSpring& l) { l.width_profile = {1, 0.5}; }).empty());
  CHECK_THAT(broken([](LeafSpring& l) {
               l.width_profile = {1, 0.5, 1};
             }),
             Contains("none, 2 or 144"));
  CHECK_THAT(broken([](LeafSpring& l) {
               l.width_profile = {1, -0.5};
             }),
             Contains("its width must be positive all along"));
  CHECK_THAT(broken([](LeafSpring& l) {
               l.thickness_profile = {1, 0};
             }),
             Contains("its thickness must be positive all along"));
  CHECK_THAT(broken([](LeafSpring& l) {
               l.thickness_profile = sampled([](double s) { return s - 0.4; });
             }),
             Contains("positive"));
  CHECK_THAT(broken([](LeafSpring& l) { l.thickness = 0.2; }), Contains("thinner than long"));
  CHECK_THAT(broken([](LeafSpring& l) { l.width = 0.4e-3; }), Contains("thicker than wide"));
  // a notch is as thin as its middle
  CHECK(broken([](LeafSpring& l) {
          l.thickness_profile = sampled([](double s) { return 1 + 400 * (s - 0.5) * (s - 0.5); });
          l.width = 1e-3;
        }).empty());
}
