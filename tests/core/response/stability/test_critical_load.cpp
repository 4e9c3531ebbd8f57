// Critical factors of dead loads: closed forms of columns, guides and strips, folds, laws, exact
// derivatives.
#include <fmt/format.h>

#include <string>

#include "core/elements/plate/beam_section.hpp"
#include "core/math/ridders.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/response/stability/critical_load.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

ModelOptions beams(int elements = 10) { return models::free_beams(elements); }

/// For laws that hold on every mesh.
ModelOptions coarse_plates() { return {.mesh = {6, 2}}; }

/// The equilibrium on full leaves at a stroke under one load, then its critical factor.
CriticalLoadResult critical(const Mechanism& mechanism, const ModelOptions& model,
                            const DeadLoad& load, DriveState drive, double stroke = 0,
                            const std::vector<Mechanism>* directions = nullptr,
                            double largest = no_critical_factor) {
  NewtonOptions newton{.tolerance = 1e-11};
  LoadCase loads{.constant = {load}};
  System system(mechanism, make_full_leaves(mechanism, model), loads);
  REQUIRE(step_load(system, {.constant = 1}, newton).converged);
  const Equilibrium at = step_to(system, stroke, newton);
  REQUIRE(at.converged);
  LoadBranch branch(system, 0, 0, drive, at.drive_loads, newton);
  if (!directions) return find_critical_load(branch, model, nullptr, true, largest);
  DesignDirections design(mechanism, *directions);
  return find_critical_load(branch, model, &design);
}

/// The factor near which the branch is said to bend away.
double told_bifurcation(const CriticalLoad& load) {
  const std::string said = "it bends away from a bifurcation near a factor of ";
  INFO(load.reason);
  const std::size_t at = load.reason.find(said);
  REQUIRE(at != std::string::npos);
  return std::stod(load.reason.substr(at + said.size()));
}

DeadLoad along_x(double force) { return {.force = {force, 0, 0}}; }

using models::bending;

}  // namespace

TEST_CASE("columns buckle at Euler's loads") {
  const double L = 0.1, w = 0.01, t = 2e-4;
  const double unit = M_PI * M_PI * bending(models::single_leaf(L, w, t).leaves[0]) / (L * L);
  struct Column {
    const char* what;
    bool turns;
    DriveState drive;
    double factor;
  };
  // clamped at the base; the tip free, pinned (tan kL = kL), guided, clamped
  for (const Column& column : {Column{"free tip", true, DriveState::free, 0.25},
                               Column{"pinned tip", true, DriveState::locked,
                                      4.493409457909064 * 4.493409457909064 / (M_PI * M_PI)},
                               Column{"guided tip", false, DriveState::free, 1},
                               Column{"clamped tip", false, DriveState::locked, 4}}) {
    Mechanism m = models::single_leaf(L, w, t);
    m.bodies[0].held[5] = !column.turns;
    const double load = 0.01 * unit;
    const CriticalLoadResult r = critical(m, beams(), along_x(-load), column.drive);
    INFO(column.what << " " << r.load.reason);
    REQUIRE(r.load.factor);
    CHECK(*r.load.factor * load == Approx(column.factor * unit).epsilon(1e-3));
    CHECK_FALSE(r.load.fold);
    // hardly anything happens on the way there: the estimate is as good
    CHECK(*r.load.linearised == Approx(*r.load.factor).epsilon(1e-3));
  }
}

