#include "core/reduction/tube/tube_stress.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "core/math/polynomial.hpp"
#include "core/math/two_point_hermite.hpp"

namespace flexopt {
namespace {

// In the mirrors across the width (y) and in the thickness (z).
constexpr std::array<double, 6> strain_in_width{1, 1, -1, 1, 1, -1},
    strain_in_thickness{1, 1, 1, -1, -1, -1};
constexpr std::array<double, 3> place_in_width{1, -1, 1}, place_in_thickness{1, 1, -1};

const MonomialTable& stress_monomials(int degree) {
  return degree == 2 ? monomials<6, 2>() : monomials<6, 3>();
}

// Monomials by their parity in (φ, M1, M2), which the mirror across the width turns.
std::vector<int> of_parity(const MonomialTable& table, bool even) {
  std::vector<int> found;
  for (int k = 0; k < table.size(); ++k) {
    const auto e = table.exponents(k);
    if (((e[2] + e[4] + e[5]) % 2 == 0) == even) found.push_back(k);
  }
  return found;
}
const std::vector<int>& parity_columns(int degree, bool even) {
  static const std::vector<int> columns[2][2] = {
      {of_parity(monomials<6, 2>(), false), of_parity(monomials<6, 2>(), true)},
      {of_parity(monomials<6, 3>(), false), of_parity(monomials<6, 3>(), true)}};
  return columns[degree - 2][even];
}

// The interpolating polynomial through up to four of the points about x: first index and weights.
struct Lagrange {
  int first, count;
  std::array<double, 4> weight{};
};
Lagrange lagrange(const std::vector<double>& points, double x) {
  const int n = static_cast<int>(points.size());
  Lagrange l{0, std::min(n, 4)};
  while (l.first + l.count < n && points[l.first + l.count / 2] < x) ++l.first;
  for (int i = 0; i < l.count; ++i) {
    l.weight[i] = 1;
    for (int k = 0; k < l.count; ++k)
      if (k != i)
        l.weight[i] *= (x - points[l.first + k]) / (points[l.first + i] - points[l.first + k]);
  }
  return l;
}

}  // namespace

// A place among the tables, mirrored to σ ≥ 0.
struct TubeStress::Local {
  bool mirrored = false;
  int interval = 0;
  double t = 0, width = 0;
  std::array<double, 5> z{};
};

// Factors of the Taylor coefficients of both neighbours.
struct TubeStress::Weights {
  std::array<VectorXd, 2> even, odd;

  Weights& operator-=(const Weights& b) {
    for (int end : {0, 1}) {
      even[end] -= b.even[end];
      odd[end] -= b.odd[end];
    }
    return *this;
  }
};

// Values of rows on the half that is tabulated: even + odd; on the other one they follow from
// even − odd.
struct TubeStress::Parts {
  VectorXd even, odd;
};

TubeStress::TubeStress(const PlateShape& shape, double force_centre)
    : shape_(shape), places_(shape), force_centre_(force_centre) {}

void TubeStress::add(const MatrixXd& coefficients, double sigma) {
  assert(nodes_.empty() ? sigma == 0 : sigma > nodes_.back().sigma);
  assert(coefficients.rows() == places_.rows());
  degree_ = coefficients.cols() == monomial_count(6, 2) ? 2 : 3;
  const auto columns = [&](bool even) {
    const std::vector<int>& which = parity_columns(degree_, even);
    MatrixXd part(coefficients.rows(), which.size());
    for (std::size_t k = 0; k < which.size(); ++k)
      part.col(static_cast<Eigen::Index>(k)) = coefficients.col(which[k]);
    return part;
  };
  nodes_.push_back({sigma, columns(true), columns(false)});
}

TubeStress::Local TubeStress::locate(const Place& place) const {
  assert(nodes_.size() >= 2);
  Local at;
  at.mirrored = place.sigma < 0;
  const double side = at.mirrored ? -1 : 1, sigma = side * place.sigma;
  const int last = static_cast<int>(nodes_.size()) - 2;
  while (at.interval < last && sigma > nodes_[at.interval + 1].sigma) ++at.interval;
  at.width = nodes_[at.interval + 1].sigma - nodes_[at.interval].sigma;
  at.t = (sigma - nodes_[at.interval].sigma) / at.width;
  at.z = {side * place.tau, side * place.twist, place.f[0] - force_centre_, place.f[1], place.f[2]};
  return at;
}

// To a total degree.
TubeStress::Weights TubeStress::weights(const Local& at, int total) const {
  const MonomialTable& table = stress_monomials(degree_);
  std::array<HermiteWeights, HermiteWeights::most + 1> joined;
  for (int q = 1; q <= total + 1; ++q) joined[q] = two_point_hermite(q, at.t);
  Weights w;
  for (const bool even : {true, false}) {
    const std::vector<int>& columns = parity_columns(degree_, even);
    VectorXd a = VectorXd::Zero(columns.size()), b = a;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const auto e = table.exponents(columns[c]);
      const int q = total + 1 - (table.degree(columns[c]) - e[0]);
      if (q <= e[0]) continue;
      double factor = 1;
      for (int p = 0; p < e[0]; ++p) factor *= at.width;
      for (int v = 0; v < 5; ++v)
        for (int p = 0; p < e[1 + v]; ++p) factor *= at.z[v];
      const auto row = static_cast<Eigen::Index>(c);
      a[row] = factor * joined[q].a[e[0]];
      b[row] = factor * joined[q].b[e[0]];
    }
    (even ? w.even : w.odd) = {a, b};
  }
  return w;
}

