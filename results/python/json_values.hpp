#pragma once
// Python's dicts, lists and numbers ↔ JSON documents, value by value.
#include <pybind11/pybind11.h>

#include <nlohmann/json_fwd.hpp>

#include "results/files/json_text.hpp"

namespace flexopt {

/// Numbers of numpy and paths are taken too. Throws SpecError, at the pointer, for what JSON does
/// not have, and for what is nested deeper than a file may be.
nlohmann::json json_of(pybind11::handle value, const std::string& pointer = "");

pybind11::object python_of(const OrderedJson& value);

}  // namespace flexopt
