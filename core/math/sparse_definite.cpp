#include "core/math/sparse_definite.hpp"

#include <dmumps_c.h>
#include <fmt/format.h>

#include <Eigen/Core>
#include <new>

#include "core/math/dense_products.hpp"

namespace flexopt {
namespace {

std::mutex in_mumps;

// Numbers of entries of MUMPS's arrays are those of its manual, from 1.
constexpr int order_choice = 7, more_memory = 14, threads = 16, columns_at_once = 27;
constexpr int status = 1, negative_pivots = 12, megabytes = 22;
constexpr int wants_more = -9, structurally_singular = -6, numerically_singular = -10;

using Columns = Eigen::Map<MatrixXd, 0, Eigen::OuterStride<>>;
using ConstColumns = Eigen::Map<const MatrixXd, 0, Eigen::OuterStride<>>;

bool is(const char* given, char letter) { return (*given | 0x20) == letter; }  // either case

template <unsigned shape>
void solve_triangular(const ConstColumns& a, bool left, bool transposed, Columns& b) {
  const auto triangle = a.triangularView<shape>();
  if (left && transposed)
    triangle.transpose().solveInPlace(b);
  else if (left)
    triangle.solveInPlace(b);
  else if (transposed)
    triangle.transpose().template solveInPlace<Eigen::OnTheRight>(b);
  else
    triangle.template solveInPlace<Eigen::OnTheRight>(b);
}

}  // namespace

// The two operations of a BLAS in which MUMPS spends its time, by Eigen's kernels, under the names
// that it calls. The BLAS of the system is used for the rest; the reference one, which is Debian's
// default, would take ten times as long for these.
extern "C" {
[[gnu::visibility("default")]] void dgemm_(const char* a_as, const char* b_as, const int* rows,
                                           const int* cols, const int* inner, const double* alpha,
                                           const double* a, const int* a_step, const double* b,
                                           const int* b_step, const double* beta, double* c,
                                           const int* c_step) {
  using dense::Strided;
  Columns sum(c, *rows, *cols, Eigen::OuterStride<>(*c_step));
  if (*beta == 0)
    sum.setZero();
  else if (*beta != 1)
    sum *= *beta;
  if (sum.size() == 0 || *inner == 0 || *alpha == 0) return;
  const auto factor = [](const double* data, int m, int n, int step, bool transposed) {
    return transposed ? Strided<const double>{data, m, n, step, 1}
                      : Strided<const double>{data, m, n, 1, step};
  };
  dense::multiply({c, *rows, *cols, 1, *c_step}, dense::Write::add, *alpha,
                  factor(a, *rows, *inner, *a_step, !is(a_as, 'n')),
                  factor(b, *inner, *cols, *b_step, !is(b_as, 'n')));
}

[[gnu::visibility("default")]] void dtrsm_(const char* side, const char* triangle, const char* a_as,
                                           const char* diagonal, const int* rows, const int* cols,
                                           const double* alpha, const double* a, const int* a_step,
                                           double* b, const int* b_step) {
  const bool left = is(side, 'l'), transposed = !is(a_as, 'n'), unit = is(diagonal, 'u');
  const int size = left ? *rows : *cols;
  const ConstColumns factor(a, size, size, Eigen::OuterStride<>(*a_step));
  Columns answer(b, *rows, *cols, Eigen::OuterStride<>(*b_step));
  if (answer.size() == 0) return;
  if (*alpha != 1) answer *= *alpha;
  const auto solve =
      is(triangle, 'u')
          ? (unit ? solve_triangular<Eigen::UnitUpper> : solve_triangular<Eigen::Upper>)
          : (unit ? solve_triangular<Eigen::UnitLower> : solve_triangular<Eigen::Lower>);
  solve(factor, left, transposed, answer);
}
}

std::mutex& mumps_mutex() { return in_mumps; }

struct DefiniteFactor::Mumps {
  DMUMPS_STRUC_C data{};

  Mumps() {
    data.par = 1;
    data.sym = 1;                 // positive definite
    data.comm_fortran = -987654;  // this process alone
    run(-1);
    for (int silent = 1; silent <= 4; ++silent) control(silent) = silent < 4 ? -1 : 0;
    control(order_choice) = 4;  // PORD: always the same, where Scotch begins at random
    control(threads) = 1;
    control(columns_at_once) = 24;
  }
  ~Mumps() { run(-2); }

  MUMPS_INT& control(int k) { return data.icntl[k - 1]; }
  int told(int k) const { return data.infog[k - 1]; }
  int run(int job) {
    data.job = job;
    dmumps_c(&data);
    return told(status);
  }
};

DefiniteFactor::DefiniteFactor() = default;

DefiniteFactor::~DefiniteFactor() {
  const std::lock_guard lock(in_mumps);
  mumps_.reset();
}

std::size_t DefiniteFactor::bytes() const {
  return static_cast<std::size_t>(mumps_->told(megabytes)) << 20;
}

Answer<std::shared_ptr<const DefiniteFactor>> DefiniteFactor::of(const SparseMatrix& A) {
  std::vector<MUMPS_INT> rows, columns;
  std::vector<double> values;
  for (const SparseEntry& e : A.entries())
    if (e.row >= e.column) {
      rows.push_back(e.row + 1);
      columns.push_back(e.column + 1);
      values.push_back(e.value);
    }
  std::shared_ptr<DefiniteFactor> factor(new DefiniteFactor);
  const std::lock_guard lock(in_mumps);
  factor->mumps_ = std::make_unique<Mumps>();
  Mumps& mumps = *factor->mumps_;
  mumps.data.n = A.size();
  mumps.data.nnz = static_cast<MUMPS_INT8>(values.size());
  mumps.data.irn = rows.data();
  mumps.data.jcn = columns.data();
  mumps.data.a = values.data();
  int done = mumps.run(4);
  while (done == wants_more && mumps.control(more_memory) < 400) {
    mumps.control(more_memory) *= 3;  // percent above its estimate
    done = mumps.run(2);
  }
  mumps.data.irn = mumps.data.jcn = nullptr;
  mumps.data.a = nullptr;
  const bool singular = done == structurally_singular || done == numerically_singular;
  if (done < 0 && !singular) throw std::bad_alloc();
  if (singular || mumps.told(negative_pivots) > 0)
    return Because(fmt::format("a matrix of {} unknowns is not positive definite", A.size()));
  return factor;
}

void DefiniteFactor::solve(MatrixXd& B) const {
  if (B.size() == 0) return;
  const std::lock_guard lock(in_mumps);
  DMUMPS_STRUC_C& data = mumps_->data;
  data.rhs = B.data();
  data.nrhs = static_cast<MUMPS_INT>(B.cols());
  data.lrhs = static_cast<MUMPS_INT>(B.rows());
  const int done = mumps_->run(3);
  data.rhs = nullptr;
  if (done < 0) throw std::bad_alloc();
}

}  // namespace flexopt
