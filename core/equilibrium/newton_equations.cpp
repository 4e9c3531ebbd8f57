#include "core/equilibrium/newton_equations.hpp"

#include "core/equilibrium/stroke_path.hpp"
#include "core/math/sparse_solver.hpp"

namespace flexopt {

NewtonEquations::NewtonEquations(const System& system, DriveHold held, int more)
    : system_(&system),
      held_(held),
      bodies_(system.size()),
      conditions_(system.constraints().count()),
      scale_(system.units()),
      size_(0),
      matrix_(0) {
  for (std::size_t k = 0; k < system.drives().size(); ++k)
    if (system.drives()[k].coordinate && system.holds(k, held))
      owned_.push_back(static_cast<int>(k));
  load_unit_.resize(loads());
  reaction_.resize(conditions_);
  size_ = behind() + more;
}

int NewtonEquations::coordinate(int load) const {
  return *system_->drives()[owned_[static_cast<std::size_t>(load)]].coordinate;
}

void NewtonEquations::add_condition(int j, bool held) {
  const Constraints& c = system_->constraints();
  const int at = first_condition() + j;
  c.rows()[j].each([&](int d, double value) {
    matrix_.add(d, at, scale_[d] * value * reaction_[j]);
    if (held) matrix_.add(at, d, 1 / c.units()[j] * value * scale_[d]);
  });
}

void NewtonEquations::assemble(const VectorXd& residual, const std::optional<VectorXd>& strokes) {
  matrix_ = SparseMatrix(size_);
  right_side_ = VectorXd::Zero(size_);
  matrix_.add(system_->residual_tangent(), scale_, scale_);
  right_side_.head(bodies_) = scale_.cwiseProduct(residual);
  energy_ = system_->tangent().diagonal().cwiseProduct(scale_.cwiseAbs2()).cwiseAbs().maxCoeff();
  const VectorXd present = present_strokes(*system_);
  for (int j = 0; j < loads(); ++j) {
    const int d = coordinate(j), k = owned_[j], row = bodies_ + j;
    // where there are joints no leaf may hang on the body that is driven
    load_unit_[j] = scale_[d] * (conditions_ > 0 ? energy_ / (scale_[d] * scale_[d])
                                                 : system_->tangent()(d, d));
    matrix_.add(d, row, -scale_[d] * load_unit_[j]);
    matrix_.add(row, d, scale_[d]);
    right_side_[row] = (*strokes)[k] - present[k];
  }
  if (conditions_ == 0) return;
  const Constraints& c = system_->constraints();
  reaction_ = energy_ * c.units().cwiseInverse();
  for (int j = 0; j < conditions_; ++j) {
    const int row = first_condition() + j, k = j < c.joints() ? -1 : c.drives()[j - c.joints()];
    const bool held = k < 0 || system_->holds(k, held_);
    add_condition(j, held);
    if (k < 0) {
      right_side_[row] = -c.value()[j] / c.units()[j];
    } else if (held) {
      right_side_[row] = ((*strokes)[k] - c.value()[j]) / c.units()[j];
    } else {
      matrix_.add(row, row, 1);
    }
  }
}

VectorXd NewtonEquations::solve() const {
  return LinearSolver(matrix_, system_->analyses()).solve(right_side_);
}

double NewtonEquations::violation() const {
  return conditions_ == 0
             ? 0
             : right_side_.segment(first_condition(), conditions_).cwiseAbs().maxCoeff();
}

VectorXd NewtonEquations::multipliers(const VectorXd& x) const {
  return reaction_.cwiseProduct(x.segment(first_condition(), conditions_));
}

void NewtonEquations::read_loads(const VectorXd& x, VectorXd& drive_loads) const {
  for (int j = 0; j < loads(); ++j) drive_loads[owned_[j]] = x[bodies_ + j] * load_unit_[j];
}

}  // namespace flexopt
