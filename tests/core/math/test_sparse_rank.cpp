#include "core/math/sparse_rank.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>

using namespace flexopt;

namespace {

Eigen::MatrixXd written_out(int rows, int columns, const std::vector<SparseEntry>& entries) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(rows, columns);
  for (const SparseEntry& e : entries) A(e.row, e.column) += e.value;
  return A;
}

}  // namespace

TEST_CASE("rows that depend on others are found with their factors", "[math][sparse]") {
  // r2 = r0 + 2 r1, r3 = 0, r5 = r4 − r0; one entry is given in two parts
  const std::vector<SparseEntry> entries{{0, 0, 1}, {0, 1, 2}, {1, 1, 1},  {1, 2, 1},
                                         {2, 0, 1}, {2, 1, 4}, {2, 2, 2},  {4, 3, 2},
                                         {4, 3, 3}, {5, 3, 5}, {5, 0, -1}, {5, 1, -2}};
  const DependentRows found = dependent_rows(6, 4, entries, 1e-8);
  CHECK(found.rank == 3);
  REQUIRE(found.sums.size() == 3);
  const Eigen::MatrixXd A = written_out(6, 4, entries);
  for (const auto& sum : found.sums) {
    CHECK(sum.back().second == -1);
    Eigen::RowVectorXd zero = Eigen::RowVectorXd::Zero(4);
    for (const auto& [row, factor] : sum) zero += factor * A.row(row);
    CHECK(zero.norm() < 1e-14);
  }
}

TEST_CASE("rank and sums of rows are those of the dense matrix", "[math][sparse]") {
  // rows in pairs of unknowns, every third a combination, lengths from 1e-6 to 1e6
  const int n = 60;
  std::vector<SparseEntry> entries;
  for (int i = 0; i < n; ++i) {
    const double size = std::pow(10, 6 * std::sin(i));
    const int c = i - i / 3;
    if (i % 3 != 2) {
      entries.push_back({i, c % 40, size * std::cos(i + 1)});
      entries.push_back({i, (c + 7) % 40, size * std::sin(2 * i)});
    }
  }
  for (int i = 2; i < n; i += 3)
    for (const int from : {i - 2, i - 1})
      for (const SparseEntry e : std::vector(entries))
        if (e.row == from) entries.push_back({i, e.column, 0.3 * (i - from) * e.value});
  const Eigen::MatrixXd A = written_out(n, 40, entries);
  const Eigen::MatrixXd unit = A.rowwise().normalized();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(unit);
  qr.setThreshold(1e-8);
  const DependentRows found = dependent_rows(n, 40, entries, 1e-8);
  CHECK(found.rank == qr.rank());
  REQUIRE(static_cast<int>(found.sums.size()) == n - found.rank);
  Eigen::MatrixXd factors = Eigen::MatrixXd::Zero(n, n - found.rank);
  for (std::size_t k = 0; k < found.sums.size(); ++k)
    for (const auto& [row, factor] : found.sums[k])
      factors(row, static_cast<Eigen::Index>(k)) = factor * A.row(row).norm();
  factors.colwise().normalize();
  CHECK((unit.transpose() * factors).norm() < 1e-12);
  CHECK(Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(factors).rank() == n - found.rank);
}

TEST_CASE("a matrix without rows or entries has rank zero", "[math][sparse]") {
  CHECK(dependent_rows(0, 6, {}, 1e-8).rank == 0);
  const DependentRows none = dependent_rows(2, 6, {}, 1e-8);
  CHECK(none.rank == 0);
  CHECK(none.sums.size() == 2);
}
