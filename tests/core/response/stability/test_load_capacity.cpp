// The largest load at O: columns and strips in closed form, linear theory where loads are small,
// the limit found again by an evaluation under that load, laws of symmetry, exact derivatives.
#include "core/response/stability/load_capacity.hpp"

#include "support/gradient_checks.hpp"

using namespace flexopt;

namespace {
constexpr int ux = 0, uy = 1, uz = 2, rx = 3, against = 6;

ModelOptions beams(int elements = 10) { return models::free_beams(elements); }

/// For laws that hold on every mesh.
ModelOptions coarse_plates() { return {.mesh = {6, 2}}; }

StrokeRequest asking(std::initializer_list<int> directions, std::vector<double> strokes = {0}) {
  StrokeRequest request{.points = std::move(strokes),
                        .outputs = {Output::equilibrium, Output::load_capacity},
                        .newton = {.tolerance = 1e-12}};
  for (const int d : directions) request.capacity.directions[static_cast<std::size_t>(d)] = true;
  return request;
}

LoadCapacity capacity(const Mechanism& m, const ModelOptions& model, const StrokeRequest& request,
                      int direction, std::size_t point = 0) {
  const StrokeResponse response = evaluate_stroke(m, model, request);
  INFO(response.message);
  REQUIRE(response.path[point].status == PointStatus::converged);
  REQUIRE(response.path[point].load_capacity[static_cast<std::size_t>(direction)]);
  return *response.path[point].load_capacity[static_cast<std::size_t>(direction)];
}

/// The point of a stroke under a dead load at O.
PathPoint loaded(const Mechanism& m, const ModelOptions& model, int direction, double size,
                 double stroke) {
  const double along = direction < 6 ? size : -size;
  const Vector3d load = along * Vector3d::Unit(direction % 3), none = Vector3d::Zero();
  const bool turns = direction % 6 >= 3;
  return test::evaluated(m, model,
                         {.points = {stroke},
                          .loads = {.constant = {{.force = turns ? none : load,
                                                  .moment = turns ? load : none}}},
                          .outputs = {Output::equilibrium, Output::stiffness, Output::stress},
                          .newton = {.tolerance = 1e-12}})
      .path[0];
}

Mechanism strong_guide(double strength) {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  for (LeafSpring& leaf : m.leaves) leaf.material.yield_strength = strength;
  return m;
}

}  // namespace

TEST_CASE("a column bears Euler's load and any pull") {
  const double L = 0.1, w = 0.01, t = 2e-4;
  struct Column {
    const char* what;
    bool turns, driven;
    double factor;
  };
  for (const Column& column :
       {Column{"free tip", true, false, 0.25},
        Column{"pinned tip", true, true, 4.493409457909064 * 4.493409457909064 / (M_PI * M_PI)},
        Column{"guided tip", false, false, 1}, Column{"clamped tip", false, true, 4}}) {
    Mechanism m = models::single_leaf(L, w, t);
    m.bodies[0].held[5] = !column.turns;
    if (!column.driven) m.drives.clear();
    INFO(column.what);
    StrokeRequest request = asking({ux, against + ux});
    request.capacity.largest_force = 500;
    const LoadCapacity pressed = capacity(m, beams(), request, against + ux);
    INFO(pressed.reason);
    CHECK(pressed.limit == CapacityLimit::instability);
    CHECK_FALSE(pressed.fold);
    CHECK(
        pressed.value ==
        Approx(column.factor * M_PI * M_PI * models::bending(m.leaves[0]) / (L * L)).epsilon(1e-3));
    const LoadCapacity pulled = capacity(m, beams(), request, ux);
    CHECK(pulled.limit == CapacityLimit::none);
    CHECK(pulled.value == 500);
    CHECK_THAT(pulled.reason, Catch::Contains("no limit up to the largest load"));
  }
}

TEST_CASE("small loads reach the stress of linear theory") {
  const double L = 0.1, w = 0.01, t = 4e-4, limit = 1e6;
  Mechanism m = models::single_leaf(L, w, t);
  m.drives.clear();
  StrokeRequest request = asking({ux, uy, rx + 2, against + uy});
  request.capacity.stress = limit;
  struct Case {
    int direction;
    double expected;
  };
  // pull; force across: moment F L at the clamp; moment at the tip
  for (const Case& c :
       {Case{ux, limit * w * t}, Case{uy, limit * w * t * t / (6 * L)},
        Case{rx + 2, limit * w * t * t / 6}, Case{against + uy, limit * w * t * t / (6 * L)}}) {
    const LoadCapacity found = capacity(m, beams(), request, c.direction);
    CAPTURE(c.direction, found.reason);
    CHECK(found.limit == CapacityLimit::stress);
    REQUIRE(found.stress);
    CHECK(found.stress->value == Approx(limit).epsilon(1e-9));
    // what bending stretches, of the order of stress over Young's modulus
    CHECK(found.value == Approx(c.expected).epsilon(1e-4));
  }
}

