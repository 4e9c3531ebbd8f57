#include "core/reduction/atlas/make_atlas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <utility>

#include "core/math/decompositions.hpp"
#include "core/math/polynomial.hpp"
#include "core/reduction/atlas/atlas_dynamics.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"
#include "core/reduction/tube/mixed_condensation.hpp"
#include "core/reduction/tube/tube_leaf.hpp"

namespace flexopt {

void run_in_order(int count, const std::function<void(int)>& work) {
  for (int i = 0; i < count; ++i) work(i);
}

namespace {

// Shape of a place of the grid.
PlateShape shape_at(const AtlasSettings& settings, const Vector3d& place) {
  return {std::exp(place[0]), std::exp(place[1]), place[2], settings.mesh,
          settings.free_edge_torsion};
}

BentStates bent_states(const AtlasSettings& settings, const PlateShape& shape, double rho,
                       bool with_stress) {
  BentStates states = bent_states(shape, {1, rho}, ray_directions(rho), settings.sigmas,
                                  {settings.dynamics, with_stress});
  if (std::abs(rho) == 1)  // equal ends, equal numbers
    for (TubeNode& node : states.nodes) {
      const std::vector<double> turned = end_for_end(node.W, rho);
      for (std::size_t k = 0; k < node.W.size(); ++k) node.W[k] = 0.5 * (node.W[k] + turned[k]);
    }
  return states;
}

// The numbers of an atlas while they are made.
struct Store {
  std::vector<std::int8_t> exponents;
  std::vector<float> values, units;
  std::vector<std::int16_t> highest;
  std::vector<CompressedNumbers> dynamics, stations;  ///< of each ray

  Store(const AtlasSettings& settings, const std::vector<AtlasTerm>& terms) {
    const auto [all_lower, all_highest] = term_counts(terms);
    const std::size_t rays = settings.rays.size(),
                      leaves = static_cast<std::size_t>(settings.shapes()) * settings.tables();
    exponents.resize(2 * terms.size() * rays);
    values.resize(TubeAtlas::stride(all_lower) * leaves);
    highest.resize(TubeAtlas::stride(all_highest) * leaves);
    units.resize(static_cast<std::size_t>(all_highest) * rays);
  }
};

// Fills the table of one ray for all Poisson's ratios from its bent states, [ratio × shape].
void fill_ray(const AtlasSettings& settings, const std::vector<AtlasTerm>& terms, int ray,
              const std::vector<BentStates>& states, Store& store) {
  const ShapeGrid grid = shape_grid(settings);
  MatrixXd places(grid.size(), 2);
  for (int k = 0; k < grid.size(); ++k) places.row(k) = grid.shape(k).head<2>().transpose();
  const int shapes = settings.shapes();
  const int rays = static_cast<int>(settings.rays.size());
  const auto [all_lower, all_highest] = term_counts(terms);
  const std::size_t stride = TubeAtlas::stride(all_lower),
                    stride_of_highest = TubeAtlas::stride(all_highest);
  const auto shape = [&](int k) {
    return (static_cast<std::size_t>(k / shapes) * rays + ray) * shapes +
           static_cast<std::size_t>(k % shapes);
  };
  std::size_t lower = 0, highest = 0;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    VectorXd c(grid.size());
    for (int k = 0; k < c.size(); ++k)
      c[k] = states[static_cast<std::size_t>(k)].nodes[terms[i].node].W[terms[i].monomial];
    const auto power = power_law(places, c.cwiseAbs());
    const std::size_t e = 2 * (static_cast<std::size_t>(ray) * terms.size() + i);
    store.exponents[e] = power[0];
    store.exponents[e + 1] = power[1];
    for (int k = 0; k < c.size(); ++k)
      c[k] /= std::exp(0.5 * (power[0] * places(k, 0) + power[1] * places(k, 1)));
    const bool last = is_highest(terms[i]);
    const double most = c.cwiseAbs().maxCoeff(), unit = most > 0 ? most / 32767 : 1;
    if (last)
      store.units[static_cast<std::size_t>(ray) * all_highest + highest] = static_cast<float>(unit);
    for (int k = 0; k < c.size(); ++k)
      if (last)
        store.highest[shape(k) * stride_of_highest + highest] =
            static_cast<std::int16_t>(std::lround(c[k] / unit));
      else
        store.values[shape(k) * stride + lower] = static_cast<float>(c[k]);
    ++(last ? highest : lower);
  }
}

// Compresses the tables of one ray.
void compress_dynamics(const AtlasSettings& settings, const std::vector<BentStates>& states,
                       Store& store) {
  constexpr double tolerance = 7e-3, of_stations = 0.06;
  const ShapeGrid grid = shape_grid(settings);
  const std::vector<double>& sigma = settings.sigmas;
  const Eigen::Index numbers = table_numbers(states[0].dynamics).size(),
                     motions = station_numbers(states[0].dynamics).size();
  MatrixXd values(numbers, grid.size()), weights(numbers, grid.size()),
      stations(motions, grid.size()), ones(motions, grid.size());
  std::vector<bool> trusted;
  for (int k = 0; k < grid.size(); ++k) {
    const PlateShape shape = shape_at(settings, grid.shape(k));
    std::vector<DynamicsNode> nodes = states[static_cast<std::size_t>(k)].dynamics;
    values.col(k) = table_numbers(nodes);
    stations.col(k) = station_numbers(nodes);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const double along =
          0.5 * (n + 1 < sigma.size() ? sigma[n + 1] - sigma[n] : sigma[n] - sigma[n - 1]);
      DynamicsNode unit = TubeDynamics::weights(nodes[n], shape, along);
      nodes[n].table = std::move(unit.table);
      nodes[n].stations = std::move(unit.stations);
    }
    weights.col(k) = table_numbers(nodes);
    ones.col(k) = station_numbers(nodes);
    trusted.push_back(TubeModel::has_dynamics(shape));
  }
  store.dynamics.push_back(compress(grid, std::move(values), weights, trusted, tolerance));
  store.stations.push_back(compress(grid, std::move(stations), ones, trusted, of_stations));
}

}  // namespace

