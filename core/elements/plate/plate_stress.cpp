#include "core/elements/plate/plate_stress.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/elements/plate/beam_stress.hpp"
#include "core/elements/plate/deformed_plate.hpp"
#include "core/mechanism/profile.hpp"

namespace flexopt {
namespace {

// Plane stress of strains e11, e22 and 2 e12, which are numbers or arrays.
template <class A, class S>
std::array<A, 3> plane_stress(const A& e11, const A& e22, const A& twice_e12, const S& nu,
                              const S& modulus) {
  const S k = modulus / (1.0 - nu * nu);
  return {k * (e11 + nu * e22), k * (e22 + nu * e11), S(k * 0.5 * (1.0 - nu)) * twice_e12};
}

}  // namespace

SurfaceStresses surface_stresses(const MatrixXd& strains, const Eigen::ArrayXd& thickness,
                                 double poissons_ratio, double youngs_modulus) {
  const auto side = [&](double sign) -> Eigen::ArrayXd {
    std::array<Eigen::ArrayXd, 3> e;
    for (int k = 0; k < 3; ++k)
      e[k] = strains.col(k).array() + (0.5 * sign) * thickness * strains.col(k + 3).array();
    const auto [s11, s22, s12] = plane_stress(e[0], e[1], e[2], poissons_ratio, youngs_modulus);
    return (s11 * s11 - s11 * s22 + s22 * s22 + 3.0 * s12 * s12).max(0.0).sqrt();
  };
  return {side(1), side(-1)};
}

SectionStress section_stress(const PlateShape& shape, const Strains& e, double youngs_modulus,
                             double along) {
  const double nu = shape.poissons_ratio, half = 0.5 * shape.thickness_at(along);
  const auto mean = plane_stress(e[0], e[1], e[2], nu, youngs_modulus),
             bend = plane_stress(e[3], e[4], e[5], nu, half * youngs_modulus);
  return (SectionStress() << mean[0], mean[1], mean[2], bend[0], bend[1], bend[2]).finished();
}

namespace {

// Stations from a to b, with both ends and the borders of the corner zones.
std::vector<double> stations(double a, double b, int intervals, double zone) {
  std::vector<double> s = graded_points(a, b, intervals, 0.5);
  s.push_back(a + zone);
  s.push_back(b - zone);
  std::sort(s.begin(), s.end());
  return s;
}

}  // namespace

StressStations stress_stations(const PlateShape& shape) {
  if (shape.is_beam()) return beam_stations(shape);
  const double width = shape.width, zone = 0.1 * std::min(1.0, shape.mean_width()),
               side = zone * (width / shape.mean_width());
  StressStations at;
  at.corner_along = zone * (1 - 1e-9);
  at.corner_across = side / width * (1 - 1e-9);
  // closer where the thickness varies: at places that do not depend on the mesh, nor the profile
  at.along = stations(0, 1, shape.thickness_profile.empty() ? 16 : 64, zone);
  if (shape.fold) {  // each leg's own, on both sides of the fold
    const double fold = shape.fold->place;
    at.along = graded_points(0, fold, 16, 0.5);
    at.along.push_back(zone);
    at.along.push_back(1 - zone);
    for (const double place : graded_points(fold, 1, 16, 0.5))
      at.along.push_back(place == fold ? behind_fold(fold) : place);
    std::sort(at.along.begin(), at.along.end());
  }
  for (const double y : stations(-width / 2, width / 2, 8, side))
    at.across.push_back((y + width / 2) / width);
  return at;
}

LeafStress plate_stress(StrainField field, const PlateShape& shape, double youngs_modulus,
                        int index) {
  const auto sections = [field = std::move(field), &shape,
                         youngs_modulus](const std::vector<StressPlace>& places) {
    MatrixXd stresses(6, static_cast<Eigen::Index>(places.size()));
    for (Eigen::Index i = 0; i < stresses.cols(); ++i) {
      const StressPlace& at = places[static_cast<std::size_t>(i)];
      stresses.col(i) = section_stress(shape, field.at(at.along, (at.across - 0.5) * shape.width),
                                       youngs_modulus, at.along);
    }
    return stresses;
  };
  return {index, stress_stations(shape), sections, {}};
}

LeafStress leaf_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                       const LeafSpring& leaf, const LeafScale& scale, int index) {
  const double modulus = leaf.material.youngs_modulus;
  LeafStress stress = mesh.shape().is_beam() ? LeafStress{index,
                                                          stress_stations(mesh.shape()),
                                                          beam_sections(mesh, nodal, modulus),
                                                          {}}
                                             : plate_stress(recovered_strains(mesh, nodal),
                                                            mesh.shape(), modulus, index);
  stress.position = [&mesh, &scale, nodal](const StressPlace& at) {
    return plate_material_points(mesh, nodal, scale, {{at.along, at.across}}).front();
  };
  return stress;
}

