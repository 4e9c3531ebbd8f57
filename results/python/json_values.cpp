#include "results/python/json_values.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/spec/spec_error.hpp"

namespace flexopt {
namespace {

namespace py = pybind11;
using nlohmann::json;

json object_of(const py::dict& dict, const std::string& pointer) {
  json object = json::object();
  for (const auto& [key, value] : dict) {
    if (!py::isinstance<py::str>(key))
      throw SpecError(pointer, py::repr(key), "keys of a job are texts");
    const auto name = key.cast<std::string>();
    object[name] = json_of(value, fmt::format("{}/{}", pointer, name));
  }
  return object;
}

json array_of(const py::sequence& list, const std::string& pointer) {
  json array = json::array();
  for (const py::handle value : list)
    array.push_back(json_of(value, fmt::format("{}/{}", pointer, array.size())));
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

}  // namespace

json json_of(py::handle value, const std::string& pointer) {
  if (value.is_none()) return nullptr;
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::isinstance<py::float_>(value)) return number_of(value, pointer);
  if (py::isinstance<py::int_>(value)) return whole_of(value, pointer);
  if (py::isinstance<py::dict>(value))
    return object_of(py::reinterpret_borrow<py::dict>(value), pointer);
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value))
    return array_of(py::reinterpret_borrow<py::sequence>(value), pointer);
  if (py::hasattr(value, "tolist")) return json_of(value.attr("tolist")(), pointer);  // of numpy
  if (py::hasattr(value, "__fspath__")) return json_of(value.attr("__fspath__")(), pointer);
  throw SpecError(pointer, py::repr(value),
                  "expected what JSON has: a dict, list, text, number, bool or None");
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