TEST_CASE("the estimate of a straight column is its load, whatever carries O") {
  const double L = 0.02, w = 5e-3, t = 6e-4, E = 200e9;
  const double EI = E * w * t * t * t / 12, A = w * t, kGA = E / 2 * A * 5 / 6;
  for (const Flexure flexure : {Flexure::beam, Flexure::plate})
    for (const bool point : {false, true})
      for (const int elements : {4, 12}) {
        Mechanism m = models::single_leaf(L, w, t, Direction::uy, models::without_poisson());
        if (point) m = models::free_tip(m);
        const ModelOptions model{.flexure = flexure,
                                 .mesh = {elements, flexure == Flexure::beam ? 1 : 3}};
        for (const DriveState drive : {DriveState::free, DriveState::locked}) {
          // clamped at the base, the tip free or pinned
          const double k = drive == DriveState::locked ? 4.493409457909064 / L : M_PI / (2 * L),
                       euler = k * k * EI, expected = euler / (1 + euler / kGA);
          const CriticalLoadResult r = critical(m, model, along_x(-1), drive);
          CAPTURE(static_cast<int>(flexure), point, elements, expected, r.load.reason);
          REQUIRE(r.load.factor);
          REQUIRE(r.load.linearised);
          // four elements are 1 % too stiff for a pinned column; the column gets shorter on the way
          // by its strain, which changes its load by no more
          const double strain = expected / (E * A);
          CHECK(*r.load.factor == Approx(expected).epsilon(elements == 4 ? 0.01 : 5e-3));
          CHECK(*r.load.linearised == Approx(*r.load.factor).epsilon(2 * strain + 1e-5));
        }
      }
}

TEST_CASE("a column of forty leaves buckles as one of a piece, solved sparse") {
  const int pieces = 40;
  const double L = 0.1, w = 1e-3, t = 2e-4;
  Mechanism m = models::single_leaf(L, w, t);
  const double unit = M_PI * M_PI * bending(m.leaves[0]) / (L * L);
  m.bodies.clear();
  m.leaves.clear();
  for (int i = 0; i < pieces; ++i) {
    m.bodies.push_back(models::body({(i + 1) * L / pieces, 0, 0}, 0, 0));
    m.leaves.push_back(models::leaf({i * L / pieces, 0, 0}, {1, 0, 0}, L / pieces, w, t));
    m.leaves.back().base = i - 1;
    m.leaves.back().tip = i;
  }
  m.end_effector = m.drives[0].body = pieces - 1;
  ModelOptions model = beams(2);
  for (const auto& [drive, factor] :
       {std::pair{DriveState::free, 0.25},
        {DriveState::locked, 4.493409457909064 * 4.493409457909064 / (M_PI * M_PI)}}) {
    const CriticalLoadResult r = critical(m, model, along_x(-0.01 * unit), drive);
    INFO(r.load.reason);
    REQUIRE(r.load.factor);
    CHECK(*r.load.factor == Approx(100 * factor).epsilon(1e-3));
  }
}

TEST_CASE("tips that rigid joints tie to a body buckle as tips that belong to it", "[slow]") {
  const Mechanism whole = models::guide(0.1, 0.03, 5e-4);
  Mechanism tied = whole;
  for (int k = 0; k < 2; ++k) {
    tied.bodies.push_back(models::body({0.1, 0, 0}, 0, 0));
    tied.leaves[static_cast<std::size_t>(k)].tip = k + 1;
    tied.joints.push_back({.type = JointType::rigid, .body = 0, .other = k + 1});
  }
  for (const double stroke : {0.0, 0.004}) {
    const double expected =
        *critical(whole, {}, along_x(-20), DriveState::locked, stroke).load.factor;
    const CriticalLoadResult r = critical(tied, {}, along_x(-20), DriveState::locked, stroke);
    INFO(r.load.reason);
    REQUIRE(r.load.factor);
    CHECK(*r.load.factor == Approx(expected).epsilon(1e-7));
  }
}

TEST_CASE("a spring that holds a guide back raises its load by what it holds") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  Mechanism held = m;
  const double k = 400;
  for (const double side : {5.0, -5.0})  // one alone would pull it aside
    held.springs.push_back({.body = 0,
                            .place = {0.1, 0, 0},
                            .other_place = {0.1, side, 0},
                            .stiffness = k / 2,
                            .free_length = 5});
  const CriticalLoadResult r = critical(held, {}, along_x(-10), DriveState::free);
  INFO(r.load.reason);
  REQUIRE(r.load.factor);
  // the guide alone, pressed as far, pulls back as hard as the spring
  LoadCase loads{.constant = {along_x(-10 * *r.load.factor)}};
  System system(m, make_full_leaves(m, {}), loads);
  REQUIRE(step_load(system, {.constant = 1}, {}).converged);
  const Equilibrium up = step_to(system, 1e-6, {});
  const Equilibrium down = step_to(system, -1e-6, {});
  CHECK((up.drive_load - down.drive_load) / 2e-6 == Approx(-k).epsilon(1e-3));
}