TubePotential tube_potential(const PlateShape& shape, const Eigen::Matrix2d& directions,
                             std::vector<TubeNode> nodes) {
  return TubePotential(directions, tube_force_scale(shape), atlas_degree, std::move(nodes));
}

AtlasCheck::Errors difference(const TubePotential& found, const TubePotential& truth,
                              const PlateShape& shape) {
  AtlasCheck::Errors worst;
  const Vector3d scale = tube_force_scale(shape);
  const Eigen::Matrix2d& D = truth.ray();
  const double last = truth.last_sigma();
  // a tenth of the buckling load between clamped ends, over the scale; a moment of its size
  const double N = 0.4 * std::numbers::pi * std::numbers::pi * shape.width / scale[0];
  constexpr double moment = 1, turn = 0.4 * std::numbers::pi / 180;
  const TubePotential lower(D, scale, atlas_degree - 1, truth.nodes());
  const auto stiffness_error = [&](double sigma, double tau, double phi, const Vector3d& f) {
    const Eigen::Vector2d bent = D * Eigen::Vector2d(sigma, tau);
    Vector6d e = Vector6d::Zero();
    e[theta1y] = bent[0];
    e[theta2y] = bent[1];
    e[twist] = phi;
    MixedState a, b, c;
    a.f = b.f = c.f = f;
    const Matrix6d K = condense(truth, e, b).hessian, dK = condense(found, e, a).hessian - K,
                   change = condense(lower, e, c).hessian - K;
    const Cholesky factor(K);
    if (!factor.positive_definite()) return 0.0;  // not stable on its own: nothing to compare with
    const auto relative = [&](const Matrix6d& d) -> MatrixXd {
      const MatrixXd X = factor.solve_lower(d);
      return factor.solve_lower(X.transpose());
    };
    if (relative(change).norm() > largest_degree_change) return 0.0;  // (R5): nobody uses it
    return symmetric_eigenvalues(relative(dK)).cwiseAbs().maxCoeff();
  };
  for (const double share : {0.01, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0}) {
    const double sigma = share * last;
    const Eigen::Vector2d bent = D * Eigen::Vector2d(sigma, 0);
    const Vector3d s(bent[0], bent[1], 0);
    const double M = D.col(0).dot(truth.evaluate(s, Vector3d::Zero()).gradient.head<2>());
    const double M_found = D.col(0).dot(found.evaluate(s, Vector3d::Zero()).gradient.head<2>());
    worst.drive = std::max(worst.drive, std::abs(M_found / M - 1));
    worst.on_ray = std::max(worst.on_ray, stiffness_error(sigma, 0, 0, Vector3d::Zero()));
    if (share < 0.05 || share > 0.7) continue;
    struct Place {
      double tau, phi, N, M1, M2;
    };
    for (const Place& p : std::initializer_list<Place>{
             {0.2 * sigma, 0, 0, 0, 0},
             {-0.2 * sigma, 0, 0, 0, 0},
             {0, turn, 0, 0, 0},
             {0, 0, N, 0, 0},
             {0, 0, -N, 0, 0},
             {0, 0, 0, moment, -moment},
             {0, 0, 0, moment, moment},
             {0.1 * sigma, 0.5 * turn, 0.5 * N, 0.5 * moment, 0.3 * moment}})
      worst.off_ray =
          std::max(worst.off_ray, stiffness_error(sigma, p.tau, p.phi, Vector3d(p.N, p.M1, p.M2)));
  }
  return worst;
}

