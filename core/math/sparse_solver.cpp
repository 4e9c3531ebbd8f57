#include "core/math/sparse_solver.hpp"

#include <cholmod.h>
#include <umfpack.h>

#include <algorithm>
#include <limits>
#include <list>
#include <new>
#include <numeric>

namespace flexopt {
namespace {

using Index = SuiteSparse_long;

// Columns, one after the other, rows ascending.
struct Columns {
  std::vector<Index> begin, row;
  std::vector<double> value;

  bool same_pattern(const Columns& other) const { return begin == other.begin && row == other.row; }
};

// Sorted by counting, twice: by rows, then by columns.
Columns columns_of(const SparseMatrix& A, bool lower_only) {
  const auto n = static_cast<std::size_t>(A.size());
  const std::vector<SparseEntry>& entries = A.entries();
  const auto left_out = [&](std::size_t k) {
    return lower_only && entries[k].row < entries[k].column;
  };
  std::vector<std::size_t> by_row(n + 1, 0);
  std::vector<std::size_t> places;
  places.reserve(entries.size());
  for (std::size_t k = 0; k < entries.size(); ++k)
    if (!left_out(k)) ++by_row[static_cast<std::size_t>(entries[k].row) + 1];
  for (std::size_t r = 0; r < n; ++r) by_row[r + 1] += by_row[r];
  places.resize(by_row[n]);
  for (std::size_t k = 0; k < entries.size(); ++k)
    if (!left_out(k)) places[by_row[static_cast<std::size_t>(entries[k].row)]++] = k;

  std::vector<std::size_t> by_column(n + 1, 0);
  for (const std::size_t k : places) ++by_column[static_cast<std::size_t>(entries[k].column) + 1];
  for (std::size_t c = 0; c < n; ++c) by_column[c + 1] += by_column[c];
  std::vector<std::size_t> sorted(places.size()), next(by_column.begin(), by_column.end() - 1);
  for (const std::size_t k : places)
    sorted[next[static_cast<std::size_t>(entries[k].column)]++] = k;

  Columns columns;
  columns.begin.reserve(n + 1);
  columns.row.reserve(sorted.size());
  columns.value.reserve(sorted.size());
  for (std::size_t c = 0; c < n; ++c) {
    columns.begin.push_back(static_cast<Index>(columns.row.size()));
    const std::size_t first = columns.row.size();
    for (std::size_t s = by_column[c]; s < by_column[c + 1]; ++s) {
      const SparseEntry& e = entries[sorted[s]];
      if (columns.row.size() > first && columns.row.back() == e.row) {
        columns.value.back() += e.value;
      } else {
        columns.row.push_back(e.row);
        columns.value.push_back(e.value);
      }
    }
  }
  columns.begin.push_back(static_cast<Index>(columns.row.size()));
  return columns;
}

constexpr std::size_t most_kept = 8;

cholmod_sparse symmetric_view(Columns& columns) {
  cholmod_sparse A{};
  A.nrow = A.ncol = columns.begin.size() - 1;
  A.nzmax = columns.row.size();
  A.p = columns.begin.data();
  A.i = columns.row.data();
  A.x = columns.value.data();
  A.stype = -1;  // the lower triangle
  A.itype = CHOLMOD_LONG;
  A.xtype = CHOLMOD_REAL;
  A.dtype = CHOLMOD_DOUBLE;
  A.sorted = A.packed = 1;
  return A;
}

}  // namespace

struct SparseAnalyses::Kept {
  struct Lu {
    Columns pattern;
    void* symbolic = nullptr;
  };
  struct Ldl {
    Columns pattern;
    std::vector<int> order;
    cholmod_factor* factor = nullptr;
  };
  cholmod_common common;
  std::list<Lu> lu;
  std::list<Ldl> ldl;

  Kept() {
    cholmod_l_start(&common);
    common.supernodal = CHOLMOD_SIMPLICIAL;
    common.final_ll = 0;
    common.print = 0;
    common.error_handler = nullptr;
  }
  Kept(const Kept&) = delete;
  Kept& operator=(const Kept&) = delete;
  ~Kept() {
    for (Lu& kept : lu) umfpack_dl_free_symbolic(&kept.symbolic);
    for (Ldl& kept : ldl) cholmod_l_free_factor(&kept.factor, &common);
    cholmod_l_finish(&common);
  }
};

SparseAnalyses::SparseAnalyses() : kept_(std::make_unique<Kept>()) {}
SparseAnalyses::~SparseAnalyses() = default;

struct LinearSolver::Factor {
  Columns A;
  void* numeric = nullptr;
  double control[UMFPACK_CONTROL] = {};

