// Shapes of bodies that can be made: blocks behind the edges that they hold, and ribs between them.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <set>

#include "core/mechanism/profile.hpp"
#include "results/export/parts.hpp"

namespace flexopt {

namespace {

/// A convex mesh and the box around it.
struct ConvexPiece {
  explicit ConvexPiece(TriangleMesh of) : mesh(std::move(of)) {
    for (const Vector3d& p : mesh.points) box.extend(p);
  }
  TriangleMesh mesh;
  Eigen::AlignedBox3d box;
};

/// Corners around a place: from `from` to `to` along each of the axes.
std::vector<Vector3d> corners_of(const Vector3d& place, const Matrix3d& axes, const Vector3d& from,
                                 const Vector3d& to) {
  std::vector<Vector3d> corners;
  for (int k = 0; k < 8; ++k)
    corners.push_back(place + axes * Vector3d(k & 1 ? to[0] : from[0], k & 2 ? to[1] : from[1],
                                              k & 4 ? to[2] : from[2]));
  return corners;
}

/// How far two convex meshes are within each other along the axis along which that is least [m];
/// not positive where they are apart or touch. Separating axes: faces of both, products of edges.
double depth_of(const ConvexPiece& a, const ConvexPiece& b) {
  if (!a.box.intersects(b.box)) return -1;
  double least = 1e300;
  const auto judge = [&](Vector3d axis) {
    const double length = axis.norm();
    if (length < 1e-9) return;
    axis /= length;
    std::array<double, 2> low{1e300, 1e300}, high{-1e300, -1e300};
    for (const ConvexPiece* piece : {&a, &b})
      for (const Vector3d& p : piece->mesh.points) {
        const double along = axis.dot(p);
        double &l = low[piece == &b], &h = high[piece == &b];
        l = std::min(l, along);
        h = std::max(h, along);
      }
    least = std::min(least, std::min(high[0], high[1]) - std::max(low[0], low[1]));
  };
  const auto edges = [](const TriangleMesh& mesh) {
    std::vector<Vector3d> all;
    for (const auto& t : mesh.triangles)
      for (std::size_t k = 0; k < 3; ++k)
        if (t[k] < t[(k + 1) % 3])
          all.push_back((mesh.points[t[(k + 1) % 3]] - mesh.points[t[k]]).normalized());
    return all;
  };
  for (const ConvexPiece* piece : {&a, &b})
    for (const auto& [i, j, k] : piece->mesh.triangles) {
      const std::vector<Vector3d>& p = piece->mesh.points;
      judge((p[j] - p[i]).normalized().cross((p[k] - p[i]).normalized()));
      if (least <= 0) return least;
    }
  const std::vector<Vector3d> own = edges(a.mesh), other = edges(b.mesh);
  for (const Vector3d& e : own)
    for (const Vector3d& f : other) {
      judge(e.cross(f));
      if (least <= 0) return least;
    }
  return least;
}

/// Convex pieces of a leaf, few for an arc or a profile.
std::vector<ConvexPiece> convex_pieces_of(const LeafSpring& leaf) {
  const LeafSurface surface = undeflected_surface(leaf);
  std::vector<ConvexPiece> pieces;
  const int step = std::max(1, (surface.along - 1) / 8);
  for (int first = 0; first + 1 < surface.along; first += step) {
    std::vector<Vector3d> points;
    for (int i = first; i <= std::min(first + step, surface.along - 1); ++i)
      for (int j = 0; j < surface.across; ++j)
        for (const double sign : {-1.0, 1.0}) {
          const std::size_t k = surface.at(i, j);
          const Vector3d face = surface.middle[k] + sign * surface.half[k];
          if (!surface.round()) points.push_back(face);
          for (const double other : {-1.0, 1.0})
            if (surface.round()) points.push_back(face + other * surface.side[k]);
        }
    pieces.emplace_back(convex_hull(points));
  }
  return pieces;
}

class Forms {
 public:
  /// `scale`: of blocks, their margins and the room around leaves.
  Forms(const Mechanism& mechanism, double room, double scale) : mechanism_(&mechanism) {
    const double size = scale * drawn_size(mechanism);
    clear_ = std::max(0.005 * size, 1.5 * room);
    margin_ = 3 * clear_;
    depth_ = 0.04 * size;
    touching_ = 1e-7 * size;
    for (const LeafSpring& leaf : mechanism.leaves) leaves_.push_back(convex_pieces_of(leaf));
  }

  std::vector<BodyForm> all() && {
    const int bodies = static_cast<int>(mechanism_->bodies.size());
    for (int body = 0; body <= bodies; ++body) add_nodes(body < bodies ? body : ground);
    for (Made& made : made_) join(made);  // the ground last: it gives way
    for (Made& made : made_) check(made);
    std::vector<BodyForm> forms;
    for (Made& made : made_) {
      for (ConvexPiece& piece : made.blocks) made.form.blocks.push_back(std::move(piece.mesh));
      for (ConvexPiece& piece : made.ribs) made.form.ribs.push_back(std::move(piece.mesh));
      forms.push_back(std::move(made.form));
    }
    return forms;
  }

