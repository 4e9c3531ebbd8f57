#include "core/reduction/superelement/leaf_chain.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/elements/plate/full_model.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {

LeafSpring leaf_segment(const LeafSpring& leaf, int i, int n) {
  LeafSpring segment = leaf;
  segment.length = leaf.length / n;
  segment.origin = leaf.origin + leaf.axes.col(0) * (leaf.length * i / n);
  segment.base = segment.tip = 0;  // held by bodies that move
  segment.point.reset();
  return segment;
}

LeafChain::LeafChain(const LeafSpring& leaf, std::vector<std::unique_ptr<LeafElement>> segments,
                     PlateShape shape, int index)
    : leaf_(leaf),
      segments_(std::move(segments)),
      shape_(std::move(shape)),
      index_(index),
      unit_energy_(LeafScale(leaf).energy) {
  const int n = this->segments();
  assert(n >= 2 && !leaf.point);
  for (int i = 0; i <= n; ++i)
    lines_.push_back({leaf.origin + leaf.axes.col(0) * (leaf.length * i / n), leaf.axes});
  K_.resize(std::vector<int>(n - 1, 6));
  g_.resize(unknowns());
  coupling_ = MatrixXd::Zero(unknowns(), 12);
}

MatrixXd LeafChain::edge_rows(int i, const MatrixXd& T) const {
  const int u = unknowns(), n = segments();
  MatrixXd rows(12, T.cols());
  for (int e = 0; e < 2; ++e) {
    const int line = i + e;
    rows.middleRows<6>(6 * e) = T.middleRows<6>(line == 0 ? u : line == n ? u + 6 : 6 * (line - 1));
  }
  return rows;
}

void LeafChain::move(const EdgePoses& edges, const Vector12d& dq) {
  VectorXd T(unknowns() + 12);
  if (condensed_) {
    Vector3d none;
    T << interior_.step(K_, dq, Vector3d::Zero(), none), dq;
  } else {
    T << VectorXd::Zero(unknowns()), dq;
  }
  for (int i = 1; i < segments(); ++i) {
    const auto step = T.segment<6>(6 * (i - 1));
    lines_[i].position += step.head<3>();
    lines_[i].axes = orthonormalised(rotation_exp(step.tail<3>()) * lines_[i].axes);
  }
  lines_.front() = edges[0];
  lines_.back() = edges[1];
  for (int i = 0; i < segments(); ++i)
    segments_[i]->move({lines_[i], lines_[i + 1]}, edge_rows(i, T));
  condensed_ = false;
}

const LeafEvaluation& LeafChain::evaluate() {
  const int n = segments(), last = n - 1;
  LeafEvaluation& sum = evaluation_;
  sum = {};
  for (MatrixXd& D : K_.diagonal) D.setZero();
  g_.setZero();
  coupling_.setZero();
  for (int i = 0; i < n; ++i) {
    const LeafEvaluation& own = segments_[i]->evaluate();
    sum.energy += own.energy;
    sum.correction = std::max(sum.correction, own.correction);
    sum.strain = std::max(sum.strain, own.strain);
    sum.negative_pivots += own.negative_pivots;
    const auto block = [&](int a, int b) { return own.tangent.block<6, 6>(6 * a, 6 * b); };
    if (i > 0) {
      g_.segment<6>(6 * (i - 1)) += own.force.head<6>();
      K_.diagonal[i - 1] += block(0, 0);
    } else {
      sum.force.head<6>() = own.force.head<6>();
      sum.tangent.topLeftCorner<6, 6>() = block(0, 0);
      coupling_.block<6, 6>(0, 0) = block(1, 0);
    }
    if (i < last) {
      g_.segment<6>(6 * i) += own.force.tail<6>();
      K_.diagonal[i] += block(1, 1);
    } else {
      sum.force.tail<6>() = own.force.tail<6>();
      sum.tangent.bottomRightCorner<6, 6>() = block(1, 1);
      coupling_.block<6, 6>(6 * (i - 1), 6) = block(0, 1);
    }
    if (i > 0 && i < last) K_.below[i - 1] = block(1, 0);
  }
  K_.factorise();
  interior_.condense(K_, g_, coupling_, sum.force, sum.tangent, last - 1);
  sum.negative_pivots += interior_.negative_pivots();
  sum.force = interior_.force();
  sum.tangent = interior_.tangent();
  sum.correction = std::max(sum.correction, std::sqrt(interior_.correction() / unit_energy_));
  condensed_ = true;
  return evaluation_;
}

namespace {
struct LeafChainState final : LeafState {
  std::vector<EdgePose> lines;
  std::vector<std::unique_ptr<LeafState>> segments;
};
}  // namespace

std::unique_ptr<LeafState> LeafChain::save() const {
  auto copy = std::make_unique<LeafChainState>();
  copy->lines = lines_;
  for (const auto& segment : segments_) copy->segments.push_back(segment->save());
  return copy;
}

void LeafChain::restore(const LeafState& state) {
  const auto& kept = static_cast<const LeafChainState&>(state);
  lines_ = kept.lines;
  for (int i = 0; i < segments(); ++i) segments_[i]->restore(*kept.segments[i]);
  condensed_ = false;
}

