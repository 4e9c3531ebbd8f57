#include "core/elements/solid/floating_body.hpp"

#include <concepts>
#include <type_traits>

namespace flexopt {
namespace {

// A number with its rate. That of a plain number is a jet, whose code is needed all the same.
template <class S>
using Rated = std::conditional_t<std::same_as<S, double>, Jet, Rate<S>>;

Jet with_rate(double x, double dx) { return {x, dx, 0}; }
Rate<Jet> with_rate(const Jet& x, const Jet& dx) { return {x, dx}; }
double rate(const Jet& x) { return x.c[1]; }
Jet rate(const Rate<Jet>& x) { return x.rate; }

// A model whose numbers have rates.
template <class S>
struct RatedModel {
  using T = Rated<S>;

  std::vector<Vector3<T>> origins;
  Eigen::MatrixX<T> stiffness, moments;
  T total_mass;
  Vector3<T> mass_moment;
  const MatrixXd& basis;
  std::vector<T> cubic, quartic;

  RatedModel(const ElasticModel& at, const ElasticModel& rate)
      : stiffness(rated(at.stiffness, rate.stiffness)),
        moments(rated(at.moments, rate.moments)),
        total_mass(with_rate(S(at.total_mass), S(rate.total_mass))),
        mass_moment(rated(at.mass_moment, rate.mass_moment)),
        basis(at.basis) {
    for (std::size_t a = 0; a < at.origins.size(); ++a)
      origins.push_back(rated(at.origins[a], rate.origins[a]));
    for (std::size_t k = 0; !at.quartic.empty() && k < at.cubic.size(); ++k)
      cubic.push_back(with_rate(S(at.cubic[k]), S(rate.cubic[k])));
    for (std::size_t k = 0; k < at.quartic.size(); ++k)
      quartic.push_back(with_rate(S(at.quartic[k]), S(rate.quartic[k])));
  }

