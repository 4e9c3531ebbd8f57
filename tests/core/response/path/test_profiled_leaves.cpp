// Mechanisms with leaves of varying width and thickness, against beam theory and each other.
#include <functional>
#include <string_view>

#include "core/mechanism/profile.hpp"
#include "support/strokes.hpp"

using namespace flexopt;
using models::sampled;

namespace {

using Profile = std::function<double(double)>;

// ∫ f ds over [0, 1].
double integral(const Profile& f) {
  double sum = 0;
  constexpr int parts = 20000;
  for (int k = 0; k < parts; ++k) sum += f((k + 0.5) / parts) / parts;
  return sum;
}

ModelOptions model_of(Accuracy accuracy, Flexure flexure) {
  return {.accuracy = accuracy, .flexure = flexure};
}

StrokeResponse evaluated(const Mechanism& m, const ModelOptions& model, std::vector<double> points,
                         int frequencies = 0) {
  REQUIRE(check_rules(m));
  return test::evaluated(m, model, {.points = std::move(points), .frequencies = frequencies});
}

void compare(const StrokeResponse& a, const StrokeResponse& b, double tolerance) {
  REQUIRE(a.path.size() == b.path.size());
  for (std::size_t i = 0; i < a.path.size(); ++i) {
    const PathPoint &p = a.path[i], &q = b.path[i];
    CHECK(p.drive_load == Approx(q.drive_load).epsilon(tolerance).margin(1e-6));
    CHECK(p.drive_stiffness == Approx(q.drive_stiffness).epsilon(tolerance));
    for (int d = 0; d < 6; ++d)
      if (p.support_stiffness[d] && q.support_stiffness[d])
        CHECK(*p.support_stiffness[d] == Approx(*q.support_stiffness[d]).epsilon(tolerance));
    CHECK((p.displacement - q.displacement).norm() <= tolerance * 0.01);
    CHECK(test::frequency_error(p.frequencies_locked, q.frequencies_locked) < tolerance);
    if (i > 0) CHECK(p.max_stress->value == Approx(q.max_stress->value).epsilon(10 * tolerance));
  }
}

Mechanism tapered_guide() {
  Mechanism m = models::guide(0.1, 0.03, 0.5e-3);
  for (LeafSpring& l : m.leaves) {
    l.width_profile = {1, 0.6};
    l.thickness_profile = {1, 1.3};
  }
  return m;
}

}  // namespace

TEST_CASE("a tapered beam has the compliance of its integral x² / EI") {
  const double L = 0.1, w = 0.01, t = 1e-3;
  Mechanism m = models::single_leaf(L, w, t);
  m.leaves[0].width_profile = {1, 0.3};
  m.leaves[0].thickness_profile = {1, 0.5};
  const auto EI = [&](double s) {
    return 200e9 * w * (1 - 0.7 * s) * std::pow(t * (1 - 0.5 * s), 3) / 12;
  };
  const double compliance =
      L * L * L * integral([&](double s) { return (1 - s) * (1 - s) / EI(s); });
  const StrokeResponse r = evaluated(m, model_of(Accuracy::full, Flexure::beam), {0});
  CHECK(r.path[0].drive_stiffness * compliance == Approx(1).epsilon(1e-3));
}

TEST_CASE("a notch hinge has the rotational stiffness of its integral 1 / EI") {
  // parabola, circle, ellipse, corner fillets, power function
  const double L = 0.01, w = 0.01;
  struct Notch {
    const char* name;
    double thinnest;
    Profile over;  // thickness over the thinnest
  };
  const auto root = [](double x) { return std::sqrt(std::max(0.0, x)); };
  const std::vector<Notch> notches{
      {"parabola", 1e-3, [](double s) { return 1 + 4 * 5 * (s - 0.5) * (s - 0.5); }},
      {"circle", 1e-3,
       [&](double s) { return 1 + 10 * (1 - root(1 - (2 * s - 1) * (2 * s - 1))); }},
      {"ellipse", 0.5e-3,
       [&](double s) { return 1 + 8 * (1 - root(1 - (2 * s - 1) * (2 * s - 1))); }},
      {"corner filleted", 0.5e-3,
       [&](double s) {
         const double r = 0.2, d = std::max({0.0, r - s, s - (1 - r)});
         return 1 + 2 * 20 * (r - root(r * r - d * d));
       }},
      {"power function", 1e-3, [](double s) { return 1 + 10 * std::pow(std::abs(2 * s - 1), 4); }}};
  for (const Notch& notch : notches) {
    INFO(notch.name);
    Mechanism m = models::single_leaf(L, w, notch.thinnest, Direction::rz);
    m.leaves[0].thickness_profile = sampled(notch.over);
    const double compliance =
        L * integral([&](double s) {
          return 12 / (200e9 * w * std::pow(notch.thinnest * notch.over(s), 3));
        });
    const StrokeResponse r = evaluated(m, model_of(Accuracy::full, Flexure::beam), {0, 1e-3});
    CHECK(r.path[0].drive_stiffness * compliance == Approx(1).epsilon(1e-3));
    // bending stress at the thinnest place
    const double stress =
        6 * std::abs(r.path[1].drive_load) / (w * notch.thinnest * notch.thinnest);
    CHECK(r.path[1].max_stress->value == Approx(stress).epsilon(0.02));
    if (std::string_view(notch.name) != "corner filleted")
      CHECK(r.path[1].max_stress->along == Approx(0.5).margin(0.02));
  }
}

