#include "core/reduction/tube/tube_leaf.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "core/math/polynomial.hpp"

namespace flexopt {
namespace {

/// Values of σ at the nodes of a curved leaf, ascending on both sides of zero: evenly spaced, and
/// closer together about the straightened leaf, where a wide one changes from stiffened by its
/// curvature across to flat.
std::vector<double> curved_nodes(const TubeRange& range, double angle, double slenderness) {
  constexpr double largest_step = 0.2, smallest_step = 0.012;  // [rad]
  const double end = std::max(range.sigma_max, 0.01);
  const int parts = 1 + static_cast<int>(end / largest_step);
  std::vector<double> sigma;
  for (int k = -parts; k <= parts; ++k) sigma.push_back(end * k / parts);
  const double both_ends = range.ray[0] - range.ray[1];  // turned against each other
  if (slenderness < 5 || std::abs(both_ends) < 0.2) return sigma;
  for (const double beside : {0.0, 0.03, -0.03, 0.1, -0.1}) {
    const double place = angle / both_ends + beside;
    const bool taken = std::any_of(sigma.begin(), sigma.end(),
                                   [&](double s) { return std::abs(s - place) < smallest_step; });
    if (!taken && std::abs(place) < end) sigma.push_back(place);
  }
  std::sort(sigma.begin(), sigma.end());
  return sigma;
}

/// Values of σ at the nodes of a flat leaf.
std::vector<double> flat_nodes(const TubeRange& range, double slenderness) {
  std::vector<double> sigma{0};
  // the transition to a stiffened, wide leaf lies at small curvature
  if (slenderness > 20 && range.sigma_max > 0.05) sigma.push_back(0.03);
  if (slenderness > 5 && range.sigma_max > 0.16) sigma.push_back(0.1);
  if (range.sigma_max > 0.32) sigma.push_back(0.22);
  sigma.push_back(std::max(range.sigma_max, least_distance_of_states));
  return sigma;
}

/// w²/(L t).
double slenderness_of(const PlateShape& shape) {
  const double width = shape.mean_width();
  return width * width / shape.mean_thickness();
}
}  // namespace

TubeModel::TubeModel(std::shared_ptr<const PlateMesh> mesh, const TubeRange& range,
                     std::shared_ptr<PlatePool> pool)
    : shape_(mesh->shape()),
      mesh_(std::move(mesh)),
      range_(range),
      directions_(ray_directions(range.ray)),
      pool_(std::move(pool)) {
  build();
}

Eigen::Matrix2d TubeModel::ray_directions(const Eigen::Vector2d& ray) {
  Eigen::Matrix2d directions;
  // for the S (1, 1) and C (1, −1) rays the other one of the two
  directions << ray, Eigen::Vector2d(ray[1], -ray[0]) * (ray[0] * ray[1] < 0 ? -1 : 1);
  return directions;
}

TubeModel::TubeModel(const PlateShape& shape, const TubeRange& range, KnownTube tube)
    : shape_(shape), range_(range), directions_(tube.directions), known_(std::move(tube)) {
  range_.ray = directions_.col(0);
  make_potentials(std::exchange(known_->nodes, {}));
}

std::vector<double> TubeModel::planned_states() const {
  return shape_.curve ? curved_nodes(range_, *shape_.curve, slenderness_of(shape_))
                      : flat_nodes(range_, slenderness_of(shape_));
}

void TubeModel::build() {
  const std::vector<double> all = planned_states();
  const auto zero = std::find(all.begin(), all.end(), 0.0);
  const std::vector<double> sigma(zero, all.end()),
      below(std::make_reverse_iterator(zero), all.rend());
  leaf().reset();
  for (const double s : sigma)
    if (!add(s)) return;
  if (!below.empty()) leaf().reset();
  for (const double s : below)
    if (!add(s)) return;
  make_potentials();
}

void TubeModel::make_potentials() {
  std::vector<TubeNode> nodes;
  for (const TubeExpansion& e : expansions_) nodes.push_back({e.sigma, e.W});
  make_potentials(nodes);
}

void TubeModel::make_potentials(const std::vector<TubeNode>& nodes) {
  for (const int less : {0, 1})
    (less ? lower_ : potential_) = std::make_unique<TubePotential>(
        directions_, tube_force_scale(shape_), 2 * range_.order + 1 - less, nodes, range_.centre(),
        !shape_.curve.has_value());
}

int TubeModel::bent_states() const {
  return static_cast<int>(known_ ? flat_nodes(range_, slenderness_of(shape_)).size()
                                 : expansions_.size());
}

const std::shared_ptr<const PlateMesh>& TubeModel::mesh() const {
  if (!mesh_) mesh_ = std::make_shared<PlateMesh>(shape_);
  return mesh_;
}

PlatePool& TubeModel::pool() {
  if (!pool_) pool_ = std::make_shared<PlatePool>(mesh());
  return *pool_;
}

ChordLeaf& TubeModel::leaf() { return pool().chord(); }

void TubeModel::stand_at(const TubeExpansion& expansion) {
  leaf().stand_at({range_.ray[0] * expansion.sigma, range_.ray[1] * expansion.sigma, 0},
                  range_.centre().cwiseProduct(tube_force_scale(shape_)), expansion.fields.col(0));
}

EdgePoses TubeModel::rest() const {
  if (mesh_) return {mesh_->line_pose(0), mesh_->line_pose(mesh_->lines() - 1)};
  return {EdgePose{Vector3d::Zero(), Matrix3d::Identity()},
          EdgePose{Vector3d::UnitX(), Matrix3d::Identity()}};
}

bool TubeModel::add(double sigma) {
  const Vector3d s(range_.ray[0] * sigma, range_.ray[1] * sigma, 0);
  const Vector3d f = range_.centre().cwiseProduct(tube_force_scale(shape_));
  if (!leaf().solve(s, f).converged || leaf().plate().negative_pivots() > 0) return false;
  const auto place = std::ranges::lower_bound(expansions_, sigma, {}, &TubeExpansion::sigma);
  expansions_.insert(place, expand(leaf(), sigma, directions_, range_.order));
  return true;
}

void TubeModel::cover(double sigma) {
  if (!known_ || covered_) return;
  const auto expand_here = [&](double at) {
    expansions_.push_back({at, {}, expand_fields(leaf(), directions_, range_.order).fields});
    if (dynamics_ && !dynamics_known()) add_dynamics(at);
    if (stress_ && !stress_known()) add_stress(expansions_.back());
  };
  // on to the next node, or as far as the leaf can be bent
  const auto bend_on = [&](double to) {
    const double from = expansions_.back().sigma, at = bend(leaf(), range_.ray, from, to);
    covered_ = at != to;
    if (at > from) expand_here(at);
  };
  if (expansions_.empty()) {
    leaf().reset();
    expand_here(0);
    for (const double at : flat_nodes(range_, slenderness_of(shape_)))
      if (at > 0 && !covered_) bend_on(at);
  }
  assert(expansions_.size() >= 2);
  if (sigma > expansions_.back().sigma * (1 + 1e-9) && !covered_) {
    stand_at(expansions_.back());
    bend_on(std::min(1.1 * sigma, std::max(sigma, potential_->last_sigma())));
  }
}

bool TubeModel::extend(double sigma) {
  kept_ = {};
  if (known_) {  // its own states, mesh and all, take the place of the known ones
    const TubeRange before = range_;
    const bool tables = dynamics_ != nullptr;
    std::optional<KnownTube> known = std::exchange(known_, std::nullopt);
    range_.sigma_max = sigma;
    expansions_.clear();
    dynamics_.reset();
    stress_.reset();
    build();
    if (static_cast<int>(potential_->nodes().size()) == static_cast<int>(expansions_.size()) &&
        potential_->last_sigma() == sigma) {
      if (tables) make_dynamics();
      return true;
    }
    known_ = std::move(known);
    stress_.reset();
    range_ = before;
    expansions_.clear();
    covered_ = false;
    return false;
  }
  const bool below = sigma < potential_->nodes().front().sigma;
  const TubeExpansion& from = below ? expansions_.front() : expansions_.back();
  stand_at(from);
  if (bend(leaf(), range_.ray, from.sigma, sigma) != sigma || !add(sigma)) return false;
  if (dynamics_) add_dynamics(sigma);
  stress_.reset();  // made anew at its next use, of all states in their order
  const TubeExpansion& added = below ? expansions_.front() : expansions_.back();
  potential_->add_node({sigma, added.W});
  lower_->add_node({sigma, added.W});
  return true;
}

VectorXd TubeModel::fields(const Vector3d& s, const Vector3d& f) {
  const TubeLocation location = potential_->locate(s);
  const double side = potential_->mirrored() && location.sigma < 0 ? -1 : 1;
  const double sigma = side * location.sigma;
  cover(sigma);
  std::size_t interval = 0;
  while (interval + 2 < expansions_.size() && sigma > expansions_[interval + 1].sigma) ++interval;
  const TubeExpansion &a = expansions_[interval], &b = expansions_[interval + 1];
  const Vector3d df = f - range_.centre();
  const StateWeights<double> w =
      state_weights(a.sigma, b.sigma, sigma,
                    std::array<double, 5>{side * location.tau, side * s[2], df[0], df[1], df[2]});
  const MonomialTable& table = monomials<6, 2>();
  VectorXd wa(table.size()), wb(table.size());
  const auto put = [&](const auto& parity, const auto& weights) {
    for (std::size_t k = 0; k < parity.size(); ++k) {
      wa[parity[k].number] = weights[0][static_cast<Eigen::Index>(k)];
      wb[parity[k].number] = weights[1][static_cast<Eigen::Index>(k)];
    }
  };
  put(even_monomials(), w.even);
  put(odd_monomials(), w.odd);
  VectorXd y = a.fields.leftCols(table.size()) * wa + b.fields.leftCols(table.size()) * wb;
  if (side < 0) {  // mirror in the thickness: the normal components of the interior change sign
    const int n = mesh_->functions_per_line();
    for (int i = 1; i + 1 < mesh_->lines(); ++i)
      y.segment(leaf().plate().block_offset(i) + 2 * n, n) *= -1;
    // … and so do the slopes of the edges along it
    for (const int line : {0, mesh_->lines() - 1})
      for (int s = 0; s < n; ++s)
        mesh_->each_slope(s, [&](int axis, int unknown) {
          if (axis == 2) y[leaf().plate().block_offset(line) + unknown] *= -1;
        });
  }
  return y;
}

// ---------------------------------------------------------------------------- element

TubeLeaf::TubeLeaf(const LeafSpring& leaf, std::shared_ptr<TubeModel> model, int index,
                   std::string reason)
    : leaf_(leaf),
      index_(index),
      reason_(std::move(reason)),
      scale_(leaf, model->shape().flexure),
      model_(std::move(model)),
      tables_(model_),
      edges_(model_->rest()) {
  state_.mixed.f = model_->range().centre();
}

void TubeLeaf::move(const EdgePoses& edges, const Vector12d& dq) {
  follow(state_, scale_.scaled_increment(dq));
  edges_ = {scale_.scaled(edges[0]), scale_.scaled(edges[1])};
  forget_answers();
}

EdgePoses TubeLeaf::chord_edges() const {
  EdgePoses edges = edges_;
  if (!model_->shape().curve) return edges;
  const PlateMesh& mesh = *model_->mesh();
  edges[0].axes = (edges[0].axes * mesh.line_pose(0).axes.transpose()).eval();
  edges[1].axes = (edges[1].axes * mesh.line_pose(mesh.lines() - 1).axes.transpose()).eval();
  return edges;
}

const LeafEvaluation& TubeLeaf::evaluate() {
  const PlateShape& shape = model_->shape();
  const double chord = model_->rest()[1].position[0];
  const bool framed =
      evaluate_reduced_leaf(model_->potential(), chord, chord_edges(), state_, response_);
  if (!framed) {  // edges on top of each other: no step leads on from here
    evaluation_.correction = 1e6;
    return evaluation_;
  }
  evaluation_.energy = scale_.energy * response_.mixed.energy;
  evaluation_.force = scale_.global_force(response_.force);
  evaluation_.tangent = scale_.global_tangent(response_.tangent);
  const double t = shape.mean_thickness();  // an arc's chord shortens without stretching it
  evaluation_.strain = std::abs(state_.mixed.f[0]) * t * t / 12;
  // the energy that the forces still want to give, as in the full leaf
  const MixedState& m = state_.mixed;
  evaluation_.correction = std::sqrt(std::abs(m.R.dot(m.F_inverse * m.R)));
  return evaluation_;
}

namespace {
struct TubeLeafState final : LeafState {
  EdgePoses edges;
  ReducedState state;
};
}  // namespace

std::unique_ptr<LeafState> TubeLeaf::save() const {
  auto copy = std::make_unique<TubeLeafState>();
  copy->edges = edges_;
  copy->state = state_;
  return copy;
}

void TubeLeaf::restore(const LeafState& state) {
  const auto& copy = static_cast<const TubeLeafState&>(state);
  edges_ = copy.edges;
  state_ = copy.state;
  forget_answers();
}

PlateLeaf::State TubeLeaf::rebuilt() const {
  const PlateMesh& mesh = *model_->mesh();
  const int n = mesh.functions_per_line();
  const Vector6d& e = response_.frame.e;
  const VectorXd y = model_->fields({e[theta1y], e[theta2y], e[twist]}, state_.mixed.f);
  PlateLeaf::State state{edges_, y.head(y.size() - 3)};
  // from the chord frame to the leaf's axes: values move with the base edge, slopes turn only
  const Matrix3d& E = response_.frame.axes;
  for (int i = 1; i + 1 < mesh.lines(); ++i) {
    Eigen::Map<MatrixXd> r(state.x.data() + mesh.edge_unknowns() + (i - 1) * 3 * n, n, 3);
    r = (r * E.transpose()).eval();
    for (int j = 0; j < mesh.nodes_per_line(); ++j) r.row(4 * j) += edges_[0].position.transpose();
  }
  return state;
}

PlateLeaf& TubeLeaf::condensed() {
  PlatePool& pool = model_->pool();
  if (PlateLeaf* known = pool.find(state_number_)) return *known;
  state_number_ = pool.new_state();
  PlateLeaf& plate = pool.take(state_number_);
  plate.set_state(rebuilt());
  plate.assemble();
  const VectorXd dx = plate.internal_step(Vector12d::Zero());
  check_ = dx.cwiseAbs().maxCoeff();
  PlateLeaf::State state = plate.state();
  state.x += dx;
  // The rebuilt state's error in the membrane force, over the buckling load: small beside what is
  // left of that load, and its stiffness will do for the internal shapes (0.1 % in their
  // frequencies).
  constexpr double buckling = 4 * std::numbers::pi * std::numbers::pi, small_force = 0.002;
  const PlateShape& shape = model_->mesh()->shape();
  const double left = std::clamp(1 + state_.mixed.f[0] / buckling, 0.01, 1.0);
  bool is_beside = false;  // compared with the reduced leaf in its own equilibrium, so nearer to it
  const auto wrong_force = [&] {
    const double force =
        plate.correction() / shape.thickness * std::sqrt(12 / shape.mean_width()) / buckling;
    return !(force <= (is_beside ? 0.1 : 1.0) * small_force * left);
  };
  plate.set_state(state);
  // Pulled along its chord an arc bends far more than its fields, of second order in the pull, can
  // tell, and so does a leaf under more than it carries alone: these take several steps.
  constexpr double good = 1e-4;
  constexpr int most = 12;
  double change = check_;
  for (int k = 0; (change > good || wrong_force()) && k < most; ++k) {
    plate.assemble();
    is_beside = true;
    state = plate.state();
    const VectorXd further = plate.internal_step(Vector12d::Zero());
    change = further.cwiseAbs().maxCoeff();
    state.x += further;
    plate.set_state(state);
  }
  // written so that what is no number is not believed either
  if (!(change <= good) || wrong_force())
    rebuilt_believed_ = Because(
        fmt::format("its full state, rebuilt, moves by {:.1e} of its length, by {:.1e} at last",
                    check_, change));
  else if (is_beside)
    rebuilt_believed_ = check_beside_full(plate);
  full_state_ = plate.state();
  return plate;
}

}  // namespace flexopt
