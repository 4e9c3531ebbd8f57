#include "core/reduction/tube/tube_potential.hpp"

#include <catch2/catch.hpp>

#include "support/synthetic_leaf.hpp"

using namespace flexopt;
using namespace flexopt::synthetic;

namespace {

double distance(const PotentialValue& a, const PotentialValue& b) {
  return std::max({std::abs(a.value - b.value), (a.gradient - b.gradient).cwiseAbs().maxCoeff(),
                   (a.hessian - b.hessian).cwiseAbs().maxCoeff()});
}

/// s on the ray and off it.
Vector3d soft(const Eigen::Matrix2d& D, double sigma, double tau, double phi) {
  Vector3d s;
  s << D * Eigen::Vector2d(sigma, tau), phi;
  return s;
}

/// A random polynomial of total degree ≤ DEGREE in (σ, τ, φ, N, M1, M2) with both mirror
/// symmetries, or with that in the width alone, and at most DEGREE − 1 transverse powers; and its
/// Taylor coefficients anywhere.
template <int DEGREE>
struct RandomPotential {
  Polynomial<6, DEGREE> p = Polynomial<6, DEGREE>::constant(0);

  explicit RandomPotential(Random& random, bool mirrored = true) {
    for (int i = 0; i < p.size; ++i) {
      const auto e = p.table().exponents(i);
      const bool thickness = !mirrored || (e[0] + e[1] + e[2]) % 2 == 0,
                 width = (e[2] + e[4] + e[5]) % 2 == 0;
      if (thickness && width && p.table().degree(i) - e[0] < DEGREE) p[i] = random();
    }
  }
  TubeNode node(double sigma) const {
    using P = Polynomial<6, DEGREE>;
    std::vector<P> power{P::constant(1)};
    const P shifted = P::variable(0, sigma, 1);
    for (int k = 1; k <= DEGREE; ++k) power.push_back(power.back() * shifted);
    P sum = P::constant(0);
    for (int i = 0; i < P::size; ++i) {
      const auto e = P::table().exponents(i);
      P rest = P::constant(0);
      const std::array<int, 6> r{0, e[1], e[2], e[3], e[4], e[5]};
      rest[P::table().index(r)] = p[i];
      sum += rest * power[e[0]];
    }
    return {sigma, {sum.c.begin(), sum.c.end()}};
  }
  /// Value, gradient, Hessian in (σ, τ, φ, N, M1, M2).
  PotentialValue operator()(const Vector6d& x) const {
    PotentialValue v;
    v.gradient.setZero();
    v.hessian.setZero();
    for (int i = 0; i < p.size; ++i) {
      const auto e = p.table().exponents(i);
      const auto term = [&](int a, int b) {  // derivative by x_a and x_b; -1: none
        double t = p[i];
        for (int k = 0; k < 6; ++k) {
          int n = e[k];
          for (int d : {a, b})
            if (d == k) t *= n--;
          if (t == 0) return 0.0;
          t *= std::pow(x[k], n);
        }
        return t;
      };
      v.value += term(-1, -1);
      for (int a = 0; a < 6; ++a) {
        v.gradient[a] += term(a, -1);
        for (int b = 0; b < 6; ++b) v.hessian(a, b) += term(a, b);
      }
    }
    return v;
  }
};

template <int DEGREE>
void check_random_polynomial(unsigned seed, bool mirrored = true) {
  Random random(seed);
  const RandomPotential<DEGREE> exact(random, mirrored);
  const Eigen::Matrix2d D = skew_ray();
  TubePotential tube(D, Vector3d(2, 3, 4), DEGREE,
                     {exact.node(0), exact.node(0.4), exact.node(1.1)}, Vector3d::Zero(), mirrored);
  if (!mirrored) {
    tube.add_node(exact.node(-0.9));
    tube.add_node(exact.node(-0.3));
    REQUIRE(tube.nodes().front().sigma == -0.9);
    CHECK(tube.locate(soft(D, -1, 0, 0)).beyond == Approx(0.1));
    CHECK(tube.locate(soft(D, -0.5, 0, 0)).interval == 0);
    CHECK(tube.locate(soft(D, 1, 0, 0)).beyond == Approx(-0.1));
  }
  Matrix6d A = Matrix6d::Identity();  // d(σ, τ, φ, f)/d(θ1y, θ2y, φ, f)
  A.topLeftCorner<2, 2>() = D.inverse();
  for (int n = 0; n < 200; ++n) {
    const Vector6d x = random.vector<6>();
    PotentialValue v = exact(x);
    v.gradient = A.transpose() * v.gradient.eval();
    v.hessian = A.transpose() * v.hessian.eval() * A;
    const PotentialValue t = tube.evaluate(soft(D, x[0], x[1], x[2]), x.tail<3>());
    REQUIRE(v.hessian.norm() > 1e-3);
    CHECK(distance(t, v) < 1e-11 * (1 + v.hessian.norm()));
    CHECK(t.hessian == t.hessian.transpose());
  }
}

}  // namespace

