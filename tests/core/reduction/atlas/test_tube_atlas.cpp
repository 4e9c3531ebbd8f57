// Tubes that are looked up against tubes that are built, on a coarse mesh and a small box.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/chebyshev.hpp"
#include "core/math/polynomial.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"
#include "core/reduction/tube/tube_leaf.hpp"
#include "support/small_atlas.hpp"

using namespace flexopt;
using test::shape_of;
using test::small_atlas;
using test::small_settings;

namespace {

const MonomialTable& table() { return monomials<6, atlas_degree>(); }

std::vector<double> expansion(const PlateShape& shape, const Eigen::Vector2d& ray,
                              const Eigen::Matrix2d& D, double sigma) {
  const auto nodes = bent_states(shape, ray, D, {0, sigma}).nodes;
  REQUIRE(nodes.size() == 2);
  return nodes[1].W;
}

std::vector<double> expansion(const PlateShape& shape, double rho, double sigma) {
  return expansion(shape, {1, rho}, ray_directions(rho), sigma);
}

// Largest difference to a degree over the largest coefficient, of those that the mirror across the
// width allows.
double distance(const std::vector<double>& a, const std::vector<double>& b, int degree) {
  double worst = 0, size = 0;
  for (const int term : atlas_terms(0.1)) {
    if (table().degree(term) > degree) continue;
    const auto k = static_cast<std::size_t>(term);
    size = std::max(size, std::abs(b[k]));
    worst = std::max(worst, std::abs(a[k] - b[k]));
  }
  REQUIRE(size > 0);
  return worst / size;
}

}  // namespace

TEST_CASE("polynomials of the degree of their points are interpolated exactly, and so are slopes") {
  const std::vector<double> x = chebyshev_points(-2, 1, 6);
  CHECK(x.front() == -2);
  CHECK(x.back() == 1);
  const auto f = [](double t) { return 1 - t + 0.3 * t * t * t * t * t; };
  const auto slope = [](double t) { return -1 + 1.5 * t * t * t * t; };
  for (const double t : {-2.0, -1.3, 0.2, x[2], 1.0}) {
    const PointWeights w = polynomial_weights(x, t);
    double value = 0, rate = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
      value += w.value[k] * f(x[k]);
      rate += w.slope[k] * f(x[k]);
    }
    CHECK(value == Approx(f(t)).margin(1e-13));
    CHECK(rate == Approx(slope(t)).margin(1e-12));
  }
  CHECK(polynomial_weights(x, x[3]).value == std::vector<double>{0, 0, 0, 1, 0, 0});
}

