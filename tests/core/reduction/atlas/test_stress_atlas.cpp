// Tables of stress in an atlas: looked up against those of the leaf itself, and in a mechanism.
#include "core/math/work_count.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"
#include "core/reduction/atlas/stress_atlas.hpp"
#include "core/reduction/tube/tube_leaf.hpp"
#include "support/small_atlas.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

AtlasSettings small_box() {
  AtlasSettings s = test::small_settings();
  s.rays = {-1, 0, 1};
  return s;
}

std::shared_ptr<const TubeAtlas> stressed_atlas() {
  static const auto kept =
      test::kept_atlas("stress", small_box(), test::checked({2, 2}, {1, -0.4}));
  return kept;
}

ModelOptions by_atlas() { return {.mesh = {4, 2}, .atlas = stressed_atlas()}; }

TubeModel looked_up(const PlateShape& shape, const Eigen::Vector2d& ray) {
  const TubeAtlas& atlas = *stressed_atlas();
  const TubeAtlas::Tube tube = atlas.look_up(shape, ray);
  return TubeModel(shape, {.sigma_max = 0.2},
                   KnownTube{tube.directions,
                             tube.nodes,
                             {},
                             TubeAtlas::view(ray),
                             [&, shape, ray](double) { return atlas.look_up_stress(shape, ray); },
                             atlas.stress()->patterns()});
}

}  // namespace

TEST_CASE("stress that is looked up is that of the leaf itself, on every ray and from both ends") {
  const PlateShape shape{0.33, 1.0 / 190, 0.306, {4, 2}, true};
  const auto ray = GENERATE(Eigen::Vector2d(1, 1), Eigen::Vector2d(1, -1), Eigen::Vector2d(1, 0.3),
                            Eigen::Vector2d(0.3, 1), Eigen::Vector2d(0.45, -1));
  TubeModel model = looked_up(shape, ray);
  const long long before = counted_iterations();
  REQUIRE(model.stress());
  CHECK(counted_iterations() == before);  // no bent state had to be solved for
  // the same leaf, its bent states solved about the same directions
  const Eigen::Matrix2d D = model.potential().ray();
  TubeStress truth(shape, 0);
  ChordLeaf leaf(std::make_shared<PlateMesh>(shape));
  for (const double sigma : small_box().sigmas) {
    REQUIRE(leaf.solve({D(0, 0) * sigma, D(1, 0) * sigma, 0}, Vector3d::Zero()).converged);
    truth.add(stress_node(leaf, sigma, D, expand_fields(leaf, D, 2).fields));
  }
  for (const TubeStress::Place& at : {TubeStress::Place{0.13, 0, 0, Vector3d::Zero()},
                                      TubeStress::Place{0.13, 0.01, 0.004, {1, 0.6, -0.2}},
                                      TubeStress::Place{-0.08, 0.01, 0.004, {-1, 0.1, 0.4}}}) {
    const TubeStress::Answer answer = model.stress()->evaluate(at), exact = truth.evaluate(at);
    const StrainField &found = answer.strains, &real = exact.strains;
    // a bound where it is enough, else the change itself
    CHECK(answer.change > 0.97 * exact.change - 1e-4);
    if (answer.change > largest_stress_change)
      CHECK(answer.change == Approx(exact.change).epsilon(0.03));
    const StressPeak a = plate_stress(found, shape, 1, 0).largest(),
                     b = plate_stress(real, shape, 1, 0).largest();
    CHECK(a.value == Approx(b.value).epsilon(3e-3));
    for (const double x : {0.02, 0.4, 0.9})
      for (const double y : {-0.15, 0.1}) {
        const SectionStress s = section_stress(shape, found.at(x, y), 1),
                            t = section_stress(shape, real.at(x, y), 1);
        for (const double side : {1.0, -1.0})
          CHECK(std::abs(von_mises(s, side) - von_mises(t, side)) < 1e-2 * b.value);
      }
    // places, each seen from the edge that the tables call the base
    const bool from_tip = model.stress()->view().from_tip;
    const Vector3d origin = from_tip ? truth.material_point(at, 1, 0.5) : Vector3d(0, 0, 0);
    const Vector3d p = model.stress()->material_point(at, 0.3, 0.2),
                   q = truth.material_point(at, 0.3, 0.2) - origin;
    CHECK((p - q).norm() < 1e-3);
  }
}

