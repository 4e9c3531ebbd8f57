#include "core/reduction/superelement_leaf_gradient.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "core/elements/beam_stress.hpp"
#include "core/math/ridders.hpp"
#include "core/math/rotation.hpp"
#include "support/models.hpp"
#include "synthetic_leaf.hpp"

using namespace flexopt;
using flexopt::synthetic::Random;

namespace {

struct Case {
  std::string name;
  LeafSpring leaf;
  ModelOptions model;
};

// A body that holds an edge: where it is, and how its reference point moves with the design.
struct Body {
  Vector3d reference, displacement, reference_rate;
  Matrix3d rotation;
};

// Numbers of a design: a leaf and the bodies' reference points, at direction · t.
struct Design {
  LeafSpring leaf;
  std::array<Body, 2> body;
};

// Along a direction the axes turn by `turn`.
struct DesignRate {
  LeafSpring rate;
  std::array<Vector3d, 2> reference{Vector3d::Zero(), Vector3d::Zero()};
  Vector3d turn = Vector3d::Zero();
};

Design moved(const Design& design, const DesignRate& d, double t) {
  Design m = design;
  LeafSpring& l = m.leaf;
  l.origin += t * d.rate.origin;
  l.axes = rotation_exp(t * d.turn) * l.axes;
  l.length += t * d.rate.length;
  l.width += t * d.rate.width;
  l.thickness += t * d.rate.thickness;
  l.material.youngs_modulus += t * d.rate.material.youngs_modulus;
  l.material.poissons_ratio += t * d.rate.material.poissons_ratio;
  l.material.density += t * d.rate.material.density;
  for (int e = 0; e < 2; ++e) m.body[e].reference += t * d.reference[e];
  return m;
}

bool held(const LeafSpring& leaf, int e) { return (e == 0 ? leaf.base : leaf.tip) >= 0; }

EdgePoses edges(const Design& design) {
  EdgePoses poses;
  for (int e = 0; e < 2; ++e) {
    const Vector3d middle = e == 0 ? design.leaf.origin : design.leaf.tip_middle();
    const Body& b = design.body[e];
    poses[e] = {middle, design.leaf.axes};
    if (held(design.leaf, e))
      poses[e] = {b.reference + b.displacement + b.rotation * (middle - b.reference),
                  b.rotation * design.leaf.axes};
  }
  return poses;
}

// What does not change with the design: inner nodes and the point's force in leaf axes and units.
struct State {
  std::vector<NodePose> nodes;
  Vector3d point_displacement, point_force;
};

// Columns of increments: internal scaled ones (without amplitudes), bodies and point in SI.
struct Columns {
  MatrixXd nodes, force, bodies, point;
  VectorXd lambda;
};

// Residual and quadratic forms, amplitudes at their stationary value, from superelements in SI.
struct Answer {
  VectorXd nodes, force, bodies, point;
  VectorXd form;
  std::vector<double> flat() const {
    std::vector<double> all;
    for (const VectorXd* v : {&nodes, &force, &bodies, &point, &form})
      all.insert(all.end(), v->begin(), v->end());
    return all;
  }
};

Answer answer(const Design& design, const ModelOptions& model, const State& state,
              const Columns& Y) {
  const LeafSpring& leaf = design.leaf;
  const SuperelementGrid grid(leaf, model);
  const LeafScale scale(leaf, model.flexure);
  const Matrix3d& A = leaf.axes;
  const EdgePoses poses = edges(design);
  const int k = grid.nodes_per_line(), m = grid.nodes_per_element(),
            columns = static_cast<int>(Y.lambda.size()), last = grid.lines() - 1;
  const auto edge_of = [&](int line) {
    return line == 0 ? 0 : line == last && leaf.tip != free_edge ? 1 : -1;
  };
  std::vector<NodePose> nodes;
  MatrixXd N1 = MatrixXd::Zero(6 * (last + 1) * k, columns);
  int inner = 0;
  for (int line = 0; line <= last; ++line)
    for (int j = 0; j < k; ++j) {
      const int i = static_cast<int>(nodes.size());
      if (const int e = edge_of(line); e >= 0) {
        nodes.push_back({poses[e].position + poses[e].axes.col(1) * grid.y(j), poses[e].axes});
        if (!held(leaf, e)) continue;
        const Body& b = design.body[e];
        const Vector3d arm = nodes[i].position - b.reference - b.displacement;
        N1.middleRows<3>(6 * i) =
            Y.bodies.middleRows<3>(6 * e) - hat(arm) * Y.bodies.middleRows<3>(6 * e + 3);
        N1.middleRows<3>(6 * i + 3) = Y.bodies.middleRows<3>(6 * e + 3);
      } else {
        const NodePose& scaled = state.nodes[i];
        nodes.push_back({leaf.origin + A * scaled.position * leaf.length, A * scaled.axes});
        N1.middleRows<3>(6 * i) = leaf.length * A * Y.nodes.middleRows<3>(inner);
        N1.middleRows<3>(6 * i + 3) = A * Y.nodes.middleRows<3>(inner + 3);
        inner += 6;
      }
    }
  VectorXd F = VectorXd::Zero(6 * nodes.size());
  Answer result;
  result.form = VectorXd::Zero(columns);
  std::vector<NodePose> gathered(m);
  for (int e = 0; e < grid.elements(); ++e) {
    const auto index = [&](int a) { return grid.node(e, a).line * k + grid.node(e, a).node; };
    MatrixXd own(6 * m, columns);
    for (int a = 0; a < m; ++a) {
      gathered[a] = nodes[index(a)];
      own.middleRows<6>(6 * a) = N1.middleRows<6>(6 * index(a));
    }
    Superelement element(grid.model(e));
    REQUIRE(element.evaluate(gathered));
    const MatrixXd M = element.mass();
    const int modes = static_cast<int>(M.rows()) - 6 * m;
    const VectorXd omega2 = grid.model(e).stiffness.diagonal().tail(modes);
    for (int a = 0; a < m; ++a) F.segment<6>(6 * index(a)) += element.force().segment<6>(6 * a);
    for (int c = 0; c < columns; ++c) {
      const double l = Y.lambda[c];
      const VectorXd y = own.col(c), C = M.bottomLeftCorner(modes, 6 * m) * y;
      result.form[c] += y.dot(element.tangent() * y) -
                        l * y.dot(M.topLeftCorner(6 * m, 6 * m) * y) -
                        l * l * C.cwiseAbs2().cwiseQuotient((omega2.array() - l).matrix()).sum();
    }
  }
  const double D = scale.energy, L = scale.length;
  const std::vector<NodeShare> shares = point_shares(leaf, grid);
  Vector3d apart = state.point_displacement;
  MatrixXd apart_rate = Y.point;
  const Vector3d point_force = A * state.point_force * (D / L);
  for (const NodeShare& s : shares) {
    const int i = s.node.line * k + s.node.node;
    apart += s.weight * (leaf.origin + A * Vector3d(grid.x(s.node.line), grid.y(s.node.node), 0) -
                         nodes[i].position);
    apart_rate -= s.weight * N1.middleRows<3>(6 * i);
    F.segment<3>(6 * i) -= s.weight * point_force;
  }
  result.nodes = VectorXd::Zero(inner);
  result.bodies = VectorXd::Zero(12);
  inner = 0;
  for (int line = 0, i = 0; line <= last; ++line)
    for (int j = 0; j < k; ++j, ++i) {
      const Vector3d f = F.segment<3>(6 * i), moment = F.segment<3>(6 * i + 3);
      if (const int e = edge_of(line); e >= 0) {
        if (!held(leaf, e)) continue;
        const Body& b = design.body[e];
        const Vector3d arm = nodes[i].position - b.reference - b.displacement;
        result.bodies.segment<3>(6 * e) += f;
        result.bodies.segment<3>(6 * e + 3) += arm.cross(f) + moment;
        for (int c = 0; c < columns; ++c) {
          const Vector3d w = Y.bodies.block<3, 1>(6 * e + 3, c);
          result.form[c] += f.dot(w.cross(w.cross(arm)));
        }
      } else {
        result.nodes.segment<3>(inner) = L * A.transpose() * f;
        result.nodes.segment<3>(inner + 3) = A.transpose() * moment;
        inner += 6;
      }
    }
  if (!shares.empty()) {
    result.force = D / L * A.transpose() * apart;
    result.point = point_force;
    for (int c = 0; c < columns; ++c)
      result.form[c] += 2 * D / L * Y.force.col(c).dot(A.transpose() * apart_rate.col(c));
  }
  return result;
}

LeafVariation<double> variation(const Design& design, const ModelOptions& model,
                                const DesignRate& d) {
  const LeafSpring& leaf = design.leaf;
  const double L = leaf.length, nu = leaf.material.poissons_ratio;
  const Matrix3d axes = hat(d.turn) * leaf.axes;
  LeafVariation<double> v;
  v.length = d.rate.length / L;
  const double t = d.rate.thickness / leaf.thickness;
  v.energy = d.rate.material.youngs_modulus / leaf.material.youngs_modulus + 3 * t;
  if (model.flexure == Flexure::plate)
    v.energy += 2 * nu * d.rate.material.poissons_ratio / (1 - nu * nu);
  v.mass = d.rate.material.density / leaf.material.density + t + 4 * v.length;
  v.shape = {(d.rate.width - leaf.width * v.length) / L,
             (d.rate.thickness - leaf.thickness * v.length) / L, d.rate.material.poissons_ratio};
  v.turn = axes.transpose() * leaf.axes;
  for (int e = 0; e < 2; ++e) {
    if (!held(leaf, e)) continue;
    const Body& b = design.body[e];
    const auto scaled = [&](const Vector3d& from, const Vector3d& rate) {
      return Vector3d((axes.transpose() * from + leaf.axes.transpose() * (rate - v.length * from)) /
                      L);
    };
    const Vector3d moves = d.reference[e] - d.rate.origin;
    v.edge[e].position = scaled(b.reference + b.displacement - leaf.origin, moves);
    v.edge[e].arm = -scaled(b.reference - leaf.origin, moves);
    v.edge[e].rotation =
        axes.transpose() * b.rotation * leaf.axes + leaf.axes.transpose() * b.rotation * axes;
  }
  return v;
}

std::vector<Case> cases() {
  ModelOptions model{.mesh = {8, 4}, .method = Reduction::linear_craig_bampton, .leaf_modes = 4};
  const LeafSpring plate = models::leaf({0.3, -0.2, 0.1}, {2, 1, 0}, 0.1, 0.05, 2e-3);
  std::vector<Case> all;
  const auto add = [&](std::string name, LeafSpring leaf, std::array<int, 2> superelements) {
    model.superelements = superelements;
    if (leaf.base == ground && leaf.tip == 0 && !leaf.point) leaf.base = 1;  // both edges move
    all.push_back({std::move(name), std::move(leaf), model});
  };
  add("segments", plate, {3, 0});
  add("one patch", plate, {1, 1});
  add("patches", plate, {2, 2});
  LeafSpring at_point = plate;
  at_point.point = LeafPoint{.body = 2, .along = 0.5, .across = 0.5};
  add("point of patches", at_point, {2, 2});
  LeafSpring tip = plate;
  tip.tip = free_edge;
  tip.base = 0;
  tip.point = LeafPoint{.body = 2, .along = 1, .across = 0.5, .spread_over_tip = true};
  add("free tip of patches", tip, {2, 2});
  add("free tip of segments", tip, {2, 0});
  model.flexure = Flexure::beam;
  add("beams", plate, {3, 0});
  LeafSpring wire = plate;
  wire.section = Section::circular;
  wire.width = wire.thickness;
  add("wires", wire, {2, 0});
  add("free tip of beams", tip, {2, 0});
  return all;
}

struct Bent {
  Design design;
  std::unique_ptr<SuperelementLeaf> leaf;
  LeafRows rows;
};

// Moved in steps; `converged`: balanced at the last one, too.
Bent bend(const Case& c, Random& random, bool converged) {
  Bent bent{{c.leaf, {}}, nullptr, {}};
  bent.leaf = std::make_unique<SuperelementLeaf>(
      c.leaf, std::make_shared<const SuperelementGrid>(c.leaf, c.model), 0);
  SuperelementLeaf& leaf = *bent.leaf;
  leaf.evaluate();
  const double L = c.leaf.length;
  std::array<Vector3d, 2> shift, turn;
  for (int e = 0; e < 2; ++e) {
    const Vector3d middle = e == 0 ? c.leaf.origin : c.leaf.tip_middle();
    shift[e] = random.vector<3>(0.001 * L) + c.leaf.axes * Vector3d(-0.006 * e, 0, 0.1 * e) * L;
    turn[e] = random.vector<3>(0.05) + c.leaf.axes * Vector3d(0.1, -0.2, 0);
    if (e == 1) turn[e] += random.vector<3>(0.05);
    bent.design.body[e] = {middle + random.vector<3>(0.3 * L), Vector3d::Zero(), Vector3d::Zero(),
                           Matrix3d::Identity()};
  }
  const Vector3d point = c.leaf.axes * Vector3d(-0.01, 0.003, 0.2) * L;
  Vector3d point_now = Vector3d::Zero();
  EdgePoses now = edges(bent.design);
  constexpr int steps = 8;
  const auto step = [&](double share) {
    for (int e = 0; e < 2; ++e) {
      if (!held(c.leaf, e)) continue;
      bent.design.body[e].displacement = share * shift[e];
      bent.design.body[e].rotation = rotation_exp(share * turn[e]);
    }
    const EdgePoses next = edges(bent.design);
    Vector12d dq;
    for (int e = 0; e < 2; ++e)
      dq.segment<6>(6 * e) << next[e].position - now[e].position,
          rotation_log(next[e].axes * now[e].axes.transpose());
    if (c.leaf.point) leaf.displace_point(share * point, share * point - point_now);
    leaf.move(next, dq);
    leaf.evaluate();
    now = next;
    point_now = share * point;
  };
  const auto balance = [&](double share) {
    for (int i = 0; i < 30 && (i < 2 || leaf.evaluation().correction > 1e-13); ++i) step(share);
    REQUIRE(leaf.evaluation().correction < 1e-11);
  };
  for (int s = 1; s < steps; ++s) balance(double(s) / steps);
  if (converged)
    balance(1);
  else
    step(1);
  const ScaledSuperelements scaled(leaf);
  bent.rows.unknowns = scaled.unknowns();
  bent.rows.point = c.leaf.point ? 3 : 0;
  for (int e = 0; e < 2; ++e)
    if (held(c.leaf, e)) {
      const Body& b = bent.design.body[e];
      bent.rows.lever[e] = c.leaf.axes.transpose() *
                           (now[e].position - b.reference - b.displacement) / c.leaf.length;
    }
  return bent;
}

}  // namespace