TEST_CASE("strips without Poisson's ratio buckle as columns, wide or narrow") {
  for (const double w : {0.01, 0.1}) {
    Mechanism m = models::single_leaf(0.1, w, 4e-4, Direction::uy, models::without_poisson());
    const double unit = M_PI * M_PI * bending(m.leaves[0]) / 0.01;
    m.bodies[0].held = {false, false, true, true, true, true};
    for (const auto& [drive, factor] :
         {std::pair{DriveState::free, 1.0}, {DriveState::locked, 4.0}}) {
      const CriticalLoadResult r = critical(m, {}, along_x(-1), drive);
      REQUIRE(r.load.factor);
      CHECK(*r.load.factor == Approx(factor * unit).epsilon(5e-3));
    }
  }
}

TEST_CASE("a wide strip buckles at the stiffness of a plate, a narrow one at that of a beam") {
  const double nu = 0.3;
  const auto over_beam = [&](double w) {
    Mechanism m = models::single_leaf(0.1, w, 4e-4);
    m.bodies[0].held = {false, false, true, true, true, true};
    const CriticalLoadResult r = critical(m, {}, along_x(-1), DriveState::free);
    INFO(w << " " << r.load.reason);
    REQUIRE(r.load.factor);
    return *r.load.factor / (M_PI * M_PI * bending(m.leaves[0]) / 0.01);
  };
  // 1 + nu²/(1 − nu²) (1 − ends − free edges): the free edges of a wide strip and the clamped ends
  // of a narrow one still count
  const double narrow = over_beam(0.002), wide = over_beam(1.0);
  CHECK(narrow > 1);
  CHECK(narrow < 1.008);
  CHECK(wide < 1 / (1 - nu * nu));
  CHECK(wide == Approx(1 / (1 - nu * nu)).epsilon(5e-3));
}

TEST_CASE("a narrow leaf under a load in its plane buckles sideways at Prandtl's load") {
  const Material m{"m", 200e9, 0.3, 7800, {}};
  const double L = 1, w = 0.02, t = 4e-4;
  const BeamSection s = beam_section(Section::rectangular, w, t, 0.3);
  const double load =
      4.012599 * std::sqrt(m.youngs_modulus * s.I_weak * m.shear_modulus() * s.J) / (L * L);
  const CriticalLoadResult r = critical(models::single_leaf(L, w, t, Direction::uy, m), beams(16),
                                        {.force = {0, 0, 0.1 * load}}, DriveState::free);
  REQUIRE(r.load.factor);
  // 1/sqrt(1 − EI_weak/EI_strong) for the bending before: 2e-4; the elements, 1e-3
  CHECK(*r.load.factor == Approx(10).epsilon(5e-3));
}

TEST_CASE("a guide carries four times as much with its drive held") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4, 0.1);
  const double sway = 2 * M_PI * M_PI * bending(m.leaves[0]) / 0.01;
  ModelOptions model = beams();
  const CriticalLoadResult locked = critical(m, model, along_x(-1), DriveState::locked),
                           free = critical(m, model, along_x(-1), DriveState::free);
  REQUIRE(locked.load.factor);
  REQUIRE(free.load.factor);
  CHECK(*free.load.factor == Approx(sway).epsilon(2e-3));
  CHECK(*locked.load.factor == Approx(4 * sway).epsilon(2e-3));
  // free it sways, held the leaves bulge and the body stands
  REQUIRE(free.load.mode.size() == 1);
  CHECK(std::abs(free.load.mode[0].displacement[1]) > 0.2);
  CHECK(locked.load.mode[0].displacement.norm() < 1e-3);
  // plates: CalculiX, tests/benchmarks/calculix/buckling.py, 516.6 and 128.9 N
  CHECK(*critical(m, {}, along_x(-1), DriveState::locked).load.factor ==
        Approx(516.6).epsilon(5e-3));
  CHECK(*critical(m, {}, along_x(-1), DriveState::free).load.factor == Approx(128.9).epsilon(5e-3));
}

