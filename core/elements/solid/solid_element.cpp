#include "core/elements/solid/solid_element.hpp"

#include <array>
#include <cmath>

#include "core/math/dual.hpp"

namespace flexopt {
namespace {

using Slope = Dual<3>;  // derivatives along the reference coordinates

// Corners, then middles of the edges 1-2, 2-3, 3-4, 4-1 below, the same above, and upright.
constexpr int hexahedron_nodes[20][3] = {
    {-1, -1, -1}, {1, -1, -1}, {1, 1, -1},  {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1},
    {-1, 1, 1},   {0, -1, -1}, {1, 0, -1},  {0, 1, -1},  {-1, 0, -1}, {0, -1, 1}, {1, 0, 1},
    {0, 1, 1},    {-1, 0, 1},  {-1, -1, 0}, {1, -1, 0},  {1, 1, 0},   {-1, 1, 0}};
constexpr int tetrahedron_edges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};

using Shapes = std::array<Slope, 20>;

void hexahedron_shapes(const std::array<Slope, 3>& x, Shapes& N) {
  for (std::size_t a = 0; a < 20; ++a) {
    Slope product(1), sum(-2);
    for (std::size_t k = 0; k < 3; ++k) {
      const int c = hexahedron_nodes[a][k];
      product *= c == 0 ? 1 - x[k] * x[k] : 1 + c * x[k];
      sum += c * x[k];
    }
    N[a] = a < 8 ? product * sum / 8 : product / 4;
  }
}

void wedge_shapes(const std::array<Slope, 3>& x, Shapes& N) {
  const std::array<Slope, 3> L{1 - x[0] - x[1], x[0], x[1]};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t top = 0; top < 2; ++top) {
      const Slope z = top ? x[2] : -x[2];
      N[3 * top + a] = L[a] * (1 + z) * (2 * L[a] - 2 + z) / 2;
      N[6 + 3 * top + a] = 2 * L[a] * L[(a + 1) % 3] * (1 + z);
      N[12 + a] = L[a] * (1 - z * z);
    }
}

void tetrahedron_shapes(const std::array<Slope, 3>& x, Shapes& N) {
  const std::array<Slope, 4> L{1 - x[0] - x[1] - x[2], x[0], x[1], x[2]};
  for (std::size_t a = 0; a < 4; ++a) N[a] = L[a] * (2 * L[a] - 1);
  for (std::size_t e = 0; e < 6; ++e)
    N[4 + e] = 4 * L[static_cast<std::size_t>(tetrahedron_edges[e][0])] *
               L[static_cast<std::size_t>(tetrahedron_edges[e][1])];
}

struct WeightedPlace {
  Vector3d place;
  double weight;
};
using Rule = std::vector<WeightedPlace>;

struct GaussPoint {
  double at, weight;
};
const std::array<GaussPoint, 2> two_points{{{-1 / std::sqrt(3.0), 1}, {1 / std::sqrt(3.0), 1}}};
const std::array<GaussPoint, 3> three_points{
    {{-std::sqrt(0.6), 5.0 / 9}, {0, 8.0 / 9}, {std::sqrt(0.6), 5.0 / 9}}};

Rule hexahedron_rule() {
  Rule rule;
  for (const GaussPoint& z : two_points)
    for (const GaussPoint& y : two_points)
      for (const GaussPoint& x : two_points) rule.push_back({{x.at, y.at, z.at}, 1});
  return rule;
}

// Three points of a triangle of degree 2; six of degree 4 [Strang and Fix 1973].
Rule wedge_rule(SolidRule use) {
  Rule rule;
  const auto add = [&](double far, double weight) {
    for (const GaussPoint& z : three_points)
      for (int corner = 0; corner < 3; ++corner) {
        const double near = (1 - far) / 2;
        rule.push_back(
            {{corner == 1 ? far : near, corner == 2 ? far : near, z.at}, weight * z.weight});
      }
  };
  if (use == SolidRule::energy) {
    add(2.0 / 3, 1.0 / 6);
  } else {
    add(0.816847572980458513, 0.109951743655321868 / 2);
    add(0.108103018168070228, 0.223381589678011466 / 2);
  }
  return rule;
}

