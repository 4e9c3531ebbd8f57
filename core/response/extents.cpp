#include "core/response/room_taken.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "core/response/solid_search.hpp"

namespace flexopt {
namespace {

// A function of the place of a point of a solid, which `f` gives over a size, with its derivative
// and second derivative, along the coordinates of the point.
template <class F>
LocalValue value_at(const Solids& solids, const SolidPoint& point, const F& f) {
  const Solids::Local here = solids.local(point);
  LocalValue result;
  Vector3d slope;
  Matrix3d curvature;
  f(here.place, result.value, slope, curvature);
  result.gradient = here.slopes.transpose() * slope;
  result.curvature = here.slopes.transpose() * curvature * here.slopes;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      result.curvature(i, j) += slope.dot(here.curvatures[symmetric_index(i, j)]);
  return result;
}

// The point of a solid, from a sample, that makes the function least: in the cell to which it falls
// first, from inside of it. Long steps, and those by the curvature of the cell on the other side,
// pass over what is least there.
template <class F>
SolidPoint least_point(const Solids& solids, const Solids::SampleGrid& grid,
                       const SolidPoint& sample, const F& f) {
  constexpr double inside = 0.25;  // of the cell
  const int solid = sample.solid;
  const auto value = [&](const VectorXd& at) { return value_at(solids, {solid, at}, f); };
  const Vector3d lower = solids.lower(solid), upper = solids.upper(solid);
  const Vector3d slope = value(sample.at).gradient;
  Vector3d low = lower.cwiseMax(sample.at - grid.steps),
           high = upper.cwiseMin(sample.at + grid.steps), start = sample.at;
  for (int k = 0; k < 3; ++k) {
    if (slope[k] > 0) high[k] = sample.at[k];
    if (slope[k] < 0) low[k] = sample.at[k];
    if (slope[k] != 0) start[k] += inside * ((slope[k] > 0 ? low : high)[k] - start[k]);
  }
  return {solid, local_minimum(value, lower, upper, local_minimum(value, low, high, start))};
}

// Samples of a solid, with the slopes of the place at those of which they were asked: all
// directions share them.
class Samples {
 public:
  Samples(const Solids& solids, int solid)
      : solids_(&solids), solid_(solid), grid_(solids.surface_samples(solid)) {}
  const Solids::SampleGrid& grid() const { return grid_; }
  const Matrix3d& slopes(std::size_t sample) {
    if (slopes_.empty()) slopes_.resize(grid_.samples.size());
    if (!slopes_[sample])
      slopes_[sample] = solids_->local({solid_, grid_.samples[sample].at}).slopes;
    return *slopes_[sample];
  }