TEST_CASE("over the stroke the traced load stays, and the estimate comes to it as the load does",
          "[slow]") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  for (const double stroke : {0.0, 0.005, 0.01}) {
    double traced = 0, before = 1;
    for (const double load : {5.0, 100.0, 300.0, 450.0}) {
      const CriticalLoadResult r = critical(m, beams(), along_x(-load), DriveState::locked, stroke);
      CAPTURE(stroke, load, r.load.reason);
      REQUIRE(r.load.factor);
      REQUIRE(r.load.linearised);
      CHECK(r.load.fold == (stroke > 0));
      if (traced == 0) traced = *r.load.factor * load;
      CHECK(*r.load.factor * load == Approx(traced).epsilon(1e-6));
      const double off = 1 - *r.load.linearised * load / traced;
      if (stroke == 0) {
        CHECK(std::abs(off) < 2e-4);  // a straight guide does not change before it gives way
        continue;
      }
      // a bent one softens faster and faster: from far away the estimate is too low
      if (load == 5) CHECK(off > 0.2);
      CHECK(off > 0);
      CHECK(off < before);
      before = off;
    }
    CHECK((stroke == 0 || before < 0.05));
  }
}

TEST_CASE("the factor is inverse to the load and turns its sign with it", "[slow]") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  for (const DriveState drive : {DriveState::locked, DriveState::free}) {
    const double one = *critical(m, {}, along_x(-1), drive).load.factor,
                 ten = *critical(m, {}, along_x(-10), drive).load.factor,
                 pulled = *critical(m, {}, along_x(10), drive).load.factor;
    CHECK(ten == Approx(one / 10).epsilon(1e-8));
    CHECK(pulled == Approx(-one / 10).epsilon(1e-8));
  }
}

TEST_CASE("what the forms of a leaf change by along its state is the same without the shape") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  System system(m, make_full_leaves(m, coarse_plates()), LoadCase{.gravity = {1, 2, 3}});
  REQUIRE(step_load(system, {.constant = 1}, {}).converged);
  REQUIRE(step_to(system, 0.01, {}).converged);
  const Answer<MechanismFactor> factor = MechanismFactor::of(system);
  REQUIRE(factor);
  DesignDirections still(m, {zero_rate(m)});
  for (const MechanismFactor::Leaf& leaf : factor->leaves()) {
    const auto gradient = leaf.linear->gradient(still.rates, leaf.rows);
    REQUIRE(gradient);
    const MatrixXd Y = MatrixXd::Random((*gradient)->size(), 3),
                   all = (*gradient)->quadratic(Y, VectorXd::Zero(3)).state;
    CHECK((*gradient)->state_rates(Y).isApprox(all, 1e-14));
    CHECK(all.norm() > 0);
  }
}

TEST_CASE("a factor is looked for up to the largest that is asked for, either way") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const auto up_to = [&](double largest, double force) {
    return critical(m, coarse_plates(), along_x(force), DriveState::locked, 0, nullptr, largest)
        .load;
  };
  const double factor = *up_to(no_critical_factor, -10).factor;
  const CriticalLoad within = up_to(1.05 * factor, -10), beyond = up_to(0.95 * factor, -10);
  CHECK(*within.factor == Approx(factor).epsilon(1e-8));
  CHECK_FALSE(within.at_least);
  CHECK_FALSE(beyond.factor);
  CHECK(beyond.none);
  CHECK(beyond.at_least == 0.95 * factor);
  CHECK_THAT(beyond.reason,  // as far as was asked, however far the last step went
             Catch::Contains(fmt::format("no singular tangent on the branch of equilibria up to a "
                                         "factor of {:.4g}",
                                         0.95 * factor)));
  CHECK(*beyond.linearised == Approx(factor).epsilon(1e-3));
  // the load that pulls is reversed
  const CriticalLoad pulled = up_to(1.05 * factor, 10), neither = up_to(0.95 * factor, 10);
  CHECK(*pulled.factor == Approx(-factor).epsilon(1e-8));
  CHECK(pulled.at_least == 1.05 * factor);
  CHECK_FALSE(neither.factor);
  CHECK(neither.at_least == 0.95 * factor);
}