TEST_CASE("two leaves in series are one leaf") {
  const double L = 0.1, w = 0.008, t = 0.6e-3;
  const auto along = [](double s) { return 1 + 0.4 * std::cos(3 * s); };
  Mechanism whole = models::single_leaf(L, w, t);
  whole.bodies[0].mass = 0.1;
  whole.bodies[0].inertia = 1e-5 * Matrix3d::Identity();
  whole.leaves[0].thickness_profile = sampled(along);
  Mechanism halves = whole;
  halves.bodies.push_back(models::body({L / 2, 0, 0}, 0, 0));
  halves.leaves = {models::between(ground, 1, models::leaf({0, 0, 0}, {1, 0, 0}, L / 2, w, t)),
                   models::between(1, 0, models::leaf({L / 2, 0, 0}, {1, 0, 0}, L / 2, w, t))};
  for (int k = 0; k < 2; ++k)
    halves.leaves[k].thickness_profile = sampled([&](double s) { return along(0.5 * (k + s)); });
  ModelOptions model = model_of(Accuracy::full, Flexure::beam);
  model.warping = Warping::free;
  model.mesh = {16, 1};
  const StrokeResponse a = evaluated(whole, model, {0, 0.02}, 3),
                       b = evaluated(halves, model, {0, 0.02}, 3);
  compare(a, b, 2e-3);
}

TEST_CASE("a turned leaf with the mirrored profile gives the same answer") {
  const auto width = [](double s) { return 1 - 0.4 * s + 0.1 * s * s; };
  const auto thickness = [](double s) { return 1 + 0.8 * s * s; };
  for (const Flexure flexure : {Flexure::plate, Flexure::beam}) {
    Mechanism m = models::guide(0.1, 0.03, 0.5e-3);
    for (LeafSpring& l : m.leaves) {
      l.width_profile = sampled(width);
      l.thickness_profile = sampled(thickness);
    }
    Mechanism turned = m;
    for (LeafSpring& l : turned.leaves) {
      l.origin = l.tip_middle();
      l.axes.col(0) *= -1;
      l.axes.col(2) *= -1;
      std::swap(l.base, l.tip);
      l.width_profile = sampled([&](double s) { return width(1 - s); });
      l.thickness_profile = sampled([&](double s) { return thickness(1 - s); });
    }
    ModelOptions model = model_of(Accuracy::full, flexure);
    model.mesh = {6, 2};
    compare(evaluated(m, model, {0, 0.01}, 3), evaluated(turned, model, {0, 0.01}, 3), 1e-6);
  }
}

TEST_CASE("the default method follows the full tapered leaf") {
  const Mechanism m = tapered_guide();
  const std::vector<double> points{0, 0.005, 0.01};
  const StrokeResponse full = evaluated(m, model_of(Accuracy::full, Flexure::plate), points, 4),
                       tube = evaluated(m, model_of(Accuracy::reduced, Flexure::plate), points, 4);
  for (const LeafReport& leaf : tube.path[1].leaves) CHECK(leaf.model == "tube");
  compare(full, tube, 0.01);
}

TEST_CASE("a narrow tapered plate without Poisson effect bends as the beam") {
  Mechanism m = models::single_leaf(0.1, 4e-3, 0.3e-3, Direction::uy, models::without_poisson());
  m.leaves[0].width_profile = {1, 0.4};
  m.leaves[0].thickness_profile = {1, 1.4};
  const StrokeResponse plate = evaluated(m, model_of(Accuracy::full, Flexure::plate), {0, 0.02}),
                       beam = evaluated(m, model_of(Accuracy::full, Flexure::beam), {0, 0.02});
  for (int i = 0; i < 2; ++i)
    CHECK(plate.path[i].drive_stiffness == Approx(beam.path[i].drive_stiffness).epsilon(2e-3));
  CHECK(plate.path[1].max_stress->value == Approx(beam.path[1].max_stress->value).epsilon(0.03));
}

TEST_CASE("methods that take uniform leaves alone leave profiles to the full leaf") {
  const Mechanism m = tapered_guide();
  for (const Reduction method : {Reduction::linear_craig_bampton, Reduction::modal_derivatives}) {
    ModelOptions model = model_of(Accuracy::reduced, Flexure::plate);
    model.method = method;
    model.mesh = {6, 2};
    const StrokeResponse r = evaluated(m, model, {0});
    for (const LeafReport& leaf : r.path[0].leaves) {
      CHECK(leaf.model == "full");
      CHECK_THAT(leaf.reason, Catch::Matchers::Contains("width or thickness varies"));
    }
  }
}
