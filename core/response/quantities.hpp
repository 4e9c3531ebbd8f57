#pragma once
// The one table of numbers that a point of the path answers. Objectives and constraints, the keys
// and units of result.json, the columns of path.csv, the summary, the report, check-gradients and
// the schema of a job are made from it: a new number is one row here beside the mechanics behind
// it.
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/response/estimated_error.hpp"
#include "core/response/response.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

std::string load_unit(Direction direction);       ///< N | N m
std::string stiffness_unit(Direction direction);  ///< N/m | N m/rad

struct QuantityRow;

/// The numbers of a request that have names by it: of points with directions, transfers, gauges and
/// bridges.
std::vector<NamedNumber> named_numbers(const StrokeRequest& request);

/// What the table must know of the drives of a mechanism, and what a request names.
struct DriveList {
  struct Item {
    std::string name;
    Direction direction = Direction::uy;
    bool remote = false;  ///< it is none of the end-effector along a global axis
    bool voice_coil = false, piezo = false;
  };
  std::vector<Item> items;
  std::array<bool, 6> prescribed{};  ///< directions of the end-effector
  /// Names and SI units of the quantities that a job defines by formulas.
  std::vector<std::pair<std::string, std::string>> named_quantities;
  std::vector<NamedNumber> numbers;  ///< that a request names

  DriveList() = default;
  /// List of the only drive, of the end-effector along a global axis.
  DriveList(Direction drive);
  DriveList(const Mechanism& mechanism);

  /// Whether strokes, loads and stiffnesses stand under the names of the drives.
  bool named() const { return items.size() > 1 || (!items.empty() && !items[0].name.empty()); }
  Direction first() const { return items.empty() ? Direction::uy : items.front().direction; }
  /// Whether these drives leave the number of a row with a meaning.
  bool offers(const QuantityRow& row, int component) const;
};

/// How the numbers of a row stand in result.json.
enum class Layout {
  number,  ///< null where there is none
  list,    ///< as many as there are
  object   ///< under their components' names, those that there are
};

/// What the summary of a run shows of a row.
enum class SummaryLine {
  none,
  number,
  weakest  ///< the least translation and the least rotation of six directions
};

/// One number, or a few of one kind.
struct QuantityRow {
  std::string name;  ///< key in result.json; a dot leads into an object
  /// The numbers are called "name.component"; empty: there is one number, called as the row.
  std::vector<std::string> components;
  Layout layout = Layout::number;
  std::string label;    ///< as a designer says it
  std::string meaning;  ///< its definition, for result.json; empty where the label says it
  Outputs needs;        ///< of an evaluation
  /// SI unit of a component.
  std::string (*unit)(Direction drive, int component) = nullptr;
  /// Value at a converged point; nothing where the point has no such number.
  std::optional<double> (*value)(const PathPoint&, int component) = nullptr;
  /// Derivative of the value along the parameters; nothing where there is none.
  std::optional<VectorXd> (*gradient)(const PathPoint&, const PointGradients&,
                                      int component) = nullptr;
  /// Where the search for the number met none: how large it is at least.
  std::optional<double> (*at_least)(const PathPoint&, int component) = nullptr;
  /// Unit vector that belongs to the number, if one does; result.json then has
  /// {"value", "direction"}.
  std::optional<Vector3d> (*direction)(const PathPoint&) = nullptr;
  ErrorKind error = ErrorKind::none;  ///< how its errors are estimated, if they are
  bool of_supports = false;           ///< the components are directions; a drive's is not offered
  /// One number for each drive, or all components: those of drives with names are called
  /// "name.drive" or "name.drive.component".
  bool of_drives = false;
  bool DriveList::Item::*of_kind = nullptr;  ///< only of drives of which this holds
  bool of_names = false;   ///< one number for each NamedNumber of the row, "name.NAME"
  bool of_design = false;  ///< one number of the design: the same at every point
  bool in_csv = true;      ///< as columns of their own; the frequencies have their kinds beside
  SummaryLine in_summary = SummaryLine::none;
  bool in_report = false;  ///< a row of the report's tables
};

const std::vector<QuantityRow>& quantity_rows();
/// The rows of load_capacity and stroke_capacity.
std::vector<QuantityRow> capacity_rows();
/// The row of the quantities that a job defines: its components are those of the point.
const QuantityRow& row_of_named_quantities();
/// The rows of numbers that a request names; their units are those of the NamedNumber.
std::vector<QuantityRow> named_rows();

/// Whether an evaluation by this request has the numbers of the row: a load that grows is named, a
/// fillet is given, the materials have what a safety needs.
bool is_answered(const QuantityRow& row, const StrokeRequest& request);

/// A number of the table that objectives, constraints and columns can name.
struct Quantity {
  std::string name;   ///< "drive_load", "support_stiffness.ux", "displacement.x", …
  std::string unit;   ///< SI, with this drive
  std::string label;  ///< with its component
  const QuantityRow* row = nullptr;
  int component = 0;

  /// Value and derivatives at a point; nothing if the point has no such number: not converged (the
  /// screening frequency needs no convergence), not asked for, or not defined.
  std::optional<double> value(const PathPoint& point) const;
  std::optional<VectorXd> gradient(const PathPoint& point, const PointGradients& gradients) const;
};

/// Whether an evaluation by this request has the quantity.
bool is_answered(const Quantity& quantity, const StrokeRequest& request);

/// Every quantity of the table for these drives, in its order.
std::vector<Quantity> quantities(const DriveList& drives);

/// Why a point has no such number, or no more than a lower bound of it; empty where it does not
/// say.
std::string why_missing(const PathPoint& point, const QuantityRow& row, int component);
std::string why_missing(const PathPoint& point, std::string_view name);

/// Value and derivatives by name ("drive_load.x" for a drive with a name, "gauge.g1": the point
/// knows these names, and the quantities of its job). Throw std::invalid_argument for a name that
/// the table does not have.
std::optional<double> value_of(const PathPoint& point, std::string_view name);
std::optional<VectorXd> gradient_of(const PathPoint& point, const PointGradients& gradients,
                                    std::string_view name);
/// How large a number without a value is at least, where that is known.
std::optional<double> at_least(const PathPoint& point, std::string_view name);
/// Whether it is the same at every point of a path.
bool is_of_design(std::string_view name);
/// What an evaluation must answer for it.
const Outputs& needs_of(std::string_view name);

}  // namespace flexopt
