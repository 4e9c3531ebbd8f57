// Lowest pairs of a pencil with a border against a whole decomposition in long double.
#include <catch2/catch.hpp>

#include <Eigen/Dense>

#include "core/math/bordered_pencil.hpp"

using namespace flexopt;

namespace {

using Long = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

// Like a body on leaves: a border graded over six decades, `leaves` with modes of their own.
BorderedPencil pencil(int border, int leaves, int modes, double mass) {
  const MatrixXd R = MatrixXd::Random(border, border);
  VectorXd k(border);
  for (int i = 0; i < border; ++i) k[i] = std::pow(10, 1 + 3.0 * i / border);
  BorderedPencil p;
  p.K = k.asDiagonal() * (R * R.transpose() + 0.1 * MatrixXd::Identity(border, border)) *
        k.asDiagonal();
  p.modes.resize(leaves * modes);
  p.C = 0.05 * MatrixXd::Random(border, leaves * modes);
  for (int j = 0; j < leaves * modes; ++j) {
    p.modes[j] = 4e5 * std::pow(1 + j % modes, 3) * (1 + 0.2 * (j / modes));
    p.C.col(j) /= 1 + j % modes;
  }
  p.M = p.C * p.C.transpose() + mass * MatrixXd::Identity(border, border);
  return p;
}

EigenPairs lowest(const BorderedPencil& p, int count) {
  const EigenPairs found = lowest_pairs(p, {}, {count, 0}).value().free;
  return {found.values.head(count), found.vectors.leftCols(count)};
}

// Of K positive definite.
VectorXd exact_values(const BorderedPencil& p, int count) {
  const Long K = p.dense_stiffness().cast<long double>(), M = p.dense_mass().cast<long double>();
  const Eigen::LLT<Long> factor(K);
  Long A = factor.matrixL().solve(M);
  A = factor.matrixL().solve(Long(A.transpose()));
  const Eigen::SelfAdjointEigenSolver<Long> eigen(A, Eigen::EigenvaluesOnly);
  VectorXd values(count);
  for (int k = 0; k < count; ++k)
    values[k] = static_cast<double>(1 / eigen.eigenvalues()[K.rows() - 1 - k]);
  return values;
}

void check_pairs(const BorderedPencil& p, const EigenPairs& found, const VectorXd& values,
                 double tolerance) {
  REQUIRE(found.values.size() == values.size());
  for (Eigen::Index k = 0; k < values.size(); ++k)
    CHECK(std::abs(found.values[k] - values[k]) <= tolerance * std::abs(values[k]));
  const MatrixXd M = p.dense_mass(), &X = found.vectors;
  CHECK((X.transpose() * M * X - MatrixXd::Identity(X.cols(), X.cols())).norm() < 1e-9);
  const VectorXd unit = p.dense_stiffness().diagonal().cwiseAbs().cwiseSqrt().cwiseInverse();
  const MatrixXd KX = p.dense_stiffness() * X,
                 rest = unit.asDiagonal() * (KX - M * X * found.values.asDiagonal());
  for (Eigen::Index k = 0; k < X.cols(); ++k)
    CHECK(rest.col(k).norm() < 1e-9 * (unit.asDiagonal() * KX.cwiseAbs()).col(k).norm() +
                                   1e-12 * X.col(k).cwiseQuotient(unit).norm());
}

}  // namespace

TEST_CASE("the lowest pairs of a bordered pencil are those of the whole one") {
  std::srand(11);
  for (int k = 0; k < 60; ++k) {
    const BorderedPencil p = pencil(5 + k % 3 * 4, 2 + k % 4, 10, std::pow(10, k % 6 - 3));
    const int count = 4 + k % 2 * 4;
    check_pairs(p, lowest(p, count), exact_values(p, count), 1e-12);
  }
}

