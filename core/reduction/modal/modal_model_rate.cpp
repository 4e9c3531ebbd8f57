#include "core/reduction/modal/modal_model_rate.hpp"

#include <utility>

#include "core/elements/leaf/leaf_rates.hpp"
#include "core/elements/plate/plate_products.hpp"
#include "core/math/rotation.hpp"
#include "core/reduction/modal/modal_derivatives.hpp"

namespace flexopt {
namespace {

using namespace plate;

// Of every node, line by line: lines · functions × 3.
using Nodal = Eigen::Matrix<double, Eigen::Dynamic, 3>;

struct Pair {
  Nodal value, rate;
};

// The undeflected leaf and its derivative in one number of the shape.
class Undeflected {
 public:
  Undeflected(const PlateLeaf& plate, const PlateMeshRate::Shape& by, bool width)
      : plate_(&plate),
        mesh_(&plate.mesh()),
        by_(&by),
        widening_(width && !mesh_->shape().is_beam() ? 1 / mesh_->shape().width : 0) {
    a0_.setZero();
    a0_.topRows<points>().col(0).setOnes();
    a0_.bottomRows<points>().col(1).setOnes();
  }

  /// ∂K/∂σ of the nodes (functions × 3 of every line) times a constant field.
  Nodal tangent_rate(const Nodal& N) const {
    return forces({N, Nodal::Zero(N.rows(), 3)}, nullptr)[0].rate;
  }

  /// Rows of the unknowns of the force s of a path.
  VectorXd rows(const Nodal& f) const {
    VectorXd r(plate_->unknowns());
    for (int i = 0; i < mesh_->lines(); ++i) {
      const int first = plate_->block_offset(i), n = functions();
      if (!plate_->is_rigid_edge(i)) {
        r.segment(first, 3 * n) = f.middleRows(i * n, n).reshaped();
        continue;
      }
      each_slope([&](int d, int s, int axis) { r[first + d] = f(i * n + s, axis); });
    }
    return r;
  }

  /// Nodes by a shape: unknowns, displacement and rotation vector of both edges.
  Nodal nodes(const VectorXd& shape) const {
    Nodal N(mesh_->lines() * functions(), 3);
    for (int i = 0; i < mesh_->lines(); ++i) {
      const int first = plate_->block_offset(i), n = functions();
      if (!plate_->is_rigid_edge(i)) {
        N.middleRows(i * n, n) = shape.segment(first, 3 * n).reshaped(n, 3);
        continue;
      }
      const Vector6d edge = shape.segment<6>(plate_->unknowns() + (i == 0 ? 0 : 6));
      for (int s = 0; s < n; ++s) {
        N.row(i * n + s) = edge.tail<3>().cross(place(s)).transpose();
        if (s % 4 == 0) N.row(i * n + s) += edge.head<3>().transpose();
      }
      each_slope([&](int d, int s, int axis) { N(i * n + s, axis) += shape[first + d]; });
    }
    return N;
  }

  /// Derivative of the coefficient of s² of the residual's unknowns along s · shape.
  VectorXd second_order_rate(const VectorXd& shape, const VectorXd& shape_rate) const {
    Pair N1{nodes(shape), nodes(shape_rate) + edge_rates(shape)};
    const Pair N2 = second_nodes(shape, shape_rate);
    const std::array<Pair, 2> f = forces(N1, &N2);
    VectorXd r = rows(f[1].rate);
    each_edge([&](int i, int edge) {  // the slopes' axes turn
      const int n = functions(), first = plate_->block_offset(i);
      const Vector3d turn = shape.segment<3>(plate_->unknowns() + 6 * edge + 3);
      each_slope([&](int d, int s, int axis) {
        const Vector3d turned = turn.cross(Vector3d::Unit(axis));
        r[first + d] += f[0].rate.row(i * n + s).dot(turned);
      });
    });
    return r;
  }

  /// Coefficient of s² of the edges' nodes along s · shape, and its derivative.
  Pair second_nodes(const VectorXd& shape, const VectorXd& shape_rate) const {
    const Nodal zero = Nodal::Zero(mesh_->lines() * functions(), 3);
    Pair N2{zero, zero};
    each_edge([&](int i, int edge) {
      const int n = functions(), first = plate_->block_offset(i);
      const Vector3d turn = shape.segment<3>(plate_->unknowns() + 6 * edge + 3);
      for (int s = 0; s < n; ++s) {
        const Vector3d twice = 0.5 * turn.cross(turn.cross(place(s)));
        N2.value.row(i * n + s) = twice.transpose();
        if (s % 4 == 0) N2.rate.row(i * n + s) = widening_ * twice.transpose();
      }
      each_slope([&](int d, int s, int axis) {
        const Vector3d turned = turn.cross(Vector3d::Unit(axis));
        N2.value.row(i * n + s) += shape[first + d] * turned.transpose();
        N2.rate.row(i * n + s) += shape_rate[first + d] * turned.transpose();
      });
    });
    return N2;
  }