// Four points of degree 2; three in each direction of a collapsed hexahedron, of degree 4 at least.
Rule tetrahedron_rule(SolidRule use) {
  Rule rule;
  if (use == SolidRule::energy) {
    const double near = (5 - std::sqrt(5.0)) / 20, far = 1 - 3 * near;
    for (int k = -1; k < 3; ++k) {
      rule.push_back({Vector3d::Constant(near), 1.0 / 24});
      if (k >= 0) rule.back().place[k] = far;
    }
    return rule;
  }
  for (const GaussPoint& x : three_points)
    for (const GaussPoint& y : three_points)
      for (const GaussPoint& z : three_points) {
        const double u = (1 + x.at) / 2, v = (1 + y.at) / 2, w = (1 + z.at) / 2;
        rule.push_back({{u, v * (1 - u), w * (1 - u) * (1 - v)},
                        x.weight * y.weight * z.weight / 8 * (1 - u) * (1 - u) * (1 - v)});
      }
  return rule;
}

std::vector<ReferencePoint> points_of(SolidCell cell, const Rule& rule) {
  std::vector<ReferencePoint> points;
  for (const WeightedPlace& p : rule) {
    points.push_back(reference_point(cell, p.place));
    points.back().weight = p.weight;
  }
  return points;
}

}  // namespace

ReferencePoint reference_point(SolidCell cell, const Vector3d& place) {
  std::array<Slope, 3> x;
  for (int k = 0; k < 3; ++k) x[static_cast<std::size_t>(k)] = Slope::variable(place[k], k);
  Shapes N;
  switch (cell) {
    case SolidCell::hexahedron:
      hexahedron_shapes(x, N);
      break;
    case SolidCell::wedge:
      wedge_shapes(x, N);
      break;
    case SolidCell::tetrahedron:
      tetrahedron_shapes(x, N);
      break;
  }
  ReferencePoint point;
  const int n = nodes_of(cell);
  point.shape.resize(n);
  point.slopes.resize(3, n);
  for (int a = 0; a < n; ++a) {
    const Slope& of_node = N[static_cast<std::size_t>(a)];
    point.shape[a] = of_node.value;
    point.slopes.col(a) = Vector3d::Map(of_node.derivatives.data());
  }
  return point;
}

Vector3d reference_node(SolidCell cell, int node) {
  if (cell == SolidCell::hexahedron)
    return Eigen::Map<const Eigen::Vector3i>(hexahedron_nodes[node]).cast<double>();
  const auto corner = [&](int c) -> Vector3d {
    const int k = cell == SolidCell::wedge ? c % 3 : c;
    Vector3d at = Vector3d::Zero();
    if (k > 0) at[k - 1] = 1;
    if (cell == SolidCell::wedge) at.z() = c < 3 ? -1 : 1;
    return at;
  };
  const int corners = cell == SolidCell::wedge ? 6 : 4;
  if (node < corners) return corner(node);
  const int edge = node - corners, floor = edge / 3 * 3;
  if (cell == SolidCell::tetrahedron)
    return (corner(tetrahedron_edges[edge][0]) + corner(tetrahedron_edges[edge][1])) / 2;
  if (edge >= 6) return (corner(edge - 6) + corner(edge - 3)) / 2;
  return (corner(edge) + corner(floor + (edge + 1) % 3)) / 2;
}

const std::vector<ReferencePoint>& reference_points(SolidCell cell, SolidRule rule) {
  using Kept = std::array<std::vector<ReferencePoint>, 2>;
  const auto both = [](SolidCell of, auto make) {
    return Kept{points_of(of, make(SolidRule::energy)), points_of(of, make(SolidRule::mass))};
  };
  static const std::array<Kept, 3> kept{
      both(SolidCell::hexahedron, [](SolidRule) { return hexahedron_rule(); }),
      both(SolidCell::wedge, wedge_rule), both(SolidCell::tetrahedron, tetrahedron_rule)};
  return kept[static_cast<std::size_t>(cell)][static_cast<std::size_t>(rule)];
}

SolidPoint solid_point(const ReferencePoint& at, const CellPlaces& nodes) {
  const Matrix3d J = nodes.lazyProduct(at.slopes.transpose());  // ∂X/∂ξ
  return {at.weight * J.determinant(), J.inverse().transpose().lazyProduct(at.slopes)};
}

SolidPoint point_rate(const SolidPoint& at, const CellPlaces& motion) {
  const Matrix3d L = motion.lazyProduct(at.gradients.transpose());
  return {at.weight * L.trace(), -L.transpose().lazyProduct(at.gradients)};
}

ElasticLaw::ElasticLaw(const Material& material)
    : ElasticLaw(material, Material{.youngs_modulus = material.youngs_modulus}) {}