TEST_CASE("a polynomial of the degree of the tube is reproduced everywhere", "[slow]") {
  check_random_polynomial<3>(1);
  check_random_polynomial<4>(2);
  check_random_polynomial<5>(3);
  check_random_polynomial<6>(4);
  check_random_polynomial<7>(5);
}

TEST_CASE("without mirror symmetry in the thickness nodes stand on both sides") {
  check_random_polynomial<5>(11, false);
  check_random_polynomial<4>(12, false);
}

TEST_CASE("node states are reproduced exactly") {
  Random random(6);
  for (const Eigen::Matrix2d& D : {s_ray(), c_ray(), skew_ray()}) {
    const std::vector<double> sigmas{0, 0.03, 0.1, 0.3};
    const TubePotential t = tube(D, sigmas);
    for (double sigma : sigmas)
      for (double sign : {1.0, -1.0}) {
        const Vector3d s = soft(D, sign * sigma, 0, 0);
        const PotentialValue v = exact(s, Vector3d::Zero());
        CHECK(distance(t.evaluate(s, Vector3d::Zero()), v) < 1e-10);
        // beside the ray the error is that of the Taylor polynomial: Hessian to degree d − 1 − 2
        const double tau = random(), phi = random();
        const Vector3d f = random.vector<3>();
        const auto error = [&](double h) {
          const Vector3d beside = soft(D, sign * sigma, h * tau, h * phi);
          return (t.evaluate(beside, h * f).hessian - exact(beside, h * f).hessian).norm();
        };
        CHECK(rate(error(0.3), error(0.03)) > 2.8);
      }
  }
}

TEST_CASE("the gradient is that of the value, the Hessian that of the gradient") {
  Random random(7);
  const TubePotential t = tube(skew_ray());
  for (int n = 0; n < 20; ++n) {
    const Vector3d s = soft(skew_ray(), random(0.3), random(0.1), random(0.1));
    const Vector3d f = random.vector<3>();
    const PotentialValue p = t.evaluate(s, f);
    const Vector6d d = random.vector<6>();
    const auto at = [&](double h) { return t.evaluate(s + h * d.head<3>(), f + h * d.tail<3>()); };
    const auto first = [&](double h) {
      return std::abs(at(h).value - p.value - h * p.gradient.dot(d));
    };
    const auto second = [&](double h) {
      return (at(h).gradient - p.gradient - h * p.hessian * d).norm();
    };
    REQUIRE(p.gradient.norm() > 1e-3);
    CHECK(rate(first(1e-3), first(1e-4)) == Approx(2).margin(0.1));
    CHECK(rate(second(1e-3), second(1e-4)) == Approx(2).margin(0.1));
  }
}

TEST_CASE("coefficients of the monomials m are C^(d - |m|) across nodes") {
  // So value and gradient are continuous; the Hessian jumps with the fourth power of the distance
  // from the ray (c_m'' of |m| = 4), its change along the ray with the third. The nodes are far
  // apart, so that the interpolation error is anything but small.
  const Eigen::Matrix2d D = s_ray();
  const TubePotential t = tube(D, {0, 0.5, 1.2});
  const auto at = [&](double sigma, double h) {
    return t.evaluate(soft(D, sigma, 0.05 * h, 0.1 * h), h * Vector3d(0.3, -0.2, 0.4));
  };
  for (double node : {0.5, -0.5}) {
    const double above = std::nextafter(node, 9), below = std::nextafter(node, -9);
    const auto jump = [&](double h) {
      return (at(above, h).hessian - at(below, h).hessian).norm();
    };
    CHECK(std::abs(at(above, 1).value - at(below, 1).value) < 1e-12);
    CHECK((at(above, 1).gradient - at(below, 1).gradient).norm() < 1e-11);
    REQUIRE(jump(1) > 1e-3);
    CHECK(rate(jump(1), jump(0.1)) == Approx(4).margin(0.1));
    CHECK(jump(0) < 1e-10);

    const double d = 1e-4;  // one-sided differences, second order
    const auto change = [&](double h, double start, double to) {
      return Matrix6d((-3 * at(start, h).hessian + 4 * at(node + to, h).hessian -
                       at(node + 2 * to, h).hessian) /
                      (2 * to));
    };
    REQUIRE(change(0, above, d).norm() > 0.1);
    CHECK((change(0, above, d) - change(0, below, -d)).norm() < 1e-4 * change(0, above, d).norm());
  }
}

