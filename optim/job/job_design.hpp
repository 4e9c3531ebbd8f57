#pragma once
// The design of a job: where it comes from, its numbers, its material.
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/spec/fault_list.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// What the document takes its design from: a family by name, a file relative to `folder`, or a
/// mechanism that is written into it. Null where there is none that can be read.
std::shared_ptr<const Family> design_source(const nlohmann::json& document,
                                            const std::string& folder, FaultList& faults);

/// Whether the design is one leaf whose section may be a circle: its width is then its thickness.
bool may_be_wire(const Family& family);

/// A wire needs no width: it is the thickness.
nlohmann::json with_width_of_wire(nlohmann::json document);

/// Whether nothing is wrong with what makes the geometry.
bool is_geometry_sound(const Family& family, const FaultList& faults);

/// Reads the design of a job. Without a family, the material alone.
DesignSpec read_design(nlohmann::json& read, const nlohmann::json& written,
                       const std::shared_ptr<const Family>& family, FaultList& faults,
                       std::vector<std::string>& notes);

}  // namespace flexopt
