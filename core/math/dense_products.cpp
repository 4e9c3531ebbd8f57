#include "core/math/dense_products.hpp"

#include <cassert>

namespace flexopt::dense {
namespace {

namespace internal = Eigen::internal;  // where Eigen's macro looks
using Eigen::Index;
using Numbers = Strided<const double>;
using ByColumns = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using ByRows =
    Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>, 0,
               Eigen::OuterStride<>>;

template <int order>
using Mapper = Eigen::internal::const_blas_data_mapper<double, Index, order>;

// c += factor A b by Eigen's matrix-vector kernels; `order`: of A's numbers.
template <int order>
void add_vector_product(double* c, Index c_step, double factor, const Numbers& a, Index outer,
                        const double* b, Index b_step) {
  // the column kernel writes, the row kernel reads, a vector without gaps
  if constexpr (order == Eigen::ColMajor) {
    using Kernel =
        Eigen::internal::general_matrix_vector_product<Index, double, Mapper<Eigen::ColMajor>,
                                                       Eigen::ColMajor, false, double,
                                                       Mapper<Eigen::RowMajor>, false>;
    if (c_step == 1) {
      Kernel::run(a.rows, a.cols, {a.data, outer}, {b, b_step}, c, 1, factor);
      return;
    }
    ei_declare_aligned_stack_constructed_variable(double, sum, a.rows, nullptr);
    for (Index i = 0; i < a.rows; ++i) sum[i] = c[i * c_step];
    Kernel::run(a.rows, a.cols, {a.data, outer}, {b, b_step}, sum, 1, factor);
    for (Index i = 0; i < a.rows; ++i) c[i * c_step] = sum[i];
  } else {
    using Kernel =
        Eigen::internal::general_matrix_vector_product<Index, double, Mapper<Eigen::RowMajor>,
                                                       Eigen::RowMajor, false, double,
                                                       Mapper<Eigen::ColMajor>, false>;
    if (b_step == 1) {
      Kernel::run(a.rows, a.cols, {a.data, outer}, {b, 1}, c, c_step, factor);
      return;
    }
    ei_declare_aligned_stack_constructed_variable(double, vector, a.cols, nullptr);
    for (Index k = 0; k < a.cols; ++k) vector[k] = b[k * b_step];
    Kernel::run(a.rows, a.cols, {a.data, outer}, {vector, 1}, c, c_step, factor);
  }
}

void add_vector_product(double* c, Index c_step, double factor, const Numbers& a, const double* b,
                        Index b_step) {
  if (a.row_step == 1)
    add_vector_product<Eigen::ColMajor>(c, c_step, factor, a, a.col_step, b, b_step);
  else
    add_vector_product<Eigen::RowMajor>(c, c_step, factor, a, a.row_step, b, b_step);
}

// Eigen's own limit, below which packing the factors costs more than it saves.
bool is_small(Index rows, Index inner, Index columns) {
  return rows + inner + columns < EIGEN_GEMM_TO_COEFFBASED_THRESHOLD;
}

template <class A, class B>
void multiply_maps(Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> c, Write write,
                   double factor, const A& a, const B& b) {
  if (is_small(a.rows(), a.cols(), b.cols())) {
    if (write == Write::set)
      c.noalias() = factor * a.lazyProduct(b);
    else
      c.noalias() += factor * a.lazyProduct(b);
    return;
  }
  if (write == Write::set) c.setZero();
  using Blocking =
      Eigen::internal::gemm_blocking_space<Eigen::ColMajor, double, double, Eigen::Dynamic,
                                           Eigen::Dynamic, Eigen::Dynamic>;
  constexpr int a_order = A::IsRowMajor ? Eigen::RowMajor : Eigen::ColMajor,
                b_order = B::IsRowMajor ? Eigen::RowMajor : Eigen::ColMajor;
  Blocking blocking(c.rows(), c.cols(), a.cols(), 1, true);
  Eigen::internal::general_matrix_matrix_product<Index, double, a_order, false, double, b_order,
                                                 false, Eigen::ColMajor, 1>::run(a.rows(), b.cols(),
                                                                                 a.cols(), a.data(),
                                                                                 a.outerStride(),
                                                                                 b.data(),
                                                                                 b.outerStride(),
                                                                                 c.data(), 1,
                                                                                 c.outerStride(),
                                                                                 factor, blocking,
                                                                                 nullptr);
}

bool has_gaps(const Numbers& a) { return a.row_step != 1 && a.col_step != 1; }

Eigen::MatrixXd without_gaps(const Numbers& a) {
  using Steps = Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>;
  return Eigen::Map<const Eigen::MatrixXd, 0, Steps>(a.data, a.rows, a.cols,
                                                     Steps(a.col_step, a.row_step));
}

Numbers numbers(const Eigen::MatrixXd& a) { return {a.data(), a.rows(), a.cols(), 1, a.rows()}; }

Strided<const double> transposed(const Numbers& a) {
  return {a.data, a.cols, a.rows, a.col_step, a.row_step};
}

void set_zero(const Strided<double>& c) {
  for (Index j = 0; j < c.cols; ++j)
    for (Index i = 0; i < c.rows; ++i) c.data[i * c.row_step + j * c.col_step] = 0;
}

// A product of which a factor has gaps inside its columns.
void multiply_copies(const Strided<double>& c, Write write, double factor, const Numbers& a,
                     const Numbers& b) {
  if (has_gaps(a)) {
    const Eigen::MatrixXd copy = without_gaps(a);
    multiply(c, write, factor, numbers(copy), b);
  } else {
    const Eigen::MatrixXd copy = without_gaps(b);
    multiply(c, write, factor, a, numbers(copy));
  }
}

// A product into a matrix with gaps inside its columns.
void multiply_into_gaps(const Strided<double>& c, Write write, double factor, const Numbers& a,
                        const Numbers& b) {
  Eigen::MatrixXd sum(c.rows, c.cols);
  multiply({sum.data(), c.rows, c.cols, 1, c.rows}, Write::set, factor, a, b);
  if (write == Write::set) set_zero(c);
  for (Index j = 0; j < c.cols; ++j)
    for (Index i = 0; i < c.rows; ++i) c.data[i * c.row_step + j * c.col_step] += sum(i, j);
}

}  // namespace

void multiply(const Strided<double>& c, Write write, double factor, const Numbers& a,
              const Numbers& b) {
  assert(c.rows == a.rows && c.cols == b.cols && a.cols == b.rows);
  if (c.rows == 0 || c.cols == 0) return;
  if (a.cols == 0) {
    if (write == Write::set) set_zero(c);
    return;
  }
  if (has_gaps(a) || has_gaps(b)) {
    multiply_copies(c, write, factor, a, b);
    return;
  }
  if ((c.cols == 1 || c.rows == 1) && !is_small(c.rows, a.cols, c.cols)) {
    if (write == Write::set) set_zero(c);
    if (c.cols == 1)
      add_vector_product(c.data, c.row_step, factor, a, b.data, b.row_step);
    else
      add_vector_product(c.data, c.col_step, factor, transposed(b), a.data, a.col_step);
    return;
  }
  if (c.row_step != 1 && c.col_step == 1) {  // by rows: cᵀ = bᵀ aᵀ
    multiply({c.data, c.cols, c.rows, 1, c.row_step}, write, factor, transposed(b), transposed(a));
    return;
  }
  if (c.row_step != 1) {
    multiply_into_gaps(c, write, factor, a, b);
    return;
  }
  const Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> target(
      c.data, c.rows, c.cols, Eigen::OuterStride<>(c.col_step));
  const auto by_columns = [](const Numbers& m) {
    return ByColumns(m.data, m.rows, m.cols, Eigen::OuterStride<>(m.col_step));
  };
  const auto by_rows = [](const Numbers& m) {
    return ByRows(m.data, m.rows, m.cols, Eigen::OuterStride<>(m.row_step));
  };
  const bool a_columns = a.row_step == 1, b_columns = b.row_step == 1;
  if (a_columns && b_columns)
    multiply_maps(target, write, factor, by_columns(a), by_columns(b));
  else if (a_columns)
    multiply_maps(target, write, factor, by_columns(a), by_rows(b));
  else if (b_columns)
    multiply_maps(target, write, factor, by_rows(a), by_columns(b));
  else
    multiply_maps(target, write, factor, by_rows(a), by_rows(b));
}

}  // namespace flexopt::dense
