#include "core/reduction/atlas/number_units.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "core/math/decompositions.hpp"
#include "core/math/polynomial.hpp"
#include "core/reduction/atlas/state_look_up.hpp"
#include "core/reduction/tube/dynamics_form.hpp"
#include "core/reduction/tube/tube_leaf.hpp"

namespace flexopt {
namespace {

// How far states are from a bent state along the ray: half of the way to the next one.
double half_way(const std::vector<double>& sigma, std::size_t n) {
  return 0.5 * (n + 1 < sigma.size() ? sigma[n + 1] - sigma[n] : sigma[n] - sigma[n - 1]);
}

// Units of the power law that fits 1/weight best. `log_inverse`: numbers × shapes, of the `kept`
// shapes alone.
NumberUnits fitted_units(const ShapeGrid& grid, const std::vector<Eigen::Index>& kept,
                         const MatrixXd& log_inverse, const VectorXd& steps) {
  const MatrixXd log_sizes = grid.log_sizes()(kept, Eigen::all);
  NumberUnits units;
  for (Eigen::Index i = 0; i < log_inverse.rows(); ++i) {
    const VectorXd of = log_inverse.row(i)(kept).transpose();
    const PowerLaw law = power_law(log_sizes, of.array().exp());
    const double size = std::exp((of.array() - law_at(log_sizes, law).array().log()).mean());
    units.sizes.push_back(static_cast<float>(size * steps[i]));
    units.laws.push_back(law);
  }
  return units;
}

std::vector<Eigen::Index> every(Eigen::Index count) {
  std::vector<Eigen::Index> all;
  for (Eigen::Index k = 0; k < count; ++k) all.push_back(k);
  return all;
}

}  // namespace

std::vector<NumberUnits> potential_units(const AtlasSettings& settings,
                                         const std::vector<std::vector<NumbersOfShapes>>& values) {
  constexpr double unit = 3e-5;          // of the stiffness of the leaf
  constexpr double along_the_ray = 0.1;  // of terms in σ alone, which carry the drive's load
  const MonomialTable& table = monomials<6, atlas_degree>();
  const ShapeGrid grid = shape_grid(settings);
  std::vector<NumberUnits> units;
  for (std::size_t n = 0; n < settings.sigmas.size(); ++n) {
    const double sigma = settings.sigmas[n];
    // how far states are from the bent state, in (σ, τ, φ, N, M1, M2)
    const std::array<double, 6> far{
        half_way(settings.sigmas, n), 0.02 + 0.1 * sigma, 0.007, 4, 1, 1};
    const std::vector<int> own = atlas_terms(sigma);
    std::array<Eigen::Index, 6> square{};  // rows of the squares of the variables
    for (std::size_t k = 0; k < own.size(); ++k)
      for (std::size_t v = 0; v < 6; ++v)
        if (table.degree(own[k]) == 2 && table.exponents(own[k])[v] == 2)
          square[v] = static_cast<Eigen::Index>(k);
    // what a term adds to the second derivatives, over the roots of those on the diagonal
    MatrixXd log_inverse = MatrixXd::Zero(static_cast<Eigen::Index>(own.size()), grid.size());
    VectorXd steps = VectorXd::Constant(log_inverse.rows(), unit);
    for (Eigen::Index k = 0; k < log_inverse.rows(); ++k) {
      const auto e = table.exponents(own[static_cast<std::size_t>(k)]);
      double size = 1;
      bool on_ray = true;
      for (std::size_t v = 0; v < 6; ++v) {
        size *= std::pow(far[v], e[v]);
        on_ray = on_ray && (v == 0 || e[v] == 0);
      }
      if (on_ray) steps[k] *= along_the_ray;
      for (const std::vector<NumbersOfShapes>& ray : values)
        for (Eigen::Index shape = 0; shape < grid.size(); ++shape) {
          const auto curvature = [&](std::size_t v) {
            return std::abs(2 * static_cast<double>(ray[n](square[v], shape)));
          };
          double weight = 0;
          for (std::size_t u = 0; u < 6; ++u)
            for (std::size_t v = u; v < 6; ++v) {
              double factor = u == v ? e[u] * (e[u] - 1) : e[u] * e[v];
              if (u == 0)  // the polynomials along the ray have slopes of lower powers, too
                factor = v == 0 ? std::max(factor, 4.0) : std::max<int>(e[0], 2) * e[v];
              if (factor > 0)
                weight = std::max(weight, factor * size / (far[u] * far[v]) /
                                              std::sqrt(curvature(u) * curvature(v)));
            }
          log_inverse(k, shape) -= std::log(weight) / static_cast<double>(values.size());
        }
    }
    units.push_back(fitted_units(grid, every(grid.size()), log_inverse, steps));
  }
  return units;
}

namespace {

constexpr int P = TubeDynamics::amplitudes, R = TubeDynamics::rates;

// Squares of what the numbers at a state change by: internal frequencies, and the kinetic energy of
// motions of the edges with the internal ones that they bring about; relative, the even numbers
// first.
VectorXd squared_gains(const TubeDynamics& tables, const TubeDynamics::Place& place,
                       std::mt19937& random) {
  constexpr int frequencies = 6, motions = 6;
  // a frequency changes by half of that, and the leaves are part of the moving mass
  constexpr double of_motions = 0.25;
  const TubeDynamics::Answer answer = tables.evaluate(place);
  const auto [evens, odds] = TubeDynamics::entries();
  if (!answer.reason.empty()) return {};
  const DynamicsForm form(tables, place, {});
  const SymmetricEigen internal(answer.stiffness, answer.mass.bottomRightCorner<P, P>());
  VectorXd sum = VectorXd::Zero(evens + odds);
  for (int j = 0; j < frequencies; ++j) {
    const double square = internal.eigenvalues()[j];
    DynamicsForm::Rates r = DynamicsForm::Rates::Zero();
    r.tail<P>() = internal.eigenvectors().col(j);
    sum += (form.by_numbers(r, square) / (2 * square)).cwiseAbs2() / frequencies;
  }
  for (int j = 0; j < motions; ++j) {
    DynamicsForm::Rates r = DynamicsForm::Rates::Zero();
    for (int i = 0; i < R - P; ++i)
      r[i] = (random() % 2 == 0 ? 1 : -1) / std::sqrt(answer.mass(i, i));
    const double mass = r.dot(answer.mass * r);
    sum += (of_motions / mass * form.by_numbers(r, -1)).cwiseAbs2() / motions;
  }
  return sum;
}

// The shapes whose dynamics may be asked for, and their tables.
struct DynamicsSamples {
  const AtlasSettings& settings;
  const std::vector<std::vector<NumbersOfShapes>>& values;
  ShapeGrid grid = shape_grid(settings);
  std::vector<Eigen::Index> trusted = {};

