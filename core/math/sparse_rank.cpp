#include "core/math/sparse_rank.hpp"

#include <Eigen/QR>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "core/math/types.hpp"

namespace flexopt {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Sparse = Eigen::SparseMatrix<double>;

// What rounding makes of zero, in columns of length one.
constexpr double rounding = 1e-14;

// Norms of the rows.
std::vector<double> lengths_of(int rows, const std::vector<SparseEntry>& entries) {
  std::vector<double> lengths(static_cast<std::size_t>(rows), 0.0);
  for (const SparseEntry& e : entries) lengths[e.row] += e.value * e.value;
  for (double& length : lengths) length = std::sqrt(length);
  return lengths;
}

// Aᵀ, with each column divided by its length.
Sparse transposed(int columns, const std::vector<SparseEntry>& given,
                  const std::vector<double>& lengths) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(given.size());
  for (const SparseEntry& e : given) {
    const double length = lengths[e.row];
    if (e.value != 0 && length != 0) entries.emplace_back(e.column, e.row, e.value / length);
  }
  Sparse A(columns, lengths.size());
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

// Rows that were turned among each other, in the columns where they may differ from zero.
struct Front {
  std::vector<int> columns;  // ascending
  RowMajor values;
  Eigen::Index row = 0, column = 0;  // what is before them is done
  Eigen::Index rank = 1;             // of the values, when it was last known

  auto rest() { return values.bottomRightCorner(values.rows() - row, values.cols() - column); }
  bool done() const { return row == values.rows() || column == values.cols(); }
  int first() const { return columns[column]; }
};

// A = Q R by Householder reflections, column by column. All rows that differ from zero in a column
// are gathered in one front, over all columns of any of them; what the reflection leaves of it
// waits at the next of these. Coordinates that nothing holds would pile up: a front is compressed
// before.
class FrontalQr {
 public:
  struct Pivot {
    int column = 0;
    std::vector<int> columns;  // the others in its row of R
    double value = 0;
    VectorXd values;
  };

  FrontalQr(const Sparse& A, double tolerance) : tolerance_(tolerance), waiting_(A.cols()) {
    const Eigen::SparseMatrix<double, Eigen::RowMajor> rows = A;
    for (Eigen::Index r = 0; r < rows.rows(); ++r) {
      Front front;
      const auto begin = rows.outerIndexPtr()[r], end = rows.outerIndexPtr()[r + 1];
      if (begin == end) continue;
      front.columns.assign(rows.innerIndexPtr() + begin, rows.innerIndexPtr() + end);
      front.values = Eigen::Map<const RowMajor>(rows.valuePtr() + begin, 1, end - begin);
      wait(std::move(front));
    }
    place_.resize(static_cast<std::size_t>(A.cols()));
    for (int k = 0; k < static_cast<int>(A.cols()); ++k) eliminate(k);
  }

  const std::vector<Pivot>& pivots() const { return pivots_; }  // rows of R
  const std::vector<int>& dependent() const { return dependent_; }

 private:
  void wait(Front front) { waiting_[front.first()].push_back(std::move(front)); }

  // Householder reflection that makes zeros below the first entry of a block.
  template <class Block>
  void reflect(Block A) {
    tail_.resize(A.rows() - 1);
    double factor = 0, length = 0;
    A.col(0).makeHouseholder(tail_, factor, length);
    if (factor == 0) return;
    work_.resize(A.cols());
    A.rightCols(A.cols() - 1).applyHouseholderOnTheLeft(tail_, factor, work_.data());
    A(0, 0) = length;
    A.col(0).tail(A.rows() - 1).setZero();
  }

  // Joins the rests of several fronts, one below the other.
  Front gathered(std::vector<Front>& parts) {
    if (parts.size() == 1) return std::move(parts[0]);
    Front all;
    Eigen::Index rows = 0;
    for (Front& part : parts) {
      all.columns.insert(all.columns.end(), part.columns.begin() + part.column, part.columns.end());
      rows += part.values.rows() - part.row;
      all.rank = std::max(all.rank, part.rank);
    }
    std::ranges::sort(all.columns);
    // without ranges, whose unique() clang 14 does not compile: libFuzzer is clang's
    all.columns.erase(std::unique(all.columns.begin(), all.columns.end()), all.columns.end());
    for (std::size_t i = 0; i < all.columns.size(); ++i)
      place_[all.columns[i]] = static_cast<int>(i);
    all.values = RowMajor::Zero(rows, all.columns.size());
    Eigen::Index row = 0;
    for (Front& part : parts) {
      const auto rest = part.rest();
      for (Eigen::Index c = 0; c < rest.cols(); ++c)
        all.values.col(place_[part.columns[static_cast<std::size_t>(part.column + c)]])
            .segment(row, rest.rows()) = rest.col(c);
      row += rest.rows();
    }
    return all;
  }

