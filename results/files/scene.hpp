#pragma once
// scene.json: what the report draws in three dimensions. Every equilibrium and every mode is there
// once, on the meshes of the leaves; the page makes the motion between them.
#include <filesystem>
#include <optional>

#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

/// {"flexopt_scene": 1, "designs": [...], "evaluations"}. The first design is the one of the
/// result; others are its other load cases ("case" has their names), the start of an optimisation
/// and the points of its front. Arrays are those of packed_array.hpp; SI units, global axes. Of a
/// design:
///     bodies, leaves, joints, springs, drives, loads   the undeflected mechanism
///     frames         index in the path of every point that is drawn
///     rest           mesh points of all leaves, undeflected [points × 3]
///     displacement   [frames × points × 3]
///     von_mises      [frames × points]
///     motion         displacement and rotation vector of the bodies [frames × bodies × 6]
///     modes          {"frames", "locked", "free", "leaves", "bodies"}: motion of mesh points, of
///                    which 32767 is the largest, and of the bodies (displacement, spin) in units
///                    of that largest; the locked ones first
///     branches       {"locked", "free"}: of every mode of every path point the number of the
///                    branch that it belongs to
/// No designs where the run has no shapes.
OrderedJson make_scene(const RunRecord& record);

/// The scene of a job that lists designs, merged from their scenes: the first one whole, the
/// equilibria of the others. `order`: places in `scenes`, best first. What does not fit into the
/// report is left out, and its labels are listed under "left_out".
OrderedJson merged_scene(const std::vector<OrderedJson>& scenes,
                         const std::vector<std::string>& labels,
                         const std::vector<std::size_t>& order);

void write_scene(const std::filesystem::path& folder, const OrderedJson& scene);

/// The scene in a folder; nothing where there is none.
OrderedJson read_scene(const std::filesystem::path& folder);

}  // namespace flexopt