TEST_CASE("under its capacity a guide is at the limit that is named", "[slow]") {
  ModelOptions model = coarse_plates();
  model.accuracy = Accuracy::full;
  for (const auto& [stroke, strength] : {std::pair{0.0, 80e6}, {0.006, 260e6}}) {
    const Mechanism m = strong_guide(strength);
    StrokeRequest request = asking({uz, ux}, {stroke});
    const LoadCapacity stressed = capacity(m, model, request, uz);
    INFO(stressed.reason);
    REQUIRE(stressed.limit == CapacityLimit::stress);
    CHECK(loaded(m, model, uz, stressed.value, stroke).max_stress->value ==
          Approx(strength).epsilon(1e-8));
    request.capacity.stress = 1e12;
    request.capacity.stiffness_share = 0.6;
    const LoadCapacity soft = capacity(m, model, request, uz);
    INFO(soft.reason);
    REQUIRE(soft.limit == CapacityLimit::stiffness);
    const auto d = static_cast<std::size_t>(index(*soft.support));
    const PathPoint with = loaded(m, model, uz, soft.value, stroke),
                    without = loaded(m, model, uz, 0, stroke);
    CHECK(*with.support_stiffness[d] / *without.support_stiffness[d] == Approx(0.6).epsilon(1e-8));
    CHECK(soft.stiffness == Approx(*with.support_stiffness[d]).epsilon(1e-8));
    for (std::size_t k = 0; k < 6; ++k)  // it is the first
      if (with.support_stiffness[k])
        CHECK(*with.support_stiffness[k] > 0.6 * (1 - 1e-8) * *without.support_stiffness[k]);
  }
}

TEST_CASE("a pressed guide bears its buckling load", "[slow]") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const std::vector<double> strokes{0, 0.005, 0.01, -0.005};
  StrokeRequest request = asking({against + ux}, strokes);
  request.outputs.add(Output::buckling);
  const double payload = 50;
  request.loads.constant = {{.force = {-payload, 0, 0}, .name = "payload"}};
  request.buckling_load = "payload";
  const StrokeResponse response = evaluate_stroke(m, coarse_plates(), request);
  for (std::size_t k = 0; k < strokes.size(); ++k) {
    const LoadCapacity& here = *response.path[k].load_capacity[against + ux];
    CAPTURE(k, here.reason);
    CHECK(here.limit == CapacityLimit::instability);
    CHECK(here.fold == (strokes[k] != 0));
    REQUIRE(response.path[k].buckling->drive_locked.factor);
    CHECK(here.value + payload ==
          Approx(payload * *response.path[k].buckling->drive_locked.factor).epsilon(1e-7));
  }
  CHECK(response.path[3].load_capacity[against + ux]->value ==
        Approx(response.path[1].load_capacity[against + ux]->value).epsilon(1e-7));
}

TEST_CASE("a branch that bends away from a bifurcation bears more, up to its own fold", "[slow]") {
  // a wide thin leaf, its end-effector aside and held against turning about y, pushed along its
  // width
  const Vector3d base(0.007174577127435354, -0.011424483376091938, 0.006715844435671702),
      tip(-0.012655392305937698, -0.00882211670871194, 0.006715844435671702),
      O(0.004048490774918041, 0.01904406613150541, -0.009728818309966669);
  const Mechanism m{
      .bodies = {models::body(O, 0, 0)},
      .leaves = {models::leaf(base, tip - base, (tip - base).norm(), 0.013351688871343404,
                              5.758879260761212e-05, {"m", 200e9, 0.33, 2700, {}})},
      .joints = {{"held", JointType::held_rotation, 0, ground, O, Vector3d::UnitY()}},
      .drives = {make_drive(Direction::ux)}};
  const double stroke = -0.00010485480303967987;
  const ModelOptions model{.accuracy = Accuracy::full, .mesh = {8, 3}};
  StrokeRequest request = asking({against + uz}, {stroke});
  request.capacity.stress = 600e6;
  const LoadCapacity found = capacity(m, model, request, against + uz);
  INFO(found.reason);
  CHECK(found.limit == CapacityLimit::instability);
  CHECK(found.fold);
  // what a state under three quarters of it foretells, and its own branch comes to
  StrokeRequest under = request;
  under.outputs = {Output::equilibrium, Output::buckling};
  under.buckling_load = "load";
  under.loads.constant = {{.force = {0, 0, -0.75 * found.value}, .name = "load"}};
  const StrokeResponse loaded = evaluate_stroke(m, model, under);
  REQUIRE(loaded.path[0].buckling);
  REQUIRE(loaded.path[0].buckling->drive_locked.factor);
  CHECK(0.75 * *loaded.path[0].buckling->drive_locked.factor == Approx(1).epsilon(1e-6));
  CHECK(found.value == Approx(0.11843).epsilon(1e-3));
}

