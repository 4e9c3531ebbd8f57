#include "core/response/gradients/design_rates.hpp"

#include <fmt/format.h>

#include <array>
#include <concepts>
#include <utility>

#include "core/math/rotation.hpp"
#include "core/response/gradients/elastic_gradients.hpp"
#include "core/response/gradients/link_gradients.hpp"
#include "core/response/modes/mechanism_factor.hpp"

namespace flexopt {
namespace {

double relative(double value, double derivative) { return derivative / value; }

template <class S>
Eigen::MatrixX<S> rows_of(const MechanismFactor& factor, const MechanismFactor::Leaf& leaf,
                          const Eigen::MatrixX<S>& Y) {
  return by_orders(Y, [&](const MatrixXd& y) { return factor.leaf_rows(leaf, y); });
}

// Forces of all leaves on the rows of the mechanism, order by order.
template <class S>
class ForceSum {
 public:
  ForceSum(const MechanismFactor& factor, Eigen::Index columns) : factor_(&factor) {
    for (MatrixXd& order : orders_) order = MatrixXd::Zero(factor.size(), columns);
  }
  /// Adds factor · rows of a leaf.
  void add(const MechanismFactor::Leaf& leaf, double scale, const Eigen::MatrixX<S>& rows) {
    if constexpr (std::same_as<S, double>) {
      factor_->add_leaf_force(leaf, scale, rows, orders_[0]);
    } else {
      for (int o = 0; o < 3; ++o)
        factor_->add_leaf_force(leaf, scale, MatrixXd(coefficients(rows, o)), orders_[o]);
    }
  }
  Eigen::MatrixX<S> sum() const {
    if constexpr (std::same_as<S, double>)
      return orders_[0];
    else
      return jets(Series<MatrixXd>{orders_[0], orders_[1], orders_[2]});
  }

