#pragma once
// Jobs with flat mechanisms (random_own_job) written otherwise, so that the answers must be the
// same, or follow from the others by a law.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// With the leaves as "reduced" or "full".
nlohmann::json with_accuracy(nlohmann::json job, const std::string& accuracy);
/// With these points of the stroke in the place of its own.
nlohmann::json with_stroke(nlohmann::json job, const nlohmann::json& at);

/// The strokes of all drives at a point of the job's list, and as a point of it.
std::vector<double> strokes_of(const nlohmann::json& job, const nlohmann::json& point);
nlohmann::json stroke_point(const nlohmann::json& job, const std::vector<double>& strokes);
/// The drives of the mechanism; those of one drive without name as a list of one.
nlohmann::json drives_of(const nlohmann::json& job);

/// In a frame that is turned about z, then about its own x [rad]; loads, payload and errors of
/// assembly turn along, the drives' directions are those of the frame. R: what turns them.
struct TurnedJob {
  nlohmann::json job;
  Matrix3d R;
};
TurnedJob turned_job(nlohmann::json job, double about_z, double about_x);

/// The mirror image across the plane normal to global axis `normal` (0, 1, 2); `signs`: of each
/// drive's stroke and load. Nothing where a drive has a frame of its own.
struct MirroredJob {
  nlohmann::json job;
  std::vector<double> signs;
};
std::optional<MirroredJob> mirrored_job(nlohmann::json job, int normal);

/// `factor` times as large and of the same material: loads and masses as random_jobs.hpp says.
nlohmann::json grown_job(nlohmann::json job, double factor);

/// Held directions as springs of this stiffness [N/m], times length² of turns: springs that pull
/// from far away, and bushings of turns alone, whose moment is that of the rotation vector. Nothing
/// where none are held, or along directions that are no axes.
std::optional<nlohmann::json> with_springs_for_held(nlohmann::json job, double stiffness,
                                                    double length);

/// The first flat leaf of one width and one thickness, or wire, as two halves with a body without
/// mass between them; nothing where there is none.
std::optional<nlohmann::json> with_cut_leaf(nlohmann::json job);

/// A translational drive against the ground along a global axis as a spring of this stiffness that
/// pulls from far away, beside a leaf of this length; the only point is this one. Nothing where the
/// drive is another one, or the only one.
struct SprungJob {
  nlohmann::json job;
  std::string body;
  Vector3d anchor;  ///< of the spring, from the undeflected place of what it pulls
  double free_length = 0, stiffness = 0;

  /// Load of the spring where the body has moved so.
  double load(const Vector3d& displacement) const {
    return stiffness * ((anchor - displacement).norm() - free_length);
  }
};
std::optional<SprungJob> with_spring_for_drive(nlohmann::json job, const nlohmann::json& point,
                                               double stiffness, double length, std::size_t drive);

}  // namespace flexopt