  DynamicsSamples(const AtlasSettings& of, const std::vector<std::vector<NumbersOfShapes>>& numbers)
      : settings(of), values(numbers) {
    for (int k = 0; k < grid.size(); ++k)
      if (TubeModel::has_dynamics(shape(k))) trusted.push_back(k);
  }
  PlateShape shape(Eigen::Index k) const {
    return shape_at(settings, grid.shape(static_cast<int>(k)));
  }
  StateTable table(std::size_t ray, std::size_t node, Eigen::Index k) const {
    return table_of(settings.sigmas[node], dynamics_form(),
                    values[ray][node].col(k).cast<double>());
  }
};

// Returns what makes up for a unit relative to the diagonals of the matrices, for the numbers about
// each bent state, those of the stations behind the others: means over the rays of its logarithm.
std::vector<MatrixXd> log_inverse_weights(const DynamicsSamples& samples, Eigen::Index stations) {
  const std::size_t nodes = samples.settings.sigmas.size(), rays = samples.values.size();
  std::vector<MatrixXd> found(
      nodes, MatrixXd::Zero(dynamics_form().numbers() + stations, samples.grid.size()));
  for (std::size_t ray = 0; ray < rays; ++ray)
    for (std::size_t n = 0; n < nodes; ++n)
      for (const Eigen::Index k : samples.trusted) {
        const DynamicsNode weights =
            TubeDynamics::weights({samples.table(ray, n, k), MatrixXd::Zero(stations / 2, 2)},
                                  samples.shape(k), half_way(samples.settings.sigmas, n));
        VectorXd all(found[n].rows());
        all << table_numbers(weights.table), weights.stations.reshaped();
        found[n].col(k) -= (all.array().log() / static_cast<double>(rays)).matrix();
      }
  return found;
}

// How far a change of a number by what makes up for its weight goes to what is asked of the tables,
// at random states of random shapes: numbers × bent states.
MatrixXd dynamics_gains(const DynamicsSamples& samples, const std::vector<MatrixXd>& log_inverse) {
  constexpr int shapes = 24;  // on each ray
  const std::vector<double>& sigma = samples.settings.sigmas;
  const TableForm form = dynamics_form();
  MatrixXd squares = MatrixXd::Zero(form.numbers(), static_cast<Eigen::Index>(sigma.size()));
  std::mt19937 random(7);
  const auto in = [&](double a, double b) {
    return a + (b - a) * (static_cast<double>(random()) / 4294967296.0);
  };
  for (std::size_t ray = 0; ray < samples.values.size(); ++ray)
    for (int s = 0; s < shapes; ++s) {
      const Eigen::Index k = samples.trusted[random() % samples.trusted.size()];
      TubeDynamics tables(0);
      for (std::size_t n = 0; n < sigma.size(); ++n) tables.add({samples.table(ray, n, k), {}});
      for (std::size_t n = 0; n + 1 < sigma.size(); ++n) {
        const double here = in(sigma[n], sigma[n + 1]);
        const TubeDynamics::Place place{here,
                                        in(-0.07, 0.07) * here,
                                        in(-0.006, 0.006),
                                        {in(-1.5, 1.5), in(-0.75, 0.75), in(-0.5, 0.5)}};
        const VectorXd own = squared_gains(tables, place, random);
        if (own.size() == 0 || !own.allFinite()) continue;
        const auto w = state_weights(sigma[n], sigma[n + 1], here,
                                     {place.tau, place.twist, place.f[0], place.f[1], place.f[2]});
        for (std::size_t end = 0; end < 2; ++end) {
          StateTable of;
          of.even = own.head(form.even_rows) * w.even[end].cwiseAbs2().transpose();
          of.odd = own.tail(form.odd_rows) * w.odd[end].cwiseAbs2().transpose();
          squares.col(static_cast<Eigen::Index>(n + end)).array() +=
              table_numbers(of).array() *
              (2 * log_inverse[n + end].col(k).head(form.numbers())).array().exp();
        }
      }
    }
  return (squares / (shapes * static_cast<double>(samples.values.size()))).cwiseSqrt();
}

}  // namespace

DynamicsUnits dynamics_units(const AtlasSettings& settings,
                             const std::vector<std::vector<NumbersOfShapes>>& values,
                             Eigen::Index stations) {
  constexpr double unit = 6e-5, of_stations = 0.02, least_gain = 1e-3;
  const DynamicsSamples samples(settings, values);
  const std::vector<MatrixXd> log_inverse = log_inverse_weights(samples, stations);
  const MatrixXd gains = dynamics_gains(samples, log_inverse);
  DynamicsUnits units;
  for (std::size_t n = 0; n < log_inverse.size(); ++n) {
    const VectorXd steps =
        unit * gains.col(static_cast<Eigen::Index>(n)).cwiseMax(least_gain).cwiseInverse();
    units.tables.push_back(
        fitted_units(samples.grid, samples.trusted, log_inverse[n].topRows(steps.size()), steps));
    units.stations.push_back(fitted_units(samples.grid, samples.trusted,
                                          log_inverse[n].bottomRows(stations),
                                          VectorXd::Constant(stations, of_stations)));
  }
  return units;
}

}  // namespace flexopt
