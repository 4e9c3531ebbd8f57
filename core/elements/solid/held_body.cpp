#include "core/elements/solid/held_body.hpp"

#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

/// Sizes of what has this stress-free growth by heat, over nominal ones.
double grown(double growth, const ElasticAction& action) {
  return 1 + action.warmth * (growth - 1);
}

template <class S>
BodyActionOf<S> inside(const ElasticBody& body, const ElasticAction& action) {
  return {action.gravity.template cast<S>(), S(grown(body.growth, action))};
}

/// From a holder's reference point to the grown origin of an interface, undeflected: the holder
/// grows up to the face, the elastic body from there. Rates of the two parts give its rate.
Vector3d grown_arm(const ElasticBody& body, std::size_t a, const ElasticAction& action,
                   const Vector3d& to_face, const Vector3d& to_origin) {
  return grown(body.interfaces[a].clamp_growth, action) * to_face +
         grown(body.growth, action) * to_origin;
}

/// Arm of an interface as above, with the reference point of its holder there [m].
Vector3d grown_arm(const ElasticBody& body, std::size_t a, const ElasticAction& action,
                   const Vector3d& reference) {
  const ElasticInterface& at = body.interfaces[a];
  return grown_arm(body, a, action, body.place + body.axes * at.face - reference,
                   body.axes * (at.origin - at.face));
}

/// A of the interfaces becomes A of their holders: its columns, those of the motions of the places
/// that the arms carry.
template <class S>
void carry_columns(const std::vector<Vector3<S>>& arms, Eigen::MatrixX<S>& A) {
  for (std::size_t a = 0; a < arms.size(); ++a) {
    const auto c = 6 * static_cast<Eigen::Index>(a);
    A.middleCols(c + 3, 3) -= A.middleCols(c, 3).lazyProduct(hat(arms[a]));
  }
}

/// Moments that forces (rows) have on the arms.
template <class S>
Eigen::MatrixX<S> moments_on(const std::vector<Vector3<S>>& arms, const Eigen::MatrixX<S>& A) {
  Eigen::MatrixX<S> moments = Eigen::MatrixX<S>::Zero(A.rows(), A.cols());
  for (std::size_t a = 0; a < arms.size(); ++a) {
    const auto r = 6 * static_cast<Eigen::Index>(a);
    moments.middleRows(r + 3, 3) = hat(arms[a]).lazyProduct(A.middleRows(r, 3));
  }
  return moments;
}

template <class S>
Vector3<S> force_at(const Eigen::VectorX<S>& forces, std::size_t a) {
  return forces.template segment<3>(6 * static_cast<Eigen::Index>(a));
}

}  // namespace

template <class S>
void evaluate_held(const ElasticBody& body, const ElasticModel& model,
                   const std::vector<JointBodyOf<S>>& holders, const ElasticAction& action,
                   HeldBodyOf<S>& held) {
  const std::size_t count = holders.size();
  held.interfaces.resize(count);
  held.arms.resize(count);
  for (std::size_t a = 0; a < count; ++a) {
    const JointBodyOf<S>& at = holders[a];
    held.arms[a] = at.rotation * grown_arm(body, a, action, at.reference);
    held.interfaces[a] = {at.position + held.arms[a], at.rotation * body.axes};
  }
  evaluate_floating<S>(model, held.interfaces, inside<S>(body, action), held.floating);
  if (!held.floating.framed) return;
  held.force = held.floating.force;
  held.force += moments_on<S>(held.arms, held.floating.force);
  held.tangent = held.floating.tangent;
  carry_columns(held.arms, held.tangent);
  held.tangent += moments_on<S>(held.arms, held.tangent);
  for (std::size_t a = 0; a < count; ++a) {
    const auto r = 6 * static_cast<Eigen::Index>(a) + 3;
    held.tangent.template block<3, 3>(r, r) +=
        arm_curvature<S>(force_at(held.floating.force, a), held.arms[a]);
  }
}

