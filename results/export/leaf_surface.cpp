#include <algorithm>
#include <cmath>

#include "core/mechanism/profile.hpp"
#include "results/export/parts.hpp"
#include "results/files/scene.hpp"

namespace flexopt {

namespace {

/// (n1 + n2)/(1 + n1·n2) of two unit normals: what both faces share at their mitre.
Vector3d mitre(const Vector3d& first, const Vector3d& second) {
  return (first + second) / (1 + first.dot(second));
}

/// Weights of the cubic through the four nearest of the places (fewer where there are fewer), and
/// of its slope.
struct Weights {
  int first = 0, count = 0;
  std::array<double, 4> value{}, slope{};
};

Weights cubic(const double* places, int count, double s) {
  Weights w;
  w.count = std::min(count, 4);
  const int above = static_cast<int>(std::upper_bound(places, places + count, s) - places);
  w.first = std::clamp(above - 2, 0, count - w.count);
  const double* x = places + w.first;
  for (int i = 0; i < w.count; ++i) {
    double value = 1;
    for (int j = 0; j < w.count; ++j)
      if (j != i) value *= (s - x[j]) / (x[i] - x[j]);
    w.value[i] = value;
    for (int k = 0; k < w.count; ++k) {
      if (k == i) continue;
      double product = 1 / (x[i] - x[k]);
      for (int j = 0; j < w.count; ++j)
        if (j != i && j != k) product *= (s - x[j]) / (x[i] - x[j]);
      w.slope[i] += product;
    }
  }
  return w;
}

/// A piece of a shape between its ends or folds, both included.
struct Piece {
  int first = 0, last = 0;
};

std::vector<Piece> pieces_of(const std::vector<double>& places) {
  std::vector<Piece> pieces{{0, 0}};
  for (int i = 1; i < static_cast<int>(places.size()); ++i) {
    if (places[i] <= places[i - 1])  // a fold is there twice
      pieces.push_back({i, i});
    else
      pieces.back().last = i;
  }
  return pieces;
}

/// Middle and normal of a surface at points of a shape.
class Interpolated {
 public:
  Interpolated(const LeafSpring& leaf, const LeafShape& shape, const std::vector<Vector3d>& points)
      : shape_(&shape), points_(&points) {
    for (int j = 0; j < shape.points_across; ++j)
      rows_.push_back(static_cast<double>(j) / std::max(shape.points_across - 1, 1));
    const Vector3d across =
        shape.undeflected[(shape.points_across - 1) * shape.points_along] - shape.undeflected[0];
    sign_ = across.dot(leaf.edge_axes(0).col(1)) < 0 ? -1 : 1;
  }

  int rows() const { return shape_->points_across; }
  double row(int j) const { return rows_[j]; }

  struct Point {
    Vector3d middle = Vector3d::Zero(), across = Vector3d::Zero(), normal = Vector3d::Zero();
  };
  Point at(const Weights& along, double v) const {
    const Weights w = cubic(rows_.data(), rows(), v);
    Point point;
    Vector3d slope = Vector3d::Zero();
    for (int b = 0; b < w.count; ++b)
      for (int a = 0; a < along.count; ++a) {
        const Vector3d& p = (*points_)[(w.first + b) * shape_->points_along + along.first + a];
        point.middle += w.value[b] * along.value[a] * p;
        slope += w.value[b] * along.slope[a] * p;
        point.across += w.slope[b] * along.value[a] * p;
      }
    point.across *= sign_;
    point.normal = slope.cross(point.across).normalized();
    return point;
  }

 private:
  const LeafShape* shape_;
  const std::vector<Vector3d>* points_;
  std::vector<double> rows_;
  double sign_ = 1;
};

using Row = std::vector<Vector3d>;  ///< across the leaf

/// Collects a surface section by section.
class SurfaceBuilder {
 public:
  explicit SurfaceBuilder(const LeafSpring& leaf) : leaf_(&leaf) {}

  void add_sheet(double s, Row middle, Row normal) {
    surface_.places.push_back(s);
    middle_.push_back(std::move(middle));
    normal_.push_back(std::move(normal));
  }
  /// Marks the last section as a fold, behind which the normals are these.
  void add_fold(const Row& behind) {
    surface_.folds.push_back(static_cast<int>(normal_.size()) - 1);
    for (std::size_t j = 0; j < behind.size(); ++j)
      normal_.back()[j] = mitre(normal_.back()[j], behind[j]);
  }
  void add_wire(double s, const Vector3d& middle, const Vector3d& along, const Vector3d& across) {
    const Vector3d side = (across - along * along.dot(across)).normalized();
    const double radius = half_thickness(*leaf_, s);
    surface_.places.push_back(s);
    surface_.middle.push_back(middle);
    surface_.side.push_back(radius * side);
    surface_.half.push_back(radius * along.cross(side));
  }

