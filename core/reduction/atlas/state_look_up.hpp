#pragma once
// Tables about bent states (state_table.hpp) as rows of numbers, and looked up on any ray.
#include <vector>

#include "core/reduction/atlas/coded_tables.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"
#include "core/reduction/tube/state_table.hpp"

namespace flexopt {

/// Rows of the parts of a state table; monomials of the even part.
struct TableForm {
  Eigen::Index even_rows = 0, odd_rows = 0;
  Eigen::Index even_monomials = StateTable::even_monomials;

  Eigen::Index numbers() const {
    return even_rows * even_monomials + odd_rows * StateTable::odd_monomials;
  }
};

/// All numbers of a table in a row, and the table that has them.
VectorXd table_numbers(const StateTable& table);
StateTable table_of(double sigma, const TableForm& form, const Eigen::Ref<const VectorXd>& numbers);

/// Table about the bent state `node`, which stands at `sigma`, on a ray, then what it changes by,
/// as many slopes as the place has. `ray`: among the rays of `tables`.
std::vector<StateTable> look_up_tables(const CodedTables& tables, const CodedTables::Place& at,
                                       const RayNeighbours& ray, int node, double sigma,
                                       const TableForm& form);

}  // namespace flexopt
