#include "core/elements/leaf/leaf_chain_gradient.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace flexopt {

// ------------------------------------------------------------------------------------- linearised

LeafChainLinear::LeafChainLinear(const LeafChain& chain,
                                 std::vector<std::unique_ptr<LeafLinear>> segments)
    : chain_(&chain), segments_(std::move(segments)), scale_(segments_.front()->scale()) {
  const int n = this->segments();
  scale_.length *= n;
  scale_.mass *= std::pow(n, 4);
  std::vector<int> edges(12);
  for (int k = 0; k < 12; ++k) edges[static_cast<std::size_t>(k)] = k;
  offset_.push_back(0);
  for (const auto& segment : segments_) {
    offset_.push_back(offset_.back() + segment->unknowns());
    shapes_.push_back(segment->static_shapes(edges));
  }
}

int LeafChainLinear::edge_row(int i, int edge) const {
  const int line = i + edge;
  if (line == 0) return unknowns();
  return line == segments() ? unknowns() + 6 : lines() + 6 * (line - 1);
}

MatrixXd LeafChainLinear::segment_rows(int i, const MatrixXd& V) const {
  const int own = segment(i).unknowns();
  MatrixXd rows(own + 12, V.cols());
  rows.topRows(own) = V.middleRows(offset(i), own);
  for (int e = 0; e < 2; ++e) {
    rows.middleRows<3>(own + 6 * e) = segments() * V.middleRows<3>(edge_row(i, e));
    rows.middleRows<3>(own + 6 * e + 3) = V.middleRows<3>(edge_row(i, e) + 3);
  }
  return rows;
}

void LeafChainLinear::add_segment_force(int i, double factor, const MatrixXd& rows,
                                        MatrixXd& V) const {
  const int own = segment(i).unknowns();
  V.middleRows(offset(i), own) += factor * rows.topRows(own);
  for (int e = 0; e < 2; ++e) {
    V.middleRows<3>(edge_row(i, e)) += (factor * segments()) * rows.middleRows<3>(own + 6 * e);
    V.middleRows<3>(edge_row(i, e) + 3) += factor * rows.middleRows<3>(own + 6 * e + 3);
  }
}

// The unknowns of the segments follow their lines: x = K_s⁻¹ b + X (lines), K_lines = Σ Xᵀ K X.
void LeafChainLinear::solve(Eigen::Ref<MatrixXd> b) const {
  MatrixXd all(unknowns() + 12, b.cols());
  all << b, MatrixXd::Zero(12, b.cols());
  for (int i = 0; i < segments(); ++i) {
    const int own = segment(i).unknowns();
    MatrixXd force(own + 12, b.cols());
    force << MatrixXd::Zero(own, b.cols()),
        shapes_[static_cast<std::size_t>(i)].transpose() * b.middleRows(offset(i), own);
    add_segment_force(i, 1, force, all);
  }
  const Matrix3d& A = scale_.axes;
  MatrixXd x = all.middleRows(lines(), unknowns() - lines());
  for (int r = 0; r < x.rows(); r += 3)
    x.middleRows<3>(r) = (A * x.middleRows<3>(r) / (r % 6 == 0 ? scale_.length : 1)).eval();
  chain_->solve(x);
  for (int r = 0; r < x.rows(); r += 3)
    x.middleRows<3>(r) =
        (scale_.energy / (r % 6 == 0 ? scale_.length : 1) * A.transpose() * x.middleRows<3>(r))
            .eval();
  all.setZero();
  all.middleRows(lines(), x.rows()) = x;
  for (int i = 0; i < segments(); ++i) {
    const int own = segment(i).unknowns();
    MatrixXd u = b.middleRows(offset(i), own);
    segment(i).solve(u);
    b.middleRows(offset(i), own) =
        u + shapes_[static_cast<std::size_t>(i)] * segment_rows(i, all).bottomRows(12);
  }
  b.bottomRows(x.rows()) = x;
}

MatrixXd LeafChainLinear::static_shapes(const std::vector<int>& columns) const {
  const Matrix3d& A = scale_.axes;
  const MatrixXd global = chain_->static_shapes();
  MatrixXd V = MatrixXd::Zero(unknowns() + 12, 12);
  V.bottomRows(12).setIdentity();
  for (int r = 0; r < global.rows(); r += 3)
    for (int c = 0; c < 12; c += 3) {
      const double unit = (c % 6 == 0 ? scale_.length : 1) / (r % 6 == 0 ? scale_.length : 1);
      V.block<3, 3>(lines() + r, c) = unit * A.transpose() * global.block<3, 3>(r, c) * A;
    }
  for (int i = 0; i < segments(); ++i)
    V.middleRows(offset(i), segment(i).unknowns()) =
        shapes_[static_cast<std::size_t>(i)] * segment_rows(i, V).bottomRows(12);
  return V.topRows(unknowns())(Eigen::all, columns);
}

