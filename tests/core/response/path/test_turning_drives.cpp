// Drives that turn bodies which other loads and drives tilt: stroke, load, stiffness and what is
// held belong together, by differences of states on full leaves.
#include <random>

#include "core/equilibrium/end_effector_compliance.hpp"
#include "core/math/ridders.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

constexpr NewtonOptions exactly{.tolerance = 1e-13};

/// A leaf along x that a drive twists at its tip, while a force bends it.
Mechanism twisted_leaf() { return models::single_leaf(0.05, 5e-3, 5e-4, Direction::rx); }
LoadCase side_force(double force) { return {.constant = {{.force = {0, force, 0}}}}; }

StrokeRequest at(std::vector<VectorXd> strokes, LoadCase loads) {
  StrokeRequest request{.points = {}};
  for (VectorXd& s : strokes) {
    request.points.push_back(s[0]);
    request.strokes.push_back(std::move(s));
  }
  request.frequencies = 4;
  request.newton = exactly;
  request.loads = std::move(loads);
  request.outputs.remove(Output::frequency_derivatives);
  return request;
}

/// A state on full leaves, and those near it.
class State {
 public:
  State(const Mechanism& mechanism, const ModelOptions& model, LoadCase loads, VectorXd strokes)
      : mechanism_(&mechanism),
        model_(model),
        strokes_(std::move(strokes)),
        system_(system(std::move(loads))) {
    REQUIRE(step_load(*system_, {.constant = 1}, exactly).converged);
    here_ = step_to(*system_, strokes_, exactly);
    INFO(here_.message);
    REQUIRE(here_.converged);
  }
  const System& here() const { return *system_; }
  const VectorXd& strokes() const { return strokes_; }
  const VectorXd& loads() const { return here_.drive_loads; }

  /// Drive loads, then displacement and spin of O from here: strokes held, other ones or loaded
  /// more at O.
  VectorXd near(const VectorXd& strokes, const Vector6d& more) const {
    LoadCase loads = system_->loads();
    loads.constant.push_back(load_at_O(more));
    const auto moved = system(std::move(loads));
    moved->restore(system_->save());
    const Equilibrium e = step_to(*moved, strokes, exactly);
    INFO(e.message);
    REQUIRE(e.converged);
    const JointBody &a = system_->pose(mechanism_->end_effector),
                    &b = moved->pose(mechanism_->end_effector);
    VectorXd all(strokes.size() + 6);
    all << e.drive_loads, b.position - a.position,
        rotation_log(b.rotation * a.rotation.transpose());
    return all;
  }
  /// Derivative of near(): of every stroke a column, then of every load at O, none of those that
  /// move nothing; and how well it is known.
  struct Differences {
    MatrixXd value, error;
  };
  Differences differences() const {
    const Eigen::Index drives = strokes_.size(), all = drives + 6;
    Differences D{MatrixXd::Zero(all, all), MatrixXd::Zero(all, all)};
    const EndEffectorCompliance stiff = end_effector_compliance(*system_);
    for (Eigen::Index k = 0; k < all; ++k) {
      const Eigen::Index load = k - drives;
      double h = 3e-3;  // [rad], or so much of a length
      if (load < 0) {
        if (!is_rotation(mechanism_->drives[static_cast<std::size_t>(k)].direction))
          h *= 0.1 * system_->length();
      } else {
        if (stiff.drive_locked(load, load) == 0) continue;
        h *= (load < 3 ? 0.1 * system_->length() : 1) /
             std::max(stiff.drive_locked(load, load), std::abs(stiff.drive_free(load, load)));
      }
      const Derivatives d = ridders(
          [&](double x) {
            VectorXd s = strokes_;
            Vector6d more = Vector6d::Zero();
            (load < 0 ? s[k] : more[load]) += x;
            const VectorXd moved = near(s, more);
            return std::vector<double>(moved.begin(), moved.end());
          },
          0, h);
      D.value.col(k) = Eigen::Map<const VectorXd>(d.value.data(), all);
      D.error.col(k) = Eigen::Map<const VectorXd>(d.error.data(), all);
    }
    return D;
  }

