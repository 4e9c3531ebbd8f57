#pragma once
// The numbers that the elements of a mesh are made of, as S = double or, along a direction of the
// shape, as S = Dual1.
#include <vector>

#include "core/elements/plate/plate_shape.hpp"
#include "core/math/dual.hpp"
#include "core/mechanism/arc.hpp"

namespace flexopt {

/// How y = y0 f(x) maps at a place: equation (P2) of core/elements/README.md.
template <class S>
struct WidthMap {
  S factor = S(1), slope = S(0), curvature = S(0);  ///< f, f'/f, f''/f
};

/// Derivatives of a function of (x, y) from those in (x, y0), at y0: equation (P3).
template <class V>
struct MappedDerivatives {
  V x, y, xx, xy, yy;
};
template <class S, class V>
MappedDerivatives<V> mapped(const WidthMap<S>& map, const S& y0, const V& x, const V& y,
                            const V& xx, const V& xy, const V& yy) {
  const S g = -y0 * map.slope, per = 1.0 / map.factor;
  const S bend = y0 * (2.0 * map.slope * map.slope - map.curvature);
  const S gg = g * g, twice = 2.0 * g, squared = per * per;
  return {V(x + g * y), V(per * y), V(xx + twice * xy + gg * yy + bend * y),
          V(per * (xy - map.slope * y + g * yy)), V(squared * yy)};
}

/// The stored part of a number: its value, or its derivative.
inline double part_of(double x) { return x; }
inline double part_of(const Dual1& x) { return x.derivatives[0]; }

/// Value of a displacement component as Σ weight · nodal dof.
template <class S>
struct NodalWeightT {
  int line, function;
  S weight;
};
using NodalWeight = NodalWeightT<double>;

template <class S>
class MeshNumbers {
 public:
  /// `rate`: of the shape, read where S = Dual1.
  explicit MeshNumbers(const PlateShape& shape, const ShapeRate& rate = {});

  S width, thickness, poissons_ratio, curve;
  LeafFoldT<S> fold;
  /// Lines along: graded, and closer together where the leaf is thin: (P4). Lines across.
  std::vector<S> x, y;
  struct LineWidth {
    S factor = S(1), slope = S(0);
  };
  std::vector<LineWidth> line_width;  ///< PlateMesh::line_width

  /// Mid-line of the undeflected leaf at every line: straight, or an arc seen from its chord.
  std::vector<ArcPoint<S>> middle;

  const PlateShape& shape() const { return shape_; }
  bool width_varies() const { return !shape_.width_profile.empty(); }
  bool curved() const { return shape_.curve.has_value(); }
  bool folded() const { return shape_.fold.has_value(); }
  S width_factor(const S& x, int order = 0) const;
  S thickness_factor(const S& x) const;
  /// Width map in element i along, at its share s.
  WidthMap<S> map(int i, double s) const;
  /// Properties of the corner of a fold in element i along: (E14), (E15).
  struct Corner {
    S place = S(0.5);    ///< where flexibility along is missing, a share of the element
    S stiffness = S(0);  ///< what is added for it there
    S twist = S(1);      ///< how many times as much energy the twist has
    S mass = S(1);       ///< how many times as heavy it is
  };
  Corner corner(int i) const;

  /// Geometry of the undeflected leaf in element i along, at its share s: r,xx = along r,x + normal
  /// n.
  struct Rest {
    S metric = S(1);  ///< |r,x|²
    S along = S(0), normal = S(0);
  };
  Rest rest(int i, double s) const;
  /// Curvature of the undeflected leaf in element i at s, with the sign for fibres on the side of
  /// the normal: −r,xx · n / |n|.
  S rest_curvature(int i, double s) const;
  /// Tangent r,x of the undeflected leaf in element i at s, along the chord and normal to it.
  std::array<S, 2> rest_tangent(int i, double s) const;
  /// Nodal values (r, r,x, r,y, r,xy) of a node of the undeflected leaf, from the middle of the
  /// line and in its axes; and from the base, in the axes of the chord.
  std::array<Vector3<S>, 4> reference_node(int line, int node) const;
  std::array<Vector3<S>, 4> undeflected_node(int line, int node) const;

  struct Membrane {
    S A11 = S(0), A12 = S(0), A33 = S(0);
  };
  Membrane membrane() const;
  S bending_stiffness() const;  ///< PlateMesh::bending_stiffness
  /// Weights of the nodal values for the place (along, across) in [0, 1]². `derivative`: order of
  /// the derivative with respect to along and across.
  std::vector<NodalWeightT<S>> point_weights(double along, double across,
                                             std::array<int, 2> derivative = {0, 0}) const;

 private:
  std::vector<S> lines_along() const;
  /// A derivative along the undeflected leaf, of which these are the nodal functions: along the
  /// chord, and normal to it.
  std::array<S, 2> rest_along(int i, const std::array<S, 4>& functions) const;

  PlateShape shape_;
  ShapeRate rate_;
};

extern template class MeshNumbers<double>;
extern template class MeshNumbers<Dual1>;

}  // namespace flexopt
