#include "results/python/path_arrays.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "optim/problem/goals.hpp"

namespace flexopt {
namespace {

namespace py = pybind11;

constexpr py::ssize_t from_point_to_point = sizeof(PathPoint);

py::array read_only(py::array array) {
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

template <class Number>
py::array view(std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides, const Number* data,
               py::handle owner) {
  return read_only(
      py::array(py::dtype::of<Number>(), std::move(shape), std::move(strides), data, owner));
}

/// An optimisation without any design has no load cases, but an empty path.
const StrokeResponse& path_of(const RunRecord& record, std::size_t load_case) {
  const auto all = responses_of(record);
  return all.empty() ? response_of(record) : *all[load_case];
}

}  // namespace

std::size_t PathArrays::Block::count_missing() const {
  return static_cast<std::size_t>(std::ranges::count(missing, 1));
}

PathArrays::PathArrays(std::shared_ptr<const RunRecord> record,
                       std::shared_ptr<const ThroughFormulas> through, std::size_t load_case)
    : record_(std::move(record)),
      through_(std::move(through)),
      load_case_(load_case),
      response_(path_of(*record_, load_case)) {
  if (load_case < record_->gradients.size()) gradients_ = &record_->gradients[load_case];
}

const std::vector<Quantity>& PathArrays::all_quantities() const {
  if (quantities_.empty()) quantities_ = quantities(DriveList(record_->mechanism));
  return quantities_;
}

py::array PathArrays::stroke(py::handle owner) const {
  return view({static_cast<py::ssize_t>(size())}, {from_point_to_point},
              size() ? &response_.path[0].stroke : nullptr, owner);
}

PathArrays::Masked PathArrays::where_converged(py::array numbers, py::handle owner) {
  if (not_converged_.empty())
    for (const PathPoint& point : response_.path)
      not_converged_.push_back(point.status != PointStatus::converged);
  if (std::ranges::count(not_converged_, 1) == 0) return {std::move(numbers), py::none()};
  const std::vector<py::ssize_t> shape(numbers.shape(), numbers.shape() + numbers.ndim());
  std::vector<py::ssize_t> strides(shape.size(), 0);
  strides[0] = 1;
  return {std::move(numbers),
          view(shape, strides, reinterpret_cast<const bool*>(not_converged_.data()), owner)};
}

PathArrays::Masked PathArrays::displacement(py::handle owner) {
  return where_converged(
      view({static_cast<py::ssize_t>(size()), 3}, {from_point_to_point, sizeof(double)},
           size() ? response_.path[0].displacement.data() : nullptr, owner),
      owner);
}

PathArrays::Masked PathArrays::rotation(py::handle owner) {
  return where_converged(
      view({static_cast<py::ssize_t>(size()), 3}, {from_point_to_point, sizeof(double)},
           size() ? response_.path[0].rotation.data() : nullptr, owner),
      owner);
}

PathArrays::Masked PathArrays::compliance(py::handle owner, bool locked) {
  const auto of = locked ? &PathPoint::compliance_locked : &PathPoint::compliance_free;
  return where_converged(view({static_cast<py::ssize_t>(size()), 6, 6},
                              {from_point_to_point, sizeof(double), 6 * sizeof(double)},
                              size() ? (response_.path[0].*of).data() : nullptr, owner),
                         owner);
}

py::dict PathArrays::strokes() const {
  py::dict all;
  const DriveList drives(record_->mechanism);
  for (std::size_t d = 0; drives.named() && d < drives.items.size(); ++d) {
    py::array_t<double> numbers(static_cast<py::ssize_t>(size()));
    for (std::size_t k = 0; k < size(); ++k) {
      if (d >= response_.path[k].strokes.size()) return py::dict();  // a load path has no strokes
      numbers.mutable_at(static_cast<py::ssize_t>(k)) = response_.path[k].strokes[d];
    }
    all[py::str(drives.items[d].name)] = read_only(std::move(numbers));
  }
  return all;
}

PathArrays::Block& PathArrays::block(const std::string& key, std::size_t width, const auto& fill) {
  const auto [found, is_new] = blocks_.try_emplace(key);
  Block& block = found->second;
  if (!is_new) return block;
  // What is missing is so by the mask; the number under it must not pass for one.
  block.numbers.assign(size() * width, std::numeric_limits<double>::quiet_NaN());
  block.missing.assign(size() * width, 1);
  block.width = width;
  for (std::size_t k = 0; k < size(); ++k)
    fill(k, [&](std::size_t j, double number) {
      block.numbers[k * width + j] = number;
      block.missing[k * width + j] = 0;
    });
  return block;
}

PathArrays::Masked PathArrays::arrays(py::handle owner, const Block& block, bool as_rows) const {
  const auto n = static_cast<py::ssize_t>(size()), width = static_cast<py::ssize_t>(block.width);
  const auto shaped = [&](const auto* data) {
    const auto bytes = static_cast<py::ssize_t>(sizeof *data);
    return as_rows ? view({n, width}, {width * bytes, bytes}, data, owner)
                   : view({n}, {bytes}, data, owner);
  };
  if (block.count_missing() == 0) return {shaped(block.numbers.data()), py::none()};
  return {shaped(block.numbers.data()),
          shaped(reinterpret_cast<const bool*>(block.missing.data()))};
}

PathArrays::Masked PathArrays::frequencies(py::handle owner, bool locked) {
  const auto of = locked ? &PathPoint::frequencies_locked : &PathPoint::frequencies_free;
  std::size_t most = 0;
  for (const PathPoint& point : response_.path) most = std::max(most, (point.*of).size());
  const Block& found = block(locked ? "/frequencies_locked" : "/frequencies_free", most,
                             [&](std::size_t k, const auto& set) {
                               const std::vector<double>& list = response_.path[k].*of;
                               for (std::size_t j = 0; j < list.size(); ++j) set(j, list[j]);
                             });
  return arrays(owner, found, true);
}

py::array PathArrays::converged() const {
  py::array_t<bool> flags(static_cast<py::ssize_t>(size()));
  for (std::size_t k = 0; k < size(); ++k)
    flags.mutable_at(k) = response_.path[k].status == PointStatus::converged;
  return read_only(std::move(flags));
}

std::vector<std::string> PathArrays::messages() const {
  std::vector<std::string> all;
  for (const PathPoint& point : response_.path) all.push_back(point.message);
  return all;
}

std::vector<std::string> PathArrays::names() const {
  std::vector<std::string> answered;
  for (const Quantity& q : all_quantities()) {
    for (const PathPoint& point : response_.path)
      if (q.value(point)) {
        answered.push_back(q.name);
        break;
      }
  }
  return answered;
}

std::map<std::string, std::string> PathArrays::units() const {
  std::map<std::string, std::string> all;
  for (const Quantity& q : all_quantities()) all[q.name] = q.unit;
  return all;
}

const Quantity& PathArrays::quantity(const std::string& name) const {
  const std::vector<Quantity>& all = all_quantities();
  const auto found = std::ranges::find(all, name, &Quantity::name);
  if (found == all.end()) throw py::key_error(fmt::format("no quantity is called {}", name));
  return *found;
}

PathArrays::Masked PathArrays::values(py::handle owner, const std::string& name) {
  const Quantity& q = quantity(name);
  const Block& found = block(name, 1, [&](std::size_t k, const auto& set) {
    if (const auto value = q.value(response_.path[k])) set(0, *value);
  });
  if (found.count_missing() == size())
    throw py::key_error(fmt::format("no point of this path has {}", name));
  return arrays(owner, found, false);
}

PathArrays::Masked PathArrays::gradient(py::handle owner, const std::string& name) {
  const Quantity& q = quantity(name);
  static_cast<void>(values(owner, name));  // a quantity of no point has no derivatives either
  const auto columns = static_cast<std::size_t>(through_->by.cols());
  const Block& found = block("/gradient/" + name, columns, [&](std::size_t k, const auto& set) {
    const PathPoint& point = response_.path[k];
    if (!q.value(point)) return;
    const auto along = q.gradient(point, gradients_->path[k]);
    if (!along) return;
    const VectorXd wanted = through_->by.transpose() * *along;
    for (std::size_t j = 0; j < columns; ++j) set(j, wanted[static_cast<Eigen::Index>(j)]);
  });
  return arrays(owner, found, true);
}

std::string PathArrays::status() const { return conclusion_of_case(*record_, load_case_).first; }

std::string PathArrays::message() const { return conclusion_of_case(*record_, load_case_).second; }

std::optional<double> PathArrays::stroke_reached() const {
  return flexopt::stroke_reached(response_);
}

}  // namespace flexopt