  /// Derivative of the nodes of edges that a shape turns.
  Nodal edge_rates(const VectorXd& shape) const {
    Nodal N = Nodal::Zero(mesh_->lines() * functions(), 3);
    each_edge([&](int i, int edge) {
      const Vector3d turn = shape.segment<3>(plate_->unknowns() + 6 * edge + 3);
      for (int j = 0; j < mesh_->nodes_per_line(); ++j)
        N.row(i * functions() + 4 * j) =
            widening_ * mesh_->y()[j] * turn.cross(Vector3d::UnitY()).transpose();
    });
    return N;
  }
  /// K N of edges' nodes.
  Nodal tangent_times(const Nodal& N) const {
    return forces({N, Nodal::Zero(N.rows(), 3)}, nullptr)[0].value;
  }

  double widening() const { return widening_; }  ///< ẏ/y of nodes across
  int functions() const { return mesh_->functions_per_line(); }

 private:
  Vector3d place(int s) const {  // from the middle of an edge
    if (s % 4 == 0) return mesh_->y()[s / 4] * Vector3d::UnitY();
    return s % 4 == 3 ? Vector3d(Vector3d::Zero()) : Vector3d(Vector3d::Unit(s % 4 - 1));
  }
  template <class Visit>
  void each_edge(const Visit& visit) const {
    visit(0, 0);
    visit(mesh_->lines() - 1, 1);
  }
  /// visit(unknown of the edge, function, axis)
  template <class Visit>
  void each_slope(const Visit& visit) const {
    const auto& slopes = mesh_->edge_slopes();
    const int per_node = static_cast<int>(slopes.size());
    for (int j = 0; j < mesh_->nodes_per_line(); ++j)
      for (int d = 0; d < per_node; ++d)
        visit(per_node * j + d, 4 * j + slopes[d].function, slopes[d].axis);
  }

  /// Coefficients of s and s² of the nodal forces along s N1 + s² N2.
  std::array<Pair, 2> forces(const Pair& N1, const Pair* N2) const {
    return mesh_->functions_per_side() == 8 ? forces_of<8>(N1, N2) : forces_of<4>(N1, N2);
  }
  template <int Side>
  std::array<Pair, 2> forces_of(const Pair& N1, const Pair* N2) const;

