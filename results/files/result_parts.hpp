#pragma once
// The parts of result.json, and the files that show one of them alone.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/mechanism/mechanism.hpp"
#include "core/response/path/error_estimate.hpp"
#include "core/response/quantities.hpp"
#include "core/response/request.hpp"
#include "core/response/response.hpp"
#include "designs/family.hpp"
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

OrderedJson verdict_json(const Verdict& verdict);

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

/// Picks the point where a quantity spreads most, for each quantity of each load case in the order
/// of the table. Quantities that do not spread are left out.
std::vector<const ToleratedQuantity*> widest_spreads(const RunRecord& record);

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

// Tables for spreadsheets and scripts: comma separated, one header line with units, SI.

namespace csv {

/// RFC 4180: quoted where a comma, a quote or a line break would be misread.
std::string text_cell(const std::string& text);

/// Shortest text that reads back to the same double; empty where there is no finite number.
std::string number_cell(const std::optional<double>& value);

std::string row(const std::vector<std::string>& cells);

}  // namespace csv

/// One row for each stroke point; a cell without value is empty. `errors`: those of the response,
/// or null.
std::string path_csv(const StrokeResponse& response, const DriveList& drives,
                     const StrokeRequest& request, const StrokeErrors* errors = nullptr);

/// The path that a run is about, or those of all load cases.
std::string path_csv(const RunRecord& record);

/// One row for each evaluated design, in the order start, number; `best` is the objective of the
/// best feasible design up to and including this row, `difference` marks neighbours for
/// derivatives.
std::string history_csv(const Job& job, const Optimum& optimum, const DriveList& drives);

/// One row for each design of the front of two objectives.
std::string pareto_csv(const Job& job, const ParetoFront& front, const DriveList& drives);

/// One row for each design and model: parameters and symbols, ratios of the widest leaf, points
/// reached, and the worst error of each quantity.
std::string comparison_csv(const Job& job, const Comparison& comparison, const DriveList& drives);

// Deformed mid-surfaces of leaves and surfaces of elastic bodies for ParaView: one shape_NNN.vtu a
// stroke point and shapes.pvd over all.

/// A vector at every point of all shapes, such as the motion of a mode.
struct VtkField {
  std::string name;
  std::vector<Vector3d> values;
};

/// VTK XML unstructured grid of quadrilaterals on the undeflected leaves and triangles on elastic
/// bodies, with the point data displacement [m] and von_mises [Pa], further ones, and the cell data
/// leaf: its index; those of elastic bodies follow.
std::string shape_vtu(const PathPoint& point, const std::vector<VtkField>& fields = {});

/// A point of a path for ParaView: displacement, stress, and every mode that it has as a vector
/// field "mode 1, drive locked, 56.3 Hz", the largest of which is one.
std::string point_vtu(const Mechanism& mechanism, const PathPoint& point);

/// Writes both, and removes shape files of a longer earlier path. Nothing if no point has shapes.
void write_shapes(const std::filesystem::path& folder, const std::vector<PathPoint>& path);

// SI units of what results hold; they depend on the drive (metre or radian).

/// m | rad of the first drive, or 1 for a load path
std::string stroke_unit(const DriveList& drives, const StrokeRequest& request);
std::string quantity_unit(const std::string& quantity, const DriveList& drives);  ///< "" if unknown
/// Unit of a goal's quantity, or of its formula.
std::string goal_unit(const Constraint& goal, const DriveList& drives);
std::string parameter_unit(const Family& family, const std::string& parameter);

/// A value as a designer reads it: "30.8 mm", "3.13 N/um", "20 deg". `unit`: SI; "1" or empty:
/// none.
std::string quantity_text(double value, const std::string& unit, int digits = 5);

/// The beginning of a sentence about unstable points: which drives are held, and that it is
/// unstable.
std::string unstable_text(const Mechanism& mechanism, const LoadCase& loads);

/// "lowest parasitic frequency over the stroke": what a goal takes of a quantity or a formula, in
/// words.
std::string extreme_name(const Constraint& goal, const DriveList& drives);
/// {"quantity" or "expression", "over_stroke" but for a formula of the parameters, "unit"}
OrderedJson measure_json(const Constraint& goal, const DriveList& drives);

}  // namespace flexopt