  static Eigen::MatrixX<T> rated(const MatrixXd& x, const MatrixXd& dx) {
    return x.binaryExpr(dx, [](double a, double b) { return with_rate(S(a), S(b)); });
  }
};

// Adds the terms of degree 3 and 4: with a = A e and b = B e e, matrices,
//     W += eᵀ (a/6 + b/24) e,   ∂W/∂e = (a/2 + b/6) e,   ∂²W/∂e² = a + b/2.
template <class T, class Model>
void add_higher_degrees(const Model& model, FloatingAnswersOf<T>& to) {
  using Number = typename decltype(model.cubic)::value_type;
  using Numbers = Eigen::Map<const Eigen::MatrixX<Number>>;
  constexpr int most = 12;  // three interfaces
  using Small = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, 0, most, most>;
  using SmallVector = Eigen::Matrix<T, Eigen::Dynamic, 1, 0, most, 1>;
  const Eigen::Index m = model.basis.cols();
  const SmallVector e = model.basis.transpose().lazyProduct(to.local);
  const Small ee = e.lazyProduct(e.transpose());
  Small a(m, m), b(m, m);
  a.reshaped() = Numbers(model.cubic.data(), m, m * m).transpose().lazyProduct(e);
  b.reshaped() = Numbers(model.quartic.data(), m * m, m * m).transpose().lazyProduct(ee.reshaped());
  const SmallVector ae = a.lazyProduct(e), be = b.lazyProduct(e);
  to.energy += e.dot(ae) * (1.0 / 6) + e.dot(be) * (1.0 / 24);
  to.force += model.basis.lazyProduct(SmallVector(0.5 * ae + be * (1.0 / 6)));
  const Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, 0, 6 * 3, most> half =
      model.basis.lazyProduct(Small(a + 0.5 * b));
  to.tangent += half.lazyProduct(model.basis.transpose());
}

// Gravity on the body.
template <class T>
struct Weight {
  Vector3<T> gravity, moment;       ///< frame axes; ∫ρ (X + u)
  Eigen::Matrix<T, 6, 1> on_frame;  ///< derivative of its energy by motions of the frame
};

// Answers by d: of the deformation and of gravity.
template <class T, class Model>
Weight<T> in_the_frame(const Model& model, const BodyActionOf<T>& action,
                       FloatingAnswersOf<T>& to) {
  const Eigen::VectorX<T>& d = to.local;
  to.force.resize(d.size());
  to.force.noalias() = model.stiffness.lazyProduct(d);
  to.energy = 0.5 * d.dot(to.force);
  to.tangent = model.stiffness.template cast<T>();
  if (!model.quartic.empty()) add_higher_degrees(model, to);

  Weight<T> w;
  w.gravity = to.frame.axes.transpose() * action.gravity;
  w.moment = action.growth * model.mass_moment.template cast<T>();
  w.moment += model.moments.lazyProduct(d);
  to.energy -= model.total_mass * action.gravity.dot(to.frame.position) + w.gravity.dot(w.moment);
  to.force -= model.moments.transpose().lazyProduct(w.gravity);
  w.on_frame << -(model.total_mass * w.gravity), w.gravity.cross(w.moment);
  return w;
}

// The weight's part of how a turn of the frame changes the forces.
template <class T, class Model>
void turn_weight(const Model& model, const Weight<T>& weight, FloatingFrame<T>& frame) {
  const Matrix3<T> W = hat(weight.gravity);
  Eigen::Index k = 0;
  for (auto& i : frame.interfaces) {
    Eigen::Matrix<T, 6, 3> turn =
        model.moments.template middleCols<6>(k).transpose().lazyProduct(W);
    i.to_motion(turn);
    i.turning -= turn;
    k += 6;
  }
  frame.curvature -= arm_curvature(weight.gravity, weight.moment);
}

template <class T, class Model>
void answer(const Model& model, std::span<const FramePoseOf<T>> interfaces,
            const BodyActionOf<T>& action, FloatingAnswersOf<T>& to) {
  static thread_local FloatingFrame<T> frame;
  const std::size_t N = interfaces.size();
  frame.interfaces.resize(N);
  for (std::size_t a = 0; a < N; ++a) {
    frame.interfaces[a].origin = action.growth * model.origins[a].template cast<T>();
    frame.interfaces[a].weights = Matrix6d::Identity() / static_cast<double>(N);
  }
  // always from the same interface: a start that does not turn with the body finds other roots
  to.framed = frame.find(interfaces, interfaces[0].axes);
  if (!to.framed) return;
  to.frame = frame.pose;
  frame.local(to.local);
  const Weight<T> weight = in_the_frame(model, action, to);
  frame.balance(to.force, weight.on_frame);
  turn_weight(model, weight, frame);
  frame.bend(to.tangent);
  Eigen::Index k = 0;
  for (const auto& i : frame.interfaces) {
    to.force.template segment<3>(k) = to.frame.axes * i.force;
    to.force.template segment<3>(k + 3) = to.frame.axes * i.moment;
    k += 6;
  }
}

}  // namespace

template <class S>
void evaluate_floating(const ElasticModel& model, std::span<const FramePoseOf<S>> interfaces,
                       const BodyActionOf<S>& action, FloatingAnswersOf<S>& answers) {
  answer(model, interfaces, action, answers);
}

template <class S>
FloatingAnswersOf<S> floating_rates(const ElasticModel& model, const ElasticModel& model_rate,
                                    std::span<const FramePoseOf<S>> interfaces,
                                    std::span<const FramePoseOf<S>> pose_rates,
                                    const BodyActionOf<S>& action) {
  using T = Rated<S>;
  const auto join = [](const S& x, const S& dx) { return with_rate(x, dx); };
  const auto rate_of = [](const T& x) { return rate(x); };
  std::vector<FramePoseOf<T>> moving(interfaces.size());
  for (std::size_t a = 0; a < interfaces.size(); ++a) {
    moving[a].position = interfaces[a].position.binaryExpr(pose_rates[a].position, join);
    moving[a].axes = interfaces[a].axes.binaryExpr(pose_rates[a].axes, join);
  }
  const BodyActionOf<T> constant{
      action.gravity.unaryExpr([](const S& x) { return with_rate(x, S(0.0)); }),
      with_rate(action.growth, S(0.0))};
  FloatingAnswersOf<T> all;
  answer<T>(RatedModel<S>(model, model_rate), moving, constant, all);
  FloatingAnswersOf<S> rates{.framed = all.framed};
  if (!all.framed) return rates;
  rates.frame = {all.frame.position.unaryExpr(rate_of), all.frame.axes.unaryExpr(rate_of)};
  rates.local = all.local.unaryExpr(rate_of);
  rates.energy = rate(all.energy);
  rates.force = all.force.unaryExpr(rate_of);
  rates.tangent = all.tangent.unaryExpr(rate_of);
  return rates;
}

template <class S>
Eigen::MatrixX<S> floating_mass(const ElasticModel& model, const Matrix3<S>& frame_axes) {
  Eigen::MatrixX<S> M(model.mass.rows(), model.mass.cols());
  for (Eigen::Index i = 0; i < M.rows(); i += 3)
    for (Eigen::Index j = 0; j < M.cols(); j += 3) {
      const Matrix3<S> turned = frame_axes * model.mass.block<3, 3>(i, j);
      M.template block<3, 3>(i, j) = turned * frame_axes.transpose();
    }
  return M;
}

template void evaluate_floating(const ElasticModel&, std::span<const FramePose>,
                                const BodyActionOf<double>&, FloatingAnswersOf<double>&);
template void evaluate_floating(const ElasticModel&, std::span<const FramePoseOf<Jet>>,
                                const BodyActionOf<Jet>&, FloatingAnswersOf<Jet>&);
template FloatingAnswersOf<double> floating_rates(const ElasticModel&, const ElasticModel&,
                                                  std::span<const FramePose>,
                                                  std::span<const FramePose>,
                                                  const BodyActionOf<double>&);
template FloatingAnswersOf<Jet> floating_rates(const ElasticModel&, const ElasticModel&,
                                               std::span<const FramePoseOf<Jet>>,
                                               std::span<const FramePoseOf<Jet>>,
                                               const BodyActionOf<Jet>&);
template MatrixXd floating_mass(const ElasticModel&, const Matrix3d&);
template Eigen::MatrixX<Jet> floating_mass(const ElasticModel&, const Matrix3<Jet>&);

}  // namespace flexopt
