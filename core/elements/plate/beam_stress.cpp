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

// Extension ε0, curvature in the plane κ3, |d,x|², shear of the plane γ, curvature across κ2, its
// rate across κ2′, twist θ′.
enum Measure { stretch, in_plane, lateral, shear, across, warping, twist, measures };
template <class S>
using MeasuresT = Eigen::Matrix<S, measures, 1>;

// `turn`: by what the curvature of the line is larger than that of the sections.
template <class S>
MeasuresT<S> measures_at(const Eigen::Matrix<S, 16, 3>& U, const HermiteValuesT<S>& X,
                         const MeshNumbers<S>& numbers, int element, double s, BeamStrain strain,
                         const Vector3<S>& turn) {
  const bool circular = numbers.shape().section == Section::circular;
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
    m << a[0], circular ? S(-r_xx[1]) : d_x[0], S(0.0 * a[0]), S(a[1] + d[0]), S(-r_xx[2]),
        S(-d_xx[2]), S(-d_x[2]);
    return m;
  }
  const Vector3<S> c = a.cross(d);
  const Vector3<S> n = c / sqrt(c.squaredNorm());
  m[stretch] = 0.5 * (a.squaredNorm() - numbers.rest(element, s).metric);
  m[in_plane] = circular ? S(-r_xx.dot(d)) : S(a.dot(d_x));
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
StressT<S> rectangular_section(const MeasuresT<S>& m, const S& w, const S& t, const S& nu,
                               const S& shear_k, double f, const S& torsion) {
  const S y = 0.5 * f * w, half = 0.5 * t, G = shear_ratio(nu);
  StressT<S> s;
  s << m[stretch] + y * m[in_plane] + 0.5 * y * y * m[lateral], S(0),
      1.5 * (1 - f * f) * G * shear_k * m[shear], half * (m[across] + y * m[warping]), S(0),
      2.0 * G * half * m[twist] * torsion;
  return s;
}
template <class S>
StressT<S> circular_section(const MeasuresT<S>& m, const S& t, const S& nu, double f) {
  StressT<S> s;
  s << m[stretch], S(0), shear_ratio(nu) * (0.5 * t) * m[twist],
      0.5 * t * (f * m[in_plane] + std::sqrt(std::max(0.0, 1 - f * f)) * m[across]), S(0), S(0);
  return s;
}

// The measures at the two Gauss stations of every element, where those of a cubic are
// superconvergent, and linearly between and beyond them. S = Dual1: along a direction.
template <class S>
class BeamField {
 public:
  // `nodal(i)`: nodal values of element i; `turn(i, U, s)`: (E11) of it.
  using Nodes = Eigen::Matrix<S, 16, 3>;
  using Nodal = std::function<Nodes(int)>;
  using Turn = std::function<Vector3<S>(int, const Nodes&, double)>;
  BeamField(MeshNumbers<S> numbers, Nodal nodal, Turn turn, BeamStrain strain)
      : numbers_(std::move(numbers)),
        nodal_(std::move(nodal)),
        turn_(std::move(turn)),
        strain_(strain),
        x_(strain_stations(numbers_.x)) {}

  // Calls take(i, stress) for each place. What belongs to a section is made once for places that
  // follow each other at one position along.
  template <class Take>
  void each_place(const std::vector<StressPlace>& places, const Take& take) const {
    const PlateShape& shape = numbers_.shape();
    const bool circular = shape.section == Section::circular;
    const S& nu = numbers_.poissons_ratio;
    MeasuresT<S> m;
    S w, t, shear_k;
    std::map<double, S> torsion;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (i == 0 || places[i].along != places[i - 1].along) {
        const S along(places[i].along);
        m = at(places[i].along);
        w = numbers_.width * numbers_.width_factor(along);
        t = numbers_.thickness * numbers_.thickness_factor(along);
        if (!circular) shear_k = beam_section<S>(shape.section, w, t, nu).shear;
        if (shape.has_profile()) torsion.clear();
      }
      const double f = 2 * places[i].across - 1;
      if (circular) {
        take(i, circular_section<S>(m, t, nu, f));
        continue;
      }
      if (!torsion.contains(f)) torsion.emplace(f, torsion_stress_factor<S>(w, t, f));
      take(i, rectangular_section<S>(m, w, t, nu, shear_k, f, torsion.at(f)));
    }
  }

 private:
  MeasuresT<S> at(double along) const {
    std::size_t k = 0;
    while (k + 2 < x_.size() && along > value_of(x_[k + 1])) ++k;
    const S s = (along - x_[k]) / (x_[k + 1] - x_[k]);
    MeasuresT<S> m = at_station(k);
    const MeasuresT<S> next = at_station(k + 1);
    for (int i = 0; i < measures; ++i) m[i] = (1.0 - s) * m[i] + s * next[i];
    if (m[lateral] < 0.0) m[lateral] = S(0);
    return m;
  }
  MeasuresT<S> at_station(std::size_t index) const {
    const int i = static_cast<int>(index) / 2;
    const double s = station[index % 2];
    const Nodes U = nodal_(i);
    return measures_at<S>(U, hermite<S>(s, S(numbers_.x[i + 1] - numbers_.x[i])), numbers_, i, s,
                          strain_, turn_(i, U, s));
  }

  MeshNumbers<S> numbers_;
  Nodal nodal_;
  Turn turn_;
  BeamStrain strain_;
  std::vector<S> x_;
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