MatrixXd LeafChainLinear::mass_times(const MatrixXd& V) const {
  MatrixXd force = MatrixXd::Zero(V.rows(), V.cols());
  for (int i = 0; i < segments(); ++i)
    add_segment_force(i, segment(i).scale().mass / scale_.mass,
                      segment(i).mass_times(segment_rows(i, V)), force);
  return force;
}

MatrixXd LeafChainLinear::station_motion(const MatrixXd& V) const {
  std::vector<MatrixXd> parts;
  Eigen::Index rows = 0;
  for (int i = 0; i < segments(); ++i) {
    parts.push_back(segment(i).station_motion(segment_rows(i, V)));
    rows += parts.back().rows();
  }
  MatrixXd motion(rows, V.cols());
  Eigen::Index r = 0;
  for (const MatrixXd& part : parts) {
    motion.middleRows(r, part.rows()) = part;
    r += part.rows();
  }
  return motion;
}

Answer<LeafGradient<double>> LeafChainLinear::gradient(LeafRates& rates,
                                                       const LeafRows& rows) const {
  LeafChainGradient::Segments own;
  for (int i = 0; i < segments(); ++i) {
    Answer<LeafGradient<double>> of_segment =
        segment(i).gradient(rates, LeafChainGradient::segment_rows(*this, i, rows));
    if (!of_segment.value) return of_segment;
    own.push_back(std::move(of_segment.value));
  }
  return {std::make_unique<LeafChainGradient>(*this, std::move(own), rows)};
}

// --------------------------------------------------------------------------------------- gradient

namespace {

// The w/L and t/L of a segment are n times those of the leaf, and so are their derivatives.
VectorXd segment_shape(VectorXd shape, int n) {
  shape[ShapeParameter::width] *= n;
  shape[ShapeParameter::thickness] *= n;
  return shape;
}

}  // namespace

LeafRows LeafChainGradient::segment_rows(const LeafChainLinear& linear, int i,
                                         const LeafRows& rows) {
  const int n = linear.segments();
  LeafRows own;
  own.unknowns = linear.segment(i).unknowns();
  if (i == 0) own.lever[0] = n * rows.lever[0];
  if (i == n - 1) own.lever[1] = n * rows.lever[1];
  return own;
}

LeafChainGradient::LeafChainGradient(const LeafChainLinear& linear, Segments segments,
                                     const LeafRows& rows)
    : LeafGradient<double>(rows, segments.front()->width() / linear.segments()),
      linear_(&linear),
      segments_(std::move(segments)) {
  assert(rows.unknowns == linear.unknowns() && rows.point == 0);
  MatrixXd force = MatrixXd::Zero(size(), 1);
  for (int i = 0; i < linear.segments(); ++i)
    add_force(i, segments_[static_cast<std::size_t>(i)]->force(), force);
  force_ = force;
}

// First row of the increments of what holds an edge of segment i: a body, or an inner line.
int LeafChainGradient::body_row(int i, int edge) const {
  const int line = i + edge;
  if (line == 0) return rows_.body(0);
  return line == linear_->segments() ? rows_.body(1) : linear_->lines() + 6 * (line - 1);
}

MatrixXd LeafChainGradient::own_rows(int i, const MatrixXd& Y) const {
  const int own = linear_->segment(i).unknowns(), n = linear_->segments();
  MatrixXd rows(own + 12, Y.cols());
  rows.topRows(own) = Y.middleRows(linear_->offset(i), own);
  for (int e = 0; e < 2; ++e) {
    rows.middleRows<3>(own + 6 * e) = n * Y.middleRows<3>(body_row(i, e));
    rows.middleRows<3>(own + 6 * e + 3) = Y.middleRows<3>(body_row(i, e) + 3);
  }
  return rows;
}

void LeafChainGradient::add_force(int i, const MatrixXd& rows, MatrixXd& Y) const {
  const int own = linear_->segment(i).unknowns(), n = linear_->segments();
  Y.middleRows(linear_->offset(i), own) += rows.topRows(own);
  for (int e = 0; e < 2; ++e) {
    Y.middleRows<3>(body_row(i, e)) += n * rows.middleRows<3>(own + 6 * e);
    Y.middleRows<3>(body_row(i, e) + 3) += rows.middleRows<3>(own + 6 * e + 3);
  }
}

