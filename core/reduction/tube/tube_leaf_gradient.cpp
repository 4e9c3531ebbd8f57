#include "core/reduction/tube/tube_leaf_gradient.hpp"

#include <cassert>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "core/elements/leaf/leaf_fields.hpp"
#include "core/elements/plate/mesh_numbers.hpp"
#include "core/elements/plate/plate_stress.hpp"

namespace flexopt {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

// Indices in (e, f) of the variables of the potential, (θ1y, θ2y, φx, N, M1, M2), and of the
// deformations on which the forces do work.
constexpr std::array<int, 6> of_potential{theta1y, theta2y, twist, 6, 7, 8};
constexpr std::array<int, 3> stretched{elongation, theta1z, theta2z};

// Derivative of tube_force_scale() by w/L, of a leaf of uniform width.
Vector3d force_scale_rate(const PlateShape& shape) { return {1, 2 * shape.width, 2 * shape.width}; }

// Derivatives in (e, f) of W* + f · c (u, θ1z, θ2z).
Vector9d force_of(const PotentialValue& W, const Vector3d& scale, const Vector6d& e,
                  const Vector3d& f) {
  Vector9d g = Vector9d::Zero();
  g(of_potential) = W.gradient;
  for (int i = 0; i < 3; ++i) {
    g[stretched[i]] = scale[i] * f[i];
    g[6 + i] += scale[i] * e[stretched[i]];
  }
  return g;
}

Matrix9d tangent_of(const PotentialValue& W, const Vector3d& scale) {
  Matrix9d H = Matrix9d::Zero();
  H(of_potential, of_potential) = W.hessian;
  for (int i = 0; i < 3; ++i) H(stretched[i], 6 + i) = H(6 + i, stretched[i]) = scale[i];
  return H;
}

}  // namespace

void TubeLeafLinear::solve(Eigen::Ref<MatrixXd> b) const {
  b.topRows<3>() = (leaf_->mixed().F_inverse * b.topRows<3>()).eval();
  if (!internal_) return;
  auto amplitudes = b.bottomRows<P>();
  solve_factorised(stiffness_factor_, amplitudes);
}

MatrixXd TubeLeafLinear::static_shapes(const std::vector<int>& columns) const {
  const MixedState& m = leaf_->mixed();
  const Rows3x12 shapes = -m.F_inverse * m.h * leaf_->response().frame.B;
  MatrixXd all = MatrixXd::Zero(unknowns(), static_cast<Eigen::Index>(columns.size()));
  all.topRows<3>() = shapes(Eigen::all, columns);
  return all;
}

// The mass is that of the forces that belong to the edges' rates, whatever those among V.
MatrixXd TubeLeafLinear::mass_times(const MatrixXd& V) const {
  assert(internal_);
  MatrixXd MV = MatrixXd::Zero(V.rows(), V.cols());
  MatrixXd rates(12 + P, V.cols());
  rates.topRows<12>().noalias() = edge_rates_ * V.bottomRows<12>();
  rates.bottomRows<P>() = V.middleRows<P>(3);
  const MatrixXd moved = internal_->mass * rates;
  MV.middleRows<P>(3) = moved.bottomRows<P>();
  MV.bottomRows<12>().noalias() = edge_rates_.transpose() * moved.topRows<12>();
  return MV;
}

MatrixXd TubeLeafLinear::station_motion(const MatrixXd& V) const {
  assert(internal_);
  const MatrixXd stations = leaf_->tabulated_stations();
  const double weight = leaf_->station_weight(stations.rows());
  return weight * (stations.leftCols<12>() * (edge_rates_ * V.bottomRows<12>()) +
                   stations.rightCols<P>() * V.middleRows<P>(3));
}

std::optional<InternalMotions> TubeLeafLinear::internal_motions() const {
  if (!internal_) return std::nullopt;
  InternalMotions motions{leaf_->dynamics_of(*internal_), MatrixXd::Zero(unknowns(), P)};
  motions.unknowns.bottomRows<P>().diagonal().setConstant(1 / std::sqrt(scale().mass));
  return motions;
}

std::optional<double> TubeLeafLinear::highest_mode() const {
  if (!internal_) return std::nullopt;
  return std::sqrt(scale().energy / scale().mass * internal_->reach) / (2 * std::numbers::pi);
}