namespace {

// Modes between held edges, through the inverted pencil where K is positive definite: the lowest
// come out with full accuracy.
struct HeldModes {
  VectorXd omega2;
  MatrixXd shapes;
};
HeldModes held_modes(const MatrixXd& K, const MatrixXd& M, int count) {
  const int inner = static_cast<int>(K.rows());
  if (Cholesky(K).positive_definite()) {
    const int kept = std::min(count, inner);
    const SymmetricEigen eigen(M, K);
    const VectorXd mu = eigen.eigenvalues().tail(kept).reverse().cwiseMax(1e-300);
    return {mu.cwiseInverse(), eigen.eigenvectors().rightCols(kept).rowwise().reverse() *
                                   mu.cwiseSqrt().cwiseInverse().asDiagonal()};
  }
  const SymmetricEigen eigen(K, M);
  const auto unstable = static_cast<int>((eigen.eigenvalues().array() < 0).count());
  const int kept = std::min(count + unstable, inner);  // unstable ones in addition
  return {eigen.eigenvalues().head(kept), eigen.eigenvectors().leftCols(kept)};
}

}  // namespace

LeafDynamics LeafChain::dynamics(DynamicsRequest request) {
  if (!condensed_) evaluate();
  const int n = segments(), u = unknowns(), count = request.modes;
  std::vector<LeafDynamics> parts;
  int own = 0, stations = 0;
  for (auto& segment : segments_) {
    parts.push_back(segment->dynamics(std::max(1, (count + n - 1) / n)));
    own += static_cast<int>(parts.back().mode_frequencies.size());
    stations += static_cast<int>(parts.back().stations.rows());
  }
  // over (inner lines, modes of the segments, edges)
  const int inner = u + own;
  MatrixXd T0 = MatrixXd::Identity(inner + 12, inner + 12),
           M = MatrixXd::Zero(inner + 12, inner + 12), motion(stations, inner + 12);
  MatrixXd lines(u + 12, inner + 12);  // rows of lines and edges
  lines << T0.topRows(u), T0.bottomRows(12);
  MatrixXd K = MatrixXd::Zero(inner + 12, inner + 12);
  for (int i = 0, o = u, s = 0; i < n; ++i) {
    const LeafDynamics& part = parts[i];
    const int k = static_cast<int>(part.mode_frequencies.size());
    const MatrixXd edges = edge_rows(i, lines);
    MatrixXd T(12 + k, inner + 12);
    T << edges, T0.middleRows(o, k);
    M.noalias() += T.transpose() * part.mass * T;
    K.noalias() += edges.transpose() * segments_[i]->evaluation().tangent * edges;
    K.block(o, o, k, k) = part.internal_stiffness;
    motion.middleRows(s, part.stations.rows()).noalias() = part.stations * T;
    s += static_cast<int>(part.stations.rows());
    o += k;
  }
  // static shapes of the edges, and modes between held edges
  const MatrixXd Ki = K.topLeftCorner(inner, inner);
  const HeldModes modes = held_modes(Ki, M.topLeftCorner(inner, inner), count);
  MatrixXd R = MatrixXd::Zero(inner + 12, 12 + modes.omega2.size());
  R.topLeftCorner(inner, 12) = -Lu(Ki).solve(K.topRightCorner(inner, 12));
  R.bottomLeftCorner<12, 12>().setIdentity();
  R.topRightCorner(inner, modes.omega2.size()) = modes.shapes;

  LeafDynamics dynamics;
  dynamics.mass = R.transpose() * M * R;
  dynamics.stations = motion * R;
  set_modes(dynamics, modes.omega2);
  return dynamics;
}

LeafStress LeafChain::stress() {
  std::vector<LeafStress> own;
  for (const auto& segment : segments_) own.push_back(segment->stress());
  LeafStress whole = own.front();
  whole.known.reset();
  const int n = whole.stations.segments = segments();
  whole.position = [n, own](const StressPlace& at) {
    return own[static_cast<std::size_t>(at.segment)].position(
        {n * at.along - at.segment, at.across});
  };
  whole.sections = [n, own = std::move(own)](const std::vector<StressPlace>& places) {
    return sections_of_segments(places, n, [&](int i, const std::vector<StressPlace>& of_segment) {
      return own[static_cast<std::size_t>(i)].sections(of_segment);
    });
  };
  return whole;
}

std::unique_ptr<LeafElement> LeafChain::full_model(const std::string& reason) {
  return full_model_in_place(*this, {{lines_.front(), lines_.back()}}, leaf_,
                             std::make_shared<PlateMesh>(shape_), index_, reason);
}

LeafShape LeafChain::shape() {
  std::vector<LeafShape> own;
  LeafShape shape;
  for (auto& segment : segments_) {
    own.push_back(segment->shape());
    shape.points_along += own.back().points_along - (own.size() > 1 ? 1 : 0);
  }
  shape.points_across = own.front().points_across;
  for (int j = 0; j < shape.points_across; ++j)
    for (std::size_t i = 0; i < own.size(); ++i)
      for (int k = i > 0 ? 1 : 0; k < own[i].points_along; ++k) {
        const int at = j * own[i].points_along + k;
        shape.undeflected.push_back(own[i].undeflected[at]);
        shape.deflected.push_back(own[i].deflected[at]);
        shape.von_mises.push_back(own[i].von_mises[at]);
      }
  return shape;
}

std::vector<Vector3d> LeafChain::material_points(const std::vector<std::array<double, 2>>& places) {
  std::vector<Vector3d> points;
  for (const auto& [along, across] : places) {
    const int i = std::clamp(static_cast<int>(along * segments()), 0, segments() - 1);
    points.push_back(segments_[i]->material_point(along * segments() - i, across));
  }
  return points;
}

}  // namespace flexopt
