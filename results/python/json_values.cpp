#include "results/python/json_values.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/spec/spec_error.hpp"

namespace flexopt {
namespace {

namespace py = pybind11;
using nlohmann::json;

constexpr int deepest = 32;  // as of a file

json json_within(py::handle value, const std::string& pointer, int depth);

std::string text_of(py::handle value, const std::string& pointer) try {
  return value.cast<std::string>();
} catch (const std::exception&) {  // half of a surrogate pair
  PyErr_Clear();
  throw SpecError(pointer, py::repr(value), "expected a text that UTF-8 can hold");
}

json object_of(const py::dict& dict, const std::string& pointer, int depth) {
  json object = json::object();
  for (const auto& [key, value] : dict) {
    if (!py::isinstance<py::str>(key))
      throw SpecError(pointer, py::repr(key), "keys of a job are texts");
    const std::string name = text_of(key, pointer);
    object[name] = json_within(value, fmt::format("{}/{}", pointer, name), depth + 1);
  }
  return object;
}

json array_of(const py::sequence& list, const std::string& pointer, int depth) {
  json array = json::array();
  for (const py::handle value : list)
    array.push_back(json_within(value, fmt::format("{}/{}", pointer, array.size()), depth + 1));
  return array;
}

double number_of(py::handle value, const std::string& pointer) {
  const double number = value.cast<double>();
  if (!std::isfinite(number)) throw SpecError(pointer, py::repr(value), "expected a finite number");
  return number;
}

std::int64_t whole_of(py::handle value, const std::string& pointer) try {
  return value.cast<std::int64_t>();
} catch (const py::cast_error&) {
  throw SpecError(pointer, py::repr(value), "expected a number of at most 63 bits");
}

/// What numpy's arrays and numbers are in Python's own types. Those that have no such type, of more
/// than 64 bits, stay as they are: then the nearest double.
json of_numpy(py::handle value, const std::string& pointer, int depth) {
  const py::object plain = value.attr("tolist")();
  if (!py::type::of(plain).is(py::type::of(value))) return json_within(plain, pointer, depth + 1);
  if (py::hasattr(value, "__float__") && !PyObject_IsTrue(value.attr("imag").ptr()))
    return number_of(py::float_(value.attr("real")), pointer);
  throw SpecError(pointer, py::repr(value), "expected a real number");
}

json json_within(py::handle value, const std::string& pointer, int depth) {
  if (depth > deepest)
    throw SpecError(pointer, "…", fmt::format("nested deeper than {} levels", deepest));
  if (value.is_none()) return nullptr;
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::str>(value)) return text_of(value, pointer);
  if (py::isinstance<py::float_>(value)) return number_of(value, pointer);
  if (py::isinstance<py::int_>(value)) return whole_of(value, pointer);
  if (py::isinstance<py::dict>(value))
    return object_of(py::reinterpret_borrow<py::dict>(value), pointer, depth);
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value))
    return array_of(py::reinterpret_borrow<py::sequence>(value), pointer, depth);
  if (py::hasattr(value, "tolist") && py::hasattr(value, "imag"))
    return of_numpy(value, pointer, depth);
  if (py::hasattr(value, "tolist"))
    return json_within(value.attr("tolist")(), pointer, depth + 1);  // a series of pandas
  if (py::hasattr(value, "__fspath__"))
    return json_within(value.attr("__fspath__")(), pointer, depth + 1);
  throw SpecError(pointer, py::repr(value),
                  "expected what JSON has: a dict, list, text, number, bool or None");
}

}  // namespace

json json_of(py::handle value, const std::string& pointer) {
  return json_within(value, pointer, 0);
}

py::object python_of(const OrderedJson& value) {
  switch (value.type()) {
    case OrderedJson::value_t::object: {
      py::dict dict;
      for (const auto& [key, entry] : value.items()) dict[py::str(key)] = python_of(entry);
      return dict;
    }
    case OrderedJson::value_t::array: {
      py::list list(value.size());
      for (std::size_t k = 0; k < value.size(); ++k) list[k] = python_of(value[k]);
      return list;
    }
    case OrderedJson::value_t::string:
      return py::str(value.get_ref<const std::string&>());
    case OrderedJson::value_t::boolean:
      return py::bool_(value.get<bool>());
    case OrderedJson::value_t::number_integer:
      return py::int_(value.get<std::int64_t>());
    case OrderedJson::value_t::number_unsigned:
      return py::int_(value.get<std::uint64_t>());
    case OrderedJson::value_t::number_float:
      return py::float_(value.get<double>());
    default:
      return py::none();
  }
}

}  // namespace flexopt