  /// The finished surface; points along run first.
  LeafSurface surface() && {
    surface_.along = static_cast<int>(surface_.places.size());
    surface_.across = middle_.empty() ? 1 : static_cast<int>(middle_.front().size());
    for (std::size_t j = 0; !middle_.empty() && j < middle_.front().size(); ++j)
      for (std::size_t i = 0; i < middle_.size(); ++i) {
        surface_.middle.push_back(middle_[i][j]);
        surface_.half.push_back(half_thickness(*leaf_, surface_.places[i]) * normal_[i][j]);
      }
    return std::move(surface_);
  }

 private:
  const LeafSpring* leaf_;
  LeafSurface surface_;
  std::vector<Row> middle_, normal_;
};

bool is_wire(const LeafSpring& leaf) { return leaf.section == Section::circular; }

/// Sections of an undeflected leaf; a fold is one of them.
std::vector<double> undeflected_places(const LeafSpring& leaf) {
  const int steps = leaf.curve || leaf.has_profile() ? 120 : 1;
  const double fold = leaf.fold ? leaf.fold->place : 1;
  std::vector<double> places;
  for (int k = 0; k <= steps; ++k) places.push_back(fold * k / steps);
  for (int k = 1; leaf.fold && k <= steps; ++k) places.push_back(fold + (1 - fold) * k / steps);
  return places;
}

}  // namespace

std::vector<Vector3d> LeafSurface::contour() const {
  std::vector<Vector3d> outline;
  const auto add = [&](int i, double sign) {
    const std::size_t a = at(i, (across - 1) / 2), b = at(i, across / 2);
    outline.emplace_back(0.5 * (middle[a] + middle[b] + sign * (half[a] + half[b])));
  };
  for (int i = 0; i < along; ++i) add(i, 1);
  for (int i = along; i-- > 0;) add(i, -1);
  return outline;
}

LeafSurface surface_of_shape(const LeafSpring& leaf, const LeafShape& shape,
                             const std::vector<Vector3d>& points, int finer) {
  const std::vector<double> stations = places_along(shape);
  const Interpolated of(leaf, shape, points);
  SurfaceBuilder builder(leaf);
  const auto add = [&](double s, const Weights& along, bool behind_fold) {
    if (is_wire(leaf)) {
      const Interpolated::Point at = of.at(along, 0.5);
      return builder.add_wire(s, at.middle, at.across.cross(at.normal).normalized(), at.across);
    }
    Row middle, normal;
    for (int j = 0; j < of.rows(); ++j) {
      const Interpolated::Point at = of.at(along, of.row(j));
      middle.push_back(at.middle);
      normal.push_back(at.normal);
    }
    if (behind_fold)
      builder.add_fold(normal);
    else
      builder.add_sheet(s, std::move(middle), std::move(normal));
  };
  for (const Piece& piece : pieces_of(stations)) {
    const int count = piece.last - piece.first + 1;
    for (int k = 0; k <= finer * (count - 1); ++k) {
      const int i = piece.first + std::min(k / finer, count - 2);
      const double part = static_cast<double>(k) / finer - (i - piece.first);
      const double s = stations[i] + part * (stations[i + 1] - stations[i]);
      Weights along = cubic(stations.data() + piece.first, count, s);
      along.first += piece.first;
      add(s, along, k == 0 && piece.first > 0);
    }
  }
  return std::move(builder).surface();
}

LeafSurface undeflected_surface(const LeafSpring& leaf) {
  SurfaceBuilder builder(leaf);
  for (const double s : undeflected_places(leaf)) {
    const ArcPoint<double> at = leaf.middle(s);
    const Matrix3d axes = leaf.axes * at.axes();
    const Vector3d middle = leaf.origin + leaf.axes.col(0) * (leaf.length * at.x) +
                            leaf.axes.col(2) * (leaf.length * at.z);
    if (is_wire(leaf)) {
      builder.add_wire(s, middle, axes.col(0), axes.col(1));
      continue;
    }
    const Vector3d edge = 0.5 * leaf.width * profile_at(leaf.width_profile, s) * axes.col(1);
    builder.add_sheet(s, {middle - edge, middle + edge}, {axes.col(2), axes.col(2)});
    if (leaf.fold && s == leaf.fold->place) {
      const Vector3d behind = leaf.edge_axes(1).col(2);
      builder.add_fold({behind, behind});
    }
  }
  return std::move(builder).surface();
}

}  // namespace flexopt