TEST_CASE("the tangent is definite below the factor and indefinite above") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  NewtonOptions newton;
  LoadCase loads{.constant = {along_x(-50)}};
  System system(m, make_full_leaves(m, coarse_plates()), loads);
  REQUIRE(step_load(system, {.constant = 1}, newton).converged);
  for (const double stroke : {0.0, 0.005}) {
    const Equilibrium at = step_to(system, stroke, newton);
    REQUIRE(at.converged);
    LoadBranch branch(system, 0, 0, DriveState::locked, at.drive_loads, newton);
    const auto begin = branch.save();
    const CriticalLoadResult r = find_critical_load(branch, coarse_plates(), nullptr);
    REQUIRE(r.load.factor);
    branch.restore(begin);
    for (const double share : {0.5, 0.9, 0.99, 0.999}) {
      REQUIRE(branch.advance_to(share * *r.load.factor));
      CHECK(branch.negative_pivots() == 0);
    }
    // deflected, the branch turns: there is no equilibrium next to it with more of the load
    CHECK(r.load.fold == (stroke != 0));
    if (stroke == 0) {
      REQUIRE(branch.advance_to(1.001 * *r.load.factor));
      CHECK(branch.negative_pivots() > 0);
    }
  }
}

TEST_CASE("a state that has buckled has a factor below one") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const double sway = *critical(m, {}, along_x(-1), DriveState::free).load.factor;
  const CriticalLoadResult r = critical(m, {}, along_x(-2 * sway), DriveState::free);
  REQUIRE(r.load.factor);
  CHECK(*r.load.factor == Approx(0.5).epsilon(1e-6));
  CHECK_FALSE(r.load.linearised);  // of a state that is stable alone
}

TEST_CASE("a guide that is deflected gives way with its drive free, and says so", "[slow]") {
  const CriticalLoadResult r =
      critical(models::guide(0.1, 0.03, 5e-4), {}, along_x(-5), DriveState::free, 0.005);
  CHECK_FALSE(r.load.factor);
  CHECK(r.load.none);
  CHECK_THAT(r.load.reason, Catch::Contains("no singular tangent"));
  CHECK(r.load.linearised);
}

TEST_CASE("a bifurcation that an imperfection makes the branch miss is told, however small it is") {
  // a dead force of 1e-7 N pulls the guide aside
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const double perfect = *critical(m, coarse_plates(), along_x(-10), DriveState::free).load.factor;
  LoadCase loads{.constant = {along_x(-10), {.force = {0, 1e-7, 0}}}};
  System system(m, make_full_leaves(m, coarse_plates()), loads);
  REQUIRE(step_load(system, {.constant = 1}, {}).converged);
  LoadBranch branch(system, 0, 0, DriveState::free, VectorXd::Zero(1), {});
  const CriticalLoadResult r = find_critical_load(branch, coarse_plates(), nullptr);
  CHECK_FALSE(r.load.factor);
  CHECK(told_bifurcation(r.load) == Approx(perfect).epsilon(1e-3));
}

