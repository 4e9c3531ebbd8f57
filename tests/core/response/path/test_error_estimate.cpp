// Estimated errors: laws of what the finer meshes say.
#include "core/response/path/error_estimate.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <vector>

#include "core/response/quantities.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

StrokeRequest to(double end) {
  StrokeRequest request{.points = {0, end / 2, end}, .frequencies = 4};
  return estimate_request(request);
}

ModelOptions full(std::array<int, 2> mesh) { return {.accuracy = Accuracy::full, .mesh = mesh}; }

StrokeErrors errors_on(const Mechanism& m, const ModelOptions& model, const StrokeRequest& r) {
  return estimate_errors(m, model, r, evaluate_stroke(m, model, r));
}

/// Of all numbers of a kind, the root of the mean of the squares.
double typical(const StrokeErrors& errors, ErrorKind kind) {
  double sum = 0;
  int count = 0;
  for (const auto& point : errors.path)
    for (const EstimatedError& e : point)
      if (e.kind == kind && e.scale > 0) sum += e.relative() * e.relative(), ++count;
  REQUIRE(count > 0);
  return std::sqrt(sum / count);
}

}  // namespace

TEST_CASE("finer meshes are next on the ladder") {
  CHECK(more_along({10, 4}) == std::array{14, 4});
  CHECK(more_across({10, 4}) == std::array{10, 6});
  CHECK(more_along({14, 6}) == std::array{20, 6});
  CHECK(more_across({14, 6}) == std::array{14, 8});
  for (int n = 2; n < 40; ++n) CHECK(more_along({n, 4})[0] > n);
}

TEST_CASE("the estimate falls with the mesh at the order at which the error falls", "[slow]") {
  const Mechanism m = models::guide(0.06, 0.04, 4e-4);
  const StrokeRequest r = to(0.009);
  const StrokeResponse fine = evaluate_stroke(m, full({28, 14}), r);
  const auto error_of = [&](const StrokeErrors& errors, ErrorKind kind) {
    double sum = 0;
    int count = 0;
    for (std::size_t k = 0; k < errors.path.size(); ++k)
      for (const EstimatedError& truth : estimated_numbers(fine.path[k])) {
        const EstimatedError* e = errors.find(k, truth.name);
        if (!e || e->kind != kind || e->scale == 0) continue;
        sum += std::pow((e->value - truth.value) / e->scale, 2);
        ++count;
      }
    return std::sqrt(sum / count);
  };
  const StrokeErrors coarse = errors_on(m, full({8, 4}), r), half = errors_on(m, full({16, 8}), r);
  for (const ErrorKind kind : {ErrorKind::load, ErrorKind::stiffness, ErrorKind::frequency}) {
    const double of_estimates = std::log2(typical(coarse, kind) / typical(half, kind)),
                 of_errors = std::log2(error_of(coarse, kind) / error_of(half, kind));
    CAPTURE(static_cast<int>(kind), of_estimates, of_errors);
    CHECK(of_errors > 2);
    CHECK(of_estimates > 1.7);
    CHECK(std::abs(of_estimates - of_errors) < 1.2);
    CHECK(typical(coarse, kind) > error_of(coarse, kind));
    CHECK(typical(half, kind) > error_of(half, kind));
  }
}

TEST_CASE("what every mesh has exactly has no error") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const StrokeErrors errors = errors_on(m, full(default_mesh), to(0.01));
  for (std::size_t k = 0; k < errors.path.size(); ++k) {
    const EstimatedError* stroke = errors.find(k, "displacement.y");  // prescribed
    REQUIRE(stroke);
    CHECK(stroke->relative() < 1e-9);
    const EstimatedError* shift = errors.find(k, "displacement.z");  // zero by symmetry
    REQUIRE(shift);
    CHECK(shift->absolute() < 1e-9 * 0.01);
  }
  CHECK(errors.find(2, "displacement.x")->relative() > 1e-7);
  CHECK_FALSE(errors.find(0, "leaf_mass"));  // exact: no estimate
}

