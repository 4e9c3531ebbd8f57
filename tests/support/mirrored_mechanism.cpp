#include "support/mirrored_mechanism.hpp"

#include <memory>
#include <type_traits>

#include "designs/solids/solid_shape.hpp"

namespace flexopt {
namespace {

struct Mirror {
  Vector3d place = Vector3d::Ones(), turn = -Vector3d::Ones();  // signs

  explicit Mirror(int normal) {
    place[normal] = -1;
    turn[normal] = 1;
  }
  void reflect(Vector3d& vector) const { vector = place.cwiseProduct(vector); }
  void reflect(DeadLoad& load) const {
    reflect(load.force);
    load.moment = turn.cwiseProduct(load.moment);
    reflect(load.arm);
    if (load.place) reflect(*load.place);
  }
  Matrix3d tensor(const Matrix3d& of) const { return place.asDiagonal() * of * place.asDiagonal(); }
  // Columns are axes of their own, of which the second turns round.
  Matrix3d axes(const Matrix3d& of) const {
    return place.asDiagonal() * of * Vector3d(1, -1, 1).asDiagonal();
  }
};

// Its own axes keep the first two; what is in them turns round along the third.
template <class Body>
void reflect_solid(Body& body, const Mirror& mirror) {
  mirror.reflect(body.place);
  body.axes = mirror.place.asDiagonal() * body.axes * Vector3d(1, 1, -1).asDiagonal();
  if (body.cells) body.cells = std::make_shared<const SolidCells>(mirrored(*body.cells));
  for (Vector3d& node : body.nodes) node[2] = -node[2];
  for (auto& held : body.interfaces) {
    held.origin[2] = -held.origin[2];
    held.face[2] = -held.face[2];
  }
  if (!body.coarse) return;
  auto coarse = std::make_shared<std::decay_t<decltype(*body.coarse)>>(*body.coarse);
  reflect_solid(*coarse, mirror);
  body.coarse = coarse;
}

// Of a drive whose axes are mirrored like a tensor, which leaves global ones as they are.
double sign_of_stroke(const Mirror& mirror, const Drive& drive) {
  const int d = index(drive.direction);
  return d < 3 ? mirror.place[d] : mirror.turn[d - 3];
}

}  // namespace

Mechanism mirrored(const Mechanism& mechanism, int normal) {
  const Mirror mirror(normal);
  const auto reflect = [&](Vector3d& vector) { mirror.reflect(vector); };
  Mechanism m = mechanism;
  for (RigidBody& body : m.bodies) {
    reflect(body.reference);
    reflect(body.center_of_mass);
    body.inertia = mirror.tensor(body.inertia);
    if (!body.box) continue;
    reflect(body.box->center);
    body.box->half_edges = mirror.place.asDiagonal() * body.box->half_edges;
  }
  for (auto& body : m.elastic_bodies) reflect_solid(body, mirror);
  for (LeafSpring& leaf : m.leaves) {
    reflect(leaf.origin);
    leaf.axes = mirror.axes(leaf.axes);
    if (leaf.point) leaf.point->across = 1 - leaf.point->across;
  }
  for (Joint& joint : m.joints) {
    reflect(joint.place);
    reflect(joint.axis);
  }
  for (Spring& spring : m.springs) {
    reflect(spring.place);
    reflect(spring.other_place);
    if (!spring.matrix) continue;
    Vector6d signs;
    signs << mirror.place, mirror.turn;
    spring.matrix = (signs.asDiagonal() * *spring.matrix * signs.asDiagonal()).eval();
  }
  for (Drive& drive : m.drives) drive.axes = mirror.tensor(drive.axes);
  return m;
}

StrokeRequest mirrored(const StrokeRequest& request, const Mechanism& mechanism, int normal) {
  const Mirror mirror(normal);
  StrokeRequest r = request;
  for (DeadLoad& load : r.loads.constant) mirror.reflect(load);
  for (DeadLoad& load : r.loads.growing) mirror.reflect(load);
  mirror.reflect(r.loads.gravity);
  for (NamedPoint& point : r.named_points) point.across = 1 - point.across;  // of leaves
  if (!r.loads.driven() || mechanism.drives.empty()) return r;
  for (double& point : r.points) point *= sign_of_stroke(mirror, mechanism.drives.front());
  for (VectorXd& strokes : r.strokes)
    for (std::size_t k = 0; k < mechanism.drives.size(); ++k)
      strokes[static_cast<Eigen::Index>(k)] *= sign_of_stroke(mirror, mechanism.drives[k]);
  return r;
}

int mirror_of_stroke(const Mechanism& mechanism) {
  if (mechanism.drives.empty()) return 1;
  const int d = index(mechanism.drives.front().direction);
  return d < 3 ? (d + 1) % 3 : d - 3;
}

}  // namespace flexopt
