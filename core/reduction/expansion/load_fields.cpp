#include "core/reduction/expansion/load_fields.hpp"

#include <cassert>
#include <memory>

#include "core/math/dual.hpp"
#include "core/reduction/expansion/tube_series.hpp"

namespace flexopt {
namespace {

constexpr int load_order = 2;
using Number = Dual<field_loads>;
using Numbers = Eigen::Matrix<Number, Eigen::Dynamic, Eigen::Dynamic>;

// Matrix of the values, then of one derivative after the other, side by side.
MatrixXd parts_of(const Numbers& A, int first, int parts) {
  MatrixXd all(A.rows(), parts * A.cols());
  for (Eigen::Index c = 0; c < A.cols(); ++c)
    for (Eigen::Index r = 0; r < A.rows(); ++r) {
      const Number& x = A(r, c);
      for (int p = 0; p < parts; ++p)
        all(r, p * A.cols() + c) = first + p == 0 ? x.value : x.derivatives[first + p - 1];
    }
  return all;
}
// Numbers with derivatives from the first `columns` of each part.
Numbers numbers_of(const MatrixXd& all, Eigen::Index columns) {
  constexpr int parts = 1 + field_loads;
  const Eigen::Index part = all.cols() / parts;
  Numbers A(all.rows(), columns);
  for (Eigen::Index c = 0; c < columns; ++c)
    for (Eigen::Index r = 0; r < A.rows(); ++r) {
      A(r, c).value = all(r, c);
      for (int p = 1; p < parts; ++p) A(r, c).derivatives[p - 1] = all(r, p * part + c);
    }
  return A;
}

// An operator of the mesh, which does not depend on loads.
struct Operator {
  const PlateMesh::Matrix16* matrix;
};
Numbers times(const Operator& A, Eigen::Index rows, const Numbers& B) {
  return numbers_of(flexopt::times(*A.matrix, rows, parts_of(B, 0, 1 + field_loads)), B.cols());
}
Numbers transposed_times(const Operator& A, Eigen::Index rows, const Numbers& B) {
  return numbers_of(flexopt::transposed_times(*A.matrix, rows, parts_of(B, 0, 1 + field_loads)),
                    B.cols());
}

// A mesh whose numbers carry derivatives along loads.
class LoadedMesh {
 public:
  struct Element {
    Operator gradient, bending;
    const PlateMesh::Weights& weight;
  };
  struct Membrane {
    Number A11, A12, A33;
  };
  struct LineWidth {
    Number factor = 1.0, slope = 0.0;
  };

  explicit LoadedMesh(const PlateMesh& mesh) : mesh_(mesh) {}
  Membrane membrane() const {
    const PlateMesh::Membrane& A = mesh_.membrane();
    return {A.A11, A.A12, A.A33};
  }
  const std::vector<double>& y() const { return mesh_.y(); }
  LineWidth line_width(int) const { return {}; }  // leaves of uniform width alone
  Element element(int i, int j) const {
    const PlateMesh::Element& e = mesh_.element(i, j);
    return {{&e.gradient}, {&e.bending}, e.weight};
  }

 private:
  const PlateMesh& mesh_;
};

std::vector<Numbers> nodal_loads(const PlateMesh& mesh, const MatrixXd& loads) {
  const int n = mesh.functions_per_line();
  std::vector<Numbers> lines;
  for (int i = 0; i < mesh.lines(); ++i) {
    Numbers& line = lines.emplace_back(n, 3);
    for (int c = 0; c < 3; ++c)
      for (int s = 0; s < n; ++s) {
        line(s, c) = 0.0;
        for (int p = 0; p < field_loads; ++p)
          line(s, c).derivatives[p] = loads((3 * i + c) * n + s, p);
      }
  }
  return lines;
}

}  // namespace

FieldExpansion expand_load_fields(const ChordLeaf& leaf, const Eigen::Matrix2d& ray,
                                  const MatrixXd& fields, const InternalLoads& loads) {
  const MonomialTable& table = monomials<6, load_order>();
  const PlateMesh& mesh = leaf.plate().mesh();
  const int m = table.size();
  assert(fields.cols() >= m && loads.loads.cols() == field_loads);
  assert(loads.loads.rows() == 3 * mesh.functions_per_line() * mesh.lines());
  const FieldSolver solve(leaf);
  const LoadedMesh loaded(mesh);
  auto series = std::make_unique<TubeSeries<load_order, LoadedMesh>>(leaf, loaded, ray, load_order);
  series->set_nodal_load(nodal_loads(mesh, loads.loads),
                         {loads.parity.across.begin(), loads.parity.across.end()});
  MatrixXd all = MatrixXd::Zero(fields.rows(), (1 + field_loads) * m);
  all.leftCols(m) = fields.leftCols(m);
  for (int d = 0; d <= load_order; ++d) {
    series->set_fields(numbers_of(all, table.count(d)));
    const MatrixXd Y = solve(parts_of(series->residual(d), 1, field_loads));
    const Eigen::Index nd = Y.cols() / field_loads;
    for (int p = 0; p < field_loads; ++p)
      all.middleCols((1 + p) * m + table.count(d - 1), nd) = Y.middleCols(p * nd, nd);
  }
  series->set_fields(numbers_of(all, m));
  return {all.rightCols(field_loads * m), parts_of(series->nodal(), 1, field_loads)};
}

}  // namespace flexopt