TEST_CASE("derivatives of a leaf of superelements agree with differences of rebuilt ones",
          "[reduction]") {
  for (const Case& c : cases()) {
    INFO(c.name);
    Random random(7);
    const Bent bent = bend(c, random, false);
    const SuperelementLeaf& leaf = *bent.leaf;
    const ScaledSuperelements scaled(leaf);
    const SuperelementLeafGradient gradient(scaled, bent.rows);
    const LeafScale& scale = leaf.scale();
    const double D = scale.energy, L = scale.length;
    const Matrix3d& A = scale.axes;
    const int nodal = scaled.nodal(), internal = bent.rows.internal(), columns = 3;
    const bool point = c.leaf.point.has_value(), wire = c.leaf.section == Section::circular;

    const State state{scaled.nodes(), leaf.point().displacement,
                      A.transpose() * leaf.point().force * (L / D)};
    Columns columns_si;
    MatrixXd Y = MatrixXd::Zero(bent.rows.size(), columns);
    for (double& y : Y.reshaped()) y = random();
    for (int e = 0; e < 2; ++e)
      if (!held(c.leaf, e)) Y.middleRows(bent.rows.body(e), 6).setZero();
    columns_si.nodes = Y.topRows(nodal);
    columns_si.force = Y.middleRows(bent.rows.unknowns, bent.rows.point);
    columns_si.bodies = MatrixXd::Zero(12, columns);
    for (int i = 0; i < 12; i += 3)
      columns_si.bodies.middleRows<3>(i) =
          (i % 6 == 0 ? L : 1) * A * Y.middleRows<3>(bent.rows.internal() + i);
    columns_si.point = MatrixXd::Zero(3, columns);
    if (point) columns_si.point = L * A * Y.middleRows<3>(bent.rows.point_body());
    // between the eigenvalues of the modes: amplitudes answer finitely
    const double lowest = scaled.model(0).stiffness.diagonal().tail(1)[0] * D / scale.mass;
    columns_si.lambda.resize(columns);
    columns_si.lambda << 0, 0.3 * lowest, 0.6 * lowest;
    const VectorXd mu = columns_si.lambda * (scale.mass / D);
    for (int e = 0; e < leaf.grid().elements(); ++e) {
      const SuperelementModel& m = scaled.model(e);
      const int n = m.coordinates(), own = scaled.own_amplitudes();
      const MatrixXd T = bent.rows.edge_rows(Y);
      const MatrixXd f =
          scaled[e].mass().bottomLeftCorner(own, n) * scaled.element_rates(e, T).topRows(n);
      for (int k = 0; k < columns; ++k)
        for (int a = 0; a < own; ++a)
          Y(scaled.amplitude(e) + a, k) = mu[k] * f(a, k) / (m.stiffness(n + a, n + a) - mu[k]);
    }

    const Answer here = answer(bent.design, c.model, state, columns_si);
    const LeafQuadratic<double> q = gradient.quadratic(Y, mu);
    const VectorXd& f = gradient.force();
    const auto global = [&](const VectorXd& rows) {  // rows of an Answer
      Answer a;
      a.nodes = D * rows.head(nodal);
      a.force = D * rows.segment(bent.rows.unknowns, bent.rows.point);
      a.bodies = VectorXd::Zero(12);
      for (int i = 0; i < 12; i += 3)
        if (held(c.leaf, i / 6))
          a.bodies.segment<3>(i) = D / (i % 6 == 0 ? L : 1) * A * rows.segment<3>(internal + i);
      if (point) a.point = D / L * A * rows.segment<3>(bent.rows.point_body());
      return a;
    };
    // sizes of the parts, forces in units of moments over L
    const auto compare = [&](const Answer& x, const Answer& y, double size, double most) {
      CHECK((x.nodes - y.nodes).norm() <= most * size);
      CHECK((x.bodies - y.bodies).norm() * L <= most * size);
      if (!point) return;
      CHECK((x.force - y.force).norm() <= most * D);
      CHECK((x.point - y.point).norm() * L <= most * size);
    };
    const double force_size =
        here.nodes.norm() + here.bodies.norm() * L + (point ? here.point.norm() * L : 0);
    REQUIRE(force_size > 0);
    compare(global(f), here, force_size, 1e-9);
    for (int k = 0; k < columns; ++k)
      CHECK(D * (q.stiffness[k] - mu[k] * q.mass[k]) == Approx(here.form[k]).epsilon(1e-8));

    for (int k = 0; k < 9; ++k) {
      DesignRate d;
      d.rate.origin.setZero();
      d.rate.material.youngs_modulus = d.rate.material.poissons_ratio = d.rate.material.density = 0;
      if (k == 0) d.rate.length = L;
      if (k == 1) d.rate.width = c.leaf.width;
      if (k == 2) d.rate.thickness = c.leaf.thickness;
      if (wire && (k == 1 || k == 2)) {
        d.rate.width = d.rate.thickness = c.leaf.thickness;
      }
      if (k == 3) d.rate.material.youngs_modulus = c.leaf.material.youngs_modulus;
      if (k == 4) d.rate.material.poissons_ratio = 1;
      if (k == 5) d.rate.material.density = c.leaf.material.density;
      if (k == 6) d.rate.origin = random.vector<3>(L);
      if (k == 7) d.turn = random.vector<3>(1);
      if (k == 8)
        for (Vector3d& r : d.reference) r = random.vector<3>(L);
      const LeafVariation<double> v = variation(bent.design, c.model, d);
      const MatrixXd rates = gradient.force_rates({v});
      Answer exact = global(rates.col(0) + v.energy * f);
      const Answer value = global(f);
      for (int i = 0; i < 12; i += 6)
        exact.bodies.segment<3>(i) -= v.length * value.bodies.segment<3>(i);
      for (int i = 0; i < 12; i += 3)
        exact.bodies.segment<3>(i) += d.turn.cross(Vector3d(value.bodies.segment<3>(i)));
      if (point) exact.point += d.turn.cross(Vector3d(value.point)) - v.length * value.point;
      exact.form = VectorXd::Zero(columns);
      for (int a = 0; a < columns; ++a)
        exact.form[a] = D * (v.energy * q.stiffness[a] + gradient.rate(q, Y, a, v)) -
                        columns_si.lambda[a] * scale.mass * v.mass * q.mass[a];
      const std::vector<double> all = exact.flat();
      const Derivatives by = ridders(
          [&](double t) {
            return answer(moved(bent.design, d, t), c.model, state, columns_si).flat();
          },
          0, 0.02, 7);
      INFO("direction " << k);
      const int rows = static_cast<int>(all.size()) - columns;
      double size = force_size;
      for (int i = 0; i < rows; ++i)
        size = std::max(size, std::abs(all[i]) * (i >= nodal + bent.rows.point ? L : 1));
      for (int i = 0; i < rows; ++i) {
        const double unit = i >= nodal + bent.rows.point ? L : 1;
        const double error = unit * std::abs(by.value[i] - all[i]) / size;
        CHECK(error < 1e-9);
      }
      for (int a = 0; a < columns; ++a) {
        const double form = std::max(std::abs(here.form[a]), D * std::abs(q.stiffness[a]));
        const double error =
            std::abs(by.value[rows + a] - all[rows + a]) / std::max(form, std::abs(all[rows + a]));
        INFO("column " << a << ": " << all[rows + a] << ' ' << by.value[rows + a]);
        CHECK(error < 1e-9);
      }
    }

    // and in the state
    for (int k = 0; k < 3; ++k) {
      VectorXd z(bent.rows.size());
      for (double& x : z) x = random();
      const Derivatives by = ridders(
          [&](double t) {
            State s = state;
            Design design = bent.design;
            int inner = 0;
            const int per_line = leaf.grid().nodes_per_line();
            for (std::size_t i = 0; i < s.nodes.size(); ++i) {
              if (leaf.is_edge(static_cast<int>(i) / per_line)) continue;
              s.nodes[i].position += t * z.segment<3>(inner);
              s.nodes[i].axes = rotation_exp(t * z.segment<3>(inner + 3)) * s.nodes[i].axes;
              inner += 6;
            }
            for (int e = 0; e < 2; ++e) {
              if (!held(c.leaf, e)) continue;
              Body& b = design.body[e];
              b.displacement += t * L * A * z.segment<3>(internal + 6 * e);
              b.rotation = rotation_exp(t * A * z.segment<3>(internal + 6 * e + 3)) * b.rotation;
            }
            if (point) {
              s.point_force += t * z.segment<3>(bent.rows.unknowns);
              s.point_displacement += t * L * A * z.segment<3>(bent.rows.point_body());
            }
            const Answer a = answer(design, c.model, s, columns_si);
            return std::vector<double>(a.form.begin(), a.form.end());
          },
          0, 0.02, 8);
      for (int e = 0; e < 2; ++e)
        if (!held(c.leaf, e)) z.segment<6>(bent.rows.body(e)).setZero();
      for (int a = 0; a < columns; ++a) {
        const double exact = D * q.state.col(a).dot(z);
        const double form =
            std::max({std::abs(here.form[a]), D * std::abs(q.stiffness[a]), std::abs(exact)});
        INFO("state, column " << a << ": " << exact << ' ' << by.value[a]);
        CHECK(std::abs(by.value[a] - exact) < 1e-9 * form);
      }
    }
  }
}

