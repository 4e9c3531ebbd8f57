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

/// The material of a design file at `at`: the name of a built-in one, or its constants (checked).
/// Throws SpecError where its S-N curve is none.
Material material_of(const nlohmann::json& read, const nlohmann::json_pointer<std::string>& at);

}  // namespace flexopt
