#include "core/response/models/dynamic_tables.hpp"

#include <algorithm>

#include "core/reduction/tube/tube_leaf.hpp"

namespace flexopt {

void make_dynamic_tables(const std::vector<std::unique_ptr<LeafElement>>& leaves, int points) {
  std::vector<std::shared_ptr<TubeModel>> models;  // one for each leaf that has one
  for (const auto& leaf : leaves)
    if (const auto* tube = dynamic_cast<const TubeLeaf*>(leaf.get()))
      models.push_back(tube->model());
  for (const auto& model : models) {
    const auto equal = std::count(models.begin(), models.end(), model);
    if (points * equal >= states_that_pay * model->bent_states()) model->make_dynamics();
  }
}

}  // namespace flexopt
