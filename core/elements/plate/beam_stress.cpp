#include "core/elements/plate/beam_stress.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/elements/plate/beam_section.hpp"
#include "core/elements/plate/element_numbers.hpp"

namespace flexopt {
namespace {

// Extension ε0, curvature in the plane of the sections κ3, its slope, that of the middle line,
// |d,x|², shear of the plane γ, curvature across κ2, its rate across κ2′, twist θ′.
enum Measure { stretch, in_plane, slope, line, lateral, shear, across, warping, twist, measures };
template <class S>
using MeasuresT = Eigen::Matrix<S, measures, 1>;

// `turn`: by what the curvature of the line is larger than that of the sections.
template <class S>
MeasuresT<S> measures_at(const Eigen::Matrix<S, 16, 3>& U, const HermiteValuesT<S>& X,
                         const MeshNumbers<S>& numbers, int element, double s, BeamStrain strain,
                         const Vector3<S>& turn) {
  auto sum = [&](const std::array<S, 4>& h, int k) -> Vector3<S> {
    Vector3<S> r;
    for (int c = 0; c < 3; ++c)
      r[c] = U(k, c) * h[0] + U(k + 1, c) * h[1] + U(k + 4, c) * h[2] + U(k + 5, c) * h[3];
    return r;
  };
  using std::sqrt;
  const Vector3<S> a = sum(X.slope, 0), r_xx = sum(X.curvature, 0) - turn, d = sum(X.value, 2),
                   d_x = sum(X.slope, 2), d_xx = sum(X.curvature, 2);
  MeasuresT<S> m;
  if (strain == BeamStrain::linear) {  // a = e1, d = e2, n = e3 and small changes
    m << a[0], d_x[0], d_xx[0], S(-r_xx[1]), S(0.0 * a[0]), S(a[1] + d[0]), S(-r_xx[2]),
        S(-d_xx[2]), S(-d_x[2]);
    return m;
  }
  const Vector3<S> c = a.cross(d);
  const Vector3<S> n = c / sqrt(c.squaredNorm());
  m[stretch] = 0.5 * (a.squaredNorm() - numbers.rest(element, s).metric);
  m[in_plane] = a.dot(d_x);
  m[slope] = a.dot(d_xx);
  m[line] = -r_xx.dot(d);
  m[lateral] = d_x.squaredNorm();
  m[shear] = a.dot(d);
  m[across] = -r_xx.dot(n) - numbers.rest_curvature(element, s);
  m[warping] = -d_xx.dot(n);
  m[twist] = -d_x.dot(n);
  return m;
}

// A SectionStress over E at a fraction of w/2: stresses even in z, and those odd in it at t/2. Of a
// circular section, at a fraction of its radius: the parts that two opposite points of the outline
// share, and those of opposite sign.
template <class S>
using StressT = Eigen::Matrix<S, 6, 1>;
template <class S>
StressT<S> rectangular_section(const MeasuresT<S>& m, const S& w, const S& t, const S& nu, double f,
                               const S& torsion) {
  const S y = 0.5 * f * w, half = 0.5 * t, G = shear_ratio(nu);
  StressT<S> s;
  s << m[stretch] + y * m[in_plane] + 0.5 * y * y * m[lateral], S(0), 1.5 * (1 - f * f) * m[shear],
      half * (m[across] + y * m[warping]), S(0), 2.0 * G * half * m[twist] * torsion;
  return s;
}
template <class S>
StressT<S> circular_section(const MeasuresT<S>& m, const S& t, const S& nu, double f) {
  StressT<S> s;
  s << m[stretch], S(0), shear_ratio(nu) * (0.5 * t) * m[twist],
      0.5 * t * (f * m[line] + std::sqrt(std::max(0.0, 1 - f * f)) * m[across]), S(0), S(0);
  return s;
}

// (B3): in the plane, the measures of a rectangle at both stations of an element of the length h
// become those of the whole moment and force; the shear is then V/EA.
template <class S>
void balance_in_plane(const std::array<BeamEnergyT<S>, 2>& e, const S& h,
                      std::array<MeasuresT<S>, 2>& m) {
  std::array<S, 2> line_moment, sheared;
  S moment(0);
  for (std::size_t a = 0; a < 2; ++a) {
    line_moment[a] = e[a].bend * m[a][line];
    sheared[a] = e[a].shear * e[a].area * m[a][shear];
    moment += 0.5 * (line_moment[a] + (e[a].stretch * e[a].second + e[a].twist) * m[a][in_plane]);
  }
  const S half = h / (2 * std::numbers::sqrt3),  // stations from the middle
      force = 0.5 * (sheared[0] + sheared[1] + (line_moment[1] - line_moment[0]) / half);
  // of (B1), |d,x|² is integrated at four points and not at the stations, and |d,xx|² has a part
  const S of_slope = 0.5 * (h * h / 60.0 * (e[0].twist + e[1].twist) + e[0].warp + e[1].warp);
  moment += half / 6.0 * (sheared[1] - sheared[0]) -
            of_slope * (m[1][slope] - m[0][slope]) / (2.0 * half);
  for (std::size_t a = 0; a < 2; ++a) {
    m[a][in_plane] = (moment + (a == 0 ? -1.0 : 1.0) * half * force) / (e[a].stretch * e[a].strong);
    m[a][shear] = force / (e[a].stretch * e[a].area);
  }
}

// The measures at the two Gauss stations of every element, where those of a cubic are
// superconvergent, and linearly between and beyond them. S = Dual1: along a direction.
template <class S>
class BeamField {
 public:
  // `nodal(i)`: nodal values of element i; `turn(i, U, s)`: (E11) of it.
  template <class Nodal, class Turn>
  BeamField(MeshNumbers<S> numbers, const Nodal& nodal, const Turn& turn, BeamStrain strain)
      : numbers_(std::move(numbers)), x_(strain_stations(numbers_.x)) {
    const PlateShape& shape = numbers_.shape();
    const BeamEnergyT<S> uniform = beam_energy_at(numbers_, S(0));
    for (int i = 0; i + 1 < static_cast<int>(numbers_.x.size()); ++i) {
      const S h = numbers_.x[i + 1] - numbers_.x[i];
      const auto U = nodal(i);
      std::array<MeasuresT<S>, 2> m;
      std::array<BeamEnergyT<S>, 2> e{uniform, uniform};
      for (std::size_t a = 0; a < 2; ++a) {
        m[a] = measures_at<S>(U, hermite<S>(station[a], h), numbers_, i, station[a], strain,
                              turn(i, U, station[a]));
        if (shape.has_profile()) e[a] = beam_energy_at(numbers_, x_[2 * i + a]);
      }
      if (shape.section == Section::rectangular) balance_in_plane(e, h, m);
      measures_.insert(measures_.end(), m.begin(), m.end());
    }
  }

