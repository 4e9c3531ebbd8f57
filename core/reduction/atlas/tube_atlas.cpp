#include "core/reduction/atlas/tube_atlas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/math/chebyshev.hpp"
#include "core/math/polynomial.hpp"
#include "core/reduction/atlas/atlas_dynamics.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"

namespace flexopt {
namespace {

constexpr double rounding = 1e-9;  // of a box and of rays

// ρ in [−1, 1] of a ray (1, ρ), or of one seen from the other end.
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

double median_of(std::vector<double> x) {
  if (x.empty()) return 0;
  std::sort(x.begin(), x.end());
  return x[x.size() / 2];
}

}  // namespace

AtlasCheck::Errors AtlasCheck::Ray::largest() const {
  Errors worst;
  for (const Sample& s : samples) {
    worst.drive = std::max(worst.drive, s.errors.drive);
    worst.on_ray = std::max(worst.on_ray, s.errors.on_ray);
    worst.off_ray = std::max(worst.off_ray, s.errors.off_ray);
    worst.frequency = std::max(worst.frequency, s.errors.frequency);
    worst.stress = std::max(worst.stress, s.errors.stress);
  }
  return worst;
}

AtlasCheck::Errors AtlasCheck::Ray::median() const {
  const auto of = [&](double Errors::*part) {
    std::vector<double> all;
    for (const Sample& s : samples) all.push_back(s.errors.*part);
    return median_of(std::move(all));
  };
  return {of(&Errors::drive), of(&Errors::on_ray), of(&Errors::off_ray), of(&Errors::frequency),
          of(&Errors::stress)};
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

StressAtlasSettings stress_settings(const AtlasSettings& s) {
  StressAtlasSettings stress;
  stress.grid = {chebyshev_points(std::log(s.width[0]), std::log(s.width[1]), s.points[0]),
                 chebyshev_points(std::log(s.thickness[0]), std::log(s.thickness[1]), s.points[1]),
                 s.poissons_ratios};
  const std::size_t step = s.rays.size() % 2 == 1 ? 2 : 1;
  for (std::size_t k = 0; k < s.rays.size(); k += step) stress.rays.push_back(s.rays[k]);
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
      grid_(shape_grid(settings_)) {
  assert(settings_.rays.size() >= 2 && settings_.rays.front() == -1 && settings_.rays.back() == 1);
  assert(settings_.sigmas.size() >= 2 && settings_.sigmas.front() == 0);
}

std::string TubeAtlas::gap(const PlateShape& shape, const TubeRange& range) const {
  const AtlasSettings& s = settings_;
  const auto outside = [](double x, double low, double high) {
    return x < low * (1 - rounding) || x > high * (1 + rounding);
  };
  if (shape.is_beam()) return "it is a beam";
  if (shape.curve) return "it is curved";
  if (shape.fold) return "it is folded";
  if (shape.has_profile()) return "its width or thickness varies";
  if (shape.mesh != s.mesh || shape.free_edge_torsion != s.free_edge_torsion)
    return "it has another mesh";
  if (range.order != 2) return "it has another degree";
  if (range.force_centre != 0) return "it is centred on a load";
  if (outside(shape.width, s.width[0], s.width[1]))
    return fmt::format("its width is {:.3g} of its length, not {:.3g} to {:.3g}", shape.width,
                       s.width[0], s.width[1]);
  if (outside(shape.thickness, s.thickness[0], s.thickness[1]))
    return fmt::format("its thickness is 1/{:.4g} of its length, not 1/{:.4g} to 1/{:.4g}",
                       1 / shape.thickness, 1 / s.thickness[0], 1 / s.thickness[1]);
  const double nu = shape.poissons_ratio;
  if (nu < s.poissons_ratios.front() - rounding || nu > s.poissons_ratios.back() + rounding)
    return fmt::format("its Poisson's ratio is {:.3g}, not {:.3g} to {:.3g}", nu,
                       s.poissons_ratios.front(), s.poissons_ratios.back());
  if (range.sigma_max > s.sigmas.back())
    return fmt::format("it bends to {:.3g} rad, beyond {:.3g}", range.sigma_max, s.sigmas.back());
  return {};
}

// Weights of all shapes, and what (A1) multiplies their sums by.
struct TubeAtlas::Weights {
  std::vector<double> shapes;                 ///< value
  std::array<std::vector<double>, 2> slopes;  ///< by log w/L, log t/L
  std::vector<double> poissons_ratios;
  double log_width = 0, log_thickness = 0;
};

TubeAtlas::Weights TubeAtlas::weights(const PlateShape& shape, bool with_slopes) const {
  Weights w;
  w.log_width = std::log(shape.width);
  w.log_thickness = std::log(shape.thickness);
  const PointWeights x = polynomial_weights(grid_.log_width, w.log_width),
                     y = polynomial_weights(grid_.log_thickness, w.log_thickness);
  const auto product = [](const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> all;
    all.reserve(a.size() * b.size());
    for (const double p : a)
      for (const double q : b) all.push_back(p * q);
    return all;
  };
  w.shapes = product(x.value, y.value);
  if (with_slopes) w.slopes = {product(x.slope, y.value), product(x.value, y.slope)};
  w.poissons_ratios = polynomial_weights(settings_.poissons_ratios, shape.poissons_ratio).value;
  return w;
}

// Σ over Poisson's ratios and shapes of the first terms of a ray. Double sums of single numbers:
// what is looked up is then smooth to rounding.
std::vector<double> TubeAtlas::sums(int ray, int terms, const Weights& weights,
                                    const std::vector<double>& shapes) const {
  const int stride = TubeAtlas::stride(static_cast<int>(terms_.size()));
  const int rays = static_cast<int>(settings_.rays.size()), count = settings_.shapes();
  std::vector<double> y(static_cast<std::size_t>(terms), 0.0);
  double* const out = y.data();
  std::array<const float*, 4> column{};
  std::array<double, 4> weight{};
  int open = 0;
  const auto flush = [&] {
    for (int k = open; k < 4; ++k) {
      weight[k] = 0;
      column[k] = column[0];
    }
    const float *a = column[0], *b = column[1], *c = column[2], *d = column[3];
    const double wa = weight[0], wb = weight[1], wc = weight[2], wd = weight[3];
    for (int i = 0; i < terms; ++i) out[i] += (wa * a[i] + wb * b[i]) + (wc * c[i] + wd * d[i]);
    open = 0;
  };
  for (std::size_t n = 0; n < weights.poissons_ratios.size(); ++n) {
    if (weights.poissons_ratios[n] == 0) continue;
    const float* table =
        numbers_.values + (n * rays + ray) * static_cast<std::size_t>(count) * stride;
    for (int k = 0; k < count; ++k) {
      const double w = weights.poissons_ratios[n] * shapes[static_cast<std::size_t>(k)];
      if (w == 0) continue;
      column[open] = table + static_cast<std::size_t>(k) * stride;
      weight[open] = w;
      if (++open == 4) flush();
    }
  }
  if (open > 0) flush();
  return y;
}

// Taylor coefficients of the bent states of a ray, (A1), or their derivatives by log w/L (slope 0)
// or log t/L (1); slope −1: the coefficients themselves.
std::vector<std::vector<double>> TubeAtlas::taylor(int ray, const Weights& weights, int nodes,
                                                   int slope) const {
  int terms = 0;
  while (terms < static_cast<int>(terms_.size()) && terms_[terms].node < nodes) ++terms;
  std::vector<double> y =
      sums(ray, terms, weights, slope < 0 ? weights.shapes : weights.slopes[slope]);
  const std::vector<double> value =
      slope < 0 ? std::vector<double>() : sums(ray, terms, weights, weights.shapes);
  // halves of powers, from −8 to 8
  constexpr int most = 16;
  std::array<double, 2 * most + 1> powers[2];
  for (int k = -most; k <= most; ++k) {
    powers[0][k + most] = std::exp(0.5 * k * weights.log_width);
    powers[1][k + most] = std::exp(0.5 * k * weights.log_thickness);
  }
  const std::int8_t* e = numbers_.exponents + 2 * static_cast<std::size_t>(ray) * terms_.size();
  std::vector<std::vector<double>> W(
      static_cast<std::size_t>(nodes),
      std::vector<double>(static_cast<std::size_t>(monomial_count(6, atlas_degree)), 0.0));
  for (int i = 0; i < terms; ++i) {
    double c = y[i];
    if (slope >= 0) c += 0.5 * e[2 * i + slope] * value[i];
    W[terms_[i].node][terms_[i].monomial] =
        c * powers[0][e[2 * i] + most] * powers[1][e[2 * i + 1] + most];
  }
  return W;
}

TubeAtlas::Tube TubeAtlas::assemble(const Weights& weights, const Eigen::Vector2d& ray, int nodes,
                                    int slope) const {
  assert(ray.cwiseAbs().maxCoeff() == 1 && (ray[0] > 0 || (ray[0] == 0 && ray[1] != 0)));
  const RayPlace place = place_of(ray);
  const RayNeighbours between = ray_neighbours(settings_.rays, place.rho);
  const auto at_a = between.on_right ? std::vector<std::vector<double>>()
                                     : taylor(between.left, weights, nodes, slope);
  const auto at_b = between.on_left ? std::vector<std::vector<double>>()
                                    : taylor(between.left + 1, weights, nodes, slope);
  Tube tube;
  tube.directions = ray_directions(between.rho);
  if (place.other_end) {
    tube.directions.row(0).swap(tube.directions.row(1));
    if (!place.same_sign) tube.directions *= -1;
  }
  for (int n = 0; n < nodes; ++n) {
    const double sigma = settings_.sigmas[static_cast<std::size_t>(n)];
    std::vector<double> W =
        between.on_left    ? at_a[n]
        : between.on_right ? at_b[n]
                           : between_rays(at_a[n], between.a, at_b[n], between.b, sigma, place.rho);
    if (place.other_end) W = from_other_end(W, place.same_sign);
    tube.nodes.push_back({sigma, std::move(W)});
  }
  return tube;
}

std::vector<DynamicsNode> TubeAtlas::dynamics(const PlateShape& shape, const Eigen::Vector2d& ray,
                                              double sigma, int slope) const {
  assert(settings_.dynamics);
  const std::vector<double>& all = settings_.sigmas;
  const auto enough = std::lower_bound(all.begin() + 1, all.end() - 1, sigma) - all.begin() + 1;
  const Vector3d place(std::log(shape.width), std::log(shape.thickness), shape.poissons_ratio);
  return look_up_dynamics(numbers_.dynamics, numbers_.stations,
                          shape_weights(grid_, place, slope >= 0),
                          ray_neighbours(settings_.rays, place_of(ray).rho),
                          {all.begin(), all.begin() + enough}, static_cast<int>(all.size()), slope);
}

TubeAtlas::Tube TubeAtlas::look_up(const PlateShape& shape, const Eigen::Vector2d& ray,
                                   int nodes) const {
  const int all = static_cast<int>(settings_.sigmas.size());
  return assemble(weights(shape, false), ray, nodes > 0 ? std::min(nodes, all) : all, -1);
}

TubeView TubeAtlas::view(const Eigen::Vector2d& ray) {
  const RayPlace place = place_of(ray);
  return {place.other_end, place.other_end && place.same_sign};
}

std::vector<StateTable> TubeAtlas::look_up_stress(const PlateShape& shape,
                                                  const Eigen::Vector2d& ray, int nodes) const {
  assert(stress_);
  const int all = static_cast<int>(settings_.sigmas.size());
  return stress_->look_up(shape, std::clamp(place_of(ray).rho, -1.0, 1.0),
                          nodes > 0 ? std::min(nodes, all) : all);
}

TubeAtlas::Rates TubeAtlas::look_up_with_rates(const PlateShape& shape,
                                               const Eigen::Vector2d& ray) const {
  const int all = static_cast<int>(settings_.sigmas.size());
  const Weights w = weights(shape, true);
  Rates rates{assemble(w, ray, all, -1),
              {assemble(w, ray, all, 0).nodes, assemble(w, ray, all, 1).nodes, {}}};
  // a longer leaf is one of smaller w/L and t/L
  rates.by_size[2] = rates.by_size[0];
  for (std::size_t n = 0; n < rates.by_size[2].size(); ++n)
    for (std::size_t k = 0; k < rates.by_size[2][n].W.size(); ++k)
      rates.by_size[2][n].W[k] = -rates.by_size[0][n].W[k] - rates.by_size[1][n].W[k];
  return rates;
}

}  // namespace flexopt