 private:
  struct Made {
    BodyForm form;
    std::vector<ConvexPiece> blocks, ribs;
    bool has_box = false;  ///< the first of the ribs
  };

  bool holds(const LeafSpring& leaf, int body) const {
    return leaf.base == body || leaf.tip == body;
  }

  /// The block behind an edge, less deep where another leaf is behind it; none in the body's box.
  void add_block(Made& made, std::size_t i, int end) {
    const LeafSpring& leaf = mechanism_->leaves[i];
    const Vector3d place = edge_place(leaf, end);
    if (in_box(made, place)) return;
    const bool round = leaf.section == Section::circular;
    const double w = 0.5 * leaf.width * profile_at(leaf.width_profile, end),
                 t = 0.5 * leaf.thickness * profile_at(leaf.thickness_profile, end);
    const Vector3d half(0, round ? w + margin_ : w, t + margin_);
    std::size_t meets = i;
    for (double depth = depth_; depth > 0.1 * depth_; depth *= 0.5) {
      Vector3d from = -half, to = half;
      (end == 0 ? from : to)[0] = end == 0 ? -depth : depth;
      ConvexPiece block(convex_hull(corners_of(place, leaf.edge_axes(end), from, to)));
      meets = leaf_behind(block, i, end);
      if (meets == leaves_.size()) return made.blocks.push_back(std::move(block));
    }
    const LeafSpring& other = mechanism_->leaves[meets];
    if (holds(other, made.form.body))
      made.form.bare.push_back(leaf.name);
    else
      made.form.faults.push_back(fmt::format("body {} has no room behind leaf {}: leaf {} is there",
                                             made.form.name, leaf.name, other.name));
  }

  static Vector3d edge_place(const LeafSpring& leaf, int end) {
    return end == 0 ? leaf.origin : leaf.tip_middle();
  }
  static Vector3d into(const LeafSpring& leaf, int end) {
    return (end == 0 ? 1 : -1) * leaf.edge_axes(end).col(0);
  }

  /// A leaf that the block behind the edge would meet; the number of leaves where there is none.
  /// Leaves that leave one place to the same side do not stand in each other's blocks.
  std::size_t leaf_behind(const ConvexPiece& block, std::size_t i, int end) const {
    const LeafSpring& leaf = mechanism_->leaves[i];
    for (std::size_t k = 0; k < leaves_.size(); ++k) {
      if (k == i) continue;
      const LeafSpring& other = mechanism_->leaves[k];
      bool beside = false;
      for (int e = 0; e < 2; ++e)
        beside = beside || ((edge_place(other, e) - edge_place(leaf, end)).norm() < margin_ &&
                            into(other, e).dot(into(leaf, end)) > 0.3);
      if (!beside && hits(block, leaves_[k])) return k;
    }
    return leaves_.size();
  }

  /// Whether a place is in the body's box or on its faces.
  bool in_box(const Made& made, const Vector3d& place) const {
    if (!made.has_box) return false;
    const BodyBoxT<double>& box = *mechanism_->bodies[made.form.body].box;
    const Vector3d at = box.half_edges.inverse() * (place - box.center);
    return at.cwiseAbs().maxCoeff() < 1 + 1e-6;
  }

  bool hits(const ConvexPiece& piece, const std::vector<ConvexPiece>& others) const {
    return std::ranges::any_of(
        others, [&](const ConvexPiece& other) { return depth_of(piece, other) > touching_; });
  }

  void add_nodes(int body) {
    Made made;
    made.form.body = body;
    made.form.name = body == ground ? "ground" : mechanism_->bodies[body].name;
    made.has_box = body != ground && mechanism_->bodies[body].box;
    if (made.has_box) made.ribs.emplace_back(closed_box(*mechanism_->bodies[body].box));
    for (std::size_t i = 0; i < leaves_.size(); ++i)
      for (int end = 0; end < 2; ++end)
        if ((end == 0 ? mechanism_->leaves[i].base : mechanism_->leaves[i].tip) == body)
          add_block(made, i, end);
    const Vector3d half = Vector3d::Constant(0.5 * margin_);
    const auto add_place = [&](const Vector3d& place) {
      made.ribs.emplace_back(convex_hull(corners_of(place, Matrix3d::Identity(), -half, half)));
    };
    for (const Joint& joint : mechanism_->joints)
      if (!is_held(joint.type) && (joint.body == body || joint.other == body))
        add_place(joint.place);
    for (const Spring& spring : mechanism_->springs) {
      if (spring.body == body) add_place(spring.place);
      if (spring.other == body) add_place(spring.matrix ? spring.place : spring.other_place);
    }
    made_.push_back(std::move(made));
  }

