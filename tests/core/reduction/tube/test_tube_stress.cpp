// The tables of a tube leaf's strains: their expansion against exact states, the mirrors of a leaf,
// and the stress of mechanisms against full leaves.
#include <algorithm>

#include "core/elements/leaf/leaf_scale.hpp"
#include "core/reduction/tube/tube_leaf.hpp"
#include "support/monomials.hpp"
#include "support/strokes.hpp"
#include "support/synthetic_leaf.hpp"

using namespace flexopt;

namespace {
const PlateShape flat{0.3, 0.005, 0.3, {6, 2}, true};

std::shared_ptr<TubeModel> tube(const PlateShape& shape) {
  return std::make_shared<TubeModel>(std::make_shared<PlateMesh>(shape), TubeRange{});
}

double von_mises(const PlateShape& shape, const Strains& e, bool positive) {
  return flexopt::von_mises(section_stress(shape, e, 1), positive ? 1 : -1);
}

StrokeRequest sweep(double end, int points) { return {.points = models::evenly(end, points)}; }

struct Errors {
  double stress = 0, place = 0;
  int others = 0;  ///< leaves whose stress is not from tables
};
Errors compare(const Mechanism& mechanism, const StrokeRequest& request) {
  const StrokeResponse found = test::evaluated(mechanism, {}, request),
                       truth = test::evaluated(mechanism, test::full(), request);
  Errors worst;
  for (std::size_t k = 0; k < truth.path.size(); ++k) {
    const StressPeak &a = *found.path[k].max_stress, &b = *truth.path[k].max_stress;
    if (truth.path[k].stroke != 0)
      worst.stress = std::max(worst.stress, std::abs(a.value / b.value - 1));
    if (a.along == b.along && a.across == b.across && a.leaf == b.leaf)
      worst.place = std::max(worst.place, (a.position - b.position).norm());
    for (const LeafReport& leaf : found.path[k].leaves)
      worst.others += leaf.model != "tube" || !leaf.reason.empty();
  }
  return worst;
}

}  // namespace

TEST_CASE("strains and places expand as exact states do, to second order, in bending to third") {
  const auto mesh = std::make_shared<PlateMesh>(flat);
  const Eigen::Matrix2d ray = synthetic::s_ray();
  const Vector3d scale = tube_force_scale(flat);
  ChordLeaf leaf(mesh);
  const auto strains = [&] { return expand_stress(leaf, ray, expand_fields(leaf, ray, 2).fields); };
  REQUIRE(leaf.solve({0.1, 0.1, 0}, Vector3d::Zero()).converged);
  const ChordLeaf node = leaf;
  const MatrixXd e = strains();
  const MonomialTable& table = monomials<6, 2>();
  constexpr int cubic = 4;
  REQUIRE(e.cols() == table.size() + cubic);
  const StressPlaces places(flat);
  double rest[2][2];
  const bool bending = GENERATE(false, true);
  for (int n = 0; n < 2; ++n) {
    Vector6d x = Vector6d::Zero();
    if (bending)
      x.head<2>() << 0.02, 0.015;
    else
      x << 0.01, 0.01, 0.004, 1, 0.5, -0.3;
    x /= 1 << n;
    leaf = node;
    for (int again = 0; again < 2; ++again)
      REQUIRE(
          leaf.solve({0.1 + x[0] + x[1], 0.1 + x[0] - x[1], x[2]}, scale.cwiseProduct(x.tail<3>()))
              .converged);
    const VectorXd power = test::monomial_values(table, {x.data(), 6});
    VectorXd difference = strains().col(0) - e.leftCols(table.size()) * power;
    for (int tau = 0; bending && tau < cubic; ++tau)  // σ³, σ²τ, στ², τ³
      difference -= e.col(table.size() + tau) * std::pow(x[0], 3 - tau) * std::pow(x[1], tau);
    rest[n][0] = difference.head(places.strain_rows()).norm();
    rest[n][1] = difference.tail(places.rows() - places.strain_rows()).norm();
  }
  for (int part = 0; part < 2; ++part)
    CHECK(std::log2(rest[0][part] / rest[1][part]) > (bending ? 3.7 : 2.7));
}

