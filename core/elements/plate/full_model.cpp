#include "core/elements/plate/full_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

// Differences of places: the slopes need only be good enough for Newton to start from.
constexpr double spacing = 1e-3;

// Function k of a node (r, r,x, r,y, r,xy) from the places of another model's material points.
class SampledField {
 public:
  SampledField(LeafElement& other, const LeafScale& scale, const PlateMesh& mesh)
      : other_(&other), scale_(&scale), mesh_(&mesh) {}

  Vector3d operator()(int line, int node, int function) const {
    const double w = mesh_->shape().width;
    const double x = mesh_->x()[line];
    const double y = mesh_->shape().is_beam() ? 0.5 : 0.5 + mesh_->y()[node] / w;
    const double x0 = std::max(x - spacing, 0.0), x1 = std::min(x + spacing, 1.0);
    // lines across a beam are straight
    const bool beam = mesh_->shape().is_beam();
    const double by = beam ? 0.5 : spacing;
    const double y0 = std::max(y - by, 0.0), y1 = std::min(y + by, 1.0), dx = x1 - x0;
    const auto across = [&](double at) -> Vector3d {
      return (place(at, y1) - place(at, y0)) /
             ((y1 - y0) * (beam ? mesh_->shape().width_at(at) : w));
    };
    switch (function) {
      case 0:
        return place(x, y);
      case 1:
        return (place(x1, y) - place(x0, y)) / dx;
      case 2:
        return across(x);
      default:
        return (across(x1) - across(x0)) / dx;
    }
  }

 private:
  Vector3d place(double along, double across) const {
    return scale_->scaled({other_->material_point(along, across), Matrix3d::Identity()}).position;
  }

  LeafElement* other_;
  const LeafScale* scale_;
  const PlateMesh* mesh_;
};

PlateLeaf::State sampled_state(const PlateLeaf& plate, const SampledField& field,
                               const LeafHold& scaled) {
  const PlateMesh& mesh = plate.mesh();
  const int n = mesh.functions_per_line();
  const auto& slopes = mesh.edge_slopes();
  PlateLeaf::State state{scaled.edges, VectorXd::Zero(plate.unknowns()), scaled.point_displacement,
                         scaled.point_force};
  for (int i = 0; i < mesh.lines(); ++i) {
    double* x = state.x.data() + plate.block_offset(i);
    if (!plate.is_rigid_edge(i)) {
      for (int s = 0; s < n; ++s) {
        const Vector3d v = field(i, s / 4, s % 4);
        for (int c = 0; c < 3; ++c) x[c * n + s] = v[c];
      }
      continue;
    }
    const Matrix3d& axes = scaled.edges[i == 0 ? 0 : 1].axes;
    for (int j = 0; j < mesh.nodes_per_line(); ++j) {
      const auto reference = mesh.reference_node(i, j);
      for (const PlateMesh::EdgeSlope& slope : slopes) {
        const Vector3d v = axes.transpose() * field(i, j, slope.function);
        *x++ = v[slope.axis] - reference[static_cast<std::size_t>(slope.function)][slope.axis];
      }
    }
  }
  return state;
}

// The undeflected leaf, moved rigidly with its base edge.
PlateLeaf::State rigid_state(const PlateLeaf& plate, const EdgePose& base) {
  const PlateMesh& mesh = plate.mesh();
  const int n = mesh.functions_per_line();
  PlateLeaf::State state = PlateLeaf::undeflected(mesh, plate.support().free_tip);
  const Matrix3d turn = base.axes * mesh.line_pose(0).axes.transpose();  // of the whole leaf
  for (int i = 0; i < mesh.lines(); ++i) {
    if (plate.is_rigid_edge(i)) continue;
    Eigen::Map<MatrixXd> r(state.x.data() + plate.block_offset(i), n, 3);
    r = (r * turn.transpose()).eval();
    for (int s = 0; s < n; s += 4) r.row(s) += base.position.transpose();
  }
  const EdgePose& tip = mesh.line_pose(mesh.lines() - 1);
  state.edges = {base, {base.position + turn * tip.position, turn * tip.axes}};
  if (plate.has_point())
    state.point = base.position + turn * plate.point_place() - plate.point_place();
  return state;
}

// Newton with the edges held, at most as unstable as `pivots` negative ones.
bool settles(FullLeaf& leaf, const LeafHold& hold, int pivots) {
  constexpr int most = 25;
  constexpr double rest = 1e-9;  // energy of the last correction: (lengths / L)² D
  for (int k = 0; k < most; ++k) {
    const LeafEvaluation& at = leaf.evaluate();
    if (!std::isfinite(at.correction)) return false;
    if (at.correction < rest) return at.negative_pivots <= pivots;
    leaf.displace_point(hold.point_displacement, Vector3d::Zero());
    leaf.move(hold.edges, Vector12d::Zero());
  }
  return false;
}

