#pragma once
// Laws of any plate or beam leaf between its edges, whatever its shape, and states to try them at.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>

#include "core/elements/plate/plate_leaf.hpp"
#include "core/elements/plate/plate_mesh_rate.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/arc.hpp"
#include "support/models.hpp"
#include "support/moved.hpp"
#include "support/slopes.hpp"

namespace flexopt::plate_laws {

using models::sampled;
inline double wave(double s) { return 1 + 0.3 * std::sin(4 * s) - 0.2 * s; }

/// Bent and twisted well into the nonlinear range, internal unknowns not at rest.
inline PlateLeaf::State random_state(const PlateMesh& mesh, unsigned seed, double lift = 0.1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  PlateLeaf::State state = PlateLeaf::undeflected(mesh);
  state.edges[1].position += Vector3d(-0.01, 0.01, lift);
  state.edges[1].axes = rotation_exp({0.1, 0.2, 0.03}) * state.edges[1].axes;
  for (double& x : state.x) x += 0.003 * u(random);
  return state;
}

inline VectorXd random_direction(Eigen::Index size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  VectorXd d(size);
  for (double& x : d) x = u(random);
  return d;
}

/// The power of the step with which the rest of a Taylor expansion falls: step, half the step.
inline double observed_rate(double coarse, double fine) { return std::log2(coarse / fine); }

/// The state of a leaf, moved as a whole.
inline PlateLeaf::State moved_rigidly(const PlateLeaf& leaf, PlateLeaf::State state,
                                      const Matrix3d& turn, const Vector3d& shift) {
  const PlateMesh& mesh = leaf.mesh();
  for (EdgePose& edge : state.edges) edge = {turn * edge.position + shift, turn * edge.axes};
  const int n = mesh.functions_per_line();
  for (int line = 1; line + 1 < mesh.lines(); ++line) {
    if (leaf.is_second_of_fold(line)) continue;
    Eigen::Map<MatrixXd> r(state.x.data() + leaf.block_offset(line), n, 3);
    r = (r * turn.transpose()).eval();
    for (int s = 0; s < n; s += 4) r.row(s) += shift.transpose();
  }
  return state;
}

/// A bent leaf that is moved as a whole has the same energy, and its force and tangent turn with
/// it.
inline void check_turned(const PlateLeaf& leaf, double energy_error) {
  const double energy = leaf.energy();
  const Vector12d force = leaf.force();
  const Matrix12d tangent = leaf.tangent();
  CHECK((tangent - tangent.transpose()).norm() < 1e-12 * tangent.norm());
  for (unsigned trial = 0; trial < 5; ++trial) {
    const VectorXd by = random_direction(6, 5 + trial);
    const Matrix3d Q = rotation_exp(Vector3d(3 * by.head<3>()));
    PlateLeaf other(leaf.shared_mesh());
    other.set_state(moved_rigidly(leaf, leaf.state(), Q, by.tail<3>()));
    other.assemble();
    Matrix12d T = Matrix12d::Zero();
    for (int k = 0; k < 12; k += 3) T.block<3, 3>(k, k) = Q;
    CHECK(std::abs(other.energy() / energy - 1) < energy_error);
    CHECK((other.force() - T * force).norm() < 1e-11 * tangent.norm());
    CHECK((other.tangent() - T * tangent * T.transpose()).norm() < 1e-10 * tangent.norm());
  }
}

/// Force and tangent of a bent leaf, interior and edges, against its energy. `step`: of the rest
/// beyond the quadratic term; `quartic`: the energy is such a polynomial of the interior's
/// unknowns, so that the blocks of the tangent can be compared one by one.
inline void check_energy_derivatives(const std::shared_ptr<const PlateMesh>& mesh, double step,
                                     bool quartic) {
  PlateLeaf leaf(mesh);
  const PlateLeaf::State state = random_state(*mesh, 7);
  const int n = leaf.unknowns();
  const auto energy_at = [&](const VectorXd& by) {
    PlateLeaf::State there = state;
    there.x += by.head(n);
    there.edges = moved(there.edges, by.tail<12>());
    leaf.set_state(there);
    leaf.assemble();
    return leaf.energy();
  };
  const auto gradient_at = [&](const VectorXd& by) {
    energy_at(by);
    VectorXd g(n + 12);
    g << leaf.residual(), leaf.edge_force();
    return g;
  };
  const VectorXd way = random_direction(n + 12, 11), force = gradient_at(0 * way);
  const Vector12d dq = way.tail<12>();
  const double energy = leaf.energy();
  REQUIRE(std::abs(force.dot(way)) > 0);
  const auto first = [&](double h) {
    return std::abs(energy_at(h * way) - energy - h * force.dot(way));
  };
  CHECK(observed_rate(first(2e-4), first(1e-4)) == Approx(2).margin(0.1));

  // K_ff v = w is solved exactly when v = K_ff⁻¹ w: compare with differences of the residual.
  energy_at(0 * way);
  VectorXd v = way.head(n);
  leaf.solve(v);
  const double size = v.norm();
  v /= size;
  const Matrix12d edge = leaf.edge_tangent();
  VectorXd along = VectorXd::Zero(n + 12), expected(n + 12);
  along.head(n) = v;
  expected << way.head(n) / size, leaf.coupling().transpose() * v;
  if (quartic) {  // differences are exact but for rounding of the membrane forces
    const VectorXd off =
        test::slope_at_zero([&](double h) { return gradient_at(h * along); }, 2e-3) - expected;
    CHECK(off.head(n).norm() < 1e-5 * expected.head(n).norm());
    CHECK(off.tail<12>().norm() < 1e-6 * expected.tail<12>().norm());
  }

  // All blocks at once: the rest beyond the quadratic term is of third order.
  along.tail<12>() = dq;
  const double curvature =
      v.dot(expected.head(n)) + 2 * dq.dot(expected.tail<12>()) + dq.dot(edge * dq);
  const auto second = [&](double h) {
    return std::abs(energy_at(h * along) - energy - h * force.dot(along) - 0.5 * h * h * curvature);
  };
  CHECK(observed_rate(second(step), second(0.5 * step)) == Approx(3).margin(0.1));

  // The edges' own block: second difference of the energy along edge motions.
  for (unsigned trial = 0; quartic && trial < 4; ++trial) {
    along.setZero();
    along.tail<12>() = random_direction(12, 12 + trial);
    const auto bend = [&](double s) {
      return (energy_at(s * along) - 2 * energy + energy_at(-s * along)) / (s * s);
    };
    CHECK((4 * bend(2e-3) - bend(4e-3)) / 3 ==
          Approx(along.tail<12>().dot(edge * along.tail<12>())).epsilon(1e-6));
  }
}

/// Mass of the undeflected leaf by velocity and spin about its base; over that of a unit of area.
inline Matrix6d rigid_mass(const std::shared_ptr<const PlateMesh>& mesh) {
  PlateLeaf leaf(mesh);
  leaf.assemble();
  // rigid motions: K⁻¹ of the constraint modes reproduces them exactly
  MatrixXd X = leaf.coupling();
  leaf.solve(X);
  MatrixXd T(leaf.unknowns() + 12, 12);
  T << -X, Matrix12d::Identity();
  Eigen::Matrix<double, 12, 6> rigid;
  rigid << Matrix6d::Identity(), Matrix6d::Identity();
  rigid.bottomRightCorner<6, 3>().topRows<3>() = -hat(Vector3d(Vector3d::UnitX()));
  return rigid.transpose() * leaf.mass(T) * rigid;
}

/// Free of stress wherever it is moved as a whole, and the tangent there is symmetric and has
/// the rigid motions as its null space.
inline void check_rigid_motions(const std::shared_ptr<const PlateMesh>& mesh,
                                double rest_energy = 1e-9) {
  PlateLeaf leaf(mesh);
  const Matrix3d turn = rotation_exp({0.7, -1.1, 2.0});
  const Vector3d shift(0.3, -2, 0.7);
  for (const PlateLeaf::State& state :
       {moved_rigidly(leaf, PlateLeaf::undeflected(*mesh), turn, shift),
        PlateLeaf::undeflected(*mesh)}) {
    leaf.set_state(state);
    leaf.assemble();
    // rounding: entries of the stiffness are of size 1e5
    CHECK(std::abs(leaf.energy()) < 1e-9);
    CHECK(leaf.residual().norm() < 1e-7);
    CHECK(leaf.edge_force().norm() < 1e-7);
    CHECK(leaf.negative_pivots() == 0);
  }
  CHECK(std::abs(leaf.energy()) < rest_energy);
  const Matrix12d K = leaf.tangent();
  Eigen::Matrix<double, 12, 6> rigid;
  for (int e = 0; e < 2; ++e) {
    rigid.block<3, 3>(6 * e, 0).setIdentity();
    rigid.block<3, 3>(6 * e, 3) = -hat(leaf.state().edges[e].position);
    rigid.block<3, 3>(6 * e + 3, 0).setZero();
    rigid.block<3, 3>(6 * e + 3, 3).setIdentity();
  }
  CHECK((K * rigid).norm() < 1e-9 * K.norm());
  CHECK((K - K.transpose()).norm() < 1e-10 * K.norm());
}

/// Residual and tangent of the interior against differences along d; the leaf stands at `state`
/// afterwards, linearised.
inline void check_interior_derivatives(PlateLeaf& leaf, const PlateLeaf::State& state,
                                       const VectorXd& d) {
  const auto move_to = [&](double h) {
    PlateLeaf::State moved = state;
    moved.x += h * d;
    leaf.set_state(moved);
    leaf.linearise();
  };
  const double slope =
      test::slope_at_zero([&](double h) { return move_to(h), leaf.energy(); }, 5e-5);
  const double bend =
      test::slope_at_zero([&](double h) { return move_to(h), leaf.residual().dot(d); }, 5e-5);
  move_to(0);
  REQUIRE(std::abs(slope) > 1);
  CHECK(leaf.residual().dot(d) == Approx(slope).epsilon(1e-7));
  CHECK(d.dot(VectorXd(leaf.tangent_times(d))) == Approx(bend).epsilon(1e-8));
}

/// A shape that lies h along a rate.
inline PlateShape moved(PlateShape shape, const ShapeRate& rate, double h) {
  shape.width += h * rate.size[0];
  shape.thickness += h * rate.size[1];
  shape.poissons_ratio += h * rate.size[2];
  if (shape.curve) *shape.curve += h * rate.curve;
  if (shape.fold) {
    shape.fold->place += h * rate.fold.place;
    shape.fold->angle += h * rate.fold.angle;
    shape.fold->radius += h * rate.fold.radius;
  }
  for (std::size_t k = 0; k < rate.width_profile.size(); ++k)
    shape.width_profile[k] += h * rate.width_profile[k];
  for (std::size_t k = 0; k < rate.thickness_profile.size(); ++k)
    shape.thickness_profile[k] += h * rate.thickness_profile[k];
  return shape;
}

/// Derivatives of the operators of a mesh, along its sizes and along directions of its profiles,
/// its arc and its fold, against differences of meshes that are made anew.
inline void check_mesh_rate(const PlateShape& at, const std::vector<ProfileRate>& directions) {
  const PlateMesh mesh(at);
  const PlateMeshRate rate(mesh, directions);
  REQUIRE(rate.directions() == 3 + static_cast<int>(directions.size()));
  for (int p = 0; p < rate.directions(); ++p) {
    CAPTURE(p);
    const ShapeRate& along = rate.direction[p];
    const PlateMeshRate::Shape& by = rate.shape[p];
    const double h = p == 1 ? 1e-5 : along.fold.radius != 0 ? 2e-5 : 1e-4;
    const auto there = [&](double step) { return PlateMesh(moved(at, along, step)); };
    const PlateMesh plus = there(h), minus = there(-h), plus2 = there(2 * h),
                    minus2 = there(-2 * h);
    const auto compare = [&](const auto& rates, std::size_t k, auto part) {
      const auto of = [&](const PlateMesh& m) { return MatrixXd(part(m).matrix()); };
      const MatrixXd d = (8 * (of(plus) - of(minus)) - (of(plus2) - of(minus2))) / (12 * h);
      MatrixXd found = MatrixXd::Zero(d.rows(), d.cols());
      if (!rates.empty()) found = rates[k].matrix();
      CHECK((found - d).norm() <= 1e-8 * d.norm() + 1e-7 * of(mesh).norm() + 1e-12);
    };
    std::size_t k = 0;
    for (int i = 0; i < mesh.elements_along(); ++i)
      for (int j = 0; j < mesh.elements_across(); ++j, ++k) {
        const auto of = [&](auto member) {
          return [=](const PlateMesh& m) { return m.element(i, j).*member; };
        };
        using Element = PlateMesh::Element;
        compare(by.bending, k, of(&Element::bending));
        compare(by.mass, k, of(&Element::mass));
        compare(by.gradient, k, of(&Element::gradient));
        compare(by.weight, k, of(&Element::weight));
        compare(by.metric, k, of(&Element::metric));
        compare(by.curvature, k, of(&Element::curvature));
        compare(by.curvature_weight, k, of(&Element::curvature_weight));
      }
    for (int line = 0; line < mesh.lines(); ++line)
      compare(by.undeflected, static_cast<std::size_t>(line),
              [=](const PlateMesh& m) { return MatrixXd(m.undeflected(line)); });
  }
}

/// Displacements and rotation of the tip in the plane of an arc or a fold: ux, uz and ry.
constexpr std::array in_its_plane{6, 8, 10};

/// Flexibility of the tip along some of its directions, the others held.
inline Matrix3d flexibility(const PlateLeaf& leaf, const std::array<int, 3>& directions) {
  return Matrix3d(leaf.tangent()(directions, directions)).inverse();
}

/// Of Fx, Fz and My at the tip of a curve: the moment at one of its points.
inline Vector3d moment_at(const ArcPoint<double>& point, const ArcPoint<double>& tip) {
  return {tip.z - point.z, -(tip.x - point.x), 1};
}

/// Flexibility of the tip of a curve of unit length in its plane:
/// ∫ moment² / EI + pull² / EA + shear² / kGA ds.
template <class Curve>
Matrix3d flexibility_in_plane(const Curve& curve, double EI, double EA, double GA) {
  constexpr int points = 2000;
  Matrix3d C = Matrix3d::Zero();
  for (int k = 0; k < points; ++k) {
    const ArcPoint<double> p = curve((k + 0.5) / points);
    const Vector3d moment = moment_at(p, curve(1.0)), pull(p.cosine, p.sine, 0),
                   cut(-p.sine, p.cosine, 0);
    C += (moment * moment.transpose() / EI + pull * pull.transpose() / EA +
          cut * cut.transpose() / GA) /
         points;
  }
  return C;
}

inline void check_flexibility(const Matrix3d& found, const Matrix3d& C, double tolerance) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      CHECK(std::abs(found(i, j) - C(i, j)) < tolerance * std::sqrt(C(i, i) * C(j, j)));
}

}  // namespace flexopt::plate_laws