TEST_CASE("what the strains change by across the ray is right between bent states, too") {
  const Eigen::Matrix2d ray = synthetic::c_ray();
  ChordLeaf leaf(std::make_shared<PlateMesh>(flat));
  TubeStress tables(flat, 0);
  const auto node = [&](double sigma, double tau) {
    const Eigen::Vector2d bent = ray * Eigen::Vector2d(sigma, tau);
    REQUIRE(leaf.solve({bent[0], bent[1], 0}, Vector3d::Zero()).converged);
    return stress_node(leaf, sigma, ray, expand_fields(leaf, ray, 2).fields);
  };
  for (const double sigma : {0.0, 0.03, 0.1, 0.22}) tables.add(node(sigma, 0));
  for (const double sigma : {0.065, 0.16}) {
    const double tau = 0.05 * sigma, h = 1e-4 * sigma;
    const auto at = [&](double t) {
      return tables.evaluate({sigma, t, 0, Vector3d::Zero()}).strains.values();
    };
    const MatrixXd found = (at(tau + h) - at(tau - h)) / (2 * h);
    // on the half that is tabulated
    const StateTable truth = node(sigma, tau);
    const Eigen::Index n = found.rows() / 2;
    double difference = 0;
    for (Eigen::Index k = 0; k < 6; ++k)
      difference = std::max(
          difference,
          (found.col(k).head(n) - truth.even.col(2).segment(k * n, n)).cwiseAbs().maxCoeff() /
              truth.even.col(2).segment(k * n, n).norm());
    INFO(sigma);
    CHECK(difference < 2.5e-3);
  }
}

TEST_CASE("a tabulated leaf is stressed as its mirror images are") {
  const auto model = tube(flat);
  REQUIRE(model->stress());
  const TubeStress& tables = *model->stress();
  const TubeStress::Place here{0.17, 0.01, 0.003, {0.6, 0.3, -0.2}};
  const auto strains = tables.evaluate(here).strains;
  const auto thickness = tables.evaluate({-0.17, -0.01, -0.003, {0.6, 0.3, -0.2}}).strains;
  const auto width = tables.evaluate({0.17, 0.01, -0.003, {0.6, -0.3, 0.2}}).strains;
  const double largest = plate_stress(strains, flat, 1, 0).largest().value;
  double asymmetry = 0;
  for (const double x : {0.0, 0.13, 0.5, 0.97})
    for (const double y : {-0.14, -0.05, 0.0, 0.11})
      for (const bool positive : {true, false}) {
        const double s = von_mises(flat, strains.at(x, y), positive);
        CHECK(std::abs(von_mises(flat, thickness.at(x, y), !positive) - s) < 1e-12 * largest);
        CHECK(std::abs(von_mises(flat, width.at(x, -y), positive) - s) < 1e-12 * largest);
        asymmetry = std::max(asymmetry, std::abs(von_mises(flat, strains.at(x, -y), positive) - s));
      }
  CHECK(asymmetry > 1e-3 * largest);
  // and its points stand in the mirror
  const Vector3d r = tables.material_point(here, 0.3, 0.2),
                 in_thickness =
                     tables.material_point({-0.17, -0.01, -0.003, {0.6, 0.3, -0.2}}, 0.3, 0.2),
                 in_width = tables.material_point({0.17, 0.01, -0.003, {0.6, -0.3, 0.2}}, 0.3, 0.8);
  CHECK((in_thickness - Vector3d(r[0], r[1], -r[2])).norm() < 1e-12);
  CHECK((in_width - Vector3d(r[0], -r[1], r[2])).norm() < 1e-12);
}

TEST_CASE("a leaf twice the size, bent alike, has the same stress from its tables") {
  const StrokeRequest request = sweep(0.02, 4), doubled = sweep(0.04, 4);
  const StrokeResponse a = evaluate_stroke(models::guide(0.1, 0.03, 5e-4, 0.06), {}, request),
                       b = evaluate_stroke(models::guide(0.2, 0.06, 1e-3, 0.12), {}, doubled);
  for (std::size_t k = 1; k < 4; ++k) {
    const StressPeak &p = *a.path[k].max_stress, &q = *b.path[k].max_stress;
    CHECK(q.value == Approx(p.value).epsilon(1e-7));
    CHECK(p.value > 1e7);
    CHECK((q.position - 2 * p.position).norm() < 5e-7);
  }
}