 private:
  const Solids* solids_;
  int solid_;
  Solids::SampleGrid grid_;
  std::vector<std::optional<Matrix3d>> slopes_;
};

// What the function may lose between a sample and its neighbours by its slope there: of a cubic
// between two samples the slope at one of them is worth 4/27 of a step along its tangent, those at
// both a quarter; half is taken.
template <class F>
double descent(const Solids& solids, int solid, Samples& samples, std::size_t sample, const F& f) {
  const Solids::SampleGrid& grid = samples.grid();
  const Solids::Sample& at = grid.samples[sample];
  double value;
  Vector3d slope;
  Matrix3d curvature;
  f(at.place, value, slope, curvature);
  const Vector3d gradient = samples.slopes(sample).transpose() * slope, lower = solids.lower(solid),
                 upper = solids.upper(solid);
  double sum = 0;
  for (int k = 0; k < 3; ++k)
    if (gradient[k] > 0 ? at.at[k] > lower[k] : at.at[k] < upper[k])
      sum += 0.5 * std::abs(gradient[k]) * grid.steps[k];
  return sum;
}

// Largest difference of a sample from its neighbours, summed over the coordinates.
double change_beside(const Solids::SampleGrid& grid, const std::vector<double>& reached,
                     std::size_t sample) {
  double sum = 0;
  std::size_t stride = 1;
  for (std::size_t axis = 3; axis-- > 0;) {
    const auto count = static_cast<std::size_t>(grid.counts[axis]), place = sample / stride % count;
    double most = 0;
    const auto compare = [&](std::size_t neighbour) {
      most = std::max(most, std::abs(reached[neighbour] - reached[sample]));
    };
    if (place > 0) compare(sample - stride);
    if (place + 1 < count) compare(sample + stride);
    sum += most;
    stride *= count;
  }
  return sum;
}

// The point that reaches furthest among the solids whose bound exceeds what the previous ones
// reach. Searches start from all samples beside which it may lie, the furthest first: with a single
// search, rounding would decide which of several places is found. The reach is −f, as in value_at,
// over a size; so is `bound` of a solid.
template <class Bound, class F>
SolidPoint furthest(const Solids& solids, std::vector<Samples>& samples, const Bound& bound,
                    const F& f) {
  SolidPoint best;
  double most = -std::numeric_limits<double>::infinity();
  const auto reach = [&](const Vector3d& place) {
    double value;
    Vector3d slope;
    Matrix3d curvature;
    f(place, value, slope, curvature);
    return -value;
  };
  const auto take = [&](const SolidPoint& point) {
    const double here = reach(solids.place(point));
    if (best.solid < 0 || here > most + equal_distance) most = here, best = point;
  };
  for (int i = 0; i < solids.count(); ++i) {
    if (best.solid >= 0 && bound(i) <= most + equal_distance) continue;
    const Solids::SampleGrid& grid = samples[i].grid();
    std::vector<double> reached;
    std::vector<std::size_t> order;
    for (const Solids::Sample& sample : grid.samples) {
      order.push_back(reached.size());
      reached.push_back(reach(sample.place));
    }
    std::ranges::stable_sort(order, std::greater(), [&](std::size_t k) { return reached[k]; });
    take({i, grid.samples[order.front()].at});
    for (const std::size_t k : order) {
      if (reached[k] + change_beside(grid, reached, k) <= most + equal_distance) continue;
      if (reached[k] + descent(solids, i, samples[i], k, f) > most + equal_distance)
        take(least_point(solids, grid, {i, grid.samples[k].at}, f));
    }
  }
  return best;
}

Vector3d off_axis(const CylinderAxis& axis, const Vector3d& place) {
  const Vector3d from = place - axis.through;
  return from - axis.along * axis.along.dot(from);
}

const Drive* turning_drive(const Mechanism& mechanism) {
  for (const Drive& drive : mechanism.drives)
    if (is_rotation(drive.direction)) return &drive;
  return nullptr;
}

}  // namespace

CylinderAxis cylinder_axis(const Mechanism& mechanism) {
  CylinderAxis axis;
  axis.through = mechanism.bodies[mechanism.end_effector].reference;
  if (const Drive* drive = turning_drive(mechanism))
    axis.along = drive->axes.col(index(drive->direction) - 3);
  return axis;
}

Extents extents_of(const Solids& solids) {
  Extents extents;
  const double size = longest_leaf(solids.mechanism());
  std::vector<Samples> samples;
  for (int i = 0; i < solids.count(); ++i) samples.emplace_back(solids, i);
  for (int side = 0; side < 2; ++side)
    for (int k = 0; k < 3; ++k) {
      const double sign = side == 0 ? -1 : 1;
      SolidPoint& at = extents.at[3 * side + k];
      at = furthest(
          solids, samples,
          [&](int i) { return (side == 0 ? -solids.lowest(i)[k] : solids.highest(i)[k]) / size; },
          [&](const Vector3d& place, double& value, Vector3d& slope, Matrix3d& curvature) {
            value = -sign * place[k] / size;
            slope = -sign / size * Vector3d::Unit(k);
            curvature.setZero();
          });
      (side == 0 ? extents.low : extents.high)[k] = solids.place(at)[k];
    }
  const CylinderAxis axis = cylinder_axis(solids.mechanism());
  const Matrix3d across = Matrix3d::Identity() - axis.along * axis.along.transpose();
  extents.at[6] = furthest(
      solids, samples,
      [&](int i) {
        double most = 0;
        for (int k = 0; k < 8; ++k) {
          Vector3d corner;
          for (int d = 0; d < 3; ++d)
            corner[d] = (k >> d & 1) != 0 ? solids.highest(i)[d] : solids.lowest(i)[d];
          most = std::max(most, 0.5 * (off_axis(axis, corner) / size).squaredNorm());
        }
        return most;
      },
      [&](const Vector3d& place, double& value, Vector3d& slope, Matrix3d& curvature) {
        const Vector3d r = off_axis(axis, place) / size;
        value = -0.5 * r.squaredNorm();
        slope = -r / size;
        curvature = -across / (size * size);
      });
  extents.radius = off_axis(axis, solids.place(extents.at[6])).norm();
  return extents;
}

MatrixXd extent_rates(const Solids& solids, const Extents& extents, const PlaceRates& rates) {
  const auto count = static_cast<Eigen::Index>(rates.directions->size());
  MatrixXd result(7, count);
  for (int k = 0; k < 6; ++k) result.row(k) = solids.place_rates(extents.at[k], rates).row(k % 3);
  const Mechanism& mechanism = solids.mechanism();
  const CylinderAxis axis = cylinder_axis(mechanism);
  const Vector3d place = solids.place(extents.at[6]), r = off_axis(axis, place),
                 away = r.norm() > 0 ? Vector3d(r.normalized()) : Vector3d(Vector3d::Zero());
  const MatrixXd moves = solids.place_rates(extents.at[6], rates);
  for (Eigen::Index p = 0; p < count; ++p) {
    const Mechanism& d = (*rates.directions)[p];
    const Vector3d through = d.bodies[mechanism.end_effector].reference;
    Vector3d turns = Vector3d::Zero();
    if (const Drive* drive = turning_drive(mechanism)) {
      const auto i = static_cast<std::size_t>(drive - mechanism.drives.data());
      turns = d.drives[i].axes.col(index(drive->direction) - 3);
    }
    result(6, p) = away.dot(Vector3d(moves.col(p)) - through) -
                   axis.along.dot(place - axis.through) * away.dot(turns);
  }
  return result;
}

namespace {

// How far a state reaches to low x, y, z, high x, y, z, and off the axis.
using Reach = Eigen::Matrix<double, 7, 1>;
Reach reach_of(const Extents& state) {
  return (Reach() << -state.low, state.high, state.radius).finished();
}

// The states that reach furthest.
std::array<std::size_t, 7> furthest_states(const std::vector<const Extents*>& states) {
  std::array<std::size_t, 7> of{};
  for (std::size_t i = 1; i < states.size(); ++i)
    for (std::size_t k = 0; k < of.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      const double most = reach_of(*states[of[k]])[row];
      if (reach_of(*states[i])[row] > most + equal_distance * std::abs(most)) of[k] = i;
    }
  return of;
}

}  // namespace

Envelope envelope_of(const std::vector<const Extents*>& states) {
  const auto of = furthest_states(states);
  Envelope envelope;
  for (int k = 0; k < 3; ++k) envelope.box[k] = states[of[3 + k]]->high[k] - states[of[k]]->low[k];
  envelope.cylinder = 2 * states[of[6]]->radius;
  return envelope;
}

MatrixXd envelope_rates(const std::vector<const Extents*>& states,
                        const std::vector<const MatrixXd*>& rates) {
  const auto of = furthest_states(states);
  MatrixXd result(4, rates.front()->cols());
  for (int k = 0; k < 3; ++k) result.row(k) = rates[of[3 + k]]->row(3 + k) - rates[of[k]]->row(k);
  result.row(3) = 2 * rates[of[6]]->row(6);
  return result;
}

}  // namespace flexopt
