#include "core/reduction/atlas/tube_atlas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "core/math/chebyshev.hpp"
#include "core/math/polynomial.hpp"
#include "core/reduction/atlas/atlas_dynamics.hpp"
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
  for (double Errors::*const part :
       {&Errors::drive, &Errors::on_ray, &Errors::off_ray, &Errors::frequency, &Errors::stress}) {
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

std::vector<AtlasTerm> atlas_terms(const std::vector<double>& sigmas) {
  const MonomialTable& table = monomials<6, atlas_degree>();
  std::vector<AtlasTerm> terms;
  for (int n = 0; n < static_cast<int>(sigmas.size()); ++n)
    for (int m = 0; m < table.size(); ++m) {
      const auto e = table.exponents(m);
      const bool across = (e[2] + e[4] + e[5]) % 2 == 0;
      const bool thickness =
          sigmas[static_cast<std::size_t>(n)] != 0 || (e[0] + e[1] + e[2]) % 2 == 0;
      if (across && thickness) terms.push_back({n, m});
    }
  return terms;
}

bool is_highest(const AtlasTerm& term) {
  return monomials<6, atlas_degree>().degree(term.monomial) == atlas_degree;
}

std::array<int, 2> term_counts(const std::vector<AtlasTerm>& terms) {
  const auto highest = static_cast<int>(std::count_if(terms.begin(), terms.end(), is_highest));
  return {static_cast<int>(terms.size()) - highest, highest};
}

StressAtlasSettings stress_settings(const AtlasSettings& s) {
  StressAtlasSettings stress;
  stress.grid = shape_grid(s);
  // every other one, those that turn by nearly equal angles
  const std::size_t wanted = s.rays.size() % 2 == 1 ? s.rays.size() / 2 + 1 : s.rays.size();
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

TubeAtlas::TubeAtlas(AtlasSettings settings, Numbers numbers, AtlasCheck check,
                     std::string fingerprint, std::shared_ptr<const StressAtlas> stress)
    : settings_(std::move(settings)),
      numbers_(std::move(numbers)),
      check_(std::move(check)),
      fingerprint_(std::move(fingerprint)),
      stress_(std::move(stress)),
      terms_(atlas_terms(settings_.sigmas)),
      counts_(term_counts(terms_)),
      grid_(shape_grid(settings_)) {
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

// Sums (A1) over the shapes of the first terms of a ray: terms × (value, its derivatives by log
// w/L, log t/L and ν). Double sums of single and of whole numbers: what is looked up is then smooth
// to rounding.
template <class Number>
MatrixXd TubeAtlas::sums(const Number* numbers, int all_terms, int ray, int terms,
                         const ShapeWeights& weights) const {
  const Eigen::Index rays = static_cast<Eigen::Index>(settings_.rays.size()),
                     count = settings_.shapes(), stride = TubeAtlas::stride(all_terms);
  return weighted_sums(weights, terms, [&](Eigen::Index k) {
    return numbers + ((k / count * rays + ray) * count + k % count) * stride;
  });
}

// Taylor coefficients (A1) of the bent states of a ray, then their derivatives as those of sums().
std::vector<std::vector<std::vector<double>>> TubeAtlas::taylor(int ray,
                                                                const ShapeWeights& weights,
                                                                int nodes) const {
  int terms = 0;
  while (terms < static_cast<int>(terms_.size()) && terms_[terms].node < nodes) ++terms;
  const auto [lower, highest] = term_counts({terms_.begin(), terms_.begin() + terms});
  const auto [all_lower, all_highest] = counts_;
  const MatrixXd of_lower = sums(numbers_.values, all_lower, ray, lower, weights),
                 of_highest = sums(numbers_.highest, all_highest, ray, highest, weights);
  const float* const units = numbers_.units + static_cast<std::size_t>(ray) * all_highest;
  const HalfPowers law(weights.place);
  const std::int8_t* e = numbers_.exponents + 2 * static_cast<std::size_t>(ray) * terms_.size();
  const std::vector<std::vector<double>> none(
      static_cast<std::size_t>(nodes),
      std::vector<double>(static_cast<std::size_t>(monomial_count(6, atlas_degree)), 0.0));
  std::vector<std::vector<std::vector<double>>> W(static_cast<std::size_t>(weights.of.cols()),
                                                  none);
  for (int i = 0, low = 0, high = 0; i < terms; ++i) {
    const bool last = is_highest(terms_[i]);
    const double size = law(e + 2 * i) * (last ? static_cast<double>(units[high]) : 1);
    const auto sum = last ? of_highest.row(high++) : of_lower.row(low++);
    for (int s = 0; s < static_cast<int>(W.size()); ++s)
      W[s][terms_[i].node][terms_[i].monomial] =
          size * (sum[s] + (s == 1 || s == 2 ? 0.5 * e[2 * i + s - 1] * sum[0] : 0));
  }
  return W;
}

// Expansions on any ray: interpolated between the stored rays, and seen from the other end of the
// leaf where that is needed.
std::vector<TubeAtlas::Tube> TubeAtlas::assemble(const PlateShape& shape,
                                                 const Eigen::Vector2d& ray, int nodes,
                                                 ShapeSlopes slopes) const {
  const ShapeWeights at = weights(shape, slopes);
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
  for (std::size_t s = 0; s < static_cast<std::size_t>(at.of.cols()); ++s) {
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

ShapeWeights TubeAtlas::weights(const PlateShape& shape, ShapeSlopes slopes) const {
  return shape_weights(grid_, place_in_grid(shape), slopes);
}

int TubeAtlas::nodes_to(double sigma) const {
  const std::vector<double>& all = settings_.sigmas;
  return static_cast<int>(std::lower_bound(all.begin() + 1, all.end() - 1, sigma) - all.begin()) +
         1;
}

std::vector<DynamicsNode> TubeAtlas::dynamics(const PlateShape& shape, const Eigen::Vector2d& ray,
                                              double sigma, StationsWanted stations) const {
  assert(settings_.dynamics);
  const std::vector<double>& all = settings_.sigmas;
  return look_up_dynamics(
      numbers_.dynamics,
      stations == StationsWanted::yes ? numbers_.stations : std::vector<CompressedTable>(),
      weights(shape, ShapeSlopes::none), ray_neighbours(settings_.rays, place_of(ray).rho),
      {all.begin(), all.begin() + nodes_to(sigma)}, static_cast<int>(all.size()));
}

DynamicsRates TubeAtlas::dynamics_rates(const PlateShape& shape, const Eigen::Vector2d& ray,
                                        double sigma, ShapeSlopes slopes) const {
  assert(settings_.dynamics);
  const std::vector<double>& all = settings_.sigmas;
  DynamicsRates rates = look_up_dynamics_rates(numbers_.dynamics, weights(shape, slopes),
                                               ray_neighbours(settings_.rays, place_of(ray).rho),
                                               {all.begin(), all.begin() + nodes_to(sigma)});
  const Vector3d per = slope_units(shape);
  for (std::size_t p = 0; p < 2; ++p)
    for (StateTable& table : rates[p]) {
      table.even *= per[static_cast<Eigen::Index>(p)];
      table.odd *= per[static_cast<Eigen::Index>(p)];
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