TEST_CASE("derivatives of the stress of a leaf of superelements agree with differences",
          "[reduction]") {
  for (const Case& c : cases()) {
    INFO(c.name);
    Random random(9);
    const Bent bent = bend(c, random, true);
    SuperelementLeaf& leaf = *bent.leaf;
    const ScaledSuperelements scaled(leaf);
    const SuperelementLeafGradient gradient(scaled, bent.rows);
    const LeafScale& scale = leaf.scale();
    const double L = scale.length;
    const Matrix3d& A = scale.axes;
    const StressPeak peak = leaf.max_stress();
    REQUIRE(peak.value > 0);
    const bool beam = c.model.flexure == Flexure::beam, wire = c.leaf.section == Section::circular;
    VectorXd z(bent.rows.size());
    for (double& x : z) x = 0.1 * random();
    for (int e = 0; e < 2; ++e)
      if (!held(c.leaf, e)) z.segment<6>(bent.rows.body(e)).setZero();
    // the largest stress of the fields of a moved design and state
    const auto stress = [&](const DesignRate& d, double t) {
      Design design = moved(bent.design, d, t);
      std::vector<NodePose> nodes = scaled.nodes();
      const int k = leaf.grid().nodes_per_line(), internal = bent.rows.internal();
      for (int e = 0; e < 2; ++e) {
        if (!held(c.leaf, e)) continue;
        Body& b = design.body[e];
        b.displacement += t * L * A * z.segment<3>(internal + 6 * e);
        b.rotation = rotation_exp(t * A * z.segment<3>(internal + 6 * e + 3)) * b.rotation;
      }
      const LeafSpring& l = design.leaf;
      const SuperelementGrid grid(l, c.model);
      const EdgePoses poses = edges(design);
      int inner = 0;
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        const int line = static_cast<int>(i) / k, j = static_cast<int>(i) % k;
        NodePose& node = nodes[i];
        if (leaf.is_edge(line)) {
          const EdgePose& edge = poses[leaf.edge_of(line)];
          node = {edge.position + edge.axes.col(1) * grid.y(j), edge.axes};
        } else {
          node.position = l.origin + l.length * l.axes * (node.position + t * z.segment<3>(inner));
          node.axes = l.axes * rotation_exp(t * z.segment<3>(inner + 3)) * node.axes;
          inner += 6;
        }
      }
      std::vector<Superelement> elements;
      std::vector<NodePose> gathered(grid.nodes_per_element());
      for (int e = 0; e < grid.elements(); ++e) {
        for (std::size_t a = 0; a < gathered.size(); ++a) {
          const auto at = grid.node(e, static_cast<int>(a));
          gathered[a] = nodes[at.line * k + at.node];
        }
        elements.emplace_back(grid.model(e));
        REQUIRE(elements.back().evaluate(gathered));
      }
      SuperelementGrid::State state;
      for (const Superelement& element : elements) {
        state.q.push_back(&element.local());
        state.frames.push_back(&element.frame());
      }
      if (!beam)
        return largest_stress(grid.strains(state), grid.shape(), l.material.youngs_modulus, 0)
            .value;
      double largest = 0;
      LeafSpring segment = l;
      segment.length /= grid.along();
      for (int e = 0; e < grid.elements(); ++e)
        largest = std::max(largest,
                           beam_max_stress(*grid.plate(e).mesh, grid.beam_displacements(state, e),
                                           segment, grid.plate(e).scale, 0, BeamStrain::linear)
                               .value);
      return largest;
    };
    for (int k = 0; k < 6; ++k) {
      INFO("direction " << k);
      DesignRate d;
      d.rate.origin.setZero();
      d.rate.material.youngs_modulus = d.rate.material.poissons_ratio = d.rate.material.density = 0;
      if (k == 0) d.rate.length = L;
      if (k == 1) d.rate.width = c.leaf.width;
      if (k == 2) d.rate.thickness = c.leaf.thickness;
      if (wire && (k == 1 || k == 2)) d.rate.width = d.rate.thickness = c.leaf.thickness;
      if (k == 3) d.rate.material.youngs_modulus = c.leaf.material.youngs_modulus;
      if (k == 4) d.rate.material.poissons_ratio = 1;
      if (k == 5) d.turn = random.vector<3>(1);
      const LeafVariation<double> v = variation(bent.design, c.model, d);
      VectorXd y = z;  // global directions of the bodies stay, their numbers are those of now
      const StressRate rate{{}, v.shape, d.rate.material.youngs_modulus};
      const double exact = leaf.stress_rate(peak, gradient.field_rates(y, v), rate);
      const Derivatives by =
          ridders([&](double t) { return std::vector{stress(d, t)}; }, 0, 2e-3, 6);
      CHECK(std::abs(by.value[0] - exact) < 1e-8 * (peak.value + std::abs(exact)));
    }
  }
}

