#pragma once
// Placement of the items of a design file: frames in frames, mirrored parts.
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Placement of an item's frame: global place = origin + axes · place. The axes are orthonormal,
/// and left-handed where a part is mirrored.
template <class S>
struct Placement {
  Vector3<S> origin = Vector3<S>::Zero();
  Matrix3<S> axes = Matrix3<S>::Identity();
  bool mirrored = false;
  bool plain = true;  ///< that of the file: nothing to compute, nothing to round
  bool fixed = true;  ///< no parameter turns it

  Vector3<S> direction(const Vector3<S>& v) const {
    return plain ? v : Vector3<S>(axes.lazyProduct(v));
  }
  Vector3<S> place(const Vector3<S>& v) const {
    return plain ? v : Vector3<S>(origin + direction(v));
  }
  /// The direction of a leaf's width: its normal is reflected with the leaf, not against it.
  Vector3<S> across(const Vector3<S>& v) const {
    return mirrored ? Vector3<S>(-direction(v)) : direction(v);
  }
  Matrix3<S> tensor(const Matrix3<S>& t) const {
    if (plain) return t;
    const Matrix3<S> left = axes.lazyProduct(t);
    return left.lazyProduct(axes.transpose());
  }
  Placement inside(const Vector3<S>& at, const Matrix3<S>& turned, bool reflects) const {
    Placement inner;
    inner.origin = place(at);
    inner.axes = plain ? turned : Matrix3<S>(axes.lazyProduct(turned));
    inner.mirrored = mirrored != reflects;
    inner.plain = false;
    inner.fixed = fixed;
    return inner;
  }
};

template <class S>
Matrix3<S> turn_about(int axis, const S& angle) {
  using std::cos, std::sin;
  const int j = (axis + 1) % 3, k = (axis + 2) % 3;
  Matrix3<S> turn = Matrix3<S>::Identity();
  turn(j, j) = turn(k, k) = cos(angle);
  turn(k, j) = sin(angle);
  turn(j, k) = -turn(k, j);
  return turn;
}

}  // namespace flexopt
