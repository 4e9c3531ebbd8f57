#include "core/response/room_taken.hpp"

#include <array>
#include <numbers>

#include "core/math/dual.hpp"
#include "core/mechanism/fold_corner.hpp"
#include "core/response/solids.hpp"

namespace flexopt {

namespace {

struct MassStation {
  double along, weight;
};

// Gauss's rule in equal pieces: exact for products of profiles.
std::vector<MassStation> mass_stations(const LeafSpring& leaf) {
  constexpr std::array<double, 3> x{0.2386191860831969, 0.6612093864662645, 0.9324695142031521},
      w{0.4679139345726910, 0.3607615730481386, 0.1713244923791704};
  const bool smooth = leaf.width_profile.size() <= 2 && leaf.thickness_profile.size() <= 2;
  const int pieces = smooth ? 4 : profile_pieces;
  std::vector<MassStation> stations;
  for (int i = 0; i < pieces; ++i)
    for (std::size_t k = 0; k < x.size(); ++k)
      for (const double side : {-1.0, 1.0})
        stations.push_back({(i + 0.5 * (1 + side * x[k])) / pieces, 0.5 * w[k] / pieces});
  return stations;
}

// Mass of a leaf; its rates along the directions are added to `sum`.
double mass_of_leaf(const Mechanism& mechanism, std::size_t i,
                    const std::vector<Mechanism>& directions, VectorXd* sum) {
  const LeafSpring& leaf = mechanism.leaves[i];
  const bool wire = leaf.section == Section::circular;
  const double shape = wire ? std::numbers::pi / 4 : 1.0;
  const std::vector<double>& across = wire ? leaf.thickness_profile : leaf.width_profile;
  const double reference = wire ? leaf.thickness : leaf.width;
  double mass = 0;
  VectorXd own = VectorXd::Zero(directions.size());
  VectorXd& rates = leaf.fold || !sum ? own : *sum;
  for (const MassStation& at : mass_stations(leaf)) {
    const double length = leaf.length, pw = profile_at(across, at.along),
                 pt = profile_at(leaf.thickness_profile, at.along), width = reference * pw,
                 thickness = leaf.thickness * pt, share = shape * at.weight * leaf.material.density;
    mass += share * width * thickness * length;
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const LeafSpring& d = directions[p].leaves[i];
      const double dw = (wire ? d.thickness : d.width) * pw +
                        reference *
                            profile_rate(wire ? d.thickness_profile : d.width_profile, at.along),
                   dt = d.thickness * pt +
                        leaf.thickness * profile_rate(d.thickness_profile, at.along),
                   dl = d.length;
      rates[static_cast<Eigen::Index>(p)] +=
          share * (dw * thickness * length + width * dt * length + width * thickness * dl) +
          shape * at.weight * d.material.density * width * thickness * length;
    }
  }
  if (leaf.fold) {  // without what a bent corner cuts off
    const LeafFold& fold = *leaf.fold;
    const auto left = [&](const LeafSpring& d) {
      const LeafFold moved = d.fold.value_or(LeafFold{});
      const Dual1 thickness = Dual1(leaf.thickness, {d.thickness}) / Dual1(leaf.length, {d.length});
      return Dual1(1.0 - 2.0 * corner_cut<Dual1>({fold.angle, {moved.angle}},
                                                 {fold.radius, {moved.radius}}, thickness));
    };
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const Dual1 of = left(directions[p].leaves[i]);
      double& rate = rates[static_cast<Eigen::Index>(p)];
      rate = of.value * rate + of.derivatives[0] * mass;
    }
    mass *= 1 - 2 * corner_cut(fold.angle, fold.radius, leaf.thickness / leaf.length);
    if (sum) *sum += own;
  }
  return mass;
}

}  // namespace

double leaf_mass(const Mechanism& mechanism) {
  double mass = 0;
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i)
    mass += mass_of_leaf(mechanism, i, {}, nullptr);
  return mass;
}

VectorXd leaf_mass_rate(const Mechanism& mechanism, const std::vector<Mechanism>& directions) {
  VectorXd sum = VectorXd::Zero(directions.size());
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i)
    mass_of_leaf(mechanism, i, directions, &sum);
  return sum;
}

}  // namespace flexopt