TEST_CASE("stress from tables goes on smoothly over the bent states") {
  const auto model = tube({0.6, 0.004, 0.3, {10, 4}, true});
  REQUIRE(model->stress());
  const auto stress = [&](double sigma) {
    const TubeStress::Place at{sigma, 0.004, 0.001, {0.5, 0.1, 0.2}};
    return plate_stress(model->stress()->evaluate(at).strains, model->shape(), 1, 0)
        .largest()
        .value;
  };
  const auto& nodes = model->potential().nodes();
  REQUIRE(nodes.size() >= 3);
  for (std::size_t n = 1; n + 1 < nodes.size(); ++n) {
    const double at = nodes[n].sigma, h = 1e-6;
    CHECK(std::abs(stress(at + 1e-10) - stress(at - 1e-10)) < 1e-8 * stress(at));
    // the slope on both sides
    const double left = (stress(at) - stress(at - h)) / h,
                 right = (stress(at + h) - stress(at)) / h;
    CHECK(std::abs(left - right) < 1e-3 * std::abs(left));
  }
}

TEST_CASE("stress from tables is that of full leaves, both ways", "[slow]") {
  const double side = GENERATE(1.0, -1.0);
  const Errors guide = compare(models::guide(0.1, 0.03, 5e-4), sweep(side * 0.02, 7));
  CHECK(guide.stress < 1e-3);
  CHECK(guide.place < 1e-6);
  CHECK(guide.others == 0);
  const Mechanism cross = models::hinge(0.1, 3.5e-4, {{1, 0.0125, 0.02}, {-1, -0.0125, 0.02}});
  const Errors hinge = compare(cross, sweep(side * M_PI / 6, 7));
  CHECK(hinge.stress < 3e-3);
  CHECK(hinge.place < 1e-6);
  const Errors wide =
      compare(models::three_leaf_hinge(0.06, 0.06, 2.5e-4), sweep(side * M_PI / 6, 7));
  CHECK(wide.stress < 3e-3);
}

TEST_CASE("shapes from tables are those of full leaves") {
  StrokeRequest request = sweep(0.02, 3);
  request.outputs = {Output::equilibrium, Output::shapes};
  const Mechanism guide = models::guide(0.1, 0.03, 5e-4);
  const StrokeResponse found = evaluate_stroke(guide, {}, request),
                       truth = test::evaluated(guide, test::full(), request);
  for (std::size_t k = 0; k < truth.path.size(); ++k) {
    REQUIRE(found.path[k].leaves[0].reason.empty());
    const LeafShape &a = found.path[k].shapes[0], &b = truth.path[k].shapes[0];
    REQUIRE(a.points_along == b.points_along);
    REQUIRE(a.deflected.size() == b.deflected.size());
    const double largest = *std::max_element(b.von_mises.begin(), b.von_mises.end());
    for (std::size_t n = 0; n < a.deflected.size(); ++n) {
      CHECK((a.undeflected[n] - b.undeflected[n]).norm() < 1e-12);
      CHECK((a.deflected[n] - b.deflected[n]).norm() < 5e-7);
      CHECK(std::abs(a.von_mises[n] - b.von_mises[n]) < 3e-3 * largest + 1);
    }
  }
}

TEST_CASE("so are the stresses of clamped edges with fillets, under a load") {
  StrokeRequest request = sweep(0.02, 5);
  request.stress.fillet = 5e-4;
  request.loads.constant = {{.force = {0, 0, -3}}};
  const Mechanism guide = models::guide(0.1, 0.03, 5e-4);
  const StrokeResponse found = evaluate_stroke(guide, {}, request),
                       truth = test::evaluated(guide, test::full(), request);
  for (std::size_t k = 1; k < truth.path.size(); ++k) {
    const StressPeak &a = *found.path[k].notch_stress, &b = *truth.path[k].notch_stress;
    CHECK(a.value == Approx(b.value).epsilon(3e-3));
    CHECK(a.per_bending == Approx(b.per_bending).epsilon(5e-3));
    CHECK(a.value > found.path[k].max_stress->value);
    CHECK(found.path[k].max_stress->value == Approx(truth.path[k].max_stress->value).epsilon(3e-3));
  }
}

TEST_CASE("where the tables of stress do not hold the leaf is rebuilt and says so") {
  const auto model = tube({0.3, 0.005, 0.3, {10, 4}, true});
  REQUIRE(model->stress());
  const Vector3d none = Vector3d::Zero();
  CHECK(model->stress()->evaluate({0, 0, 0, none}).change == 0);
  CHECK(model->stress()->evaluate({0.1, 0, 0, none}).change == 0);  // a bent state itself
  CHECK(model->stress()->evaluate({0.17, 0, 0, none}).change < largest_stress_change);
  CHECK(model->stress()->evaluate({0.02, 0, 0.15, none}).change > largest_stress_change);
}
