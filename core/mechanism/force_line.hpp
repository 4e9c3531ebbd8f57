#pragma once
// The force of a spring over its length as a smooth curve through a table, in numbers of any kind.
#include <array>

#include "core/math/rate.hpp"

namespace flexopt {

/// Energy [J], force [N] and stiffness [N/m] of a spring along its length.
template <class T>
struct Pull {
  T energy{}, force{}, stiffness{};
};

/// A table of `count` lengths [m], ascending, and forces [N], which `point` reads as they are
/// needed: no copy is allocated. Between two lengths the force is a cubic that rises or falls as
/// the table does there (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984): its slope at a
/// length is a harmonic mean of those of the secants on either side, zero where these differ in
/// sign. At the ends it is that of the secant; beyond them the force is straight.
template <class T, class Read>
struct ForceLine {
  const Read& point;  ///< (i) → length and force
  int count;

  T secant(int i) const {
    const auto a = point(i), b = point(i + 1);
    return (b[1] - a[1]) / (b[0] - a[0]);
  }
  T slope(int i) const {
    if (i == 0) return secant(0);
    const T left = secant(i - 1);
    if (i == count - 1) return left;
    const T right = secant(i);
    if (plain(left) * plain(right) <= 0) return T(0.0);
    const T before = point(i)[0] - point(i - 1)[0], after = point(i + 1)[0] - point(i)[0];
    return 3.0 * (before + after) /
           ((before + 2.0 * after) / left + (2.0 * before + after) / right);
  }
  /// Adds the part t, 0 … 1, of the interval behind point i.
  void go(int i, const T& t, Pull<T>& to) const {
    const auto a = point(i), b = point(i + 1);
    const T h = b[0] - a[0], m = h * slope(i), n = h * slope(i + 1), rise = b[1] - a[1],
            c = 3.0 * rise - 2.0 * m - n, d = m + n - 2.0 * rise;  // a + m t + c t² + d t³
    to.energy = to.energy + h * t * (a[1] + t * (0.5 * m + t * (c / 3.0 + t * (0.25 * d))));
    to.force = a[1] + t * (m + t * (c + t * d));
    to.stiffness = (m + t * (2.0 * c + t * (3.0 * d))) / h;
  }
  Pull<T> at(const T& length) const {
    Pull<T> r;
    int i = 0;
    for (; i + 1 < count && plain(length) > plain(point(i + 1)[0]); ++i) go(i, T(1.0), r);
    const auto from = point(i);
    if (i + 1 < count && plain(length) >= plain(from[0])) {
      go(i, (length - from[0]) / (point(i + 1)[0] - from[0]), r);
      return r;
    }
    const T beyond = length - from[0];
    r.stiffness = slope(i);
    r.force = from[1] + r.stiffness * beyond;
    r.energy = r.energy + beyond * (from[1] + 0.5 * r.stiffness * beyond);
    return r;
  }
};

}  // namespace flexopt
