#include "core/reduction/tube/tube_stress.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/math/chebyshev.hpp"
#include "core/math/polynomial.hpp"
#include "core/reduction/tube/table_sums.hpp"

namespace flexopt {
namespace {

// Signs of the strains (e, κ) and of the coordinates of places in the mirrors across the width (y)
// and in the thickness (z).
constexpr std::array<double, 6> strain_in_width{1, 1, -1, 1, 1, -1},
    strain_in_thickness{1, 1, 1, -1, -1, -1};
constexpr std::array<double, 3> place_in_width{1, -1, 1}, place_in_thickness{1, 1, -1};

// The interpolating polynomial through up to four of the points about x: first index and weights.
struct Lagrange {
  int first;
  std::vector<double> weight;
};
Lagrange lagrange(const std::vector<double>& points, double x) {
  const int n = static_cast<int>(points.size()), count = std::min(n, 4);
  int first = 0;
  while (first + count < n && points[first + count / 2] < x) ++first;
  const auto begin = points.begin() + first;
  return {first, polynomial_weights({begin, begin + count}, x).value};
}

}  // namespace

TubeStress::TubeStress(const PlateShape& shape, double force_centre, TubeView view,
                       std::shared_ptr<const StrainPatterns> patterns)
    : shape_(shape),
      places_(shape),
      view_(view),
      force_centre_(force_centre),
      patterns_(std::move(patterns)) {}

StateTable stress_node(const ChordLeaf& leaf, double sigma, const Eigen::Matrix2d& ray,
                       const MatrixXd& fields) {
  const MatrixXd all = expand_stress(leaf, ray, fields.leftCols(monomial_count(6, 2)));
  constexpr auto& evens = even_monomials<StateTable::even_of_stress>;
  StateTable node{sigma, MatrixXd(all.rows(), StateTable::even_of_stress),
                  MatrixXd(all.rows(), StateTable::odd_monomials)};
  for (Eigen::Index k = 0; k < node.even.cols(); ++k)
    node.even.col(k) = all.col(evens()[static_cast<std::size_t>(k)].number);
  for (Eigen::Index k = 0; k < node.odd.cols(); ++k)
    node.odd.col(k) = all.col(odd_monomials()[static_cast<std::size_t>(k)].number);
  return node;
}

void TubeStress::add(StateTable node) {
  assert(nodes_.empty() ? node.sigma == 0 : node.sigma > nodes_.back().sigma);
  assert(node.even.cols() == StateTable::even_of_stress);
  assert(node.even.rows() == (patterns_ ? patterns_->all() : places_.rows()));
  nodes_.push_back(std::move(node));
}

TubeStress::Local TubeStress::locate(const Place& place) const {
  Local at = TubeDynamics::locate_among(
      nodes_, [](const StateTable& n) { return n.sigma; }, place, force_centre_);
  if (view_.from_tip) std::swap(at.z[3], at.z[4]);
  if (view_.mirrored) at.z[1] *= -1;
  return at;
}

// Weights of the coefficients to a total degree.
TubeStress::Weights TubeStress::weights(const Local& at, int total) const {
  return state_weights<StateTable::even_of_stress>(
      nodes_[at.interval].sigma, nodes_[at.interval + 1].sigma, at.sigma, at.z, total);
}

template <std::size_t sets>
MatrixXd TubeStress::coefficients(const Local& at, const std::array<Weights, sets>& weights,
                                  Eigen::Index first, Eigen::Index count) const {
  MatrixXd sum = MatrixXd::Zero(count, 2 * sets);
  for (const std::size_t end : {0, 1}) {
    const StateTable& node = nodes_[at.interval + end];
    Eigen::Matrix<double, StateTable::even_of_stress, sets> even;
    Eigen::Matrix<double, StateTable::odd_monomials, sets> odd;
    for (std::size_t k = 0; k < sets; ++k) {
      even.col(static_cast<Eigen::Index>(k)) = weights[k].even[end];
      odd.col(static_cast<Eigen::Index>(k)) = weights[k].odd[end];
    }
    add_table_sums(node.even.middleRows(first, count), even, 1, sum.leftCols(sets));
    add_table_sums(node.odd.middleRows(first, count), odd, 1, sum.rightCols(sets));
  }
  return sum;
}

MatrixXd TubeStress::read(const Local& at, const Weights& w, Eigen::Index first,
                          Eigen::Index rows) const {
  const std::array<Weights, 1> weights{w};
  if (!patterns_) return coefficients(at, weights, first, rows);
  const Eigen::Index strains = places_.strain_rows();
  if (first < strains) {
    assert(first == 0 && rows == strains);
    return patterns_->strains_of(coefficients(at, weights, 0, patterns_->strains()),
                                 shape_.thickness);
  }
  return patterns_->places_of(
      first - strains, rows,
      coefficients(at, weights, patterns_->strains(), patterns_->all() - patterns_->strains()));
}

// Strains at the stations of the whole leaf, rows as in StrainField.
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
               most = patterns_->largest_norm(false) * stretching +
                      patterns_->largest_norm(true) * bending;
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
  const Eigen::Index rows = places_.strain_rows();
  const auto true_change = [&](double size) {
    return largest(strains(at, read(at, w[1], 0, rows))) / size;
  };
  if (!patterns_) {
    MatrixXd here = strains(at, read(at, w[0], 0, rows));
    const double change = true_change(largest(here) + rounding);
    return {{places_.x, places_.y, std::move(here)}, change};
  }
  const MatrixXd a = coefficients(at, w, 0, patterns_->strains());  // even, even, odd, odd
  MatrixXd here = strains(at, patterns_->strains_of(a(Eigen::all, {0, 2}), shape_.thickness));
  const auto last = [&](const auto& rows_of) {  // of the last degree: the coefficients' norms
    return rows_of.col(1).norm() + rows_of.col(3).norm();
  };
  const Eigen::Index stretching = patterns_->stretching();
  // κ: 2 P a, at half the thickness
  const double bound =
      stress_bound(last(a.topRows(stretching)), last(a.bottomRows(a.rows() - stretching)));
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
  const auto weights = state_weight_slopes<StateTable::even_of_stress>(
      tables.nodes_[at.interval].sigma, tables.nodes_[at.interval + 1].sigma, at.sigma, at.z);
  const Eigen::Index all = tables.patterns_->strains(), stretching = tables.patterns_->stretching();
  std::array<MatrixXd, 2> sum{MatrixXd::Zero(all, 10), MatrixXd::Zero(all, 10)};
  for (const std::size_t end : {0, 1}) {
    const auto add = [&](MatrixXd StateTable::*part, const auto& w, MatrixXd& to) {
      const std::size_t node = at.interval + end;
      add_table_sums((tables.nodes_[node].*part).topRows(all), w, 1, to.leftCols<7>());
      Eigen::Index column = 7;
      for (const StateTable& rate : rates(node))
        add_table_sums((rate.*part).topRows(all), w.col(0).eval(), 1, to.middleCols<1>(column++));
    };
    add(&StateTable::even, weights.even[end], sum[0]);
    add(&StateTable::odd, weights.odd[end], sum[1]);
  }
  for (MatrixXd& part : sum) {  // e = t P a, κ = 2 P a
    const VectorXd by_thickness = part.col(0).head(stretching);
    part.topRows(stretching) *= tables.shape_.thickness;
    part.bottomRows(all - stretching) *= 2;
    part.col(8).head(stretching) += by_thickness;
  }
  for (const bool image : {false, true}) {
    const Terms terms = (sum[0] + (image ? -1.0 : 1.0) * sum[1]).transpose();
    terms_[image][false] = terms.leftCols(stretching);
    terms_[image][true] = terms.rightCols(all - stretching);
  }
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
    all.middleRows<3>(bending ? 3 : 0) =
        tables_->patterns_
            ->at<10>(along, image ? 2 * half - 1 - across : across, bending, terms_[image][bending])
            .transpose();
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
  const MatrixXd parts = read(at, w, places_.strain_rows() + per_line * x.first,
                              per_line * static_cast<Eigen::Index>(x.weight.size()));
  Vector3d r = Vector3d::Zero();
  for (std::size_t i = 0; i < x.weight.size(); ++i)
    for (std::size_t j = 0; j < y.weight.size(); ++j)
      r += x.weight[i] * y.weight[j] *
           node_place(at, parts, static_cast<int>(i), y.first + static_cast<int>(j));
  return seen(r);
}

}  // namespace flexopt
