#include "core/reduction/modal/modal_derivatives.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/rotation.hpp"
#include "core/reduction/frame/chord_edges.hpp"

using namespace flexopt;

namespace {

std::shared_ptr<const PlateMesh> beam(int elements, double width, double thickness) {
  PlateShape shape;
  shape.width = width;
  shape.thickness = thickness;
  shape.mesh = {elements, 1};
  shape.flexure = Flexure::beam;
  return std::make_shared<PlateMesh>(shape);
}

std::shared_ptr<const PlateMesh> plate() {
  PlateShape shape;
  shape.width = 0.4;
  shape.thickness = 0.01;
  shape.mesh = {4, 2};
  return std::make_shared<PlateMesh>(shape);
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

TEST_CASE("second-order forces are the derivative of the tangent, symmetric in all three shapes",
          "[reduction][modal_derivatives]") {
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

TEST_CASE("modal derivatives of the boundary modes are those of the static solution",
          "[reduction][modal_derivatives]") {
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
      const MatrixXd difference =
          (8 * (rates(h) - rates(-h)) - (rates(2 * h) - rates(-2 * h))) / (12 * h);
      for (int i = 0; i < 6; ++i) {
        const VectorXd exact = theta.col(pair_index(i, j));
        INFO("i " << i << ", j " << j << ", |theta| " << exact.norm());
        CHECK((difference.col(i) - exact).norm() < 1e-6 * (exact.norm() + 1));
      }
    }
    CHECK(theta.rows() == n);
  }
}

TEST_CASE("both readings of the paper's equation 8 differ by boundary modes",
          "[reduction][modal_derivatives]") {
  const auto mesh = beam(10, 0.3, 5e-3);
  PlateLeaf leaf = assembled(mesh);
  const int n = leaf.unknowns();
  const MatrixXd Phi = boundary_modes(leaf);
  const MatrixXd K2 = second_order_forces(leaf, Phi);
  const MatrixXd held = derivatives_edges_held(leaf, K2), own = derivatives_own_edge_free(leaf, K2);
  const MatrixXd K = whole_tangent(leaf);
  double asymmetry = 0;
  for (int i = 0; i < 12; ++i) {
    // eq. 8 literally: the stiffness with all held but the interior and the own edge
    std::vector<int> free(n + 6);
    for (int k = 0; k < n; ++k) free[k] = k;
    for (int k = 0; k < 6; ++k) free[n + k] = n + 6 * (i / 6) + k;
    const Eigen::LDLT<MatrixXd> stiffness(K(free, free));
    for (int j = 0; j < 12; ++j) {
      VectorXd literal = VectorXd::Zero(n + 12);
      literal(free) = -stiffness.solve(K2.col(pair_index(i, j))(free));
      const VectorXd theta = own.col(12 * i + j);
      CHECK((literal - theta).norm() < 1e-6 * (theta.norm() + 1));
      // the identity: theta = theta_fix + Phi theta_b
      VectorXd sum = Phi * literal.tail<12>();
      sum.head(n) += held.col(pair_index(i, j));
      CHECK((literal - sum).norm() < 1e-6 * (theta.norm() + 1));
      asymmetry = std::max(asymmetry, (theta - own.col(12 * j + i)).norm());
    }
  }
  CHECK(asymmetry > 0.1);  // of pairs of two nodes
  // foreshortening of a tip that moves across by v, or turns by φ: −6/5 v²/L, −2/15 φ² L
  CHECK(own(n + 6, 12 * 8 + 8) == Approx(-6.0 / 5).epsilon(1e-3));
  CHECK(own(n + 6, 12 * 10 + 10) == Approx(-2.0 / 15).epsilon(1e-3));
}

TEST_CASE(
    "modal derivatives of a cantilever's modes have their closed form, and enter with one half",
    "[reduction][modal_derivatives]") {
  // shared reference E4: u_ij′ = −φi′ φj′, tip values −I_ij for ∫φ² = L
  const double width = 0.1, thickness = 2e-3;
  const auto mesh = beam(24, width, thickness);
  PlateLeaf leaf = assembled(mesh, {.free_tip = true, .point = {}});
  // out-of-plane bending: torsion and in-plane bending lie higher here
  const std::vector<PlateLeaf::Mode> modes = leaf.modes(2);
  REQUIRE(std::sqrt(modes[0].omega2) == Approx(3.5160152685).epsilon(1e-4));
  REQUIRE(std::sqrt(modes[1].omega2) == Approx(22.034491565).epsilon(1e-4));
  const MatrixXd theta = vibration_mode_derivatives(leaf, modes);
  const int tip = leaf.block_offset(mesh->lines() - 1);
  const int w_tip = tip + 2 * mesh->functions_per_line();  // of the component along the normal
  const double sign = modes[0].shape[w_tip] * modes[1].shape[w_tip] > 0 ? 1 : -1;
  // mass ρ t w L: shapes are 1/√w times those of the reference
  CHECK(theta(tip, 0) * width == Approx(-4.64777832).epsilon(1e-3));
  CHECK(std::abs(theta(tip, 1)) * width == Approx(7.37987527).epsilon(1e-3));
  CHECK(sign * theta(tip, 1) * sign == theta(tip, 1));
  CHECK(theta(tip, 1) == Approx(theta(tip, 2)).epsilon(1e-9));
  CHECK(theta(tip, 3) * width == Approx(-32.417399028).epsilon(1e-3));

  // The exact second-order slave field is ½ θ η²: with it the membrane stays almost unstrained.
  const VectorXd x0 = leaf.state().x;
  const double eta = 0.02 * std::sqrt(width);
  const auto stretch = [&](double factor) {
    PlateLeaf::State state = leaf.state();
    state.x = x0 + eta * modes[0].shape + factor * eta * eta * theta.col(0);
    PlateLeaf bent(mesh, {.free_tip = true, .point = {}});
    bent.set_state(state);
    bent.linearise();
    return bent.energy() / (0.5 * modes[0].omega2 * eta * eta) - 1;
  };
  CHECK(std::abs(stretch(0.5)) < 0.005);
  CHECK(stretch(1.0) > 10);
  CHECK(stretch(0.0) > 10);
}

TEST_CASE("with the inertia kept, modal derivatives are the differences of the modes",
          "[reduction][modal_derivatives]") {
  for (const bool free_tip : {false, true}) {
    const auto mesh = beam(6, 0.13, 0.01);
    const PlateSupport support{.free_tip = free_tip, .point = {}};
    PlateLeaf leaf = assembled(mesh, support);
    const int n = leaf.unknowns(), m = 4;
    const std::vector<PlateLeaf::Mode> modes = leaf.modes(m, 1e-11);
    const MatrixXd kept = vibration_mode_derivatives(leaf, modes, ModalInertia::kept),
                   left_out = vibration_mode_derivatives(leaf, modes);
    REQUIRE(kept.rows() == n);
    const double h = 2e-6;
    double inertia = 0;
    for (int j = 0; j < m; ++j) {
      const auto modes_at = [&](double step) {
        PlateLeaf moved_leaf(mesh, support);
        PlateLeaf::State state = leaf.state();
        state.x += step * modes[j].shape;
        moved_leaf.set_state(state);
        moved_leaf.assemble();
        MatrixXd shapes(n, m);
        const std::vector<PlateLeaf::Mode> own = moved_leaf.modes(m, 1e-11);
        for (int i = 0; i < m; ++i) {
          const double same = own[i].shape.dot(leaf.mass_times(modes[i].shape).col(0));
          shapes.col(i) = same < 0 ? VectorXd(-own[i].shape) : own[i].shape;
        }
        return shapes;
      };
      const MatrixXd difference =
          (8 * (modes_at(h) - modes_at(-h)) - (modes_at(2 * h) - modes_at(-2 * h))) / (12 * h);
      for (int i = 0; i < m; ++i) {
        const VectorXd theta = kept.col(m * i + j);
        INFO("i " << i << ", j " << j << ", |theta| " << theta.norm());
        CHECK((difference.col(i) - theta).norm() < 1e-6 * (theta.norm() + 1));
        CHECK(std::abs(theta.dot(leaf.mass_times(modes[i].shape).col(0))) <
              1e-9 * (theta.norm() + 1));
        inertia = std::max(inertia, (theta - left_out.col(m * i + j)).norm() / (theta.norm() + 1));
      }
    }
    CHECK(inertia > 1e-4);  // it is not nothing
  }
}

TEST_CASE(
    "the manifold has the cubic coefficient and the frequencies under tension of von Kármán's beam",
    "[reduction][modal_derivatives]") {
  const double width = 0.1, t = 2e-3;
  const auto mesh = beam(20, width, t);
  PlateLeaf leaf = assembled(mesh);
  const int n = leaf.unknowns();
  const std::vector<PlateLeaf::Mode> modes = leaf.modes(3, 1e-10);
  REQUIRE(std::sqrt(modes[0].omega2) == Approx(22.373285448).epsilon(1e-4));

  // reference E3: γ/ω² = 0.151183919232 A/I for ∫φ² = 1, along x = η φ + ½ η² θ
  const MatrixXd theta = vibration_mode_derivatives(leaf, {modes[0]});
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