TEST_CASE("what the stroke stresses a guide with is not left for loads") {
  StrokeRequest request = asking({uz}, {0.003, 0.005, 0.007, 0.009});
  request.capacity.stress = 300e6;
  const StrokeResponse response = evaluate_stroke(strong_guide(600e6), coarse_plates(), request);
  double before = 1e9;
  for (const PathPoint& point : response.path) {
    const LoadCapacity& here = *point.load_capacity[uz];
    CAPTURE(point.stroke, here.reason);
    CHECK(here.limit == CapacityLimit::stress);
    CHECK(here.value < before);
    CHECK(here.value > 0);
    before = here.value;
  }
}

TEST_CASE("a free drive leaves a guided leaf the rest of its stress, either way") {
  const double L = 0.1, w = 0.01, t = 4e-4, limit = 6e6;
  Mechanism m = models::single_leaf(L, w, t);
  m.bodies[0].held[5] = true;
  const double most = limit * w * t * t / (3 * L),  // at both ends the moment F L/2
      stiffness = 12 * models::bending(m.leaves[0]) / (L * L * L), stroke = 0.4 * most / stiffness;
  StrokeRequest request = asking({uy, against + uy}, {stroke});
  request.capacity.stress = limit;
  request.capacity.drive = DriveState::free;
  for (const auto& [direction, share] : {std::pair{uy, 0.6}, {against + uy, 1.4}}) {
    const LoadCapacity found = capacity(m, beams(), request, direction);
    CAPTURE(direction, found.reason);
    CHECK(found.limit == CapacityLimit::stress);
    // shear and what bending stretches: of the order of (t/L)² and (s/L)²
    CHECK(found.value == Approx(share * most).epsilon(1e-3));
  }
}

TEST_CASE("a pressed guide with a free drive sways as a column does") {
  const Mechanism m = models::guide(0.1, 0.01, 2e-4);
  StrokeRequest request = asking({against + ux});
  request.capacity.drive = DriveState::free;
  const LoadCapacity found = capacity(m, beams(), request, against + ux);
  INFO(found.reason);
  CHECK(found.limit == CapacityLimit::instability);
  // two columns between ends that do not turn, one of which moves aside
  CHECK(found.value ==
        Approx(2 * M_PI * M_PI * models::bending(m.leaves[0]) / (0.1 * 0.1)).epsilon(1e-3));
  Mechanism without = m;
  without.drives.clear();
  CHECK(
      found.value ==
      Approx(capacity(without, beams(), asking({against + ux}), against + ux).value).epsilon(1e-7));
}

TEST_CASE("a free drive keeps its load, which is one more dead load") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  StrokeRequest request = asking({uy, uz, against + rx}, {0.004});
  request.capacity.stress = 400e6;
  request.capacity.drive = DriveState::free;
  const PathPoint driven = evaluate_stroke(m, beams(), request).path[0];
  m.drives.clear();
  request.points = {0};
  request.loads.constant = {{.force = {0, driven.drive_load, 0}}};
  const PathPoint loaded = evaluate_stroke(m, beams(), request).path[0];
  for (const std::size_t d : {uy, uz, against + rx}) {
    REQUIRE(driven.load_capacity[d]);
    REQUIRE(loaded.load_capacity[d]);
    CAPTURE(d, driven.load_capacity[d]->reason);
    CHECK(driven.load_capacity[d]->limit == CapacityLimit::stress);
    CHECK(driven.load_capacity[d]->value == Approx(loaded.load_capacity[d]->value).epsilon(1e-7));
  }
}

