#include "core/response/gradients/point_gradients.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/math/eigenvalue_branches.hpp"
#include "core/math/rotation.hpp"
#include "core/response/actuators.hpp"
#include "core/response/gain.hpp"
#include "core/response/gradients/named_point_rates.hpp"
#include "core/response/room_taken.hpp"
#include "core/response/stress_safety.hpp"

namespace flexopt {
namespace {

using std::numbers::pi;

// Squares of frequencies nearer than this are one cluster: single derivatives mean nothing there.
constexpr double cluster_gap = 1e-6;

struct Column {
  double lambda = 0;  ///< q = yᵀ(K − λ M) y
  VectorXd y;
  VectorXd lag = {};  ///< K⁻¹ M y of the leaves, bodies held, where they have static shapes only
};

// Columns of one list of frequencies: the modes, in whole clusters, and the columns that belong to
// them.
struct ModeColumns {
  int wanted = 0;
  VectorXd lambda;
  struct Run {
    int first, size, column;
  };
  std::vector<Run> runs;
};

ModeColumns mode_columns(const MechanismFactor& factor, const FullModes& exact,
                         std::vector<Column>& columns) {
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
    const auto add = [&](VectorXd y) {
      VectorXd lag;
      if (exact.static_shapes) lag = factor.solve_held(factor.mass(y));
      if (lag.isZero(0)) lag.resize(0);  // leaves without mass
      columns.push_back({mean, std::move(y), std::move(lag)});
    };
    for (int a = k; a < end; ++a) add(exact.phi.col(a));
    for (int a = k; a < end; ++a)  // off the diagonal by the sums of two
      for (int b = a + 1; b < end; ++b) add(exact.phi.col(a) + exact.phi.col(b));
    k = end;
  }
  return modes;
}

// Derivatives of the quadratic form of every column along the parameters. A static shape x = −K⁻¹
// K_b q of a leaf changes by −K⁻¹ K′y: that adds 2λ wᵀK′y with the lag w, from the forms of y ± w.
// Equation (S14).
MatrixXd column_rates(const DesignRates<double>& design, const std::vector<Column>& columns,
                      const MatrixXd& state_rates) {
  const auto own = static_cast<Eigen::Index>(columns.size());
  const auto enlarged = [](const Column& c) {  // w is small beside y
    return c.y.norm() / c.lag.norm();
  };
  std::vector<VectorXd> all;
  std::vector<double> lambdas;
  for (const Column& c : columns) {
    all.push_back(c.y);
    lambdas.push_back(c.lambda);
  }
  for (const Column& c : columns)
    if (c.lag.size() > 0)
      for (const double side : {1.0, -1.0}) {
        all.push_back(c.y + side * enlarged(c) * c.lag);
        lambdas.push_back(0);
      }
  MatrixXd Y(columns.front().y.size(), all.size());
  for (Eigen::Index k = 0; k < Y.cols(); ++k) Y.col(k) = all[k];
  const VectorXd lambda = VectorXd::Map(lambdas.data(), Y.cols());
  const MatrixXd rates = design.quadratic(Y, lambda, state_rates);
  MatrixXd of_columns = rates.topRows(own);
  Eigen::Index sides = own;
  for (Eigen::Index k = 0; k < own; ++k)
    if (columns[k].lag.size() > 0) {
      const double by = 0.5 * lambda[k] / enlarged(columns[k]);
      of_columns.row(k) += by * (rates.row(sides) - rates.row(sides + 1));
      sides += 2;
    }
  return of_columns;
}

// yᵀA z from the rates of y, z and y + z.
double mixed_form(const MatrixXd& rates, Eigen::Index sum, Eigen::Index y, Eigen::Index z,
                  Eigen::Index parameter) {
  return 0.5 * (rates(sum, parameter) - rates(y, parameter) - rates(z, parameter));
}

// Sets the derivatives of frequencies and clusters from those of the columns.
void set_frequencies(const ModeColumns& modes, const MatrixXd& rates, MatrixXd& gradients,
                     std::vector<FrequencyCluster>& clusters) {
  const int count = static_cast<int>(rates.cols());
  gradients = MatrixXd::Zero(modes.wanted, count);
  for (const ModeColumns::Run& run : modes.runs) {
    MatrixXd lambda_rates = rates.middleRows(run.column, run.size);
    if (run.size > 1) {
      FrequencyCluster cluster{run.first, run.size, {}};
      for (int p = 0; p < count; ++p) {
        MatrixXd block(run.size, run.size);
        int column = run.column + run.size;
        for (int a = 0; a < run.size; ++a) block(a, a) = rates(run.column + a, p);
        for (int a = 0; a < run.size; ++a)
          for (int b = a + 1; b < run.size; ++b, ++column)
            block(a, b) = block(b, a) =
                mixed_form(rates, column, run.column + a, run.column + b, p);
        cluster.block.push_back(std::move(block));
      }
      if (count > 0) lambda_rates = branch_rates(cluster.block);
      clusters.push_back(std::move(cluster));
    }
    for (int a = 0; a < run.size && run.first + a < modes.wanted; ++a) {
      const double omega = std::sqrt(std::abs(modes.lambda[run.first + a]));
      if (omega > 0) gradients.row(run.first + a) = lambda_rates.row(a) / (4 * pi * omega);
    }
  }
}

// Motions whose quadratic forms give the stiffnesses, as columns: the motions of unit strokes,
// drive by drive; the motions y = K⁻¹ e of the end-effector under unit loads of every support with
// the drives held; and the sums of two translations.
struct StiffnessColumns {
  int first = 0, drives = 0;
  std::vector<int> supports;
  struct Pair {
    int a, b, column;  ///< directions of support
  };
  std::vector<Pair> pairs;

