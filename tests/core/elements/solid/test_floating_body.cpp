// The laws of a body in its floating frame, for bodies of random numbers: objectivity, derivatives,
// balance, rates along a path and along a change of the body.
#include "core/elements/solid/floating_body.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "core/math/decompositions.hpp"
#include "core/math/ridders.hpp"
#include "support/synthetic_leaf.hpp"

using namespace flexopt;
using flexopt::synthetic::Random;

namespace {

constexpr double size = 0.1;  // [m]

MatrixXd any(Random& random, Eigen::Index rows, Eigen::Index columns) {
  return MatrixXd::NullaryExpr(rows, columns, [&] { return random(); });
}

// Lengths in units of the size.
VectorXd units(Eigen::Index n) {
  return VectorXd::NullaryExpr(n, [](Eigen::Index i) { return i % 6 < 3 ? size : 1.0; });
}

MatrixXd rigid_motions(const ElasticModel& model) {
  MatrixXd rigid(6 * model.interfaces(), 6);
  for (int a = 0; a < model.interfaces(); ++a) {
    rigid.middleRows<6>(6 * a).setIdentity();
    rigid.block<3, 3>(6 * a, 3) = -hat(model.origins[static_cast<std::size_t>(a)]);
  }
  return rigid;
}

// A symmetric tensor: one number for each set of indices.
std::vector<double> symmetric_tensor(Random& random, int m, int order, double scale) {
  int all = 1;
  for (int k = 0; k < order; ++k) all *= m;
  std::vector<double> T;
  for (int index = 0; index < all; ++index) {
    std::vector<int> digits;
    for (int rest = index, k = 0; k < order; ++k, rest /= m) digits.push_back(rest % m);
    std::sort(digits.begin(), digits.end());
    int sorted = 0;  // the smallest of all places of the same number
    for (const int d : digits) sorted = sorted * m + d;
    T.push_back(sorted == index ? scale * random() : T[static_cast<std::size_t>(sorted)]);
  }
  return T;
}

// A body of random numbers: K without energy in rigid motions.
ElasticModel random_model(unsigned seed, int N, ElasticDegree degree) {
  Random random(seed);
  ElasticModel model;
  for (int a = 0; a < N; ++a) model.origins.push_back(random.vector<3>(size));
  const int n = 6 * N;
  const VectorXd back = units(n).cwiseInverse();
  const auto positive = [&] {
    const MatrixXd A = any(random, n, n);
    return MatrixXd(back.asDiagonal() * (A * A.transpose() + MatrixXd::Identity(n, n)) *
                    back.asDiagonal());
  };
  const MatrixXd rigid = rigid_motions(model),
                 P = MatrixXd::Identity(n, n) -
                     rigid * Lu(MatrixXd(rigid.transpose() * rigid)).solve(rigid.transpose());
  model.stiffness = P.transpose() * positive() * P;
  model.stiffness = (0.5 * (model.stiffness + model.stiffness.transpose())).eval();
  model.mass = positive();
  model.moments = any(random, 3, n) * back.asDiagonal() * size;
  model.total_mass = 0.7;
  model.mass_moment = random.vector<3>(size);
  if (degree == ElasticDegree::linear) return model;
  const MatrixXd Z = MatrixXd::Identity(6, 6).replicate(1, N) / N;
  const SymmetricEigen eigen(MatrixXd(Z.transpose() * Z));
  const int m = n - 6;
  model.basis = eigen.eigenvectors().leftCols(m);  // ascending: the first ones are zero
  model.cubic = symmetric_tensor(random, m, 3, 30);
  model.quartic = symmetric_tensor(random, m, 4, 300);
  return model;
}

using Poses = std::vector<FramePose>;

// Interfaces displaced and turned against each other, the whole turned at random.
Poses deformed(const ElasticModel& model, Random& random, double stretch, double bend) {
  const Matrix3d R = rotation_exp(random.vector<3>(1.8));
  const Vector3d p = random.vector<3>(1.0);
  Poses poses;
  for (const Vector3d& X : model.origins)
    poses.push_back(
        {p + R * (X + random.vector<3>(stretch * size)), R * rotation_exp(random.vector<3>(bend))});
  return poses;
}

Poses moved(const Poses& from, const VectorXd& y) {
  Poses poses = from;
  for (std::size_t a = 0; a < poses.size(); ++a) {
    const auto k = 6 * static_cast<Eigen::Index>(a);
    poses[a].position += y.segment<3>(k);
    poses[a].axes = rotation_exp(y.segment<3>(k + 3)) * poses[a].axes;
  }
  return poses;
}

using Action = BodyActionOf<double>;
using Answers = FloatingAnswersOf<double>;
const Action weight{.gravity = {1.5, -9.0, 3.0}, .growth = 1.003};

Answers answers(const ElasticModel& model, const Poses& poses, const Action& action = {}) {
  Answers a;
  evaluate_floating<double>(model, poses, action, a);
  REQUIRE(a.framed);
  return a;
}

VectorXd turned(const Matrix3d& R, VectorXd v) {
  for (Eigen::Index i = 0; i < v.size(); i += 3) v.segment<3>(i) = (R * v.segment<3>(i)).eval();
  return v;
}
MatrixXd turned_both(const Matrix3d& R, MatrixXd A) {
  for (Eigen::Index j = 0; j < A.cols(); ++j) A.col(j) = turned(R, A.col(j));
  for (Eigen::Index i = 0; i < A.rows(); ++i)
    A.row(i) = turned(R, A.row(i).transpose()).transpose();
  return A;
}
MatrixXd scaled(const MatrixXd& A) {
  return units(A.rows()).asDiagonal() * A *
         (A.cols() == A.rows() ? units(A.cols()) : VectorXd::Ones(A.cols())).asDiagonal();
}

std::vector<double> listed(const MatrixXd& A) { return {A.data(), A.data() + A.size()}; }
std::vector<double> listed(const Answers& a) {
  std::vector<double> all = listed(scaled(a.tangent));
  for (const MatrixXd& part : {MatrixXd(a.local.cwiseQuotient(units(a.local.size()))),
                               scaled(a.force), MatrixXd(a.frame.position), MatrixXd(a.frame.axes),
                               MatrixXd(MatrixXd::Constant(1, 1, a.energy))})
    for (const double x : listed(part)) all.push_back(x);
  return all;
}

// Largest deviation from differences, beside what these are known to, over the largest entry.
double deviation(const std::vector<double>& exact, const Derivatives& d) {
  double worst = 0, largest = 0;
  for (const double x : exact) largest = std::max(largest, std::abs(x));
  for (std::size_t i = 0; i < exact.size(); ++i)
    worst = std::max(worst, std::abs(exact[i] - d.value[i]) - 5 * d.error[i]);
  return worst / largest;
}

struct Body {
  int interfaces;
  ElasticDegree degree;
  ElasticModel model() const {
    return random_model(40u + static_cast<unsigned>(interfaces), interfaces, degree);
  }
};
const std::vector<Body> bodies{{2, ElasticDegree::linear},
                               {3, ElasticDegree::linear},
                               {5, ElasticDegree::linear},
                               {2, ElasticDegree::quartic},
                               {3, ElasticDegree::quartic}};

}  // namespace