  /// Whether a joint ties both bodies, so that they meet there.
  bool tied(int body, int other) const {
    return std::ranges::any_of(mechanism_->joints, [&](const Joint& joint) {
      return !is_held(joint.type) &&
             std::minmax(joint.body, joint.other) == std::minmax(body, other);
    });
  }

  /// Whether a rib would meet another body, or a leaf of others.
  bool is_in_the_way(const Made& made, const ConvexPiece& rib) const {
    for (const Made& other : made_)
      if (&other != &made && !tied(made.form.body, other.form.body) &&
          (hits(rib, other.blocks) || hits(rib, other.ribs)))
        return true;
    for (std::size_t i = 0; i < leaves_.size(); ++i)
      if (!holds(mechanism_->leaves[i], made.form.body) && hits(rib, leaves_[i])) return true;
    return false;
  }

  /// Joins blocks and box by the shortest ribs that meet nothing else (the tree of Kruskal).
  void join(Made& made) {
    std::vector<ConvexPiece> nodes = made.blocks;
    nodes.insert(nodes.end(), made.ribs.begin(), made.ribs.end());
    const std::size_t count = nodes.size();
    std::vector<std::size_t> part(count);
    std::iota(part.begin(), part.end(), 0);
    struct Way {
      double length;
      std::size_t from, to;
    };
    std::vector<Way> ways;
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = i + 1; j < count; ++j)
        ways.push_back({(nodes[i].box.center() - nodes[j].box.center()).norm(), i, j});
    std::ranges::stable_sort(ways, {}, &Way::length);
    for (const auto& [length, i, j] : ways) {
      if (part[i] == part[j]) continue;
      std::vector<Vector3d> points = nodes[i].mesh.points;
      const bool to_box = made.has_box && j == made.blocks.size();
      const Vector3d moved = nodes[j].box.center() - nodes[i].box.center();
      for (const Vector3d& p : to_box ? nodes[i].mesh.points : nodes[j].mesh.points)
        points.push_back(to_box ? Vector3d(p + moved) : p);
      ConvexPiece rib(convex_hull(points));
      if (is_in_the_way(made, rib)) continue;
      made.ribs.push_back(std::move(rib));
      const std::size_t gone = part[j], kept = part[i];
      std::ranges::replace(part, gone, kept);
    }
    made.form.parts = static_cast<int>(std::set<std::size_t>(part.begin(), part.end()).size());
  }

  /// Sentences on what cannot be made as it is.
  void check(Made& made) {
    BodyForm& form = made.form;
    for (std::size_t i = 0; i < leaves_.size(); ++i)
      if (holds(mechanism_->leaves[i], form.body)) add_rooms(mechanism_->leaves[i], form);
    if (form.parts > 1 && form.body != ground)
      form.faults.push_back(fmt::format(
          "body {} falls into {} pieces: leaves or other bodies stand between the edges it holds",
          form.name, form.parts));
    for (const Made& other : made_) {
      if (&other == &made) break;
      const auto meets = [&](const std::vector<ConvexPiece>& own) {
        return std::ranges::any_of(own, [&](const ConvexPiece& piece) {
          return hits(piece, other.blocks) || hits(piece, other.ribs);
        });
      };
      if (!tied(form.body, other.form.body) && (meets(made.blocks) || meets(made.ribs)))
        form.faults.push_back(fmt::format("bodies {} and {} overlap", other.form.name, form.name));
    }
  }

  /// The room that a leaf needs before the edges that hold it: along a flat one to its other edge,
  /// along both legs of a fold, along a part of an arc.
  void add_rooms(const LeafSpring& leaf, BodyForm& form) const {
    const double w = 0.5 * leaf.width * profile_range(leaf.width_profile).largest + clear_,
                 t = 0.5 * leaf.thickness * profile_range(leaf.thickness_profile).largest + clear_;
    for (int end = 0; end < (leaf.curve || leaf.fold ? 2 : 1); ++end) {
      const double leg = leaf.fold ? (end == 0 ? leaf.fold->place : 1 - leaf.fold->place)
                                   : (leaf.curve ? 0.25 : 1.0),
                   way = leg * leaf.length;
      form.rooms.push_back(
          convex_hull(corners_of(edge_place(leaf, end), leaf.edge_axes(end),
                                 {end == 0 ? 0 : -way, -w, -t}, {end == 0 ? way : 0, w, t})));
    }
  }

  const Mechanism* mechanism_;
  double clear_ = 0, margin_ = 0, depth_ = 0, touching_ = 0;
  std::vector<std::vector<ConvexPiece>> leaves_;
  std::vector<Made> made_;
};

}  // namespace

std::vector<BodyForm> body_forms(const Mechanism& mechanism, double room) {
  std::vector<BodyForm> forms;
  for (const double scale : {1.0, 0.5, 0.25}) {  // smaller where there is less room
    forms = Forms(mechanism, room, scale).all();
    if (std::ranges::all_of(forms, [](const BodyForm& form) { return form.faults.empty(); })) break;
  }
  return forms;
}

}  // namespace flexopt