  int column(std::size_t support) const { return first + drives + static_cast<int>(support); }
};

StiffnessColumns stiffness_columns(const MechanismFactor& factor, const PathPoint& point,
                                   std::vector<Column>& columns) {
  const int ee = 6 * factor.system().mechanism().end_effector;
  StiffnessColumns result;
  result.first = static_cast<int>(columns.size());
  result.drives = factor.drives();
  for (int k = 0; k < 6; ++k)
    if (point.support_stiffness[k]) result.supports.push_back(k);
  MatrixXd loads = MatrixXd::Zero(factor.size(), result.supports.size());
  for (Eigen::Index k = 0; k < loads.cols(); ++k) loads(ee + result.supports[k], k) = 1;
  const MatrixXd answers = factor.solve_locked(loads), shapes = factor.drive_shapes();
  for (Eigen::Index k = 0; k < shapes.cols(); ++k) columns.push_back({0, shapes.col(k)});
  for (Eigen::Index k = 0; k < answers.cols(); ++k) columns.push_back({0, answers.col(k)});
  for (std::size_t i = 0; i < result.supports.size(); ++i)
    for (std::size_t j = i + 1; j < result.supports.size() && result.supports[j] < 3; ++j) {
      result.pairs.push_back(
          {static_cast<int>(i), static_cast<int>(j), static_cast<int>(columns.size())});
      columns.push_back({0, answers.col(i) + answers.col(j)});
    }
  return result;
}

// A compliance eᵀK⁻¹e changes by −yᵀK′y, the stiffness yᵀK y of a drive by yᵀK′y.
void set_stiffness(const StiffnessColumns& of, const std::vector<Column>& columns,
                   const MatrixXd& rates, int ee, PointGradients& gradients) {
  const auto stiffness = [&](int column, int direction) {
    const double c = columns[column].y[ee + direction];
    return VectorXd(rates.row(column).transpose() / (c * c));
  };
  gradients.drive_stiffnesses = rates.middleRows(of.first, of.drives);
  if (of.drives > 0) gradients.drive_stiffness = gradients.drive_stiffnesses.row(0).transpose();
  for (std::size_t s = 0; s < of.supports.size(); ++s)
    gradients.support_stiffness[of.supports[s]] = stiffness(of.column(s), of.supports[s]);
  gradients.translation_compliance.assign(static_cast<std::size_t>(rates.cols()), Matrix3d::Zero());
  for (Eigen::Index p = 0; p < rates.cols(); ++p) {
    Matrix3d& C = gradients.translation_compliance[p];
    for (std::size_t s = 0; s < of.supports.size() && of.supports[s] < 3; ++s)
      C(of.supports[s], of.supports[s]) = -rates(of.column(s), p);
    for (const StiffnessColumns::Pair& pair : of.pairs) {
      const auto a = static_cast<std::size_t>(pair.a), b = static_cast<std::size_t>(pair.b);
      C(of.supports[a], of.supports[b]) = C(of.supports[b], of.supports[a]) =
          -mixed_form(rates, pair.column, of.column(a), of.column(b), p);
    }
  }
}

// Two columns whose forms differ by 4 yᵀK′c/by: the motion c of a unit stroke, and to either side
// of it the answer y of the mechanism, its drives held, to a unit load of the end-effector.
struct GainColumns {
  int row;  ///< of PointGradients::gain
  int column;
  double by;  ///< 1 over the enlargement of y to the size of c, against rounding
};

// (S34): (y, its multipliers) solve the equations of c transposed, so that c′ = −yᵀK′c.
std::vector<GainColumns> gain_columns(const MechanismFactor& factor, std::vector<Column>& columns) {
  MatrixXd loads = MatrixXd::Zero(factor.size(), 6);
  loads.middleRows<6>(6 * factor.system().mechanism().end_effector).setIdentity();
  const MatrixXd answers = factor.solve_locked(loads), shapes = factor.drive_shapes();
  std::vector<GainColumns> all;
  for (int k = 0; k < factor.drives(); ++k)
    for (int d = 0; d < 6; ++d) {
      const VectorXd c = shapes.col(k), y = answers.col(d);
      const double by = y.norm() / c.norm();
      if (by == 0) continue;  // held, or driven
      all.push_back({6 * k + d, static_cast<int>(columns.size()), by});
      columns.push_back({0, c + y / by});
      columns.push_back({0, c - y / by});
    }
  return all;
}

void set_drive_motions(const MechanismFactor& factor, const std::vector<GainColumns>& all,
                       const MatrixXd& rates, PointGradients& gradients) {
  const Mechanism& mechanism = factor.system().mechanism();
  MatrixXd of_motions = MatrixXd::Zero(6 * factor.drives(), rates.cols());
  for (const GainColumns& of : all)
    of_motions.row(of.row) = of.by / 4 * (rates.row(of.column + 1) - rates.row(of.column));
  set_gain_gradients(mechanism, factor.drive_shapes().middleRows<6>(6 * mechanism.end_effector),
                     of_motions, gradients);
}

void set_motion(const MechanismFactor& factor, const PathPoint& point,
                const std::vector<Mechanism>& directions, const MatrixXd& moved,
                MovingFields& fields, PointGradients& gradients) {
  const System& system = factor.system();
  const Mechanism& mechanism = system.mechanism();
  const int ee = 6 * mechanism.end_effector;
  gradients.drive_loads = moved.bottomRows(factor.drives());
  gradients.drive_load = factor.drives() > 0 ? VectorXd(gradients.drive_loads.row(0).transpose())
                                             : VectorXd::Zero(moved.cols());
  gradients.displacement = moved.middleRows(ee, 3);
  for (int i = 0; i < system.leaves(); ++i)
    if (const auto& follows = mechanism.leaves[i].point;
        follows && follows->body == mechanism.end_effector && follows->spread_over_tip)
      gradients.displacement =
          tip_displacement_rates(mechanism, i, point, directions, fields.of(i));
  gradients.rotation =
      rotation_log_tangent(system.pose(mechanism.end_effector).turn) * moved.middleRows(ee + 3, 3);
}

void set_stress(const Mechanism& mechanism, const PathPoint& point, const StressRules& rules,
                const std::vector<std::vector<StressPlace>>& stress_places,
                const std::vector<Mechanism>& directions, MovingFields& fields,
                PointGradients& gradients) {
  const auto stress_rate = [&](const StressPeak& peak) {
    return stress_rates(fields, peak, mechanism);
  };
  const int leaves = static_cast<int>(mechanism.leaves.size());
  for (int i = 0; i < static_cast<int>(point.sections.size()); ++i) {
    std::vector<int> nodes;
    for (const StressPlace& place : stress_places[i]) nodes.push_back(place.node);
    gradients.section_rates.push_back(
        i >= leaves ? fields.elastic(i - leaves, nodes).rate
                    : fields.of(i).section_rates(stress_places[i],
                                                 mechanism.leaves[i].material.youngs_modulus,
                                                 modulus_rates(directions, i)));
  }
  const auto notched_rate = [&](const StressPeak& peak) {
    return stress_rates(fields, peak, mechanism, rules.fillet);
  };
  if (point.max_stress) gradients.max_stress = stress_rate(*point.max_stress);
  if (point.notch_stress) gradients.notch_stress = notched_rate(*point.notch_stress);
  if (const auto& safety = point.yield_safety)
    gradients.yield_safety =
        safety_rates(safety->value, safety->stress.value, notched_rate(safety->stress));
  if (const auto& safety = point.fatigue_safety)
    gradients.fatigue_safety =
        safety_rates(safety->value, safety->stress.value, notched_rate(safety->stress));
  if (const auto& life = point.fatigue_life)
    gradients.fatigue_life = ratio_life_rates(*life, *part_of(life->stress, mechanism).material,
                                              rules.fatigue_rule, notched_rate(life->stress));
  gradients.stress_peaks.resize(point.stress_peaks.size(), directions.size());
  for (Eigen::Index k = 0; k < gradients.stress_peaks.rows(); ++k)
    gradients.stress_peaks.row(k) =
        k == 0 ? gradients.max_stress->transpose() : stress_rate(point.stress_peaks[k]).transpose();
}

void set_parasitic_frequency(const PathPoint& point, DriveState drive, PointGradients& gradients) {
  if (!point.parasitic_frequency) return;
  const bool locked = drive == DriveState::locked;
  const MatrixXd& rows = locked ? gradients.frequencies_locked : gradients.frequencies_free;
  const std::vector<double>& list = locked ? point.frequencies_locked : point.frequencies_free;
  const auto k = std::ranges::find(list, *point.parasitic_frequency) - list.begin();
  if (k < rows.rows()) gradients.parasitic_frequency = VectorXd(rows.row(k));
}

// Sets the derivatives of the dynamic measures as sums over their terms.
void set_dynamics(const MechanismFactor& factor, const DynamicsMeasures& dynamics,
                  const DesignRates<double>& design, const MatrixXd& state_rates,
                  PointGradients& gradients) {
  std::optional<MatrixXd> carried;  // by the ground, made at its first use
  const auto gradient = [&](const std::optional<MeasureRate>& rate) -> std::optional<VectorXd> {
    if (!rate) return std::nullopt;
    const auto n = static_cast<Eigen::Index>(rate->terms.size());
    MatrixXd Y(state_rates.rows(), n), translations(3, n);
    VectorXd lambda(n), weight(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const QuadraticTerm& term = rate->terms[k];
      Y.col(k) = term.y;
      translations.col(k) = term.ground;
      lambda[k] = term.lambda;
      weight[k] = term.weight;
    }
    std::optional<GroundShare> ground;
    if (!translations.isZero(0)) {
      if (!carried) carried = rigid_motion(factor).motion.leftCols<3>();
      ground = {translations, *carried * translations};
    }
    VectorXd sum =
        design.quadratic(Y, lambda, state_rates, ground ? &*ground : nullptr).transpose() * weight;
    for (const ForceTerm& term : rate->forces) {
      const auto of = force_rates(term.point, term.y, factor, design, state_rates);
      if (!of) return std::nullopt;
      sum += *of;
    }
    return sum;
  };
  for (const std::optional<DynamicsMeasure>& measure : dynamics.bandwidths) {
    gradients.bandwidths.emplace_back();
    if (measure) gradients.bandwidths.back() = gradient(measure->rate);
  }
  if (const auto& measure = dynamics.transmissibility)
    gradients.transmissibility = gradient(measure->rate);
  for (const TransferMeasure& transfer : dynamics.transfers) {
    gradients.transfers.push_back(gradient(transfer.at_rest));
    gradients.transfer_bandwidths.push_back(gradient(transfer.of_bandwidth));
  }
}

void set_room_taken(const Solids& solids, const PathPoint& point, const PlaceRates& rates,
                    PointGradients& gradients) {
  if (point.extents) gradients.extents = extent_rates(solids, *point.extents, rates);
  if (point.clearance) gradients.clearance = clearance_rate(solids, *point.clearance, rates);
}

}  // namespace