TEST_CASE("patterns carry the stress of leaves of every shape and ray", "[slow]") {
  const AtlasSettings box;
  StressAtlasSettings settings = stress_settings(box);
  CHECK(settings.rays == std::vector<double>{-1, -0.38, 0, 0.38, 1});  // by nearly equal angles
  const auto patterns = std::make_shared<StrainPatterns>(find_patterns(settings));
  struct Leaf {
    double width, thickness, poissons_ratio, rho;
  };
  for (const Leaf& leaf : {Leaf{0.13, 1.0 / 60, 0.27, 1}, Leaf{0.4, 1.0 / 150, 0.33, -1},
                           Leaf{0.9, 1.0 / 450, 0.29, 0.3}, Leaf{2.1, 1.0 / 250, 0.34, -0.6}}) {
    const PlateShape shape{leaf.width, leaf.thickness, leaf.poissons_ratio, settings.mesh, true};
    TubeStress found(shape, 0, {}, patterns), truth(shape, 0);
    for (StateTable& node : bent_states(shape, {1, leaf.rho}, ray_directions(leaf.rho),
                                        settings.sigmas, {.stress = true})
                                .stress) {
      found.add(patterns->coefficients(node, shape.thickness));
      truth.add(std::move(node));
    }
    for (const TubeStress::Place& at : {TubeStress::Place{0.05, 0, 0, Vector3d::Zero()},
                                        TubeStress::Place{0.5, 0.02, 0.003, {1, 0.5, -0.3}}}) {
      const StrainField a = found.evaluate(at).strains, b = truth.evaluate(at).strains;
      const Eigen::ArrayXd thickness = Eigen::ArrayXd::Constant(b.values().rows(), shape.thickness);
      const auto stresses = [&](const MatrixXd& strains) {
        return surface_stresses(strains, thickness, shape.poissons_ratio, 1).positive;
      };
      INFO(leaf.width);
      CHECK(stresses(a.values() - b.values()).maxCoeff() <
            2.5e-3 * stresses(b.values()).maxCoeff());
      CHECK((found.nodes(at)[30] - truth.nodes(at)[30]).norm() < 2e-4);
      CHECK(plate_stress(a, shape, 1, 0).largest().value ==
            Approx(plate_stress(b, shape, 1, 0).largest().value).epsilon(6e-4));
    }
  }
}

TEST_CASE("patterns come back from their bytes in single precision") {
  const StressAtlas& atlas = *stressed_atlas()->stress();
  const AtlasPart part = pack(*atlas.patterns());
  const auto again = unpack_patterns(atlas.settings(), part);
  for (int f = 0; f < StrainPatterns::families; ++f) {
    const MatrixXd &P = atlas.patterns()->P(f), &Q = again->P(f);
    REQUIRE(P.size() == Q.size());
    CHECK((P - Q).norm() < 1e-7 * P.norm());
    CHECK(P.norm() > 0);
  }
}

TEST_CASE("an atlas tells the errors of its stress, and mechanisms with it solve no leaf") {
  const AtlasCheck& check = stressed_atlas()->check();
  for (const AtlasCheck::Ray& ray : check.rays) {
    CHECK(ray.largest().stress < 5.5e-3);
    CHECK(ray.median().stress > 1e-7);
  }
  const StrokeRequest request{.points = {0, 0.005, 0.012},
                              .outputs = {Output::equilibrium, Output::stress}};
  const Mechanism guide = models::guide(0.1, 0.03, 5e-4, 0.1);
  const StrokeResponse built = evaluate_stroke(guide, {.mesh = {4, 2}}, request),
                       found = evaluate_stroke(guide, by_atlas(), request);
  for (std::size_t k = 1; k < found.path.size(); ++k) {
    CHECK(found.path[k].leaves[0].source == "atlas");
    CHECK(found.path[k].leaves[0].reason.empty());
    const StressPeak &a = *found.path[k].max_stress, &b = *built.path[k].max_stress;
    CHECK(a.value == Approx(b.value).epsilon(3e-3));
    CHECK((a.position - b.position).norm() < 1e-4);
  }
}

TEST_CASE("a looked-up leaf is stressed the same whichever edge is called its base") {
  Mechanism one = models::hinge(0.08, 4e-4, {{1, 0.0125, 0.025}, {-1, -0.0125, 0.025}});
  for (LeafSpring& leaf : one.leaves) leaf.origin += 0.15 * leaf.length * leaf.axes.col(0);
  Mechanism other = one;
  for (LeafSpring& leaf : other.leaves) leaf = models::turned(leaf);
  StrokeRequest request{.points = {0, 0.1, -0.12},
                        .outputs = {Output::equilibrium, Output::stress}};
  request.loads.constant = {{.force = {3, 2, 1}}};
  const StrokeResponse a = evaluate_stroke(one, by_atlas(), request),
                       b = evaluate_stroke(other, by_atlas(), request);
  for (std::size_t k = 0; k < request.points.size(); ++k) {
    for (const LeafReport& leaf : b.path[k].leaves) CHECK(leaf.reason.empty());
    CHECK(b.path[k].max_stress->value == Approx(a.path[k].max_stress->value).epsilon(1e-8));
  }
}
