#include "core/elements/plate/section_stress.hpp"

#include <optional>

namespace flexopt {
namespace {

// Plane stress of strains e11, e22, 2 e12.
template <class S, class V>
Vector3<S> plane_stress(const V& e11, const V& e22, const V& twice_e12, const S& nu,
                        const S& modulus) {
  const S k = modulus / (1.0 - nu * nu);
  return {S(k * (e11 + nu * e22)), S(k * (e22 + nu * e11)), S(k * (0.5 * (1.0 - nu)) * twice_e12)};
}

}  // namespace

std::vector<StressPlace> section_places(const PlateShape& shape) {
  return shape.is_beam() ? beam_stress_places(shape) : plate_stress_places(shape);
}

MatrixXd section_stresses(const StrainField& field, const PlateShape& shape, double youngs_modulus,
                          const std::vector<StressPlace>& places) {
  MatrixXd stresses(6, static_cast<Eigen::Index>(places.size()));
  const double nu = shape.poissons_ratio;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const StressPlace& at = places[i];
    const Strains e = field.at(at.along, (at.across - 0.5) * shape.width);
    const double half = 0.5 * shape.thickness_at(at.along);
    stresses.col(static_cast<Eigen::Index>(i))
        << plane_stress<double, double>(e[0], e[1], e[2], nu, youngs_modulus),
        half * plane_stress<double, double>(e[3], e[4], e[5], nu, youngs_modulus);
  }
  return stresses;
}

MatrixXd section_stresses(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                          double youngs_modulus, const std::vector<StressPlace>& places) {
  if (mesh.shape().is_beam()) return beam_section_stresses(mesh, nodal, youngs_modulus, places);
  return section_stresses(recovered_strains(mesh, nodal), mesh.shape(), youngs_modulus, places);
}

VectorXd section_rates(const PlateShape& shape, const MovingStations& stations,
                       const std::vector<StressPlace>& places, double youngs_modulus,
                       const StressRate& rate) {
  const Dual1 nu(shape.poissons_ratio, {rate.shape.size[2]}),
      modulus(youngs_modulus, {rate.youngs_modulus});
  // many places have stations in common
  const std::size_t across = stations.y.size();
  std::vector<std::optional<StrainRate>> known(stations.x.size() * across);
  const auto strains = [&](int x, int y) -> StrainRate {
    auto& at = known[static_cast<std::size_t>(x) * across + static_cast<std::size_t>(y)];
    if (!at) at = stations.strains(x, y);
    return *at;
  };
  VectorXd rates(6 * static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto [e, half] = moving_section(shape, stations.x, stations.y, strains, places[i].along,
                                          places[i].across, rate.shape);
    const Vector3<Dual1> mean = plane_stress<Dual1, Dual1>(e[0], e[1], e[2], nu, modulus),
                         bend = plane_stress<Dual1, Dual1>(half * e[3], half * e[4], half * e[5],
                                                           nu, modulus);
    for (Eigen::Index k = 0; k < 3; ++k) {
      rates[6 * static_cast<Eigen::Index>(i) + k] = mean[k].derivatives[0];
      rates[6 * static_cast<Eigen::Index>(i) + 3 + k] = bend[k].derivatives[0];
    }
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
