#pragma once
// What acts on the mechanism of a job: the end-effector's body, the stroke, loads.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/spec/fault_list.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

EndEffector read_end_effector(const nlohmann::json& read, FaultList& faults,
                              std::vector<std::string>& notes);

/// Adds to `request`, which holds what stands at the head of the job.
void read_request(nlohmann::json& read, const nlohmann::json& as_written, const Family* family,
                  FaultList& faults, StrokeRequest& request);

/// Checks that nothing rigid is attached to O where O is a material point of a leaf.
void check_material_point(const Job& job, FaultList& faults);

/// The bodies that loads name, once these are known; `loads` are those of the job that were sound.
void find_loaded_bodies(const nlohmann::json& read, const Mechanism& mechanism, FaultList& faults,
                        std::vector<DeadLoad>& loads);

/// Gravity, temperature and errors of assembly, once the leaves are known. `notes`: which leaves
/// are full models because of them.
void read_surroundings(const nlohmann::json& read, const Mechanism& mechanism,
                       const ModelOptions& model, FaultList& faults, LoadCase& loads,
                       std::vector<std::string>& notes);

}  // namespace flexopt
