#include "core/response/gradients/elastic_gradients.hpp"

#include "core/elements/solid/held_body.hpp"
#include "core/elements/solid/solid_stress.hpp"

namespace flexopt {
namespace {

// An elastic body at a state, and its rates along directions.
template <class S>
class MovedElastic {
 public:
  MovedElastic(const MechanismFactor& factor, const MechanismState<S>& state, int k)
      : elastic_(&factor.system().elastic_bodies()),
        state_(&state),
        k_(k),
        holders_(holders_of(body(), state.bodies)) {
    evaluate_held(body(), model(), holders_, elastic_->action(), held_);
  }

  const ElasticBody& body() const { return elastic_->body(k_); }
  const ElasticModel& model() const { return elastic_->model(k_); }
  const HeldBodyOf<S>& held() const { return held_; }
  std::shared_ptr<const ElasticModel> model_rate(const Mechanism& direction) const {
    return flexopt::model_rate(body(), direction.elastic_bodies[k_]);
  }
  // The state moves by its rate; where that is empty it stays.
  HeldBodyOf<S> rates(const Mechanism& direction, const ElasticModel& model_rate,
                      const Eigen::Ref<const Eigen::VectorX<S>>& state_rate) const {
    HeldBodyRate<S> rate{&direction.elastic_bodies[k_], &model_rate, {}};
    for (const ElasticInterface& interface : body().interfaces)
      rate.holders.push_back(moving<S>(direction, *state_, interface.body, state_rate));
    return held_rates(body(), model(), holders_, elastic_->action(), held_, rate);
  }

 private:
  const ElasticBodies* elastic_;
  const MechanismState<S>* state_;
  int k_;
  std::vector<JointBodyOf<S>> holders_;
  HeldBodyOf<S> held_;
};

// What the fixed-interface modes of an elastic body add to the derivatives of yᵀ(K − λM)y.
// `z`: motions of its holders, those with the ground too.
template <class S>
void add_mode_rates(const MechanismFactor::ElasticInside& inside,
                    const FixedInterfaceModes& mode_rates, const HeldBodyOf<S>& held,
                    const HeldBodyOf<S>& rate, const Eigen::MatrixX<S>& z,
                    const Eigen::MatrixX<S>& Y, const Eigen::VectorX<S>& lambda,
                    Eigen::Ref<Eigen::VectorX<S>> rates) {
  for (Eigen::Index c = 0; c < Y.cols(); ++c) {
    const Eigen::VectorX<S> q = Y.col(c).segment(inside.offset, inside.count());
    const Eigen::VectorX<S> forces = mode_rates.stiffness.lazyProduct(q);
    rates[c] += q.cwiseProduct(forces).sum();
    if (lambda[c] != S(0))
      rates[c] -= lambda[c] * mode_mass_rate<S>(*inside.modes, mode_rates, held, rate, z.col(c), q);
  }
}

}  // namespace

template <class S>
void add_elastic_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                                const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R) {
  for (int k = 0; k < factor.system().elastic_bodies().count(); ++k) {
    const MovedElastic<S> moved(factor, state, k);
    for (std::size_t p = 0; p < directions.size(); ++p)
      add_holder_forces(
          moved.body(),
          moved.rates(directions[p], *moved.model_rate(directions[p]), Eigen::VectorX<S>()).force,
          R.col(static_cast<Eigen::Index>(p)));
  }
}

template <class S>
void add_elastic_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                                 const std::vector<Mechanism>& directions,
                                 const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                                 const Eigen::VectorX<S>& lambda, const GroundShare* ground,
                                 Eigen::MatrixX<S>& rates) {
  Eigen::MatrixX<S> absolute = Y;
  MatrixXd translations;
  if (ground) {
    absolute += ground->carried.template cast<S>();
    translations = MatrixXd::Zero(6, Y.cols());
    translations.topRows(3) = ground->translations;
  }
  for (int k = 0; k < factor.system().elastic_bodies().count(); ++k) {
    const MovedElastic<S> moved(factor, state, k);
    const Eigen::MatrixX<S> y = holder_rows(moved.body(), Y),
                            z = holder_rows(moved.body(), absolute, translations);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const auto column = static_cast<Eigen::Index>(p);
      const auto model_rate = moved.model_rate(directions[p]);
      const HeldBodyOf<S> rate = moved.rates(directions[p], *model_rate, state_rates.col(column));
      rates.col(column) += y.cwiseProduct(rate.tangent.lazyProduct(y)).colwise().sum().transpose();
      for (Eigen::Index c = 0; c < Y.cols(); ++c)
        if (lambda[c] != S(0))
          rates(c, column) -= lambda[c] * held_mass_rate<S>(moved.model(), *model_rate,
                                                            moved.held(), rate, z.col(c));
      if (!factor.elastic().empty())
        add_mode_rates<S>(
            factor.elastic()[static_cast<std::size_t>(k)],
            *fixed_interface_mode_rates(moved.body(), directions[p].elastic_bodies[k],
                                        ElasticBodies::modes_for(factor.frequencies())),
            moved.held(), rate, z, Y, lambda, rates.col(column));
    }
  }
}

ElasticStressRates elastic_stress_rates(const MechanismFactor& factor, int body,
                                        const std::vector<int>& nodes,
                                        const std::vector<Mechanism>& directions,
                                        const MatrixXd& state_rates) {
  const MechanismState<double> state = present_state(factor);
  const MovedElastic<double> moved(factor, state, body);
  const CondensedSolid& solid = factor.system().elastic_bodies().solid(body);
  const VectorXd &d = moved.held().floating.local, u = solid_displacements(solid, d);
  const auto rows = 6 * static_cast<Eigen::Index>(nodes.size());
  ElasticStressRates answer{VectorXd(rows), MatrixXd(rows, directions.size())};
  for (std::size_t p = 0; p < directions.size(); ++p) {
    const auto column = static_cast<Eigen::Index>(p);
    const ElasticBody& direction = directions[p].elastic_bodies[body];
    const VectorXd d_rate =
        moved.rates(directions[p], *moved.model_rate(directions[p]), state_rates.col(column))
            .floating.local;
    const std::vector<RatedTensor> tensors = node_stresses(
        moved.body(), direction, u,
        solid_displacement_rates(solid, *field_rates(moved.body(), direction), d, d_rate), nodes);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const auto row = 6 * static_cast<Eigen::Index>(k);
      answer.value.segment<6>(row) = tensors[k].value;
      answer.rate.block<6, 1>(row, column) = tensors[k].rate;
    }
  }
  return answer;
}

#define INSTANTIATE(S)                                                                         \
  template void add_elastic_residual_rates(const MechanismFactor&, const MechanismState<S>&,   \
                                           const std::vector<Mechanism>&, Eigen::MatrixX<S>&); \
  template void add_elastic_quadratic_rates(                                                   \
      const MechanismFactor&, const MechanismState<S>&, const std::vector<Mechanism>&,         \
      const Eigen::MatrixX<S>&, const Eigen::MatrixX<S>&, const Eigen::VectorX<S>&,            \
      const GroundShare*, Eigen::MatrixX<S>&);
INSTANTIATE(double)
INSTANTIATE(Jet)
#undef INSTANTIATE

}  // namespace flexopt
