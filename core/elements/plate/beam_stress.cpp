#include "core/elements/plate/beam_stress.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <tuple>

#include "core/elements/plate/beam_measures.hpp"
#include "core/elements/plate/deformed_plate.hpp"
#include "core/elements/plate/full_leaf.hpp"
#include "core/elements/plate/strain_field.hpp"
#include "core/math/dual.hpp"

namespace flexopt {

using namespace beam;

namespace {

// The measures at the two Gauss stations of every element, where those of a cubic are
// superconvergent, and linearly between and beyond them.
class RecoveredMeasures {
 public:
  RecoveredMeasures(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal, BeamStrain strain) {
    const MeshNumbers<double> numbers(mesh.shape(), mesh.x());
    for (int i = 0; i < mesh.elements_along(); ++i) {
      Eigen::Matrix<double, 8, 3> U;
      U << nodal[i], nodal[i + 1];
      const double h = mesh.x()[i + 1] - mesh.x()[i];
      for (const double s : station) {
        x_.push_back(mesh.x()[i] + s * h);
        const PlateMesh::Element::Shear& shear = mesh.element(i, 0).shear;
        const Vector3d turn = shear.per_x * (s - 0.5) * h * (U.transpose() * shear.force.head<8>());
        values_.push_back(measures_at<double>(U, hermite(s, h), numbers, i, s, strain, turn));
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

int intervals_along(const PlateShape& shape) { return shape.thickness_profile.empty() ? 32 : 96; }

// Places across at which a history of stress is kept, of w/2; of a wire with those opposite 64
// around its outline: a peak between two of them is missed by 0.1 %.
std::vector<double> fractions_across(const PlateShape& shape) {
  constexpr int half_outline = 32;
  std::vector<double> fractions;
  if (shape.section == Section::circular)
    for (int k = 0; k < half_outline; ++k)
      fractions.push_back(-std::cos(std::numbers::pi * k / half_outline));
  else
    for (int k = 0; k < stations_across; ++k)
      fractions.push_back(-1 + 2.0 * k / (stations_across - 1));
  return fractions;
}

// Largest von Mises stress of a section, at the stations across or only at `fraction`.
class SectionStress {
 public:
  SectionStress(const PlateShape& shape, double along)
      : shape_{.width = shape.width_at(along),
               .thickness = shape.thickness_at(along),
               .poissons_ratio = shape.poissons_ratio,
               .section = shape.section},
        section_(
            beam_section(shape.section, shape_.width, shape_.thickness, shape.poissons_ratio)) {
    for (int k = 0; k < stations_across; ++k) {
      fraction_[k] = -1 + 2.0 * k / (stations_across - 1);
      factor_[k] = torsion_stress_factor(shape_.width, shape_.thickness, fraction_[k]);
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
  // Values that are equal up to rounding; the first one is kept.
  static void keep(Place& best, const Place& p) {
    if (p.value > best.value * (1 + 1e-9)) best = p;
  }
  Place circular(const Measures& m) const {
    const double bend = std::hypot(m[in_plane], m[across]);
    const double sign = m[stretch] < 0 ? -1 : 1;
    return {circular_stress<double>(m, shape_.thickness, shape_.poissons_ratio),
            bend > 0 ? sign * m[in_plane] / bend : 0.0, sign * m[across] >= 0};
  }
  Place rectangular(const Measures& m, int k) const {
    const auto side = [&](bool positive) {
      return rectangular_stress<double>(m, shape_.width, shape_.thickness, shape_.poissons_ratio,
                                        section_.shear, fraction_[k], factor_[k], positive);
    };
    const double up = side(true), down = side(false);
    const bool positive = up >= down * (1 - 1e-9);
    return {positive ? up : down, fraction_[k], positive};
  }

  PlateShape shape_;  // a uniform one
  BeamSection section_;
  std::array<double, stations_across> fraction_, factor_;
};

// Section stresses of every place along the leaf; a uniform leaf needs one section.
class SectionStresses {
 public:
  explicit SectionStresses(const PlateShape& shape) : shape_(&shape), uniform_(shape, 0) {}
  SectionStress at(double along) const {
    return shape_->has_profile() ? SectionStress(*shape_, along) : uniform_;
  }

 private:
  const PlateShape* shape_;
  SectionStress uniform_;
};

// The largest stress of the section at each station along.
std::vector<StressPeak> section_peaks(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                                      double youngs_modulus, int index, BeamStrain strain) {
  const RecoveredMeasures field(mesh, nodal, strain);
  const SectionStresses section(mesh.shape());
  const int intervals = intervals_along(mesh.shape());
  std::vector<StressPeak> peaks;
  for (int k = 0; k <= intervals; ++k) {
    const double x = static_cast<double>(k) / intervals;
    const Place p = section.at(x).largest(field.at(x));
    peaks.push_back(
        {youngs_modulus * p.value, index, x, 0.5 * (1 + p.fraction), Vector3d::Zero(), p.positive});
  }
  return peaks;
}

}  // namespace

StressPeak beam_max_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                           const LeafSpring& leaf, const LeafScale& scale, int index,
                           BeamStrain strain) {
  StressPeak peak;
  peak.leaf = index;
  for (const StressPeak& p :
       section_peaks(mesh, nodal, leaf.material.youngs_modulus, index, strain))
    if (p.value > peak.value * (1 + 1e-9)) peak = p;
  peak.position = plate_material_point(mesh, nodal, scale, peak.along, peak.across);
  return peak;
}

std::vector<StressPeak> beam_stress_peaks(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                                          const LeafSpring& leaf, int index, BeamStrain strain) {
  const auto all = section_peaks(mesh, nodal, leaf.material.youngs_modulus, index, strain);
  std::vector<StressPeak> peaks;
  for (std::size_t k = 0; k < all.size(); ++k)
    if (all[k].value > 0 && (k == 0 || all[k].value >= all[k - 1].value) &&
        (k + 1 == all.size() || all[k].value >= all[k + 1].value))
      peaks.push_back(all[k]);
  return peaks;
}

std::vector<StressPeak> beam_clamp_stresses(const PlateMesh& mesh,
                                            const std::vector<MatrixXd>& nodal,
                                            const LeafSpring& leaf, int index,
                                            const ClampFactors& factors, BeamStrain strain) {
  using Dual2 = Dual<2>;
  const PlateShape& shape = mesh.shape();
  const RecoveredMeasures field(mesh, nodal, strain);
  std::vector<StressPeak> peaks;
  for (const int end : {0, 1}) {
    if (!factors[end] || shape.section == Section::circular) continue;
    StressPeak peak;
    peak.leaf = index;
    peak.along = end;
    peak.notch = *factors[end];
    const double w = shape.width_at(end), t = shape.thickness_at(end), nu = shape.poissons_ratio;
    const double E = leaf.material.youngs_modulus;
    const double shear_k = beam_section(shape.section, w, t, nu).shear;
    const MeasuresT<Dual2> m = field.at(end).template cast<Dual2>();
    for (int k = 0; k < stations_across; ++k) {
      const double f = -1 + 2.0 * k / (stations_across - 1);
      for (const bool positive : {true, false}) {
        const Dual2 stress = rectangular_stress<Dual2>(
            m, Dual2(w), Dual2(t), Dual2(nu), Dual2(shear_k), f,
            Dual2(torsion_stress_factor(w, t, f)), positive,
            Dual2::variable(peak.notch.membrane, 0), Dual2::variable(peak.notch.bending, 1));
        if (E * stress.value <= peak.value * (1 + 1e-9)) continue;
        peak.value = E * stress.value;
        peak.per_membrane = E * stress.derivatives[0];
        peak.per_bending = E * stress.derivatives[1];
        peak.on_positive_normal = positive;
        peak.across = 0.5 * (1 + f);
      }
    }
    peaks.push_back(peak);
  }
  return peaks;
}

namespace {

// A beam whose nodes and shape move along a parameter.
class MovingBeam {
 public:
  // all must outlive it
  MovingBeam(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal, const StressRate& rate)
      : numbers_(mesh.shape(), rate.shape), elements_(numbers_), nodal_(nodal), rate_(rate) {
    for (int i = 0; i < mesh.elements_along(); ++i)
      for (const double s : station)
        x_.push_back(numbers_.x[i] + s * (numbers_.x[i + 1] - numbers_.x[i]));
  }

  MeasuresT<Dual1> at(double along) const {
    std::size_t k = 0;
    while (k + 2 < x_.size() && along > x_[k + 1].value) ++k;
    const Dual1 s = (along - x_[k]) / (x_[k + 1] - x_[k]);
    MeasuresT<Dual1> m = at_station(k);
    const MeasuresT<Dual1> next = at_station(k + 1);
    for (int i = 0; i < measures; ++i) m[i] = (1.0 - s) * m[i] + s * next[i];
    if (m[lateral] < 0.0) m[lateral] = 0;
    return m;
  }
  Dual1 width(double along) const { return numbers_.width * numbers_.width_factor(Dual1(along)); }
  Dual1 thickness(double along) const {
    return numbers_.thickness * numbers_.thickness_factor(Dual1(along));
  }
  const Dual1& poissons_ratio() const { return numbers_.poissons_ratio; }

 private:
  MeasuresT<Dual1> at_station(std::size_t index) const {
    const int i = static_cast<int>(index) / 2;
    Eigen::Matrix<Dual1, 8, 3> U;
    for (int f = 0; f < 8; ++f)
      for (int c = 0; c < 3; ++c)
        U(f, c) = {nodal_[i + f / 4](f % 4, c), {rate_.nodal[i + f / 4](f % 4, c)}};
    const double s = station[index % 2];
    const Dual1 h = numbers_.x[i + 1] - numbers_.x[i];
    Vector3<Dual1> turn = Vector3<Dual1>::Zero();
    if (elements_.has_shear()) {
      const PlateShear<Dual1> shear = elements_.beam_shear(i);
      const Dual1 per = shear.compliance * shear.per_x * (s - 0.5) * h;
      for (int f = 0; f < 8; ++f)
        for (int c = 0; c < 3; ++c) turn[c] += per * (shear.along[f] - shear.rest[f]) * U(f, c);
    }
    return measures_at<Dual1>(U, hermite<Dual1>(s, h), numbers_, i, s, BeamStrain::finite, turn);
  }

  MeshNumbers<Dual1> numbers_;
  ElementNumbers<Dual1> elements_;
  const std::vector<MatrixXd>& nodal_;
  const StressRate& rate_;
  std::vector<Dual1> x_;
};

}  // namespace

double beam_stress_rate(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                        const StressPeak& peak, double youngs_modulus, const StressRate& rate) {
  const Section section = mesh.shape().section;
  const MovingBeam beam(mesh, nodal, rate);
  const MeasuresT<Dual1> m = beam.at(peak.along);
  const Dual1 w = beam.width(peak.along), t = beam.thickness(peak.along),
              nu = beam.poissons_ratio();
  Dual1 stress;
  if (section == Section::circular) {
    stress = circular_stress<Dual1>(m, t, nu);
  } else {
    const double f = 2 * peak.across - 1;
    stress =
        rectangular_stress<Dual1>(m, w, t, nu, beam_section<Dual1>(section, w, t, nu).shear, f,
                                  torsion_stress_factor_of<Dual1>(w, t, f), peak.on_positive_normal,
                                  Dual1(peak.notch.membrane), Dual1(peak.notch.bending));
  }
  return youngs_modulus * stress.derivatives[0] + rate.youngs_modulus * stress.value;
}

std::vector<StressPlace> beam_stress_places(const PlateShape& shape) {
  const int intervals = intervals_along(shape);
  std::vector<StressPlace> places;
  for (int k = 0; k <= intervals; ++k)
    for (const double f : fractions_across(shape))
      places.push_back({static_cast<double>(k) / intervals, 0.5 * (1 + f)});
  return places;
}

namespace {

// Calls `at_section` for places that are sorted by section. Measures and other section data are
// made once for places that follow each other at one position along.
template <class S, class AtSection>
void each_place(const PlateShape& shape, const std::vector<StressPlace>& places,
                const AtSection& at, const std::function<void(std::size_t, ParityT<S>)>& take) {
  const bool circular = shape.section == Section::circular;
  MeasuresT<S> m;
  S w, t, nu, shear_k;
  std::map<double, S> torsion;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i == 0 || places[i].along != places[i - 1].along) {
      std::tie(m, w, t, nu) = at(places[i].along);
      if (!circular) shear_k = beam_section<S>(shape.section, w, t, nu).shear;
      if (shape.has_profile()) torsion.clear();
    }
    const double f = 2 * places[i].across - 1;
    if (circular) {
      take(i, circular_section<S>(m, t, nu, f));
      continue;
    }
    if (!torsion.contains(f)) torsion.emplace(f, torsion_stress_factor_of<S>(w, t, f));
    take(i, rectangular_section<S>(m, w, t, nu, shear_k, f, torsion.at(f)));
  }
}

}  // namespace

MatrixXd beam_section_stresses(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               double youngs_modulus, const std::vector<StressPlace>& places,
                               BeamStrain strain) {
  const PlateShape& shape = mesh.shape();
  const RecoveredMeasures field(mesh, nodal, strain);
  MatrixXd stresses(6, static_cast<Eigen::Index>(places.size()));
  const auto at = [&](double along) {
    return std::tuple(field.at(along), shape.width_at(along), shape.thickness_at(along),
                      shape.poissons_ratio);
  };
  each_place<double>(shape, places, at, [&](std::size_t i, const ParityT<double>& s) {
    stresses.col(static_cast<Eigen::Index>(i)) << s.plane, 0, s.cut, s.bend, 0, s.turn;
  });
  return youngs_modulus * stresses;
}

VectorXd beam_section_rates(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                            const std::vector<StressPlace>& places, double youngs_modulus,
                            const StressRate& rate) {
  const MovingBeam beam(mesh, nodal, rate);
  const Dual1 modulus(youngs_modulus, {rate.youngs_modulus});
  VectorXd rates = VectorXd::Zero(6 * static_cast<Eigen::Index>(places.size()));
  const auto at = [&](double along) {
    return std::tuple(beam.at(along), beam.width(along), beam.thickness(along),
                      beam.poissons_ratio());
  };
  each_place<Dual1>(mesh.shape(), places, at, [&](std::size_t i, const ParityT<Dual1>& s) {
    const auto of = [&](const Dual1& x) { return Dual1(modulus * x).derivatives[0]; };
    rates.segment<6>(6 * static_cast<Eigen::Index>(i)) << of(s.plane), 0, of(s.cut), of(s.bend), 0,
        of(s.turn);
  });
  return rates;
}

LeafShape beam_deformed_shape(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                              const LeafSpring& leaf, const LeafScale& scale, BeamStrain strain) {
  LeafShape shape;
  const RecoveredMeasures field(mesh, nodal, strain);
  const SectionStresses section(mesh.shape());
  shape.points_along = mesh.lines();
  shape.points_across = 2;
  for (const bool positive : {false, true})
    for (int i = 0; i < mesh.lines(); ++i) {
      const double y = 0.5 * mesh.shape().width_at(mesh.x()[i]) * (positive ? 1 : -1);
      const EdgePose& line = mesh.line_pose(i);
      const Vector3d r = (nodal[i].row(0) + y * nodal[i].row(2)).transpose();
      shape.undeflected.push_back(scale.origin + scale.axes *
                                                     (line.position + y * line.axes.col(1)) *
                                                     (scale.length / scale.growth));
      shape.deflected.push_back(scale.origin + scale.axes * r * scale.length);
      shape.von_mises.push_back(
          leaf.material.youngs_modulus *
          section.at(mesh.x()[i]).at_edge(field.at(mesh.x()[i]), positive).value);
    }
  return shape;
}

}  // namespace flexopt