TEST_CASE("a pencil is solved with coordinates held at the same time") {
  std::srand(12);
  for (const std::vector<int>& held : {std::vector<int>{2}, {0, 5}, {1, 2, 3}}) {
    const BorderedPencil p = pencil(6, 3, 10, 0.1);
    std::vector<int> kept;
    for (int i = 0; i < 6; ++i)
      if (std::find(held.begin(), held.end(), i) == held.end()) kept.push_back(i);
    const FreeAndHeldPairs found = lowest_pairs(p, held, {8, 8}).value();
    check_pairs(p, found.free, exact_values(p, 8), 1e-12);
    CHECK(found.held.vectors(held, Eigen::all).norm() == 0);
    std::vector<int> rows = kept;
    for (int i = 6; i < p.size(); ++i) rows.push_back(i);
    check_pairs(p.kept(kept), {found.held.values, found.held.vectors(rows, Eigen::all)},
                exact_values(p.kept(kept), 8), 1e-12);
  }
}

TEST_CASE("one of both lists alone is the same") {
  std::srand(12);
  const BorderedPencil p = pencil(6, 3, 10, 0.1);
  const std::vector<int> held{1, 4};
  const FreeAndHeldPairs both = lowest_pairs(p, held, {7, 5}).value(),
                         free = lowest_pairs(p, held, {7, 0}).value(),
                         inner = lowest_pairs(p, held, {0, 5}).value();
  CHECK(free.held.values.size() == 0);
  CHECK(inner.free.values.size() == 0);
  CHECK((free.free.values - both.free.values).norm() <= 1e-12 * both.free.values.norm());
  CHECK((inner.held.values - both.held.values).norm() <= 1e-12 * both.held.values.norm());
}

TEST_CASE("lists end with whole clusters") {
  std::srand(13);
  BorderedPencil p = pencil(6, 2, 10, 0.3);
  for (int j = 0; j < 10; ++j) {  // of two equal leaves, one's image the other
    p.modes[10 + j] = p.modes[j];
    p.C.col(10 + j) = p.C.col(j);
    p.C.col(10 + j).head(3) *= -1;
  }
  p.C *= 1e-4;  // next to no coupling: pairs of values
  const VectorXd values = exact_values(p, p.size());
  int split = 0;
  for (int count = 1; count < 9; ++count) {
    const auto next_to_last = [&](const VectorXd& of, Eigen::Index n) {
      return of[n] - of[n - 1] <= 1e-3 * std::abs(of[n]);
    };
    const EigenPairs found = lowest_pairs(p, {0}, {count, 0}).value().free;
    const Eigen::Index n = found.values.size();
    CHECK(n >= count);
    split += n > count;
    CHECK_FALSE(next_to_last(values, n));
    CHECK((found.values - values.head(n)).norm() <= 1e-11 * values[n]);
  }
  CHECK(split > 0);
}

TEST_CASE("equal leaves have equal frequencies, also those that move no body") {
  std::srand(13);
  BorderedPencil p = pencil(6, 8, 6, 0.2);  // eight modes at each frequency, six coordinates
  for (int j = 0; j < 48; ++j) p.modes[j] = 4e5 * std::pow(1 + j % 6, 3);
  for (const int count : {3, 8, 12, 17})
    check_pairs(p, lowest(p, count), exact_values(p, count), 1e-12);
  p.C.setZero();
  check_pairs(p, lowest(p, 16), exact_values(p, 16), 1e-12);
}

TEST_CASE("frequencies within 1e-9 of each other are told apart, none is found twice") {
  std::srand(14);
  BorderedPencil p = pencil(6, 2, 10, 0.3);
  for (int j = 0; j < 10; ++j) {  // the second leaf is the first one's image, and hardly another
    p.modes[10 + j] = p.modes[j] * (1 + 1e-9);
    p.C.col(10 + j) = p.C.col(j);
    p.C.col(10 + j).head(3) *= -1;
  }
  p.M = p.C * p.C.transpose() + 0.3 * MatrixXd::Identity(6, 6);
  for (const int count : {7, 8, 9}) {
    check_pairs(p, lowest(p, count), exact_values(p, count), 1e-12);
  }
}

