#include "core/math/sparse_solver.hpp"

#include <amd.h>
#include <klu.h>
extern "C" {  // which this header lacks
#include <ldl.h>
}

#include <Eigen/SparseCore>
#include <algorithm>
#include <limits>
#include <list>
#include <new>

namespace flexopt {
namespace {

using Index = SuiteSparse_long;

using Columns = Eigen::SparseMatrix<double, Eigen::ColMajor, Index>;

bool same_pattern(const Columns& A, const Columns& B) {
  return A.cols() == B.cols() && A.nonZeros() == B.nonZeros() &&
         std::equal(A.outerIndexPtr(), A.outerIndexPtr() + A.cols(), B.outerIndexPtr()) &&
         std::equal(A.innerIndexPtr(), A.innerIndexPtr() + A.nonZeros(), B.innerIndexPtr());
}

Columns columns_of(const SparseMatrix& A, bool lower_only) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  entries.reserve(A.entries().size());
  for (const SparseEntry& e : A.entries())
    if (!lower_only || e.row >= e.column) entries.emplace_back(e.row, e.column, e.value);
  Columns columns(A.size(), A.size());
  columns.setFromTriplets(entries.begin(), entries.end());
  return columns;
}

constexpr std::size_t most_kept = 8;

/// Order of elimination by approximate minimum degree, of the pattern of A + Aᵀ.
std::vector<Index> minimum_degree(const Columns& A) {
  std::vector<Index> order(static_cast<std::size_t>(A.cols()));
  if (amd_l_order(A.cols(), A.outerIndexPtr(), A.innerIndexPtr(), order.data(), nullptr, nullptr) <
      AMD_OK)
    throw std::bad_alloc();
  return order;
}

/// Equations and unknowns of a matrix in an order in which L D Lᵀ stays sparse, and the tree of
/// elimination.
struct LdlPattern {
  std::vector<Index> order, place, begin, parent, count;

  LdlPattern(Columns& A, std::vector<Index> given) : order(std::move(given)) {
    const std::size_t n = order.size();
    place.resize(n);
    begin.resize(n + 1);
    parent.resize(n);
    count.resize(n);
    std::vector<Index> flag(n);
    ldl_l_symbolic(A.cols(), A.outerIndexPtr(), A.innerIndexPtr(), begin.data(), parent.data(),
                   count.data(), flag.data(), order.data(), place.data());
  }
};

klu_l_common settings() {
  klu_l_common common;
  klu_l_defaults(&common);
  common.tol = 0.1;  // of the largest of its column a pivot on the diagonal must be
  return common;
}

/// Symbolic analysis of a pattern, on which a factorisation depends.
using Symbolic = std::shared_ptr<klu_l_symbolic>;

Symbolic owned(klu_l_symbolic* symbolic) {
  return {symbolic, [](klu_l_symbolic* s) {
            klu_l_common common = settings();
            klu_l_free_symbolic(&s, &common);
          }};
}

}  // namespace

struct SparseAnalyses::Kept {
  struct Lu {
    Columns pattern;
    Symbolic symbolic;
  };
  struct Ldl {
    Columns pattern;
    std::vector<int> order;
    LdlPattern tree;
  };
  std::list<Lu> lu;
  std::list<Ldl> ldl;
};

SparseAnalyses::SparseAnalyses() : kept_(std::make_unique<Kept>()) {}
SparseAnalyses::~SparseAnalyses() = default;

struct LinearSolver::Factor {
  Columns A;
  Symbolic symbolic;
  klu_l_numeric* numeric = nullptr;
  mutable klu_l_common common = settings();

  Factor(Columns columns, SparseAnalyses::Kept& kept);
  Factor(const Factor&) = delete;
  Factor& operator=(const Factor&) = delete;
  ~Factor() { klu_l_free_numeric(&numeric, &common); }

