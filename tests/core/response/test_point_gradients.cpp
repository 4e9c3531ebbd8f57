// Exact derivatives of every quantity at every point against extrapolated differences of the whole
// path, with respect to geometry, material and payload: (26)–(30).
#include <catch2/catch.hpp>

#include <cmath>

#include "core/math/ridders.hpp"
#include "core/response/stroke_gradients.hpp"
#include "tests/support/models.hpp"

using namespace flexopt;

namespace {

struct Parameter {
  const char* name;
  double value;
};
using Values = std::vector<double>;

// Guide or hinge without symmetry, so that every term of the chain counts.
const std::vector<Parameter> parameters{{"length", 0.1},   {"width", 0.03},  {"thickness", 0.5e-3},
                                        {"modulus", 2e11}, {"poisson", 0.3}, {"density", 7800},
                                        {"mass", 0.4},     {"centre", 0.01}, {"inertia", 3e-4},
                                        {"angle", 0.7},    {"shift", 0.004}};

Mechanism skew(bool hinge, const Values& p) {
  const Material material{"steel", p[3], p[4], p[5], {}};
  Mechanism m;
  m.drive = hinge ? Direction::rz : Direction::uy;
  m.bodies = {hinge ? models::body({0.001, 0, 0}, p[6], p[8])
                    : models::body({p[0], 0.001, 0.002}, p[6], p[8])};
  m.bodies[0].center_of_mass += Vector3d(p[7], 0.5 * p[7], 0);
  if (hinge) {
    const double z = 0.8 * p[1];
    for (const models::Crossing& c :
         {models::Crossing{1, z, 0.5 * p[1]}, {-1, 0, p[1]}, {1, -z - p[10], 0.5 * p[1]}}) {
      const Vector3d along(std::cos(p[9]), c.side * std::sin(p[9]), 0);
      m.leaves.push_back(models::leaf(Vector3d(0, 0, c.z) - 0.45 * p[0] * along, along, p[0],
                                      c.width, p[2], material));
    }
  } else {
    for (const double y : {0.03, -0.03}) {
      const Vector3d along(std::cos(0.1 * (p[9] - 0.7)), std::sin(0.1 * (p[9] - 0.7)), 0);
      m.leaves.push_back(models::leaf({0, y + p[10] * y, 0}, along, p[0], p[1], p[2], material));
    }
  }
  return m;
}

// Every number that may move, to write its rate in its place.
std::vector<double*> numbers(Mechanism& m) {
  std::vector<double*> all;
  for (LeafSpring& l : m.leaves) {
    for (int i = 0; i < 3; ++i) all.push_back(&l.origin[i]);
    for (int i = 0; i < 9; ++i) all.push_back(l.axes.data() + i);
    for (double* x : {&l.length, &l.width, &l.thickness, &l.material.youngs_modulus,
                      &l.material.poissons_ratio, &l.material.density})
      all.push_back(x);
  }
  for (RigidBody& b : m.bodies) {
    for (int i = 0; i < 3; ++i) {
      all.push_back(&b.reference[i]);
      all.push_back(&b.center_of_mass[i]);
    }
    all.push_back(&b.mass);
    for (int i = 0; i < 9; ++i) all.push_back(b.inertia.data() + i);
  }
  return all;
}

MechanismDirection direction(bool hinge, std::size_t k) {
  Values p;
  for (const Parameter& q : parameters) p.push_back(q.value);
  const Derivatives d = ridders(
      [&](double x) {
        Values moved = p;
        moved[k] = x;
        Mechanism m = skew(hinge, moved);
        Values out;
        for (double* n : numbers(m)) out.push_back(*n);
        return out;
      },
      p[k], 0.05 * p[k]);
  MechanismDirection result{parameters[k].name, skew(hinge, p)};
  const std::vector<double*> places = numbers(result.rate);
  for (std::size_t i = 0; i < places.size(); ++i) *places[i] = d.value[i];
  return result;
}

struct Case {
  bool hinge;
  Flexure flexure;
  Accuracy accuracy;
  double stroke;
  std::vector<std::size_t> along;  ///< parameters
};

void check(const Case& c) {
  Values p;
  for (const Parameter& q : parameters) p.push_back(q.value);
  ModelOptions model;
  model.accuracy = c.accuracy;
  model.flexure = c.flexure;
  model.mesh = c.flexure == Flexure::plate ? std::array{6, 2} : std::array{8, 1};
  StrokeRequest request;
  request.points = {0, c.stroke};
  request.frequencies = 4;
  request.frequency_derivatives = false;
  request.exact = true;
  request.newton.tolerance = 1e-11;
  request.load << 1, 0.5, -2, 0.01, 0.02, -0.01;
  request.load[c.hinge ? 5 : 1] = 0;

  std::vector<MechanismDirection> directions;
  for (const std::size_t k : c.along) directions.push_back(direction(c.hinge, k));
  const StrokeSensitivity exact =
      evaluate_stroke_gradients(skew(c.hinge, p), directions, model, request);
  REQUIRE(exact.gradients);
  REQUIRE(exact.response.status == Status::ok);

  const std::vector<Quantity> all = quantities(c.hinge ? Direction::rz : Direction::uy);
  const auto values = [&](const StrokeResponse& r) {
    Values v;
    for (const PathPoint& point : r.path)
      for (const Quantity& q : all) v.push_back(value_of(point, q.name).value_or(0));
    return v;
  };
  const Values here = values(exact.response);
  for (std::size_t d = 0; d < c.along.size(); ++d) {
    const std::size_t k = c.along[d];
    const Derivatives differences = ridders(
        [&](double x) {
          Values moved = p;
          moved[k] = x;
          return values(evaluate_stroke(skew(c.hinge, moved), model, request));
        },
        p[k], 0.02 * p[k], 5);
    std::size_t n = 0;
    int compared = 0;
    for (const PointGradients& point : exact.gradients->path)
      for (const Quantity& q : all) {
        const std::size_t i = n++;
        const auto gradient = gradient_of(point, q.name);
        if (!gradient) continue;
        ++compared;
        // values that are zero but for rounding count as 1e-2 of what the stroke makes of them
        const double floor = q.name.starts_with("displacement") ? 1e-2 * 0.02
                             : q.name.starts_with("rotation")   ? 1e-2 * 0.4
                             : q.name == "drive_load"           ? 1e-2 * (c.hinge ? 0.1 : 10.0)
                                                                : 0.0;
        const double size = std::max(std::abs(differences.value[i]),
                                     0.1 * std::max(std::abs(here[i]), floor) / p[k]);
        const double known = differences.error[i] / size;
        INFO(parameters[k].name << ": " << q.name << " at point " << i / all.size() << ", "
                                << (*gradient)[static_cast<Eigen::Index>(d)]
                                << ", differences known to " << known);
        CHECK(std::abs((*gradient)[static_cast<Eigen::Index>(d)] - differences.value[i]) / size <=
              1e-7 + 5 * known);
        CHECK(known <= 1e-4);
      }
    CHECK(compared >= 2 * 22);
  }
}

}  // namespace

