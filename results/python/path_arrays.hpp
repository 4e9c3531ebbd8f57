#pragma once
// The numbers of a path as numpy sees them: one row for each stroke point, read-only, in the memory
// of the path itself where they lie there at equal distances, else gathered once.
#include <pybind11/numpy.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/response/quantities.hpp"
#include "optim/problem/stroke_sensitivity.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

/// One load case of a run. Arrays are views that keep `owner`, the Python object of this path,
/// alive.
class PathArrays {
 public:
  /// `through`: how the derivatives that the record has go on to those that were asked for.
  PathArrays(std::shared_ptr<const RunRecord> record,
             std::shared_ptr<const ThroughFormulas> through, std::size_t load_case);

  /// An array, and where it has no number (bool, of the same shape) or None.
  using Masked = std::pair<pybind11::array, pybind11::object>;

  std::size_t size() const { return response_.path.size(); }
  /// Strokes [m or rad].
  pybind11::array stroke(pybind11::handle owner) const;
  /// n × 3 [m], n × 3 rotation vectors [rad], n × 6 × 6; missing where there is no equilibrium.
  Masked displacement(pybind11::handle owner);
  Masked rotation(pybind11::handle owner);
  Masked compliance(pybind11::handle owner, bool locked);
  /// Drives with names: n strokes [m or rad] of each by its name, in the order of the drives. Empty
  /// for a drive without a name, and on a load path.
  pybind11::dict strokes() const;
  /// Frequencies [Hz]: n × as many as the point with most has.
  Masked frequencies(pybind11::handle owner, bool locked);
  /// Whether each point has converged (bool).
  pybind11::array converged() const;
  std::vector<std::string> messages() const;

  /// Quantities with a number at some point, and the SI units of all.
  std::vector<std::string> names() const;
  std::map<std::string, std::string> units() const;
  /// n numbers. Throws KeyError for a name that is no quantity, or one without any number here.
  Masked values(pybind11::handle owner, const std::string& name);
  /// Gradient of a quantity: n × parameters.
  Masked gradient(pybind11::handle owner, const std::string& name);
  bool has_gradients() const { return gradients_ != nullptr; }

  std::string status() const;
  std::string message() const;
  std::optional<double> stroke_reached() const;

 private:
  struct Block {
    std::vector<double> numbers;
    std::vector<unsigned char> missing;
    std::size_t width = 1;
    std::size_t count_missing() const;
  };
  /// The numbers with the mask of the points that have no equilibrium.
  Masked where_converged(pybind11::array numbers, pybind11::handle owner);
  Block& block(const std::string& key, std::size_t width, const auto& fill);
  Masked arrays(pybind11::handle owner, const Block& block, bool as_rows) const;
  const std::vector<Quantity>& all_quantities() const;
  const Quantity& quantity(const std::string& name) const;

  std::shared_ptr<const RunRecord> record_;
  std::shared_ptr<const ThroughFormulas> through_;
  std::size_t load_case_;
  const StrokeResponse& response_;
  const StrokeGradients* gradients_ = nullptr;
  mutable std::vector<Quantity> quantities_;  ///< once they are asked for
  std::map<std::string, Block> blocks_;
  std::vector<unsigned char> not_converged_;  ///< once it is asked for
};

}  // namespace flexopt
