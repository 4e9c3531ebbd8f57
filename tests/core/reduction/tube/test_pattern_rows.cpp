#include <catch2/catch.hpp>

#include "core/reduction/tube/pattern_rows.hpp"

using namespace flexopt;

TEST_CASE("products of pattern rows are those of single numbers, added up in double") {
  std::srand(2);
  const MatrixXd P = MatrixXd::Random(75, 37);
  const MatrixXd single = P.cast<float>().cast<double>();
  const PatternRows rows(P);
  CHECK(rows.rows() == 75);
  CHECK(rows.patterns() == 37);
  for (const Eigen::Index columns : {1, 2, 4, 7}) {
    const MatrixXd A = MatrixXd::Random(37, columns);
    for (const Eigen::Index first : {0, 5, 16, 33, 70})
      for (const Eigen::Index count : {1, 5}) {
        const MatrixXd product = rows.times(first, count, A),
                       truth = single.middleRows(first, count) * A;
        CHECK((product - truth).norm() < 1e-14 * truth.norm() + 1e-15);
      }
    CHECK((rows.times(0, 75, A) - single * A).norm() < 1e-14 * (single * A).norm());
  }
}

TEST_CASE("rows of patterns one by one") {
  std::srand(3);
  const MatrixXd P = MatrixXd::Random(41, 12);
  const PatternRows rows(P);
  for (const Eigen::Index i : {0, 17, 40})
    CHECK(Eigen::Map<const VectorXd>(rows.row(i), 12) == P.row(i).transpose());
}
