#include "core/reduction/tube/tube_stress.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/math/polynomial.hpp"
#include "core/reduction/tube/table_sums.hpp"

namespace flexopt {
namespace {

// In the mirrors across the width (y) and in the thickness (z).
constexpr std::array<double, 6> strain_in_width{1, 1, -1, 1, 1, -1},
    strain_in_thickness{1, 1, 1, -1, -1, -1};
constexpr std::array<double, 3> place_in_width{1, -1, 1}, place_in_thickness{1, 1, -1};

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
  std::size_t interval = 0;
  double sigma = 0;
  std::array<double, 5> z{};
};

TubeStress::TubeStress(const PlateShape& shape, double force_centre, TubeView view,
                       std::shared_ptr<const PatternRows> patterns)
    : shape_(shape),
      places_(shape),
      view_(view),
      force_centre_(force_centre),
      patterns_(std::move(patterns)) {
  assert(!patterns_ || patterns_->rows() == places_.rows());
  const Eigen::Index half = places_.strain_rows() / 2;
  if (patterns_)
    pattern_norms_ = {patterns_->largest_norm(0, half), patterns_->largest_norm(half, half)};
}

StateTable stress_node(const ChordLeaf& leaf, double sigma, const Eigen::Matrix2d& ray,
                       const MatrixXd& fields) {
  const MatrixXd all = expand_stress(leaf, ray, fields.leftCols(monomial_count(6, 2)));
  StateTable node{sigma, MatrixXd(all.rows(), StateTable::even_monomials),
                  MatrixXd(all.rows(), StateTable::odd_monomials)};
  for (Eigen::Index k = 0; k < node.even.cols(); ++k)
    node.even.col(k) = all.col(even_monomials()[static_cast<std::size_t>(k)].number);
  for (Eigen::Index k = 0; k < node.odd.cols(); ++k)
    node.odd.col(k) = all.col(odd_monomials()[static_cast<std::size_t>(k)].number);
  return node;
}

void TubeStress::add(StateTable node) {
  assert(nodes_.empty() ? node.sigma == 0 : node.sigma > nodes_.back().sigma);
  assert(node.even.rows() == (patterns_ ? patterns_->patterns() : places_.rows()));
  nodes_.push_back(std::move(node));
}

TubeStress::Local TubeStress::locate(const Place& place) const {
  assert(nodes_.size() >= 2);
  Local at;
  at.mirrored = place.sigma < 0;
  const double side = at.mirrored ? -1 : 1;
  at.sigma = side * place.sigma;
  while (at.interval + 2 < nodes_.size() && at.sigma > nodes_[at.interval + 1].sigma) ++at.interval;
  at.z = {side * place.tau, side * place.twist, place.f[0] - force_centre_, place.f[1], place.f[2]};
  if (view_.from_tip) std::swap(at.z[3], at.z[4]);
  if (view_.mirrored) at.z[1] *= -1;
  return at;
}

// To a total degree.
TubeStress::Weights TubeStress::weights(const Local& at, int total) const {
  return state_weights(nodes_[at.interval].sigma, nodes_[at.interval + 1].sigma, at.sigma, at.z,
                       total);
}

// About a flat leaf the mirror in the thickness forbids half of the monomials, which compression
// leaves a little of; and it is not strained. `weights`: a row for each monomial.
template <class Monomials, class W>
void TubeStress::keep_flat(const Monomials& monomials, Kind kind, W& weights) {
  for (std::size_t k = 0; k < monomials.size(); ++k)
    if (monomials[k].turned() != (kind == Kind::bending))
      weights.row(static_cast<Eigen::Index>(k)).setZero();
  if (monomials[0].number == 0 && kind != Kind::place) weights.row(0).setZero();
}

template <std::size_t sets>
MatrixXd TubeStress::coefficients(const Local& at, const std::array<Weights, sets>& weights,
                                  Kind kind) const {
  MatrixXd sum = MatrixXd::Zero(nodes_[at.interval].even.rows(), 2 * sets);
  for (const std::size_t end : {0, 1}) {
    const StateTable& node = nodes_[at.interval + end];
    Eigen::Matrix<double, StateTable::even_monomials, sets> even;
    Eigen::Matrix<double, StateTable::odd_monomials, sets> odd;
    for (std::size_t k = 0; k < sets; ++k) {
      even.col(static_cast<Eigen::Index>(k)) = weights[k].even[end];
      odd.col(static_cast<Eigen::Index>(k)) = weights[k].odd[end];
    }
    if (node.sigma == 0) {
      keep_flat(even_monomials(), kind, even);
      keep_flat(odd_monomials(), kind, odd);
    }
    add_table_sums(node.even, even, 1, sum.leftCols(sets));
    add_table_sums(node.odd, odd, 1, sum.rightCols(sets));
  }
  return sum;
}

MatrixXd TubeStress::read(const Local& at, const Weights& w, Eigen::Index first,
                          Eigen::Index rows) const {
  MatrixXd parts(rows, 2);
  if (!patterns_) {
    const StateTable &a = nodes_[at.interval], &b = nodes_[at.interval + 1];
    auto even = parts.col(0), odd = parts.col(1);
    even.noalias() = a.even.middleRows(first, rows) * w.even[0];
    even.noalias() += b.even.middleRows(first, rows) * w.even[1];
    odd.noalias() = a.odd.middleRows(first, rows) * w.odd[0];
    odd.noalias() += b.odd.middleRows(first, rows) * w.odd[1];
    return parts;
  }
  const std::array<Weights, 1> weights{w};
  const Eigen::Index half = places_.strain_rows() / 2;
  const auto fill = [&](Eigen::Index begin, Eigen::Index end, Kind kind, double scale) {
    begin = std::max(begin, first);
    end = std::min(end, first + rows);
    if (begin >= end) return;
    parts.middleRows(begin - first, end - begin) =
        patterns_->times(begin, end - begin, scale * coefficients(at, weights, kind));
  };
  fill(0, half, Kind::stretching, shape_.thickness);
  fill(half, 2 * half, Kind::bending, 2);
  fill(2 * half, places_.rows(), Kind::place, 1);
  if (first + rows <= 2 * half) return parts;
  const Eigen::Index places = std::max(first, 2 * half), end = first + rows;
  const MatrixXd turned =
      patterns_->times(places, end - places, coefficients(at, weights, Kind::bending));
  for (Eigen::Index row = places; row < end; ++row)
    if ((row - 2 * half) % 3 == 2)
      parts.row(row - first) = turned.row(row - places);  // off the plane
  return parts;
}

// Of the whole leaf, as of StrainField.
MatrixXd TubeStress::strains(const Local& at, const Parts& parts) const {
  const Eigen::Index n = places_.stations_along(), half = places_.half_across(), across = 2 * half;
  MatrixXd values(n * across, 6);
  for (Eigen::Index k = 0; k < 6; ++k) {
    const bool seen_mirrored = at.mirrored != view_.mirrored;
    const double sign = seen_mirrored ? strain_in_thickness[k] : 1,
                 image = sign * strain_in_width[k];
    const auto even = parts.col(0).segment(k * n * half, n * half),
               odd = parts.col(1).segment(k * n * half, n * half);
    values.col(k).head(n * half) = sign * (even + odd);
    for (Eigen::Index j = 0; j < half; ++j)
      values.col(k).segment(n * (across - 1 - j), n) =
          image * (even.segment(n * j, n) - odd.segment(n * j, n));
    if (view_.from_tip) values.col(k).reverseInPlace();
  }
  return values;
}

// |P a| ≤ |P| |a| for each strain; von Mises stress is convex, so that it is largest at a corner of
// the box that all strains are in.
double TubeStress::stress_bound(double stretching, double bending) const {
  const double nu = shape_.poissons_ratio, plus = 1 / ((1 + nu) * (1 + nu)),
               minus = 1 / ((1 - nu) * (1 - nu)),
               most = pattern_norms_[0] * stretching + pattern_norms_[1] * bending;
  return shape_.thickness * most * std::sqrt(std::max(minus, 3 * plus) + 0.75 * plus);
}

double TubeStress::largest(const Eigen::Ref<const MatrixXd>& strains) const {
  const Eigen::ArrayXd thickness = Eigen::ArrayXd::Constant(strains.rows(), shape_.thickness);
  const SurfaceStresses s = surface_stresses(strains, thickness, shape_.poissons_ratio, 1);
  return std::max(s.positive.maxCoeff(), s.negative.maxCoeff());
}

TubeStress::Answer TubeStress::evaluate(const Place& place) const {
  constexpr double rounding = 1e-9;  // stress over Young's modulus that is none
  const Local at = locate(place);
  std::array<Weights, 2> w{weights(at, 2), weights(at, 1)};  // what the last degree is of them
  for (const std::size_t end : {0, 1}) {
    w[1].even[end] = w[0].even[end] - w[1].even[end];
    w[1].odd[end] = w[0].odd[end] - w[1].odd[end];
  }
  const Eigen::Index rows = places_.strain_rows(), half = rows / 2;
  const auto true_change = [&](double size) {
    return largest(strains(at, read(at, w[1], 0, rows))) / size;
  };
  if (!patterns_) {
    MatrixXd here = strains(at, read(at, w[0], 0, rows));
    const double change = true_change(largest(here) + rounding);
    return {{places_.x, places_.y, std::move(here)}, change};
  }
  MatrixXd parts(rows, 2);
  std::array<double, 2> last{};  // of the coefficients of the last degree: their norms
  for (const Kind kind : {Kind::stretching, Kind::bending}) {
    const bool bending = kind == Kind::bending;
    const MatrixXd a = coefficients(at, w, kind);  // even, even, odd, odd
    parts.middleRows(bending ? half : 0, half) = patterns_->times(
        bending ? half : 0, half, (bending ? 2 : shape_.thickness) * a(Eigen::all, {0, 2}));
    // κ: 2 P a, at half the thickness
    last[bending ? 1 : 0] = a.col(1).norm() + a.col(3).norm();
  }
  MatrixXd here = strains(at, parts);
  const double bound = stress_bound(last[0], last[1]);
  // at its ends a leaf is often stressed most: as bounds go, that will do
  const Eigen::Index n = places_.stations_along(), across = here.rows() / n;
  MatrixXd ends(2 * across, 6);
  for (Eigen::Index j = 0; j < across; ++j) {
    ends.row(2 * j) = here.row(n * j);
    ends.row(2 * j + 1) = here.row(n * j + n - 1);
  }
  double change = bound / (largest(ends) + rounding);
  if (!(change <= largest_stress_change)) {
    const double size = largest(here) + rounding;
    change = bound / size;
    if (!(change <= largest_stress_change)) change = true_change(size);
  }
  return {{places_.x, places_.y, std::move(here)}, change};
}

TubeStress::Slopes::Slopes(const TubeStress& tables, const Place& place,
                           const StressRateSource& rates)
    : tables_(&tables) {
  assert(tables.patterns_);
  const Local at = tables.locate(place);
  mirrored_ = at.mirrored;
  const StateWeightSlopes weights = state_weight_slopes(
      tables.nodes_[at.interval].sigma, tables.nodes_[at.interval + 1].sigma, at.sigma, at.z);
  const StressRates by_shape = rates(at.interval, tables.weights(at, 2));
  const Eigen::Index patterns = tables.patterns_->patterns();
  for (const bool bending : {false, true}) {
    const std::array<MatrixXd, 2>& shape = bending ? by_shape.bending : by_shape.membrane;
    const double scale = bending ? 2 : tables.shape_.thickness;
    std::array<MatrixXd, 2> sum{MatrixXd::Zero(patterns, 7), MatrixXd::Zero(patterns, 7)};
    for (const std::size_t end : {0, 1}) {
      const StateTable& node = tables.nodes_[at.interval + end];
      auto even = weights.even[end];
      auto odd = weights.odd[end];
      if (node.sigma == 0) {
        keep_flat(even_monomials(), bending ? Kind::bending : Kind::stretching, even);
        keep_flat(odd_monomials(), bending ? Kind::bending : Kind::stretching, odd);
      }
      add_table_sums(node.even, even, scale, sum[0]);
      add_table_sums(node.odd, odd, scale, sum[1]);
    }
    for (const bool image : {false, true}) {
      Terms& terms = terms_[image][bending];
      const double odd = image ? -1 : 1;
      terms.resize(10, patterns);
      terms.topRows<7>() = (sum[0] + odd * sum[1]).transpose();
      terms.bottomRows<3>() = (shape[0] + odd * shape[1]).transpose();
    }
  }
}

auto TubeStress::Slopes::rows(const Terms& terms, Eigen::Index first, Eigen::Index step) const
    -> Eigen::Matrix<double, 10, 3> {
  const PatternRows& P = *tables_->patterns_;
  const std::array<const double*, 3> row{P.row(first), P.row(first + step),
                                         P.row(first + 2 * step)};
  // even and odd patterns apart: one sum need not wait for the other
  std::array<Eigen::Matrix<double, 10, 3>, 2> sums{Eigen::Matrix<double, 10, 3>::Zero(),
                                                   Eigen::Matrix<double, 10, 3>::Zero()};
  for (Eigen::Index k = 0; k < P.patterns(); ++k)
    for (int j = 0; j < 3; ++j)
      sums[static_cast<std::size_t>(k % 2)].col(j) +=
          row[static_cast<std::size_t>(j)][k] * terms.col(k);
  return sums[0] + sums[1];
}

auto TubeStress::Slopes::at(int along, int across) const -> Station {
  const StressPlaces& places = tables_->places_;
  const TubeView view = tables_->view_;
  const int n = places.stations_along(), half = places.half_across();
  if (view.from_tip) {
    along = n - 1 - along;
    across = 2 * half - 1 - across;
  }
  const bool image = across >= half;
  Eigen::Matrix<double, 6, 10> all;  // value, by the state of the tables, by the shape
  for (const bool bending : {false, true}) {
    const Eigen::Index step = static_cast<Eigen::Index>(n) * half,
                       first = along + n * (image ? 2 * half - 1 - across : across) +
                               (bending ? 3 * step : 0);
    all.middleRows<3>(bending ? 3 : 0) = rows(terms_[image][bending], first, step).transpose();
  }
  for (int k = 0; k < 6; ++k) {
    if (mirrored_ != view.mirrored) all.row(k) *= strain_in_thickness[static_cast<std::size_t>(k)];
    if (image) all.row(k) *= strain_in_width[static_cast<std::size_t>(k)];
  }
  // from the state of the tables to the place
  if (mirrored_) all.middleCols<3>(1) *= -1;
  if (view.mirrored) all.col(3) *= -1;
  if (view.from_tip) all.col(5).swap(all.col(6));
  return {all.col(0), all.rightCols<9>()};
}

// `parts`: of all rows of places.
Vector3d TubeStress::node_place(const Local& at, const Parts& parts, int line, int node) const {
  const int all = static_cast<int>(places_.nodes.size()), half = places_.half_nodes();
  const bool image = node >= half;
  const int row = 3 * (line * half + (image ? all - 1 - node : node));
  Vector3d r;
  for (int c = 0; c < 3; ++c)
    r[c] = (at.mirrored ? place_in_thickness[c] : 1) * (image ? place_in_width[c] : 1) *
           (parts(row + c, 0) + (image ? -1 : 1) * parts(row + c, 1));
  return r;
}

Vector3d TubeStress::seen(const Vector3d& r) const {
  const double turned = view_.from_tip ? -1 : 1;
  return {turned * r[0], turned * r[1], view_.mirrored ? -r[2] : r[2]};
}

std::vector<Vector3d> TubeStress::nodes(const Place& place) const {
  const Local at = locate(place);
  const int first = places_.strain_rows();
  const Weights w = weights(at, 2);
  const MatrixXd parts = read(at, w, first, places_.rows() - first);
  std::vector<Vector3d> all;
  for (int j = 0; j < static_cast<int>(places_.nodes.size()); ++j)
    for (int i = 0; i < static_cast<int>(places_.lines.size()); ++i)
      all.push_back(seen(node_place(at, parts, i, j)));
  if (view_.from_tip) std::reverse(all.begin(), all.end());
  return all;
}

Vector3d TubeStress::material_point(const Place& place, double along, double across) const {
  const Local at = locate(place);
  const double turned = view_.from_tip ? -1 : 1;
  const Lagrange x = lagrange(places_.lines, view_.from_tip ? 1 - along : along),
                 y = lagrange(places_.nodes, turned * (across - 0.5) * shape_.width);
  const int per_line = 3 * places_.half_nodes();
  const Weights w = weights(at, 2);
  const MatrixXd parts =
      read(at, w, places_.strain_rows() + per_line * x.first, per_line * x.count);
  Vector3d r = Vector3d::Zero();
  for (int i = 0; i < x.count; ++i)
    for (int j = 0; j < y.count; ++j)
      r += x.weight[i] * y.weight[j] * node_place(at, parts, i, y.first + j);
  return seen(r);
}

}  // namespace flexopt
