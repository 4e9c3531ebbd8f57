#include "core/elements/plate/plate_stress.hpp"

#include <algorithm>
#include <cmath>

#include "core/elements/plate/beam_stress.hpp"
#include "core/elements/plate/deformed_plate.hpp"
#include "core/mechanism/profile.hpp"

namespace flexopt {
namespace {

// Square of the von Mises stress from strains e11, e22 and 2 e12, which are numbers or arrays.
template <class S, class A>
A von_mises_square(const A& e11, const A& e22, const A& twice_e12, const S& nu, const S& modulus) {
  const S k = modulus / (1.0 - nu * nu);
  const A s11 = k * (e11 + nu * e22), s22 = k * (e22 + nu * e11),
          s12 = S(k * 0.5 * (1.0 - nu)) * twice_e12;
  return s11 * s11 - s11 * s22 + s22 * s22 + 3.0 * s12 * s12;
}

template <class S>
S von_mises(const Vector3<S>& strain, const S& nu, const S& modulus) {
  using std::sqrt;
  const S square = von_mises_square<S, S>(strain[0], strain[1], strain[2], nu, modulus);
  return square > 0.0 ? S(sqrt(square)) : S(0.0 * square);  // no stress has no slope
}

}  // namespace

SurfaceStresses surface_stresses(const MatrixXd& strains, const Eigen::ArrayXd& thickness,
                                 double poissons_ratio, double youngs_modulus) {
  const auto side = [&](double sign) -> Eigen::ArrayXd {
    std::array<Eigen::ArrayXd, 3> e;
    for (int k = 0; k < 3; ++k)
      e[k] = strains.col(k).array() + (0.5 * sign) * thickness * strains.col(k + 3).array();
    return von_mises_square<double, Eigen::ArrayXd>(e[0], e[1], e[2], poissons_ratio,
                                                    youngs_modulus)
        .max(0.0)
        .sqrt();
  };
  return {side(1), side(-1)};
}

SurfaceStress surface_stress(const PlateShape& shape, const Strains& e, double youngs_modulus,
                             double along) {
  const double nu = shape.poissons_ratio, half = 0.5 * shape.thickness_at(along);
  return {von_mises<double>(e.head<3>() + half * e.tail<3>(), nu, youngs_modulus),
          von_mises<double>(e.head<3>() - half * e.tail<3>(), nu, youngs_modulus)};
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

/// Stations of a plate's stress, and those that are not to be read.
struct Stations {
  std::vector<double> x, y;           // over L
  double width, margin, margin_side;  // of the squares at the corners: along, across

  explicit Stations(const PlateShape& shape) : width(shape.width) {
    const double zone = 0.1 * std::min(1.0, shape.mean_width()),
                 side = zone * (width / shape.mean_width());
    margin = zone * (1 - 1e-9);
    margin_side = side * (1 - 1e-9);
    // closer where the thickness varies: at places that do not depend on the mesh, nor the profile
    x = stations(0, 1, shape.thickness_profile.empty() ? 16 : 64, zone);
    if (shape.fold) {  // each leg's own, on both sides of the fold
      const double fold = shape.fold->place;
      x = graded_points(0, fold, 16, 0.5);
      x.push_back(zone);
      x.push_back(1 - zone);
      for (const double place : graded_points(fold, 1, 16, 0.5))
        x.push_back(place == fold ? behind_fold(fold) : place);
      std::sort(x.begin(), x.end());
    }
    y = stations(-width / 2, width / 2, 8, side);
  }
  bool in_corner(double sx, double sy) const {
    const bool at_clamp = std::min(sx, 1 - sx) < margin;
    const bool at_free_edge = std::min(sy + width / 2, width / 2 - sy) < margin_side;
    return at_clamp && at_free_edge;
  }
};

}  // namespace

std::vector<StressPlace> plate_stress_places(const PlateShape& shape) {
  const Stations at(shape);
  std::vector<StressPlace> places;
  for (const double x : at.x)
    for (const double y : at.y)
      if (!at.in_corner(x, y)) places.push_back({x, (y + at.width / 2) / at.width});
  return places;
}

namespace {

/// Stresses on both sides of all stations, along × across; −1 where a station is not to be read.
struct StationStress {
  MatrixXd positive, negative;