TEST_CASE("what a load path has brought is missing from the capacity along it") {
  const Mechanism m = models::single_leaf(0.1, 0.01, 4e-4);
  const double force = 0.5;
  StrokeRequest request = asking({uy, against + uy}, {0, 0.5, 1});
  request.loads.growing = {{.force = {0, force, 0}}};
  request.capacity.stress = 300e6;
  request.capacity.drive = DriveState::free;
  const StrokeResponse response = evaluate_stroke(m, beams(), request);
  for (const PathPoint& point : response.path) {
    CAPTURE(point.stroke);
    REQUIRE(point.load_capacity[uy]);
    const double brought = force * point.stroke;
    CHECK(point.load_capacity[uy]->value + brought ==
          Approx(response.path[0].load_capacity[uy]->value).epsilon(1e-7));
    CHECK(point.load_capacity[against + uy]->value - brought ==
          Approx(response.path[0].load_capacity[uy]->value).epsilon(1e-7));
  }
}

TEST_CASE("what is mirrored bears the mirrored load") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.leaves[0].thickness = 4e-4;  // not symmetric in itself
  Mechanism mirrored = m;
  for (LeafSpring& leaf : mirrored.leaves) leaf.origin[1] *= -1;
  StrokeRequest request =
      asking({uz, against + uz, rx + 1, against + rx + 1, rx, against + rx, against + ux}, {0.004});
  request.capacity.stress = 400e6;
  request.capacity.stiffness_share = 0.5;
  StrokeRequest other = request;
  other.points = {-0.004};
  const StrokeResponse one = evaluate_stroke(m, beams(), request),
                       two = evaluate_stroke(mirrored, beams(), other);
  const auto value = [](const StrokeResponse& r, int d) {
    const auto& found = r.path[0].load_capacity[static_cast<std::size_t>(d)];
    REQUIRE(found);
    CHECK(found->limit != CapacityLimit::none);
    return found->value;
  };
  // y turns: ux, uz, ry stay, rx and rz turn
  for (const auto& [a, b] : {std::pair{uz, uz},
                             {against + uz, against + uz},
                             {rx, against + rx},
                             {rx + 1, against + rx + 1},
                             {against + ux, against + ux}})
    CHECK(value(one, a) == Approx(value(two, b)).epsilon(1e-7));
  // z turns: the mechanism is its own image
  CHECK(value(one, uz) == Approx(value(one, against + uz)).epsilon(1e-7));
}

TEST_CASE("a state at its limit bears nothing, and says why") {
  const Mechanism m = strong_guide(600e6);
  StrokeRequest request = asking({uz}, {0, 0.02});
  request.capacity.stress = 200e6;
  const LoadCapacity stressed = capacity(m, beams(), request, uz, 1);
  CHECK(stressed.value == 0);
  CHECK(stressed.limit == CapacityLimit::stress);
  CHECK_THAT(stressed.reason, Catch::Contains("the state without the load is at the limit"));
  StrokeRequest pressed = asking({uz});
  pressed.loads.constant = {{.force = {-700, 0, 0}}};
  const LoadCapacity buckled = capacity(m, beams(), pressed, uz);
  CHECK(buckled.value == 0);
  CHECK(buckled.limit == CapacityLimit::instability);
}

TEST_CASE("a pull ends where a leaf is stretched beyond its reach") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const LoadCapacity found = capacity(m, beams(), asking({ux}), ux);
  CHECK(found.limit == CapacityLimit::none);
  CHECK_THAT(found.reason, Catch::Contains("stretched"));
  const double area = 2 * 0.03 * 5e-4, modulus = 200e9;  // 5 % of stretch
  CHECK(found.value > 0.9 * 0.05 * modulus * area);
  CHECK(found.value < 1.1 * 0.05 * modulus * area);
}

