#pragma once
// Design files: JSON → plan.
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/spec/fault_list.hpp"
#include "designs/design_plan.hpp"

namespace flexopt {

/// What a design file says of itself, beside its plan.
struct DesignHead {
  std::string name, summary, drawing;
  std::vector<int> mesh;  ///< elements along and across, or empty
};

/// Reads a design document. All that is wrong is added to `faults`, with its place. `within`: the
/// files that this one is a part of, outermost first.
std::shared_ptr<const DesignPlan> read_plan(const nlohmann::json& document,
                                            const DesignSource& source, DesignHead& head,
                                            FaultList& faults,
                                            std::vector<std::string> within = {});

/// Source of a family that the program brings along.
DesignSource library_source(const std::string& name);

/// Reads a design file of the user. Throws SpecError.
std::shared_ptr<const DesignPlan> read_design_file(const std::string& file, DesignHead& head,
                                                   std::vector<std::string> within = {});

}  // namespace flexopt
