// Directions of profiles, arcs and folds, which equal leaves share.
#include "core/elements/leaf/leaf_rates.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "support/models.hpp"

using namespace flexopt;

TEST_CASE("leaves that rounding alone tells apart have directions in common") {
  // two elastic folds, and the rates of their places: one of them not quite zero
  constexpr double rounding = 3e-16;
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.leaves[0].fold = LeafFold{0.4, 1.2, 0};
  m.leaves[1].fold = LeafFold{0.4 * (1 + rounding), 1.2 * (1 - 2 * rounding), 0};
  std::vector<Mechanism> directions(2, m);
  directions[0].leaves[0].fold = LeafFold{0, 1, 0};
  directions[0].leaves[1].fold = LeafFold{0, 1, 0};
  directions[1].leaves[0].fold = LeafFold{0, 0, 0};
  directions[1].leaves[1].fold = LeafFold{rounding, 0, 0};
  const ProfileDirections profiles(m, directions);
  const auto& all = profiles.of({{}, {}, 0, 0.4, 1.2, 0});
  REQUIRE(all.size() == 2);
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t p = 0; p < 2; ++p) {
      const VectorXd along = profiles.coordinates(m.leaves[i], directions[p].leaves[i]);
      REQUIRE(along.size() == 2);
      CHECK(along[0] == (p == 0 ? 1 : 0));
      CHECK(along[1] == (p == 1 && i == 1 ? 1 : 0));
    }
  // other folds are leaves of their own
  CHECK(profiles.of({{}, {}, 0, 0.41, 1.2, 0}).empty());
}
