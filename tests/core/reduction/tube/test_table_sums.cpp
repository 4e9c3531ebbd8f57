#include <catch2/catch.hpp>

#include "core/reduction/tube/table_sums.hpp"

using namespace flexopt;

TEST_CASE("sums over the monomials of a table are products, beside what was there") {
  std::srand(5);
  for (const Eigen::Index rows : {1, 7, 8, 9, 120, 203}) {
    const MatrixXd table = MatrixXd::Random(rows, 12);
    const Eigen::Matrix<double, 12, 7> weights = Eigen::Matrix<double, 12, 7>::Random();
    const MatrixXd before = MatrixXd::Random(rows, 10);
    MatrixXd sums = before;
    add_table_sums(table, weights, 0.5, sums.middleCols<7>(2));
    MatrixXd truth = before;
    truth.middleCols<7>(2) += 0.5 * table * weights;
    CHECK((sums - truth).norm() < 1e-14 * truth.norm());
    add_table_sums(table, weights.col(3).eval(), 2, sums.col(0));
    truth.col(0) += 2 * table * weights.col(3);
    CHECK((sums - truth).norm() < 1e-14 * truth.norm());
  }
}
