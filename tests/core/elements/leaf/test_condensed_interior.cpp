// The interior of a leaf condensed onto edges and material point, against dense linear algebra.
#include "core/elements/leaf/condensed_interior.hpp"
#include "core/math/decompositions.hpp"

#include <catch2/catch.hpp>
#include <numeric>

using namespace flexopt;

namespace {

constexpr int blocks = 4, size = 5, n = blocks * size;

struct Interior {
  BlockTridiagonal K;
  MatrixXd dense;
  VectorXd residual = VectorXd::Random(n);
  MatrixXd coupling = MatrixXd::Zero(n, 12);
  Vector12d edge_force = Vector12d::Random();
  Matrix12d edge_tangent = Matrix12d::Identity() * 50;
  CondensedInterior::Point point{.gradient = MatrixXd::Random(n, 3),
                                 .edge_gradient = Eigen::Matrix<double, 3, 12>::Random(),
                                 .missing = Vector3d::Random(),
                                 .force = Vector3d::Random()};

  /// `shift` < 0 makes it indefinite.
  explicit Interior(double shift) {
    std::srand(7);
    K.resize(std::vector<int>(blocks, size));
    dense = MatrixXd::Zero(n, n);
    for (int i = 0; i < blocks; ++i) {
      const MatrixXd A = MatrixXd::Random(size, size);
      K.diagonal[i] =
          A * A.transpose() + (4 + (i == 1 ? shift : 0)) * MatrixXd::Identity(size, size);
      dense.block(size * i, size * i, size, size) = K.diagonal[i];
      if (i + 1 == blocks) continue;
      K.below[i] = 0.3 * MatrixXd::Random(size, size);
      dense.block(size * (i + 1), size * i, size, size) = K.below[i];
      dense.block(size * i, size * (i + 1), size, size) = K.below[i].transpose();
    }
    coupling.topLeftCorner(size, 6).setRandom();
    coupling.bottomRightCorner(size, 6).setRandom();
    K.factorise();
  }
};

// Equations for (dx, dλ) with edges and point held: [K, −C; −Cᵀ, 0].
MatrixXd saddle(const Interior& of) {
  MatrixXd A = MatrixXd::Zero(n + 3, n + 3);
  A.topLeftCorner(n, n) = of.dense;
  A.topRightCorner(n, 3) = -of.point.gradient;
  A.bottomLeftCorner(3, n) = -of.point.gradient.transpose();
  return A;
}

}  // namespace

TEST_CASE("a condensed interior is the Schur complement on the edges, also where it has buckled") {
  for (const double shift : {0.0, -12.0}) {
    const Interior of(shift);
    CondensedInterior interior;
    interior.condense(of.K, of.residual, of.coupling, of.edge_force, of.edge_tangent, blocks - 1);
    const MatrixXd X = Lu(of.dense).solve(of.coupling);
    const VectorXd x = Lu(of.dense).solve(of.residual);
    CHECK((interior.force() - (of.edge_force - of.coupling.transpose() * x)).norm() < 1e-12);
    CHECK((interior.tangent() - (of.edge_tangent - of.coupling.transpose() * X)).norm() < 1e-11);
    CHECK(interior.correction() == Approx(std::abs(of.residual.dot(x))));
    CHECK((interior.negative_pivots() > 0) == (shift < 0));
    const Vector12d dq = Vector12d::Random();
    Vector3d df;
    CHECK((interior.step(of.K, dq, Vector3d::Zero(), df) + x + X * dq).norm() < 1e-12);
    CHECK(df.isZero(0));
    CHECK((interior.static_shapes(of.K, {3, 8}).col(1) + X.col(8)).norm() < 1e-12);
  }
}

TEST_CASE("a held material point borders the interior's equations") {
  const Interior of(0);
  CondensedInterior interior;
  interior.condense(of.K, of.residual, of.coupling, of.edge_force, of.edge_tangent, blocks - 1);
  interior.hold(of.K, of.point);
  const MatrixXd A = saddle(of);
  // dx and dλ for increments of edges and point, after the residual is gone
  const Vector12d dq = Vector12d::Random();
  const Vector3d du = Vector3d::Random();
  VectorXd b(n + 3);
  b << -(of.residual + of.coupling * dq), of.point.edge_gradient * dq - of.point.missing - du;
  const VectorXd solved = Lu(A).solve(b);
  Vector3d df;
  CHECK((interior.step(of.K, dq, du, df) - solved.head(n)).norm() < 1e-11);
  CHECK((df - solved.tail<3>()).norm() < 1e-11);

  // force of edges and point, and their derivatives, are those of the equations
  REQUIRE(interior.point());
  const auto forces = [&](const Vector12d& q, const Vector3d& u) -> VectorXd {
    VectorXd c(n + 3);
    c << -(of.residual + of.coupling * q), of.point.edge_gradient * q - of.point.missing - u;
    const VectorXd s = Lu(A).solve(c);
    VectorXd f(15);
    f << of.edge_force + of.edge_tangent * q + of.coupling.transpose() * s.head(n) -
             of.point.edge_gradient.transpose() * s.tail<3>(),
        of.point.force + s.tail<3>();
    return f;
  };
  const VectorXd rest = forces(Vector12d::Zero(), Vector3d::Zero());
  CHECK((interior.force() - rest.head<12>()).norm() < 1e-11);
  CHECK((interior.point()->force - rest.tail<3>()).norm() < 1e-11);
  const VectorXd by_edges = forces(dq, Vector3d::Zero()) - rest,
                 by_point = forces(Vector12d::Zero(), du) - rest;
  CHECK((interior.tangent() * dq - by_edges.head<12>()).norm() < 1e-10);
  CHECK((interior.point()->coupling * dq - by_edges.tail<3>()).norm() < 1e-10);
  CHECK((interior.point()->coupling.transpose() * du - by_point.head<12>()).norm() < 1e-10);
  CHECK((interior.point()->tangent * du - by_point.tail<3>()).norm() < 1e-10);

  MatrixXd B = MatrixXd::Random(n, 2);
  MatrixXd bordered = MatrixXd::Zero(n + 3, 2);
  bordered.topRows(n) = B;
  interior.solve(of.K, B);
  CHECK((B - Lu(A).solve(bordered).topRows(n)).norm() < 1e-11);
}