TEST_CASE("a floating body does not notice rigid motions") {
  const Body body = GENERATE(from_range(bodies));
  const ElasticModel model = body.model();
  Random random(3);
  const Poses here = deformed(model, random, 0.2, 0.6);
  const Answers a = answers(model, here, weight);
  const MatrixXd K = scaled(a.tangent);
  for (int k = 0; k < 50; ++k) {
    const Matrix3d R = rotation_exp(random.vector<3>(1.8));
    const Vector3d p = random.vector<3>(0.5);
    Poses there;
    for (const FramePose& i : here)
      there.push_back({p + R * i.position, orthonormalised(R * i.axes)});
    const Answers b =
        answers(model, there, {.gravity = R * weight.gravity, .growth = weight.growth});
    CHECK(scaled(MatrixXd(b.local - a.local)).norm() < 1e-12);
    CHECK(scaled(MatrixXd(turned(R.transpose(), b.force) - a.force)).norm() <
          1e-12 * scaled(a.force).norm());
    CHECK((scaled(turned_both(R.transpose(), b.tangent)) - K).norm() < 1e-12 * K.norm());
    const double lowered = model.total_mass * weight.gravity.dot(R.transpose() * p);
    CHECK(b.energy + lowered == Approx(a.energy).epsilon(1e-12));
  }
}