TEST_CASE("linear solves of a leaf of superelements are those of its quadratic form",
          "[reduction]") {
  for (const Case& c : cases()) {
    INFO(c.name);
    Random random(8);
    const Bent bent = bend(c, random, true);
    const ScaledSuperelements scaled(*bent.leaf);
    const LeafRows& rows = bent.rows;
    const SuperelementLeafGradient gradient(scaled, rows);
    CHECK(gradient.force().head(rows.internal()).norm() < 1e-8 * gradient.force().norm());
    const int n = rows.unknowns;
    const auto form = [&](const MatrixXd& Y) {
      return gradient.quadratic(Y, VectorXd::Zero(Y.cols()));
    };
    // mass
    MatrixXd Y(rows.size(), 2);
    for (double& y : Y.reshaped()) y = random();
    const LeafQuadratic<double> q = form(Y);
    const MatrixXd MY = rows.body_rows(scaled.mass_times(rows.edge_rows(Y)));
    for (int k = 0; k < 2; ++k) CHECK(Y.col(k).dot(MY.col(k)) == Approx(q.mass[k]).epsilon(1e-11));
    if (n == 0) continue;
    // K⁻¹ b: the work of b1 on x2 is that of K x1. Where a point is held its force answers.
    MatrixXd b = MatrixXd::Zero(rows.size(), 2);
    for (double& x : b.topRows(n).reshaped()) x = random();
    MatrixXd X = b;
    Eigen::Ref<MatrixXd> part = X.topRows(n);
    scaled.solve(part);
    MatrixXd sums(rows.size(), 3);
    sums << X, X.col(0) + X.col(1);
    const VectorXd s = form(sums).stiffness;
    const double size = std::abs(s[0]) + std::abs(s[1]);
    for (int k = 0; k < 2; ++k) CHECK(std::abs(s[k] - X.col(k).dot(b.col(k))) < 1e-9 * size);
    CHECK(std::abs(s[2] - s[0] - s[1] - 2 * b.col(0).dot(X.col(1))) < 1e-9 * size);
    // static shapes store the condensed energy
    std::vector<int> outer(bent.rows.point > 0 ? 15 : 12);
    std::iota(outer.begin(), outer.end(), 0);
    const MatrixXd shapes = scaled.static_shapes(outer);
    MatrixXd S = MatrixXd::Zero(rows.size(), shapes.cols());
    LeafRows at_edges = rows;
    for (Vector3d& lever : at_edges.lever) lever.setZero();
    S.topRows(n) = shapes;
    S.bottomRows(shapes.cols()).setIdentity();
    const LeafEvaluation& evaluation = bent.leaf->evaluation();
    MatrixXd K = MatrixXd::Zero(15, 15);
    K.topLeftCorner<12, 12>() = evaluation.tangent;
    if (evaluation.point) {
      K.bottomRightCorner<3, 3>() = evaluation.point->tangent;
      K.bottomLeftCorner<3, 12>() = evaluation.point->coupling;
      K.topRightCorner<12, 3>() = evaluation.point->coupling.transpose();
    }
    const LeafScale& scale = bent.leaf->scale();
    MatrixXd unit = MatrixXd::Zero(15, 15);
    for (int i = 0; i < 15; i += 3)
      unit.block<3, 3>(i, i) = (i % 6 == 0 ? scale.length : 1) * scale.axes;
    const MatrixXd scaled_K = unit.transpose() * K * unit / scale.energy;
    const SuperelementLeafGradient of_edges(scaled, at_edges);
    MatrixXd moving = S;
    if (c.leaf.tip == free_edge) {
      moving.middleCols(6, 6).setZero();
    }
    const VectorXd energies = of_edges.quadratic(moving, VectorXd::Zero(moving.cols())).stiffness;
    for (int k = 0; k < energies.size(); ++k) {
      INFO("increment " << k);
      CHECK(std::abs(energies[k] - scaled_K(k, k)) <
            1e-8 * scaled_K.diagonal().cwiseAbs().maxCoeff());
    }
  }
}
