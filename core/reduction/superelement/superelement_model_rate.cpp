#include "core/reduction/superelement/superelement_model_rate.hpp"

#include <algorithm>
#include <cmath>

#include "core/reduction/superelement/condensation.hpp"

namespace flexopt {

SuperelementModel scaled_model(const SuperelementGrid& grid, int row) {
  const double length = 1.0 / grid.along();
  return in_units(grid.plate(row).condensation->model(), length, 1, std::pow(length, 4));
}

SuperelementModelRate::SuperelementModelRate(const SuperelementGrid& grid) {
  // a superelement over its leaf: its length, and what its own shape is to that of the leaf
  const double length = 1.0 / grid.along(), mass = std::pow(length, 4);
  const std::array<double, 3> own{double(grid.along()) / grid.rows(), double(grid.along()), 1.0};
  std::vector<const CondensedPlate*> plates;
  for (int row = 0; row < grid.rows(); ++row) {
    const CondensedPlate* plate = &grid.plate(row);
    const auto known = std::find(plates.begin(), plates.end(), plate);
    kind_of_row_.push_back(static_cast<int>(known - plates.begin()));
    if (known != plates.end()) continue;
    plates.push_back(plate);
    ScaledSuperelement kind{scaled_model(grid, row), plate->condensation->shape_rates()};
    for (int p = 0; p < 3; ++p) {
      SuperelementModel& rate = kind.shape[p] = in_units(kind.shape[p], length, 1, mass);
      for (Vector3d& node : rate.nodes) node *= own[p];
      for (MatrixXd* A : {&rate.stiffness, &rate.mass, &rate.frame_modes, &rate.recovery})
        *A *= own[p];
    }
    kinds_.push_back(std::move(kind));
  }
}

}  // namespace flexopt