// Variations of segment i; the inner lines move along with the leaf.
std::vector<LeafVariation<double>> LeafChainGradient::own_variations(
    int i, const std::vector<LeafVariation<double>>& variations) const {
  const int n = linear_->segments();
  std::vector<LeafVariation<double>> own = variations;
  for (LeafVariation<double>& v : own) {
    v.shape = segment_shape(v.shape, n);
    for (int e = 0; e < 2; ++e) {
      const bool held = i + e == 0 || i + e == n;
      if (!held) v.edge[e] = {};
      v.edge[e].position *= n;
      v.edge[e].arm *= n;
    }
  }
  return own;
}

MatrixXd LeafChainGradient::force_rates(
    const std::vector<LeafVariation<double>>& variations) const {
  MatrixXd rows = MatrixXd::Zero(size(), static_cast<Eigen::Index>(variations.size()));
  for (int i = 0; i < linear_->segments(); ++i)
    add_force(i, segments_[static_cast<std::size_t>(i)]->force_rates(own_variations(i, variations)),
              rows);
  return rows;
}

LeafQuadratic<double> LeafChainGradient::quadratic(const MatrixXd& Y, const VectorXd& mu) const {
  const int n = linear_->segments(), columns = static_cast<int>(Y.cols());
  LeafQuadratic<double> q(size(), columns);
  for (int i = 0; i < n; ++i) {
    const double mass = linear_->segment(i).scale().mass / linear_->scale().mass;
    const LeafQuadratic<double> own =
        segments_[static_cast<std::size_t>(i)]->quadratic(own_rows(i, Y), mass * mu);
    q.stiffness += own.stiffness;
    q.mass += mass * own.mass;
    add_force(i, own.state, q.state);
    for (int k = 0; k < columns; ++k) {
      q.shape.col(k) += segment_shape(own.shape.col(k), n);
      for (int e = 0; e < 2; ++e) {
        const LeafQuadratic<double>::Edge& of = own.edge[static_cast<std::size_t>(k)][e];
        LeafQuadratic<double>::Edge& to = q.edge[static_cast<std::size_t>(k)][e];
        to.across += of.across;
        if (i + e != 0 && i + e != n) continue;
        to.rotation = of.rotation;
        to.position = n * of.position;
        to.arm = n * of.arm;
        to.displacement = n * of.displacement;
        to.spin = of.spin;
      }
    }
  }
  return q;
}

namespace {

class LeafChainFields final : public LeafFields {
 public:
  explicit LeafChainFields(std::vector<std::unique_ptr<LeafFields>> segments)
      : segments_(std::move(segments)) {}

  MatrixXd place_rates(double along, double across) const override {
    const auto n = static_cast<double>(segments_.size());
    const auto i = static_cast<std::size_t>(std::clamp(std::floor(along * n), 0.0, n - 1));
    return segments_[i]->place_rates(along * n - static_cast<double>(i), across) / n;
  }
  VectorXd stress_rates(const StressPeak& peak, double modulus,
                        const VectorXd& modulus_rates) const override {
    StressPeak own = peak;
    own.along = peak.along * static_cast<double>(segments_.size()) - peak.segment;
    return segments_[static_cast<std::size_t>(peak.segment)]->stress_rates(own, modulus,
                                                                           modulus_rates);
  }

  MatrixXd section_rates(const std::vector<StressPlace>& places, double modulus,
                         const VectorXd& modulus_rates) const override {
    MatrixXd rates(6 * static_cast<Eigen::Index>(places.size()), modulus_rates.size());
    for (const PlacesOfSegment& of : places_by_segment(places, static_cast<int>(segments_.size())))
      rates.middleRows(6 * of.first, 6 * static_cast<Eigen::Index>(of.own.size())) =
          segments_[of.segment]->section_rates(of.own, modulus, modulus_rates);
    return rates;
  }

 private:
  std::vector<std::unique_ptr<LeafFields>> segments_;
};

}  // namespace

std::unique_ptr<LeafFields> LeafChainGradient::fields(
    const MatrixXd& rows, const std::vector<LeafVariation<double>>& variations) const {
  std::vector<std::unique_ptr<LeafFields>> segments;
  for (int i = 0; i < linear_->segments(); ++i)
    segments.push_back(segments_[static_cast<std::size_t>(i)]->fields(
        own_rows(i, rows), own_variations(i, variations)));
  return std::make_unique<LeafChainFields>(std::move(segments));
}

}  // namespace flexopt
