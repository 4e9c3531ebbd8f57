#include "results/python/path_arrays.hpp"

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "core/response/quantities.hpp"
#include "optim/problem/goals.hpp"

namespace flexopt {
namespace {

namespace py = pybind11;

py::array read_only(py::array array) {
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

std::size_t product(const std::vector<py::ssize_t>& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
}

/// An optimisation without any design has no load cases, but an empty path.
const StrokeResponse& path_of(const RunRecord& record, std::size_t load_case) {
  const auto all = responses_of(record);
  return all.empty() ? response_of(record) : *all[load_case];
}

/// Numbers that every point with an equilibrium has.
struct PointNumbers {
  const char* name;
  std::vector<py::ssize_t> shape;
  double (*number)(const PathPoint& point, Eigen::Index k);
};
const PointNumbers point_numbers[] = {
    {"displacement", {3}, [](const PathPoint& p, Eigen::Index k) { return p.displacement[k]; }},
    {"rotation", {3}, [](const PathPoint& p, Eigen::Index k) { return p.rotation[k]; }},
    {"compliance_free",
     {6, 6},
     [](const PathPoint& p, Eigen::Index k) { return p.compliance_free(k / 6, k % 6); }},
    {"compliance_locked", {6, 6}, [](const PathPoint& p, Eigen::Index k) {
       return p.compliance_locked(k / 6, k % 6);
     }}};

/// One load case of a run. Its arrays are gathered once, are views of that memory, and keep the
/// Python object of this path alive.
class PathArrays {
 public:
  /// An array, and where it has no number (bool, of the same shape) or None.
  using Masked = std::pair<py::array, py::object>;

  PathArrays(const FinishedRun& run, std::size_t load_case)
      : record_(run.record),
        through_(run.through),
        load_case_(load_case),
        response_(path_of(*record_, load_case)) {
    if (load_case < record_->gradients.size()) gradients_ = &record_->gradients[load_case];
  }

  std::size_t size() const { return response_.path.size(); }
  py::array stroke() {
    return gathered("/stroke", {},
                    [&](std::size_t k, const auto& set) { set(0, response_.path[k].stroke); })
        .first;
  }
  /// n × their shape; missing where there is no equilibrium.
  Masked numbers(const PointNumbers& of) {
    return gathered(std::string("/") + of.name, of.shape, [&](std::size_t k, const auto& set) {
      if (response_.path[k].status != PointStatus::converged) return;
      for (std::size_t j = 0; j < product(of.shape); ++j) set(j, of.number(response_.path[k], j));
    });
  }
  /// Drives with names: n strokes [m or rad] of each by its name, in the order of the drives. Empty
  /// for a drive without a name, and on a load path.
  py::dict strokes() const {
    py::dict all;
    const DriveList drives(record_->mechanism);
    for (std::size_t d = 0; drives.named() && d < drives.items.size(); ++d) {
      py::array_t<double> numbers(static_cast<py::ssize_t>(size()));
      for (std::size_t k = 0; k < size(); ++k) {
        if (d >= response_.path[k].strokes.size()) return py::dict();  // a load path has no strokes
        numbers.mutable_at(k) = response_.path[k].strokes[d];
      }
      all[py::str(drives.items[d].name)] = read_only(std::move(numbers));
    }
    return all;
  }
  /// Frequencies [Hz]: n × as many as the point with most has.
  Masked frequencies(std::vector<double> PathPoint::*of, const char* key) {
    std::size_t most = 0;
    for (const PathPoint& point : response_.path) most = std::max(most, (point.*of).size());
    return gathered(key, {static_cast<py::ssize_t>(most)}, [&](std::size_t k, const auto& set) {
      const std::vector<double>& list = response_.path[k].*of;
      for (std::size_t j = 0; j < list.size(); ++j) set(j, list[j]);
    });
  }
  /// Whether each point has converged (bool).
  py::array converged() const {
    py::array_t<bool> flags(static_cast<py::ssize_t>(size()));
    for (std::size_t k = 0; k < size(); ++k)
      flags.mutable_at(k) = response_.path[k].status == PointStatus::converged;
    return read_only(std::move(flags));
  }
  std::vector<std::string> messages() const {
    std::vector<std::string> all;
    for (const PathPoint& point : response_.path) all.push_back(point.message);
    return all;
  }

  /// Quantities with a number at some point, and the SI units of all.
  std::vector<std::string> names() {
    std::vector<std::string> answered;
    for (const Quantity& q : all_quantities())
      if (std::ranges::any_of(response_.path,
                              [&](const PathPoint& point) { return q.value(point).has_value(); }))
        answered.push_back(q.name);
    return answered;
  }
  std::map<std::string, std::string> units() {
    std::map<std::string, std::string> all;
    for (const Quantity& q : all_quantities()) all[q.name] = q.unit;
    return all;
  }
  /// n numbers. Throws KeyError for a name that is no quantity, or one without any number here.
  Masked values(const std::string& name) {
    const Quantity& q = quantity(name);
    Masked found = gathered(name, {}, [&](std::size_t k, const auto& set) {
      if (const auto value = q.value(response_.path[k])) set(0, *value);
    });
    if (blocks_[name].count_missing() == size())
      throw py::key_error(fmt::format("no point of this path has {}", name));
    return found;
  }
  /// Gradient of a quantity: n × parameters.
  Masked gradient(const std::string& name) {
    const Quantity& q = quantity(name);
    static_cast<void>(values(name));  // a quantity of no point has no derivatives either
    const py::ssize_t columns = through_->by.cols();
    return gathered("/gradient/" + name, {columns}, [&](std::size_t k, const auto& set) {
      const PathPoint& point = response_.path[k];
      if (!q.value(point)) return;
      const auto along = q.gradient(point, gradients_->path[k]);
      if (!along) return;
      const VectorXd wanted = through_->by.transpose() * *along;
      for (Eigen::Index j = 0; j < wanted.size(); ++j) set(j, wanted[j]);
    });
  }
  bool has_gradients() const { return gradients_ != nullptr; }

  std::string status() const { return conclusion_of_case(*record_, load_case_).first; }
  std::string message() const { return conclusion_of_case(*record_, load_case_).second; }
  std::optional<double> stroke_reached() const { return flexopt::stroke_reached(response_); }

 private:
  struct Block {
    std::vector<double> numbers;
    std::vector<unsigned char> missing;
    std::size_t count_missing() const {
      return static_cast<std::size_t>(std::ranges::count(missing, 1));
    }
  };

  /// n × so many numbers, which fill(point, set(place, number)) tells at the first call.
  Masked gathered(const std::string& key, std::vector<py::ssize_t> shape, const auto& fill) {
    const std::size_t width = product(shape);
    const auto [found, is_new] = blocks_.try_emplace(key);
    Block& block = found->second;
    if (is_new) {
      // What is missing is so by the mask; the number under it must not pass for one.
      block.numbers.assign(size() * width, std::numeric_limits<double>::quiet_NaN());
      block.missing.assign(size() * width, 1);
      for (std::size_t k = 0; k < size(); ++k)
        fill(k, [&](std::size_t j, double number) {
          block.numbers[k * width + j] = number;
          block.missing[k * width + j] = 0;
        });
    }
    shape.insert(shape.begin(), static_cast<py::ssize_t>(size()));
    const auto shaped = [&](const auto* data) {
      return read_only(py::array(shape, data, py::cast(this)));
    };
    if (block.count_missing() == 0) return {shaped(block.numbers.data()), py::none()};
    return {shaped(block.numbers.data()),
            shaped(reinterpret_cast<const bool*>(block.missing.data()))};
  }
  const std::vector<Quantity>& all_quantities() {
    if (quantities_.empty()) quantities_ = quantities(drives_of(*record_));
    return quantities_;
  }
  const Quantity& quantity(const std::string& name) {
    const std::vector<Quantity>& all = all_quantities();
    const auto found = std::ranges::find(all, name, &Quantity::name);
    if (found == all.end()) throw py::key_error(fmt::format("no quantity is called {}", name));
    return *found;
  }

  std::shared_ptr<const RunRecord> record_;
  std::shared_ptr<const ThroughFormulas>
      through_;  ///< from the record's derivatives to those asked
  std::size_t load_case_;
  const StrokeResponse& response_;
  const StrokeGradients* gradients_ = nullptr;
  std::vector<Quantity> quantities_;  ///< once they are asked for
  std::map<std::string, Block> blocks_;
};

}  // namespace

void add_path(py::module_& module, py::class_<FinishedRun>& run) {
  py::class_<PathArrays, std::shared_ptr<PathArrays>> path(module, "Path");
  path.def("__len__", &PathArrays::size)
      .def_property_readonly("status", &PathArrays::status)
      .def_property_readonly("message", &PathArrays::message)
      .def_property_readonly("messages", &PathArrays::messages)
      .def_property_readonly("stroke_reached", &PathArrays::stroke_reached)
      .def_property_readonly("stroke", &PathArrays::stroke)
      .def_property_readonly("strokes", &PathArrays::strokes)
      .def_property_readonly("converged", &PathArrays::converged)
      .def_property_readonly("frequencies_free",
                             [](PathArrays& path) {
                               return path.frequencies(&PathPoint::frequencies_free,
                                                       "/frequencies_free");
                             })
      .def_property_readonly("frequencies_locked",
                             [](PathArrays& path) {
                               return path.frequencies(&PathPoint::frequencies_locked,
                                                       "/frequencies_locked");
                             })
      .def_property_readonly("names", &PathArrays::names)
      .def_property_readonly("units", &PathArrays::units)
      .def_property_readonly("has_gradients", &PathArrays::has_gradients)
      .def("values", &PathArrays::values)
      .def("gradient", &PathArrays::gradient);
  for (const PointNumbers& of : point_numbers)
    path.def_property_readonly(of.name, [&of](PathArrays& path) { return path.numbers(of); });
  run.def("path", [](const FinishedRun& of, std::size_t load_case) {
    return std::make_shared<PathArrays>(of, load_case);
  });
}

}  // namespace flexopt
