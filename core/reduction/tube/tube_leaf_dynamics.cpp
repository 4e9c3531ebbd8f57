// The dynamics of a tube leaf: from its tables, or from the full leaf condensed at its state.
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/reduction/tube/tube_leaf.hpp"

namespace flexopt {
namespace {

constexpr int internal = TubeDynamics::amplitudes;

/// Number of modes of a full leaf below TubeDynamics::Answer::reach.
constexpr int tabulated_modes = 8;

}  // namespace

void TubeModel::expect_dynamics(int states) {
  // States, for each bent state of the tube, from which tables cost less; measured on the default
  // mesh.
  constexpr int states_that_pay = 10;
  const int enough = dynamics_known() ? 1 : states_that_pay * bent_states();
  const bool before = expected_ >= enough;
  expected_ += states;
  if (!before && expected_ >= enough) make_dynamics();
}

bool TubeModel::has_dynamics(const PlateShape& shape) {
  // Largest w²/(L t) for which statics and dynamics were compared with full leaves.
  constexpr double widest = 1200;  // w²/(L t)
  const bool flat = !shape.curve && !shape.fold && !shape.has_profile() && !shape.is_beam();
  // ten loads on coarser meshes are not independent
  return flat && shape.width * shape.width <= widest * shape.thickness && shape.mesh[0] >= 4 &&
         shape.mesh[1] >= 2;
}

void TubeModel::make_dynamics() {
  if (dynamics_ || !built() || !has_dynamics(shape_)) return;
  if (dynamics_known()) return look_up_dynamics(range_.sigma_max, StationsWanted::no);
  cover(range_.sigma_max);
  leaf().reset();
  dynamics_ = std::make_unique<TubeDynamics>(range_.force_centre);
  for (const TubeExpansion& e : expansions_) {
    stand_at(e);
    add_dynamics(e.sigma);
  }
}

void TubeModel::add_dynamics(double sigma) {
  if (loads_.loads.size() == 0) loads_ = internal_loads(*mesh());
  kept_ = {};
  dynamics_->add(dynamics_node(leaf(), sigma, directions_, loads_, amplitude_units_));
}

void TubeModel::look_up_dynamics(double sigma, StationsWanted stations) {
  kept_ = {};
  dynamics_ = std::make_unique<TubeDynamics>(range_.force_centre);
  for (DynamicsNode& node : known_->dynamics(sigma, stations)) dynamics_->add(std::move(node));
}

const DynamicsRates& TubeModel::dynamics_rates() {
  assert(differentiable_dynamics());
  if (known_dynamics_rates_.empty() ||
      known_dynamics_rates_.front().back().sigma != dynamics_->last_sigma())
    known_dynamics_rates_ = known_->dynamics_rates(dynamics_->last_sigma());
  return known_dynamics_rates_;
}

void TubeModel::reach_dynamics(double sigma, StationsWanted stations) {
  if (!dynamics_) return;
  if (!dynamics_known()) return cover(sigma);
  const bool had = dynamics_->has_stations(), more = stations == StationsWanted::yes && !had;
  if (more || sigma > dynamics_->last_sigma() * (1 + 1e-9))
    look_up_dynamics(std::max({sigma, range_.sigma_max, dynamics_->last_sigma()}),
                     had ? StationsWanted::yes : stations);
}

TubeDynamics::Place TubeLeaf::place() const {
  const Vector6d& e = response_.frame.e;
  const TubeLocation at = tables_->potential().locate({e[theta1y], e[theta2y], e[twist]});
  return {at.sigma, at.tau, e[twist], state_.mixed.f};
}

TubeDynamics::Place TubeLeaf::place_in_tables() const {
  TubeDynamics::Place at = place();
  const TubeView view = tables_->view();
  if (!view.from_tip) return at;
  at.twist *= view.signs()[8];
  std::swap(at.f[1], at.f[2]);
  return at;
}

// (D7)
Matrix12d TubeLeaf::edge_rates() const {
  const ChordFrame& frame = response_.frame;
  const MixedState& mixed = state_.mixed;
  const TubeView view = tables_->view();
  const int base = view.from_tip ? 6 : 0, first = view.from_tip ? theta2y : theta1y,
            second = view.from_tip ? theta1y : theta2y;
  Matrix12d T = Matrix12d::Zero();
  T.block<3, 3>(0, base) = frame.axes.transpose();
  T.middleRows<3>(3) = frame.axes.transpose().lazyProduct(frame.spin);
  T.row(6) = frame.B.row(first);
  T.row(7) = frame.B.row(second);
  T.row(8) = frame.B.row(twist);
  const Eigen::Matrix<double, 3, 6> f = -mixed.F_inverse * mixed.h;
  T.middleRows<3>(9) = f.lazyProduct(frame.B);
  if (!view.from_tip) return T;
  T.row(10).swap(T.row(11));
  return view.signs().asDiagonal() * T;
}

const TubeDynamics::Answer* TubeLeaf::tabulated() {
  condensed_because_.clear();
  tables_->reach_dynamics(std::abs(place().sigma), StationsWanted::no);
  const TubeDynamics* tables = tables_->dynamics();
  if (!tables) return nullptr;
  if (std::abs(place().sigma) > tables->last_sigma() * (1 + 1e-9)) {
    condensed_because_ = "frequencies of the full leaf: it bends beyond the tables";
    return nullptr;
  }
  if (!internal_) {
    const TubeDynamics::Place at = place_in_tables();
    internal_ = tables_->kept().dynamics.at(at, [&] {
      const double change = tables->change(at);
      TubeDynamics::Answer answer;
      if (change <= largest_dynamics_change) answer = tables->evaluate(at);
      answer.change = change;
      return answer;
    });
  }
  // far off the force about which they were expanded, tables err more for the same change
  const double largest = (model_->range().under_load() ? 0.5 : 1.0) * largest_dynamics_change;
  if (internal_->reason.empty() && internal_->change <= largest) return &*internal_;
  condensed_because_ =
      "frequencies of the full leaf: " +
      (internal_->reason.empty()
           ? fmt::format(
                 "the last degree of the tables changes the internal stiffness by {:.2g} > {:.2g}",
                 internal_->change, largest)
           : internal_->reason);
  return nullptr;
}

LeafDynamics TubeLeaf::dynamics_of(const TubeDynamics::Answer& local) const {
  const Matrix12d T = edge_rates().lazyProduct(scale_.transformation().transpose());
  const double root = std::sqrt(scale_.mass);  // unit modal mass in SI
  LeafDynamics dynamics;
  dynamics.mass.resize(12 + internal, 12 + internal);
  const Matrix12d MT = local.mass.topLeftCorner<12, 12>().lazyProduct(T);
  dynamics.mass.topLeftCorner<12, 12>() = scale_.mass * T.transpose().lazyProduct(MT);
  dynamics.mass.bottomLeftCorner<internal, 12>() =
      root * local.mass.bottomLeftCorner<internal, 12>().lazyProduct(T);
  dynamics.mass.topRightCorner<12, internal>() =
      dynamics.mass.bottomLeftCorner<internal, 12>().transpose();
  dynamics.mass.bottomRightCorner<internal, internal>() =
      local.mass.bottomRightCorner<internal, internal>();
  const double unit = scale_.energy / scale_.mass;
  dynamics.internal_stiffness = unit * local.stiffness;
  const double to_hertz = std::sqrt(unit) / (2 * std::numbers::pi);
  dynamics.mode_frequencies =
      to_hertz * local.stiffness.diagonal()
                     .cwiseQuotient(local.mass.bottomRightCorner<internal, internal>().diagonal())
                     .cwiseSqrt();
  dynamics.highest_mode = to_hertz * std::sqrt(local.reach);
  return dynamics;
}

std::optional<LeafDynamics> TubeLeaf::tabulated_dynamics(const DynamicsRequest& request) {
  condensed_because_.clear();
  if (request.modes == 0) return std::nullopt;
  if (request.modes > tabulated_modes && tables_->dynamics()) {
    condensed_because_ =
        "frequencies of the full leaf: they take more internal modes than the tables have";
    return std::nullopt;
  }
  const TubeDynamics::Answer* const found = tabulated();
  if (!found) return std::nullopt;
  check_ = 0;  // nothing is condensed
  LeafDynamics dynamics = dynamics_of(*found);
  if (!request.stations) return dynamics;

  // from chord axes to the leaf's, and to what leaf_station_motion() calls motion
  const Matrix12d T = edge_rates().lazyProduct(scale_.transformation().transpose());
  const MatrixXd stations = tabulated_stations();
  const double weight = station_weight(stations.rows());
  dynamics.stations.resize(stations.rows(), 12 + internal);
  dynamics.stations.leftCols(12) = weight * (stations.leftCols<12>() * T);
  dynamics.stations.rightCols(internal) =
      weight / std::sqrt(scale_.mass) * stations.rightCols(internal);
  return dynamics;
}

MatrixXd TubeLeaf::tabulated_stations() const {
  tables_->reach_dynamics(std::abs(place().sigma), StationsWanted::yes);
  MatrixXd stations =
      tables_->view().seen_from_base(tables_->dynamics()->stations(place_in_tables()));
  for (Eigen::Index i = 0; i < stations.rows(); i += 3)
    stations.middleRows<3>(i) = (response_.frame.axes * stations.middleRows<3>(i)).eval();
  return stations;
}

double TubeLeaf::station_weight(Eigen::Index rows) const {
  return std::sqrt(scale_.mass * model_->shape().width * 6 / static_cast<double>(rows));
}

LeafDynamics TubeLeaf::dynamics(DynamicsRequest request) {
  // the tables have no motions of points between their stations
  if (!request.shapes)
    if (std::optional<LeafDynamics> tabulated = tabulated_dynamics(request)) return *tabulated;
  LeafDynamics dynamics = plate_dynamics(condensed(), leaf_, scale_, request);
  dynamics.check = check_;
  return dynamics;
}

}  // namespace flexopt