TEST_CASE("derivatives of a plate guide") {
  check({false, Flexure::plate, Accuracy::full, 0.02, {0, 1, 2, 4, 7, 10}});
}

TEST_CASE("derivatives of a plate hinge") {
  check({true, Flexure::plate, Accuracy::full, 0.4, {0, 1, 2, 3, 6, 9}});
}

TEST_CASE("derivatives of a beam guide, the other way") {
  check({false, Flexure::beam, Accuracy::full, -0.015, {0, 1, 2, 4, 5, 9}});
}

TEST_CASE("derivatives of a beam hinge") {
  check({true, Flexure::beam, Accuracy::full, 0.5, {0, 1, 2, 8, 9, 10}});
}

TEST_CASE("derivatives of a hinge finished from reduced leaves") {
  check({true, Flexure::plate, Accuracy::reduced, -0.3, {0, 2, 10}});
}

TEST_CASE("equal leaves: derivatives of double frequencies are those of their cluster") {
  // a light end-effector between four equal leaves: leaf modes come in groups
  Mechanism m = models::guide(0.1, 0.03, 0.5e-3, 0.06, 2.0, 1e-2);
  ModelOptions model;
  model.accuracy = Accuracy::full;
  model.mesh = {6, 2};
  StrokeRequest request;
  request.frequencies = 10;
  request.frequency_derivatives = false;
  request.stress = false;
  MechanismDirection thicker{"thickness", m};
  for (RigidBody& b : thicker.rate.bodies) {
    b.reference = b.center_of_mass = Vector3d::Zero();
    b.mass = 0;
    b.inertia.setZero();
  }
  for (LeafSpring& l : thicker.rate.leaves) {
    l.origin.setZero();
    l.axes.setZero();
    l.length = l.width = 0;
    l.material.youngs_modulus = l.material.poissons_ratio = l.material.density = 0;
    l.thickness = 1;
  }
  const StrokeSensitivity s = evaluate_stroke_gradients(m, {thicker}, model, request);
  REQUIRE(s.gradients);
  const PointGradients& g = s.gradients->path[0];
  // bending of the leaves in one plane has an even and an odd combination, all but equal
  CHECK(g.frequencies_locked.rows() == 10);
  const Derivatives d = ridders(
      [&](double t) {
        Mechanism moved = m;
        for (LeafSpring& l : moved.leaves) l.thickness = t;
        StrokeRequest exact = request;
        exact.exact = true;
        return evaluate_stroke(moved, model, exact).path[0].frequencies_locked;
      },
      0.5e-3, 1e-5, 4);
  for (int k = 0; k < 10; ++k)
    CHECK(g.frequencies_locked(k, 0) == Approx(d.value[k]).epsilon(1e-6).margin(5 * d.error[k]));
}
