#pragma once
// Runs of jobs, and the numbers of two of them side by side.
#include <vector>

#include "core/math/types.hpp"
#include "results/files/run_record.hpp"
#include "support/differences.hpp"

namespace flexopt {

// An evaluation as the program concludes it.
struct Run {
  RunRecord record;
  double seconds = 0;
  bool ok() const { return record.status == "ok"; }
  const std::vector<PathPoint>& path() const { return record.response.path; }
};

// What Newton's tolerance leaves of a place, over the length.
inline constexpr double of_newton = 3e-9;

// What rounding leaves of the force in a leaf, over its stretching stiffness E w t, and of the
// place of a body that hangs on soft leaves beside stiff ones, over the length.
inline constexpr double of_force = 1e-13, of_place = 6e-8;

// Largest errors of the kinds of numbers, relative.
struct LawTolerance {
  double number = 0, stress = 0;
};

// How the other run is to be read.
struct Twin {
  double growth = 1;
  Matrix3d Q = Matrix3d::Identity();  // what turns or mirrors vectors
  std::vector<double> signs;          // of the strokes; empty: 1
  std::vector<std::size_t> points;    // of the other run, of each of ours; empty: the same
  bool frequencies = true, motion = true, compliance = true;
  bool drives_free = true;  // the compliance with them
  double of_acting = 1e-7;  // what is unknown of a drive's load, over the loads that act beside it
  double of_motion = 0;     // the same, over the largest motion times the drive's stiffness
};

Run run(const nlohmann::json& job);

// Converged, stable and on the primary branch.
bool believed(const PathPoint& point);

// The length of the longest leaf.
double length_of(const Mechanism& mechanism);

// [N]; moments over the length.
double largest_load(const Job& job, double length);

// Writes to `found` what differs most at the points that are believed in both.
void compare(const Run& one, const Run& other, const Twin& twin, const LawTolerance& allowed,
             Difference& found);

// What the reduction may be off by: README's accuracy of reduced leaves, three times.
inline constexpr LawTolerance of_reduction{0.01, 0.03};
// What leaves may be off by that are expanded about other states.
inline constexpr LawTolerance of_expansion{0.005, 0.015};
// Full leaves, by Newton's tolerance and rounding.
inline constexpr LawTolerance of_rounding{2e-5, 1e-4};

}  // namespace flexopt