  Factor(Columns columns, SparseAnalyses::Kept& kept) : A(std::move(columns)) {
    umfpack_dl_defaults(control);
    auto at =
        std::ranges::find_if(kept.lu, [&](const auto& lu) { return lu.pattern.same_pattern(A); });
    const auto n = static_cast<Index>(A.begin.size()) - 1;
    if (at == kept.lu.end()) {
      if (kept.lu.size() == most_kept) {
        umfpack_dl_free_symbolic(&kept.lu.back().symbolic);
        kept.lu.pop_back();
      }
      kept.lu.push_front({{A.begin, A.row, {}}, nullptr});
      at = kept.lu.begin();
      const Index status = umfpack_dl_symbolic(n, n, A.begin.data(), A.row.data(), A.value.data(),
                                               &at->symbolic, control, nullptr);
      if (status != UMFPACK_OK) {
        kept.lu.pop_front();
        throw std::bad_alloc();
      }
    } else {
      kept.lu.splice(kept.lu.begin(), kept.lu, at);
    }
    const Index status = umfpack_dl_numeric(A.begin.data(), A.row.data(), A.value.data(),
                                            at->symbolic, &numeric, control, nullptr);
    if (status != UMFPACK_OK) umfpack_dl_free_numeric(&numeric);
    if (status == UMFPACK_ERROR_out_of_memory) throw std::bad_alloc();
  }
  Factor(const Factor&) = delete;
  Factor& operator=(const Factor&) = delete;
  ~Factor() { umfpack_dl_free_numeric(&numeric); }
};

LinearSolver::LinearSolver(const SparseMatrix& A, std::shared_ptr<SparseAnalyses> analyses) {
  if (analyses)
    sparse_ = std::make_shared<const Factor>(columns_of(A, false), analyses->kept());
  else
    dense_.compute(A.dense());
}

MatrixXd LinearSolver::solve(const Eigen::Ref<const MatrixXd>& B) const {
  if (!sparse_) return dense_.solve(B);
  const Factor& f = *sparse_;
  MatrixXd X = MatrixXd::Constant(B.rows(), B.cols(), std::numeric_limits<double>::quiet_NaN());
  if (!f.numeric) return X;
  std::vector<Index> integers(static_cast<std::size_t>(B.rows()));
  std::vector<double> numbers(5 * static_cast<std::size_t>(B.rows()));
  for (Eigen::Index k = 0; k < B.cols(); ++k)
    umfpack_dl_wsolve(UMFPACK_A, f.A.begin.data(), f.A.row.data(), f.A.value.data(),
                      X.col(k).data(), B.col(k).data(), f.numeric, f.control, nullptr,
                      integers.data(), numbers.data());
  return X;
}

std::optional<int> negative_eigenvalues(const SparseMatrix& A, const std::vector<int>& order,
                                        SparseAnalyses& analyses) {
  SparseAnalyses::Kept& kept = analyses.kept();
  Columns columns = columns_of(A, true);
  cholmod_sparse view = symmetric_view(columns);
  auto at = std::ranges::find_if(kept.ldl, [&](const auto& ldl) {
    return ldl.order == order && ldl.pattern.same_pattern(columns);
  });
  if (at == kept.ldl.end()) {
    if (kept.ldl.size() == most_kept) {
      cholmod_l_free_factor(&kept.ldl.back().factor, &kept.common);
      kept.ldl.pop_back();
    }
    std::vector<Index> permutation(order.begin(), order.end());
    kept.common.nmethods = 1;
    kept.common.method[0].ordering = order.empty() ? CHOLMOD_AMD : CHOLMOD_GIVEN;
    kept.common.postorder = 1;
    cholmod_factor* factor = cholmod_l_analyze_p(
        &view, order.empty() ? nullptr : permutation.data(), nullptr, 0, &kept.common);
    if (!factor) throw std::bad_alloc();
    kept.ldl.push_front({{columns.begin, columns.row, {}}, order, factor});
    at = kept.ldl.begin();
  }
  cholmod_l_factorize(&view, at->factor, &kept.common);
  if (kept.common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  const cholmod_factor& L = *at->factor;
  if (L.xtype != CHOLMOD_REAL || L.is_ll || L.minor < L.n) return std::nullopt;
  const auto* begin = static_cast<const Index*>(L.p);
  const auto* value = static_cast<const double*>(L.x);
  int negative = 0;
  for (std::size_t k = 0; k < L.n; ++k) {
    const double pivot = value[begin[k]];
    if (!(std::abs(pivot) > 0)) return std::nullopt;
    negative += pivot < 0;
  }
  return negative;
}

std::vector<int> elimination_order(const BlockMatrix& A,
                                   const std::vector<std::pair<int, int>>& ties) {
  SparseMatrix pattern(A.bodies());
  for (int b = 0; b < A.bodies(); ++b) pattern.add(b, b, 1);
  A.for_each([&](int r, int c, const Matrix6d&) { pattern.add(r, c, 1); });
  for (const auto& [a, b] : ties) {
    pattern.add(a, b, 1);
    pattern.add(b, a, 1);
  }
  Columns columns = columns_of(pattern, true);
  cholmod_sparse view = symmetric_view(columns);
  std::vector<Index> order(static_cast<std::size_t>(A.bodies()));
  cholmod_common common;
  cholmod_l_start(&common);
  const int ok = cholmod_l_amd(&view, nullptr, 0, order.data(), &common);
  cholmod_l_finish(&common);
  if (!ok) throw std::bad_alloc();
  return {order.begin(), order.end()};
}

}  // namespace flexopt
