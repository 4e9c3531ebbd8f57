// Terms of degree 3 and 4 of a condensed body against the nonlinear solid that they expand, and
// their rates.
#include "core/elements/solid/quartic.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "core/elements/solid/floating_body.hpp"
#include "core/elements/solid/mesh_energy.hpp"
#include "core/elements/solid/solid_element.hpp"
#include "core/elements/solid/solid_stress.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"
#include "notch_body.hpp"
#include "support/slopes.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

constexpr double degree_of_arc = 3.14159265358979323846 / 180;

// A block of 30 × 10 × 8 mm, bent a little when undeformed.
ElasticBody bent_block(SolidCell cell, const std::array<int, 3>& counts) {
  ElasticBody body =
      block_body(cell, counts, material(70e9, 0.3, 2700), [&](int i, int j, int k) -> Vector3d {
        const double x = i / (2.0 * counts[0]), y = j / (2.0 * counts[1]),
                     z = k / (2.0 * counts[2]);
        return Vector3d(0.03 * x, 0.01 * y + 0.004 * x * x, 0.008 * z - 0.002 * x * y);
      });
  body.degree = ElasticDegree::quartic;
  return body;
}

// A third interface on the side y = 0 of the middle cell of the block, along its whole height.
ElasticBody block_of_three(const std::array<int, 3>& counts) {
  ElasticBody body = bent_block(SolidCell::hexahedron, counts);
  ElasticInterface third{.name = "c", .body = 1, .origin = Vector3d(0.016, -0.002, 0.003)};
  for (std::size_t k = 0; k < body.nodes.size(); ++k) {
    const double x = body.nodes[k].x() / 0.03;
    const double y = body.nodes[k].y() - 0.004 * x * x;
    if (std::abs(x - 0.5) < 0.51 / counts[0] && y < 1e-9)
      third.patch.push_back(static_cast<int>(k));
  }
  body.interfaces.push_back(third);
  return body;
}

// Coordinates with Z d = 0: displacements of about `size`, turns of about `turn`.
VectorXd any_coordinates(const ElasticModel& model, double size, double turn, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  VectorXd d(6 * model.interfaces());
  for (Eigen::Index k = 0; k < d.size(); ++k) d[k] = number(random) * (k % 6 < 3 ? size : turn);
  return model.basis * (model.basis.transpose() * d);
}

double form(const std::vector<double>& tensor, const VectorXd& e) {
  std::vector<double> values = tensor;
  while (values.size() > 1) {
    const std::size_t m = static_cast<std::size_t>(e.size()), n = values.size() / m;
    for (std::size_t i = 0; i < n; ++i) {
      double sum = 0;
      for (std::size_t j = 0; j < m; ++j)
        sum += values[i * m + j] * e[static_cast<Eigen::Index>(j)];
      values[i] = sum;
    }
    values.resize(n);
  }
  return values[0];
}

// The St. Venant–Kirchhoff solid itself, its patches turned by finite rotations.
class NonlinearSolid {
 public:
  explicit NonlinearSolid(const ElasticBody& body) : body_(body) {
    const auto n = 3 * static_cast<Eigen::Index>(body.nodes.size());
    std::vector<bool> held(body.nodes.size());
    for (const ElasticInterface& i : body.interfaces)
      for (const int node : i.patch) held[static_cast<std::size_t>(node)] = true;
    for (Eigen::Index k = 0; k < n; ++k)
      if (!held[static_cast<std::size_t>(k / 3)]) free_.push_back(k);
    MatrixXd K = MatrixXd::Zero(n, n), of_cell;
    for_each_cell(*body.cells, [&](SolidCell cell, std::span<const int> nodes) {
      cell_stiffness(cell, places_of(body.nodes, nodes), ElasticLaw(body.material), of_cell);
      for (Eigen::Index a = 0; a < of_cell.rows(); ++a)
        for (Eigen::Index b = 0; b < of_cell.cols(); ++b)
          K(3 * nodes[static_cast<std::size_t>(a / 3)] + a % 3,
            3 * nodes[static_cast<std::size_t>(b / 3)] + b % 3) += of_cell(a, b);
    });
    stiffness_ = K(free_, free_).llt();
  }

