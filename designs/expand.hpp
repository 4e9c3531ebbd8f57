#pragma once
// A design at given numbers as a design file without parameters.
#include <nlohmann/json_fwd.hpp>

#include "designs/family.hpp"

namespace flexopt {

/// The flat design file: no frames, parts, repeats or options; full names, numbers in SI. Read
/// again it makes the same mechanism to the last bit. Throws SpecError as Family::make.
nlohmann::ordered_json expanded(const Family& family, const ParameterValues& values,
                                const FamilyChoices& choices, const Material& material);

}  // namespace flexopt
