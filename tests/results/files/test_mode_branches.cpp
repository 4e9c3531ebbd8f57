#include "results/files/scene.hpp"
#include "tests/results/results_tests.hpp"

namespace {

Mode mode(double frequency, const VectorXd& motion) {
  Mode made;
  made.frequency = frequency;
  made.motion = motion;
  return made;
}

/// Two modes that cross in frequency half-way, and a third that the path loses.
std::vector<PathPoint> crossing() {
  std::vector<PathPoint> path(5);
  for (int k = 0; k < 5; ++k) {
    const double a = 100 + 20 * k, b = 150 - 5 * k, turn = 0.05 * k;
    const Mode first = mode(a, Vector3d(std::cos(turn), std::sin(turn), 0)),
               second = mode(b, Vector3d(-std::sin(turn), std::cos(turn), 0));
    auto& modes = path[static_cast<std::size_t>(k)].modes_free;
    modes = a < b ? std::vector{first, second} : std::vector{second, first};
    if (k != 2) modes.push_back(mode(300, Vector3d::UnitZ()));
  }
  return path;
}

}  // namespace

TEST_CASE("Branches follow the motion of a mode, not its place in the list") {
  const auto branches = mode_branches(crossing(), DriveState::free);
  CHECK(branches ==
        std::vector<std::vector<int>>{{0, 1, 2}, {0, 1, 2}, {1, 0}, {1, 0, 3}, {1, 0, 3}});
  for (const auto& of_point : mode_branches(crossing(), DriveState::locked))
    CHECK(of_point.empty());
}

TEST_CASE("A point without modes interrupts no branch") {
  std::vector<PathPoint> path = crossing();
  path[1].modes_free.clear();
  const auto branches = mode_branches(path, DriveState::free);
  CHECK(branches[1].empty());
  CHECK(branches[3] == std::vector<int>{1, 0, 3});
}