template <class S>
HeldBodyOf<S> held_rates(const ElasticBody& body, const ElasticModel& model,
                         const std::vector<JointBodyOf<S>>& holders, const ElasticAction& action,
                         const HeldBodyOf<S>& held, const HeldBodyRate<S>& rate) {
  HeldBodyOf<S> r;
  const ElasticBody& d = *rate.body;
  for (std::size_t a = 0; a < holders.size(); ++a) {
    const JointBodyOf<S>&at = holders[a], &moves = rate.holders[a];
    const ElasticInterface &own = body.interfaces[a], &own_rate = d.interfaces[a];
    const Vector3d arm = grown_arm(body, a, action, at.reference),
                   darm = grown_arm(
                       body, a, action,
                       d.place + d.axes * own.face + body.axes * own_rate.face - moves.reference,
                       d.axes * (own.origin - own.face) +
                           body.axes * (own_rate.origin - own_rate.face));
    r.arms.push_back(moves.rotation * arm + at.rotation * darm);
    r.interfaces.push_back(
        {moves.position + r.arms[a], moves.rotation * body.axes + at.rotation * d.axes});
  }
  r.floating =
      floating_rates<S>(model, *rate.model, held.interfaces, r.interfaces, inside<S>(body, action));
  r.force = r.floating.force;
  r.force +=
      moments_on<S>(held.arms, r.floating.force) + moments_on<S>(r.arms, held.floating.force);
  r.tangent = r.floating.tangent;
  carry_columns(held.arms, r.tangent);
  r.tangent += moments_on<S>(held.arms, r.tangent);
  Eigen::MatrixX<S> carried = held.floating.tangent;
  carry_columns(held.arms, carried);
  const Eigen::MatrixX<S> moved = moments_on<S>(r.arms, carried);
  r.tangent += moved + moved.transpose();
  for (std::size_t a = 0; a < holders.size(); ++a) {
    const auto k = 6 * static_cast<Eigen::Index>(a) + 3;
    r.tangent.template block<3, 3>(k, k) +=
        arm_curvature<S>(force_at(r.floating.force, a), held.arms[a]) +
        arm_curvature<S>(force_at(held.floating.force, a), r.arms[a]);
  }
  return r;
}

template <class S>
Eigen::MatrixX<S> held_mass(const ElasticModel& model, const HeldBodyOf<S>& held) {
  Eigen::MatrixX<S> M = floating_mass<S>(model, held.floating.frame.axes);
  carry_columns(held.arms, M);
  M += moments_on<S>(held.arms, M);
  return M;
}

template <class S>
Eigen::MatrixX<S> motions_in_frame(const HeldBodyOf<S>& held, const Eigen::MatrixX<S>& holders) {
  const Matrix3<S> FT = held.floating.frame.axes.transpose();
  Eigen::MatrixX<S> z(holders.rows(), holders.cols());
  for (std::size_t a = 0; a < held.arms.size(); ++a) {
    const auto r = 6 * static_cast<Eigen::Index>(a);
    const Eigen::MatrixX<S> turned = FT.lazyProduct(hat(held.arms[a]));
    z.middleRows(r, 3) =
        FT.lazyProduct(holders.middleRows(r, 3)) - turned.lazyProduct(holders.middleRows(r + 3, 3));
    z.middleRows(r + 3, 3) = FT.lazyProduct(holders.middleRows(r + 3, 3));
  }
  return z;
}

template <class S>
Eigen::MatrixX<S> held_coupling(const FixedInterfaceModes& modes, const HeldBodyOf<S>& held) {
  Eigen::MatrixX<S> C(modes.coupling.rows(), modes.coupling.cols());
  for (Eigen::Index i = 0; i < C.rows(); i += 3)
    C.middleRows(i, 3) = held.floating.frame.axes.lazyProduct(modes.coupling.middleRows(i, 3));
  C += moments_on<S>(held.arms, C);
  return C;
}