 private:
  std::unique_ptr<System> system(LoadCase loads) const {
    return std::make_unique<System>(*mechanism_, make_full_leaves(*mechanism_, model_),
                                    std::move(loads));
  }
  const Mechanism* mechanism_;
  ModelOptions model_;
  VectorXd strokes_;
  std::unique_ptr<System> system_;
  Equilibrium here_;
};

/// Largest difference of two matrices over the sizes of rows and columns, those of a diagonal.
double off(const MatrixXd& a, const MatrixXd& b, const VectorXd& diagonal) {
  const VectorXd size = diagonal.cwiseAbs().cwiseSqrt();
  double worst = 0;
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < a.cols(); ++j)
      if (size[i] * size[j] > 0)
        worst = std::max(worst, std::abs(a(i, j) - b(i, j)) / (size[i] * size[j]));
  return worst;
}
double off(const MatrixXd& a, const MatrixXd& b) { return off(a, b, b.diagonal()); }

/// How far what is linear about a state is from differences of states, and how well these are
/// known: stiffness of the strokes, compliances, and that a load at O changes the drive loads as
/// the strokes move O (Maxwell and Betti).
struct Linear {
  double off, known;
};
Linear compared(const State& state) {
  const auto drives = state.strokes().size();
  const auto [D, error] = state.differences();
  const EndEffectorCompliance found = end_effector_compliance(state.here());
  const MatrixXd S = D.topLeftCorner(drives, drives), Y = D.bottomLeftCorner(6, drives);
  const Matrix6d free = D.bottomRightCorner<6, 6>() + Y * S.inverse() * Y.transpose();
  // of the strokes by the loads, of O by both
  VectorXd size(drives + 6);
  size << S.diagonal(), found.drive_locked.diagonal();
  MatrixXd other = D.transpose();
  other.topRightCorner(drives, 6) *= -1;
  other.bottomLeftCorner(6, drives) *= -1;
  double worst = off(D, other, size);
  worst = std::max(worst, off(found.drive_locked, D.bottomRightCorner<6, 6>(), size.tail(6)));
  for (Eigen::Index k = 0; k < drives; ++k)
    worst = std::max(worst, std::abs(found.drive_stiffness[k] / S(k, k) - 1));
  if (found.drive_free.diagonal().minCoeff() > 0)  // stable with the drives free
    worst = std::max(worst, off(found.drive_free, free));
  return {worst, off(error, MatrixXd::Zero(drives + 6, drives + 6), size)};
}