// Path from the rigidly moved leaf to `hold`. The tip turns steadily and moves along the arc to
// which a leaf bends without stretch; what remains of its displacement along the leaf grows with
// the square of the displacement across.
class WayFromRest {
 public:
  WayFromRest(const FullLeaf& full, const LeafHold& hold) : scale_(&full.scale()) {
    // seen from the chord of the undeflected leaf
    const PlateMesh& mesh = full.plate().mesh();
    end_ = mesh.line_pose(mesh.lines() - 1);
    base_ = scale_->scaled(hold.edges[0]);
    base_.axes = (base_.axes * mesh.line_pose(0).axes.transpose()).eval();
    const EdgePose tip = scale_->scaled(hold.edges[1]);
    turn_ = rotation_log(base_.axes.transpose() * tip.axes * end_.axes.transpose());
    tip_ = base_.axes.transpose() * (tip.position - base_.position) - arc(1);
    const Vector3d place = full.plate().point_place();
    rigid_point_ = scale_->axes * (base_.position + base_.axes * place - place) * scale_->length;
    point_ = hold.point_displacement - rigid_point_;
    free_tip_ = full.plate().support().free_tip;
    last_ = hold;
  }

  LeafHold at(double s) const {
    if (s >= 1) return last_;
    LeafHold hold = last_;
    if (!free_tip_) {
      const Vector3d place = arc(s) + curved(tip_, s, Vector3d::UnitX());
      hold.edges[1] = scale_->global(
          {base_.position + base_.axes * place, base_.axes * rotation_exp(s * turn_) * end_.axes});
    }
    hold.point_displacement = rigid_point_ + curved(point_, s, scale_->axes * base_.axes.col(0));
    return hold;
  }

 private:
  Vector3d arc(double s) const {
    return end_.position[0] * rotation_left_tangent(s * turn_).col(0);
  }
  static Vector3d curved(const Vector3d& way, double s, const Vector3d& along) {
    return s * way - s * (1 - s) * along.dot(way) * along;
  }

  const LeafScale* scale_;
  EdgePose base_, end_;
  Vector3d turn_, tip_, rigid_point_, point_;
  bool free_tip_ = false;
  LeafHold last_;
};

bool comes_from_rest(FullLeaf& full, const LeafHold& hold, int pivots) {
  full.plate().set_state(rigid_state(full.plate(), full.scale().scaled(hold.edges[0])));
  const WayFromRest way(full, hold);
  double reached = 0, step = 0.25;
  while (reached < 1) {
    const auto kept = full.save();
    const double next = std::min(1.0, reached + step);
    const LeafHold from = way.at(reached), to = way.at(next);
    Vector12d dq;
    for (int e = 0; e < 2; ++e)
      dq.segment<6>(6 * e) << to.edges[e].position - from.edges[e].position,
          rotation_log(to.edges[e].axes * from.edges[e].axes.transpose());
    full.evaluate();
    full.displace_point(to.point_displacement, to.point_displacement - from.point_displacement);
    full.move(to.edges, dq);
    if (settles(full, to, pivots)) {
      reached = next;
      continue;
    }
    full.restore(*kept);
    step /= 2;
    if (step < 1.0 / 512) return false;
  }
  return true;
}

}  // namespace

std::unique_ptr<FullLeaf> full_model_in_place(LeafElement& other, const LeafHold& hold,
                                              const LeafSpring& leaf,
                                              std::shared_ptr<const PlateMesh> mesh, int index,
                                              const std::string& reason) {
  auto full = std::make_unique<FullLeaf>(leaf, std::move(mesh), index, reason);
  PlateLeaf& plate = full->plate();
  const LeafScale& scale = full->scale();
  const int pivots = other.evaluation().negative_pivots;
  const LeafHold scaled{{scale.scaled(hold.edges[0]), scale.scaled(hold.edges[1])},
                        scale.axes.transpose() * hold.point_displacement / scale.length,
                        scale.axes.transpose() * hold.point_force * scale.length / scale.energy};
  const PlateLeaf::State start =
      sampled_state(plate, SampledField(other, scale, plate.mesh()), scaled);
  // the first tangent takes the stress at rest: the sampled membrane stress is mostly error
  plate.linearise();
  plate.step_to(start, VectorXd::Zero(plate.unknowns()), Vector12d::Zero());
  if (settles(*full, hold, pivots) || comes_from_rest(*full, hold, pivots)) return full;
  plate.set_state(start);
  full->evaluate();
  return full;
}

}  // namespace flexopt