namespace {
// What motions_in_frame() of constant motions of the holders change by.
template <class S>
Eigen::MatrixX<S> frame_motion_rates(const HeldBodyOf<S>& held, const HeldBodyOf<S>& rate,
                                     const Eigen::VectorX<S>& y) {
  HeldBodyOf<S> turned;  // the frame turns, the arms stay
  turned.floating.frame.axes = rate.floating.frame.axes;
  turned.arms = held.arms;
  Eigen::MatrixX<S> dz = motions_in_frame<S>(turned, y);
  const Matrix3<S> FT = held.floating.frame.axes.transpose();
  for (std::size_t a = 0; a < held.arms.size(); ++a) {
    const auto r = 6 * static_cast<Eigen::Index>(a);
    const Vector3<S> w = y.template segment<3>(r + 3);
    dz.middleRows(r, 3) += FT * w.cross(rate.arms[a]);
  }
  return dz;
}
}  // namespace

template <class S>
S held_mass_rate(const ElasticModel& model, const ElasticModel& model_rate,
                 const HeldBodyOf<S>& held, const HeldBodyOf<S>& rate, const Eigen::VectorX<S>& y) {
  const Eigen::MatrixX<S> z = motions_in_frame<S>(held, y), dz = frame_motion_rates(held, rate, y);
  const Eigen::MatrixX<S> forces =
      model_rate.mass.lazyProduct(z) + S(2) * model.mass.lazyProduct(dz);
  return z.cwiseProduct(forces).sum();
}

template <class S>
S mode_mass_rate(const FixedInterfaceModes& modes, const FixedInterfaceModes& mode_rates,
                 const HeldBodyOf<S>& held, const HeldBodyOf<S>& rate, const Eigen::VectorX<S>& y,
                 const Eigen::VectorX<S>& q) {
  const Eigen::MatrixX<S> z = motions_in_frame<S>(held, y), dz = frame_motion_rates(held, rate, y),
                          coupled = dz.cwiseProduct(modes.coupling.lazyProduct(q)) +
                                    z.cwiseProduct(mode_rates.coupling.lazyProduct(q)),
                          own = q.cwiseProduct(mode_rates.mass.lazyProduct(q));
  return S(2) * coupled.sum() + own.sum();
}

#define INSTANTIATE(S)                                                                            \
  template void evaluate_held(const ElasticBody&, const ElasticModel&,                            \
                              const std::vector<JointBodyOf<S>>&, const ElasticAction&,           \
                              HeldBodyOf<S>&);                                                    \
  template HeldBodyOf<S> held_rates(const ElasticBody&, const ElasticModel&,                      \
                                    const std::vector<JointBodyOf<S>>&, const ElasticAction&,     \
                                    const HeldBodyOf<S>&, const HeldBodyRate<S>&);                \
  template Eigen::MatrixX<S> held_mass(const ElasticModel&, const HeldBodyOf<S>&);                \
  template Eigen::MatrixX<S> held_coupling(const FixedInterfaceModes&, const HeldBodyOf<S>&);     \
  template S mode_mass_rate(const FixedInterfaceModes&, const FixedInterfaceModes&,               \
                            const HeldBodyOf<S>&, const HeldBodyOf<S>&, const Eigen::VectorX<S>&, \
                            const Eigen::VectorX<S>&);                                            \
  template Eigen::MatrixX<S> motions_in_frame(const HeldBodyOf<S>&, const Eigen::MatrixX<S>&);    \
  template S held_mass_rate(const ElasticModel&, const ElasticModel&, const HeldBodyOf<S>&,       \
                            const HeldBodyOf<S>&, const Eigen::VectorX<S>&);
INSTANTIATE(double)
INSTANTIATE(Jet)
#undef INSTANTIATE

}  // namespace flexopt