  // Least energy at coordinates d.
  double energy(const VectorXd& d) const {
    VectorXd u = VectorXd::Zero(3 * static_cast<Eigen::Index>(body_.nodes.size()));
    for (std::size_t a = 0; a < body_.interfaces.size(); ++a) {
      const Vector6d at = d.segment<6>(6 * static_cast<Eigen::Index>(a));
      for (const int node : body_.interfaces[a].patch) {
        const Vector3d arm =
            body_.nodes[static_cast<std::size_t>(node)] - body_.interfaces[a].origin;
        u.segment<3>(3 * node) = at.head<3>() + rotation_exp(at.tail<3>()) * arm - arm;
      }
    }
    double step = 1;
    for (int k = 0; k < 400 && step > 1e-17; ++k) {
      const VectorXd change = stiffness_.solve(VectorXd(forces(u)(free_)));
      u(free_) -= change;
      step = change.lpNorm<Eigen::Infinity>();
    }
    REQUIRE(step < 1e-15);
    return solid_stress(body_, {}, u).energy;
  }

 private:
  VectorXd forces(const VectorXd& u) const {
    VectorXd f = VectorXd::Zero(u.size());
    const ElasticLaw law(body_.material);
    for_each_point(body_, SolidRule::energy,
                   [&](const SolidPoint& at, const ReferencePoint&, std::span<const int> nodes) {
                     Matrix3d H = Matrix3d::Zero();
                     for (std::size_t a = 0; a < nodes.size(); ++a)
                       H += u.segment<3>(3 * nodes[a]) *
                            at.gradients.col(static_cast<Eigen::Index>(a)).transpose();
                     const Matrix3d P = at.weight * (Matrix3d::Identity() + H) *
                                        law.stress(H + 0.5 * H.transpose() * H);
                     for (std::size_t a = 0; a < nodes.size(); ++a)
                       f.segment<3>(3 * nodes[a]) +=
                           P * at.gradients.col(static_cast<Eigen::Index>(a));
                   });
    return f;
  }

  ElasticBody body_;
  std::vector<Eigen::Index> free_;
  Eigen::LLT<MatrixXd> stiffness_;
};

// The limit at h = 0 of an even function of h.
template <class F>
double even_limit(const F& f) {
  const double a = f(1.0), b = f(0.5), c = f(0.25);
  const double ab = (4 * b - a) / 3, bc = (4 * c - b) / 3;
  return (16 * bc - ab) / 15;
}

void require_series(const ElasticBody& body, double size, double turn) {
  const auto solid = condensed(body);
  const ElasticModel& model = solid->model;
  const NonlinearSolid exact(body);
  for (const unsigned seed : {1U, 2U, 3U}) {
    const VectorXd d = any_coordinates(model, size, turn, seed);
    const VectorXd e = model.basis.transpose() * d;
    const double second = d.dot(model.stiffness * d);
    const double third = even_limit([&](double h) {
      return 3 * (exact.energy(h * d) - exact.energy(-h * d)) / std::pow(h, 3);
    });
    const double fourth = even_limit([&](double h) {
      return 12 * (exact.energy(h * d) + exact.energy(-h * d) - h * h * second) / std::pow(h, 4);
    });
    CHECK(form(model.cubic, e) == Approx(third).epsilon(1e-6));
    CHECK(form(model.quartic, e) == Approx(fourth).epsilon(1e-5));
  }
}

