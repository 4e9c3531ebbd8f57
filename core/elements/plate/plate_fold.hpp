#pragma once
// Relation of the two legs of a folded leaf at a node of the fold line: equation (E8) of
// core/elements/README.md. The second leg's derivatives of r are polynomials of the first leg's
// derivatives and of four unknowns of its own.
#include <array>
#include <cmath>

#include "core/math/types.hpp"

namespace flexopt {

/// Unknowns of a node of the fold line, or an increment of them: r,x, r,y and r,xy of the first
/// leg; 1 + α, γ, α′, γ′ of the second one.
template <class S>
struct FoldNode {
  static constexpr int unknowns = 13;
  static constexpr int own = 4;  ///< of the second leg alone
  Eigen::Matrix<S, unknowns, 1> numbers;

  auto along() const { return numbers.template head<3>(); }
  auto across() const { return numbers.template segment<3>(3); }
  auto both() const { return numbers.template segment<3>(6); }
  const S& stretch() const { return numbers[9]; }
  const S& shear() const { return numbers[10]; }
  const S& stretch_rate() const { return numbers[11]; }
  const S& shear_rate() const { return numbers[12]; }

  static FoldNode unit(int k) {
    FoldNode node{Eigen::Matrix<S, unknowns, 1>::Zero()};
    node.numbers[k] = S(1);
    return node;
  }
  /// Row of unknown k of node j in the block of a fold line: the nodal values of the first leg,
  /// component by component, then the four unknowns of the second leg.
  static int row(int k, int functions, int j) {
    return k < 9 ? k % 3 * functions + 4 * j + 1 + k / 3 : 3 * functions + own * j + k - 9;
  }
  /// Node j, as an increment, of the block `x`.
  template <class Column>
  static FoldNode of(const Column& x, int functions, int j) {
    FoldNode node;
    for (int k = 0; k < unknowns; ++k) node.numbers[k] = x[row(k, functions, j)];
    return node;
  }
  /// Node j of the block `x` as a state: the stretch is then 1 + its increment.
  template <class Column>
  static FoldNode state(const Column& x, int functions, int j) {
    FoldNode node = of(x, functions, j);
    node.numbers[9] += S(1);
    return node;
  }
};

/// r,x and r,xy of the second leg as a function of FoldNode, and its derivatives.
template <class S>
class FoldMap {
 public:
  using Pair = std::array<Vector3<S>, 2>;
  using Node = FoldNode<S>;

  /// Map of a fold by this angle [rad].
  static FoldMap of(double angle) { return {std::cos(angle), std::sin(angle), 1}; }
  /// Derivative of the map with the angle.
  static FoldMap rate(double angle) { return {-std::sin(angle), std::cos(angle), 0}; }

  // the part with n is the product f C of f = (3 − |r,y|²)/2 and a cubic form
  Pair value(const Node& u) const {
    Pair sum = quadratic(u, u);
    add(sum, factor(u), cubic(u, u, u));
    return sum;
  }
  /// First derivative of the map along y.
  Pair first(const Node& u, const Node& y) const {
    Pair sum = quadratic(u, y);
    add(sum, S(1), quadratic(y, u));
    add(sum, factor(u), cubic_first(u, y));
    add(sum, factor(u, y), cubic(u, u, u));
    return sum;
  }
  /// Second derivative of the map along y and z.
  Pair second(const Node& u, const Node& y, const Node& z) const {
    Pair sum = quadratic(y, z);
    add(sum, S(1), quadratic(z, y));
    add(sum, factor(u), cubic_second(u, y, z));
    add(sum, factor(u, y), cubic_first(u, z));
    add(sum, factor(u, z), cubic_first(u, y));
    add(sum, factor(y, z), cubic(u, u, u));
    return sum;
  }
  /// Third derivative of the map along x, y and z.
  Pair third(const Node& u, const Node& x, const Node& y, const Node& z) const {
    Pair sum = zero();
    add(sum, factor(u), cubic_second(x, y, z));
    const std::array<const Node*, 3> along{&x, &y, &z};
    for (std::size_t i = 0; i < 3; ++i) {
      const Node &one = *along[i], &two = *along[(i + 1) % 3], &three = *along[(i + 2) % 3];
      add(sum, factor(u, one), cubic_second(u, two, three));
      add(sum, factor(one, two), cubic_first(u, three));
    }
    return sum;
  }

 private:
  FoldMap(double cosine, double sine, double own) : cosine_(cosine), sine_(sine), own_(own) {}

  static Pair zero() { return {Vector3<S>(Vector3<S>::Zero()), Vector3<S>(Vector3<S>::Zero())}; }
  static void add(Pair& sum, const S& by, const Pair& part) {
    for (std::size_t k = 0; k < 2; ++k)
      for (int i = 0; i < 3; ++i) sum[k][i] += by * part[k][i];
  }
  static Vector3<S> cross(const Vector3<S>& a, const Vector3<S>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  /// 1/|r,y| to the order of the line's strain, and its derivatives along y and along y and z; the
  /// second derivative does not depend on the state.
  static S factor(const Node& u) { return 1.5 - 0.5 * u.across().dot(u.across()); }
  static S factor(const Node& u, const Node& y) { return -u.across().dot(y.across()); }

  Pair quadratic(const Node& p, const Node& q) const {
    const S c = S(cosine_) * p.stretch(), dc = S(cosine_) * p.stretch_rate(),
            g = S(own_) * p.shear(), dg = S(own_) * p.shear_rate();
    return {Vector3<S>(c * q.along() + g * q.across()),
            Vector3<S>(c * q.both() + dc * q.along() + dg * q.across())};
  }
  Pair cubic(const Node& p, const Node& q, const Node& r) const {
    const S s = S(sine_) * p.stretch(), ds = S(sine_) * p.stretch_rate();
    const Vector3<S> normal = cross(q.along(), r.across()), turning = cross(q.both(), r.across());
    return {Vector3<S>(s * normal), Vector3<S>(s * turning + ds * normal)};
  }
  Pair cubic_first(const Node& u, const Node& y) const {
    Pair sum = cubic(y, u, u);
    add(sum, S(1), cubic(u, y, u));
    add(sum, S(1), cubic(u, u, y));
    return sum;
  }
  Pair cubic_second(const Node& u, const Node& y, const Node& z) const {
    Pair sum = cubic(u, y, z);
    add(sum, S(1), cubic(y, z, u));
    add(sum, S(1), cubic(z, u, y));
    add(sum, S(1), cubic(u, z, y));
    add(sum, S(1), cubic(z, y, u));
    add(sum, S(1), cubic(y, u, z));
    return sum;
  }

  double cosine_, sine_, own_;
};

}  // namespace flexopt