TEST_CASE("force and tangent of a floating body are the derivatives of its energy") {
  const Body body = GENERATE(from_range(bodies));
  const Action action = GENERATE(Action{}, weight);
  const ElasticModel model = body.model();
  const int n = 6 * body.interfaces;
  Random random(7);
  for (int state = 0; state < 2; ++state) {
    const Poses here = deformed(model, random, 0.3, 0.58);  // turned by up to 1 rad
    const Answers a = answers(model, here, action);
    CHECK((a.tangent - a.tangent.transpose()).norm() == 0);
    for (int k = 0; k < 3; ++k) {
      VectorXd y = any(random, n, 1);
      y = units(n).asDiagonal() * y;
      const auto along = [&](double s) { return answers(model, moved(here, s * y), action); };
      const Derivatives energy =
          ridders([&](double s) { return std::vector{along(s).energy}; }, 0, 0.1);
      CHECK(std::abs(a.force.dot(y) - energy.value[0]) <
            5 * energy.error[0] + 1e-11 * scaled(a.force).norm());
      // moments of spins: their derivative is K − ½ hat(m)
      VectorXd change = a.tangent * y;
      for (int i = 3; i < n; i += 6)
        change.segment<3>(i) -= 0.5 * a.force.segment<3>(i).cross(y.segment<3>(i));
      const Derivatives force =
          ridders([&](double s) { return listed(scaled(along(s).force)); }, 0, 0.1);
      CHECK(deviation(listed(scaled(change)), force) < 1e-10);
    }
  }
}

TEST_CASE("the forces that hold a floating body balance in its deformed place, with its weight") {
  const Body body = GENERATE(from_range(bodies));
  const ElasticModel model = body.model();
  Random random(11);
  const Poses here = deformed(model, random, 0.3, 0.58);
  for (const Action& action : {Action{}, weight}) {
    const Answers a = answers(model, here, action);
    const Matrix3d& F = a.frame.axes;
    const Vector3d down = F.transpose() * action.gravity,
                   arm = action.growth * model.mass_moment + model.moments * a.local;
    Vector3d sum = model.total_mass * action.gravity, moment = F * arm.cross(down);
    for (std::size_t k = 0; k < here.size(); ++k) {
      const auto i = 6 * static_cast<Eigen::Index>(k);
      sum += a.force.segment<3>(i);
      moment += (here[k].position - a.frame.position).cross(a.force.segment<3>(i)) +
                a.force.segment<3>(i + 3);
    }
    CHECK(sum.norm() * size < 1e-13 * scaled(a.force).norm());
    CHECK(moment.norm() < 1e-13 * scaled(a.force).norm());
    // the mean of displacements and of turns vanishes in the frame
    Vector6d mean = Vector6d::Zero();
    for (int k = 0; k < body.interfaces; ++k) mean += a.local.segment<6>(6 * k);
    CHECK(mean.norm() < 1e-14);
  }
}

