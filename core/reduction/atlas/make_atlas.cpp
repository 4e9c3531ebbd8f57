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
#include "core/reduction/atlas/number_units.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"
#include "core/reduction/tube/mixed_condensation.hpp"
#include "core/reduction/tube/tube_leaf.hpp"

namespace flexopt {

void run_in_order(int count, const std::function<void(int)>& work) {
  for (int i = 0; i < count; ++i) work(i);
}

namespace {

BentStates bent_states(const AtlasSettings& settings, const PlateShape& shape, double rho,
                       const StateTablesWanted& wanted) {
  BentStates states = bent_states(shape, {1, rho}, ray_directions(rho), settings.sigmas, wanted);
  if (std::abs(rho) == 1)  // equal ends, equal numbers
    for (TubeNode& node : states.nodes) {
      const std::vector<double> turned = end_for_end(node.W, rho);
      for (std::size_t k = 0; k < node.W.size(); ++k) node.W[k] = 0.5 * (node.W[k] + turned[k]);
    }
  return states;
}

// The numbers of an atlas while they are made: of each ray all bent states.
struct Made {
  std::vector<std::vector<NumbersOfShapes>> potentials, dynamics, stations;
};

// Adds the numbers of a ray from the bent states of all shapes of the grid.
void add_ray(const AtlasSettings& settings, const std::vector<BentStates>& states, Made& made) {
  const std::size_t nodes = settings.sigmas.size();
  std::vector<NumbersOfShapes>& potentials = made.potentials.emplace_back();
  for (std::size_t n = 0; n < nodes; ++n) {
    const std::vector<int> terms = atlas_terms(settings.sigmas[n]);
    NumbersOfShapes& of = potentials.emplace_back(terms.size(), states.size());
    for (std::size_t k = 0; k < states.size(); ++k)
      for (std::size_t i = 0; i < terms.size(); ++i)
        of(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
            static_cast<float>(states[k].nodes[n].W[static_cast<std::size_t>(terms[i])]);
  }
  if (!settings.dynamics) return;
  std::vector<NumbersOfShapes>&dynamics = made.dynamics.emplace_back(),
  &stations = made.stations.emplace_back();
  for (std::size_t n = 0; n < nodes; ++n) {
    const auto numbers_of = [&](Eigen::Index numbers, const auto& of) {
      NumbersOfShapes all(numbers, states.size());
      for (std::size_t k = 0; k < states.size(); ++k)
        all.col(static_cast<Eigen::Index>(k)) = VectorXd(of(states[k].dynamics[n])).cast<float>();
      return all;
    };
    dynamics.push_back(numbers_of(dynamics_form().numbers(), [](const DynamicsNode& node) {
      return table_numbers(node.table);
    }));
    stations.push_back(
        numbers_of(states.front().dynamics[n].stations.size(),
                   [](const DynamicsNode& node) { return node.stations.reshaped(); }));
  }
}

// The tables of all rays. Shapes that nobody may ask the dynamics of count less.
TubeAtlas::Tables coded(const AtlasSettings& settings, Made made) {
  constexpr double share_beyond = 0.3;
  TubeAtlas::Tables tables;
  const ShapeGrid grid = shape_grid(settings);
  const std::vector<NumberUnits> units = potential_units(settings, made.potentials);
  tables.potentials =
      code_tables(grid, VectorXd::Ones(grid.size()), units, std::move(made.potentials));
  if (!settings.dynamics) return tables;
  VectorXd share(grid.size());
  for (int k = 0; k < grid.size(); ++k)
    share[k] = TubeModel::has_dynamics(shape_at(settings, grid.shape(k))) ? 1 : share_beyond;
  const DynamicsUnits units_of =
      dynamics_units(settings, made.dynamics, made.stations.front().front().rows());
  tables.dynamics = code_tables(grid, share, units_of.tables, std::move(made.dynamics));
  tables.stations = code_tables(grid, share, units_of.stations, std::move(made.stations));
  return tables;
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
      if (b.change(place) > largest_dynamics_change) continue;  // nobody uses them
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

}  // namespace

AtlasCheck::Errors atlas_errors(const TubeAtlas& atlas, double rho,
                                const AtlasCheck::Sample& sample) {
  const AtlasSettings& s = atlas.settings();
  const PlateShape shape{sample.width, sample.thickness, sample.poissons_ratio, s.mesh,
                         s.free_edge_torsion};
  TubeAtlas::Tube tube = atlas.look_up(shape, {1, rho});
  BentStates states =
      bent_states(shape, tube.directions.col(0), tube.directions, s.sigmas,
                  {s.dynamics && TubeModel::has_dynamics(shape), atlas.stress() != nullptr});
  // A shape that the grid surrounds has bent states as the grid has; without them nothing holds.
  if (states.nodes.size() < s.sigmas.size()) return {1, 1, 1, 1, 1};
  AtlasCheck::Errors errors =
      difference(tube_potential(shape, tube.directions, std::move(tube.nodes)),
                 tube_potential(shape, tube.directions, std::move(states.nodes)), shape);
  if (!states.dynamics.empty())
    errors.frequency = frequency_difference(atlas.dynamics(shape, {1, rho}, s.sigmas.back()),
                                            std::move(states.dynamics));
  if (atlas.stress()) errors.stress = stress_error(atlas, shape, rho, std::move(states.stress));
  return errors;
}

namespace {

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
    sample.errors = atlas_errors(atlas, ray.rho, sample);
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

  Made made;
  const StressAtlasSettings of_stress = stress_settings(settings);
  std::optional<StressAtlasMaker> stress;
  if (settings.stress_patterns > 0)
    stress.emplace(of_stress, std::make_shared<StrainPatterns>(find_patterns(of_stress)));
  for (int ray = 0; ray < rays; ++ray) {
    const double rho = settings.rays[static_cast<std::size_t>(ray)];
    const bool stressed = stress && std::ranges::find(of_stress.rays, rho) != of_stress.rays.end();
    if (stressed) stress->begin_ray();
    std::vector<BentStates> states(static_cast<std::size_t>(per_ray));
    options.loop(per_ray, [&](int i) {
      BentStates& own = states[static_cast<std::size_t>(i)];
      own = bent_states(settings, shape_at(settings, grid.shape(i)), rho,
                        {settings.dynamics, stressed});
      if (stressed && own.stress.size() == settings.sigmas.size()) stress->put(i, own.stress);
      own.stress.clear();
      one_more();
    });
    if (Check complete = check_states(settings, grid, states, rho); !complete)
      return Because(std::move(complete.error()));
    add_ray(settings, states, made);
  }
  const std::shared_ptr<const StressAtlas> of = stress ? stress->finish() : nullptr;
  const TubeAtlas::Tables tables = coded(settings, std::move(made));
  AtlasCheck check;
  if (checks > 0) check = checked(TubeAtlas(settings, tables, {}, {}, of), options, one_more);
  return std::make_shared<TubeAtlas>(settings, tables, std::move(check), std::string(), of);
}

}  // namespace flexopt