MatrixXd as_column(const std::vector<double>& numbers) {
  return VectorXd::Map(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

void require_close(const MatrixXd& found, const MatrixXd& expected, double tolerance) {
  REQUIRE(found.size() == expected.size());
  CHECK((found - expected).cwiseAbs().maxCoeff() <= tolerance * expected.cwiseAbs().maxCoeff());
}

// A notch hinge, one end held by the ground, the other one turned about z to an angle while a dead
// force along −x pushes at the middle of its outer face.
struct HingeState {
  double moment = 0;                                   // [N m]
  double rz = 0, x = 0, y = 0, z = 0, rx = 0, ry = 0;  // stiffness: rz alone, others with rz held
  Vector3d shift;  // of the middle of the notch on the turned end [m]
};

HingeState hinge_state(const ElasticModel& model, double angle, double push, double reach) {
  std::vector<FramePose> frames(2);
  FloatingAnswersOf<double> answers;
  HingeState state;
  const std::vector<int> others{0, 1, 2, 3, 4};
  for (int k = 0; k < 30; ++k) {
    evaluate_floating<double>(model, frames, {}, answers);
    REQUIRE(answers.framed);
    const Vector3d arm = frames[1].axes.col(0) * reach, force(-push, 0, 0);
    Vector6d rest = answers.force.tail<6>();
    rest.head<3>() -= force;
    rest.tail<3>() -= arm.cross(force);
    Matrix6d K = answers.tangent.bottomRightCorner<6, 6>();
    const Matrix3d S = force * arm.transpose();
    K.bottomRightCorner<3, 3>() -= 0.5 * (S + S.transpose()) - S.trace() * Matrix3d::Identity();
    const MatrixXd held = Lu(MatrixXd(K(others, others))).inverse(), free = Lu(K).inverse();
    state = {rest[5],        1 / free(5, 5), 1 / held(0, 0), 1 / held(1, 1),
             1 / held(2, 2), 1 / held(3, 3), 1 / held(4, 4), frames[1].position};
    Vector6d step;
    step[5] = angle - rotation_log(frames[1].axes)[2];
    step.head<5>() = -held * (rest.head<5>() + K.col(5).head<5>() * step[5]);
    if (step.cwiseAbs().maxCoeff() < 1e-13) return state;
    frames[1].position += step.head<3>();
    frames[1].axes = rotation_exp(step.tail<3>()) * frames[1].axes;
  }
  FAIL("no equilibrium of the hinge");
  return state;
}

}  // namespace

TEST_CASE("the basis of elastic coordinates has no mean motion") {
  for (const int N : {2, 3}) {
    const MatrixXd basis = elastic_basis(N);
    REQUIRE(basis.cols() == 6 * N - 6);
    const MatrixXd mean = Matrix6d::Identity().replicate(1, N) / N;
    CHECK((mean * basis).cwiseAbs().maxCoeff() < 1e-15);
    CHECK((basis.transpose() * basis - MatrixXd::Identity(6 * N - 6, 6 * N - 6))
              .cwiseAbs()
              .maxCoeff() < 1e-15);
  }
}

TEST_CASE("a linear body knows the cubic terms that it leaves out") {
  for (ElasticBody body : {bent_block(SolidCell::wedge, {3, 1, 1}), block_of_three({4, 2, 2})}) {
    const std::vector<double> whole = condensed(body)->model.cubic;
    body.degree = ElasticDegree::linear;
    const std::vector<double> left_out = condensed(body)->model.cubic;
    const auto n = static_cast<Eigen::Index>(whole.size());
    REQUIRE(left_out.size() == whole.size());
    const auto a = VectorXd::Map(whole.data(), n), b = VectorXd::Map(left_out.data(), n);
    CHECK((a - b).norm() < 1e-12 * a.norm());
  }
}

TEST_CASE("terms of degree 3 and 4 are those of the nonlinear solid") {
  SECTION("hexahedra") { require_series(bent_block(SolidCell::hexahedron, {3, 2, 2}), 1e-4, 0.01); }
  SECTION("wedges") { require_series(bent_block(SolidCell::wedge, {2, 1, 1}), 3e-4, 0.03); }
  SECTION("tetrahedra") {
    require_series(bent_block(SolidCell::tetrahedron, {2, 1, 1}), 3e-4, 0.03);
  }
  SECTION("three interfaces") { require_series(block_of_three({4, 1, 1}), 1e-4, 0.01); }
}

TEST_CASE("the energy that degree 4 leaves out is that of the nonlinear solid") {
  const ElasticBody body = bent_block(SolidCell::hexahedron, {3, 2, 2});
  const auto solid = condensed(body);
  const ElasticModel& model = solid->model;
  const NonlinearSolid exact(body);
  for (const double size : {0.15, 0.3}) {
    const VectorXd d = any_coordinates(model, size * 1e-3, size * 0.1, 5),
                   e = model.basis.transpose() * d;
    const double energy = 0.5 * d.dot(model.stiffness * d) + form(model.cubic, e) / 6 +
                          form(model.quartic, e) / 24,
                 off = exact.energy(d) / energy - 1;
    INFO(size << ": " << off);
    CHECK(std::abs(off) > 1e-6);
    CHECK(left_out_energy(body, *solid, d) == Approx(off).epsilon(0.1));
  }
}

TEST_CASE("second-order fields turn patches as rigid bodies to second order") {
  const ElasticBody body = block_of_three({4, 1, 1});
  const auto solid = condensed(body);
  const VectorXd d = any_coordinates(solid->model, 1e-4, 1e-3, 4);
  const VectorXd u = solid_displacements(*solid, d);
  for (std::size_t a = 0; a < 3; ++a) {
    const Vector6d at = d.segment<6>(6 * static_cast<Eigen::Index>(a));
    for (const int node : body.interfaces[a].patch) {
      const Vector3d arm = body.nodes[static_cast<std::size_t>(node)] - body.interfaces[a].origin;
      const Vector3d exact = at.head<3>() + rotation_exp(at.tail<3>()) * arm - arm;
      CHECK((u.segment<3>(3 * node) - exact).norm() < 1e-9 * arm.norm());
    }
  }
}

TEST_CASE("rates of terms of degree 3 and 4 are exact") {
  for (const ElasticBody& body : {notch_body({}, {6, 2, 2}), block_of_three({4, 2, 2})}) {
    const ElasticBody direction = any_direction(body);
    const auto rate = model_rate(body, direction);
    const auto at = [&](double h) { return condensed(moved_body(body, direction, h)); };
    constexpr double h = 1e-3;
    require_close(as_column(rate->cubic),
                  slope_at_zero([&](double x) { return as_column(at(x)->model.cubic); }, h), 1e-7);
    require_close(as_column(rate->quartic),
                  slope_at_zero([&](double x) { return as_column(at(x)->model.quartic); }, h),
                  1e-7);
    require_close(field_rates(body, direction)->second_fields,
                  slope_at_zero([&](double x) { return at(x)->second_fields; }, h), 1e-7);
  }
}

// Of the nonlinear solid on the same mesh between the same rigid faces, whose moment and shift at
// 5 degrees and t/R = 0.1 CalculiX gives to six digits too.
TEST_CASE("a notch hinge of degree 4 is the nonlinear solid to 5 degrees and 0.2 of buckling") {
  struct Row {
    double thickness, angle, push;  // [m], [deg], [N]
    HingeState solid;
  };
  const auto row = GENERATE(values<Row>({{0.5e-3,
                                          0,
                                          0,
                                          {0,
                                           4.1924810640,
                                           79460959.482,
                                           4554262.5339,
                                           20982087.576,
                                           42.943952026,
                                           650.54246958,
                                           {0, 0, 0}}},
                                         {0.5e-3,
                                          5,
                                          0,
                                          {0.36582752547,
                                           4.1912592327,
                                           76392278.145,
                                           4565472.6957,
                                           20975799.857,
                                           43.054003761,
                                           628.76467612,
                                           {1.7511509595e-6, 7.64569e-8, 0}}},
                                         {0.5e-3,
                                          0,
                                          119.78517326,
                                          {0,
                                           3.4081816326,
                                           79413190.757,
                                           4524702.6070,
                                           20968913.710,
                                           42.710465786,
                                           649.56005192,
                                           {-1.5079252571e-6, 0, 0}}},
                                         {0.5e-3,
                                          3,
                                          119.78517326,
                                          {0.17846174381,
                                           3.4087465283,
                                           78260763.616,
                                           4528769.8091,
                                           20966754.799,
                                           42.750915710,
                                           641.42572245,
                                           {-8.9903021846e-7, 6.6952536183e-7, 0}}},
                                         {1e-3,
                                          0,
                                          0,
                                          {0,
                                           22.930785649,
                                           118137384.62,
                                           11749240.389,
                                           29576625.489,
                                           123.81801154,
                                           971.04421076,
                                           {0, 0, 0}}},
                                         {1e-3,
                                          5,
                                          0,
                                          {2.0006045781,
                                           22.914138455,
                                           115554425.39,
                                           11774952.767,
                                           29566930.686,
                                           124.07950372,
                                           954.79699183,
                                           {2.2827620903e-6, 9.96675e-8, 0}}},
                                         {1e-3,
                                          0,
                                          655.1653042,
                                          {0,
                                           18.727130836,
                                           117923704.31,
                                           11632627.661,
                                           29515297.056,
                                           122.90959442,
                                           966.16385642,
                                           {-5.5508113054e-6, 0, 0}}},
                                         {1e-3,
                                          3,
                                          655.1653042,
                                          {0.98053664932,
                                           18.726362052,
                                           116956336.57,
                                           11642020.568,
                                           29512014.339,
                                           123.00798087,
                                           960.14397578,
                                           {-4.7736449406e-6, 1.34956552e-6, 0}}},
                                         {2.5e-3,
                                          0,
                                          0,
                                          {0,
                                           211.39583606,
                                           212234466.31,
                                           38745055.970,
                                           48930473.532,
                                           506.02670293,
                                           1749.6186643,
                                           {0, 0, 0}}},
                                         {2.5e-3,
                                          5,
                                          0,
                                          {18.435127328,
                                           210.96127076,
                                           209800666.63,
                                           38803087.935,
                                           48912206.346,
                                           506.54202093,
                                           1738.1294341,
                                           {2.5962091151e-6, 1.13353e-7, 0}}},
                                         {2.5e-3,
                                          0,
                                          6039.88102,
                                          {0,
                                           172.97389413,
                                           210576806.19,
                                           38012049.646,
                                           48425849.364,
                                           500.71963407,
                                           1708.2438852,
                                           {-2.8570128706e-5, 0, 0}}},
                                         {2.5e-3,
                                          3,
                                          6039.88102,
                                          {9.0549459970,
                                           172.86241457,
                                           209655363.41,
                                           38033892.480,
                                           48419719.250,
                                           500.93915504,
                                           1704.0805882,
                                           {-2.7757014745e-5, 3.4339972e-6, 0}}}}));
  CAPTURE(row.thickness, row.angle, row.push);
  const auto solid = condensed(notch_body({.thickness = row.thickness}, {20, 3, 4}));
  const HingeState found = hinge_state(solid->model, row.angle * degree_of_arc, row.push, 7e-3);
  const HingeState& exact = row.solid;
  const bool turned = row.angle > 0;
  CHECK(found.moment == Approx(exact.moment).epsilon(2.5e-4).margin(1e-9));
  CHECK(found.rz == Approx(exact.rz).epsilon(turned ? 1.2e-3 : 2e-6));
  const double tolerance = turned ? 1e-4 : 1e-6;
  CHECK(found.x == Approx(exact.x).epsilon(tolerance));
  CHECK(found.y == Approx(exact.y).epsilon(tolerance));
  CHECK(found.z == Approx(exact.z).epsilon(tolerance));
  CHECK(found.rx == Approx(exact.rx).epsilon(tolerance));
  CHECK(found.ry == Approx(exact.ry).epsilon(tolerance));
  CHECK((found.shift - exact.shift).norm() < (turned ? 2e-8 : 1e-12));
}

TEST_CASE("the cubic form along a deformation is that of the whole tensor") {
  ElasticBody body = notch_body({}, {4, 2, 2});
  const auto solid = condensed(body);
  const VectorXd d = solid->model.basis * VectorXd::LinSpaced(6, -2e-3, 3e-3);
  CondensedSolid without = *solid;
  without.model.cubic.clear();
  const MatrixXd whole = cubic_along(body, *solid, d), along = cubic_along(body, without, d);
  CHECK((whole - along).norm() < 1e-10 * whole.norm());
}
