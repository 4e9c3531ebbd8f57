#include "core/reduction/tube/strain_patterns.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace flexopt {
namespace {

// Signs of the strain components (e11, e22, 2 e12) under the half turn that maps one half of the
// leaf's width onto the other.
constexpr std::array<double, 3> turned_sign{1, 1, -1};

}  // namespace

StrainPatterns::StrainPatterns(std::array<int, 2> mesh, const std::array<MatrixXd, families>& P)
    : places_(mesh),
      along_(places_.stations_along()),
      across_(places_.half_across()),
      P_(P),
      rows_(P.begin(), P.end()) {
  for (const int kind : {0, 1}) {
    const MatrixXd &kept = P[static_cast<std::size_t>(2 * kind)],
                   &turned = P[static_cast<std::size_t>(2 * kind + 1)];
    norms_[static_cast<std::size_t>(kind)] =
        (kept.rowwise().squaredNorm() + turned.rowwise().squaredNorm()).cwiseSqrt().maxCoeff();
  }
}

MatrixXd StrainPatterns::folded(const StressPlaces& places, int family, const MatrixXd& rows) {
  const int all = places.strain_rows(), n = places.stations_along(), half = places.half_across();
  if (family == places_family) return rows.bottomRows(rows.rows() - all);
  const auto strains = rows.middleRows(family < 2 ? 0 : all / 2, all / 2);
  MatrixXd near(all / 4, rows.cols());
  for (int line = 0; line < 3 * half; ++line) {
    const double image =
        (family % 2 == 0 ? 1 : -1) * turned_sign[static_cast<std::size_t>(line / half)];
    for (int s = 0; s < n / 2; ++s)
      near.row(line * n / 2 + s) =
          strains.row(line * n + s) + image * strains.row(line * n + n - 1 - s);
  }
  return near;
}

StateTable StrainPatterns::coefficients(const StateTable& node, double thickness) const {
  StateTable found{node.sigma, MatrixXd(all(), node.even.cols()), MatrixXd(all(), node.odd.cols())};
  Eigen::Index first = 0;
  for (int f = 0; f < families; ++f) {
    const double scale = f < 2 ? 1 / thickness : f < places_family ? 0.5 : 1;
    const MatrixXd& P = P_[static_cast<std::size_t>(f)];
    found.even.middleRows(first, P.cols()) = scale * P.transpose() * folded(places_, f, node.even);
    found.odd.middleRows(first, P.cols()) = scale * P.transpose() * folded(places_, f, node.odd);
    first += P.cols();
  }
  return found;
}

MatrixXd StrainPatterns::strains_of(const MatrixXd& a, double thickness) const {
  assert(a.rows() == strains());
  const Eigen::Index lines = 3 * across_, n = along_, near = lines * n / 2;
  MatrixXd rows(2 * lines * n, a.cols());
  Eigen::Index first = 0;
  for (const int kind : {0, 1}) {
    const double scale = kind == 0 ? thickness : 2;
    std::array<MatrixXd, 2> sums;
    for (const int turned : {0, 1}) {
      const PatternRows& P = of(2 * kind + turned);
      sums[static_cast<std::size_t>(turned)] =
          P.times(0, near, scale * a.middleRows(first, P.patterns()));
      first += P.patterns();
    }
    for (Eigen::Index c = 0; c < a.cols(); ++c)
      for (Eigen::Index line = 0; line < lines; ++line) {
        const auto kept = sums[0].col(c).segment(line * n / 2, n / 2),
                   turned = sums[1].col(c).segment(line * n / 2, n / 2);
        auto whole = rows.col(c).segment((kind * lines + line) * n, n);
        whole.head(n / 2) = kept + turned;
        whole.tail(n / 2).reverse() =
            turned_sign[static_cast<std::size_t>(line / across_)] * (kept - turned);
      }
  }
  return rows;
}

MatrixXd StrainPatterns::places_of(Eigen::Index first, Eigen::Index count,
                                   const MatrixXd& a) const {
  return of(places_family).times(first, count, a);
}

}  // namespace flexopt
