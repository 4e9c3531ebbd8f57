#include "core/elements/leaf/leaf_stress.hpp"

#include <algorithm>
#include <cmath>

namespace flexopt {
namespace {

constexpr double equal = 1 + 1e-9;  // values that are equal but for rounding

Vector3d on_side(const SectionStress& section, double side, const NotchFactors& notch) {
  return notch.membrane * section.head<3>() + side * notch.bending * section.tail<3>();
}

double side_of(const StressPeak& peak) { return peak.on_positive_normal ? 1 : -1; }

}  // namespace

double von_mises(const SectionStress& section, double side, const NotchFactors& notch) {
  const Vector3d s = on_side(section, side, notch);
  return std::sqrt(std::max(0.0, s[0] * s[0] - s[0] * s[1] + s[1] * s[1] + 3 * s[2] * s[2]));
}

SectionStress von_mises_slopes(const StressPeak& peak) {
  const Vector3d s = on_side(peak.section, side_of(peak), peak.notch);
  const double value = von_mises(peak.section, side_of(peak), peak.notch);
  if (value == 0) return SectionStress::Zero();
  const Vector3d slopes = Vector3d(s[0] - 0.5 * s[1], s[1] - 0.5 * s[0], 3 * s[2]) / value;
  return (SectionStress() << peak.notch.membrane * slopes,
          side_of(peak) * peak.notch.bending * slopes)
      .finished();
}

bool StressStations::in_corner(double x, double y) const {
  return std::min(x, 1 - x) < corner_along && std::min(y, 1 - y) < corner_across;
}

std::vector<StressPlace> StressStations::places() const {
  std::vector<StressPlace> all;
  for (int i = 0; i < segments; ++i)
    for (const double x : along)
      for (const double y : across)
        if (!in_corner(x, y)) all.push_back({(i + x) / segments, y, i});
  return all;
}

std::vector<StressPeak> LeafStress::peaks_at(const std::vector<StressPlace>& places) const {
  std::vector<StressPeak> all;
  const auto add = [&](const StressPlace& at, double across, bool positive,
                       const SectionStress& section, double across_section) {
    StressPeak& peak = all.emplace_back();
    peak.value = von_mises(section, positive ? 1 : -1);
    peak.leaf = leaf;
    peak.along = at.along;
    peak.across = across;
    peak.on_positive_normal = positive;
    peak.segment = at.segment;
    peak.section = section;
    peak.across_section = across_section;
  };
  if (stations.kind != StressStations::Kind::wire) {
    const MatrixXd at_places = sections(places);
    for (std::size_t k = 0; k < places.size(); ++k) {
      const SectionStress s = at_places.col(static_cast<Eigen::Index>(k));
      // both surfaces of a symmetric state are equal but for rounding: prefer the positive one
      const bool positive = von_mises(s, 1) >= von_mises(s, -1) * (1 - 1e-9);
      add(places[k], places[k].across, positive, s, places[k].across);
    }
    return all;
  }
  // bending in the plane and out of it, read at the side and in the middle, add up like a vector
  std::vector<StressPlace> read;
  for (const StressPlace& at : places)
    if (read.empty() || at.along != read.back().along || at.segment != read.back().segment)
      for (const double across : {0.0, 0.5}) read.push_back({at.along, across, at.segment});
  const MatrixXd at_places = sections(read);
  for (Eigen::Index k = 0; k < at_places.cols(); k += 2) {
    SectionStress s = at_places.col(k + 1);
    const double in_plane = -at_places(3, k), out = s[3], bend = std::hypot(in_plane, out),
                 sign = s[0] < 0 ? -1 : 1, fraction = bend > 0 ? sign * in_plane / bend : 0.0;
    const bool positive = sign * out >= 0;
    s[3] = positive ? sign * bend : -sign * bend;
    add(read[static_cast<std::size_t>(k)], 0.5 * (1 + fraction), positive, s,
        0.5 * (positive ? 1 + fraction : 1 - fraction));
  }
  return all;
}

StressPeak LeafStress::largest() const {
  StressPeak largest = known.value_or(StressPeak{});
  if (!known)
    for (const StressPeak& peak : peaks_at(stations.places()))
      if (peak.value > largest.value * equal) largest = peak;
  largest.leaf = leaf;
  if (position) largest.position = position({largest.along, largest.across, largest.segment});
  return largest;
}

std::vector<StressPeak> LeafStress::plate_peaks(
    const std::vector<StressPeak>& stations_in_order) const {
  const auto nx = static_cast<int>(stations.along.size()),
             ny = static_cast<int>(stations.across.size());
  std::vector<StressPeak> peaks;
  auto next = stations_in_order.begin();
  for (int segment = 0; segment < stations.segments; ++segment) {
    const auto first = next;
    Eigen::MatrixXi number = Eigen::MatrixXi::Constant(nx, ny, -1);  // −1 in corners
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < ny; ++j)
        if (!stations.in_corner(stations.along[i], stations.across[j]))
          number(i, j) = static_cast<int>(next++ - first);
    for (const double side : {1.0, -1.0}) {
      const MatrixXd stress =
          number.unaryExpr([&](int k) { return k < 0 ? -1.0 : von_mises(first[k].section, side); });
      for (int i = 0; i < nx; ++i)
        for (int j = 0; j < ny; ++j) {
          const int i0 = std::max(i - 1, 0), j0 = std::max(j - 1, 0);
          const auto around =
              stress.block(i0, j0, std::min(i + 2, nx) - i0, std::min(j + 2, ny) - j0);
          if (stress(i, j) <= 0 || stress(i, j) < around.maxCoeff()) continue;
          StressPeak& peak = peaks.emplace_back(first[number(i, j)]);
          peak.value = stress(i, j);
          peak.on_positive_normal = side > 0;
        }
    }
  }
  return peaks;
}