Answer<std::unique_ptr<LeafGradient<double>>> TubeLeafLinear::gradient(LeafRates& rates,
                                                                       const LeafRows& rows) const {
  const std::shared_ptr<TubeModel>& model = leaf_->model();
  if (!model->differentiable()) return Because("its tube was built, not looked up");
  const auto of_model =
      rates.of<TubeRates>(model, [&] { return TubeRates(model->potential(), model->rates()); });
  return std::make_unique<TubeLeafGradient>(*leaf_, *of_model,
                                            internal_ ? &model->dynamics_rates() : nullptr, rows);
}

TubeLeafLinear::TubeLeafLinear(const TubeLeaf& leaf, const TubeDynamics::Answer* internal)
    : leaf_(&leaf), internal_(internal) {
  if (!internal) return;
  edge_rates_ = leaf.edge_rates();
  stiffness_factor_ = internal->stiffness;
  [[maybe_unused]] const bool positive = factorise(stiffness_factor_);
  assert(positive);
}

Check TubeLeaf::check_interior(InteriorUse use) {
  if (!model_->differentiable()) return Because("its tube was built, not looked up");
  if (use.places) return Because("places inside it are those of the full leaf");
  if (use.stress && !model_->differentiable_stress())
    return Because("it has no tables of its stress");
  if (use.stress && !tabulated_strains()) return Because(rebuilt_because_);
  if (use.mass && !model_->differentiable_dynamics())
    return Because("it has no tables of its dynamics");
  if (use.mass && !tabulated()) return Because(condensed_because_);
  return {};
}

Answer<std::unique_ptr<LeafLinear>> TubeLeaf::linearise() {
  if (!model_->differentiable()) return Because("its tube was built, not looked up");
  const TubeDynamics::Answer* internal = nullptr;
  if (model_->dynamics() && !(internal = tabulated())) return Because(condensed_because_);
  return std::make_unique<TubeLeafLinear>(*this, internal);
}

TubeLeafGradient::TubeLeafGradient(const TubeLeaf& leaf, const TubeRates& rates,
                                   const DynamicsRates* dynamics, const LeafRows& rows)
    : LeafGradient<double>(rows, leaf.model()->shape().width), leaf_(&leaf) {
  assert(rows.unknowns == 3 + (dynamics ? P : 0) && rows.point == 0);
  const ChordFrame& frame = leaf.response().frame;
  const Vector6d& e = frame.e;
  const Vector3d &f = leaf.mixed().f, &scale = leaf.model()->potential().force_scale();
  TubeModel::KeptAnswers& kept = leaf.model()->kept();
  const auto known = kept.potential_rates.at(leaf.place(), [&] {
    return rates.evaluate({e[theta1y], e[theta2y], e[twist]}, f);
  });
  const TubeRates::Answer& W = *known;
  tangent_ = tangent_of(W.potential, scale);
  third_ = W.third;
  // the amplitudes have no force on them, whatever the state
  const int own = 6 + rows.unknowns;
  ChordGradient::Energy energy{VectorXd::Zero(own), MatrixXd::Zero(own, own),
                               MatrixXd::Zero(own, 3)};
  energy.force.head<9>() = force_of(W.potential, scale, e, f);
  energy.tangent.topLeftCorner<9, 9>() = tangent_;
  for (int p = 0; p < 3; ++p) {
    const PotentialValue& by = W.by_shape[static_cast<std::size_t>(p)];
    const Vector3d scale_rate =
        p == ShapeParameter::width ? force_scale_rate(leaf.model()->shape()) : Vector3d::Zero();
    energy.shape_force.col(p).head<9>() = force_of(by, scale_rate, e, f);
    shape_tangent_[static_cast<std::size_t>(p)] = tangent_of(by, scale_rate);
  }
  chord_ = ChordGradient(frame, leaf.edges(), rows, std::move(energy));
  force_ = chord_.force();
  const TubeDynamics::Place at = leaf.place_in_tables();
  if (dynamics)
    internal_ = kept.dynamics_forms.at(
        at, [&] { return DynamicsForm(*leaf.model()->dynamics(), at, *dynamics); });
}

// Derivatives of a form along (e, f), along e1 and the frame's motion, of its column's increments.
struct TubeLeafGradient::Covectors {
  Vector9d state = Vector9d::Zero();
  Vector6d first = Vector6d::Zero();
  Vector3d spin = Vector3d::Zero(), base = Vector3d::Zero(), apart = Vector3d::Zero();
};