namespace {

// Worst relative difference of the six lowest internal frequencies, edges held, on the ray and a
// little off it.
double frequency_difference(std::vector<DynamicsNode> found, std::vector<DynamicsNode> truth) {
  constexpr int compared = 6;
  const double last = truth.back().table.sigma;
  TubeDynamics a(0), b(0);
  for (DynamicsNode& node : found) a.add(std::move(node));
  for (DynamicsNode& node : truth) b.add(std::move(node));
  const auto squares = [](const TubeDynamics& tables, const TubeDynamics::Place& place) {
    const TubeDynamics::Answer answer = tables.evaluate(place);
    if (!answer.reason.empty()) return VectorXd();
    constexpr int P = TubeDynamics::amplitudes;
    return VectorXd(SymmetricEigen(answer.stiffness, answer.mass.bottomRightCorner<P, P>())
                        .eigenvalues()
                        .head<compared>());
  };
  double worst = 0;
  for (const double share : {0.0, 0.03, 0.12, 0.35, 0.7, 0.95})
    for (const double off : {0.0, 1.0}) {
      const double sigma = share * last;
      const TubeDynamics::Place place{
          sigma, 0.05 * off * sigma, 0.004 * off, {off, 0.5 * off, -0.3 * off}};
      const VectorXd x = squares(a, place), y = squares(b, place);
      if (y.size() == 0) continue;
      worst = std::max(
          worst, x.size() == 0 ? 1.0 : 0.5 * (x.cwiseQuotient(y).array() - 1).abs().maxCoeff());
    }
  return worst;
}

// Worst error of the largest stress, on the ray and off it.
double stress_error(const TubeAtlas& atlas, const PlateShape& shape, double rho,
                    std::vector<StateTable> truth) {
  TubeStress a(shape, 0, TubeAtlas::view({1, rho}), atlas.stress()->patterns()), b(shape, 0);
  for (StateTable& node : atlas.look_up_stress(shape, {1, rho})) a.add(std::move(node));
  for (StateTable& node : truth) b.add(std::move(node));
  const double turn = 0.4 * std::numbers::pi / 180,
               N = 0.1 * 4 * std::numbers::pi * std::numbers::pi;
  double worst = 0;
  for (const double share : {0.02, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0}) {
    const double sigma = share * b.last_sigma();
    for (const TubeStress::Place& at : std::initializer_list<TubeStress::Place>{
             {sigma, 0, 0, Vector3d::Zero()},
             {sigma, 0.1 * sigma, 0.5 * turn, {0.5 * N, 1, 0.5}},
             {sigma, -0.1 * sigma, turn, {-N, -1, 1}}}) {
      const double s = plate_stress(a.evaluate(at).strains, shape, 1, 0).largest().value,
                   t = plate_stress(b.evaluate(at).strains, shape, 1, 0).largest().value;
      worst = std::max(worst, std::abs(s / t - 1));
    }
  }
  return worst;
}

AtlasCheck checked(const TubeAtlas& atlas, const AtlasOptions& options,
                   const std::function<void()>& one_more) {
  const AtlasSettings& s = atlas.settings();
  AtlasCheck check{options.check_cells, {}};
  const int across = check.cells[1], per_ray = check.cells[0] * across;
  std::mt19937 random(20);
  const auto in = [&](double a, double b) {
    return a + (b - a) * (static_cast<double>(random()) / 4294967296.0);
  };
  for (const double rho : options.check_rays) {
    AtlasCheck::Ray& ray = check.rays.emplace_back();
    ray.rho = rho;
    for (int c = 0; c < per_ray; ++c) {
      const auto place = [&](const std::array<double, 2>& box, int cell, int cells) {
        const double a = std::log(box[0]), b = std::log(box[1]);
        return std::exp(a + (b - a) * (cell + in(0, 1)) / cells);
      };
      AtlasCheck::Sample& sample = ray.samples.emplace_back();
      sample.width = place(s.width, c / across, check.cells[0]);
      sample.thickness = place(s.thickness, c % across, across);
      sample.poissons_ratio = in(s.poissons_ratios.front(), s.poissons_ratios.back());
    }
  }
  options.loop(static_cast<int>(check.rays.size()) * per_ray, [&](int i) {
    AtlasCheck::Ray& ray = check.rays[static_cast<std::size_t>(i / per_ray)];
    AtlasCheck::Sample& sample = ray.samples[static_cast<std::size_t>(i % per_ray)];
    const PlateShape shape{sample.width, sample.thickness, sample.poissons_ratio, s.mesh,
                           s.free_edge_torsion};
    TubeAtlas::Tube tube = atlas.look_up(shape, {1, ray.rho});
    BentStates states =
        bent_states(shape, tube.directions.col(0), tube.directions, s.sigmas,
                    {s.dynamics && TubeModel::has_dynamics(shape), atlas.stress() != nullptr});
    const bool all = states.nodes.size() == s.sigmas.size();
    // A shape that the grid surrounds has bent states as the grid has; without them nothing holds.
    sample.errors =
        all ? difference(tube_potential(shape, tube.directions, std::move(tube.nodes)),
                         tube_potential(shape, tube.directions, std::move(states.nodes)), shape)
            : AtlasCheck::Errors{1, 1, 1, 1, 1};
    if (all && !states.dynamics.empty())
      sample.errors.frequency = frequency_difference(
          atlas.dynamics(shape, {1, ray.rho}, s.sigmas.back()), std::move(states.dynamics));
    if (all && atlas.stress())
      sample.errors.stress = stress_error(atlas, shape, ray.rho, std::move(states.stress));
    one_more();
  });
  return check;
}

// Whether a ray has all bent states, [ratio × shape].
Check check_states(const AtlasSettings& settings, const ShapeGrid& grid,
                   const std::vector<BentStates>& states, double rho) {
  for (std::size_t i = 0; i < states.size(); ++i)
    if (states[i].nodes.size() < settings.sigmas.size()) {
      const Vector3d at = grid.shape(static_cast<int>(i));
      return Because(fmt::format(
          "a leaf with w/L = {:.4g}, t/L = 1/{:.4g} has only {} of {} bent states on the ray "
          "(1, {:.3g})",
          std::exp(at[0]), std::exp(-at[1]), states[i].nodes.size(), settings.sigmas.size(), rho));
    }
  return {};
}

}  // namespace

