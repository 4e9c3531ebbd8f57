#include "core/reduction/tube/equal_states.hpp"

#include <cmath>

namespace flexopt {
namespace {

constexpr double equal = 1e-9;

// A mirror of a flat leaf, or both: across its width, in its thickness.
struct Mirror {
  double width = 1, normal = 1;  ///< −1: mirrored

  /// Turns vectors; spins have `handed` beside it.
  Matrix3d axes() const { return Vector3d(1, width, normal).asDiagonal(); }
  double handed() const { return width * normal; }
  Vector6d deformations() const {
    Vector6d signs;
    signs << 1, normal, width, normal, width, handed();
    return signs;
  }
  Vector3d forces() const { return {1, width, width}; }
};

bool same(const LeafStand& a, const LeafStand& b, const Mirror& mirror) {
  const auto near = [](double x, double y) {
    return std::abs(x - y) <= equal * (std::abs(x) + std::abs(y));
  };
  return a.moving == b.moving && near(a.length, b.length) && near(a.energy, b.energy) &&
         near(a.mass, b.mass) &&
         (a.e - mirror.deformations().cwiseProduct(b.e)).cwiseAbs().maxCoeff() <= equal &&
         (a.f - mirror.forces().cwiseProduct(b.f)).cwiseAbs().maxCoeff() <=
             equal * (1 + a.f.cwiseAbs().maxCoeff());
}

// Node j of a line seen in the mirror.
int partner(const PlateMesh& mesh, const Mirror& mirror, int j) {
  return mirror.width < 0 ? mesh.nodes_per_line() - 1 - j : j;
}

// PlateLeaf::State::x of the image: places go from one base edge to the other.
VectorXd image_of_unknowns(const PlateMesh& mesh, const Mirror& mirror, const Matrix3d& turn,
                           const LeafStand& from, const LeafStand& to, const VectorXd& x) {
  const int n = mesh.functions_per_line(), nodes = mesh.nodes_per_line(),
            edge = mesh.edge_unknowns();
  const auto& slopes = mesh.edge_slopes();
  const int per_node = static_cast<int>(slopes.size());
  VectorXd y(x.size());
  // derivatives across change their sign with the width
  const auto sign = [&](int function) { return function >= 2 ? mirror.width : 1.0; };
  const Vector3d axes(1, mirror.width, mirror.normal);
  for (const Eigen::Index offset : {Eigen::Index(0), x.size() - edge})
    for (int j = 0; j < nodes; ++j)
      for (int k = 0; k < per_node; ++k) {
        const PlateMesh::EdgeSlope& slope = slopes[static_cast<std::size_t>(k)];
        y[offset + per_node * j + k] = sign(slope.function) * axes[slope.axis] *
                                       x[offset + per_node * partner(mesh, mirror, j) + k];
      }
  for (Eigen::Index o = edge; o + edge < x.size(); o += 3 * n)
    for (int j = 0; j < nodes; ++j)
      for (int k = 0; k < 4; ++k) {
        const Eigen::Index row = o + 4 * partner(mesh, mirror, j) + k, image = o + 4 * j + k;
        Vector3d v(x[row], x[row + n], x[row + 2 * n]);
        if (k == 0) v -= from.edges[0].position;
        v = (sign(k) * (turn * v)).eval();
        if (k == 0) v += to.edges[0].position;
        for (int c = 0; c < 3; ++c) y[image + c * n] = v[c];
      }
  return y;
}

LeafDynamics image_of_dynamics(const PlateMesh& mesh, const Mirror& mirror, const Matrix3d& local,
                               const Matrix3d& global, const LeafDynamics& leaf) {
  LeafDynamics image = leaf;
  const Eigen::Index coordinates = leaf.mass.rows();
  // increments of the edges of the leaf from those of its image
  MatrixXd T = MatrixXd::Identity(coordinates, coordinates);
  for (int e = 0; e < 2; ++e) {
    T.block<3, 3>(6 * e, 6 * e) = global.transpose();
    T.block<3, 3>(6 * e + 3, 6 * e + 3) = mirror.handed() * global.transpose();
  }
  image.mass = T.transpose() * leaf.mass * T;
  const MatrixXd stations = leaf.stations * T;
  for (Eigen::Index i = 0; i < stations.rows(); i += 6) {
    image.stations.middleRows<3>(i) = local * stations.middleRows<3>(i);
    image.stations.middleRows<3>(i + 3) = mirror.width * local * stations.middleRows<3>(i + 3);
  }
  if (leaf.shape_motion.rows() == 0) return image;
  const MatrixXd motion = leaf.shape_motion * T;
  const Eigen::Index lines = mesh.lines(), across = motion.rows() / (3 * lines);
  for (Eigen::Index j = 0; j < across; ++j)
    for (Eigen::Index i = 0; i < lines; ++i) {
      const Eigen::Index from = mirror.width < 0 ? across - 1 - j : j;
      image.shape_motion.middleRows<3>(3 * (j * lines + i)) =
          global * motion.middleRows<3>(3 * (from * lines + i));
    }
  return image;
}

}  // namespace

std::optional<CondensedLeaf> EqualStates::find(const PlateMesh& mesh, const LeafStand& stand,
                                               DynamicsRequest request) const {
  static constexpr std::array<Mirror, 4> mirrors{Mirror{1, 1}, Mirror{-1, 1}, Mirror{1, -1},
                                                 Mirror{-1, -1}};
  const bool mirrored = !mesh.shape().curve && !mesh.shape().is_beam();
  for (const Mirror& mirror : mirrors) {
    if (!mirrored && &mirror != mirrors.data()) break;
    for (const Kept& kept : kept_) {
      if (kept.request.modes != request.modes || kept.request.shapes != request.shapes ||
          !same(stand, kept.stand, mirror))
        continue;
      const Matrix3d local = stand.chord_axes * mirror.axes() * kept.stand.chord_axes.transpose(),
                     global = stand.leaf_axes * local * kept.stand.leaf_axes.transpose();
      CondensedLeaf image = kept.leaf;
      image.unknowns =
          image_of_unknowns(mesh, mirror, local, kept.stand, stand, kept.leaf.unknowns);
      image.dynamics = image_of_dynamics(mesh, mirror, local, global, kept.leaf.dynamics);
      return image;
    }
  }
  return std::nullopt;
}

void EqualStates::keep(const LeafStand& stand, DynamicsRequest request, const CondensedLeaf& leaf,
                       std::size_t most) {
  kept_.push_front({stand, request, leaf});
  if (kept_.size() > most) kept_.pop_back();
}

}  // namespace flexopt