TEST_CASE("a floating body that is moved rigidly, or has grown evenly, is free of force") {
  const Body body = GENERATE(from_range(bodies));
  const ElasticModel model = body.model();
  Random random(13);
  const double growth = 1.002;
  const Matrix3d R = rotation_exp(random.vector<3>(1.8));
  const Vector3d p = random.vector<3>(0.5);
  Poses there;
  for (const Vector3d& X : model.origins) there.push_back({p + growth * (R * X), R});
  const Answers a = answers(model, there, {.growth = growth});
  const double stiffness = scaled(model.stiffness).norm();
  CHECK(std::abs(a.energy) < 1e-26 * stiffness);
  CHECK(scaled(a.force).norm() < 1e-13 * stiffness);
  const VectorXd eigenvalues = SymmetricEigen(scaled(a.tangent)).eigenvalues();
  for (Eigen::Index k = 0; k < 6; ++k)
    CHECK(std::abs(eigenvalues[k]) < 1e-12 * eigenvalues.tail<1>()[0]);
  CHECK(eigenvalues[6] > 1e-4 * eigenvalues.tail<1>()[0]);
  CHECK((a.frame.axes - R).norm() < 1e-13);
  CHECK((a.frame.position - p).norm() < 1e-13);
  // its mass: translations carry no more than they should, turned with the frame
  const MatrixXd M = floating_mass<double>(model, R);
  CHECK((scaled(turned_both(R.transpose(), M)) - scaled(model.mass)).norm() <
        1e-13 * scaled(model.mass).norm());
}

TEST_CASE("jets of a floating body are its series along a path, and so are jets of its rates") {
  const Body body = GENERATE(from_range(bodies));
  const ElasticModel model = body.model();
  const int N = body.interfaces, n = 6 * N;
  Random random(17);
  const Poses here = GENERATE(0, 1) == 1 ? deformed(model, random, 0.2, 0.5) : [&] {
    Poses rest;
    for (const Vector3d& X : model.origins) rest.push_back({X, Matrix3d::Identity()});
    return rest;
  }();
  const VectorXd y1 = any(random, n, 1), y2 = any(random, n, 1);
  const VectorXd unit = units(n);
  const auto at = [&](double s) {
    return VectorXd(unit.asDiagonal() * (0.3 * s * y1 + 0.2 * s * s * y2));
  };
  std::vector<FramePoseOf<Jet>> path(here.size());
  for (std::size_t a = 0; a < path.size(); ++a) {
    Vector3<Jet> theta;
    for (int i = 0; i < 3; ++i) {
      const auto k = 6 * static_cast<Eigen::Index>(a) + i;
      path[a].position[i] = {here[a].position[i], 0.3 * size * y1[k], 0.2 * size * y2[k]};
      theta[i] = {0, 0.3 * y1[k + 3], 0.2 * y2[k + 3]};
    }
    path[a].axes = jet_rotation_exp(theta) * here[a].axes;
  }
  const BodyActionOf<Jet> action{weight.gravity.cast<Jet>(), weight.growth};
  FloatingAnswersOf<Jet> series;
  evaluate_floating<Jet>(model, path, action, series);
  REQUIRE(series.framed);
  const auto of_order = [](const FloatingAnswersOf<Jet>& x, int o) {
    const auto part = [&](const Jet& v) { return v.c[o]; };
    Answers r{.framed = true};
    r.frame = {x.frame.position.unaryExpr(part), x.frame.axes.unaryExpr(part)};
    r.local = x.local.unaryExpr(part);
    r.energy = x.energy.c[o];
    r.force = x.force.unaryExpr(part);
    r.tangent = x.tangent.unaryExpr(part);
    return r;
  };
  const auto along = [&](double s) { return answers(model, moved(here, at(s)), weight); };
  const std::vector<double> now = listed(along(0)), zero = listed(of_order(series, 0));
  double largest = 0;
  for (const double x : now) largest = std::max(largest, std::abs(x));
  for (std::size_t i = 0; i < now.size(); ++i) CHECK(std::abs(now[i] - zero[i]) < 1e-13 * largest);
  CHECK(deviation(listed(of_order(series, 1)),
                  ridders([&](double s) { return listed(along(s)); }, 0, 0.2)) < 1e-10);
  // second order: what is left beside the first, over s, along ± s
  const auto second = [&](double s) {
    std::vector<double> r = listed(along(s));
    const std::vector<double> left = listed(along(-s));
    for (std::size_t i = 0; i < r.size(); ++i) r[i] = (r[i] + left[i] - 2 * now[i]) / (2 * s * s);
    return r;
  };
  const std::vector<double> far = second(0.02), near = second(0.01),
                            exact = listed(of_order(series, 2));
  double size_of_second = 0;
  for (const double x : exact) size_of_second = std::max(size_of_second, std::abs(x));
  for (std::size_t i = 0; i < far.size(); ++i)
    CHECK(std::abs((4 * near[i] - far[i]) / 3 - exact[i]) < 1e-5 * size_of_second);

  // rates along the path's own first derivative are its first order; those of jets go one further
  ElasticModel nothing = model;
  for (Vector3d& X : nothing.origins) X.setZero();
  nothing.stiffness.setZero();
  nothing.moments.setZero();
  nothing.total_mass = 0;
  nothing.mass_moment.setZero();
  std::fill(nothing.cubic.begin(), nothing.cubic.end(), 0);
  std::fill(nothing.quartic.begin(), nothing.quartic.end(), 0);
  auto slopes = path;
  const auto differentiated = [](const Jet& x) { return Jet(x.c[1], 2 * x.c[2], 0); };
  for (std::size_t a = 0; a < path.size(); ++a)
    slopes[a] = {path[a].position.unaryExpr(differentiated),
                 path[a].axes.unaryExpr(differentiated)};
  const auto rates = floating_rates<Jet>(model, nothing, path, slopes, action);
  REQUIRE(rates.framed);
  for (int o = 0; o < 2; ++o) {
    const std::vector<double> r = listed(of_order(rates, o)), c = listed(of_order(series, o + 1));
    double scale = 0;
    for (const double x : c) scale = std::max(scale, std::abs(x));
    for (std::size_t i = 0; i < r.size(); ++i)
      CHECK(std::abs(r[i] - (o + 1) * c[i]) < 1e-12 * scale);
  }
}

