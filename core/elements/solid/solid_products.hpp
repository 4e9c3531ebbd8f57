#pragma once
// The stiffness and the mass of a solid mesh times fields, cell by cell, and their rates: nothing
// is assembled but the stiffness that is factorised.
#include "core/elements/solid/solid_element.hpp"
#include "core/math/sparse_matrix.hpp"

namespace flexopt {

/// K · fields (3n × any) [N]. Cells where all fields vanish cost nothing.
MatrixXd stiffness_product(const ElasticBody& body, const MatrixXd& fields);
/// M · fields.
MatrixXd mass_product(const ElasticBody& body, const MatrixXd& fields);
/// Rates of these products while the body changes by `direction` and the fields stay. Cells whose
/// nodes do not move cost nothing unless the material changes.
MatrixXd stiffness_product_rate(const ElasticBody& body, const ElasticBody& direction,
                                const MatrixXd& fields);
MatrixXd mass_product_rate(const ElasticBody& body, const ElasticBody& direction,
                           const MatrixXd& fields);

/// Lower triangle of the stiffness over the nodes with a number, three unknowns each; `number`: of
/// each node, −1 for those that are held.
SparseMatrix free_stiffness(const ElasticBody& body, const std::vector<int>& number, int count);

}  // namespace flexopt
