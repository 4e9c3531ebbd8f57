#include "core/reduction/atlas/state_look_up.hpp"

#include <cassert>
#include <utility>

namespace flexopt {

VectorXd table_numbers(const StateTable& table) {
  VectorXd numbers(table.even.size() + table.odd.size());
  numbers << table.even.reshaped(), table.odd.reshaped();
  return numbers;
}

StateTable table_of(double sigma, const TableForm& form,
                    const Eigen::Ref<const VectorXd>& numbers) {
  assert(numbers.size() == form.numbers());
  const Eigen::Index evens = form.even_rows * form.even_monomials;
  return {sigma, numbers.head(evens).reshaped(form.even_rows, form.even_monomials),
          numbers.tail(numbers.size() - evens).reshaped(form.odd_rows, StateTable::odd_monomials)};
}

std::vector<StateTable> look_up_tables(const CodedTables& tables, const CodedTables::Place& at,
                                       const RayNeighbours& ray, int node, double sigma,
                                       const TableForm& form) {
  const auto on_ray = [&](int k) {
    const MatrixXd numbers = tables.look_up(k, node, at);
    std::vector<StateTable> found;
    for (Eigen::Index c = 0; c < numbers.cols(); ++c)
      found.push_back(table_of(sigma, form, numbers.col(c)));
    return found;
  };
  if (ray.on_left) return on_ray(ray.left);
  if (ray.on_right) return on_ray(ray.left + 1);
  std::vector<StateTable> found = on_ray(ray.left);
  const std::vector<StateTable> right = on_ray(ray.left + 1);
  const RayBlend blend = blend_between_rays(ray.a, ray.b, sigma, ray.rho);
  for (std::size_t c = 0; c < found.size(); ++c) found[c] = blended(found[c], right[c], blend);
  return found;
}

}  // namespace flexopt
