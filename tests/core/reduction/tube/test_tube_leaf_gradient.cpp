#include "core/reduction/tube/tube_leaf_gradient.hpp"

#include "support/held_leaf.hpp"
#include "support/slopes.hpp"

using namespace flexopt;
using namespace flexopt::held;
using flexopt::synthetic::Random;

namespace {

// Coefficients that are known functions of the shape: those of the synthetic potential, each with
// slopes of its own.
struct KnownTubes {
  Eigen::Matrix2d D = synthetic::skew_ray();
  Vector3d about{0.5, 0.02, 0.3};  ///< w/L, t/L, ν
  std::vector<double> sigmas{0, 0.1, 0.3};

  Vector3d slopes(std::size_t term) const {
    const auto k = static_cast<double>(term);
    return {std::sin(k + 1), std::cos(2 * k), std::sin(3 * k - 1)};
  }
  std::vector<TubeNode> nodes(const Vector3d& shape) const {
    std::vector<TubeNode> all;
    const Vector3d d = (shape - about).cwiseQuotient(about);
    for (const double sigma : sigmas) {
      TubeNode& node = all.emplace_back(synthetic::node<5>(D, sigma));
      for (std::size_t i = 0; i < node.W.size(); ++i)
        node.W[i] *= (1 + 0.3 * slopes(i).dot(d)) / synthetic::EI_over_L;
    }
    return all;
  }
  TubeNodeRates rates() const {
    TubeNodeRates all(3);
    for (int p = 0; p < 3; ++p)
      for (const double sigma : sigmas) {
        TubeNode& node =
            all[static_cast<std::size_t>(p)].emplace_back(synthetic::node<5>(D, sigma));
        for (std::size_t i = 0; i < node.W.size(); ++i)
          node.W[i] *= 0.3 * slopes(i)[p] / about[p] / synthetic::EI_over_L;
      }
    return all;
  }
  std::shared_ptr<TubeModel> model(const PlateShape& shape) const {
    const Vector3d at(shape.width, shape.thickness, shape.poissons_ratio);
    return std::make_shared<TubeModel>(
        shape, TubeRange{}, KnownTube{D, nodes(at), {}, {}, {}, {}, [this] { return rates(); }});
  }
};

// From rest in steps, the forces balanced.
std::unique_ptr<TubeLeaf> bent(const Design& d, const KnownTubes& known) {
  auto leaf = std::make_unique<TubeLeaf>(d.leaf, known.model(leaf_shape(d.leaf, {})), 0);
  leaf->evaluate();
  EdgePoses now = edges(d, 0);
  for (int s = 1; s <= 8; ++s)
    for (int i = 0; i < 6; ++i) {
      const EdgePoses next = edges(d, s / 8.0);
      Vector12d dq;
      for (int e = 0; e < 2; ++e)
        dq.segment<6>(6 * e) << next[e].position - now[e].position,
            rotation_log(next[e].axes * now[e].axes.transpose());
      leaf->move(next, dq);
      leaf->evaluate();
      now = next;
    }
  return leaf;
}

// Force on the bodies, and yᵀK y with the internal forces where they are stationary.
std::vector<double> answer(const Design& d, const KnownTubes& known, const MatrixXd& Y) {
  const auto leaf = bent(d, known);
  const EdgePoses now = edges(d, 1);
  const Matrix12d map = edge_map(d, now);
  const VectorXd force = map.transpose() * leaf->evaluation().force;
  std::vector<double> all(force.begin(), force.end());
  for (int k = 0; k < Y.cols(); ++k) {
    const Vector12d y = map * Y.col(k);
    double q = y.dot(leaf->evaluation().tangent * y);
    for (int e = 0; e < 2; ++e) {  // the lever arms turn
      const Vector3d w = Y.block<3, 1>(6 * e + 3, k),
                     arm = now[e].position - d.reference[e] - d.displacement[e];
      q += leaf->evaluation().force.segment<3>(6 * e).dot(w.cross(w.cross(arm)));
    }
    all.push_back(q);
  }
  return all;
}

}  // namespace