namespace {

/// Strains at a place, and half the thickness there over L, with their derivatives.
struct MovingSection {
  StrainsT<Dual1> strains;
  Dual1 half;
};

// Section whose strains move only with the four stations around the place.
template <class StrainsAt>
MovingSection moving_section(const PlateShape& shape, const std::vector<Dual1>& xs,
                             const std::vector<double>& ys, const StrainsAt& strains_at,
                             double along, double across_share, const ShapeRate& rate) {
  const Dual1 width(shape.width, {rate.size[0]}), thickness(shape.thickness, {rate.size[1]});
  // places over L; the border of the corner zones moves with the width of narrow leaves
  Dual1 mean = width;
  if (!shape.width_profile.empty()) {
    const std::vector<double>& by = rate.width_profile;
    mean = width * Dual1(profile_mean(shape.width_profile), {by.empty() ? 0 : profile_mean(by)});
  }
  const Dual1 moving = mean.value < 1 ? 0.1 * mean : Dual1(0.1),
              moving_side = moving * (width / mean);
  const double across = (across_share - 0.5) * shape.width;
  const auto at_border = [](double distance, const Dual1& zone) {
    return std::abs(distance - zone.value) < 1e-9 * zone.value;
  };
  Dual1 x = along, y = (across_share - 0.5) * width;
  if (shape.fold) {  // a place keeps its part of the leg
    const double fold = shape.fold->place;
    const double part = along > fold ? (1 - along) / (1 - fold) : along / fold;
    x = Dual1(along, {part * rate.fold.place});
  }
  if (at_border(along, moving)) x = moving;
  if (at_border(1 - along, moving)) x = 1.0 - moving;
  if (at_border(across + shape.width / 2, moving_side)) y = moving_side - 0.5 * width;
  if (at_border(shape.width / 2 - across, moving_side)) y = 0.5 * width - moving_side;

  std::vector<double> at_x;
  for (const Dual1& place : xs) at_x.push_back(place.value);
  const auto [i, s0] = station_interval(at_x, along, fold_split(shape));
  const auto [j, t0] = station_interval(ys, across);
  const Dual1 per_width = width / shape.width;
  const Dual1 s = (x - xs[i]) / (xs[i + 1] - xs[i]),
              t = (y - ys[j] * per_width) / ((ys[j + 1] - ys[j]) * per_width);
  StrainsT<Dual1> e;
  const auto &e00 = strains_at(i, j), &e01 = strains_at(i, j + 1), &e10 = strains_at(i + 1, j),
             &e11 = strains_at(i + 1, j + 1);
  for (int k = 0; k < 6; ++k)
    e[k] = (1.0 - s) * ((1.0 - t) * e00[k] + t * e01[k]) + s * ((1.0 - t) * e10[k] + t * e11[k]);
  Dual1 half = 0.5 * thickness;
  if (!shape.thickness_profile.empty()) {
    const std::vector<double>& by = rate.thickness_profile;
    const double slope = profile_at(shape.thickness_profile, along, 1);
    half *= Dual1(profile_at(shape.thickness_profile, along),
                  {(by.empty() ? 0 : profile_at(by, along)) + slope * x.derivatives[0]});
  }
  return {e, half};
}

}  // namespace

VectorXd section_rates(const PlateShape& shape, const MovingStations& stations,
                       const std::vector<StressPlace>& places, double youngs_modulus,
                       const StressRate& rate) {
  const Dual1 nu(shape.poissons_ratio, {rate.shape.size[2]}),
      modulus(youngs_modulus, {rate.youngs_modulus});
  std::map<std::pair<int, int>, StrainsT<Dual1>> known;  // many places have stations in common
  const auto strains = [&](int x, int y) -> const StrainsT<Dual1>& {
    auto at = known.find({x, y});
    if (at == known.end()) at = known.emplace(std::pair(x, y), stations.strains(x, y)).first;
    return at->second;
  };
  VectorXd rates(6 * static_cast<Eigen::Index>(places.size()));
  Eigen::Index row = 0;
  for (const StressPlace& at : places) {
    const auto [e, half] =
        moving_section(shape, stations.x, stations.y, strains, at.along, at.across, rate.shape);
    for (const auto& part : {plane_stress(e[0], e[1], e[2], nu, modulus),
                             plane_stress(e[3], e[4], e[5], nu, Dual1(half * modulus))})
      for (const Dual1& stress : part) rates[row++] = stress.derivatives[0];
  }
  return rates;
}

VectorXd section_rates(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                       const std::vector<StressPlace>& places, double youngs_modulus,
                       const StressRate& rate) {
  if (mesh.shape().is_beam()) return beam_section_rates(mesh, nodal, places, youngs_modulus, rate);
  return section_rates(mesh.shape(), moving_stations(mesh, nodal, rate), places, youngs_modulus,
                       rate);
}

}  // namespace flexopt
