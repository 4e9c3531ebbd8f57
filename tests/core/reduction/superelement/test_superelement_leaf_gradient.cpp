#include "core/reduction/superelement/superelement_leaf_gradient.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/ridders.hpp"
#include "superelement_leaves.hpp"

using namespace flexopt;
using namespace flexopt::superelement_leaves;

namespace {

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
struct LeafValues {
  VectorXd nodes, force, bodies, point;
  VectorXd form;
  std::vector<double> flat() const {
    std::vector<double> all;
    for (const VectorXd* v : {&nodes, &force, &bodies, &point, &form})
      all.insert(all.end(), v->begin(), v->end());
    return all;
  }
};

LeafValues answer(const Design& design, const ModelOptions& model, const State& state,
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
  LeafValues result;
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

}  // namespace

TEST_CASE("derivatives of a leaf of superelements agree with differences of rebuilt ones",
          "[reduction][slow]") {
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

    const LeafValues here = answer(bent.design, c.model, state, columns_si);
    const LeafQuadratic<double> q = gradient.quadratic(Y, mu);
    const VectorXd& f = gradient.force();
    const auto global = [&](const VectorXd& rows) {  // rows of an LeafValues
      LeafValues a;
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
    const auto compare = [&](const LeafValues& x, const LeafValues& y, double size, double most) {
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
      LeafValues exact = global(rates.col(0) + v.energy * f);
      const LeafValues value = global(f);
      for (int i = 0; i < 12; i += 6)
        exact.bodies.segment<3>(i) -= v.length * value.bodies.segment<3>(i);
      for (int i = 0; i < 12; i += 3)
        exact.bodies.segment<3>(i) += d.turn.cross(Vector3d(value.bodies.segment<3>(i)));
      if (point) exact.point += d.turn.cross(Vector3d(value.point)) - v.length * value.point;
      exact.form = VectorXd::Zero(columns);
      const MatrixXd q_rates = gradient.rates(q, Y, {v});
      for (int a = 0; a < columns; ++a)
        exact.form[a] = D * (v.energy * q.stiffness[a] + q_rates(a, 0)) -
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
            const LeafValues a = answer(design, c.model, s, columns_si);
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
