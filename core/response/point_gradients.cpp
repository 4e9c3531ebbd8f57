#include "core/response/point_gradients.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/elements/plate_gradient.hpp"
#include "core/elements/plate_stress.hpp"
#include "core/math/rotation.hpp"
#include "core/response/joint_gradients.hpp"

namespace flexopt {
namespace {

using std::numbers::pi;

// Squares of frequencies nearer than this are one cluster: single derivatives mean nothing there.
constexpr double cluster_gap = 1e-6;

double rate(double value, double derivative) { return derivative / value; }

// The leaf seen from its own axes and scales, along one parameter.
LeafVariation leaf_variation(const System& system, int i, const Mechanism& direction,
                             const ModelOptions& model) {
  const LeafSpring &leaf = system.mechanism().leaves[i], &d = direction.leaves[i];
  const double L = leaf.length, nu = leaf.material.poissons_ratio;
  LeafVariation v;
  v.length = rate(L, d.length);
  const double t = rate(leaf.thickness, d.thickness);
  v.energy = rate(leaf.material.youngs_modulus, d.material.youngs_modulus) + 3 * t;
  if (model.flexure == Flexure::plate)
    v.energy += 2 * nu * d.material.poissons_ratio / (1 - nu * nu);
  v.mass = (leaf.material.density > 0 ? rate(leaf.material.density, d.material.density) : 0) + t +
           4 * v.length;
  v.shape = {(d.width - leaf.width * v.length) / L, (d.thickness - leaf.thickness * v.length) / L,
             d.material.poissons_ratio};
  v.turn = d.axes.transpose() * leaf.axes;
  if (leaf.point && !leaf.point->spread_over_tip) v.point = {d.point->along, d.point->across};
  const std::array<int, 2> body{leaf.base, leaf.tip};
  for (int e = 0; e < 2; ++e) {
    const int b = body[e];
    if (b < 0) continue;
    const BodyPose& pose = system.pose(b);
    const RigidBody &of = system.mechanism().bodies[b], &db = direction.bodies[b];
    const auto scaled = [&](const Vector3d& from_origin, const Vector3d& derivative) {
      return Vector3d((d.axes.transpose() * from_origin + leaf.axes.transpose() * derivative -
                       v.length * leaf.axes.transpose() * from_origin) /
                      L);
    };
    const Vector3d moves = db.reference - d.origin;
    v.edge[e].position = scaled(pose.position - leaf.origin, moves);
    v.edge[e].arm = -scaled(of.reference - leaf.origin, moves);
    v.edge[e].rotation = d.axes.transpose() * pose.rotation * leaf.axes +
                         leaf.axes.transpose() * pose.rotation * d.axes;
  }
  return v;
}

// (26): what the residual of every row changes by at a constant state.
MatrixXd residual_rates(const MechanismFactor& factor, const std::vector<PlateGradient>& leaves,
                        const std::vector<Mechanism>& directions,
                        const std::vector<std::vector<LeafVariation>>& variations) {
  const int count = static_cast<int>(directions.size());
  MatrixXd R = MatrixXd::Zero(factor.size(), count);
  for (std::size_t i = 0; i < factor.leaves().size(); ++i) {
    const MechanismFactor::Leaf& leaf = factor.leaves()[i];
    const LeafScale& scale = leaf.full->scale();
    const VectorXd& f = leaves[i].force();
    factor.add_leaf_force(leaf, scale.energy, leaves[i].force_rates(variations[i]), R);
    for (int k = 0; k < count; ++k) {
      const LeafVariation& v = variations[i][k];
      R.col(k).segment(leaf.offset, leaf.rows.internal()) +=
          scale.energy * v.energy * f.head(leaf.rows.internal());
      const Matrix3d& turned = directions[k].leaves[i].axes;
      for (const MechanismFactor::Leaf::Side& side : leaf.sides) {
        const int r = leaf.row(side), b = 6 * side.body;
        const Vector3d force = f.segment<3>(r);
        R.col(k).segment<3>(b) += scale.energy / scale.length *
                                  (turned * force + (v.energy - v.length) * scale.axes * force);
        if (side.size == 3) continue;
        const Vector3d moment = f.segment<3>(r + 3);
        R.col(k).segment<3>(b + 3) +=
            scale.energy * (turned * moment + v.energy * scale.axes * moment);
      }
    }
  }
  add_joint_residual_rates(factor, directions, R);
  factor.clear_held(R);
  return R;
}

// Derivative of the rigid bodies' yᵀM y, at constant state and along it.
double body_mass_rate(const System& system, const Mechanism& direction, const VectorXd& y,
                      const VectorXd& state_rate) {
  double sum = 0;
  for (int b = 0; b < system.size() / 6; ++b) {
    const RigidBody &body = system.mechanism().bodies[b], &d = direction.bodies[b];
    const Matrix3d& R = system.pose(b).rotation;
    const Vector3d u = y.segment<3>(6 * b), w = y.segment<3>(6 * b + 3),
                   turn = state_rate.segment<3>(6 * b + 3);
    const Vector3d c = R * (body.center_of_mass - body.reference),
                   dc = R * (d.center_of_mass - d.reference) + turn.cross(c);
    const Vector3d p = u + w.cross(c);
    const Matrix3d J = R * body.inertia * R.transpose();
    sum += d.mass * p.squaredNorm() + 2 * body.mass * p.dot(w.cross(dc)) +
           w.dot(R * d.inertia * R.transpose() * w) + 2 * w.dot(turn.cross(J * w));
  }
  return sum;
}

// Of O in the middle of a tip edge whose mean the end-effector follows: the displacement that the
// point of the path lists.
MatrixXd tip_displacement_rates(const MechanismFactor& factor, int i, const PlateGradient& gradient,
                                const std::vector<Mechanism>& directions,
                                const std::vector<LeafVariation>& variations,
                                const MatrixXd& state_rates) {
  const MechanismFactor::Leaf& leaf = factor.leaves()[static_cast<std::size_t>(i)];
  const Mechanism& mechanism = factor.system().mechanism();
  const LeafSpring& spring = mechanism.leaves[i];
  const PlateLeaf& plate = leaf.full->plate();
  const std::vector<MatrixXd> nodal =
      gradient.nodal_rates(factor.leaf_rows(leaf, state_rates), variations);
  MatrixXd rates(3, static_cast<Eigen::Index>(directions.size()));
  for (int p = 0; p < rates.cols(); ++p) {
    const Mechanism& direction = directions[static_cast<std::size_t>(p)];
    const LeafSpring& d = direction.leaves[i];
    Vector3d place = Vector3d::Zero(), rate = Vector3d::Zero();  // over L
    for (const NodalWeight& w :
         point_weights(plate.mesh(), spring.point->along, spring.point->across)) {
      const Vector3d r = plate.nodal()[w.line].row(w.function).transpose();
      place += w.weight * r;
      rate += w.weight * nodal[w.line].block<1, 3>(w.function, 3 * p).transpose() +
              width_slope(plate.mesh(), w) * variations[static_cast<std::size_t>(p)].shape[0] * r;
    }
    rates.col(p) = d.origin + d.axes * place * spring.length +
                   spring.axes * (rate * spring.length + place * d.length) -
                   direction.bodies[mechanism.end_effector].reference;
  }
  return rates;
}

struct Column {
  double lambda = 0;  ///< q = yᵀ(K − λ M) y
  VectorXd y;
};

// (28)–(30): derivatives of q of every column along every parameter, columns × parameters.
MatrixXd quadratic_rates(const MechanismFactor& factor, const std::vector<PlateGradient>& leaves,
                         const std::vector<Mechanism>& directions,
                         const std::vector<std::vector<LeafVariation>>& variations,
                         const MatrixXd& state_rates, const std::vector<Column>& columns) {
  const int count = static_cast<int>(directions.size()), n = static_cast<int>(columns.size());
  MatrixXd rates = MatrixXd::Zero(n, count);
  if (n == 0) return rates;
  MatrixXd Y(factor.size(), n), V = MatrixXd::Zero(factor.size(), n);
  VectorXd lambda(n);
  for (int k = 0; k < n; ++k) {
    Y.col(k) = columns[k].y;
    lambda[k] = columns[k].lambda;
  }
  for (std::size_t i = 0; i < factor.leaves().size(); ++i) {
    const MechanismFactor::Leaf& leaf = factor.leaves()[i];
    const LeafScale& scale = leaf.full->scale();
    const MatrixXd rows = factor.leaf_rows(leaf, Y);
    const PlateGradient::Quadratic q =
        leaves[i].quadratic(rows, lambda * (scale.mass / scale.energy));
    factor.add_leaf_force(leaf, scale.energy, q.state, V);
    for (int k = 0; k < n; ++k)
      for (int p = 0; p < count; ++p) {
        const LeafVariation& v = variations[i][p];
        rates(k, p) += scale.energy * (v.energy * q.stiffness[k] + leaves[i].rate(q, rows, k, v)) -
                       lambda[k] * scale.mass * v.mass * q.mass[k];
      }
  }
  rates.noalias() += V.transpose() * state_rates.topRows(factor.size());
  add_joint_quadratic_rates(factor, directions, state_rates, Y, rates);
  for (int k = 0; k < n; ++k)
    if (lambda[k] != 0)
      for (int p = 0; p < count; ++p)
        rates(k, p) -= lambda[k] * body_mass_rate(factor.system(), directions[p], columns[k].y,
                                                  state_rates.col(p).head(factor.bodies()));
  return rates;
}

// One list of frequencies: the modes, whole clusters, and where their columns stand.
struct ModeColumns {
  int wanted = 0;
  VectorXd lambda;
  struct Run {
    int first, size, column;
  };
  std::vector<Run> runs;
};

ModeColumns mode_columns(const ExactModes& exact, std::vector<Column>& columns) {
  ModeColumns modes;
  modes.wanted = static_cast<int>(exact.modes.size());
  modes.lambda = exact.lambda;
  const int found = static_cast<int>(modes.lambda.size());
  for (int k = 0; k < modes.wanted;) {
    int end = k + 1;
    while (end < found &&
           modes.lambda[end] - modes.lambda[end - 1] <= cluster_gap * std::abs(modes.lambda[end]))
      ++end;
    const double mean = modes.lambda.segment(k, end - k).mean();
    modes.runs.push_back({k, end - k, static_cast<int>(columns.size())});
    for (int a = k; a < end; ++a) columns.push_back({mean, exact.phi.col(a)});
    for (int a = k; a < end; ++a)  // off the diagonal by the sums of two
      for (int b = a + 1; b < end; ++b)
        columns.push_back({mean, exact.phi.col(a) + exact.phi.col(b)});
    k = end;
  }
  return modes;
}

// Frequencies and clusters from the rates of the columns.
void set_frequencies(const ModeColumns& modes, const MatrixXd& rates, MatrixXd& gradients,
                     std::vector<FrequencyCluster>& clusters) {
  const int count = static_cast<int>(rates.cols());
  gradients = MatrixXd::Zero(modes.wanted, count);
  for (const ModeColumns::Run& run : modes.runs) {
    MatrixXd lambda_rates(run.size, count);
    if (run.size == 1) {
      lambda_rates.row(0) = rates.row(run.column);
    } else {
      FrequencyCluster cluster{run.first, run.size, {}};
      MatrixXd mixed = MatrixXd::Zero(run.size, run.size);
      for (int p = 0; p < count; ++p) {
        MatrixXd block(run.size, run.size);
        int column = run.column + run.size;
        for (int a = 0; a < run.size; ++a) block(a, a) = rates(run.column + a, p);
        for (int a = 0; a < run.size; ++a)
          for (int b = a + 1; b < run.size; ++b, ++column)
            block(a, b) = block(b, a) = 0.5 * (rates(column, p) - block(a, a) - block(b, b));
        const double size = block.norm();
        if (size > 0) mixed += (1 + 0.37 * p) / size * block;  // a common basis, if there is one
        cluster.block.push_back(std::move(block));
      }
      const MatrixXd U = Eigen::SelfAdjointEigenSolver<MatrixXd>(mixed).eigenvectors();
      for (int p = 0; p < count; ++p)
        lambda_rates.col(p) = (U.transpose() * cluster.block[p] * U).diagonal();
      clusters.push_back(std::move(cluster));
    }
    for (int a = 0; a < run.size && run.first + a < modes.wanted; ++a) {
      const double omega = std::sqrt(std::abs(modes.lambda[run.first + a]));
      if (omega > 0) gradients.row(run.first + a) = lambda_rates.row(a) / (4 * pi * omega);
    }
  }
}

}  // namespace

std::optional<std::string> without_gradients(const ModelOptions& model) {
  if (model.accuracy == Accuracy::reduced && model.method != Reduction::mixed_potential)
    return "exact derivatives are those of full leaves, or of the default reduction finished on "
           "them";
  if (model.mass == LeafMass::constant || model.leaf_modes == 0)
    return "exact derivatives are those of the consistent mass with all internal motions";
  return std::nullopt;
}

std::vector<std::shared_ptr<const PlateMeshRate>> MeshRates::of(const System& system) {
  std::vector<std::shared_ptr<const PlateMeshRate>> rates;
  for (int i = 0; i < system.leaves(); ++i) {
    const PlateLeaf& plate = dynamic_cast<const FullLeaf&>(system.leaf(i)).plate();
    auto& rate = made_[plate.shared_mesh()];
    if (!rate) rate = std::make_shared<PlateMeshRate>(plate.mesh());
    rates.push_back(rate);
  }
  return rates;
}

PointGradients point_gradients(const MechanismFactor& factor, MeshRates& meshes,
                               const std::vector<Mechanism>& directions, const ModelOptions& model,
                               const StrokeRequest& request, const PathPoint& point,
                               const ExactModeLists& lists) {
  const System& system = factor.system();
  const Mechanism& mechanism = system.mechanism();
  const int n = factor.size(), ee = 6 * mechanism.end_effector, d = index(mechanism.drive);
  std::vector<std::vector<LeafVariation>> variations(system.leaves());
  for (int i = 0; i < system.leaves(); ++i)
    for (const Mechanism& direction : directions)
      variations[i].push_back(leaf_variation(system, i, direction, model));

  const std::vector<std::shared_ptr<const PlateMeshRate>> meshes_of_leaves = meshes.of(system);
  std::vector<PlateGradient> leaves;
  for (std::size_t i = 0; i < factor.leaves().size(); ++i)
    leaves.emplace_back(factor.leaves()[i].full->plate(), meshes_of_leaves[i],
                        factor.leaves()[i].rows);

  // (27)
  const MatrixXd moved = factor.balance(-residual_rates(factor, leaves, directions, variations),
                                        request.load_path ? std::nullopt : std::optional(0.0));
  PointGradients gradients;
  gradients.drive_load = moved.row(n).transpose();
  gradients.displacement = moved.middleRows(ee, 3);
  for (int i = 0; i < system.leaves(); ++i)
    if (const auto& follows = mechanism.leaves[i].point;
        follows && follows->body == mechanism.end_effector && follows->spread_over_tip)
      gradients.displacement =
          tip_displacement_rates(factor, i, leaves[static_cast<std::size_t>(i)], directions,
                                 variations[i], moved.topRows(n));
  gradients.rotation =
      rotation_left_tangent_inverse(rotation_log(system.pose(mechanism.end_effector).rotation)) *
      moved.middleRows(ee + 3, 3);

  std::map<int, std::vector<MatrixXd>> nodal_rates;  // of the leaves that are asked for
  const auto stress_rate = [&](const StressPeak& peak) {
    const int i = peak.leaf;
    const MechanismFactor::Leaf& leaf = factor.leaves()[i];
    const PlateLeaf& plate = leaf.full->plate();
    std::vector<MatrixXd>& nodal = nodal_rates[i];
    if (nodal.empty())
      nodal = leaves[static_cast<std::size_t>(i)].nodal_rates(
          factor.leaf_rows(leaf, moved.topRows(n)), variations[i]);
    VectorXd stress(directions.size());
    for (int p = 0; p < stress.size(); ++p) {
      StressRate along{{}, variations[i][p].shape, directions[p].leaves[i].material.youngs_modulus};
      for (const MatrixXd& line : nodal) along.nodal.push_back(line.middleCols<3>(3 * p));
      stress[p] = plate_stress_rate(plate.mesh(), plate.nodal(), peak,
                                    mechanism.leaves[i].material.youngs_modulus, along);
    }
    return stress;
  };
  if (point.max_stress) gradients.max_stress = stress_rate(*point.max_stress);
  gradients.stress_peaks.resize(static_cast<Eigen::Index>(point.stress_peaks.size()),
                                static_cast<Eigen::Index>(directions.size()));
  for (Eigen::Index k = 0; k < gradients.stress_peaks.rows(); ++k)
    gradients.stress_peaks.row(k) =
        k == 0 ? gradients.max_stress->transpose()
               : stress_rate(point.stress_peaks[static_cast<std::size_t>(k)]).transpose();

  // compliances: −yᵀK′y of y = K⁻¹ e
  std::vector<Column> columns;
  std::vector<int> supports;
  const auto answer = [&](int direction, bool locked) {
    const VectorXd e = VectorXd::Unit(n, ee + direction);
    columns.push_back({0, locked ? factor.solve_locked(e) : factor.solve(e)});
  };
  answer(d, false);
  for (int k = 0; k < 6; ++k)
    if (point.support_stiffness[k]) {
      supports.push_back(k);
      answer(k, true);
    }
  const ModeColumns free_columns = mode_columns(lists.free, columns),
                    locked_columns = mode_columns(lists.locked, columns);

  const MatrixXd rates = quadratic_rates(factor, leaves, directions, variations, moved, columns);
  const auto stiffness = [&](int column, int direction) {
    const double c = columns[column].y[ee + direction];
    return VectorXd(rates.row(column).transpose() / (c * c));
  };
  gradients.drive_stiffness = stiffness(0, d);
  for (std::size_t s = 0; s < supports.size(); ++s)
    gradients.support_stiffness[supports[s]] = stiffness(static_cast<int>(s) + 1, supports[s]);

  set_frequencies(free_columns, rates, gradients.frequencies_free, gradients.clusters_free);
  set_frequencies(locked_columns, rates, gradients.frequencies_locked, gradients.clusters_locked);
  const bool of_locked = request.parasitic_with_drive_locked;
  const MatrixXd& rows = of_locked ? gradients.frequencies_locked : gradients.frequencies_free;
  const std::vector<Mode>& modes = of_locked ? point.modes_locked : point.modes_free;
  for (Eigen::Index k = 0; point.parasitic_frequency && k < rows.rows(); ++k)
    if (modes[static_cast<std::size_t>(k)].frequency == *point.parasitic_frequency &&
        !gradients.parasitic_frequency)
      gradients.parasitic_frequency = VectorXd(rows.row(k));
  return gradients;
}

}  // namespace flexopt