TEST_CASE("rates of a tube are those of its potential, along the state and along the shape") {
  Random random(3);
  const KnownTubes known;
  const PlateShape shape = leaf_shape(models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.05, 2e-3), {});
  const auto model = known.model(shape);
  const TubePotential& tube = model->potential();
  const TubeRates rates(tube, known.rates());
  TubeNodeRates as_potentials = known.rates();
  for (int i = 0; i < 12; ++i) {
    const double sigma = std::array{0.05, 0.2, 0.35, -0.2}[static_cast<std::size_t>(i % 4)];
    Vector3d s;
    const Vector3d f = random.vector<3>(0.5);
    s << known.D * Eigen::Vector2d(sigma + random(0.03), random(0.05)), random(0.05);
    const TubeRates::Answer answer = rates.evaluate(s, f);
    const auto equal = [&](const PotentialValue& a, const PotentialValue& b) {
      const double size = b.hessian.cwiseAbs().maxCoeff();
      CHECK(std::abs(a.value - b.value) < 1e-12 * size);
      CHECK((a.gradient - b.gradient).cwiseAbs().maxCoeff() < 1e-12 * size);
      CHECK((a.hessian - b.hessian).cwiseAbs().maxCoeff() < 1e-11 * size);
    };
    equal(answer.potential, tube.evaluate(s, f));
    for (std::size_t p = 0; p < 3; ++p)
      equal(answer.by_shape[p],
            TubePotential(known.D, tube.force_scale(), 5, as_potentials[p]).evaluate(s, f));
    const double size = answer.potential.hessian.cwiseAbs().maxCoeff();
    for (std::size_t k = 0; k < 6; ++k) {
      const auto at = [&](double h) {
        Vector6d z;
        z << s, f;
        z[static_cast<Eigen::Index>(k)] += h;
        return Matrix6d(tube.evaluate(z.head<3>(), z.tail<3>()).hessian);
      };
      const Matrix6d slope = test::slope_at_zero(at, 1e-3);
      CHECK((answer.third[k] - slope).cwiseAbs().maxCoeff() < 1e-7 * size);
      for (std::size_t j = 0; j < k; ++j)  // and they commute
        CHECK((answer.third[k].col(static_cast<Eigen::Index>(j)) -
               answer.third[j].col(static_cast<Eigen::Index>(k)))
                  .cwiseAbs()
                  .maxCoeff() < 3e-11 * size);
    }
  }
}

TEST_CASE("derivatives of a looked-up tube leaf agree with differences") {
  const KnownTubes known;
  for (const unsigned seed : {7u, 11u}) {
    Random random(seed);
    const Design design =
        random_design(models::leaf({0.3, -0.2, 0.1}, {2, 1, 0}, 0.1, 0.05, 2e-3), random);
    const double L = design.leaf.length;
    const auto at = bent(design, known);
    CHECK(at->evaluation().correction < 1e-12);
    CHECK(at->check_interior({}));
    const auto linear = at->linearise();
    REQUIRE(linear);
    LeafRows rows;
    rows.unknowns = (*linear)->unknowns();
    const EdgePoses now = edges(design, 1);
    for (int e = 0; e < 2; ++e)
      rows.lever[e] = design.leaf.axes.transpose() *
                      (now[e].position - design.reference[e] - design.displacement[e]) / L;
    LeafRates rates;
    const auto gradient = (*linear)->gradient(rates, rows);
    REQUIRE(gradient);

    MatrixXd Y(12, 3), y = MatrixXd::Zero(rows.size(), 3);
    const MatrixXd shapes = (*linear)->static_shapes({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 12; i += 3) {
        Y.block<3, 1>(i, k) = random.vector<3>(i % 6 == 0 ? L : 1.0);
        y.block<3, 1>(rows.internal() + i, k) =
            design.leaf.axes.transpose() * Y.block<3, 1>(i, k) / (i % 6 == 0 ? L : 1.0);
      }
      y.col(k).head(rows.unknowns) = shapes * rows.edge_rows(y.col(k)).bottomRows(12);
    }
    check_derivatives({design, Flexure::plate, **linear, **gradient, rows, y, VectorXd::Zero(3),
                       [&](const Design& d) { return answer(d, known, Y); }},
                      random);
  }
}

TEST_CASE("a tube that was built has no exact derivatives of its own") {
  const KnownTubes known;
  const PlateShape shape = leaf_shape(models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.05, 2e-3), {});
  TubeLeaf leaf(models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.05, 2e-3),
                std::make_shared<TubeModel>(shape, TubeRange{},
                                            KnownTube{known.D, known.nodes(known.about), {}, {}}),
                0);
  leaf.evaluate();
  CHECK_FALSE(leaf.check_interior({}));
  CHECK_FALSE(leaf.linearise());
}