TEST_CASE("rates of a floating body along a change of the body and its places") {
  const Body body = GENERATE(from_range(bodies));
  const ElasticModel model = body.model(), other = random_model(90, body.interfaces, body.degree);
  const int n = 6 * body.interfaces;
  ElasticModel rate = other;
  rate.basis = model.basis;
  Random random(19);
  const Poses here = deformed(model, random, 0.2, 0.5);
  const VectorXd y = units(n).asDiagonal() * any(random, n, 1);
  Poses slopes(here.size());
  for (std::size_t a = 0; a < here.size(); ++a) {
    const auto k = 6 * static_cast<Eigen::Index>(a);
    slopes[a] = {y.segment<3>(k), hat(Vector3d(y.segment<3>(k + 3))) * here[a].axes};
  }
  const Answers rates = floating_rates<double>(model, rate, here, slopes, weight);
  REQUIRE(rates.framed);
  const auto at = [&](double s) {
    ElasticModel m = model;
    for (std::size_t a = 0; a < m.origins.size(); ++a) m.origins[a] += s * rate.origins[a];
    m.stiffness += s * rate.stiffness;
    m.moments += s * rate.moments;
    m.total_mass += s * rate.total_mass;
    m.mass_moment += s * rate.mass_moment;
    for (std::size_t i = 0; i < m.cubic.size(); ++i) m.cubic[i] += s * rate.cubic[i];
    for (std::size_t i = 0; i < m.quartic.size(); ++i) m.quartic[i] += s * rate.quartic[i];
    return listed(answers(m, moved(here, s * y), weight));
  };
  CHECK(deviation(listed(rates), ridders(at, 0, 0.1)) < 1e-10);
}

TEST_CASE("places that are not finite have no floating frame") {
  const ElasticModel model = random_model(5, 3, ElasticDegree::linear);
  Random random(5);
  Poses poses = deformed(model, random, 0.1, 0.1);
  poses[1].position[0] = std::numeric_limits<double>::infinity();
  Answers a;
  evaluate_floating<double>(model, poses, {}, a);
  CHECK_FALSE(a.framed);
}