 private:
  const MechanismFactor* factor_;
  std::array<MatrixXd, std::same_as<S, double> ? 1 : 3> orders_;
};

}  // namespace

template <class S>
DesignRates<S>::DesignRates(const MechanismFactor& factor, LeafGradients<S> leaves,
                            MechanismState<S> state, const std::vector<Mechanism>& directions,
                            const ModelOptions& model)
    : factor_(&factor),
      directions_(&directions),
      state_(std::move(state)),
      leaves_(std::move(leaves)) {
  const ProfileDirections profiles(factor.system().mechanism(), directions);
  for (std::size_t i = 0; i < factor.leaves().size(); ++i) {
    variations_.emplace_back();
    for (const Mechanism& direction : directions)
      variations_.back().push_back(variation(static_cast<int>(i), direction, profiles, model));
  }
}

namespace {

// Middle and axes of an edge in the leaf as designed, over its length, and how arc and fold change
// them.
struct DesignedEdge {
  Vector3d middle, middle_rate = Vector3d::Zero();
  Matrix3d axes = Matrix3d::Identity(), axes_rate = Matrix3d::Zero();
};
DesignedEdge designed_edge(const LeafSpring& leaf, const LeafSpring& d, int e) {
  DesignedEdge edge{Vector3d(e * leaf.chord() / leaf.length, 0, 0)};
  const auto turn = [&](const ArcPoint<Dual1>& at) {
    const Matrix3<Dual1> axes = at.axes();
    edge.axes = axes.unaryExpr([](const Dual1& x) { return x.value; });
    edge.axes_rate = axes.unaryExpr([](const Dual1& x) { return x.derivatives[0]; });
    edge.middle_rate[0] = at.x.derivatives[0] / leaf.growth;
  };
  if (leaf.fold && e == 1) {
    const ArcPoint<Dual1> at = leg_point<Dual1>({leaf.fold->place, {d.fold->place}},
                                                {leaf.fold->angle, {d.fold->angle}}, Dual1(1));
    turn(at);
    edge.middle = {at.x.value, 0, at.z.value};
    edge.middle_rate[2] = at.z.derivatives[0] / leaf.growth;
  }
  if (leaf.curve) turn(arc_point<Dual1>({*leaf.curve, {*d.curve}}, Dual1(static_cast<double>(e))));
  return edge;
}

// Variation of the sizes and of the material of a leaf.
template <class S>
LeafVariation<S> size_variation(const LeafSpring& leaf, const LeafSpring& d,
                                const VectorXd& profile, bool is_plate) {
  const double L = leaf.length, nu = leaf.material.poissons_ratio;
  LeafVariation<S> v;
  v.length = relative(L, d.length);
  const double t = relative(leaf.thickness, d.thickness);
  v.energy = relative(leaf.material.youngs_modulus, d.material.youngs_modulus) + 3 * t;
  if (is_plate) v.energy += 2 * nu * d.material.poissons_ratio / (1 - nu * nu);
  v.mass = (leaf.material.density > 0 ? relative(leaf.material.density, d.material.density) : 0) +
           t + 4 * v.length;
  v.shape.resize(ShapeParameter::sizes + profile.size());
  v.shape << (d.width - leaf.width * v.length) / L, (d.thickness - leaf.thickness * v.length) / L,
      d.material.poissons_ratio, profile;
  v.turn = d.axes.transpose() * leaf.axes;
  if (leaf.point && !leaf.point->spread_over_tip) v.point = {d.point->along, d.point->across};
  return v;
}

}  // namespace

// Variation of a leaf along one parameter, seen from the leaf's own axes and scales.
template <class S>
LeafVariation<S> DesignRates<S>::variation(int i, const Mechanism& direction,
                                           const ProfileDirections& profiles,
                                           const ModelOptions& model) const {
  const Mechanism& mechanism = factor_->system().mechanism();
  const LeafSpring &leaf = mechanism.leaves[i], &d = direction.leaves[i];
  const double L = leaf.length;
  LeafVariation<S> v = size_variation<S>(leaf, d, profiles.coordinates(leaf, d),
                                         flexure_of(leaf, model) == Flexure::plate);
  const std::array<int, 2> body{leaf.base, leaf.tip};
  const double held_length = leaf.growth * L;  // what places are divided by
  const Matrix3d to_leaf = leaf.axes.transpose(), turning = d.axes.transpose();
  for (int e = 0; e < 2; ++e) {
    const int b = body[e];
    const System::EdgeFit& fit = factor_->system().edge_fit(i, e);
    auto [end, dplace, own, down] = designed_edge(leaf, d, e);
    const Vector3d dend = leaf.growth * dplace;
    // Rotation of the edge as it sits in its body, and its change along assembly errors (S32).
    if (!fit.turn.isIdentity(0) || !d.assembly_turn[e].isZero(0)) {
      const Vector3d spin = rotation_left_tangent(rotation_log(fit.turn)) * d.assembly_turn[e];
      const Matrix3d turned = to_leaf * fit.turn * leaf.axes;
      down = (turned * down + (turning * fit.turn * leaf.axes + to_leaf * fit.turn * d.axes +
                               to_leaf * hat(spin) * fit.turn * leaf.axes) *
                                  own)
                 .eval();
      own = (turned * own).eval();
    }
    const Matrix3d along = (turning - v.length * to_leaf) / held_length;
    dplace += along * fit.move + to_leaf * (d.assembly_move[e] / held_length);
    if (leaf.clamp_growth[e] != 1) {  // growth_move
      Vector3d moves = d.origin + d.axes * (L * end) + leaf.axes * (d.length * end + L * dend);
      if (b >= 0) moves -= direction.bodies[b].reference;
      const System& system = factor_->system();
      const double share = system.load_factors().of_step(system.loads().temperature_step);
      dplace += to_leaf * (share * (leaf.clamp_growth[e] - 1) / held_length * moves);
    }
    if (b < 0) {
      v.edge[e].rotation = down.template cast<S>();
      v.edge[e].position = dplace.template cast<S>();
      continue;
    }
    const JointBodyOf<S>& at = state_.bodies[b];
    const RigidBody &of = mechanism.bodies[b], &db = direction.bodies[b];
    const Vector3d moves = to_leaf * (db.reference - d.origin),
                   undeflected = of.reference - leaf.origin;
    const Vector3<S> place = at.position - leaf.origin.template cast<S>();
    v.edge[e].position = along * place + (moves / held_length).template cast<S>();
    const Vector3d arm = dplace - (along * undeflected + moves / held_length),
                   reach = (L * end + to_leaf * Vector3d(fit.move - undeflected)) / held_length;
    v.edge[e].arm = own.transpose() * arm + down.transpose() * reach;
    // at.rotation is R: of (Aᵀ R A) own, where own holds Aᵀ Θ A of the fit's turn Θ
    if (!d.axes.isZero(0))
      v.edge[e].rotation =
          (turning * at.rotation * leaf.axes + to_leaf * at.rotation * d.axes) * own;
    if (!down.isZero(0)) v.edge[e].rotation += to_leaf * at.rotation * leaf.axes * down;
  }
  return v;
}

template <class S>
auto DesignRates<S>::residual() const -> Matrix {
  const MechanismFactor& factor = *factor_;
  const int count = static_cast<int>(directions_->size());
  ForceSum<S> forces(factor, count);
  for (std::size_t i = 0; i < leaves_.size(); ++i) {
    const MechanismFactor::Leaf& leaf = factor.leaves()[i];
    forces.add(leaf, leaf.linear->scale().energy, leaves_[i]->force_rates(variations_[i]));
  }
  Matrix R = forces.sum();
  for (std::size_t i = 0; i < leaves_.size(); ++i) {
    const MechanismFactor::Leaf& leaf = factor.leaves()[i];
    const LeafScale& scale = leaf.linear->scale();
    const Vector& f = leaves_[i]->force();
    for (int k = 0; k < count; ++k) {
      const LeafVariation<S>& v = variations_[i][k];
      R.col(k).segment(leaf.offset, leaf.rows.internal()) +=
          (scale.energy * v.energy) * f.head(leaf.rows.internal());
      const Matrix3d& turned = (*directions_)[k].leaves[i].axes;
      for (const MechanismFactor::Leaf::Side& side : leaf.sides) {
        const int r = leaf.row(side), b = 6 * side.body;
        const Vector3<S> force = f.template segment<3>(r);
        const Matrix3d by_force =
            scale.energy / scale.length * (turned + (v.energy - v.length) * scale.axes);
        R.col(k).template segment<3>(b) += by_force * force;
        if (side.size == 3) continue;
        const Vector3<S> moment = f.template segment<3>(r + 3);
        const Matrix3d by_moment = scale.energy * (turned + v.energy * scale.axes);
        R.col(k).template segment<3>(b + 3) += by_moment * moment;
      }
    }
  }
  add_link_residual_rates(factor, state_, *directions_, R);
  for (const int k : factor.system().held()) R.row(k).setZero();
  return R;
}

// Derivative of yᵀM y of the rigid bodies along a direction of the design, at constant state and
// with the change of the state.
template <class S>
S DesignRates<S>::body_mass_rate(const Mechanism& direction, const Vector& y,
                                 const Vector& state_rate) const {
  const Mechanism& mechanism = factor_->system().mechanism();
  S sum = 0;
  for (std::size_t k = 0; k < state_.bodies.size(); ++k) {
    const RigidBody &body = mechanism.bodies[k], &d = direction.bodies[k];
    const auto b = 6 * static_cast<Eigen::Index>(k);
    const Matrix3<S>& R = state_.bodies[k].rotation;
    const Vector3<S> u = y.template segment<3>(b), w = y.template segment<3>(b + 3),
                     turn = state_rate.template segment<3>(b + 3);
    const Vector3<S> c = R * Vector3d(body.center_of_mass - body.reference),
                     dc = R * Vector3d(d.center_of_mass - d.reference) + turn.cross(c);
    const Vector3<S> p = u + w.cross(c);
    const Matrix3<S> J = R * body.inertia * R.transpose(), dJ = R * d.inertia * R.transpose();
    sum += d.mass * p.dot(p) + 2.0 * body.mass * p.dot(w.cross(dc)) + w.dot(dJ * w) +
           2.0 * w.dot(turn.cross(J * w));
  }
  return sum;
}

template <class S>
auto DesignRates<S>::quadratic(const Matrix& Y, const Vector& lambda, const Matrix& state_rates,
                               const GroundShare* ground) const -> Matrix {
  const MechanismFactor& factor = *factor_;
  const auto count = static_cast<Eigen::Index>(directions_->size()), n = Y.cols();
  Matrix rates = Matrix::Zero(n, count);
  if (n == 0) return rates;
  ForceSum<S> forces(factor, n);
  Matrix absolute = Y;
  if (ground) absolute += ground->carried.template cast<S>();
  for (std::size_t i = 0; i < leaves_.size(); ++i) {
    const MechanismFactor::Leaf& leaf = factor.leaves()[i];
    const LeafScale& scale = leaf.linear->scale();
    Matrix rows = rows_of<S>(factor, leaf, absolute);
    if (ground)
      rows += grounded_rows(factor, static_cast<int>(i), ground->translations).template cast<S>();
    const LeafQuadratic<S> q = leaves_[i]->quadratic(rows, lambda * (scale.mass / scale.energy));
    forces.add(leaf, scale.energy, q.state);
    rates += scale.energy * leaves_[i]->rates(q, rows, variations_[i]);
    for (Eigen::Index p = 0; p < count; ++p) {
      const LeafVariation<S>& v = variations_[i][p];
      if (v.energy != 0) rates.col(p) += (scale.energy * v.energy) * q.stiffness;
      if (v.mass != 0) rates.col(p) -= (scale.mass * v.mass) * lambda.cwiseProduct(q.mass);
    }
  }
  rates.noalias() += forces.sum().transpose() * state_rates;
  add_link_quadratic_rates(factor, state_, *directions_, state_rates, Y, rates);
  add_elastic_quadratic_rates(factor, state_, *directions_, state_rates, Y, lambda, ground, rates);
  for (Eigen::Index k = 0; k < n; ++k)
    if (lambda[k] != S(0))
      for (Eigen::Index p = 0; p < count; ++p)
        rates(k, p) -=
            lambda[k] * body_mass_rate((*directions_)[p], absolute.col(k).head(factor.bodies()),
                                       state_rates.col(p).head(factor.bodies()));
  return rates;
}

template class DesignRates<double>;
template class DesignRates<Jet>;

Answer<DesignRates<double>> design_rates(const MechanismFactor& factor,
                                         DesignDirections& directions, const ModelOptions& model) {
  LeafGradients<double> gradients;
  for (const MechanismFactor::Leaf& leaf : factor.leaves()) {
    auto own = leaf.linear->gradient(directions.rates, leaf.rows);
    if (!own) return Because(fmt::format("leaf {}: {}", gradients.size(), own.error()));
    gradients.push_back(std::move(*own));
  }
  return DesignRates<double>(factor, std::move(gradients), present_state(factor), directions.list,
                             model);
}

}  // namespace flexopt