Answer<std::shared_ptr<const TubeAtlas>> make_atlas(const AtlasSettings& settings,
                                                    const AtlasOptions& options) {
  const ShapeGrid grid = shape_grid(settings);
  const int rays = static_cast<int>(settings.rays.size()), per_ray = grid.size();
  const int checks =
      options.check_cells[0] * options.check_cells[1] * static_cast<int>(options.check_rays.size());
  const int total = rays * per_ray + checks;
  std::atomic<int> done = 0;
  const auto one_more = [&] {
    const int so_far = ++done;
    if (options.progress) options.progress(so_far, total);
  };

  const std::vector<AtlasTerm> terms = atlas_terms(settings.sigmas);
  auto store = std::make_shared<Store>(settings, terms);
  const StressAtlasSettings of_stress = stress_settings(settings);
  std::optional<StressAtlasMaker> stress;
  if (settings.stress_patterns > 0) stress.emplace(of_stress);
  for (int ray = 0; ray < rays; ++ray) {
    const double rho = settings.rays[static_cast<std::size_t>(ray)];
    const bool stressed = stress && std::find(of_stress.rays.begin(), of_stress.rays.end(), rho) !=
                                        of_stress.rays.end();
    std::vector<BentStates> states(static_cast<std::size_t>(per_ray));
    options.loop(per_ray, [&](int i) {
      BentStates& own = states[static_cast<std::size_t>(i)];
      own = bent_states(settings, shape_at(settings, grid.shape(i)), rho, stressed);
      if (stressed && own.stress.size() == settings.sigmas.size()) stress->put(i, own.stress);
      own.stress.clear();
      one_more();
    });
    if (Check complete = check_states(settings, grid, states, rho); !complete)
      return Because(std::move(complete.error()));
    fill_ray(settings, terms, ray, states, *store);
    if (settings.dynamics) compress_dynamics(settings, states, *store);
    if (stressed) stress->end_ray();
  }
  const std::shared_ptr<const StressAtlas> tables = stress ? stress->finish() : nullptr;
  TubeAtlas::Numbers numbers{store->exponents.data(),
                             store->values.data(),
                             store->highest.data(),
                             store->units.data(),
                             {},
                             {},
                             store};
  for (const CompressedNumbers& table : store->dynamics) numbers.dynamics.push_back(table.table());
  for (const CompressedNumbers& table : store->stations) numbers.stations.push_back(table.table());
  AtlasCheck check;
  if (checks > 0) check = checked(TubeAtlas(settings, numbers, {}, {}, tables), options, one_more);
  return std::make_shared<TubeAtlas>(settings, numbers, std::move(check), std::string(), tables);
}

}  // namespace flexopt