  StationStress(const StrainField& field, const PlateShape& shape, double youngs_modulus,
                const Stations& at) {
    const auto nx = static_cast<Eigen::Index>(at.x.size()),
               ny = static_cast<Eigen::Index>(at.y.size());
    Eigen::ArrayXd along(nx);
    for (Eigen::Index i = 0; i < nx; ++i)
      along[i] = shape.thickness_at(at.x[static_cast<std::size_t>(i)]);
    const SurfaceStresses s = surface_stresses(field.on(at.x, at.y), along.replicate(ny, 1),
                                               shape.poissons_ratio, youngs_modulus);
    positive = s.positive.reshaped(nx, ny);
    negative = s.negative.reshaped(nx, ny);
    for (Eigen::Index i = 0; i < nx; ++i)
      for (Eigen::Index j = 0; j < ny; ++j)
        if (at.in_corner(at.x[static_cast<std::size_t>(i)], at.y[static_cast<std::size_t>(j)]))
          positive(i, j) = negative(i, j) = -1;
  }
};

}  // namespace

StressPeak largest_stress(const StrainField& field, const PlateShape& shape, double youngs_modulus,
                          int index) {
  const Stations at(shape);
  const StationStress stress(field, shape, youngs_modulus, at);
  StressPeak peak;
  peak.leaf = index;
  for (Eigen::Index i = 0; i < stress.positive.rows(); ++i)
    for (Eigen::Index j = 0; j < stress.positive.cols(); ++j) {
      // both surfaces of a symmetric state are equal but for rounding: prefer the positive one
      const bool positive = stress.positive(i, j) >= stress.negative(i, j) * (1 - 1e-9);
      const double value = positive ? stress.positive(i, j) : stress.negative(i, j);
      if (value <= peak.value * (1 + 1e-9)) continue;
      peak.value = value;
      peak.on_positive_normal = positive;
      peak.along = at.x[static_cast<std::size_t>(i)];
      peak.across = (at.y[static_cast<std::size_t>(j)] + at.width / 2) / at.width;
    }
  return peak;
}

std::vector<StressPeak> plate_stress_peaks(const PlateMesh& mesh,
                                           const std::vector<MatrixXd>& nodal,
                                           const LeafSpring& leaf, int index) {
  if (mesh.shape().is_beam()) return beam_stress_peaks(mesh, nodal, leaf, index);
  return stress_peaks(recovered_strains(mesh, nodal), mesh.shape(), leaf.material.youngs_modulus,
                      index);
}

std::vector<StressPeak> stress_peaks(const StrainField& field, const PlateShape& shape,
                                     double youngs_modulus, int index) {
  const Stations at(shape);
  const StationStress stress(field, shape, youngs_modulus, at);
  const auto nx = static_cast<int>(at.x.size()), ny = static_cast<int>(at.y.size());
  std::vector<StressPeak> peaks;
  for (const MatrixXd* of : {&stress.positive, &stress.negative})
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < ny; ++j) {
        const double here = (*of)(i, j);
        const int i0 = std::max(i - 1, 0), j0 = std::max(j - 1, 0);
        const auto around = of->block(i0, j0, std::min(i + 2, nx) - i0, std::min(j + 2, ny) - j0);
        if (here <= 0 || here < around.maxCoeff()) continue;
        peaks.push_back({here, index, at.x[i], (at.y[j] + at.width / 2) / at.width,
                         Vector3d::Zero(), of == &stress.positive});
      }
  return peaks;
}

StressPeak plate_max_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                            const LeafSpring& leaf, const LeafScale& scale, int index) {
  if (mesh.shape().is_beam()) return beam_max_stress(mesh, nodal, leaf, scale, index);
  StressPeak peak = largest_stress(recovered_strains(mesh, nodal), mesh.shape(),
                                   leaf.material.youngs_modulus, index);
  peak.position = plate_material_point(mesh, nodal, scale, peak.along, peak.across);
  return peak;
}

