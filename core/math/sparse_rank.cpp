#include "core/math/sparse_rank.hpp"

#include <SuiteSparseQR.hpp>
#include <algorithm>
#include <cmath>
#include <new>

namespace flexopt {
namespace {

// What SuiteSparse allocates, freed at the end.
struct Workspace {
  cholmod_common common;
  cholmod_triplet* entries = nullptr;
  cholmod_sparse *A = nullptr, *R = nullptr;
  SuiteSparse_long* order = nullptr;

  Workspace() { cholmod_l_start(&common); }
  void set_transposed(int columns, const std::vector<SparseEntry>& given,
                      const std::vector<double>& lengths);
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;
  ~Workspace() {
    cholmod_l_free_triplet(&entries, &common);
    cholmod_l_free_sparse(&A, &common);
    if (order) cholmod_l_free(R ? R->ncol : 0, sizeof(SuiteSparse_long), order, &common);
    cholmod_l_free_sparse(&R, &common);
    cholmod_l_finish(&common);
  }
};

// Aᵀ, each column over its length.
void Workspace::set_transposed(int columns, const std::vector<SparseEntry>& given,
                               const std::vector<double>& lengths) {
  entries = cholmod_l_allocate_triplet(static_cast<std::size_t>(columns), lengths.size(),
                                       given.size(), 0, CHOLMOD_REAL, &common);
  if (!entries) throw std::bad_alloc();
  for (const SparseEntry& e : given) {
    const double length = lengths[static_cast<std::size_t>(e.row)];
    if (e.value == 0 || length == 0) continue;
    const std::size_t k = entries->nnz++;
    static_cast<SuiteSparse_long*>(entries->i)[k] = e.column;
    static_cast<SuiteSparse_long*>(entries->j)[k] = e.row;
    static_cast<double*>(entries->x)[k] = e.value / length;
  }
  A = cholmod_l_triplet_to_sparse(entries, entries->nnz, &common);
}

// Lengths of the rows.
std::vector<double> lengths_of(int rows, const std::vector<SparseEntry>& entries) {
  std::vector<double> lengths(static_cast<std::size_t>(rows), 0.0);
  for (const SparseEntry& e : entries)
    lengths[static_cast<std::size_t>(e.row)] += e.value * e.value;
  for (double& length : lengths) length = std::sqrt(length);
  return lengths;
}

}  // namespace

// The columns of Aᵀ, in their order, are columns of Q times those of R = [R1 R2]. Those of R2
// depend on those of R1, with the factors R1⁻¹ R2.
DependentRows dependent_rows(int rows, int columns, const std::vector<SparseEntry>& entries,
                             double tolerance) {
  DependentRows result;
  if (rows == 0) return result;
  const std::vector<double> lengths = lengths_of(rows, entries);
  Workspace w;
  w.set_transposed(columns, entries, lengths);
  const SuiteSparse_long rank =
      SuiteSparseQR<double>(SPQR_ORDERING_NATURAL, tolerance, 0, w.A, &w.R, &w.order, &w.common);
  if (rank < 0 || !w.R) throw std::bad_alloc();
  result.rank = static_cast<int>(rank);

  const auto* begin = static_cast<const SuiteSparse_long*>(w.R->p);
  const auto* row = static_cast<const SuiteSparse_long*>(w.R->i);
  const auto* value = static_cast<const double*>(w.R->x);
  const auto original = [&](SuiteSparse_long k) {
    return static_cast<int>(w.order ? w.order[k] : k);
  };
  std::vector<double> x(static_cast<std::size_t>(rank));
  for (SuiteSparse_long d = rank; d < rows; ++d) {
    std::fill(x.begin(), x.end(), 0.0);
    for (SuiteSparse_long e = begin[d]; e < begin[d + 1]; ++e)
      if (row[e] < rank) x[static_cast<std::size_t>(row[e])] = value[e];
    const double own = lengths[static_cast<std::size_t>(original(d))];
    std::vector<std::pair<int, double>> sum;
    for (SuiteSparse_long k = rank - 1; k >= 0; --k) {
      double& factor = x[static_cast<std::size_t>(k)];
      if (factor == 0) continue;
      double pivot = 0;
      for (SuiteSparse_long e = begin[k]; e < begin[k + 1]; ++e)
        if (row[e] == k) pivot = value[e];
      factor /= pivot;
      for (SuiteSparse_long e = begin[k]; e < begin[k + 1]; ++e)
        if (row[e] < k) x[static_cast<std::size_t>(row[e])] -= value[e] * factor;
      const int of = original(k);
      sum.emplace_back(of, factor * own / lengths[static_cast<std::size_t>(of)]);
    }
    sum.emplace_back(original(d), -1.0);
    result.sums.push_back(std::move(sum));
  }
  return result;
}

int rank_of(int rows, int columns, const std::vector<SparseEntry>& entries, double tolerance) {
  if (rows == 0) return 0;
  Workspace w;
  w.set_transposed(columns, entries, lengths_of(rows, entries));
  const SuiteSparse_long rank =
      SuiteSparseQR<double>(SPQR_ORDERING_DEFAULT, tolerance, 0, w.A, &w.R, &w.order, &w.common);
  if (rank < 0) throw std::bad_alloc();
  return static_cast<int>(rank);
}

}  // namespace flexopt