TEST_CASE("negative eigenvalues of the border and of modes come first") {
  std::srand(15);
  BorderedPencil p = pencil(6, 3, 10, 0.1);
  p.K(0, 0) -= 2 * p.K(0, 0);
  p.modes[4] = -3e5;
  const MatrixXd K = p.dense_stiffness(), M = p.dense_mass();
  const VectorXd values =
      Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(K, M).eigenvalues().head(8);
  REQUIRE(values[1] < 0);
  const EigenPairs found = lowest(p, 8);
  for (int k = 0; k < 8; ++k)  // the decomposition is good to the largest one's rounding
    CHECK(std::abs(found.values[k] - values[k]) < 1e-9 * std::abs(values[k]) + 1e-3);
  CHECK((found.vectors.transpose() * M * found.vectors - MatrixXd::Identity(8, 8)).norm() < 1e-9);
}

TEST_CASE("a pencil in other coordinates of its border has the same eigenvalues") {
  std::srand(17);
  const BorderedPencil p = pencil(6, 3, 10, 0.1);
  const MatrixXd Z = MatrixXd::Random(6, 6) + 3 * MatrixXd::Identity(6, 6);
  const BorderedPencil turned = p.along(Z);
  // coordinates that mix six decades round to the largest: 2e-12 to 3e-11 were seen
  check_pairs(turned, lowest(turned, 8), exact_values(p, 8), 1e-10);
}

TEST_CASE("one coordinate has its pair although the pencil is singular there to the last bit") {
  BorderedPencil p;
  p.K = MatrixXd::Constant(1, 1, 4);
  p.M = MatrixXd::Ones(1, 1);
  p.C = MatrixXd(1, 0);
  const FreeAndHeldPairs found = lowest_pairs(p, {0}, {3, 3}).value();
  REQUIRE(found.free.values.size() == 1);
  CHECK(found.free.values[0] == Approx(4).epsilon(1e-15));
  CHECK(std::abs(found.free.vectors(0, 0)) == Approx(1).epsilon(1e-15));
  CHECK(found.held.values.size() == 0);
}

TEST_CASE("beside buckling no pair is lost, on either side of it") {
  std::srand(18);
  for (const auto& [left, modes] : {std::pair{1e-13, 10},
                                    {-1e-13, 10},
                                    {1e-11, 10},
                                    {-1e-15, 4},
                                    {1e-16, 4},
                                    {1e-13, 4},
                                    {-1e-13, 4}}) {
    CAPTURE(left, modes);
    BorderedPencil p = pencil(6, modes == 4 ? 1 : 3, modes, 0.1);
    // all but so much of its stiffness is taken from one direction
    const VectorXd u = VectorXd::Random(6), soft = p.K.llt().solve(u);
    p.K -= (1 - left) / u.dot(soft) * u * u.transpose();
    const Long L = Long(p.dense_mass().cast<long double>()).llt().matrixL();
    Long A = L.triangularView<Eigen::Lower>().solve(Long(p.dense_stiffness().cast<long double>()));
    A = L.triangularView<Eigen::Lower>().solve(Long(A.transpose()));
    const VectorXd values =
        Eigen::SelfAdjointEigenSolver<Long>(A, Eigen::EigenvaluesOnly).eigenvalues().cast<double>();
    REQUIRE(std::abs(values[0]) < 1e-9 * values[1]);
    for (const int count : {1, 2, 8}) {
      const EigenPairs found = lowest(p, count);
      REQUIRE(found.values.size() == count);
      for (int k = 0; k < count; ++k)
        CHECK(std::abs(found.values[k] - values[k]) <=
              1e-11 * std::abs(values[k]) + 1e-12 * values[1]);
    }
  }
}