TubeStress::Parts TubeStress::read(const Local& at, const Weights& w, Eigen::Index first,
                                   Eigen::Index rows) const {
  const Node &a = nodes_[at.interval], &b = nodes_[at.interval + 1];
  Parts parts{a.even.middleRows(first, rows) * w.even[0], a.odd.middleRows(first, rows) * w.odd[0]};
  parts.even.noalias() += b.even.middleRows(first, rows) * w.even[1];
  parts.odd.noalias() += b.odd.middleRows(first, rows) * w.odd[1];
  return parts;
}

// Of the whole leaf, as of StrainField.
MatrixXd TubeStress::strains(const Local& at, const Weights& w) const {
  const Parts parts = read(at, w, 0, places_.strain_rows());
  const Eigen::Index n = places_.stations_along(), half = places_.half_across(), across = 2 * half;
  MatrixXd values(n * across, 6);
  for (Eigen::Index k = 0; k < 6; ++k) {
    const double sign = at.mirrored ? strain_in_thickness[k] : 1, image = sign * strain_in_width[k];
    const auto even = parts.even.segment(k * n * half, n * half),
               odd = parts.odd.segment(k * n * half, n * half);
    values.col(k).head(n * half) = sign * (even + odd);
    for (Eigen::Index j = 0; j < half; ++j)
      values.col(k).segment(n * (across - 1 - j), n) =
          image * (even.segment(n * j, n) - odd.segment(n * j, n));
  }
  return values;
}

TubeStress::Answer TubeStress::evaluate(const Place& place) const {
  const Local at = locate(place);
  Weights w = weights(at, degree_);
  MatrixXd here = strains(at, w);
  w -= weights(at, degree_ - 1);
  const Eigen::ArrayXd thickness = Eigen::ArrayXd::Constant(here.rows(), shape_.thickness);
  const auto largest = [&](const MatrixXd& e) {
    const SurfaceStresses s = surface_stresses(e, thickness, shape_.poissons_ratio, 1);
    return std::max(s.positive.maxCoeff(), s.negative.maxCoeff());
  };
  constexpr double rounding = 1e-9;  // stress over Young's modulus that is none
  const double change = largest(strains(at, w)) / (largest(here) + rounding);
  return {{places_.x, places_.y, std::move(here)}, change};
}

// `parts`: of all rows of places.
Vector3d TubeStress::node_place(const Local& at, const Parts& parts, int line, int node) const {
  const int all = static_cast<int>(places_.nodes.size()), half = places_.half_nodes();
  const bool image = node >= half;
  const int row = 3 * (line * half + (image ? all - 1 - node : node));
  Vector3d r;
  for (int c = 0; c < 3; ++c)
    r[c] = (at.mirrored ? place_in_thickness[c] : 1) * (image ? place_in_width[c] : 1) *
           (parts.even[row + c] + (image ? -1 : 1) * parts.odd[row + c]);
  return r;
}

std::vector<Vector3d> TubeStress::nodes(const Place& place) const {
  const Local at = locate(place);
  const int first = places_.strain_rows();
  const Parts parts = read(at, weights(at, degree_), first, places_.rows() - first);
  std::vector<Vector3d> all;
  for (std::size_t j = 0; j < places_.nodes.size(); ++j)
    for (std::size_t i = 0; i < places_.lines.size(); ++i)
      all.push_back(node_place(at, parts, static_cast<int>(i), static_cast<int>(j)));
  return all;
}

Vector3d TubeStress::material_point(const Place& place, double along, double across) const {
  const Local at = locate(place);
  const Lagrange x = lagrange(places_.lines, along),
                 y = lagrange(places_.nodes, (across - 0.5) * shape_.width);
  const int per_line = 3 * places_.half_nodes();
  const Parts parts = read(at, weights(at, degree_), places_.strain_rows() + per_line * x.first,
                           per_line * x.count);
  Vector3d r = Vector3d::Zero();
  for (int i = 0; i < x.count; ++i)
    for (int j = 0; j < y.count; ++j)
      r += x.weight[i] * y.weight[j] * node_place(at, parts, i, y.first + j);
  return r;
}

}  // namespace flexopt