  const PlateLeaf* plate_;
  const PlateMesh* mesh_;
  const PlateMeshRate::Shape* by_;
  double widening_;
  Gradient<double> a0_;
};

template <int Side>
std::array<Pair, 2> Undeflected::forces_of(const Pair& N1, const Pair* N2) const {
  using Block = Eigen::Matrix<double, 2 * Side, 3>;
  const int n = functions(), nx = mesh_->elements_along(), ny = mesh_->elements_across();
  const Nodal zero = Nodal::Zero(N1.value.rows(), 3);
  std::array<Pair, 2> f{Pair{zero, zero}, Pair{zero, zero}};
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      const int k = i * ny + j, low = i * n + 4 * j, high = low + n;
      const PlateMesh::Element& element = mesh_->element(i, j);
      const auto G = element.gradient.leftCols<2 * Side>();
      const auto B = element.bending.topLeftCorner<2 * Side, 2 * Side>();
      const auto dB = by_->bending[k].template topLeftCorner<2 * Side, 2 * Side>();
      using Operator = Eigen::Matrix<double, 16, 2 * Side>;
      const Operator dG = by_->gradient.empty()
                              ? Operator(Operator::Zero())
                              : Operator(by_->gradient[k].template leftCols<2 * Side>());
      const auto gather = [&](const Nodal& N) {
        Block U;
        U << N.middleRows<Side>(low), N.middleRows<Side>(high);
        return U;
      };
      const auto add = [&](const Block& F, Nodal& to) {
        to.middleRows<Side>(low) += F.template topRows<Side>();
        to.middleRows<Side>(high) += F.template bottomRows<Side>();
      };
      // stresses times weight, and their rates
      const auto stress = [&](const Stress<double>& e) {
        return weighted(stress_of(mesh_->membrane(), e), element.weight);
      };
      const auto stress_rate = [&](const Stress<double>& e, const Stress<double>& de) {
        Stress<double> dn = stress(de) + weighted(stress_of(by_->membrane, e), element.weight);
        if (!by_->weight.empty()) dn += weighted(stress_of(mesh_->membrane(), e), by_->weight[k]);
        return dn;
      };
      const Block U1 = gather(N1.value), dU1 = gather(N1.rate);
      const Gradient<double> a1 = G * U1, da1 = dG * U1 + G * dU1;
      const Stress<double> e1 = strain_product(a0_, a1), de1 = strain_product(a0_, da1),
                           n1 = stress(e1), dn1 = stress_rate(e1, de1);
      const Gradient<double> s1 = stress_times(n1, a0_), ds1 = stress_times(dn1, a0_);
      add(G.transpose() * s1 + B * U1, f[0].value);
      add(dG.transpose() * s1 + G.transpose() * ds1 + dB * U1 + B * dU1, f[0].rate);
      if (!N2) continue;
      const Block U2 = gather(N2->value), dU2 = gather(N2->rate);
      const Gradient<double> a2 = G * U2, da2 = dG * U2 + G * dU2;
      const Stress<double> e2 = 0.5 * strain_product(a1, a1) + strain_product(a0_, a2),
                           de2 = strain_product(a1, da1) + strain_product(a0_, da2),
                           n2 = stress(e2), dn2 = stress_rate(e2, de2);
      const Gradient<double> s2 = stress_times(n2, a0_) + stress_times(n1, a1),
                             ds2 = stress_times(dn2, a0_) + stress_times(dn1, a1) +
                                   stress_times(n1, da1);
      add(G.transpose() * s2 + B * U2, f[1].value);
      add(dG.transpose() * s2 + G.transpose() * ds2 + dB * U2 + B * dU2, f[1].rate);
    }
  return f;
}

// Second derivatives of a quadratic form of the shapes, for all pairs, by polarisation as in
// second_order_forces().
template <class Form>
MatrixXd polarised(const MatrixXd& shapes, const MatrixXd& shape_rates, const Form& form) {
  const int m = static_cast<int>(shapes.cols());
  const VectorXd size = shapes.colwise().norm();
  const auto along = [&](const VectorXd& weight) -> VectorXd {
    return form(shapes * weight, shape_rates * weight);
  };
  std::vector<VectorXd> own;
  for (int i = 0; i < m; ++i) own.push_back(along(VectorXd::Unit(m, i) / size[i]));
  MatrixXd result(own[0].size(), m * (m + 1) / 2);
  for (int j = 0; j < m; ++j)
    for (int i = 0; i <= j; ++i) {
      auto column = result.col(pair_index(i, j));
      if (i == j)
        column = 2 * own[i];
      else
        column = along(VectorXd::Unit(m, i) / size[i] + VectorXd::Unit(m, j) / size[j]) - own[i] -
                 own[j];
      column *= size[i] * size[j];
    }
  return result;
}

}  // namespace

std::shared_ptr<const ModalModelRate> shared_model_rate(
    LeafRates& rates, const std::shared_ptr<const ModalModel>& model) {
  return rates.of<ModalModelRate>(
      model, [&] { return ModalModelRate(*model, shared_mesh_rate(rates, model->mesh())); });
}