TEST_CASE("between nodes the error falls at least with the order of the Hermite data") {
  // On the ray: the value has 6 + 6 data (order 12), the moment by its derivative 11, the stiffness
  // against twist |m| = 2, so 4 + 4 data (order 8).
  const Eigen::Matrix2d D = c_ray();
  const auto error = [&](double h) {
    const TubePotential t = tube(D, {0, 0.2, 0.2 + h});
    Vector3d worst = Vector3d::Zero();
    for (double u : {0.3, 0.5, 0.7}) {
      const Vector3d s = soft(D, 0.2 + u * h, 0, 0);
      const PotentialValue p = t.evaluate(s, Vector3d::Zero()), v = exact(s, Vector3d::Zero());
      worst = worst.cwiseMax(Vector3d(std::abs(p.value - v.value),
                                      std::abs(p.gradient[0] - v.gradient[0]),
                                      std::abs(p.hessian(2, 2) - v.hessian(2, 2))));
    }
    return worst;
  };
  const Vector3d coarse = error(0.5), fine = error(0.25);
  CAPTURE(coarse, fine);
  REQUIRE(fine.minCoeff() > 1e-12);  // above rounding
  CHECK(std::log2(coarse[0] / fine[0]) > 11.5);
  CHECK(std::log2(coarse[1] / fine[1]) > 10.5);
  CHECK(std::log2(coarse[2] / fine[2]) > 7.5);
}

TEST_CASE("a node added later gives the tube that was built with it") {
  const Eigen::Matrix2d D = skew_ray();
  const TubePotential whole = tube(D, {0, 0.05, 0.1, 0.2, 0.3});
  TubePotential grown = tube(D, {0, 0.1, 0.2});
  CHECK(grown.locate(soft(D, 0.25, 0, 0)).beyond == Approx(0.05));
  CHECK(grown.locate(soft(D, -0.25, 0, 0)).beyond == Approx(0.05));
  grown.add_node(node<5>(D, 0.3));
  CHECK(grown.locate(soft(D, -0.25, 0, 0)).beyond == Approx(-0.05));
  grown.add_node(node<5>(D, 0.05));
  REQUIRE(grown.nodes().size() == 5);
  Random random(8);
  for (int n = 0; n < 50; ++n) {
    const Vector3d s = soft(D, random(0.3), random(0.1), random(0.1)), f = random.vector<3>();
    CHECK(distance(grown.evaluate(s, f), whole.evaluate(s, f)) == 0);
  }
}

TEST_CASE("both mirror symmetries hold to the last digit") {
  const TubePotential t = tube(skew_ray());
  Random random(9);
  for (int n = 0; n < 50; ++n) {
    const Vector3d s = soft(skew_ray(), random(0.3), random(0.1), random(0.1)),
                   f = random.vector<3>();
    const PotentialValue p = t.evaluate(s, f);
    Vector6d thickness, width;
    thickness << -1, -1, -1, 1, 1, 1;
    width << 1, 1, -1, 1, -1, -1;
    const PotentialValue a = t.evaluate(-s, f);
    const PotentialValue b = t.evaluate(Vector3d(s[0], s[1], -s[2]), Vector3d(f[0], -f[1], -f[2]));
    for (const auto& [q, mirror] : {std::pair(a, thickness), std::pair(b, width)}) {
      CHECK(q.value == p.value);
      CHECK(q.gradient == mirror.cwiseProduct(p.gradient));
      CHECK(q.hessian == mirror.asDiagonal() * p.hessian * mirror.asDiagonal());
    }
  }
}

TEST_CASE("the location tells ray, side and interval") {
  const Eigen::Matrix2d D = skew_ray();
  const TubePotential t = tube(D, {0, 0.1, 0.3});
  const TubeLocation a = t.locate(soft(D, -0.2, 0.03, 0.01));
  CHECK(a.sigma == Approx(-0.2));
  CHECK(a.tau == Approx(0.03));
  CHECK(a.beyond == Approx(-0.1));
  CHECK(a.interval == 1);
  CHECK(t.locate(soft(D, 0.05, 0, 0)).interval == 0);
  CHECK(t.locate(soft(D, 0.5, 0, 0)).interval == 1);
}

TEST_CASE("a force centre shifts the expansion") {
  // nodes about N0: Taylor coefficients of the same function about another force
  const Eigen::Matrix2d D = s_ray();
  const Vector3d centre(1.5, 0, 0);
  std::vector<TubeNode> nodes;
  for (double sigma : {0.0, 0.1, 0.3}) {
    const auto p = taylor<5>(D, sigma, 0, 0, centre);
    nodes.push_back({sigma, {p.c.begin(), p.c.end()}});
  }
  const TubePotential t(D, force_scale, 5, nodes, centre);
  for (double sigma : {0.1, -0.3, 0.2}) {
    const Vector3d s = soft(D, sigma, 0, 0);
    const double tolerance = sigma == 0.2 ? 1e-5 : 1e-10;  // between nodes, at a node
    CHECK(distance(t.evaluate(s, centre), exact(s, centre)) < tolerance);
    const Vector3d f = centre + Vector3d(0.05, 0.04, -0.05);
    CHECK(distance(t.evaluate(s, f), exact(s, f)) < 1e-5);
  }
}
