#include "core/reduction/superelement/modal_derivatives.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/elements/leaf/chord_edges.hpp"
#include "core/math/rotation.hpp"
#include "support/slopes.hpp"

using namespace flexopt;

namespace {

std::shared_ptr<const PlateMesh> beam(int elements, double width, double thickness) {
  return std::make_shared<PlateMesh>(PlateShape{
      .width = width, .thickness = thickness, .mesh = {elements, 1}, .flexure = Flexure::beam});
}

std::shared_ptr<const PlateMesh> plate() {
  return std::make_shared<PlateMesh>(PlateShape{.width = 0.4, .thickness = 0.01, .mesh = {4, 2}});
}

PlateLeaf assembled(std::shared_ptr<const PlateMesh> mesh, PlateSupport support = {}) {
  PlateLeaf leaf(std::move(mesh), std::move(support));
  leaf.assemble();
  return leaf;
}

/// The state at x0 + s φ.
PlateLeaf::State moved(const PlateLeaf::State& from, const VectorXd& shape, double s) {
  PlateLeaf::State state = from;
  const Eigen::Index n = from.x.size();
  state.x += s * shape.head(n);
  for (int e = 0; e < 2; ++e) {
    state.edges[e].position += s * shape.segment<3>(n + 6 * e);
    state.edges[e].axes = rotation_exp(s * shape.segment<3>(n + 6 * e + 3)) * from.edges[e].axes;
  }
  return state;
}

/// The tangent over (unknowns, edges), dense.
MatrixXd whole_tangent(PlateLeaf& leaf) {
  const int n = leaf.unknowns();
  leaf.linearise();
  MatrixXd K(n + 12, n + 12);
  K.topLeftCorner(n, n) = leaf.tangent_times(MatrixXd::Identity(n, n));
  K.topRightCorner(n, 12) = leaf.coupling();
  K.bottomLeftCorner(12, n) = leaf.coupling().transpose();
  K.bottomRightCorner<12, 12>() = leaf.edge_tangent();
  return K;
}

/// Brought to equilibrium between the edges of e.
void relax(PlateLeaf& leaf, const Vector6d& e) {
  PlateLeaf::State state = leaf.state();
  state.edges = chord_edges(e);
  leaf.set_state(state);
  for (int k = 0; k < 30; ++k) {
    leaf.assemble();
    if (leaf.correction() < 1e-14) break;
    state.x += leaf.internal_step(Vector12d::Zero());
    leaf.set_state(state);
  }
  REQUIRE(leaf.correction() < 1e-11);
}

}  // namespace

TEST_CASE("second-order forces are the derivative of the tangent, symmetric in all three shapes") {
  for (const auto& mesh : {beam(4, 0.3, 0.01), plate()}) {
    PlateLeaf leaf = assembled(mesh);
    const int n = leaf.unknowns();
    const MatrixXd Phi = boundary_modes(leaf);
    const std::vector<PlateLeaf::Mode> modes = leaf.modes(2);
    MatrixXd shapes = MatrixXd::Zero(n + 12, 14);
    shapes.leftCols(12) = Phi;
    for (int k = 0; k < 2; ++k) shapes.col(12 + k).head(n) = modes[k].shape;
    const MatrixXd K2 = second_order_forces(leaf, shapes);
    REQUIRE(K2.norm() > 1);
    const auto third = [&](int i, int j, int k) {
      return K2.col(pair_index(i, j)).dot(shapes.col(k));
    };
    const double largest = (shapes.transpose() * K2).cwiseAbs().maxCoeff();
    for (int i = 0; i < 14; ++i)
      for (int j = 0; j <= i; ++j)
        for (int k = 0; k <= j; ++k) {
          CHECK(std::abs(third(i, j, k) - third(k, i, j)) < 1e-11 * largest);
          CHECK(std::abs(third(i, j, k) - third(j, k, i)) < 1e-11 * largest);
        }
    // rows of the unknowns by differences of the tangent; the edges of φi must not turn, since the
    // tangent varies them about the moved state
    const PlateLeaf::State rest = leaf.state();
    const double h = 1e-4;
    for (const int i : {0, 2, 6, 12, 13})
      for (const int j : {2, 4, 5, 9, 12}) {
        leaf.set_state(moved(rest, shapes.col(j), h));
        const VectorXd plus = (whole_tangent(leaf) * shapes.col(i)).head(n);
        leaf.set_state(moved(rest, shapes.col(j), -h));
        const VectorXd minus = (whole_tangent(leaf) * shapes.col(i)).head(n);
        const VectorXd exact = K2.col(pair_index(i, j)).head(n);
        CHECK(((plus - minus) / (2 * h) - exact).norm() < 1e-6 * (exact.norm() + 1));
      }
  }
}