TEST_CASE("a motion that is zero but for rounding is relative to what the mechanism does") {
  // a hub between three arms, a third of a turn apart, moves along their axis and does not turn
  constexpr double length = 0.04, hub = 0.01;
  Mechanism m = models::single_leaf(length, 0.008, 3e-4, Direction::uz);
  m.bodies[0].reference.setZero();
  m.bodies[0].center_of_mass.setZero();
  const LeafSpring arm = m.leaves[0];
  m.leaves.clear();
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * M_PI / 3 * i;
    const Vector3d outward(std::cos(angle), std::sin(angle), 0);
    LeafSpring& leaf = m.leaves.emplace_back(arm);
    leaf.origin = (hub + length) * outward;
    leaf.axes.col(0) = -outward;
    leaf.axes.col(2) = Vector3d::UnitZ();
    leaf.axes.col(1) = leaf.axes.col(2).cross(leaf.axes.col(0));
  }
  const StrokeErrors errors = errors_on(m, {}, to(4e-4));
  for (std::size_t k = 0; k < errors.path.size(); ++k)
    for (const char* name : {"rotation.x", "rotation.y", "rotation.z"}) {
      CAPTURE(k, name);
      const EstimatedError* turn = errors.find(k, name);
      REQUIRE(turn);
      CHECK(turn->value == Approx(0).margin(1e-9));
      CHECK(turn->scale == Approx(1e-3 * 4e-4 / length));
      CHECK(turn->relative() < 1e-3);
    }
}

TEST_CASE("numbers that are rounding alone have no error") {
  // two drives, of which symmetry keeps one without load; and paths of the rest alone
  Mechanism m = models::single_leaf(0.08, 0.02, 4e-4, Direction::rx);
  m.bodies[0].reference.setZero();
  const LeafSpring along_x = m.leaves[0];
  m.leaves.clear();
  for (int i = 0; i < 4; ++i) {
    const double angle = M_PI / 2 * i;
    LeafSpring& leaf = m.leaves.emplace_back(along_x);
    leaf.axes.col(0) = -Vector3d(std::cos(angle), std::sin(angle), 0);
    leaf.axes.col(2) = Vector3d::UnitZ();
    leaf.axes.col(1) = leaf.axes.col(2).cross(leaf.axes.col(0));
    leaf.origin = -0.1 * leaf.axes.col(0);
  }
  m.drives = {make_drive(Direction::rx), make_drive(Direction::ry)};
  m.drives[0].name = "a";
  m.drives[1].name = "b";
  for (const double turn : {0.0, 0.02})
    for (const ModelOptions& model : {ModelOptions{}, full(default_mesh)}) {
      CAPTURE(turn, static_cast<int>(model.accuracy));
      StrokeRequest request = estimate_request({.points = {0, turn}, .frequencies = 4});
      request.strokes = {Eigen::Vector2d(0, 0), Eigen::Vector2d(turn, 0)};
      const StrokeErrors errors = errors_on(m, model, request);
      REQUIRE(errors.message.empty());
      REQUIRE(errors.find(1, "drive_load.b"));
      CHECK(errors.find(1, "drive_load.b")->relative() < 1e-3);
      const double least = 1e-3 * turn * errors.find(1, "drive_stiffness.b")->value;
      CHECK(errors.find(1, "drive_load.b")->scale == Approx(least).epsilon(1e-2).margin(1e-12));
      CHECK((errors.find(1, "drive_load.a")->relative() > 2e-4) == (turn > 0));
      CHECK(largest_error({errors}, false)->relative < 0.01);
      CHECK(largest_error({errors}, false)->relative > 1e-5);
    }
}

TEST_CASE("the reduction's part is the distance from full leaves on the same mesh", "[slow]") {
  const Mechanism m = models::three_leaf_hinge(0.1, 0.04, 3.5e-4);
  const StrokeRequest r = to(0.5);
  const StrokeResponse reduced = evaluate_stroke(m, {}, r),
                       own = evaluate_stroke(m, full(default_mesh), r);
  const StrokeErrors errors = estimate_errors(m, {}, r, reduced);
  for (std::size_t k = 0; k < r.points.size(); ++k)
    for (const EstimatedError& truth : estimated_numbers(own.path[k])) {
      const EstimatedError* e = errors.find(k, truth.name);
      REQUIRE(e);
      if (e->scale == 0) continue;
      const double zero = e->kind == ErrorKind::stress      ? 1e-12 * 200e9
                          : e->kind == ErrorKind::load      ? 1e-12 * 200e9 * 0.04 * 3.5e-4 * 0.1
                          : e->name.starts_with("rotation") ? 1e-7
                          : e->name.starts_with("displacement") ? 1e-7 * 0.1
                                                                : 0;
      CAPTURE(k, truth.name);
      const bool none = std::max(std::abs(e->value), std::abs(truth.value)) <= zero;
      const double apart = none ? 0 : std::abs(e->value - truth.value);
      CHECK(e->reduction == Approx(apart).margin(1e-12 * e->scale));
      CHECK(e->absolute() >= e->reduction);
    }
  // of full leaves there is none
  const StrokeErrors of_full = estimate_errors(m, full(default_mesh), r, own);
  for (const auto& point : of_full.path)
    for (const EstimatedError& e : point) CHECK(e.reduction == 0);
}

