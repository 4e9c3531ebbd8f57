#include "core/response/solids.hpp"

#include "core/mechanism/arc.hpp"

namespace flexopt {

namespace {
/// Place of the middle line in leaf axes over the length, and its rate with the angle of the arc.
struct MiddlePlace {
  Vector3d place, rate, slope;
};
MiddlePlace middle_place(const LeafSpring& leaf, const LeafSpring& direction, double along) {
  if (leaf.fold && along > leaf.fold->place) {
    const LeafFold rate = direction.fold.value_or(LeafFold{});
    const ArcPoint<Dual1> leg = leg_point<Dual1>({leaf.fold->place, {rate.place}},
                                                 {leaf.fold->angle, {rate.angle}}, Dual1(along));
    return {{leg.x.value, 0, leg.z.value},
            {leg.x.derivatives[0], 0, leg.z.derivatives[0]},
            {leg.cosine.value, 0, leg.sine.value}};
  }
  if (!leaf.curve) return {along * Vector3d::UnitX(), Vector3d::Zero(), Vector3d::UnitX()};
  const ArcPoint<Dual1> arc =
      arc_point(Dual1(*leaf.curve, {direction.curve.value_or(0)}), Dual1(along));
  return {{arc.x.value, 0, arc.z.value},
          {arc.x.derivatives[0], 0, arc.z.derivatives[0]},
          {arc.cosine.value, 0, arc.sine.value}};
}
}  // namespace

Vector3d undeflected_place(const LeafSpring& leaf, double along, double across) {
  return leaf.origin + leaf.axes * (middle_place(leaf, leaf, along).place * leaf.length) +
         leaf.axes.col(1) * ((across - 0.5) * leaf.width * profile_at(leaf.width_profile, along));
}

Vector3d undeflected_place_rate(const LeafSpring& leaf, const LeafSpring& direction, double along,
                                double across, double along_rate) {
  const double width = leaf.width * profile_at(leaf.width_profile, along),
               width_rate = direction.width * profile_at(leaf.width_profile, along) +
                            leaf.width * profile_rate(direction.width_profile, along);
  const auto [place, held, slope] = middle_place(leaf, direction, along);
  const Vector3d rate = held + along_rate * slope;
  return direction.origin + direction.axes * (place * leaf.length) +
         leaf.axes * (place * direction.length + rate * leaf.length) +
         direction.axes.col(1) * ((across - 0.5) * width) +
         leaf.axes.col(1) * ((across - 0.5) * width_rate);
}

PlaceRates undeflected_rates(const Mechanism& mechanism, const std::vector<Mechanism>& directions) {
  PlaceRates rates;
  rates.directions = &directions;
  const auto count = static_cast<Eigen::Index>(directions.size());
  rates.leaf = [&mechanism, &directions, count](int leaf, double along, double across,
                                                const VectorXd& along_rates) {
    MatrixXd result(3, count);
    const auto i = static_cast<std::size_t>(leaf);
    for (Eigen::Index p = 0; p < count; ++p)
      result.col(p) = undeflected_place_rate(mechanism.leaves[i], directions[p].leaves[i], along,
                                             across, along_rates.size() > 0 ? along_rates[p] : 0);
    return result;
  };
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    BodyPlaceRate rate{MatrixXd(3, count), MatrixXd::Zero(3, count)};
    for (Eigen::Index p = 0; p < count; ++p)
      rate.position.col(p) = directions[p].bodies[b].reference;
    rates.bodies.push_back(std::move(rate));
  }
  return rates;
}

}  // namespace flexopt