  // Calls take(i, stress) for each place. What belongs to a section is made once for places that
  // follow each other at one position along.
  template <class Take>
  void each_place(const std::vector<StressPlace>& places, const Take& take) const {
    const PlateShape& shape = numbers_.shape();
    const bool circular = shape.section == Section::circular;
    const S& nu = numbers_.poissons_ratio;
    MeasuresT<S> m;
    S w, t;
    std::map<double, S> torsion;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (i == 0 || places[i].along != places[i - 1].along) {
        const S along(places[i].along);
        w = numbers_.width * numbers_.width_factor(along);
        t = numbers_.thickness * numbers_.thickness_factor(along);
        m = at(places[i].along);
        if (shape.has_profile()) torsion.clear();
      }
      const double f = 2 * places[i].across - 1;
      if (circular) {
        take(i, circular_section<S>(m, t, nu, f));
        continue;
      }
      if (!torsion.contains(f)) torsion.emplace(f, torsion_stress_factor<S>(w, t, f));
      take(i, rectangular_section<S>(m, w, t, nu, f, torsion.at(f)));
    }
  }

 private:
  MeasuresT<S> at(double along) const {
    std::size_t k = 0;
    while (k + 2 < x_.size() && along > value_of(x_[k + 1])) ++k;
    const S s = (along - x_[k]) / (x_[k + 1] - x_[k]);
    MeasuresT<S> m;
    for (int i = 0; i < measures; ++i) m[i] = (1.0 - s) * measures_[k][i] + s * measures_[k + 1][i];
    if (m[lateral] < 0.0) m[lateral] = S(0);
    return m;
  }

  MeshNumbers<S> numbers_;
  std::vector<S> x_;
  std::vector<MeasuresT<S>> measures_;
};

}  // namespace

StressStations beam_stations(const PlateShape& shape) {
  constexpr int across = 9, half_outline = 32;  // a peak between two of a wire is missed by 0.1 %
  const int intervals = shape.thickness_profile.empty() ? 32 : 96;
  StressStations at{StressStations::Kind::beam, {}, {}};
  for (int k = 0; k <= intervals; ++k) at.along.push_back(static_cast<double>(k) / intervals);
  if (shape.section == Section::circular) {
    at.kind = StressStations::Kind::wire;
    for (int k = 0; k < half_outline; ++k)
      at.across.push_back(0.5 * (1 - std::cos(std::numbers::pi * k / half_outline)));
  } else {
    for (int k = 0; k < across; ++k) at.across.push_back(0.5 * (1 + (-1 + 2.0 * k / (across - 1))));
  }
  return at;
}

LeafStress::Sections beam_sections(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                                   double youngs_modulus, BeamStrain strain) {
  BeamField<double> field(
      mesh.numbers(), [&mesh, nodal](int i) { return element_nodes(mesh, nodal, i, 0); },
      [&mesh](int i, const auto& U, double s) { return section_turn(mesh, i, 0, U, s); }, strain);
  return [field = std::move(field), youngs_modulus](const std::vector<StressPlace>& places) {
    MatrixXd stresses(6, static_cast<Eigen::Index>(places.size()));
    field.each_place(places, [&](std::size_t i, const SectionStress& s) {
      stresses.col(static_cast<Eigen::Index>(i)) = youngs_modulus * s;
    });
    return stresses;
  };
}

VectorXd beam_section_rates(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                            const std::vector<StressPlace>& places, double youngs_modulus,
                            const StressRate& rate) {
  const MeshNumbers<Dual1> numbers(mesh.shape(), rate.shape);
  const BeamField<Dual1> field(
      numbers,
      [&](int i) {
        return moving(element_nodes(mesh, nodal, i, 0), element_nodes(mesh, rate.nodal, i, 0));
      },
      [&](int i, const auto& U, double s) { return section_turn(numbers, i, 0, U, s); },
      BeamStrain::finite);
  const Dual1 modulus(youngs_modulus, {rate.youngs_modulus});
  VectorXd rates(6 * static_cast<Eigen::Index>(places.size()));
  field.each_place(places, [&](std::size_t i, const StressT<Dual1>& s) {
    for (int k = 0; k < 6; ++k)
      rates[6 * static_cast<Eigen::Index>(i) + k] = Dual1(modulus * s[k]).derivatives[0];
  });
  return rates;
}

}  // namespace flexopt
