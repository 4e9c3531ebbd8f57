#include "core/math/matrix_polynomial.hpp"

#include <cassert>

#include "core/math/decompositions.hpp"

namespace flexopt {

MatrixPolynomial MatrixPolynomial::transposed() const {
  MatrixPolynomial t(*table_, cols_, rows_);
  for (int m = 0; m < size(); ++m) t[m] = (*this)[m].transpose();
  return t;
}

MatrixPolynomial MatrixPolynomial::block(Eigen::Index row, Eigen::Index col, Eigen::Index rows,
                                         Eigen::Index cols) const {
  MatrixPolynomial part(*table_, rows, cols);
  for (int m = 0; m < size(); ++m) part[m] = (*this)[m].block(row, col, rows, cols);
  return part;
}

void MatrixPolynomial::set_block(Eigen::Index row, Eigen::Index col, const MatrixPolynomial& part) {
  assert(part.size() == size());
  for (int m = 0; m < size(); ++m) (*this)[m].block(row, col, part.rows(), part.cols()) = part[m];
}

MatrixPolynomial& MatrixPolynomial::operator+=(const MatrixPolynomial& b) {
  for (int m = 0; m < size(); ++m) (*this)[m] += b[m];
  return *this;
}

MatrixPolynomial& MatrixPolynomial::operator-=(const MatrixPolynomial& b) {
  for (int m = 0; m < size(); ++m) (*this)[m] -= b[m];
  return *this;
}

MatrixPolynomial operator*(const MatrixPolynomial& a, const MatrixPolynomial& b) {
  assert(a.cols() == b.rows() && a.size() == b.size());
  const MonomialTable& table = a.table();
  MatrixPolynomial c(table, a.rows(), b.cols());
  for (int i = 0; i < table.size(); ++i) {
    const std::uint16_t* k = table.products(i);
    for (int j = 0; j < table.count(table.order() - table.degree(i)); ++j)
      c[k[j]].noalias() += a[i] * b[j];
  }
  return c;
}

// Newton's iteration doubles the number of degrees that are right.
MatrixPolynomial MatrixPolynomial::inverse() const {
  assert(rows_ == cols_);
  MatrixPolynomial X(*table_, rows_, cols_);
  X[0] = Lu((*this)[0]).inverse();
  for (int right = 1; right <= table_->order(); right *= 2) {
    const MatrixPolynomial XAX = X * (*this * X);
    X += X;
    X -= XAX;
  }
  return X;
}

}  // namespace flexopt
