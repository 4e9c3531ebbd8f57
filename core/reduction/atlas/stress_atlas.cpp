#include "core/reduction/atlas/stress_atlas.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <random>

#include "core/math/decompositions.hpp"
#include "core/reduction/atlas/expanded_leaf.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"
#include "core/reduction/atlas/table_parts.hpp"

namespace flexopt {
namespace {

constexpr Eigen::Index even_columns = StateTable::even_monomials,
                       odd_columns = StateTable::odd_monomials;

// One for each monomial, the even ones first: how much of the stress about a bent state an error of
// 1 in the coefficient of a pattern is, where states lie as far from it as they usually do.
VectorXd monomial_weights(double sigma) {
  constexpr double least = 0.015;  // [rad], of a state near the flat leaf
  const double bent = std::max(sigma, least), along = 0.3 * bent + 0.01;
  const std::array<double, 5> far{0.02 + 0.1 * sigma, 0.01, 4, 2, 2};  // τ, φ, N, M1, M2
  VectorXd weights(even_columns + odd_columns);
  Eigen::Index row = 0;
  const auto fill = [&](const auto& monomials) {
    for (const StateMonomial& m : monomials) {
      double x = std::pow(along, m.along) / (2 * bent);
      for (int f = 0; f < m.off_ray; ++f) x *= far[m.variable[f]];
      weights[row++] = x;
    }
  };
  fill(even_monomials());
  fill(odd_monomials());
  return weights;
}

// Both parts side by side, and apart again.
MatrixXd columns_of(const StateTable& t) {
  MatrixXd all(t.even.rows(), even_columns + odd_columns);
  all << t.even, t.odd;
  return all;
}
StateTable table_of(double sigma, const MatrixXd& columns) {
  return {sigma, columns.leftCols(even_columns), columns.rightCols(odd_columns)};
}

StressPlaces places_of(std::array<int, 2> mesh) {
  PlateShape shape;
  shape.mesh = mesh;
  return StressPlaces(shape);
}

}  // namespace

// ---------------------------------------------------------------------------- patterns

StressPatterns::StressPatterns(std::array<int, 2> mesh, MatrixXd P)
    : rows_(places_of(mesh).rows()),
      half_(places_of(mesh).strain_rows() / 2),
      P_(std::move(P)),
      rows_of_P_(std::make_shared<PatternRows>(P_)) {}

StressPatterns::StressPatterns(const StressAtlasSettings& settings)
    : StressPatterns(settings.mesh, MatrixXd()) {
  std::mt19937 random(11);
  const auto in = [&](double a, double b) {
    return a + (b - a) * (static_cast<double>(random()) / 4294967296.0);
  };
  const auto inside = [&](const std::vector<double>& x) { return in(x.front(), x.back()); };
  const ShapeGrid& grid = settings.grid;
  MatrixXd gram = MatrixXd::Zero(rows_, rows_);
  for (int s = 0; s < settings.samples; ++s) {
    const Vector3d place(inside(grid.log_width), inside(grid.log_thickness),
                         inside(grid.poissons_ratios));
    const PlateShape shape{std::exp(place[0]), std::exp(place[1]), place[2], settings.mesh,
                           settings.free_edge_torsion};
    const VectorXd per_row = scale(shape.thickness).cwiseInverse();
    const double rho = inside(settings.rays);
    const BentStates states =
        bent_states(shape, {1, rho}, ray_directions(rho), settings.sigmas, {.stress = true});
    for (const StateTable& node : states.stress) {
      const MatrixXd weighted =
          per_row.asDiagonal() * columns_of(node) * monomial_weights(node.sigma).asDiagonal();
      gram += weighted * weighted.transpose();
    }
  }
  P_ = SymmetricEigen(gram).eigenvectors().rowwise().reverse().leftCols(
      std::min<Eigen::Index>(settings.patterns, rows_));
  rows_of_P_ = std::make_shared<PatternRows>(P_);
}

VectorXd StressPatterns::scale(double thickness) const {
  VectorXd scale = VectorXd::Ones(rows_);
  scale.head(half_).setConstant(thickness);
  scale.segment(half_, half_).setConstant(2);
  return scale;
}

StateTable StressPatterns::coefficients(const StateTable& node, double thickness) const {
  const VectorXd per_row = scale(thickness).cwiseInverse();
  return {node.sigma, P_.transpose() * (per_row.asDiagonal() * node.even),
          P_.transpose() * (per_row.asDiagonal() * node.odd)};
}

void StressPatterns::add_rates(const StateTable& coefficients,
                               const std::array<StateTable, 3>& by_shape, double thickness,
                               const StateWeights<double>& weights, std::size_t end,
                               StressRates& to) const {
  const auto add = [&](const auto& monomials, std::size_t part, MatrixXd StateTable::*table,
                       const auto& all, bool bending, MatrixXd& sum) {
    auto w = all;
    if (coefficients.sigma == 0) {  // as TubeStress has it
      for (std::size_t k = 0; k < monomials.size(); ++k)
        if (monomials[k].turned() != bending) w[static_cast<Eigen::Index>(k)] = 0;
      if (part == 0) w[0] = 0;
    }
    const double scale = bending ? 2 : thickness;
    for (std::size_t p = 0; p < 3; ++p)
      sum.col(static_cast<Eigen::Index>(p)).noalias() += scale * (by_shape[p].*table * w);
    if (!bending) sum.col(1).noalias() += coefficients.*table * w;
  };
  for (const bool bending : {false, true}) {
    std::array<MatrixXd, 2>& sum = bending ? to.bending : to.membrane;
    add(even_monomials(), 0, &StateTable::even, weights.even[end], bending, sum[0]);
    add(odd_monomials(), 1, &StateTable::odd, weights.odd[end], bending, sum[1]);
  }
}

// ---------------------------------------------------------------------------- look-up

// Of the bent state n: what `look_up(table)` says of the coefficients of a ray.
template <class LookUp>
StateTable StressAtlas::coefficients(double rho, std::size_t n, const LookUp& look_up) const {
  const std::vector<double>& rays = settings_.rays;
  std::size_t left = 0;
  while (left + 2 < rays.size() && rho > rays[left + 1]) ++left;
  const double a = rays[left], b = rays[left + 1], sigma = settings_.sigmas[n];
  const auto of_ray = [&](std::size_t ray) {
    const VectorXd numbers = look_up(tables_[ray * settings_.sigmas.size() + n]);
    return table_of(sigma, numbers.reshaped(patterns_.P().cols(), even_columns + odd_columns));
  };
  if (rho == a || rho == b) return of_ray(rho == a ? left : left + 1);
  return blended(of_ray(left), of_ray(left + 1), blend_between_rays(a, b, sigma, rho));
}

std::vector<StateTable> StressAtlas::look_up(const PlateShape& shape, double rho, int nodes) const {
  const ShapeWeights weights =
      shape_weights(settings_.grid, place_in_grid(shape), ShapeSlopes::none);
  std::vector<StateTable> found;
  for (std::size_t n = 0; n < static_cast<std::size_t>(nodes); ++n)
    found.push_back(
        coefficients(rho, n, [&](const CompressedTable& t) { return t.look_up(weights, t.all); }));
  return found;
}

StressRateSource StressAtlas::rates(const PlateShape& shape, double rho, ShapeSlopes slopes) const {
  struct Known {  // of a bent state
    StateTable coefficients;
    std::array<StateTable, 3> by_shape;
  };
  return [this, shape, rho, known = std::map<std::size_t, Known>(),
          at = shape_weights(settings_.grid, place_in_grid(shape), slopes)](
             std::size_t interval, const StateWeights<double>& weights) mutable {
    const MatrixXd none = MatrixXd::Zero(patterns_.P().cols(), 3);
    StressRates rates{{none, none}, {none, none}};
    for (const std::size_t end : {0, 1}) {
      Known& node = known[interval + end];
      if (node.coefficients.even.size() == 0) {
        std::map<const CompressedTable*, Eigen::MatrixX4d> of_ray;
        const auto column = [&](int c) {
          return coefficients(rho, interval + end, [&](const CompressedTable& t) {
            const auto [found, fresh] = of_ray.try_emplace(&t);
            if (fresh) found->second = t.look_up_slopes(at, t.all);
            return VectorXd(found->second.col(c));
          });
        };
        node.coefficients = column(0);
        const Vector3d per = slope_units(shape);
        for (int p = 0; p < 3; ++p) {
          StateTable& rate = node.by_shape[static_cast<std::size_t>(p)];
          rate = column(1 + p);
          rate.even *= per[p];
          rate.odd *= per[p];
        }
      }
      patterns_.add_rates(node.coefficients, node.by_shape, shape.thickness, weights, end, rates);
    }
    return rates;
  };
}

// ---------------------------------------------------------------------------- file

std::string StressAtlas::pack() const {
  std::string block;
  std::vector<std::int32_t> counts{static_cast<std::int32_t>(patterns_.P().rows()),
                                   static_cast<std::int32_t>(patterns_.P().cols()),
                                   static_cast<std::int32_t>(tables_.size())};
  for (const CompressedTable& t : tables_) {
    counts.push_back(t.numbers);
    counts.push_back(t.directions);
  }
  append_part(block, counts.data(), 3);
  append_part(block, counts.data() + 3, 2 * tables_.size());
  const Eigen::MatrixXf P = patterns_.P().cast<float>();
  append_part(block, P.data(), static_cast<std::uint64_t>(P.size()));
  for (const CompressedTable& t : tables_) append_table(block, t);
  return block;
}

std::shared_ptr<const StressAtlas> StressAtlas::unpack(const StressAtlasSettings& settings,
                                                       const char* data, std::size_t size,
                                                       std::shared_ptr<const void> owner) {
  PartReader read{data, size};
  const std::size_t tables = settings.rays.size() * settings.sigmas.size();
  const auto* counts = read.next<std::int32_t>(3);
  const int rows = places_of(settings.mesh).rows();
  if (!counts || counts[0] != rows || counts[1] != std::min(settings.patterns, rows) ||
      counts[2] != static_cast<std::int32_t>(tables))
    return nullptr;
  const int patterns = counts[1],
            all_numbers = patterns * static_cast<int>(even_columns + odd_columns);
  const auto* sizes = read.next<std::int32_t>(2 * tables);
  const auto* P = read.next<float>(static_cast<std::size_t>(rows) * patterns);
  if (!sizes || !P) return nullptr;
  std::vector<CompressedTable> all;
  for (std::size_t k = 0; k < tables; ++k) {
    CompressedTable& t = all.emplace_back();
    t.all = all_numbers;
    t.numbers = sizes[2 * k];
    t.directions = sizes[2 * k + 1];
    t.shapes = settings.grid.size();
    if (!read_table(read, t)) return nullptr;
  }
  if (read.at != size) return nullptr;
  return std::make_shared<StressAtlas>(
      settings,
      StressPatterns(settings.mesh,
                     Eigen::Map<const Eigen::MatrixXf>(P, rows, patterns).cast<double>()),
      std::move(all), std::move(owner));
}

// ---------------------------------------------------------------------------- making

StressAtlasMaker::StressAtlasMaker(const StressAtlasSettings& settings)
    : settings_(settings), patterns_(settings) {
  const Eigen::Index numbers = patterns_.P().cols() * (even_columns + odd_columns);
  values_.assign(settings.sigmas.size(), MatrixXd(numbers, settings.grid.size()));
}

void StressAtlasMaker::put(int k, const std::vector<StateTable>& nodes) {
  assert(nodes.size() == settings_.sigmas.size());
  const double thickness = std::exp(settings_.grid.shape(k)[1]);
  for (std::size_t n = 0; n < nodes.size(); ++n)
    values_[n].col(k) = columns_of(patterns_.coefficients(nodes[n], thickness)).reshaped();
}

void StressAtlasMaker::end_ray() {
  for (std::size_t n = 0; n < values_.size(); ++n) {
    const VectorXd w = monomial_weights(settings_.sigmas[n]);
    const MatrixXd of_leaf = VectorXd::Ones(patterns_.P().cols()) * w.transpose();
    made_->push_back(
        compress(settings_.grid, values_[n], of_leaf.reshaped().replicate(1, settings_.grid.size()),
                 std::vector<bool>(static_cast<std::size_t>(settings_.grid.size()), true),
                 settings_.tolerance));
  }
}

std::shared_ptr<const StressAtlas> StressAtlasMaker::finish() {
  assert(made_->size() == settings_.rays.size() * settings_.sigmas.size());
  std::vector<CompressedTable> tables;
  for (const CompressedNumbers& numbers : *made_) tables.push_back(numbers.table());
  return std::make_shared<StressAtlas>(settings_, patterns_, std::move(tables), made_);
}

}  // namespace flexopt