  // Replaces the rows of a front by as many as their rank, by a QR decomposition with pivoting.
  void compress(Front& front) {
    const Eigen::ColPivHouseholderQR<RowMajor> qr(front.rest());
    const auto& diagonal = qr.matrixQR().diagonal();
    front.rank = 0;
    while (front.rank < diagonal.size() && std::abs(diagonal[front.rank]) > rounding) ++front.rank;
    front.rank = std::max<Eigen::Index>(front.rank, 1);
    const RowMajor upper =
        qr.matrixQR().topRows(front.rank).template triangularView<Eigen::Upper>();
    front.columns.erase(front.columns.begin(), front.columns.begin() + front.column);
    front.values = upper * qr.colsPermutation().transpose();
    front.row = front.column = 0;
  }

  void eliminate(int k) {
    std::vector<Front> parts = std::move(waiting_[k]);
    if (parts.empty()) return dependent_.push_back(k);
    Front front = gathered(parts);
    if (front.rest().rows() > std::min(front.rest().cols(), 2 * front.rank)) compress(front);
    auto rest = front.rest();
    if (rest.col(0).norm() > tolerance_) {
      reflect(rest);
      pivots_.push_back({k,
                         {front.columns.begin() + front.column + 1, front.columns.end()},
                         rest(0, 0),
                         rest.row(0).tail(rest.cols() - 1)});
      ++front.row;
    } else {
      dependent_.push_back(k);
    }
    ++front.column;
    if (!front.done()) wait(std::move(front));
  }

  double tolerance_;
  std::vector<std::vector<Front>> waiting_;  // at their first columns
  std::vector<int> place_;
  std::vector<Pivot> pivots_;
  std::vector<int> dependent_;
  VectorXd tail_, work_;
};

// Columns of R from the rows that the pivots have.
std::vector<std::vector<std::pair<int, double>>> columns_of(
    const std::vector<FrontalQr::Pivot>& pivots, int columns) {
  std::vector<std::vector<std::pair<int, double>>> R(static_cast<std::size_t>(columns));
  for (std::size_t p = 0; p < pivots.size(); ++p)
    for (std::size_t i = 0; i < pivots[p].columns.size(); ++i)
      if (const double value = pivots[p].values[i]; value != 0)
        R[pivots[p].columns[i]].emplace_back(static_cast<int>(p), value);
  return R;
}

}  // namespace

// Uses Aᵀ = Q R: the columns of R without a pivot depend on earlier ones with a pivot, with the
// factors R1⁻¹ r.
DependentRows dependent_rows(int rows, int columns, const std::vector<SparseEntry>& entries,
                             double tolerance) {
  DependentRows result;
  const std::vector<double> lengths = lengths_of(rows, entries);
  const FrontalQr qr(transposed(columns, entries, lengths), tolerance);
  const auto& pivots = qr.pivots();
  result.rank = static_cast<int>(pivots.size());
  if (qr.dependent().empty()) return result;
  const auto R = columns_of(pivots, rows);
  std::vector<double> x(pivots.size(), 0.0);
  std::vector<char> met(pivots.size(), 0);
  for (const int d : qr.dependent()) {
    std::priority_queue<int> last;  // of those that are met
    const auto subtract = [&](int column, double factor) {
      for (const auto& [p, value] : R[column]) {
        const auto at = static_cast<std::size_t>(p);
        x[at] += factor * value;
        if (!met[at]) last.push(p);
        met[at] = 1;
      }
    };
    subtract(d, 1);
    const double own = lengths[d];
    double largest = 1;
    std::vector<std::pair<int, double>> sum;
    while (!last.empty()) {
      const auto at = static_cast<std::size_t>(last.top());
      last.pop();
      const double left = std::exchange(x[at], 0.0);
      met[at] = 0;
      // what rounding leaves in place of zero would go through the whole mechanism
      if (std::abs(left) <= rounding * largest) continue;
      const double factor = left / pivots[at].value;
      largest = std::max(largest, std::abs(factor));
      subtract(pivots[at].column, -factor);
      const int of = pivots[at].column;
      sum.emplace_back(of, factor * own / lengths[of]);
    }
    sum.emplace_back(d, -1.0);
    result.sums.push_back(std::move(sum));
  }
  return result;
}

int rank_of(int rows, int columns, const std::vector<SparseEntry>& entries, double tolerance) {
  const Sparse A = transposed(columns, entries, lengths_of(rows, entries));
  return static_cast<int>(FrontalQr(A, tolerance).pivots().size());
}

}  // namespace flexopt
