#include "core/reduction/modal/modal_leaf_linear.hpp"

#include "core/reduction/modal/modal_leaf_gradient.hpp"

namespace flexopt {

Answer<LeafLinear> ModalLeaf::linearise() {
  if (!evaluated_) evaluate();
  return {std::make_unique<ModalLeafLinear>(*this)};
}

Answer<LeafGradient<double>> ModalLeafLinear::gradient(LeafRates& rates,
                                                       const LeafRows& rows) const {
  return {std::make_unique<ModalLeafGradient>(
      *leaf_, shared_model_rate(rates, leaf_->shared_model()), rows)};
}

MatrixXd ModalLeafLinear::static_shapes(const std::vector<int>& columns) const {
  return MatrixXd(leaf_->static_shapes() * leaf_->frame().B)(Eigen::all, columns);
}

MatrixXd ModalLeafLinear::mass_times(const MatrixXd& V) const {
  MatrixXd edges_first(V.rows(), V.cols());
  edges_first << V.bottomRows(12), V.topRows(unknowns());
  const MatrixXd f = mass_ * edges_first;
  MatrixXd result(V.rows(), V.cols());
  result << f.bottomRows(unknowns()), f.topRows(12);
  return result;
}

MatrixXd ModalLeafLinear::station_motion(const MatrixXd& V) const {
  return leaf_->station_motion(rates_.leftCols<12>() * V.bottomRows(12) +
                               rates_.rightCols(unknowns()) * V.topRows(unknowns()));
}

}  // namespace flexopt
