#pragma once
// The parts of result.json, and the files that show one of them alone.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/response/path/error_estimate.hpp"
#include "core/response/request.hpp"
#include "core/response/response.hpp"
#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

/// What `of` makes of each item, in a list.
template <class Items, class Of>
OrderedJson list_json(const Items& items, const Of& of) {
  OrderedJson list = OrderedJson::array();
  for (const auto& item : items) list.push_back(of(item));
  return list;
}

/// The value where it is known, else null.
template <class Value>
OrderedJson known_json(bool known, const Value& value) {
  return known ? OrderedJson(value) : OrderedJson();
}

// A stroke point in result.json.

/// One stroke point; numbers that a point without equilibrium does not have are null.
OrderedJson make_path_point(const PathPoint& point, const Mechanism& mechanism,
                            const StrokeRequest& request);

/// All points of a path, with their estimated errors unless `errors` is null.
OrderedJson path_json(const StrokeResponse& response, const Mechanism& mechanism,
                      const StrokeRequest& request, const StrokeErrors* errors = nullptr);

/// First part of a name with dots: the key of the result that the number stands in.
std::string key_of(const std::string& name);

/// [x, y, z]
OrderedJson vector_json(const Vector3d& v);
OrderedJson rows_json(const MatrixXd& matrix);

/// Strokes of several drives by their names.
OrderedJson strokes_json(const VectorXd& strokes, const std::vector<Drive>& drives);

// What stands beside the numbers of result.json: units, meanings, the material, what is checked.

/// Units of all keys, of the job's parameters too.
OrderedJson units_json(const Job& job, const Mechanism& mechanism, const StrokeRequest& request);

/// What the report's tables show: labels, units, and where the values stand in a path point.
OrderedJson quantities_json(const DriveList& drives, const StrokeRequest& request);

/// What the numbers refer to, so that nobody has to guess.
OrderedJson conventions_json(const RunRecord& record);

OrderedJson material_json(const Material& material);

/// Sizes of the undeflected leaves, their elements, and which model each of them needs.
OrderedJson leaf_geometry_json(const Mechanism& mechanism, const ModelOptions& model);

/// Which leaves have more elements than the model's mesh says; empty where none has.
std::string refined_leaves(const Mechanism& mechanism, const ModelOptions& model);

/// What the undeflected leaves and joints leave free, and what they hold more than once.
OrderedJson constraints_json(const Mechanism& mechanism);

/// What is checked of the stress, and what is not.
OrderedJson stress_checks_json(const RunRecord& record);

// How exact the numbers of a run are: `estimated_error` and `accuracy` of result.json.

/// Estimated errors of a point in the places of its numbers; null where a quantity has none.
OrderedJson point_errors_json(const std::vector<EstimatedError>& errors);

/// Estimated accuracy of the run, and the model that was chosen for it.
OrderedJson accuracy_json(const RunRecord& record);

// The worst and the critical errors of assembly in result.json.

/// Writes the study of assembly errors of a record that has one.
OrderedJson make_assembly(const RunRecord& record);

// Quantities over two parameters: the part "maps" of result.json, and maps.csv.

OrderedJson make_maps(const RunRecord& record);

/// Writes maps.csv, or removes that of an earlier run where the record has no maps.
void write_maps_csv(const std::filesystem::path& folder, const RunRecord& record);

// What tolerances do to a design: the part "tolerances" of result.json, and tolerances.csv.

OrderedJson make_tolerances(const RunRecord& record);

/// A row for each quantity at each stroke point, with a column for the share of each tolerance.
std::string tolerances_csv(const RunRecord& record);

// Linear models about points of the stroke: in result.json, and for MATLAB and Octave.

/// Inputs and outputs with their units; null where no point has a model.
OrderedJson signals_json(const StrokeResponse& response);
/// Squares of the frequencies, damping, and the matrices by rows: those of StateSpace.
OrderedJson state_space_json(const StateSpace& model);

/// A script that leaves the models in an array of structs: strokes, frequencies [Hz], A, B, C, D,
/// and as `sys` the objects of a control toolbox, where there is one.
std::string state_space_script(const StrokeResponse& response, const std::string& title);

/// state_space.m, or nothing in its place where no point has a model.
void write_state_space(const std::filesystem::path& folder, const StrokeResponse& response,
                       const std::string& title);

}  // namespace flexopt