  void solve(MatrixXd& X) const {
    klu_l_solve(symbolic.get(), numeric, X.rows(), X.cols(), X.data(), &common);
  }
  /// Residual B − A X.
  MatrixXd rest(const Eigen::Ref<const MatrixXd>& B, const MatrixXd& X) const {
    MatrixXd R = B;
    R.noalias() -= A * X;
    return R;
  }
};

LinearSolver::Factor::Factor(Columns columns, SparseAnalyses::Kept& kept) : A(std::move(columns)) {
  auto at =
      std::ranges::find_if(kept.lu, [&](const auto& lu) { return same_pattern(lu.pattern, A); });
  if (at == kept.lu.end()) {
    Symbolic found = owned(klu_l_analyze(A.cols(), A.outerIndexPtr(), A.innerIndexPtr(), &common));
    if (!found && common.status != KLU_SINGULAR) throw std::bad_alloc();
    if (!found) return;  // singular by its pattern alone
    if (kept.lu.size() == most_kept) kept.lu.pop_back();
    kept.lu.push_front({A, std::move(found)});
  } else {
    kept.lu.splice(kept.lu.begin(), kept.lu, at);
  }
  symbolic = kept.lu.front().symbolic;
  numeric =
      klu_l_factor(A.outerIndexPtr(), A.innerIndexPtr(), A.valuePtr(), symbolic.get(), &common);
  if (!numeric && common.status != KLU_SINGULAR) throw std::bad_alloc();
}

LinearSolver::LinearSolver(const SparseMatrix& A, const std::shared_ptr<SparseAnalyses>& analyses) {
  if (analyses)
    sparse_ = std::make_shared<const Factor>(columns_of(A, false), analyses->kept());
  else
    dense_.compute(A.dense());
}

MatrixXd LinearSolver::solve(const Eigen::Ref<const MatrixXd>& B) const {
  if (!sparse_) return dense_.solve(B);
  if (!sparse_->numeric)
    return MatrixXd::Constant(B.rows(), B.cols(), std::numeric_limits<double>::quiet_NaN());
  MatrixXd X = B;
  sparse_->solve(X);
  // pivots are not always the largest: one step of refinement takes back what this costs
  MatrixXd correction = sparse_->rest(B, X);
  sparse_->solve(correction);
  return X + correction;
}

std::optional<int> negative_eigenvalues(const SparseMatrix& A, const std::vector<int>& order,
                                        SparseAnalyses& analyses) {
  SparseAnalyses::Kept& kept = analyses.kept();
  Columns columns = columns_of(A, false);
  auto at = std::ranges::find_if(kept.ldl, [&](const auto& ldl) {
    return ldl.order == order && same_pattern(ldl.pattern, columns);
  });
  if (at == kept.ldl.end()) {
    LdlPattern tree(columns, order.empty() ? minimum_degree(columns)
                                           : std::vector<Index>(order.begin(), order.end()));
    if (kept.ldl.size() == most_kept) kept.ldl.pop_back();
    kept.ldl.push_front({columns, order, std::move(tree)});
    at = kept.ldl.begin();
  }
  LdlPattern& tree = at->tree;
  const std::size_t n = tree.order.size(), entries = static_cast<std::size_t>(tree.begin.back());
  std::vector<Index> row(entries), pattern(n), flag(n);
  std::vector<double> factor(entries), pivot(n), work(n);
  const Index done = ldl_l_numeric(
      columns.cols(), columns.outerIndexPtr(), columns.innerIndexPtr(), columns.valuePtr(),
      tree.begin.data(), tree.parent.data(), tree.count.data(), row.data(), factor.data(),
      pivot.data(), work.data(), pattern.data(), flag.data(), tree.order.data(), tree.place.data());
  if (done < static_cast<Index>(n)) return std::nullopt;
  int negative = 0;
  for (const double d : pivot) {
    if (!(std::abs(d) > 0)) return std::nullopt;
    negative += d < 0;
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
  const std::vector<Index> order = minimum_degree(columns_of(pattern, true));
  return {order.begin(), order.end()};
}

}  // namespace flexopt