std::vector<StressPeak> clamp_stresses(const StrainField& field, const PlateShape& shape,
                                       double youngs_modulus, int index,
                                       const ClampFactors& factors) {
  using Dual2 = Dual<2>;
  const Stations at(shape);
  std::vector<StressPeak> peaks;
  for (const int end : {0, 1}) {
    if (!factors[end]) continue;
    StressPeak peak;
    peak.leaf = index;
    peak.along = end;
    peak.notch = *factors[end];
    for (const double sy : at.y) {
      if (at.in_corner(end, sy)) continue;
      const Strains e = field.at(end, sy);
      for (const double side : {1.0, -1.0}) {
        const double half = side * 0.5 * shape.thickness_at(end);
        const Dual2 membrane = Dual2::variable(peak.notch.membrane, 0),
                    bending = Dual2::variable(peak.notch.bending, 1);
        Vector3<Dual2> strain;
        for (int k = 0; k < 3; ++k) strain[k] = membrane * e[k] + bending * (half * e[k + 3]);
        const Dual2 stress =
            von_mises<Dual2>(strain, Dual2(shape.poissons_ratio), Dual2(youngs_modulus));
        if (stress.value <= peak.value * (1 + 1e-9)) continue;
        peak.value = stress.value;
        peak.per_membrane = stress.derivatives[0];
        peak.per_bending = stress.derivatives[1];
        peak.on_positive_normal = side > 0;
        peak.across = (sy + at.width / 2) / at.width;
      }
    }
    peaks.push_back(peak);
  }
  return peaks;
}

std::vector<StressPeak> plate_clamp_stresses(const PlateMesh& mesh,
                                             const std::vector<MatrixXd>& nodal,
                                             const LeafSpring& leaf, const LeafScale& scale,
                                             int index, const ClampFactors& factors) {
  if (!factors[0] && !factors[1]) return {};
  std::vector<StressPeak> peaks =
      mesh.shape().is_beam() ? beam_clamp_stresses(mesh, nodal, leaf, index, factors)
                             : clamp_stresses(recovered_strains(mesh, nodal), mesh.shape(),
                                              leaf.material.youngs_modulus, index, factors);
  for (StressPeak& peak : peaks)
    peak.position = plate_material_point(mesh, nodal, scale, peak.along, peak.across);
  return peaks;
}

// Section whose strains move, as dual numbers, only at the four stations around the place.
MovingSection moving_section(const PlateShape& shape, const std::vector<Dual1>& xs,
                             const std::vector<double>& ys,
                             const std::function<StrainRate(int, int)>& strains_at, double along,
                             double across_share, const ShapeRate& rate) {
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
  const StrainRate e00 = strains_at(i, j), e01 = strains_at(i, j + 1), e10 = strains_at(i + 1, j),
                   e11 = strains_at(i + 1, j + 1);
  for (int k = 0; k < 6; ++k) {
    const auto at = [k](const StrainRate& strain) {
      return Dual1(strain.value[k], {strain.rate[k]});
    };
    e[k] =
        (1.0 - s) * ((1.0 - t) * at(e00) + t * at(e01)) + s * ((1.0 - t) * at(e10) + t * at(e11));
  }
  Dual1 half = 0.5 * thickness;
  if (!shape.thickness_profile.empty()) {
    const std::vector<double>& by = rate.thickness_profile;
    const double slope = profile_at(shape.thickness_profile, along, 1);
    half *= Dual1(profile_at(shape.thickness_profile, along),
                  {(by.empty() ? 0 : profile_at(by, along)) + slope * x.derivatives[0]});
  }
  return {e, half};
}

double stress_rate(const PlateShape& shape, const std::vector<Dual1>& xs,
                   const std::vector<double>& ys,
                   const std::function<StrainRate(int, int)>& strains_at, const StressPeak& peak,
                   double youngs_modulus, const StressRate& rate) {
  const auto [e, half] =
      moving_section(shape, xs, ys, strains_at, peak.along, peak.across, rate.shape);
  const Dual1 nu(shape.poissons_ratio, {rate.shape.size[2]}),
      modulus(youngs_modulus, {rate.youngs_modulus}),
      side = peak.on_positive_normal ? half : Dual1(-half);
  Vector3<Dual1> strain;
  for (int k = 0; k < 3; ++k)
    strain[k] = peak.notch.membrane * e[k] + peak.notch.bending * side * e[k + 3];
  return von_mises<Dual1>(strain, nu, modulus).derivatives[0];
}

double plate_stress_rate(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                         const StressPeak& peak, double youngs_modulus, const StressRate& rate) {
  const PlateShape& shape = mesh.shape();
  if (shape.is_beam()) return beam_stress_rate(mesh, nodal, peak, youngs_modulus, rate);
  const MovingStations at = moving_stations(mesh, nodal, rate);
  return stress_rate(shape, at.x, at.y, at.strains, peak, youngs_modulus, rate);
}

}  // namespace flexopt
