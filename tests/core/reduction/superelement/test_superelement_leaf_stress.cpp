// The stress of leaves of superelements along the design, and linear solves about their states.
#include "core/reduction/superelement/superelement_leaf_gradient.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/elements/plate/beam_stress.hpp"
#include "core/math/ridders.hpp"
#include "superelement_leaves.hpp"

using namespace flexopt;
using namespace flexopt::superelement_leaves;

TEST_CASE("derivatives of the stress of a leaf of superelements agree with differences",
          "[reduction][slow]") {
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
      const StressRate rate{{}, Vector3d(v.shape), d.rate.material.youngs_modulus};
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
