#include "core/elements/beam_stress.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/elements/beam_section.hpp"
#include "core/elements/full_leaf.hpp"
#include "core/elements/plate_stress.hpp"

namespace flexopt {
namespace {

// Extension ε0, curvature in the plane κ3, |d,x|², shear of the plane γ, curvature across κ2, its
// rate across κ2′, twist θ′.
enum Measure { stretch, in_plane, lateral, shear, across, warping, twist, measures };
using Measures = Eigen::Matrix<double, measures, 1>;

constexpr double station[2] = {0.21132486540518713, 0.7886751345948129};

Measures measures_at(const Eigen::Matrix<double, 8, 3>& U, const HermiteValues& X, bool circular) {
  auto sum = [&](const std::array<double, 4>& h, int k) -> Vector3d {
    return (h[0] * U.row(k) + h[1] * U.row(k + 1) + h[2] * U.row(k + 4) + h[3] * U.row(k + 5))
        .transpose();
  };
  const Vector3d a = sum(X.slope, 0), r_xx = sum(X.curvature, 0), d = sum(X.value, 2),
                 d_x = sum(X.slope, 2), d_xx = sum(X.curvature, 2);
  const Vector3d n = a.cross(d).normalized();
  Measures m;
  m[stretch] = 0.5 * (a.squaredNorm() - 1);
  m[in_plane] = circular ? -r_xx.dot(d) : a.dot(d_x);
  m[lateral] = d_x.squaredNorm();
  m[shear] = a.dot(d);
  m[across] = -r_xx.dot(n);
  m[warping] = -d_xx.dot(n);
  m[twist] = -d_x.dot(n);
  return m;
}

// The measures at the two Gauss stations of every element, where those of a cubic are
// superconvergent, and linearly between and beyond them.
class RecoveredMeasures {
 public:
  RecoveredMeasures(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal) {
    const bool circular = mesh.shape().section == Section::circular;
    for (int i = 0; i < mesh.elements_along(); ++i) {
      Eigen::Matrix<double, 8, 3> U;
      U << nodal[i], nodal[i + 1];
      const double h = mesh.x()[i + 1] - mesh.x()[i];
      for (const double s : station) {
        x_.push_back(mesh.x()[i] + s * h);
        values_.push_back(measures_at(U, hermite(s, h), circular));
      }
    }
  }

  Measures at(double x) const {
    std::size_t i = 0;
    while (i + 2 < x_.size() && x > x_[i + 1]) ++i;
    const double s = (x - x_[i]) / (x_[i + 1] - x_[i]);
    Measures m = (1 - s) * values_[i] + s * values_[i + 1];
    m[lateral] = std::max(0.0, m[lateral]);
    return m;
  }

 private:
  std::vector<double> x_;
  std::vector<Measures> values_;
};

struct Place {
  double value = 0;     // von Mises over E
  double fraction = 0;  // of w/2 across, −1 … 1
  bool positive = true;
};

constexpr int stations_across = 9;

// Largest von Mises stress of a section, at the stations across or only at `fraction`.
class SectionStress {
 public:
  explicit SectionStress(const PlateShape& shape)
      : shape_(shape),
        section_(beam_section(shape.section, shape.width, shape.thickness, shape.poissons_ratio)) {
    for (int k = 0; k < stations_across; ++k) {
      fraction_[k] = -1 + 2.0 * k / (stations_across - 1);
      factor_[k] = torsion_stress_factor(shape.width, shape.thickness, fraction_[k]);
    }
  }

  Place largest(const Measures& m) const {
    if (shape_.section == Section::circular) return circular(m);
    Place best;
    for (int k = 0; k < stations_across; ++k) keep(best, rectangular(m, k));
    return best;
  }
  Place at_edge(const Measures& m, bool positive) const {
    return shape_.section == Section::circular ? circular(m)
                                               : rectangular(m, positive ? stations_across - 1 : 0);
  }

 private:
  // equal values but for rounding: the first one is kept
  static void keep(Place& best, const Place& p) {
    if (p.value > best.value * (1 + 1e-9)) best = p;
  }
  static double von_mises(double s, double t) { return std::sqrt(s * s + 3 * t * t); }

  Place circular(const Measures& m) const {
    const double bend = std::hypot(m[in_plane], m[across]), half = 0.5 * shape_.thickness;
    const double G = shear_ratio(shape_.poissons_ratio);
    const double sign = m[stretch] < 0 ? -1 : 1;
    return {von_mises(std::abs(m[stretch]) + half * bend, G * half * m[twist]),
            bend > 0 ? sign * m[in_plane] / bend : 0.0, sign * m[across] >= 0};
  }
  Place rectangular(const Measures& m, int k) const {
    const double f = fraction_[k], y = 0.5 * f * shape_.width, half = 0.5 * shape_.thickness;
    const double G = shear_ratio(shape_.poissons_ratio);
    const double plane = m[stretch] + y * m[in_plane] + 0.5 * y * y * m[lateral],
                 bend = half * (m[across] + y * m[warping]),
                 cut = 1.5 * G * section_.shear * m[shear] * (1 - f * f),
                 turn = 2 * G * half * m[twist] * factor_[k];
    const double up = von_mises(plane + bend, cut + turn),
                 down = von_mises(plane - bend, cut - turn);
    const bool positive = up >= down * (1 - 1e-9);
    return {positive ? up : down, f, positive};
  }

  PlateShape shape_;
  BeamSection section_;
  std::array<double, stations_across> fraction_, factor_;
};

}  // namespace

StressPeak beam_max_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                           const LeafSpring& leaf, const LeafScale& scale, int index) {
  constexpr int intervals = 32;
  const RecoveredMeasures field(mesh, nodal);
  const SectionStress section(mesh.shape());
  StressPeak peak;
  peak.leaf = index;
  for (int k = 0; k <= intervals; ++k) {
    const double x = static_cast<double>(k) / intervals;
    const Place p = section.largest(field.at(x));
    const double value = leaf.material.youngs_modulus * p.value;
    if (value <= peak.value * (1 + 1e-9)) continue;
    peak.value = value;
    peak.on_positive_normal = p.positive;
    peak.along = x;
    peak.across = 0.5 * (1 + p.fraction);
  }
  peak.position = plate_material_point(mesh, nodal, scale, peak.along, peak.across);
  return peak;
}

LeafShape beam_deformed_shape(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                              const LeafSpring& leaf, const LeafScale& scale) {
  LeafShape shape;
  const RecoveredMeasures field(mesh, nodal);
  const SectionStress section(mesh.shape());
  shape.points_along = mesh.lines();
  shape.points_across = 2;
  for (const bool positive : {false, true})
    for (int i = 0; i < mesh.lines(); ++i) {
      const double y = 0.5 * mesh.shape().width * (positive ? 1 : -1);
      const Vector3d r = (nodal[i].row(0) + y * nodal[i].row(2)).transpose();
      shape.undeflected.push_back(scale.origin +
                                  scale.axes * Vector3d(mesh.x()[i], y, 0) * scale.length);
      shape.deflected.push_back(scale.origin + scale.axes * r * scale.length);
      shape.von_mises.push_back(leaf.material.youngs_modulus *
                                section.at_edge(field.at(mesh.x()[i]), positive).value);
    }
  return shape;
}

}  // namespace flexopt
