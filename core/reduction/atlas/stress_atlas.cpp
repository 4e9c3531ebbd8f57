#include "core/reduction/atlas/stress_atlas.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <map>
#include <random>

#include "core/math/decompositions.hpp"
#include "core/reduction/atlas/expanded_leaf.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"

namespace flexopt {
namespace {

constexpr Eigen::Index even_columns = StateTable::even_of_stress,
                       odd_columns = StateTable::odd_monomials;

constexpr double least_bending = 0.015;  // [rad], of a state near the flat leaf

// Size of each monomial, the even ones first, where states lie as far from a bent state as usual.
VectorXd monomial_sizes(double sigma) {
  const double along = 0.3 * std::max(sigma, least_bending) + 0.01;
  const std::array<double, 5> far{0.02 + 0.1 * sigma, 0.01, 4, 2, 2};  // τ, φ, N, M1, M2
  const double turned = 0.02 + 0.3 * sigma;  // τ of a design that turns its rays: for slopes
  VectorXd sizes(even_columns + odd_columns);
  Eigen::Index row = 0;
  const auto fill = [&](const auto& monomials) {
    for (const StateMonomial& m : monomials) {
      double x = std::pow(along, m.along);
      for (int f = 0; f < m.off_ray; ++f)
        x *= f == 0 && m.variable[f] == 0 ? turned : far[m.variable[f]];
      sizes[row++] = x;
    }
  };
  fill(even_monomials<StateTable::even_of_stress>());
  fill(odd_monomials());
  return sizes;
}

// Factor from strains divided by the thickness to their share of the largest stress at this σ.
double per_stress(double sigma) { return 1 / (2 * std::max(sigma, least_bending)); }

// The even and odd parts of a table side by side.
MatrixXd columns_of(const StateTable& t) {
  MatrixXd all(t.even.rows(), even_columns + odd_columns);
  all << t.even, t.odd;
  return all;
}

// The `count` leading eigenvectors.
MatrixXd leading(const MatrixXd& gram, Eigen::Index count) {
  return SymmetricEigen(gram).eigenvectors().rowwise().reverse().leftCols(
      std::min(count, gram.rows()));
}

// Number of rows of folded(), and largest number of patterns, of a family.
std::array<int, 2> pattern_counts(const StressAtlasSettings& settings, const StressPlaces& places,
                                  int family) {
  if (family == StrainPatterns::places_family) {
    const int nodes = (places.rows() - places.strain_rows()) / 3;
    return {3 * nodes, std::min(settings.place_patterns, 2 * nodes) +
                           std::min(settings.place_patterns, nodes)};
  }
  const int rows = places.strain_rows() / 4;
  return {rows, std::min(settings.patterns, rows)};
}

}  // namespace

// ---------------------------------------------------------------------------- patterns

StrainPatterns find_patterns(const StressAtlasSettings& settings) {
  std::mt19937 random(11);
  const auto in = [&](double a, double b) {
    return a + (b - a) * (static_cast<double>(random()) / 4294967296.0);
  };
  const auto inside = [&](const std::vector<double>& x) { return in(x.front(), x.back()); };
  const ShapeGrid& grid = settings.grid;
  const StressPlaces places(settings.mesh);
  std::array<MatrixXd, StrainPatterns::families> grams;
  for (int f = 0; f < StrainPatterns::families; ++f) {
    const int rows = pattern_counts(settings, places, f)[0];
    grams[static_cast<std::size_t>(f)] = MatrixXd::Zero(rows, rows);
  }
  for (int s = 0; s < settings.samples; ++s) {
    const Vector3d place(inside(grid.log_width), inside(grid.log_thickness),
                         inside(grid.poissons_ratios));
    const PlateShape shape{std::exp(place[0]), std::exp(place[1]), place[2], settings.mesh,
                           settings.free_edge_torsion};
    const double rho = inside(settings.rays);
    const BentStates states =
        bent_states(shape, {1, rho}, ray_directions(rho), settings.sigmas, {.stress = true});
    for (const StateTable& node : states.stress) {
      const MatrixXd all = columns_of(node) * monomial_sizes(node.sigma).asDiagonal();
      for (int f = 0; f < StrainPatterns::families; ++f) {
        const double scale = f == StrainPatterns::places_family
                                 ? 1
                                 : (f < 2 ? 1 / shape.thickness : 0.5) * per_stress(node.sigma);
        const MatrixXd rows = scale * StrainPatterns::folded(places, f, all);
        grams[static_cast<std::size_t>(f)].noalias() += rows * rows.transpose();
      }
    }
  }
  std::array<MatrixXd, StrainPatterns::families> P;
  for (int f = 0; f < StrainPatterns::places_family; ++f)  // half of a pattern of norm 1
    P[static_cast<std::size_t>(f)] =
        std::sqrt(0.5) * leading(grams[static_cast<std::size_t>(f)], settings.patterns);
  // places in the plane and off it apart: of a flat leaf the mirror in the thickness keeps one kind
  const MatrixXd& gram = grams.back();
  std::array<std::vector<Eigen::Index>, 2> rows;
  for (Eigen::Index i = 0; i < gram.rows(); ++i) rows[i % 3 == 2 ? 1 : 0].push_back(i);
  const std::array<MatrixXd, 2> apart{leading(gram(rows[0], rows[0]), settings.place_patterns),
                                      leading(gram(rows[1], rows[1]), settings.place_patterns)};
  P.back() = MatrixXd::Zero(gram.rows(), apart[0].cols() + apart[1].cols());
  P.back()(rows[0], Eigen::seqN(0, apart[0].cols())) = apart[0];
  P.back()(rows[1], Eigen::seqN(apart[0].cols(), apart[1].cols())) = apart[1];
  return {settings.mesh, P};
}

// ---------------------------------------------------------------------------- look-up

std::vector<StateTable> StressAtlas::look_up(const CodedTables::Place& at, double rho,
                                             std::size_t n) const {
  return look_up_tables(*tables_, at, ray_neighbours(settings_.rays, rho), static_cast<int>(n),
                        settings_.sigmas[n], {patterns_->all(), patterns_->all(), even_columns});
}

std::vector<StateTable> StressAtlas::look_up(const PlateShape& shape, double rho, int nodes) const {
  const CodedTables::Place at = tables_->place(shape, ShapeSlopes::none);
  std::vector<StateTable> found;
  for (std::size_t n = 0; n < static_cast<std::size_t>(nodes); ++n)
    found.push_back(std::move(look_up(at, rho, n).front()));
  return found;
}

StressRateSource StressAtlas::rates(const PlateShape& shape, double rho, ShapeSlopes slopes) const {
  return [this, rho, known = std::map<std::size_t, std::vector<StateTable>>(),
          at = tables_->place(shape, slopes),
          per = slope_units(shape)](std::size_t n) mutable -> const std::vector<StateTable>& {
    std::vector<StateTable>& rates = known[n];
    if (!rates.empty()) return rates;
    rates = look_up(at, rho, n);
    rates.erase(rates.begin());
    for (std::size_t p = 0; p < rates.size(); ++p) {
      rates[p].even *= per[static_cast<Eigen::Index>(p)];
      rates[p].odd *= per[static_cast<Eigen::Index>(p)];
    }
    return rates;
  };
}

// ---------------------------------------------------------------------------- file

std::vector<int> stress_counts(const StressAtlasSettings& settings, Eigen::Index patterns) {
  return std::vector<int>(settings.sigmas.size(),
                          static_cast<int>(patterns * (even_columns + odd_columns)));
}

AtlasPart pack(const StrainPatterns& patterns) {
  std::string bytes;
  for (int f = 0; f < StrainPatterns::families; ++f) {
    const Eigen::MatrixXf P = patterns.P(f).cast<float>();
    bytes.append(reinterpret_cast<const char*>(P.data()),
                 static_cast<std::size_t>(P.size()) * sizeof(float));
  }
  return AtlasPart(std::move(bytes));
}

std::shared_ptr<const StrainPatterns> unpack_patterns(const StressAtlasSettings& settings,
                                                      const AtlasPart& part) {
  const StressPlaces places(settings.mesh);
  std::array<MatrixXd, StrainPatterns::families> P;
  const char* at = part.bytes().data();
  for (int f = 0; f < StrainPatterns::families; ++f) {
    const auto [rows, patterns] = pattern_counts(settings, places, f);
    Eigen::MatrixXf numbers(rows, patterns);
    const std::size_t size = static_cast<std::size_t>(numbers.size()) * sizeof(float);
    std::memcpy(numbers.data(), at, size);
    at += size;
    P[static_cast<std::size_t>(f)] = numbers.cast<double>();
  }
  return std::make_shared<StrainPatterns>(settings.mesh, P);
}

// ---------------------------------------------------------------------------- making

StressAtlasMaker::StressAtlasMaker(const StressAtlasSettings& settings,
                                   std::shared_ptr<const StrainPatterns> patterns)
    : settings_(settings), patterns_(std::move(patterns)) {}

void StressAtlasMaker::begin_ray() {
  const Eigen::Index numbers = patterns_->all() * (even_columns + odd_columns);
  values_.emplace_back(settings_.sigmas.size(), NumbersOfShapes(numbers, settings_.grid.size()));
}

void StressAtlasMaker::put(int k, const std::vector<StateTable>& nodes) {
  assert(nodes.size() == settings_.sigmas.size());
  const double thickness = std::exp(settings_.grid.shape(k)[1]);
  for (std::size_t n = 0; n < nodes.size(); ++n)
    values_.back()[n].col(k) =
        table_numbers(patterns_->coefficients(nodes[n], thickness)).cast<float>();
}

std::shared_ptr<const StressAtlas> StressAtlasMaker::finish() {
  const StressPlaces places(settings_.mesh);
  std::vector<NumberUnits> units;
  for (const double sigma : settings_.sigmas) {
    VectorXd share(patterns_->all());
    share.head(patterns_->strains())
        .setConstant(per_stress(sigma) / std::sqrt(0.5 * places.strain_rows()));
    share.tail(patterns_->count(StrainPatterns::places_family))
        .setConstant(1 / std::sqrt(places.rows() - places.strain_rows()));
    const MatrixXd weights = share * monomial_sizes(sigma).transpose();
    NumberUnits& of = units.emplace_back();
    for (const double weight : weights.reshaped())
      of.sizes.push_back(static_cast<float>(settings_.unit / weight));
    of.laws.resize(of.sizes.size());
  }
  return std::make_shared<StressAtlas>(
      settings_, patterns_,
      code_tables(settings_.grid, VectorXd::Ones(settings_.grid.size()), units,
                  std::move(values_)));
}

}  // namespace flexopt