TEST_CASE("the reduction's part grows as the leaves leave the range of their expansion", "[slow]") {
  // a payload on the hinge that the tubes are not centred on
  const Mechanism m = models::three_leaf_hinge(0.1, 0.04, 3.5e-4);
  std::vector<double> reduction;
  for (const double stroke : {0.05, 0.3, 0.6}) {
    const StrokeErrors errors = errors_on(m, {}, to(stroke));
    double largest = 0;
    for (const EstimatedError& e : errors.path.back())
      if (e.kind == ErrorKind::stiffness) largest = std::max(largest, e.reduction / e.scale);
    reduction.push_back(largest);
  }
  CAPTURE(reduction[0], reduction[1], reduction[2]);
  CHECK(reduction[2] > 3 * reduction[0]);
}

TEST_CASE("estimates change no bit of the values") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const StrokeRequest r = to(0.02);
  StrokeResponse response = evaluate_stroke(m, {}, r);
  const StrokeResponse before = response;
  (void)estimate_errors(m, {}, r, response);
  const StrokeResponse again = evaluate_stroke(m, {}, r);
  for (std::size_t k = 0; k < response.path.size(); ++k)
    for (const StrokeResponse* other : {&before, &again}) {
      const auto a = estimated_numbers(response.path[k]), b = estimated_numbers(other->path[k]);
      REQUIRE(a.size() == b.size());
      for (std::size_t i = 0; i < a.size(); ++i)
        CHECK(std::memcmp(&a[i].value, &b[i].value, sizeof(double)) == 0);
    }
}

TEST_CASE("beams have errors of the elements along alone") {
  const Mechanism m = models::guide(0.1, 0.01, 5e-4);
  ModelOptions beams = full(default_mesh);
  beams.flexure = Flexure::beam;
  CHECK_FALSE(has_elements_across(m, beams));
  const StrokeErrors errors = errors_on(m, beams, to(0.02));
  const auto largest = largest_error({errors}, false);
  REQUIRE(largest);
  CHECK(largest->relative > 0);
  CHECK(largest->across == 0);
}

TEST_CASE("every quantity of the table has an estimate or is said to have none") {
  StrokeRequest request{.points = {0, 0.01}, .frequencies = 4};
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const StrokeResponse response = evaluate_stroke(m, {}, request);
  const auto numbers = estimated_numbers(response.path[1]);
  for (const Quantity& q : quantities(DriveList(m))) {
    if (!q.value(response.path[1])) continue;
    const bool there = std::ranges::find(numbers, q.name, &EstimatedError::name) != numbers.end();
    CAPTURE(q.name);
    CHECK(there == (q.row->error != ErrorKind::none));
  }
  for (const char* name : {"compliance.drive_free.uy", "compliance.drive_locked.rx",
                           "principal_stiffness.translations.0", "principal_stiffness.rotations.1"})
    CHECK(std::ranges::find(numbers, name, &EstimatedError::name) != numbers.end());
}

TEST_CASE("points that full leaves do not reach have no estimate, and the reason is told") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const StrokeRequest r = to(0.01);
  const StrokeResponse response = evaluate_stroke(m, full(default_mesh), r);
  StrokeResponse lost = response;
  lost.path[2].status = PointStatus::no_equilibrium;
  const auto here = std::make_shared<const StrokeResponse>(response),
             gone = std::make_shared<const StrokeResponse>(lost);
  const StrokeErrors errors = errors_of(response, {here, gone, here, nullptr, default_mesh, {}});
  CHECK(errors.path[2].empty());
  CHECK_FALSE(errors.path[1].empty());
  CHECK_FALSE(errors.message.empty());
}

TEST_CASE("load capacities and transmissibility have estimates that cover their errors", "[slow]") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  StrokeRequest request = to(0.01);
  request.points = {0.01};
  request.dynamics = DynamicsRule{0.02, TransmissibilityRule{Direction::ux, 1, 60}};
  request.capacity.directions[2] = request.capacity.directions[3] = true;  // uz, rx
  request.capacity.stress = 600e6;
  request.capacity.stiffness_share = 0.5;
  const std::array<int, 2> coarse{8, 4}, fine{20, 8};
  const StrokeErrors errors = errors_on(m, full(coarse), request);
  const StrokeResponse reference = evaluate_stroke(m, full(fine), request);
  for (const char* name : {"transmissibility", "load_capacity.uz", "load_capacity.rx"}) {
    CAPTURE(name);
    const EstimatedError* error = errors.find(0, name);
    const auto value = value_of(reference.path[0], name);
    REQUIRE(error);
    REQUIRE(value);
    INFO(error->value << " ± " << error->absolute() << ", on a finer mesh " << *value);
    CHECK(error->absolute() > 0);
    CHECK(std::abs(error->value - *value) <= error->absolute());
    CHECK(error->relative() < 0.4);  // stress ends uz, known to 18 % on this mesh
  }
}
