#include "core/reduction/atlas/tube_atlas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "core/math/chebyshev.hpp"
#include "core/math/polynomial.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"

namespace flexopt {
namespace {

constexpr double rounding = 1e-9;  // of a box

// ρ in [−1, 1] of a ray (1, ρ), or of a ray that is seen from the other end of the leaf.
struct RayPlace {
  double rho = 0;
  bool other_end = false;
  bool same_sign = true;  ///< of D from the other end
};
RayPlace place_of(const Eigen::Vector2d& ray) {
  RayPlace place;
  place.other_end = std::abs(ray[0]) < std::abs(ray[1]);
  place.rho = place.other_end ? ray[0] / ray[1] : ray[1] / ray[0];
  place.same_sign = !place.other_end || ray[1] > 0;
  return place;
}

// The errors of all samples together, each kind by summary(errors).
template <class Summary>
AtlasCheck::Errors summarised(const std::vector<AtlasCheck::Sample>& samples,
                              const Summary& summary) {
  using Errors = AtlasCheck::Errors;
  Errors all;
  for (double Errors::*const part : Errors::parts) {
    std::vector<double> errors;
    for (const AtlasCheck::Sample& s : samples) errors.push_back(s.errors.*part);
    if (!errors.empty()) all.*part = summary(errors);
  }
  return all;
}

}  // namespace

AtlasCheck::Errors AtlasCheck::Ray::largest() const {
  return summarised(samples, [](const std::vector<double>& x) { return std::ranges::max(x); });
}

AtlasCheck::Errors AtlasCheck::Ray::median() const {
  return summarised(samples, [](std::vector<double>& x) {
    std::ranges::sort(x);
    return x[x.size() / 2];
  });
}

ShapeGrid shape_grid(const AtlasSettings& s) {
  return {chebyshev_points(std::log(s.width[0]), std::log(s.width[1]), s.points[0]),
          chebyshev_points(std::log(s.thickness[0]), std::log(s.thickness[1]), s.points[1]),
          s.poissons_ratios};
}

PlateShape shape_at(const AtlasSettings& settings, const Vector3d& place) {
  return {std::exp(place[0]), std::exp(place[1]), place[2], settings.mesh,
          settings.free_edge_torsion};
}

std::vector<int> atlas_terms(double sigma) {
  const MonomialTable& table = monomials<6, atlas_degree>();
  std::vector<int> terms;
  for (int m = 0; m < table.size(); ++m) {
    const auto e = table.exponents(m);
    const bool across = (e[2] + e[4] + e[5]) % 2 == 0,
               thickness = sigma != 0 || (e[0] + e[1] + e[2]) % 2 == 0;
    if (across && thickness) terms.push_back(m);
  }
  return terms;
}

TableForm dynamics_form() {
  const auto [evens, odds] = TubeDynamics::entries();
  return {evens, odds};
}

StressAtlasSettings stress_settings(const AtlasSettings& s) {
  StressAtlasSettings stress;
  stress.grid = shape_grid(s);
  // every other one, those that turn by nearly equal angles
  const std::size_t wanted = std::max<std::size_t>(2, (s.rays.size() + 1) / 2);
  for (std::size_t k = 0; k < wanted; ++k) {
    const double angle =
        std::numbers::pi / 2 * (static_cast<double>(k) / static_cast<double>(wanted - 1) - 0.5);
    const double nearest = *std::min_element(s.rays.begin(), s.rays.end(), [&](double a, double b) {
      return std::abs(std::atan(a) - angle) < std::abs(std::atan(b) - angle);
    });
    if (stress.rays.empty() || nearest > stress.rays.back()) stress.rays.push_back(nearest);
  }
  stress.sigmas = s.sigmas;
  stress.mesh = s.mesh;
  stress.free_edge_torsion = s.free_edge_torsion;
  stress.patterns = s.stress_patterns;
  stress.samples = s.stress_samples;
  return stress;
}

TubeAtlas::TubeAtlas(AtlasSettings settings, Tables tables, AtlasCheck check,
                     std::string fingerprint, std::shared_ptr<const StressAtlas> stress)
    : settings_(std::move(settings)),
      tables_(std::move(tables)),
      check_(std::move(check)),
      fingerprint_(std::move(fingerprint)),
      stress_(std::move(stress)) {
  assert(settings_.rays.size() >= 2 && settings_.rays.front() == -1 && settings_.rays.back() == 1);
  assert(settings_.sigmas.size() >= 2 && settings_.sigmas.front() == 0);
}

Check TubeAtlas::covers(const PlateShape& shape, const TubeRange& range) const {
  const AtlasSettings& s = settings_;
  const auto outside = [](double x, double low, double high) {
    return x < low * (1 - rounding) || x > high * (1 + rounding);
  };
  if (shape.is_beam()) return Because("it is a beam");
  if (shape.curve) return Because("it is curved");
  if (shape.fold) return Because("it is folded");
  if (shape.has_profile()) return Because("its width or thickness varies");
  if (shape.mesh != s.mesh || shape.free_edge_torsion != s.free_edge_torsion)
    return Because("it has another mesh");
  if (!shape.transverse_shear) return Because("it has no transverse shear");
  if (range.order != 2) return Because("it has another degree");
  if (range.force_centre != 0) return Because("it is centred on a load");
  if (outside(shape.width, s.width[0], s.width[1]))
    return Because(fmt::format("its width is {:.3g} of its length, not {:.3g} to {:.3g}",
                               shape.width, s.width[0], s.width[1]));
  if (outside(shape.thickness, s.thickness[0], s.thickness[1]))
    return Because(fmt::format("its thickness is 1/{:.4g} of its length, not 1/{:.4g} to 1/{:.4g}",
                               1 / shape.thickness, 1 / s.thickness[0], 1 / s.thickness[1]));
  const double nu = shape.poissons_ratio;
  if (nu < s.poissons_ratios.front() - rounding || nu > s.poissons_ratios.back() + rounding)
    return Because(fmt::format("its Poisson's ratio is {:.3g}, not {:.3g} to {:.3g}", nu,
                               s.poissons_ratios.front(), s.poissons_ratios.back()));
  if (range.sigma_max > s.sigmas.back())
    return Because(
        fmt::format("it bends to {:.3g} rad, beyond {:.3g}", range.sigma_max, s.sigmas.back()));
  return {};
}

// Taylor coefficients about the bent states of a ray, then their derivatives by log w/L, log t/L
// and ν, as many as the place has.
std::vector<std::vector<std::vector<double>>> TubeAtlas::taylor(int ray,
                                                                const CodedTables::Place& at,
                                                                int nodes) const {
  std::vector<std::vector<std::vector<double>>> W(static_cast<std::size_t>(at.coordinates.rows()));
  for (int n = 0; n < nodes; ++n) {
    const MatrixXd c = tables_.potentials->look_up(ray, n, at);
    const std::vector<int> terms = atlas_terms(settings_.sigmas[static_cast<std::size_t>(n)]);
    for (std::size_t s = 0; s < W.size(); ++s) {
      std::vector<double>& of =
          W[s].emplace_back(static_cast<std::size_t>(monomial_count(6, atlas_degree)), 0.0);
      for (std::size_t i = 0; i < terms.size(); ++i)
        of[static_cast<std::size_t>(terms[i])] =
            c(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(s));
    }
  }
  return W;
}

// Expansions on any ray: interpolated between the stored rays, and seen from the other end of the
// leaf where that is needed.
std::vector<TubeAtlas::Tube> TubeAtlas::assemble(const PlateShape& shape,
                                                 const Eigen::Vector2d& ray, int nodes,
                                                 ShapeSlopes slopes) const {
  const CodedTables::Place at = tables_.potentials->place(shape, slopes);
  const int all = static_cast<int>(settings_.sigmas.size());
  nodes = nodes > 0 ? std::min(nodes, all) : all;
  assert(ray.cwiseAbs().maxCoeff() == 1 && (ray[0] > 0 || (ray[0] == 0 && ray[1] != 0)));
  const RayPlace place = place_of(ray);
  const RayNeighbours between = ray_neighbours(settings_.rays, place.rho);
  using Taylor = std::vector<std::vector<std::vector<double>>>;
  const Taylor at_a = between.on_right ? Taylor() : taylor(between.left, at, nodes);
  const Taylor at_b = between.on_left ? Taylor() : taylor(between.left + 1, at, nodes);
  Eigen::Matrix2d directions = ray_directions(between.rho);
  if (place.other_end) {
    directions.row(0).swap(directions.row(1));
    if (!place.same_sign) directions *= -1;
  }
  std::vector<Tube> tubes;
  for (std::size_t s = 0; s < static_cast<std::size_t>(at.coordinates.rows()); ++s) {
    Tube& tube = tubes.emplace_back();
    tube.directions = directions;
    for (int n = 0; n < nodes; ++n) {
      const double sigma = settings_.sigmas[static_cast<std::size_t>(n)];
      std::vector<double> W = between.on_left    ? at_a[s][n]
                              : between.on_right ? at_b[s][n]
                                                 : between_rays(at_a[s][n], between.a, at_b[s][n],
                                                                between.b, sigma, place.rho);
      if (place.other_end) W = from_other_end(W, place.same_sign);
      tube.nodes.push_back({sigma, std::move(W)});
    }
  }
  return tubes;
}

int TubeAtlas::nodes_to(double sigma) const {
  const std::vector<double>& all = settings_.sigmas;
  return static_cast<int>(std::lower_bound(all.begin() + 1, all.end() - 1, sigma) - all.begin()) +
         1;
}

std::vector<DynamicsNode> TubeAtlas::dynamics(const PlateShape& shape, const Eigen::Vector2d& ray,
                                              double sigma, StationsWanted wanted) const {
  assert(tables_.dynamics);
  const RayNeighbours at = ray_neighbours(settings_.rays, place_of(ray).rho);
  const CodedTables::Place place = tables_.dynamics->place(shape, ShapeSlopes::none);
  std::vector<DynamicsNode> found;
  for (int n = 0; n < nodes_to(sigma); ++n)
    found.push_back(
        {std::move(look_up_tables(*tables_.dynamics, place, at, n,
                                  settings_.sigmas[static_cast<std::size_t>(n)], dynamics_form())
                       .front()),
         {}});
  if (wanted == StationsWanted::no) return found;
  const CodedTables::Place of_stations = tables_.stations->place(shape, ShapeSlopes::none);
  const double t = at.on_left ? 0 : at.on_right ? 1 : (at.rho - at.a) / (at.b - at.a);
  for (std::size_t n = 0; n < found.size(); ++n) {
    const auto motion = [&](int k) {
      return tables_.stations->look_up(k, static_cast<int>(n), of_stations);
    };
    MatrixXd all = MatrixXd::Zero(tables_.stations->counts()[n], 1);
    if (t < 1) all += (1 - t) * motion(at.left);
    if (t > 0) all += t * motion(at.left + 1);
    found[n].stations = all.reshaped(all.rows() / 2, 2);
  }
  return found;
}

DynamicsRates TubeAtlas::dynamics_rates(const PlateShape& shape, const Eigen::Vector2d& ray,
                                        double sigma, ShapeSlopes slopes) const {
  assert(tables_.dynamics);
  const RayNeighbours at = ray_neighbours(settings_.rays, place_of(ray).rho);
  const CodedTables::Place place = tables_.dynamics->place(shape, slopes);
  const Vector3d per = slope_units(shape);
  DynamicsRates rates(static_cast<std::size_t>(slope_count(slopes)));
  for (int n = 0; n < nodes_to(sigma); ++n) {
    std::vector<StateTable> found =
        look_up_tables(*tables_.dynamics, place, at, n,
                       settings_.sigmas[static_cast<std::size_t>(n)], dynamics_form());
    for (std::size_t p = 0; p < rates.size(); ++p) {
      found[p + 1].even *= per[static_cast<Eigen::Index>(p)];
      found[p + 1].odd *= per[static_cast<Eigen::Index>(p)];
      rates[p].push_back(std::move(found[p + 1]));
    }
  }
  return rates;
}

TubeAtlas::Tube TubeAtlas::look_up(const PlateShape& shape, const Eigen::Vector2d& ray,
                                   int nodes) const {
  return std::move(assemble(shape, ray, nodes, ShapeSlopes::none).front());
}

TubeView TubeAtlas::view(const Eigen::Vector2d& ray) {
  const RayPlace place = place_of(ray);
  return {place.other_end, place.other_end && place.same_sign};
}

std::vector<StateTable> TubeAtlas::look_up_stress(const PlateShape& shape,
                                                  const Eigen::Vector2d& ray, int nodes) const {
  assert(stress_);
  const int all = static_cast<int>(settings_.sigmas.size());
  return stress_->look_up(shape, ray_neighbours(settings_.rays, place_of(ray).rho).rho,
                          nodes > 0 ? std::min(nodes, all) : all);
}

StressRateSource TubeAtlas::stress_rates(const PlateShape& shape, const Eigen::Vector2d& ray,
                                         ShapeSlopes slopes) const {
  assert(stress_);
  return stress_->rates(shape, ray_neighbours(settings_.rays, place_of(ray).rho).rho, slopes);
}

TubeNodeRates TubeAtlas::look_up_rates(const PlateShape& shape, const Eigen::Vector2d& ray,
                                       int nodes, ShapeSlopes slopes) const {
  std::vector<Tube> found = assemble(shape, ray, nodes, slopes);
  const Vector3d per = slope_units(shape);
  TubeNodeRates rates;
  for (std::size_t p = 0; p + 1 < found.size(); ++p) {
    for (TubeNode& node : found[p + 1].nodes)
      for (double& c : node.W) c *= per[static_cast<Eigen::Index>(p)];
    rates.push_back(std::move(found[p + 1].nodes));
  }
  return rates;
}

}  // namespace flexopt
