#pragma once
// The superelements of a leaf in units of the leaf, and their exact derivatives in its shape.
#include <array>
#include <vector>

#include "core/reduction/superelement/superelement_grid.hpp"

namespace flexopt {

/// Lengths over L, energies over D, masses over ρ t L⁴ of the leaf (LeafScale): the shape of the
/// leaf is all that such a model depends on. `row`: across, all along it are alike.
SuperelementModel scaled_model(const SuperelementGrid& grid, int row);

struct ScaledSuperelement {
  SuperelementModel model;
  std::array<SuperelementModel, 3> shape;  ///< ∂model/∂(w/L, t/L, ν): Condensation::shape_rates
};

/// Those of a grid, made once for every kind of superelement in it.
class SuperelementModelRate {
 public:
  explicit SuperelementModelRate(const SuperelementGrid& grid);
  const ScaledSuperelement& operator[](int element) const {
    return kinds_[kind_of_row_[element % static_cast<int>(kind_of_row_.size())]];
  }

 private:
  std::vector<int> kind_of_row_;
  std::vector<ScaledSuperelement> kinds_;
};

}  // namespace flexopt
