#include "core/math/sparse_rank.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace flexopt;

namespace {

Eigen::MatrixXd written_out(int rows, int columns, const std::vector<SparseEntry>& entries) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(rows, columns);
  for (const SparseEntry& e : entries) A(e.row, e.column) += e.value;
  return A;
}

/// Rank and number of sums against a dense decomposition of the rows, brought to one length.
DependentRows checked_rows(int rows, int columns, const std::vector<SparseEntry>& entries,
                           double threshold) {
  const DependentRows found = dependent_rows(rows, columns, entries, threshold);
  const Eigen::MatrixXd unit = written_out(rows, columns, entries).rowwise().normalized();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(unit);
  qr.setThreshold(threshold);
  CHECK(found.rank == qr.rank());
  REQUIRE(static_cast<int>(found.sums.size()) == rows - found.rank);
  return found;
}

}  // namespace

TEST_CASE("rows that depend on others are found with their factors") {
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

TEST_CASE("rank and sums of rows are those of the dense matrix") {
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
  const DependentRows found = checked_rows(n, 40, entries, 1e-8);
  Eigen::MatrixXd factors = Eigen::MatrixXd::Zero(n, n - found.rank);
  for (std::size_t k = 0; k < found.sums.size(); ++k)
    for (const auto& [row, factor] : found.sums[k])
      factors(row, static_cast<Eigen::Index>(k)) = factor * A.row(row).norm();
  factors.colwise().normalize();
  CHECK((unit.transpose() * factors).norm() < 1e-12);
  CHECK(Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(factors).rank() == n - found.rank);
}

// Rows of three that tie neighbours of six columns each, or all of them to the first six, as
// conditions tie bodies; some repeat earlier ones of the same columns.
TEST_CASE("ranks of chains and stars are those of the dense matrix") {
  const bool star = GENERATE(false, true);
  const unsigned seed = GENERATE(1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u);
  const int bodies = 40;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<SparseEntry> entries;
  int row = 0;
  const auto add = [&](int body, int other, int free) {
    for (int k = 0; k < 3; ++k, ++row) {
      const double size = std::pow(10, 6 * number(random));
      for (int c = 0; c < 6; ++c) {
        const double value = c < free ? 0 : number(random);  // nothing holds the first columns
        entries.push_back({row, 6 * body + c, size * value});
        if (other >= 0) entries.push_back({row, 6 * other + c, -size * value});
      }
    }
  };
  for (int b = 1; b < bodies; ++b) {
    add(b, star ? -1 : b - 1, b % 3);
    if (star || b % 2 == 0) add(b, star ? 0 : b - 1, b % 3);
    if (b % 5 == 0) add(b, -1, 4);  // of rank two
  }
  const Eigen::MatrixXd A = written_out(row, 6 * bodies, entries);
  const DependentRows found = checked_rows(row, 6 * bodies, entries, 1e-10);
  CHECK(found.rank < row);
  CHECK(rank_of(row, 6 * bodies, entries, 1e-10) == found.rank);
  for (const auto& sum : found.sums) {
    Eigen::RowVectorXd zero = Eigen::RowVectorXd::Zero(6 * bodies);
    double sizes = 0;
    for (const auto& [r, factor] : sum) {
      CHECK(r <= sum.back().first);
      zero += factor * A.row(r);
      sizes += std::abs(factor) * A.row(r).norm();
    }
    CHECK(zero.norm() < 1e-12 * sizes);
  }
}

TEST_CASE("a matrix without rows or entries has rank zero") {
  CHECK(dependent_rows(0, 6, {}, 1e-8).rank == 0);
  const DependentRows none = dependent_rows(2, 6, {}, 1e-8);
  CHECK(none.rank == 0);
  CHECK(none.sums.size() == 2);
}