// ηᵀK_a η − μ rᵀM r with f1 = −F⁻¹h e1 in r, whatever the column has: (D8), (D9).
void TubeLeafGradient::add_internal(const ChordGradient::Column& column, const VectorXd& amplitudes,
                                    double mu, LeafQuadratic<double>& q, int k,
                                    Covectors& of) const {
  const MixedState& mixed = leaf_->mixed();
  const TubeView view = leaf_->model()->view();
  const Vector3d f1 = -mixed.F_inverse * (mixed.h * column.e1);
  const int first = view.from_tip ? theta2y : theta1y, second = view.from_tip ? theta1y : theta2y;
  Eigen::Matrix<double, 12, 1> edges;
  edges << (view.from_tip ? Vector3d(column.base + column.apart) : column.base),
      column.path.first.spin, column.e1[first], column.e1[second], column.e1[twist], f1;
  if (view.from_tip) std::swap(edges[10], edges[11]);
  DynamicsForm::Rates r;
  r << view.signs().cwiseProduct(edges), amplitudes;
  const DynamicsForm::Value value = internal_->at(r, mu);
  q.stiffness[k] += value.stiffness;
  q.mass[k] += value.mass;
  q.shape.col(k).head<3>() += value.shape;

  // along (θ1y, θ2y, φ), f of the potential
  const Eigen::Matrix2d to_ray = leaf_->model()->potential().ray().inverse();
  const Eigen::Vector2d bending = to_ray.transpose() * value.state.head<2>();
  Vector3d by_f = value.state.tail<3>();
  Eigen::Matrix<double, 12, 1> by_rates =
      -2 * mu * view.signs().cwiseProduct(value.along_mass.head<12>());
  if (view.from_tip) {
    std::swap(by_f[1], by_f[2]);
    std::swap(by_rates[10], by_rates[11]);
  }
  of.state[theta1y] += bending[0];
  of.state[theta2y] += bending[1];
  of.state[twist] += view.signs()[8] * value.state[2];
  of.state.tail<3>() += by_f;

  of.base = by_rates.head<3>();
  if (view.from_tip) of.apart = by_rates.head<3>();
  of.spin = by_rates.segment<3>(3);
  of.first[first] += by_rates[6];
  of.first[second] += by_rates[7];
  of.first[twist] += by_rates[8];
  // f1 follows: F ḟ1 = −(Π,fz)˙ z1 − h ė1
  const Vector3d pulled = mixed.F_inverse * by_rates.tail<3>();
  of.first -= mixed.h.transpose() * pulled;
  Vector9d z1, w = Vector9d::Zero();
  z1 << column.e1, f1;
  w.tail<3>() = pulled;
  of.state -= third_of(w, z1);
  for (int p = 0; p < 3; ++p)
    q.shape(p, k) -= w.dot(shape_tangent_[static_cast<std::size_t>(p)] * z1);
}

// Derivatives of aᵀΠ,zz b along (e, f).
auto TubeLeafGradient::third_of(const Vector9d& a, const Vector9d& b) const -> Vector9d {
  Vector9d third = Vector9d::Zero();
  const Vector6d x = a(of_potential), y = b(of_potential);
  for (std::size_t i = 0; i < 6; ++i) third[of_potential[i]] = x.dot(third_[i] * y);
  return third;
}

LeafQuadratic<double> TubeLeafGradient::quadratic(const MatrixXd& Y, const VectorXd& mu) const {
  const int columns = static_cast<int>(Y.cols());
  assert(internal_ || mu.isZero(0));
  const MatrixXd T = rows_.edge_rows(Y);
  const ChordGradient::Energy& energy = chord_.energy();
  const Vector6d g = energy.force.head<6>();
  LeafQuadratic<double> q(size(), columns);
  for (int k = 0; k < columns; ++k) {
    const ChordGradient::Column column = chord_.column(T.col(k).tail<12>());
    Vector9d z;
    z << column.e1, T.col(k).head<3>();
    const Vector9d Hz = tangent_ * z;
    q.stiffness[k] = z.dot(Hz) + g.dot(column.e2);
    for (int p = 0; p < 3; ++p)
      q.shape(p, k) = z.dot(shape_tangent_[static_cast<std::size_t>(p)] * z) +
                      energy.shape_force.col(p).head<6>().dot(column.e2);
    Covectors of;
    of.state = third_of(z, z) + tangent_.leftCols<6>() * column.e2;
    of.first = 2 * Hz.head<6>();
    if (internal_ && (mu[k] != 0 || !T.col(k).segment<P>(3).isZero(0)))
      add_internal(column, T.col(k).segment<P>(3), mu[k], q, k, of);
    q.state.col(k).head<3>() = of.state.tail<3>();
    ChordGradient::Seen seen = chord_.seen(column, {of.state.head<6>(), of.first, g}, of.spin);
    seen.tail<3>() += of.apart;
    chord_.add(Y, k, column, seen, of.base, q);
  }
  return q;
}

