#pragma once
// Matrices whose entries are polynomials, truncated at a total degree: sums, products, inverses.
#include <vector>

#include "core/math/polynomial.hpp"
#include "core/math/types.hpp"

namespace flexopt {

/// A(x) = Σ_m A_m x^m over the monomials of a table. Results are truncated at its order.
class MatrixPolynomial {
 public:
  MatrixPolynomial() = default;
  /// The zero polynomial. The table must outlive it.
  MatrixPolynomial(const MonomialTable& table, Eigen::Index rows, Eigen::Index cols)
      : table_(&table),
        rows_(rows),
        cols_(cols),
        coefficients_(static_cast<std::size_t>(table.size()), MatrixXd::Zero(rows, cols)) {}

  const MonomialTable& table() const { return *table_; }
  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return cols_; }
  int size() const { return static_cast<int>(coefficients_.size()); }
  /// Coefficient of monomial m.
  MatrixXd& operator[](int m) { return coefficients_[m]; }
  const MatrixXd& operator[](int m) const { return coefficients_[m]; }

  MatrixPolynomial transposed() const;
  /// A block of rows and columns of the polynomial.
  MatrixPolynomial block(Eigen::Index row, Eigen::Index col, Eigen::Index rows,
                         Eigen::Index cols) const;
  void set_block(Eigen::Index row, Eigen::Index col, const MatrixPolynomial& part);
  /// Series of the inverse, for a square matrix whose constant part is regular.
  MatrixPolynomial inverse() const;

  MatrixPolynomial& operator+=(const MatrixPolynomial& b);
  MatrixPolynomial& operator-=(const MatrixPolynomial& b);
  friend MatrixPolynomial operator+(MatrixPolynomial a, const MatrixPolynomial& b) {
    return a += b;
  }
  friend MatrixPolynomial operator-(MatrixPolynomial a, const MatrixPolynomial& b) {
    return a -= b;
  }
  friend MatrixPolynomial operator*(const MatrixPolynomial& a, const MatrixPolynomial& b);

 private:
  const MonomialTable* table_ = nullptr;
  Eigen::Index rows_ = 0, cols_ = 0;
  std::vector<MatrixXd> coefficients_;
};

}  // namespace flexopt