TEST_CASE("modal derivatives of the boundary modes are those of the static solution") {
  for (const auto& mesh : {beam(6, 0.3, 0.01), plate()}) {
    PlateLeaf leaf = assembled(mesh);
    const int n = leaf.unknowns();
    const MatrixXd shapes = boundary_modes(leaf) * chord_edge_map(Vector6d::Zero());
    const MatrixXd theta = derivatives_edges_held(leaf, second_order_forces(leaf, shapes));
    // dx/de at both sides of the undeflected state, well below buckling
    for (int j = 0; j < 6; ++j) {
      const double h = j == 1 || j == 3 || j == 5 ? 1e-4 : j == 0 ? 1e-6 : 1e-5;
      const auto rates = [&](double step) {
        PlateLeaf bent(mesh);
        const Vector6d e = step * Vector6d::Unit(j);
        relax(bent, e);
        MatrixXd X = -bent.coupling() * chord_edge_map(e);
        bent.solve(X);
        return X;
      };
      const MatrixXd difference = test::slope_at_zero(rates, h);
      for (int i = 0; i < 6; ++i) {
        const VectorXd exact = theta.col(pair_index(i, j));
        INFO("i " << i << ", j " << j << ", |theta| " << exact.norm());
        CHECK((difference.col(i) - exact).norm() < 1e-6 * (exact.norm() + 1));
      }
    }
    CHECK(theta.rows() == n);
  }
}

TEST_CASE("equation 8 of the paper adds boundary modes to derivatives with held edges") {
  const auto mesh = beam(10, 0.3, 5e-3);
  PlateLeaf leaf = assembled(mesh);
  const int n = leaf.unknowns();
  const MatrixXd Phi = boundary_modes(leaf);
  const MatrixXd K2 = second_order_forces(leaf, Phi);
  const MatrixXd held = derivatives_edges_held(leaf, K2), K = whole_tangent(leaf);
  MatrixXd own = MatrixXd::Zero(n + 12, 144);
  for (int i = 0; i < 12; ++i) {
    // the stiffness with all held but the interior and the own edge
    std::vector<int> free(n + 6);
    for (int k = 0; k < n; ++k) free[k] = k;
    for (int k = 0; k < 6; ++k) free[n + k] = n + 6 * (i / 6) + k;
    const Eigen::LDLT<MatrixXd> stiffness(K(free, free));
    for (int j = 0; j < 12; ++j) {
      VectorXd theta = VectorXd::Zero(n + 12);
      theta(free) = -stiffness.solve(K2.col(pair_index(i, j))(free));
      VectorXd sum = Phi * theta.tail<12>();
      sum.head(n) += held.col(pair_index(i, j));
      CHECK((theta - sum).norm() < 1e-6 * (theta.norm() + 1));
      own.col(12 * i + j) = theta;
    }
  }
  double asymmetry = 0;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < i; ++j)
      asymmetry = std::max(asymmetry, (own.col(12 * i + j) - own.col(12 * j + i)).norm());
  CHECK(asymmetry > 0.1);  // of pairs of two nodes
  // foreshortening of a tip that moves across by v, or turns by φ: −6/5 v²/L, −2/15 φ² L
  CHECK(own(n + 6, 12 * 8 + 8) == Approx(-6.0 / 5).epsilon(1e-3));
  CHECK(own(n + 6, 12 * 10 + 10) == Approx(-2.0 / 15).epsilon(1e-3));
}

