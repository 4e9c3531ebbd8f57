#pragma once
// Built-in materials.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// A built-in material with the source of its values.
struct NamedMaterial {
  Material material;
  std::string source;
};
const std::vector<NamedMaterial>& materials();

/// The material of a design file: the name of a built-in one, or its constants (checked).
Material material_of(const nlohmann::json& read);

}  // namespace flexopt