ElasticLaw::ElasticLaw(const Material& material, const Material& direction) {
  const double E = material.youngs_modulus, nu = material.poissons_ratio,
               dE = direction.youngs_modulus, dnu = direction.poissons_ratio;
  const double below = (1 + nu) * (1 - 2 * nu);
  lambda = dE * nu / below + E * (1 + 2 * nu * nu) / (below * below) * dnu;
  mu = dE / (2 * (1 + nu)) - E / (2 * (1 + nu) * (1 + nu)) * dnu;
}

void cell_stiffness(SolidCell cell, const CellPlaces& nodes, const ElasticLaw& law, MatrixXd& K) {
  const Eigen::Index n = nodes.cols();
  K.setZero(3 * n, 3 * n);
  for (const ReferencePoint& at : reference_points(cell, SolidRule::energy)) {
    const SolidPoint point = solid_point(at, nodes);
    const CellPlaces& g = point.gradients;
    const double lambda = point.weight * law.lambda, mu = point.weight * law.mu;
    for (Eigen::Index b = 0; b < n; ++b)
      for (Eigen::Index a = b; a < n; ++a) {
        Matrix3d block = lambda * g.col(a) * g.col(b).transpose();
        block.noalias() += mu * g.col(b) * g.col(a).transpose();
        block.diagonal().array() += mu * g.col(a).dot(g.col(b));
        K.block<3, 3>(3 * a, 3 * b) += block;
      }
  }
  K.triangularView<Eigen::StrictlyUpper>() = K.transpose();
}

void cell_mass(SolidCell cell, const CellPlaces& nodes, double density, MatrixXd& M) {
  const CellPlaces still = CellPlaces::Zero(3, nodes.cols());
  cell_mass_rate(cell, nodes, 0, still, density, M);
}

void cell_mass_rate(SolidCell cell, const CellPlaces& nodes, double density,
                    const CellPlaces& motion, double density_rate, MatrixXd& M) {
  M.setZero(nodes.cols(), nodes.cols());
  for (const ReferencePoint& at : reference_points(cell, SolidRule::mass)) {
    const SolidPoint point = solid_point(at, nodes);
    const double weight = density_rate * point.weight + density * point_rate(point, motion).weight;
    for (Eigen::Index b = 0; b < nodes.cols(); ++b) M.col(b) += weight * at.shape[b] * at.shape;
  }
}

CellPlaces places_of(const std::vector<Vector3d>& places, std::span<const int> nodes) {
  CellPlaces of_cell(3, static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t a = 0; a < nodes.size(); ++a)
    of_cell.col(static_cast<Eigen::Index>(a)) = places[static_cast<std::size_t>(nodes[a])];
  return of_cell;
}

void gather_fields(const Eigen::Ref<const MatrixXd>& fields, std::span<const int> nodes,
                   MatrixXd& of_cell) {
  of_cell.resize(3 * fields.cols(), static_cast<Eigen::Index>(nodes.size()));
  for (Eigen::Index q = 0; q < fields.cols(); ++q)
    for (std::size_t a = 0; a < nodes.size(); ++a)
      of_cell.col(static_cast<Eigen::Index>(a)).segment<3>(3 * q) =
          fields.col(q).segment<3>(3 * nodes[a]);
}

void scatter_fields(const MatrixXd& of_cell, std::span<const int> nodes, MatrixXd& fields) {
  for (Eigen::Index q = 0; q < fields.cols(); ++q)
    for (std::size_t a = 0; a < nodes.size(); ++a)
      fields.col(q).segment<3>(3 * nodes[a]) +=
          of_cell.col(static_cast<Eigen::Index>(a)).segment<3>(3 * q);
}

void slopes_of(const MatrixXd& of_cell, const CellPlaces& gradients, MatrixXd& slopes) {
  slopes.setZero(of_cell.rows(), 3);
  for (Eigen::Index a = 0; a < of_cell.cols(); ++a)
    for (Eigen::Index j = 0; j < 3; ++j) slopes.col(j) += gradients(j, a) * of_cell.col(a);
}

void add_forces(const MatrixXd& stresses, const CellPlaces& gradients, MatrixXd& of_cell) {
  for (Eigen::Index a = 0; a < of_cell.cols(); ++a)
    for (Eigen::Index j = 0; j < 3; ++j) of_cell.col(a) += gradients(j, a) * stresses.col(j);
}

}  // namespace flexopt