TEST_CASE("derivatives of the capacity are exact at every limit", "[slow]") {
  const test::Family family{
      [](const test::Values& v) {
        Mechanism m = models::guide(v[0], v[1], v[2], v[3]);
        for (LeafSpring& leaf : m.leaves) leaf.material.youngs_modulus = v[4];
        return m;
      },
      {{"length", 0.1}, {"width", 0.03}, {"thickness", 5e-4}, {"spacing", 0.06}, {"modulus", 2e11}},
      {0, 1, 2, 3, 4},
      1};
  ModelOptions model{.accuracy = Accuracy::full, .mesh = {8, 2}};
  struct Limit {
    CapacityLimit limit;
    int direction;
    double stroke;
    std::optional<double> fillet = {};
    DriveState drive = DriveState::locked;
  };
  for (const Limit& limit :
       {Limit{CapacityLimit::stress, uz, 0.006}, Limit{CapacityLimit::stress, rx, 0.003, 3e-4},
        Limit{CapacityLimit::stiffness, uz, 0.004},
        Limit{CapacityLimit::stiffness, against + ux, 0},
        Limit{CapacityLimit::instability, against + ux, 0.006},
        Limit{CapacityLimit::stress, uy, 0.004, {}, DriveState::free},
        Limit{CapacityLimit::stress, uz, 0.004, {}, DriveState::free},
        Limit{CapacityLimit::stiffness, uz, 0.004, {}, DriveState::free},
        Limit{CapacityLimit::instability, against + ux, 0, {}, DriveState::free}}) {
    StrokeRequest request = asking({limit.direction}, {limit.stroke});
    request.values = PathValues::differentiable;
    request.stress.fillet = limit.fillet;
    request.capacity.drive = limit.drive;
    if (limit.limit == CapacityLimit::stress) request.capacity.stress = 500e6;
    if (limit.limit == CapacityLimit::stiffness) request.capacity.stiffness_share = 0.7;
    const std::vector<MechanismDirection> directions = test::directions_of(family);
    const test::Values p = test::values_of(family.numbers);
    const auto d = static_cast<std::size_t>(limit.direction);
    const StrokeSensitivity here =
        evaluate_stroke_gradients(family.make(p), directions, model, request);
    REQUIRE(here.gradients);
    const auto& found = here.response.path[0].load_capacity[d];
    const auto& gradient = here.gradients->path[0].load_capacity[d];
    REQUIRE(found);
    INFO(found->reason << " at " << found->value);
    REQUIRE(found->limit == limit.limit);
    REQUIRE(gradient);
    const double size = (gradient->array() * VectorXd::Map(p.data(), 5).array()).abs().maxCoeff();
    REQUIRE(size > 0);
    for (const std::size_t k : family.along) {
      const Derivatives difference =
          test::differences_along(family, k, 0.01, [&](const Mechanism& moved) {
            const PathPoint point = evaluate_stroke(moved, model, request).path[0];
            return std::vector{point.load_capacity[d]->value};
          });
      const double exact = (*gradient)[static_cast<Eigen::Index>(k)] * p[k];
      CAPTURE(family.numbers[k].name, exact, difference.value[0] * p[k],
              difference.error[0] * p[k]);
      CHECK(difference.error[0] * p[k] < 1e-6 * size);
      CHECK(std::abs(exact - difference.value[0] * p[k]) < 1e-6 * size);
    }
  }
}

TEST_CASE(
    "the largest load that is looked at has derivative zero, how far a search came has none") {
  const test::Family family{[](const test::Values& v) { return models::guide(v[0], 0.03, 5e-4); },
                            {{"length", 0.1}},
                            {0},
                            1};
  StrokeRequest request = asking({ux});
  request.values = PathValues::differentiable;
  for (const bool bounded : {true, false}) {
    if (bounded)
      request.capacity.largest_force = 500;
    else
      request.capacity.largest_force.reset();
    const StrokeSensitivity here =
        evaluate_stroke_gradients(family.make(test::values_of(family.numbers)),
                                  test::directions_of(family), beams(), request);
    REQUIRE(here.gradients);
    const std::optional<VectorXd>& gradient = here.gradients->path[0].load_capacity[ux];
    CHECK(here.response.path[0].load_capacity[ux]->limit == CapacityLimit::none);
    REQUIRE(gradient.has_value() == bounded);
    if (bounded) CHECK(gradient->isZero(0));
  }
}

TEST_CASE("a load along which nothing moves has no capacity, and says so") {
  // O turns about z alone
  Mechanism m = models::single_leaf(0.1, 0.01, 4e-4);
  m.drives.clear();
  m.bodies[0].held = {true, true, true, true, true, false};
  const LoadCapacity found = capacity(m, beams(), asking({uz}), uz);
  CHECK(found.limit == CapacityLimit::none);
  CHECK(found.value == 0);
  CHECK_THAT(found.reason, Catch::Contains("the load moves nothing"));
  StrokeRequest turning = asking({rx + 2});
  turning.capacity.largest_moment = 0.01;
  CHECK(capacity(m, beams(), turning, rx + 2).value == 0.01);
}
