// The quadratic forms of a full leaf and what they change by: (S7)–(S9) of core/response/README.md.
#include <cassert>

#include "core/elements/plate/element_quadratic.hpp"
#include "core/elements/plate/plate_fields.hpp"
#include "core/elements/plate/plate_gradient.hpp"

namespace flexopt {

using namespace plate;

template <class S>
template <int Side>
void PlateGradient<S>::quadratic_elements(const std::vector<Matrix>& N1,
                                          const std::vector<Matrix>& N2, const Vector& mu,
                                          LeafQuadratic<S>& q, std::vector<Matrix>& n0,
                                          std::vector<Matrix>& n1) const {
  const int nx = mesh_->elements_along(), ny = mesh_->elements_across();
  const Matrix zero =
      Matrix::Zero(mesh_->functions_per_line(), 3 * static_cast<Eigen::Index>(mu.size()));
  const auto or_zero = [&](const Matrix& N) -> const Matrix& { return N.size() > 0 ? N : zero; };
  ElementQuadratic<S, Side> elements(*mesh_, *rate_, mu, q);
  typename ElementQuadratic<S, Side>::Block U1, U2;
  for (int i = 0; i < nx; ++i) {
    const bool curved = N2[i].size() > 0 || N2[i + 1].size() > 0,
               moved = n1[i].size() > 0 || n1[i + 1].size() > 0;
    for (int j = 0; j < ny; ++j) {
      const int k = i * ny + j;
      U1 = gather<Side>(N1[i], N1[i + 1], j);
      if (curved) U2 = gather<Side>(or_zero(N2[i]), or_zero(N2[i + 1]), j);
      elements.add({k, mesh_->element(i, j), a0_[k], strain_[k], n0_[k], natural_[k]},
                   gather<Side>(state_.nodal[i], state_.nodal[i + 1], j), U1,
                   curved ? &U2 : nullptr, moved);
      const auto add = [&](Matrix& to, const auto& rows) {
        if (to.size() > 0) to.template middleRows<Side>(4 * j) += rows;
      };
      if (moved) {
        add(n1[i], elements.n1().template topRows<Side>());
        add(n1[i + 1], elements.n1().template bottomRows<Side>());
      }
      add(n0[i], elements.n0().template topRows<Side>());
      add(n0[i + 1], elements.n0().template bottomRows<Side>());
    }
  }
}

// N2 = ω×(ω×v) + 2 Σ ȧ ω×d with v = R w and axes d.
template <class S>
auto PlateGradient<S>::second_nodes(int e, const Matrix& Y) const -> Matrix {
  const int n = mesh_->functions_per_line(), columns = static_cast<int>(Y.cols());
  Matrix second = Matrix::Zero(n, 3 * columns);
  for (int k = 0; k < columns; ++k) {
    const Vector3<S> w = Y.template block<3, 1>(rows_.body(e) + 3, k);
    for (int s = 0; s < n; ++s) {
      Vector3<S> r = w.cross(w.cross(edges_[e].arm[s]));
      mesh_->each_slope(s, [&](int axis, int unknown) {
        r += S(2.0 * Y(plate_->block_offset(edges_[e].line) + unknown, k)) *
             w.cross(edges_[e].axes.col(axis));
      });
      second.template block<1, 3>(s, 3 * k) = r.transpose();
    }
  }
  return second;
}

// The nodes move by N1 = line_rates(y); of these the edges' depend on their axes and arms.
template <class S>
std::unique_ptr<LeafFields> PlateGradient<S>::motion_fields(
    const Vector& y, const Matrix& rows, const std::vector<LeafVariation<S>>& variations) const {
  if constexpr (std::is_same_v<S, double>) {
    if (mesh_->shape().fold) return nullptr;
    const std::array<Matrix, 2> edges = edge_nodal_rates(variations);
    const auto count = static_cast<Eigen::Index>(variations.size());
    Matrix moved = Matrix::Zero(size(), count);  // increments turn and shrink
    std::vector<ShapeRate> shapes;
    for (Eigen::Index p = 0; p < count; ++p) {
      const LeafVariation<S>& v = variations[static_cast<std::size_t>(p)];
      shapes.push_back(rate_->along(v.shape));
      for (const int body : {rows_.body(0), rows_.body(1)}) {
        const Vector3<S> u = y.template segment<3>(body);
        moved.col(p).template segment<3>(body) = v.turn * u - v.length * u;
        moved.col(p).template segment<3>(body + 3) = v.turn * y.template segment<3>(body + 3);
      }
    }
    std::vector<Matrix> nodal, rates;
    for (int i = 0; i < mesh_->lines(); ++i) {
      nodal.push_back(line_rates(i, y));
      rates.push_back(line_rates(i, moved));
      if (const int e = edge_at(i); e >= 0)
        add_edge_motion_rates(e, y, rows, line_rates(i, rows) + edges[e], variations, rates.back());
    }
    return std::make_unique<PlateFields>(*mesh_, std::move(nodal), std::move(rates),
                                         std::move(shapes));
  } else {
    return nullptr;
  }
}

template <class S>
void PlateGradient<S>::add_edge_motion_rates(int e, const Vector& y, const Matrix& rows,
                                             const Matrix& nodes,
                                             const std::vector<LeafVariation<S>>& variations,
                                             Matrix& rates) const {
  const int body = rows_.body(e), first = plate_->block_offset(edges_[e].line);
  const Vector3<S> spin = y.template segment<3>(body + 3);
  for (int p = 0; p < static_cast<int>(variations.size()); ++p) {
    const LeafVariation<S>& v = variations[p];
    const Vector3<S> u = rows.template block<3, 1>(body, p),
                     w = rows.template block<3, 1>(body + 3, p);
    for (int s = 0; s < mesh_->functions_per_line(); ++s) {
      Vector3<S> arm = nodes.template block<1, 3>(s, 3 * p).transpose();
      if (s % 4 == 0) arm -= u + v.edge[e].position;
      Vector3<S> r = spin.cross(arm);
      mesh_->each_slope(s, [&](int axis, int unknown) {
        r +=
            y[first + unknown] * (w.cross(edges_[e].axes.col(axis)) + v.edge[e].rotation.col(axis));
      });
      rates.template block<1, 3>(s, 3 * p) += r.transpose();
    }
  }
}

// Adds the quadratic terms of an edge: N0 = p + v, N1 = u̇ + ω×v + Σ ȧ d, and N2.
template <class S>
void PlateGradient<S>::add_edge_quadratic(int e, const Matrix& Y, const Matrix& n0,
                                          const Matrix& n1, LeafQuadratic<S>& q) const {
  const int n = mesh_->functions_per_line(), columns = static_cast<int>(Y.cols()),
            line = edges_[e].line, body = rows_.body(e);
  const Matrix3<S>& R = edges_[e].axes;
  for (int k = 0; k < columns; ++k) {
    typename LeafQuadratic<S>::Edge& g = q.edge[k][e];
    const Vector3<S> w = Y.template block<3, 1>(body + 3, k);
    for (int s = 0; s < n; ++s) {
      const Vector3<S> f0 = n0.template block<1, 3>(s, 3 * k).transpose(),
                       f1 = n1.template block<1, 3>(s, 3 * k).transpose(),
                       f2 = nodal_force_[line].row(s).transpose();
      const Vector3<S>&v = edges_[e].arm[s], f2w = f2.cross(w);
      const Vector3<S> c = f0 + f1.cross(w) + f2w.cross(w);
      g.rotation += c * edges_[e].local[s].transpose();
      g.spin += v.cross(f1) + w.cross(v).cross(f2) + v.cross(f2w);
      q.state.template block<3, 1>(body + 3, k) += v.cross(c);
      if (s % 4 == 0) {
        g.position += f0;
        g.displacement += f1;
        g.arm += R.transpose() * c;
      }
      for (int p = 0; p < q.shape.rows(); ++p)
        if (!rate_->shape[p].reference.empty())
          q.shape(p, k) +=
              held(e, s) * c.dot(R * rate_->shape[p].reference[line].row(s).transpose());
      mesh_->each_slope(s, [&](int along, int unknown) {
        const int row = plate_->block_offset(line) + unknown;
        const Vector3<S> axis = R.col(along);
        const S rate = Y(row, k);
        const Vector3<S> cd = rate * (f1 + 2.0 * f2w);
        g.rotation.col(along) += cd;
        g.spin += S(2.0 * rate) * axis.cross(f2);
        q.state.template block<3, 1>(body + 3, k) += axis.cross(cd);
        q.state(row, k) += c.dot(axis);
      });
    }
    q.state.template block<3, 1>(body, k) += g.position;
  }
}

// Adds the quadratic terms of the weight w, − Σ m w·N2.
template <class S>
void PlateGradient<S>::add_weight_quadratic(const std::vector<Matrix>& N2,
                                            LeafQuadratic<S>& q) const {
  if (weight_.isZero(0)) return;
  const Vector3<S> weight = weight_.template cast<S>();
  for (int line = 0; line < mesh_->lines(); ++line) {
    const Matrix& second = N2[static_cast<std::size_t>(line)];
    for (Eigen::Index k = 0; 3 * k < second.cols(); ++k) {
      const auto of = second.template middleCols<3>(3 * k);
      const auto moved = [&](const VectorXd& m) {
        return Vector3<S>(of.transpose() * m.template cast<S>());
      };
      const Vector3<S> whole = moved(mesh_->mass_moment(line));
      q.stiffness[k] -= weight.dot(whole);
      q.weight.col(k) -= whole;
      for (int p = 0; p < q.shape.rows(); ++p)
        q.shape(p, k) -= weight.dot(moved(moment_rates_[p][static_cast<std::size_t>(line)]));
    }
  }
}

template <class S>
auto PlateGradient<S>::quadratic(const Matrix& Y, const Vector& mu, int shape) const
    -> LeafQuadratic<S> {
  const int n = mesh_->functions_per_line(), lines = mesh_->lines(),
            columns = static_cast<int>(Y.cols());
  assert(Y.rows() == size() && mu.size() == columns);
  std::vector<Matrix> N1(lines), n0(lines, Matrix::Zero(n, 3 * columns));
  for (int i = 0; i < lines; ++i) N1[i] = line_rates(i, Y);
  std::vector<Matrix> N2(lines), n1(lines);  // of the edges and behind a fold alone
  add_fold_second(Y, N2, n1);
  for (int e = 0; e < 2; ++e) {
    if (!rigid_[e]) continue;
    N2[edges_[e].line] = second_nodes(e, Y);
    n1[edges_[e].line] = Matrix::Zero(n, 3 * columns);
  }
  LeafQuadratic<S> q(size(), columns, shape);
  mesh_->with_side(
      [&]<int Side>() { this->template quadratic_elements<Side>(N1, N2, mu, q, n0, n1); });
  add_point_quadratic(Y, N1, N2, q, n1);
  add_weight_quadratic(N2, q);

  for (int i = 0; i < lines; ++i)
    if (edge_at(i) < 0) add_to_rows(i, n0[i], q.state);
  add_fold_quadratic(Y, n0, n1, q);
  for (int e = 0; e < 2; ++e)
    if (rigid_[e]) add_edge_quadratic(e, Y, n0[edges_[e].line], n1[edges_[e].line], q);
  return q;
}

#define INSTANTIATE_ELEMENTS(S, SIDE)                                                           \
  template void PlateGradient<S>::quadratic_elements<SIDE>(                                     \
      const std::vector<Matrix>&, const std::vector<Matrix>&, const Vector&, LeafQuadratic<S>&, \
      std::vector<Matrix>&, std::vector<Matrix>&) const;
#define INSTANTIATE(S)                                                                        \
  INSTANTIATE_ELEMENTS(S, 8)                                                                  \
  INSTANTIATE_ELEMENTS(S, 4)                                                                  \
  template PlateGradient<S>::Matrix PlateGradient<S>::second_nodes(int, const Matrix&) const; \
  template void PlateGradient<S>::add_edge_quadratic(int, const Matrix&, const Matrix&,       \
                                                     const Matrix&, LeafQuadratic<S>&) const; \
  template void PlateGradient<S>::add_weight_quadratic(const std::vector<Matrix>&,            \
                                                       LeafQuadratic<S>&) const;              \
  template void PlateGradient<S>::add_edge_motion_rates(                                      \
      int, const Vector&, const Matrix&, const Matrix&, const std::vector<LeafVariation<S>>&, \
      Matrix&) const;                                                                         \
  template std::unique_ptr<LeafFields> PlateGradient<S>::motion_fields(                       \
      const Vector&, const Matrix&, const std::vector<LeafVariation<S>>&) const;              \
  template LeafQuadratic<S> PlateGradient<S>::quadratic(const Matrix&, const Vector&, int) const;
INSTANTIATE(double)
INSTANTIATE(Jet)
#undef INSTANTIATE
#undef INSTANTIATE_ELEMENTS

}  // namespace flexopt