TEST_CASE("the manifold has cubic coefficient and frequencies of von Kármán's beam") {
  const double width = 0.1, t = 2e-3;
  const auto mesh = beam(20, width, t);
  PlateLeaf leaf = assembled(mesh);
  const int n = leaf.unknowns();
  const std::vector<PlateLeaf::Mode> modes = leaf.modes(3, 1e-10);
  REQUIRE(std::sqrt(modes[0].omega2) == Approx(22.373285448).epsilon(1e-4));

  // reference E3: γ/ω² = 0.151183919232 A/I for ∫φ² = 1, along x = η φ + ½ η² θ
  MatrixXd first = MatrixXd::Zero(n + 12, 1);
  first.col(0).head(n) = modes[0].shape;
  const MatrixXd theta = derivatives_edges_held(leaf, second_order_forces(leaf, first));
  const double eta = 2 * t * std::sqrt(width);
  const auto energy = [&](double s) {
    PlateLeaf bent(mesh);
    PlateLeaf::State state = leaf.state();
    state.x += s * modes[0].shape + 0.5 * s * s * theta.col(0);
    bent.set_state(state);
    bent.linearise();
    return 0.5 * bent.energy();
  };
  // (energy is even in s: its second and fourth power from two places)
  const double u1 = energy(eta) + energy(-eta), u2 = energy(2 * eta) + energy(-2 * eta);
  const double quartic = (u2 - 4 * u1) / (12 * std::pow(eta, 4));
  const double gamma = 4 * quartic * width / modes[0].omega2;
  CHECK(gamma == Approx(0.151183919232 * 12 / (t * t)).epsilon(1e-3));

  // reference E1: dΩ²/dp at rest from the second-order force of an elongation, p = 12 u L/t²
  MatrixXd shapes(n + 12, 4);
  shapes.setZero();
  for (int k = 0; k < 3; ++k) shapes.col(k).head(n) = modes[k].shape;
  shapes.col(3) = boundary_modes(leaf) * chord_edge_map(Vector6d::Zero()).col(0);
  const MatrixXd K2 = second_order_forces(leaf, shapes);
  const double slopes[3] = {12.302618623, 46.050120144, 98.904801402};
  for (int k = 0; k < 3; ++k)
    CHECK(K2.col(pair_index(k, 3)).dot(shapes.col(k)) * t * t / 12 ==
          Approx(slopes[k]).epsilon(1e-3));
  // … and Ω itself at a tension p
  const struct {
    double p, omega[3];
  } cases[] = {{5, {23.704290434, 63.510162542, 122.93108551}},
               {20, {27.274227085, 68.707635596, 128.81768488}},
               {100, {40.993160999, 91.264311101, 156.39549268}},
               {-5, {20.948923386, 59.774850685, 118.8402653}},
               {-19.73920880218, {15.951287605, 53.762642907, 112.53422334}}};
  for (const auto& c : cases) {
    PlateLeaf tense(mesh);
    relax(tense, c.p * t * t / 12 * Vector6d::Unit(0));
    const std::vector<PlateLeaf::Mode> own = tense.modes(5, 1e-8);  // a torsional one among them
    for (int k = 0; k < 3; ++k) {
      double nearest = 0;
      for (const PlateLeaf::Mode& mode : own)
        if (std::abs(std::sqrt(mode.omega2) - c.omega[k]) < std::abs(nearest - c.omega[k]))
          nearest = std::sqrt(mode.omega2);
      CHECK(nearest == Approx(c.omega[k]).epsilon(1e-3));
    }
  }
}
