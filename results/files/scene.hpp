#pragma once
// scene.json: what the report draws in three dimensions. Every equilibrium and every mode is there
// once, on the meshes of the leaves; the page makes the motion between them.
#include <filesystem>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

/// {"flexopt_scene": 1, "designs": [...], "evaluations"}. The first design is the one of the
/// result; others are its other load cases ("case" has their names), the start of an optimisation
/// and the points of its front. Arrays are those of packed_floats; SI units, global axes. Of a
/// design:
///     bodies, leaves, elastic_bodies, joints, springs, drives, loads   the undeflected mechanism
///     frames         index in the path of every point that is drawn
///     rest           mesh points of all leaves, then corners at the surfaces of elastic bodies,
///                    undeflected [points × 3]
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

// The natural modes of a scene.

/// The key "modes" of a design in scene.hpp, for these points of the path; `points`: all that are
/// drawn. Signs follow from frame to frame. Null where no point has shapes of its modes.
OrderedJson modes_json(const Mechanism& mechanism, const std::vector<PathPoint>& path,
                       const std::vector<std::size_t>& frames, std::size_t points);

/// Calls visit(shape) for the shape of each leaf, then of each elastic body.
template <class Visit>
void for_each_shape(const PathPoint& point, const Visit& visit) {
  for (const LeafShape& shape : point.shapes) visit(shape);
  for (const ElasticShape& shape : point.elastic_shapes) visit(shape);
}
/// How many points the shapes have; none where nothing is drawn.
std::size_t drawn_points(const PathPoint& point);

/// Positions of the mesh lines of a leaf, as shares of its length from base to tip.
std::vector<double> places_along(const LeafShape& shape);

/// Half the thickness of a leaf, or the radius of a wire, at a share s of its length [m].
double half_thickness(const LeafSpring& leaf, double s);

/// Motion of the points of a leaf whose edges follow their bodies: cubic along the leaf, as a
/// slender leaf bends. For models that do not tell their own. 3 numbers a point, in the order of
/// the shape.
VectorXd cubic_leaf_motion(const Mechanism& mechanism, std::size_t leaf, const PathPoint& point,
                           const VectorXd& body_motion);

// Tracks modes from one point of the path to the next.

/// For every point of the path (empty where it has no modes), the branch of each of its modes. The
/// modes of a point continue the branches of the nearest earlier point with modes to which they are
/// most similar, each once: cos² of the angle between the motions (Mode::motion) at least 0.3.
/// Other modes begin a branch. `drive`: whose list of modes.
std::vector<std::vector<int>> mode_branches(const std::vector<PathPoint>& path, DriveState drive);

}  // namespace flexopt