PointGradients point_gradients(const MechanismFactor& factor, const DesignRates<double>& design,
                               const StrokeRequest& request, const PathPoint& point,
                               const FullModeLists& lists, const Solids* solids,
                               const DynamicsMeasures* dynamics,
                               const std::vector<std::vector<StressPlace>>& stress_places,
                               const MatrixXd& strokes) {
  const Mechanism& mechanism = factor.system().mechanism();
  const std::vector<Mechanism>& directions = design.directions();
  // (S7)
  const MatrixXd forces = -design.residual(),
                 moved = strokes.size() > 0 ? factor.balance(forces, strokes)
                                            : factor.balance(forces, request.loads.driven()),
                 state_rates = moved.topRows(factor.size());
  MovingFields fields(factor, design, state_rates);
  PointGradients gradients;
  set_motion(factor, point, directions, moved, fields, gradients);
  set_stress(mechanism, point, request.stress, stress_places, directions, fields, gradients);
  if (solids)
    set_room_taken(*solids, point, moving_places(factor, *solids, directions, state_rates, fields),
                   gradients);

  if (dynamics) set_dynamics(factor, *dynamics, design, state_rates, gradients);
  set_named_points(request, factor, point, state_rates, fields, gradients);
  if (request.wants_gauges()) set_gauges(request, mechanism, point, fields, gradients);

  std::vector<Column> columns;
  std::optional<StiffnessColumns> stiffness;
  if (request.outputs.has(Output::stiffness)) stiffness = stiffness_columns(factor, point, columns);
  std::vector<GainColumns> gains;
  if (request.outputs.has(Output::gain)) gains = gain_columns(factor, columns);
  const ModeColumns free_columns = mode_columns(factor, lists.free, columns),
                    locked_columns = mode_columns(factor, lists.locked, columns);
  if (!columns.empty()) {
    const MatrixXd rates = column_rates(design, columns, state_rates);
    if (stiffness) set_stiffness(*stiffness, columns, rates, 6 * mechanism.end_effector, gradients);
    if (request.outputs.has(Output::gain)) set_drive_motions(factor, gains, rates, gradients);
    set_frequencies(free_columns, rates, gradients.frequencies_free, gradients.clusters_free);
    set_frequencies(locked_columns, rates, gradients.frequencies_locked, gradients.clusters_locked);
    set_parasitic_frequency(point, request.parasitic.drive, gradients);
  }
  if (has_actuators(mechanism))
    set_actuator_gradients(mechanism, directions,
                           factor.drive_shapes().middleRows<6>(6 * mechanism.end_effector), point,
                           gradients);
  return gradients;
}

}  // namespace flexopt
