#include <map>

#include "core/response/solid_stations.hpp"
#include "core/response/solids.hpp"

namespace flexopt {
namespace {

double half_rate_of(const LeafSpring& leaf, const LeafSpring& direction, double along) {
  return 0.5 * (direction.thickness * profile_at(leaf.thickness_profile, along) +
                leaf.thickness * profile_rate(direction.thickness_profile, along));
}

// Rate of v/|v|.
Vector3d unit_rate(const Vector3d& v, const Vector3d& rate) {
  const Vector3d n = v.normalized();
  return (rate - n * n.dot(rate)) / v.norm();
}

WireAxes wire_section_rate(const Vector3d& t, const Vector3d& reference, const Vector3d& rate) {
  const Vector3d e = t.normalized(), de = unit_rate(t, rate), v = reference - e * e.dot(reference),
                 dv = -de * e.dot(reference) - e * de.dot(reference), n = v.normalized(),
                 dn = unit_rate(v, dv);
  return {dn, de.cross(n) + e.cross(dn)};
}

// What that changes by as the fold moves.
double along_leaf_rate(const SolidPart& part, const LeafSpring& leaf, const LeafSpring& direction,
                       double along) {
  const double fold = leaf.fold && direction.fold ? direction.fold->place : 0;
  return part.begin > 0 ? fold * (1 - along) : part.end < 1 ? fold * along : 0;
}

// Rates of the middle (node 0) of a body's box, or of one of its edges (1 to 3), which turns with
// the body.
MatrixXd box_node_rates(const RigidBody& body, int index, const Matrix3d& rotation, int node,
                        const PlaceRates& rates) {
  const BodyPlaceRate& of = rates.bodies[index];
  MatrixXd result(3, rates.directions->size());
  for (Eigen::Index p = 0; p < result.cols(); ++p) {
    const RigidBody& d = (*rates.directions)[p].bodies[index];
    const Vector3d spin = of.spin.col(p);
    if (node == 0)
      result.col(p) = Vector3d(of.position.col(p)) +
                      spin.cross(rotation * (body.box->center - body.reference)) +
                      rotation * (d.box->center - d.reference);
    else
      result.col(p) = spin.cross(rotation * body.box->half_edges.col(node - 1)) +
                      rotation * d.box->half_edges.col(node - 1);
  }
  return result;
}

}  // namespace

// Folded leaves, whose legs end where a parameter may move the fold, have one thickness.
double Solids::half_thickness_rate(int solid, double along, const Mechanism& direction) const {
  return half_rate_of(leaf_of(solid), direction.leaves[part(solid).leaf],
                      along_leaf(part(solid), along));
}

MatrixXd Solids::node_rates(const Solid& solid, int node, const PlaceRates& rates,
                            std::map<int, MatrixXd>& known) const {
  const std::vector<Mechanism>& directions = *rates.directions;
  const auto count = static_cast<Eigen::Index>(directions.size());
  const SolidPart& part = solid.part;
  if (part.body >= 0)
    return box_node_rates(mechanism_->bodies[part.body], part.body, solid.rotation, node, rates);
  const LeafSpring& leaf = mechanism_->leaves[part.leaf];
  const bool wire = leaf.section == Section::circular;
  const int layer = wire ? stations_along : surface_size, kind = node / layer,
            station = node % layer, i = wire ? station : station / stations_across,
            j = wire ? 0 : station % stations_across;
  const auto mid = [&](int a, int b) -> const MatrixXd& {
    MatrixXd& rate = known[mid_index(a, b)];
    if (rate.size() > 0) return rate;
    VectorXd along_rates(leaf.fold ? count : 0);
    for (Eigen::Index p = 0; p < along_rates.size(); ++p)
      along_rates[p] = along_leaf_rate(part, leaf, directions[p].leaves[part.leaf], along_of(a));
    rate = rates.leaf(part.leaf, along_leaf(part, along_of(a)), wire ? 0.5 : across_of(b),
                      along_rates);
    return rate;
  };
  if (wire && kind == 0) return mid(i, 0);
  const auto mid_place = [&](int a, int b) -> Vector3d {
    if (wire) return solid.nodes[a];
    const auto k = static_cast<std::size_t>(mid_index(a, b));
    return 0.5 * (solid.nodes[k] + solid.nodes[surface_size + k]);
  };
  const MatrixXd none = MatrixXd::Zero(3, count);
  const Vector3d along = station_slope(along_intervals, i, Vector3d(Vector3d::Zero()),
                                       [&](int k) { return mid_place(k, j); });
  const MatrixXd along_rate =
      station_slope(along_intervals, i, none, [&](int k) -> const MatrixXd& { return mid(k, j); });
  const double at = along_leaf(part, along_of(i)), half = half_of(leaf, at);
  const auto half_rate = [&](Eigen::Index p) {
    return half_rate_of(leaf, directions[p].leaves[part.leaf], at);
  };
  MatrixXd result(3, count);
  if (wire) {
    const WireAxes s = wire_section(along, solid.reference);
    for (Eigen::Index p = 0; p < count; ++p) {
      const WireAxes ds = wire_section_rate(along, solid.reference, along_rate.col(p));
      result.col(p) = kind == 1 ? Vector3d(half_rate(p) * s.n + half * ds.n)
                                : Vector3d(half_rate(p) * s.b + half * ds.b);
    }
    return result;
  }
  const Vector3d across = station_slope(across_intervals, j, Vector3d(Vector3d::Zero()),
                                        [&](int k) { return mid_place(i, k); });
  const MatrixXd across_rate =
      station_slope(across_intervals, j, none, [&](int k) -> const MatrixXd& { return mid(i, k); });
  const Vector3d v = along.cross(across), n = v.normalized();
  for (Eigen::Index p = 0; p < count; ++p) {
    const Vector3d da = along_rate.col(p), dc = across_rate.col(p);
    const Vector3d turning =
        half_rate(p) * n + half * unit_rate(v, da.cross(across) + along.cross(dc));
    result.col(p) = Vector3d(mid(i, j).col(p)) + (kind == 0 ? -1 : 1) * turning;
  }
  return result;
}

MatrixXd Solids::sum_of_rates(int solid, const std::vector<std::pair<int, double>>& weights,
                              const PlaceRates& rates) const {
  std::map<int, MatrixXd> known;
  MatrixXd result = MatrixXd::Zero(3, rates.directions->size());
  for (const auto& [node, weight] : weights)
    if (weight != 0) result += weight * node_rates(solids_[solid], node, rates, known);
  return result;
}

MatrixXd Solids::place_rates(const SolidPoint& point, const PlaceRates& rates) const {
  std::vector<std::pair<int, double>> values;
  for (const Weight& w : weights(point)) values.push_back({w.node, w.value});
  return sum_of_rates(point.solid, values, rates);
}

}  // namespace flexopt