/// Bodies one after the other, each on three wires from those before it, of random places and
/// sizes; drives of random bodies, directions and axes, rotations among them.
struct RandomMechanism {
  std::mt19937 random;
  Mechanism m;
  double number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  int choice(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random); }
  Vector3d vector(double size) {
    return size * Vector3d(number(-1, 1), number(-1, 1), number(-1, 1));
  }

  explicit RandomMechanism(unsigned seed) : random(seed) {
    const int bodies = 1 + choice(3);
    std::vector<Vector3d> places;
    for (int b = 0; b < bodies; ++b) {
      const int from = b == 0 ? ground : choice(b + 1) - 1;
      const Vector3d start = from < 0 ? Vector3d(Vector3d::Zero()) : places[from];
      const Vector3d way =
          Vector3d(number(-1, 1), number(-1, 1), number(-1, 1)).normalized() * number(0.05, 0.1);
      places.push_back(start + way);
      m.bodies.push_back(models::body(places.back(), number(0.1, 0.5), number(1e-5, 1e-4)));
      if (b > 0) m.bodies.back().role = BodyRole::intermediate;
      for (int k = 0; k < 2; ++k) {
        const Vector3d base = start + vector(0.02), along = places.back() + vector(0.02) - base;
        LeafSpring leaf =
            models::leaf(base, along, along.norm(), number(2e-3, 6e-3), number(4e-4, 8e-4));
        const Vector3d across = along.cross(vector(1)).normalized();
        leaf.axes.col(1) = across;
        leaf.axes.col(2) = leaf.axes.col(0).cross(across);
        leaf.base = from;
        leaf.tip = b;
        m.leaves.push_back(leaf);
      }
    }
    m.end_effector = choice(bodies);
    const int drives = 1 + choice(6);
    for (int k = 0; k < drives; ++k) {
      Drive d;
      d.name = "d" + std::to_string(k);
      d.body = choice(bodies);
      d.other = choice(2) == 0 ? ground : choice(bodies);
      if (d.other == d.body) d.other = ground;
      d.direction = static_cast<Direction>(choice(3) == 0 ? choice(3) : 3 + choice(3));
      if (choice(2) == 0) d.axes = rotation_exp(vector(2));
      m.drives.push_back(d);
      if (!check_rules(m)) m.drives.pop_back();
    }
  }

  LoadCase forces(double size) {
    LoadCase loads;
    for (int b = 0; b < static_cast<int>(m.bodies.size()); ++b)
      loads.constant.push_back({.force = vector(size), .body = b, .arm = vector(0.03)});
    return loads;
  }
  /// Strokes of the state to which forces lead without the drives: all of them fit together.
  VectorXd reachable(const ModelOptions& model) {
    LoadCase loads = forces(3);
    std::swap(loads.constant, loads.growing);
    System system(m, make_full_leaves(m, model), loads);
    if (!step_load(system, {.growing = 1}, {}).converged) return {};
    return present_strokes(system);
  }
};

}  // namespace

TEST_CASE("stiffnesses of a twisted leaf that is bent are those of the stroke that is held") {
  // bent by 0.24 and 0.45 rad, twisted by 0.3
  const Mechanism m = twisted_leaf();
  ModelOptions plate{.accuracy = Accuracy::full, .mesh = {8, 2}};
  for (const double force : {2.0, 4.0}) {
    const State state(m, plate, side_force(force), VectorXd::Constant(1, 0.3));
    CHECK(rotation_log(state.here().pose(0).rotation).tail<2>().norm() > 0.1 * force);
    const Linear linear = compared(state);
    CHECK(linear.off < 1e-6);
    CHECK(linear.known < 1e-6);
  }
}

TEST_CASE("a second drive on another body changes no number of the first") {
  const Mechanism alone = twisted_leaf();
  Mechanism beside = alone;
  beside.bodies.push_back(models::intermediate({0, 0.1, 0}, 0.2, 1e-4));
  beside.leaves.push_back(models::leaf({0, 0.1, 0.05}, {0, 0, -1}, 0.05, 4e-3, 5e-4));
  beside.leaves[1].axes << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  beside.leaves[1].axes.col(0) = -Vector3d::UnitZ();
  beside.leaves[1].axes.col(1) = Vector3d::UnitX();
  beside.leaves[1].axes.col(2) = beside.leaves[1].axes.col(0).cross(beside.leaves[1].axes.col(1));
  beside.leaves[1].tip = 1;
  beside.drives[0].name = "twist";
  beside.drives.push_back({"other", 1, ground, Direction::ry});
  const Mechanism m = beside;
  LoadCase loads = side_force(3);
  const StrokeResponse a =
      evaluate_stroke(alone, models::beams(8), at({VectorXd::Constant(1, 0.4)}, loads));
  loads.constant.push_back({.force = {0.3, 0.5, 0}, .body = 1});
  const StrokeResponse b =
      evaluate_stroke(m, models::beams(8), at({Eigen::Vector2d(0.4, 0.2)}, loads));
  INFO(a.message << " " << b.message);
  REQUIRE(a.status == Status::ok);
  REQUIRE(b.status == Status::ok);
  const PathPoint &p = a.path[0], &q = b.path[0];
  CHECK(q.drive_loads[0] == Approx(p.drive_load).epsilon(1e-9));
  CHECK(q.drive_stiffnesses[0] == Approx(p.drive_stiffness).epsilon(1e-9));
  CHECK((q.displacement - p.displacement).norm() < 1e-10 * p.displacement.norm());
  CHECK((q.rotation - p.rotation).norm() < 1e-10);
  CHECK(off(q.compliance_free, p.compliance_free) < 1e-9);
  CHECK(off(q.compliance_locked + 1e-9 * p.compliance_free,
            p.compliance_locked + 1e-9 * p.compliance_free) < 1e-7);
  for (int d = 0; d < 6; ++d)
    if (p.support_stiffness[d])
      CHECK(*q.support_stiffness[d] == Approx(*p.support_stiffness[d]).epsilon(1e-8));
}

