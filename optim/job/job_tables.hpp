#pragma once
// The sections of a job that go to plain structs, each declared once: key, shape, meaning, member.
#include <map>
#include <string>
#include <vector>

#include "core/spec/record_table.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// Larger forces, masses and stiffnesses are taken for typing errors [SI].
inline constexpr double largest_number = 1e12;

/// Three numbers of this unit, each at most `largest`.
Shape vector3(const std::string& unit, double largest);

/// The stroke as a job writes it.
struct StrokeSpec {
  std::optional<double> from, to;  ///< [m or rad]
  std::optional<int> points;
  std::vector<double> at;  ///< [m or rad]
  bool in_order = false;
};
/// What `in_order` of a stroke means.
inline constexpr const char* in_order_meaning =
    "whether the way leads from point to point as they are listed; else, the default, it leads "
    "from rest straight to each";

/// A load on a body, or the growing one of a load path, which has `points` and acts at O.
struct LoadSpec {
  std::string name, body;      ///< name and body of a dead load; empty: none, the end-effector
  std::optional<Vector3d> at;  ///< place of a dead load, undeflected, global [m]
  Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();  ///< [N], [N m]
  bool follows = false;                                          ///< they turn with the body
  int points = 11;
};

/// An error of assembly.
struct AssemblySpec {
  std::string leaf;
  int end = 0;                                                ///< 0 base, 1 tip
  Vector3d move = Vector3d::Zero(), turn = Vector3d::Zero();  ///< [m], [rad]
  /// Formulas of parameters in their places, whose numbers are zero here: axis of the move, then of
  /// the turn.
  std::map<int, std::string> formulas = {};
};

struct NamedPointSpec {
  std::string name, body;             ///< body: empty where none is named
  std::optional<Vector3d> at;         ///< [m]
  std::optional<Vector6d> direction;  ///< unit vector, or zero
};

/// Name, kind and frequencies of a job.
const RecordTable<Job>& head_table();
const RecordTable<EndEffector>& end_effector_table();
/// Schema of one stroke of a drive in this direction.
Shape stroke_place(Direction direction);
/// Table of the stroke of one drive without a name. Without a direction, the unit of the stroke is
/// not known.
RecordTable<StrokeSpec> stroke_table(std::optional<Direction> drive);
const RecordTable<LoadSpec>& load_table();
const RecordTable<LoadSpec>& load_path_table();
const RecordTable<AssemblySpec>& assembly_table();
Shape temperature_shape();
const RecordTable<NamedPointSpec>& named_point_table();
const RecordTable<Expectation>& expectation_table();
const RecordTable<ModelChoice>& model_table();
const RecordTable<WorkLimits>& limits_table();

/// The keys of "optimise" that are plain numbers and names.
const RecordTable<OptimiseSpec>& search_table();
const RecordTable<Objective>& objective_table();
const RecordTable<Constraint>& constraint_table();
const RecordTable<Algorithm>& algorithm_table();
const RecordTable<VerifySpec>& verify_table();
const RecordTable<ParetoSpec>& pareto_table();

/// Points of a map.
const RecordTable<MapSpec>& map_table();

/// Method, count and seed of "samples".
const RecordTable<SamplesSpec>& samples_table();
/// Spread and points of an entry of "vary".
const RecordTable<SampleRange>& range_table();

// The names that a job gives them.
std::string name_of(Reduction method);
std::string name_of(SampleMethod method);

}  // namespace flexopt