TEST_CASE("a leaf is bent in smaller steps where one does not lead there") {
  ChordLeaf leaf(std::make_shared<PlateMesh>(shape_of(0.3, 1.0 / 200)));
  CHECK(bend(leaf, {1, 0.5}, 0, 0.3) == 0.3);
  CHECK(leaf.soft()[0] == 0.3);
  CHECK(leaf.soft()[1] == 0.15);
  const VectorXd there = leaf.unknowns();
  // nothing to do, and back: the state is a matter of place alone
  CHECK(bend(leaf, {1, 0.5}, 0.3, 0.3) == 0.3);
  CHECK(bend(leaf, {1, 0.5}, 0.3, 0.05) == 0.05);
  CHECK(bend(leaf, {1, 0.5}, 0.05, 0.3) == 0.3);
  CHECK((leaf.unknowns() - there).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("an expansion knows how it changes when its ray turns") {
  const PlateShape shape = shape_of(0.3, 1.0 / 90);
  const double sigma = 0.1, rho = 0.35, h = 2e-3;
  const auto at = [&](double r) { return expansion(shape, r, sigma); };
  const auto W = at(rho), more = at(rho + h), less = at(rho - h);
  std::vector<double> first(W.size()), second(W.size());
  for (std::size_t k = 0; k < W.size(); ++k) {
    first[k] = (more[k] - less[k]) / (2 * h);
    second[k] = (more[k] - 2 * W[k] + less[k]) / (h * h);
  }
  const RayRates rates = ray_rates(W, sigma, rho);
  // h² of the differences
  CHECK(distance(rates.first, first, atlas_degree - 1) < 2e-4);
  CHECK(distance(rates.second, second, atlas_degree - 2) < 2e-4);
}

TEST_CASE("between two rays the expansion has the order of their derivatives") {
  const PlateShape shape = shape_of(0.3, 1.0 / 90);
  const double sigma = 0.1, rho = 0.4;
  const auto at = [&](double r) { return expansion(shape, r, sigma); };
  const auto truth = at(rho);
  const auto error = [&](double h, int degree) {
    return distance(between_rays(at(rho - h), rho - h, at(rho + h), rho + h, sigma, rho), truth,
                    degree);
  };
  CHECK(between_rays(truth, rho, at(0.5), 0.5, sigma, rho) == truth);
  // sixth and fourth order; at half the distance 2⁻⁶ and 2⁻⁴
  CHECK(error(0.1, 3) < 2.5 / 64 * error(0.2, 3));
  CHECK(error(0.1, 4) < 2.5 / 16 * error(0.2, 4));
}

TEST_CASE("between two rays a table has the order of the derivatives that its degrees tell") {
  // f(θ1y, θ2y) (1 + N), f = sin(3 θ1y + 4 θ2y), about σ of a ray
  const double sigma = 0.3, rho = 0.4;
  const bool of_stress = GENERATE(false, true);
  const auto table = [&](double r) {
    const double at = (3 + 4 * r) * sigma;
    const std::array<double, 4> taylor{std::sin(at), std::cos(at), -std::sin(at) / 2,
                                       -std::cos(at) / 6};
    StateTable t{
        sigma,
        MatrixXd::Zero(1, of_stress ? StateTable::even_of_stress : StateTable::even_monomials),
        MatrixXd::Zero(1, StateTable::odd_monomials)};
    for (Eigen::Index k = 0; k < t.even.cols(); ++k) {
      const StateMonomial& m =
          even_monomials<StateTable::even_of_stress>()[static_cast<std::size_t>(k)];
      int tau = 0, force = 0, others = 0;
      for (int f = 0; f < m.off_ray; ++f)
        ++(m.variable[f] == 0 ? tau : m.variable[f] == 2 ? force : others);
      if (force > 1 || others > 0) continue;
      const int n = m.along + tau;  // σ^along τ^tau of (d1 σ + d2 τ)^n
      double binomial = 1;
      for (int i = 0; i < tau; ++i) binomial *= static_cast<double>(n - i) / (i + 1);
      t.even(0, k) = taylor[static_cast<std::size_t>(n)] * binomial * std::pow(3 + 4 * r, m.along) *
                     std::pow(4 - 3 * r, tau);
    }
    return t;
  };
  const StateTable truth = table(rho);
  const auto error = [&](double h, int column) {
    const RayBlend blend = blend_between_rays(rho - h, rho + h, sigma, rho);
    return std::abs(blended(table(rho - h), table(rho + h), blend).even(0, column) -
                    truth.even(0, column));
  };
  // 1, σ, τ, N, σ², στ, σN, τ²; of each degree a derivative more is known than of the next one
  const auto order = [&](int column) {
    return std::log2(error(0.1, column) / error(0.05, column));
  };
  const int more = of_stress ? 2 : 0;
  CHECK(order(0) > 5.7);
  for (const int column : {1, 2}) CHECK(order(column) > 3.7 + more);
  CHECK(order(3) > 3.7);
  for (const int column : {4, 5, 7}) CHECK(order(column) > 1.7 + more);
  CHECK(order(6) > 1.7);
}

TEST_CASE("a leaf seen from its other end has the potential of the mirrored ray") {
  const PlateShape shape = shape_of(0.3, 1.0 / 90);
  const double sigma = 0.12;
  for (const double rho : {0.4, -0.4}) {
    const auto W = expansion(shape, rho, sigma);
    for (const bool same : {true, false}) {
      Eigen::Matrix2d D = ray_directions(rho);
      D.row(0).swap(D.row(1));
      if (!same) D *= -1;
      const auto other = expansion(shape, D.col(0), D, sigma);
      CHECK(distance(from_other_end(W, same), other, atlas_degree) < 1e-9);
    }
  }
  for (const double rho : {1.0, -1.0}) {
    const auto W = expansion(shape, rho, sigma);
    CHECK(distance(end_for_end(W, rho), W, atlas_degree) < 1e-9);
  }
}

TEST_CASE("an atlas has the built tubes at the shapes of its grid") {
  const TubeAtlas& atlas = *small_atlas();
  const AtlasSettings& s = atlas.settings();
  const auto widths = chebyshev_points(std::log(s.width[0]), std::log(s.width[1]), s.points[0]);
  const auto thicknesses =
      chebyshev_points(std::log(s.thickness[0]), std::log(s.thickness[1]), s.points[1]);
  for (const auto& [i, j, rho] : {std::tuple{0, 0, 1.0}, {2, 1, -0.5}, {3, 2, -1.0}}) {
    const PlateShape shape = shape_of(std::exp(widths[i]), std::exp(thicknesses[j]), 0.28);
    const TubeAtlas::Tube found = atlas.look_up(shape, {1, rho});
    const auto built = bent_states(shape, {1, rho}, found.directions, s.sigmas).nodes;
    REQUIRE(found.nodes.size() == built.size());
    const AtlasCheck::Errors errors =
        difference(tube_potential(shape, found.directions, found.nodes),
                   tube_potential(shape, found.directions, built), shape);
    CHECK(errors.drive < 1e-5);  // whole numbers in units of what counts
    CHECK(errors.on_ray < 3e-4);
    CHECK(errors.off_ray < 3e-4);
  }
}

TEST_CASE("between its shapes and rays an atlas is as exact as its check says") {
  const TubeAtlas& atlas = *small_atlas();
  const AtlasSettings& s = atlas.settings();
  REQUIRE(atlas.check().rays.size() == 4);
  double stated = 0;
  for (const AtlasCheck::Ray& ray : atlas.check().rays) {
    CHECK(ray.samples.size() == 4);
    CHECK(ray.largest().drive > 0);
    CHECK(ray.largest().drive >= ray.median().drive);
    CHECK(ray.largest().drive < 1e-4);  // of this grid
    CHECK(ray.largest().on_ray < 3e-3);
    CHECK(ray.largest().off_ray < 1e-2);
    stated = std::max(stated, ray.largest().on_ray);
  }
  for (const Eigen::Vector2d& ray : {Eigen::Vector2d(1, 1), Eigen::Vector2d(1, -0.3),
                                     Eigen::Vector2d(0.8, 1), Eigen::Vector2d(0.25, -1)}) {
    const PlateShape shape = shape_of(0.31, 1.0 / 190, 0.305);
    const TubeAtlas::Tube found = atlas.look_up(shape, ray);
    CHECK((found.directions.col(0) - ray).norm() < 1e-15);
    const auto built = bent_states(shape, ray, found.directions, s.sigmas).nodes;
    const auto error = difference(tube_potential(shape, found.directions, found.nodes),
                                  tube_potential(shape, found.directions, built), shape);
    CHECK(error.on_ray > 0);
    CHECK(error.on_ray < 2 * stated);
  }
}

TEST_CASE("what an atlas looks up has exact derivatives by the leaf's shape") {
  const TubeAtlas& atlas = *small_atlas();
  const double h = 1e-3;  // the coefficients are sums of large terms: small steps see rounding
  const Vector3d here(0.31, 1.0 / 190, 0.305);
  for (const Eigen::Vector2d& ray : {Eigen::Vector2d(1, -0.3), Eigen::Vector2d(0.4, 1)}) {
    const TubeNodeRates rates = atlas.look_up_rates(shape_of(here[0], here[1], here[2]), ray);
    const TubeNodeRates by_sizes =
        atlas.look_up_rates(shape_of(here[0], here[1], here[2]), ray, 0, ShapeSlopes::sizes);
    CHECK(by_sizes.size() == 2);
    for (std::size_t n = 0; n < rates[0].size(); ++n) {
      CHECK(by_sizes[0][n].W == rates[0][n].W);
      CHECK(by_sizes[1][n].W == rates[1][n].W);
    }
    for (int by = 0; by < 3; ++by) {  // w/L, t/L, ν
      const auto moved = [&](double step) {
        Vector3d shape = here;
        shape[by] *= 1 + step;
        return atlas.look_up(shape_of(shape[0], shape[1], shape[2]), ray).nodes;
      };
      const auto a = moved(h), b = moved(-h), c = moved(2 * h), d = moved(-2 * h);
      REQUIRE(rates[by].size() == a.size());
      for (std::size_t n = 0; n < a.size(); ++n) {
        std::vector<double> difference(a[n].W.size());
        for (std::size_t k = 0; k < difference.size(); ++k)
          difference[k] =
              (8 * (a[n].W[k] - b[n].W[k]) - (c[n].W[k] - d[n].W[k])) / (12 * h * here[by]);
        CHECK(rates[by][n].sigma == a[n].sigma);
        for (int degree = 2; degree <= atlas_degree; ++degree)
          CHECK(distance(rates[by][n].W, difference, degree) < 1e-9);
      }
    }
  }
}

TEST_CASE("an atlas says which leaves it does not have") {
  const TubeAtlas& atlas = *small_atlas();
  const TubeRange range{.sigma_max = 0.15};
  const PlateShape inside = shape_of(0.3, 1.0 / 200);
  CHECK(atlas.covers(inside, range));
  CHECK(atlas.covers(shape_of(0.25, 1.0 / 240), range));  // at its edge
  CHECK_FALSE(atlas.covers(shape_of(0.24, 1.0 / 200), range));
  CHECK_FALSE(atlas.covers(shape_of(0.3, 1.0 / 150), range));
  CHECK_FALSE(atlas.covers(shape_of(0.3, 1.0 / 200, 0.33), range));
  CHECK_FALSE(atlas.covers(inside, {.sigma_max = 0.21}));
  CHECK_FALSE(atlas.covers(inside, {.sigma_max = 0.1, .force_centre = 1e-3}));
  CHECK_FALSE(atlas.covers(inside, {.sigma_max = 0.1, .order = 3}));
  const std::initializer_list<void (*)(PlateShape&)> changes{
      [](PlateShape& s) {
        s.mesh = {5, 2};
      },
      [](PlateShape& s) { s.free_edge_torsion = false; },
      [](PlateShape& s) { s.curve = 0.1; },
      [](PlateShape& s) {
        s.thickness_profile = {1, 1.2};
      },
      [](PlateShape& s) { s.flexure = Flexure::beam; },
      [](PlateShape& s) { s.fold = LeafFoldT<double>{.place = 0.5, .angle = 1.5}; }};
  for (const auto change : changes) {
    PlateShape other = inside;
    change(other);
    CHECK_FALSE(atlas.covers(other, range));
  }
}

TEST_CASE("a tube of known states makes fields and further states when they are asked for") {
  const TubeAtlas& atlas = *small_atlas();
  const PlateShape shape = shape_of(0.31, 1.0 / 190);
  const TubeRange range{.sigma_max = 0.12};
  const TubeAtlas::Tube found = atlas.look_up(shape, range.ray);
  TubeModel known(shape, range, KnownTube{found.directions, found.nodes, {}, {}, {}});
  TubeModel built(std::make_shared<PlateMesh>(shape), {.sigma_max = 0.2});
  CHECK(known.known());
  CHECK_FALSE(built.known());
  const Vector3d f(0.1, 0.02, -0.01);
  for (const Vector3d& s :
       {Vector3d(0.1, 0.09, 1e-3), Vector3d(-0.03, -0.04, 0), Vector3d(0.19, 0.18, 0)}) {
    const VectorXd a = known.fields(s, f), b = built.fields(s, f);
    REQUIRE(a.size() == b.size());
    CHECK((a - b).cwiseAbs().maxCoeff() < 2e-5);  // other nodes; steps between them
  }
  REQUIRE(known.extend(0.3));
  CHECK_FALSE(known.known());
  CHECK(known.potential().last_sigma() == 0.3);
  CHECK(known.fields({0.25, 0.25, 0}, f).allFinite());
}