TEST_CASE("about its own axis alone a body turns as a coordinate does") {
  // what is held, deleted from the tangent: of the energy of the leaves alone, at the same state
  const Mechanism m = models::three_leaf_hinge(0.08, 0.02, 3.5e-4);
  const State state(m, models::beams(8), {}, VectorXd::Constant(1, 0.35));
  System free(m, make_full_leaves(m, models::beams(8)), {});
  System::Snapshot snapshot = state.here().save();
  snapshot.multipliers.setZero();
  free.restore(snapshot);
  free.assemble();
  const MatrixXd K = free.tangent().dense();
  const EndEffectorCompliance found = end_effector_compliance(state.here());
  const Matrix6d C = K.inverse();
  CHECK(off(found.drive_free, C) < 1e-9);
  CHECK(found.drive_stiffness[0] == Approx(1 / C(5, 5)).epsilon(1e-9));
  CHECK(state.loads()[0] == Approx(free.internal_force()[5]).epsilon(1e-9));
  const MatrixXd held = K.topLeftCorner<5, 5>().inverse();
  CHECK(off(found.drive_locked.topLeftCorner<5, 5>(), held) < 1e-10);
  CHECK(found.drive_locked.col(5).isZero(0));
}

TEST_CASE("random drives, most of them turns, answer small changes as their matrices say") {
  int well_known = 0;
  constexpr int tried = 16;
  for (unsigned seed = 1; seed <= tried; ++seed) {
    RandomMechanism made(seed);
    const ModelOptions model = models::beams(3);
    const VectorXd strokes = made.reachable(model);
    if (strokes.size() == 0) continue;
    const State state(made.m, model, made.forces(1), strokes);
    const Linear linear = compared(state);
    INFO("seed " << seed << ", drives " << strokes.size() << ", off by " << linear.off
                 << ", known to " << linear.known);
    CHECK(linear.off < 1e-6 + 30 * linear.known);
    well_known += linear.known < 1e-6;
  }
  CHECK(well_known >= tried / 2);
}

TEST_CASE("no work is left around a closed loop of two strokes") {
  Mechanism m = twisted_leaf();
  m.drives[0].name = "twist";
  m.drives.push_back({"turn", 0, ground, Direction::ry, rotation_exp({0.3, 0, 0.2})});
  const State state(m, models::beams(6), side_force(3), Eigen::Vector2d(0.2, 0.05));
  // around a rectangle, by Gauss's rule of five points a side
  constexpr double x[] = {0, 0.5384693101056831, 0.9061798459386640},
                   w[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const Eigen::Vector2d size(0.2, 0.1);
  double loop = 0, turnover = 0;
  for (int side = 0; side < 4; ++side) {
    const int along = side % 2;
    const double sense = side < 2 ? 1 : -1;
    for (int k = -2; k <= 2; ++k) {
      Eigen::Vector2d s = state.strokes();
      s[along] += sense * size[along] * 0.5 * std::copysign(x[std::abs(k)], k);
      s[1 - along] += (side == 0 || side == 3 ? -0.5 : 0.5) * size[1 - along];
      const double part =
          0.5 * w[std::abs(k)] * size[along] * state.near(s, Vector6d::Zero())[along];
      loop += sense * part;
      turnover += std::abs(part);
    }
  }
  CHECK(std::abs(loop) < 1e-8 * turnover);
}