namespace {

// Derivatives of the fields of a leaf. Its place in the tables of stress, (σ, τ, twist, N, M1, M2),
// and its shape change at the given rates, one column for each parameter.
class TubeFields final : public LeafFields {
 public:
  TubeFields(TubeModel& model, const TubeDynamics::Place& place, MatrixXd rates)
      : model_(&model), place_(place), rates_(std::move(rates)) {}

  // check_interior() says that there are none
  MatrixXd place_rates(double, double) const override {
    assert(false);
    return MatrixXd::Zero(3, rates_.cols());
  }
  MatrixXd section_rates(const std::vector<StressPlace>& places, double modulus,
                         const VectorXd& modulus_rates) const override {
    MatrixXd rates(6 * static_cast<Eigen::Index>(places.size()), modulus_rates.size());
    for (Eigen::Index p = 0; p < rates.cols(); ++p)
      rates.col(p) = flexopt::section_rates(model_->shape(), stations(p), places, modulus,
                                            along(p, modulus_rates));
    return rates;
  }

 private:
  StressRate along(Eigen::Index p, const VectorXd& modulus_rates) const {
    return {{}, ShapeRate(Vector3d(rates_.col(p).tail<3>())), modulus_rates[p]};
  }
  // Stations that move along parameter p. What the tables tell of a station is kept for the other
  // parameters.
  MovingStations stations(Eigen::Index p) const {
    if (!slopes_)
      slopes_ = model_->kept().strain_slopes.at(place_, [this] {
        return TubeStress::Slopes(*model_->stress(), place_, model_->stress_rates());
      });
    const ShapeRate rate(Vector3d(rates_.col(p).tail<3>()));
    return {
        strain_stations(MeshNumbers<Dual1>(model_->shape(), rate).x), model_->stress()->places().y,
        [this, p](int along, int across) {
          auto station = known_.find({along, across});
          if (station == known_.end())
            station = known_.emplace(std::array{along, across}, slopes_->at(along, across)).first;
          return moving(station->second.value, Strains(station->second.slopes * rates_.col(p)));
        }};
  }

  TubeModel* model_;
  TubeDynamics::Place place_;
  MatrixXd rates_;
  mutable std::shared_ptr<const TubeStress::Slopes> slopes_;  ///< made at their first use
  mutable std::map<std::array<int, 2>, TubeStress::Slopes::Station> known_;  ///< slopes made so far
};

}  // namespace

std::unique_ptr<LeafFields> TubeLeafGradient::fields(
    const MatrixXd& rows, const std::vector<LeafVariation<double>>& variations) const {
  const Eigen::Matrix2d to_ray = leaf_->model()->potential().ray().inverse();
  const MatrixXd T = rows_.edge_rows(rows);
  MatrixXd rates(9, rows.cols());
  for (Eigen::Index p = 0; p < rows.cols(); ++p) {
    const LeafVariation<double>& variation = variations[static_cast<std::size_t>(p)];
    std::array<Vector3d, 2> lever;
    const Vector12d moved = T.col(p).tail<12>() + chord_.edge_moves(variation, lever);
    const Vector6d e = leaf_->response().frame.B * moved;
    rates.col(p) << to_ray * Eigen::Vector2d(e[theta1y], e[theta2y]), e[twist], T.col(p).head<3>(),
        variation.shape.head<3>();
  }
  return std::make_unique<TubeFields>(*leaf_->model(), leaf_->place(), std::move(rates));
}

}  // namespace flexopt
