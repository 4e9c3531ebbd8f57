#pragma once
// Files of matrices that a file of an elastic body names.
#include <string>

#include "designs/solids/import_matrices.hpp"

namespace flexopt {

/// A square matrix of Matrix Market (coordinate or array; real; general or symmetric). Throws
/// SpecError: another size than `n`, what is no such file.
MatrixXd read_matrix_market(const std::string& file, int n);

}  // namespace flexopt