std::vector<StressPeak> LeafStress::peaks() const {
  const std::vector<StressPeak> all = peaks_at(stations.places());
  if (stations.kind == StressStations::Kind::plate) return plate_peaks(all);
  std::vector<StressPeak> sections, peaks;  // the largest of each section; those of them
  for (const StressPeak& peak : all)
    if (sections.empty() || peak.along != sections.back().along ||
        peak.segment != sections.back().segment)
      sections.push_back(peak);
    else if (peak.value > sections.back().value * equal)
      sections.back() = peak;
  for (std::size_t k = 0; k < sections.size(); ++k) {
    const auto exceeded_by = [&](std::size_t other) {
      return sections[other].segment == sections[k].segment &&
             sections[other].value > sections[k].value;
    };
    if (sections[k].value > 0 && !(k > 0 && exceeded_by(k - 1)) &&
        !(k + 1 < sections.size() && exceeded_by(k + 1)))
      peaks.push_back(sections[k]);
  }
  return peaks;
}

std::vector<StressPeak> LeafStress::at_clamps(const ClampFactors& factors) const {
  std::vector<StressPeak> peaks;
  for (const int end : {0, 1}) {
    if (!factors[end] || stations.kind == StressStations::Kind::wire) continue;
    std::vector<StressPlace> places;
    for (const double y : stations.across)
      if (!stations.in_corner(end, y))
        places.push_back({static_cast<double>(end), y, end == 0 ? 0 : stations.segments - 1});
    StressPeak largest;
    largest.leaf = leaf;
    largest.along = end;
    largest.segment = places.front().segment;
    for (StressPeak& peak : peaks_at(places))
      for (const double side : {1.0, -1.0}) {
        peak.value = von_mises(peak.section, side, *factors[end]);
        peak.on_positive_normal = side > 0;
        if (peak.value > largest.value * equal) largest = peak;
      }
    largest.notch = *factors[end];
    const SectionStress slopes = von_mises_slopes(largest), &section = largest.section;
    largest.per_membrane = slopes.head<3>().dot(section.head<3>()) / largest.notch.membrane;
    largest.per_bending = slopes.tail<3>().dot(section.tail<3>()) / largest.notch.bending;
    if (position) largest.position = position({largest.along, largest.across, largest.segment});
    peaks.push_back(largest);
  }
  return peaks;
}

std::vector<double> LeafStress::on_surface(const std::vector<StressPlace>& places) const {
  std::vector<double> stress;
  if (stations.kind == StressStations::Kind::wire) {
    for (const StressPlace& at : places) stress.push_back(peaks_at({at}).front().value);
    return stress;
  }
  for (const StressPeak& peak : peaks_at(places))
    stress.push_back(std::max(peak.value, von_mises(peak.section, -side_of(peak))));
  return stress;
}

MatrixXd sections_of_segments(
    const std::vector<StressPlace>& places, int n,
    const std::function<MatrixXd(int i, const std::vector<StressPlace>&)>& sections) {
  MatrixXd stresses(6, static_cast<Eigen::Index>(places.size()));
  int segment = -1;
  std::vector<StressPlace> own;  // places in it that follow each other
  Eigen::Index done = 0;
  const auto finish = [&] {
    if (own.empty()) return;
    const auto count = static_cast<Eigen::Index>(own.size());
    stresses.middleCols(done, count) = sections(segment, own);
    done += count;
    own.clear();
  };
  for (const StressPlace& place : places) {
    int at = place.segment;
    double along = place.along * n - at;
    if (along < 0 || along > 1) {  // places of a leaf in one piece
      at = std::clamp(static_cast<int>(std::floor(place.along * n)), 0, n - 1);
      along = place.along * n - at;
    }
    if (at != segment) finish();
    segment = at;
    own.push_back({along, place.across});
  }
  finish();
  return stresses;
}

}  // namespace flexopt
