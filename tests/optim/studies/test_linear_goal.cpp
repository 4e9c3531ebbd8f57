#include "optim/studies/tolerance_study.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

Goal goal(OverStroke over) { return {"", "max_stress", {}, over, 1}; }

}  // namespace

TEST_CASE("the worst of a maximum is that of the point that gets farthest") {
  const GoalValues values{10, 9};
  const MatrixXd slopes = (MatrixXd(2, 1) << 1, -3).finished();
  const LinearGoal linear = linear_goal(goal(OverStroke::max), values, slopes);
  CHECK(linear.value == 10);
  CHECK(linear.high == 12);  // the second point, not the decisive one
  CHECK(linear.low == 9);
  CHECK(linear.slopes[0] == 1);
}

TEST_CASE("the room is the scale at which the first point meets its bound") {
  const GoalValues values{10, 9};
  const MatrixXd slopes = (MatrixXd(2, 1) << 1, -3).finished();
  CHECK(*room_of(goal(OverStroke::max), values, slopes, {}, 15.0) == Approx(2));
  CHECK(*room_of(goal(OverStroke::max), values, slopes, {}, 10.0) == 0);
  CHECK(*room_of(goal(OverStroke::max), values, slopes, {}, 8.0) == 0);
  CHECK(*room_of(goal(OverStroke::last), values, slopes, {}, 15.0) == Approx(2));
  CHECK(*room_of(goal(OverStroke::first), values, slopes, 4.0, {}) == Approx(6));
  CHECK(*room_of(goal(OverStroke::min), values, slopes, 3.0, {}) == Approx(2));
  CHECK_FALSE(room_of(goal(OverStroke::max), values, MatrixXd::Zero(2, 1), {}, 15.0));
  // an optimum is at its bound to rounding, also where no tolerance moves it
  const MatrixXd still = MatrixXd::Constant(2, 1, 1e-20);
  CHECK_FALSE(room_of(goal(OverStroke::max), values, still, {}, 10 - 1e-12, 1e-3));
  CHECK(*room_of(goal(OverStroke::max), values, still, {}, 9.99, 1e-3) == 0);
  CHECK(*room_of(goal(OverStroke::max), values, slopes, {}, 10 - 1e-12, 1e-3) == 0);
  const GoalValues signs{-10, 9};
  CHECK(*room_of(goal(OverStroke::max_abs), signs, slopes, {}, 15.0) == Approx(2));
}
