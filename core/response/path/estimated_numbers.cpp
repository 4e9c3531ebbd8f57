#include <fmt/format.h>

#include <algorithm>

#include "core/response/path/error_estimate.hpp"
#include "core/response/principal_stiffness.hpp"
#include "core/response/quantities.hpp"

namespace flexopt {
namespace {

std::string pointer_of(const QuantityRow& row) {
  std::string pointer = "/" + row.name;
  std::ranges::replace(pointer, '.', '/');
  return pointer;
}

/// Kind of the errors of a row. A load capacity that is not limited by stress has errors like those
/// of stiffness.
ErrorKind kind_of(const QuantityRow& row, const PathPoint& point, int component) {
  if (!row.needs.has(Output::load_capacity)) return row.error;
  const auto& capacity = point.load_capacity[component];
  return capacity && capacity->limit != CapacityLimit::stress ? ErrorKind::stiffness : row.error;
}

void add_row(const QuantityRow& row, const PathPoint& point, std::vector<EstimatedError>& numbers) {
  const auto add = [&](const std::string& name, const std::string& place, int component) {
    if (const auto value = row.value(point, component))
      numbers.push_back({name, pointer_of(row) + place, kind_of(row, point, component), *value});
  };
  const auto add_each = [&](const std::vector<std::string>& names) {
    for (std::size_t k = 0; k < names.size(); ++k)
      add(row.name + "." + names[k], "/" + names[k], static_cast<int>(k));
  };
  if (row.of_drives && !point.drive_names.empty()) {
    add_each(point.drive_names);
  } else if (row.layout == Layout::number) {
    add(row.name, row.direction ? "/value" : "", 0);
  } else if (row.layout == Layout::list) {
    for (int k = 0; row.value(point, k); ++k) {
      const auto i = static_cast<std::size_t>(k);
      const std::string index = fmt::format("{}", k);
      add(row.name + "." + (i < row.components.size() ? row.components[i] : index), "/" + index, k);
    }
  } else {
    add_each(row.components);
  }
}

/// Adds the numbers that the table of quantities does not name: all principal stiffnesses, and the
/// diagonals of both compliances.
void add_matrices(const PathPoint& point, std::vector<EstimatedError>& numbers) {
  for (const bool rotations : {false, true}) {
    const char* kind = rotations ? "rotations" : "translations";
    int k = 0;
    for (const PrincipalStiffness& p : principal_stiffnesses(point, rotations)) {
      numbers.push_back({fmt::format("principal_stiffness.{}.{}", kind, k),
                         fmt::format("/principal_stiffness/{}/{}", kind, k), ErrorKind::stiffness,
                         p.value});
      ++k;
    }
  }
  for (const bool free : {true, false})
    for (int d = 0; d < 6; ++d) {
      if (!free && !point.support_stiffness[d]) continue;  // held
      const char* drive = free ? "drive_free" : "drive_locked";
      const Matrix6d& of = free ? point.compliance_free : point.compliance_locked;
      numbers.push_back({fmt::format("compliance.{}.{}", drive, direction_names[d]),
                         fmt::format("/compliance/{}/{}", drive, d), ErrorKind::stiffness,
                         of(d, d)});
    }
}

}  // namespace

std::vector<EstimatedError> estimated_numbers(const PathPoint& point) {
  std::vector<EstimatedError> numbers;
  for (const QuantityRow& row : quantity_rows())
    if (row.error != ErrorKind::none) add_row(row, point, numbers);
  add_matrices(point, numbers);
  return numbers;
}

std::optional<Mechanism> with_coarse_bodies(const Mechanism& mechanism) {
  Mechanism coarse = mechanism;
  bool any = false;
  for (ElasticBody& body : coarse.elastic_bodies) {
    if (!body.coarse) continue;
    any = true;
    body = ElasticBody(*body.coarse);
  }
  if (!any) return std::nullopt;
  return coarse;
}

}  // namespace flexopt
