#include "core/math/sparse_definite.hpp"

#include <dmumps_c.h>
#include <fmt/format.h>

#include <new>

namespace flexopt {
namespace {

std::mutex in_mumps;

// Numbers of entries of MUMPS's arrays are those of its manual, from 1.
constexpr int order_choice = 7, more_memory = 14, threads = 16, columns_at_once = 27;
constexpr int status = 1, negative_pivots = 12, megabytes = 22;
constexpr int wants_more = -9, structurally_singular = -6, numerically_singular = -10;

}  // namespace

std::mutex& mumps_mutex() { return in_mumps; }

struct DefiniteFactor::Mumps {
  DMUMPS_STRUC_C data{};

  Mumps() {
    data.par = 1;
    data.sym = 1;                 // positive definite
    data.comm_fortran = -987654;  // this process alone
    run(-1);
    for (int silent = 1; silent <= 4; ++silent) control(silent) = silent < 4 ? -1 : 0;
    control(order_choice) = 7;  // its own choice: METIS or Scotch
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