ModalModelRate::ModalModelRate(const ModalModel& model, std::shared_ptr<const PlateMeshRate> rate)
    : mesh(std::move(rate)) {
  const PlateMesh& of = *model.mesh();
  PlateLeaf plate(model.mesh());
  plate.linearise();
  const BlockTridiagonal lines = plate.line_factor();
  const int n = plate.unknowns(), u = model.slopes(), inner = n - 2 * u,
            functions = of.functions_per_line(), n3 = 3 * functions, count = of.lines();
  const MatrixXd& follow = model.line_shapes();
  const MatrixXd J0 = plate.edge_jacobian(0).leftCols(u), J1 = plate.edge_jacobian(1).leftCols(u);
  const auto slopes = [&](const MatrixXd& field) {
    MatrixXd b(2 * n3, field.cols());
    b << J0 * field.topRows(u), J1 * field.bottomRows(u);
    return b;
  };
  const auto whole = [&](MatrixXd field) {
    field.middleRows(u, inner) += follow * slopes(field);
    return field;
  };
  const MatrixXd field_forces = plate.tangent_times(whole(model.fields()));
  plate.eliminate();
  const Rows12x6 G = chord_edge_map(Vector6d::Zero());
  const MatrixXd shapes = boundary_modes(plate) * G;
  const MatrixXd forces = second_order_forces(plate, shapes);
  const MatrixXd held = derivatives_edges_held(plate, forces);
  const auto held_shape = [&](const VectorXd& x) {
    VectorXd shape = VectorXd::Zero(n + 12);
    shape.head(n) = x;
    return shape;
  };
  // nodal values of the edges (functions × 3 each), one column
  const auto of_edges = [&](const Nodal& N) {
    VectorXd b(2 * n3);
    b << N.topRows(functions).reshaped(), N.bottomRows(functions).reshaped();
    return b;
  };
  const ChordLeaf chord(model.mesh());
  const Eigen::Matrix2d ray = Eigen::Matrix2d::Identity();
  const bool has_third = !model.slaved() && model.set() == ModalDerivativeSet::third_order;
  const FieldExpansion expansion = has_third ? expand_fields(chord, ray, 3) : FieldExpansion{};
  for (int p = 0; p < 3; ++p) {
    const Undeflected leaf(plate, mesh->shape[p], p == ShapeParameter::width);
    Shape& r = shape[p];
    r.rest = VectorXd::Zero(n);
    r.edges_at_rest = VectorXd::Zero(2 * n3);
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < of.nodes_per_line(); ++j) {
        const double y = leaf.widening() * of.y()[j];
        if (plate.is_rigid_edge(i)) {
          r.edges_at_rest[(i == 0 ? 0 : n3) + functions + 4 * j] = y;
          continue;
        }
        const Eigen::Index block = plate.block_offset(i);
        r.rest[block + functions + 4 * j] = y;
        if (!mesh->shape[p].undeflected.empty())  // the lines move
          r.rest[block + 4 * j] = mesh->shape[p].undeflected[i](4 * j, 0);
      }

    r.follow.resize(inner, 2 * n3);
    for (int k = 0; k < 2 * n3; ++k) {
      Nodal N(count * functions, 3);
      const VectorXd unit = VectorXd::Unit(2 * n3, k);
      N.topRows(functions) = unit.head(n3).reshaped(functions, 3);
      N.bottomRows(functions) = unit.tail(n3).reshaped(functions, 3);
      for (int i = 1; i + 1 < count; ++i)
        N.middleRows(i * functions, functions) =
            follow.col(k).segment((i - 1) * n3, n3).reshaped(functions, 3);
      r.follow.col(k) = -leaf.rows(leaf.tangent_rate(N)).segment(u, inner);
    }
    lines.solve(r.follow);

    MatrixXd shape_rates = MatrixXd::Zero(n + 12, 6);
    for (int k = 0; k < 6; ++k)
      shape_rates.col(k).head(n) = -leaf.rows(leaf.tangent_rate(leaf.nodes(shapes.col(k))) +
                                              leaf.tangent_times(leaf.edge_rates(shapes.col(k))));
    MatrixXd X = shape_rates.topRows(n);
    plate.solve(X);
    shape_rates.topRows(n) = X;
    r.boundary = X;
    r.boundary.middleRows(u, inner).setZero();

    r.theta =
        -polarised(shapes, shape_rates, [&](const VectorXd& shape, const VectorXd& shape_rate) {
          return leaf.second_order_rate(shape, shape_rate);
        });
    for (int k = 0; k < 21; ++k)
      r.theta.col(k) -= leaf.rows(leaf.tangent_rate(leaf.nodes(held_shape(held.col(k)))));
    plate.solve(r.theta);
    // less what the lines between follow of the edges
    const MatrixXd b2 =
        slopes(held) +
        polarised(shapes, shape_rates, [&](const VectorXd& shape, const VectorXd& shape_rate) {
          return of_edges(leaf.second_nodes(shape, shape_rate).value);
        });
    const MatrixXd b2_rate =
        slopes(r.theta) +
        polarised(shapes, shape_rates, [&](const VectorXd& shape, const VectorXd& shape_rate) {
          return of_edges(leaf.second_nodes(shape, shape_rate).rate);
        });
    r.theta.middleRows(u, inner) -= r.follow * b2 + follow * b2_rate;
    for (int k = 0; k < 21; ++k)
      if (model.derivatives().col(k).isZero(0)) r.theta.col(k).setZero();

    r.fields.resize(n, 0);
    if (model.slaved()) continue;
    MatrixXd candidates = MatrixXd::Zero(n, model.combination().rows());
    candidates.leftCols(21) = r.theta;
    if (has_third) {
      VectorXd state_rate = VectorXd::Zero(n + 3);
      state_rate.head(n) = r.rest;
      const FieldExpansion third_rate = third_order(expand_fields_rate(
          chord, ray, expansion.fields, mesh->shape[p], leaf.widening(), state_rate));
      candidates.rightCols(third_rate.fields.cols()) =
          third_rate.fields.topRows(n) - edge_share(third_rate, model.boundary(), follow) -
          edge_share(third_order(expansion), r.boundary, r.follow);
    }
    r.fields = candidates * model.combination();
    // less what stays in the span, which is large where candidates are nearly dependent
    r.fields -= model.fields() * (field_forces.transpose() * whole(r.fields));
  }
}

}  // namespace flexopt
