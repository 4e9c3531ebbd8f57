#pragma once
// What the two legs of a folded leaf share at a node of the fold line: equation (E8) of
// core/elements/README.md. The second leg's derivatives of r are polynomials of the first one's and
// of four numbers of its own.
#include <array>
#include <cmath>

#include "core/math/types.hpp"

namespace flexopt {

/// A node's unknowns, or an increment of them.
template <class S>
struct FoldNode {
  Vector3<S> along, across, both;              ///< r,x, r,y and r,xy of the first leg
  S stretch, shear, stretch_rate, shear_rate;  ///< of the second: 1 + α, γ, α′, γ′
  static constexpr int unknowns = 13;          ///< in this order
  static constexpr int own = 4;                ///< of the second leg alone

  static FoldNode zero() {
    const Vector3<S> none = Vector3<S>::Zero();
    return {none, none, none, S(0), S(0), S(0), S(0)};
  }
  static FoldNode unit(int k) {
    FoldNode node = zero();
    S* const own_numbers[] = {&node.stretch, &node.shear, &node.stretch_rate, &node.shear_rate};
    Vector3<S>* const vectors[] = {&node.along, &node.across, &node.both};
    (k < 9 ? (*vectors[k / 3])[k % 3] : *own_numbers[k - 9]) = S(1);
    return node;
  }
  /// Node j of the block `x` of a fold line: the nodal values of the first leg, component by
  /// component, then the second one's own numbers. An increment.
  template <class Column>
  static FoldNode of(const Column& x, int functions, int j) {
    FoldNode node;
    for (int c = 0; c < 3; ++c) {
      node.along[c] = x[c * functions + 4 * j + 1];
      node.across[c] = x[c * functions + 4 * j + 2];
      node.both[c] = x[c * functions + 4 * j + 3];
    }
    const int first = 3 * functions + own * j;
    node.stretch = x[first];
    node.shear = x[first + 1];
    node.stretch_rate = x[first + 2];
    node.shear_rate = x[first + 3];
    return node;
  }
  /// The same of a state.
  template <class Column>
  static FoldNode state(const Column& x, int functions, int j) {
    FoldNode node = of(x, functions, j);
    node.stretch += S(1);
    return node;
  }
  /// Row of unknown k of node j in the block.
  static int row(int k, int functions, int j) {
    return k < 9 ? k % 3 * functions + 4 * j + 1 + k / 3 : 3 * functions + own * j + k - 9;
  }
};

/// r,x and r,xy of the second leg as a function of FoldNode, and its derivatives.
template <class S>
class FoldMap {
 public:
  using Pair = std::array<Vector3<S>, 2>;
  using Node = FoldNode<S>;

  /// Of a fold by this angle.
  static FoldMap of(double angle) { return {std::cos(angle), std::sin(angle)}; }
  /// Derivative of the map with the angle.
  static FoldMap rate(double angle) { return {-std::sin(angle), std::cos(angle)}; }

  Pair value(const Node& u) const { return sum(quadratic(u, u), cubic(u, u, u)); }
  /// Along y.
  Pair first(const Node& u, const Node& y) const {
    return sum(sum(quadratic(u, y), quadratic(y, u)),
               sum(sum(cubic(y, u, u), cubic(u, y, u)), cubic(u, u, y)));
  }
  /// Along y and z.
  Pair second(const Node& u, const Node& y, const Node& z) const {
    return sum(sum(quadratic(y, z), quadratic(z, y)), third(u, y, z));
  }
  /// Along all three; the same at every u.
  Pair third(const Node& x, const Node& y, const Node& z) const {
    return sum(sum(sum(cubic(x, y, z), cubic(y, z, x)), sum(cubic(z, x, y), cubic(x, z, y))),
               sum(cubic(z, y, x), cubic(y, x, z)));
  }

 private:
  FoldMap(double cosine, double sine) : cosine_(cosine), sine_(sine) {}

  static Pair sum(const Pair& a, const Pair& b) {
    return {Vector3<S>(a[0] + b[0]), Vector3<S>(a[1] + b[1])};
  }
  static Vector3<S> cross(const Vector3<S>& a, const Vector3<S>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  Pair quadratic(const Node& p, const Node& q) const {
    const S c = S(cosine_) * p.stretch, dc = S(cosine_) * p.stretch_rate;
    return {Vector3<S>(c * q.along + p.shear * q.across),
            Vector3<S>(c * q.both + dc * q.along + p.shear_rate * q.across)};
  }
  Pair cubic(const Node& p, const Node& q, const Node& r) const {
    const S s = S(sine_) * p.stretch, ds = S(sine_) * p.stretch_rate;
    const Vector3<S> normal = cross(q.along, r.across), turning = cross(q.both, r.across);
    return {Vector3<S>(s * normal), Vector3<S>(s * turning + ds * normal)};
  }

  double cosine_, sine_;
};

}  // namespace flexopt