TEST_CASE("a bifurcation that an error of assembly makes the branch miss is none of its states",
          "[slow]") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  Mechanism thicker = m;
  each_number(thicker, [](double& x) { x = 0; });
  for (LeafSpring& leaf : thicker.leaves) leaf.thickness = 1;
  const std::vector<Mechanism> directions{thicker};
  const auto traced = [&](double turn) {
    LoadCase loads{.constant = {along_x(-5)}, .assembly = {{0, 0, Vector3d::Zero(), {0, turn, 0}}}};
    System system(m, make_full_leaves(m, coarse_plates()), loads);
    REQUIRE(step_load(system, {.constant = 1}, {}).converged);
    LoadBranch branch(system, 0, 0, DriveState::free, VectorXd::Zero(1), {});
    DesignDirections design(m, directions);
    return find_critical_load(branch, coarse_plates(), &design);
  };
  // one that is zero, or next to nothing, is rounding: on the other side the tangent is indefinite
  const CriticalLoadResult perfect =
      critical(m, coarse_plates(), along_x(-5), DriveState::free, 0, &directions);
  REQUIRE(perfect.gradient);
  for (const double turn : {0.0, 1e-12, 1e-10, 1e-8, 1e-7}) {
    const CriticalLoadResult r = traced(turn);
    CAPTURE(turn, r.load.reason);
    REQUIRE(r.load.factor);
    CHECK(*r.load.factor == Approx(*perfect.load.factor).epsilon(1e-8));
    CHECK_FALSE(r.load.fold);
    REQUIRE(r.gradient);
    CHECK((*r.gradient)[0] == Approx((*perfect.gradient)[0]).epsilon(1e-6));
  }
  for (const double turn : {7e-5, 3e-4, 1e-3}) {
    const CriticalLoadResult crooked = traced(turn);
    CAPTURE(turn, crooked.load.reason);
    // it bends away and stays stable; where that is said is an estimate, with its digits
    CHECK_FALSE(crooked.load.factor);
    CHECK_FALSE(crooked.gradient);
    if (turn < 5e-4)  // a larger one is not heading for it
      CHECK(told_bifurcation(crooked.load) ==
            Approx(*perfect.load.factor).epsilon(100 * turn + 1e-3));
  }
}

TEST_CASE("derivatives of the factor are exact at bifurcations and at folds", "[slow]") {
  const std::vector<double> numbers{0.1, 0.03, 5e-4};
  const auto make = [](const std::vector<double>& v) { return models::guide(v[0], v[1], v[2]); };
  const auto places = [](Mechanism& m) {
    std::vector<double*> all;
    each_number(m, [&](double& x) { all.push_back(&x); });
    return all;
  };
  std::vector<Mechanism> directions;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    std::vector<double> low = numbers, high = numbers;
    low[k] *= 0.99;
    high[k] *= 1.01;
    Mechanism rate = make(high), other = make(low);  // every number is linear in these
    const std::vector<double*> to = places(rate), from = places(other);
    for (std::size_t i = 0; i < to.size(); ++i) *to[i] = (*to[i] - *from[i]) / (0.02 * numbers[k]);
    directions.push_back(std::move(rate));
  }
  struct At {
    DriveState drive;
    double stroke;
    bool fold;
  };
  for (const At& at : {At{DriveState::locked, 0, false}, At{DriveState::free, 0, false},
                       At{DriveState::locked, 0.01, true}}) {
    const CriticalLoadResult here =
        critical(make(numbers), {}, along_x(-5), at.drive, at.stroke, &directions);
    REQUIRE(here.gradient);
    CHECK(here.load.fold == at.fold);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      const Derivatives d = ridders(
          [&](double x) {
            std::vector<double> moved = numbers;
            moved[k] = x;
            return std::vector{
                *critical(make(moved), {}, along_x(-5), at.drive, at.stroke).load.factor};
          },
          numbers[k], 0.01 * numbers[k]);
      CAPTURE(k, at.stroke, d.value[0], d.error[0]);
      const double exact = (*here.gradient)[static_cast<Eigen::Index>(k)];
      CHECK(d.error[0] < 1e-6 * std::abs(exact));
      CHECK(std::abs(exact - d.value[0]) < 1e-7 * std::abs(exact));
    }
  }
}
