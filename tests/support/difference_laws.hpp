#pragma once
// The laws of differences_of(): each runs a job in two ways and writes what it found.
#include <functional>

#include "support/compared_runs.hpp"
#include "support/random_design.hpp"

namespace flexopt {

class Looker {
 public:
  Looker(const nlohmann::json& job, unsigned long long seed, Laws laws)
      : job_(job), random_(seed), seed_(seed), laws_(laws) {}

  Differences look();

 private:
  const nlohmann::json& points() const { return job_["stroke"]["at"]; }

  // Runs one law; a mechanism is looked at by every third one, in turn, where few are asked for.
  void law(const std::string& name, const std::function<void(Difference&)>& look);
  void look_at(const std::string& name, std::size_t number,
               const std::function<void(Difference&)>& look);
  static bool answered(const Run& one, Difference& d);
  static void answer(const Run& one, const Run& other, const Twin& twin,
                     const LawTolerance& allowed, Difference& d);
  // Runs d.other, which has the same leaves; those whose models differ are as good as reduced ones.
  void answer_again(const Run& base, const Twin& twin, Difference& d) const;

  // One number against another one.
  static void number(double one, double other, double scale, double allowed,
                     const std::string& name, Difference& d);

  // The k-th frequency with d drives held lies between the k-th and the (k + d)-th with them free.
  // This costs nothing and is looked at for every mechanism.
  void interlacing(const Run& base);
  void alone(const Run& base);

  // With two points more on the way from each point to the next.
  void more_points(const Run& base);

  // A force at O that grows, nothing driven: at once, and by steps that are told.
  void load_in_steps(const Run& whole);

  // Each drive's load at both sides of the last point, the other drives held.
  void stiffness_by_stroke(const std::string& name, const nlohmann::json& job, double allowed);

  // A leaf that has changed its model between two points makes loads leap by what it was off.
  static bool other_models(const PathPoint& a, const PathPoint& b);
  void compare_stiffness(nlohmann::json job, double share, double allowed, Difference& d);

  // A dead moment has no potential, and compliances are those of the part that has one: without it.
  void compliance_by_load(nlohmann::json job);
  void compare_compliance(const nlohmann::json& job, const PathPoint& here, const Vector6d& w,
                          double share, Difference& d);

  // The work of two drives around a rectangle, from 0.7 to 1 of the last point's strokes: by
  // Gauss's five points on each edge, and where loads change too sharply for these, on each quarter
  // or sixteenth of it.
  void closed_way(nlohmann::json job, const Run& whole);
  void work_around(const nlohmann::json& job, const std::vector<double>& last,
                   std::array<std::size_t, 2> pair, int parts, Difference& d);

  // Whether the load of a drive leaps from one point of a row to the next by what its stiffness
  // does not tell: each point lies at the end of its own way, and ways at both sides of a
  // bifurcation part. Then small steps along both ways must end where the points are.
  bool leaps(const nlohmann::json& job, const nlohmann::json& at, const Run& row, Difference& d);
  void moved(const nlohmann::json& job, const Run& whole, bool all);

  // What the stiffest leaf could carry: E A / L [N/m].
  double stiffest() const;
  void springs_for_held(const nlohmann::json& job, const Run& whole);

  // Largest distance of a body's places, and of its rotations times the length.
  double apart(const PathPoint& a, const PathPoint& b) const;

  // Bodies apart by more than this share of what they move.
  bool far_apart(const PathPoint& a, const PathPoint& b, double share) const;

  // Leaves that have buckled to their other sides hardly move bodies.
  static bool same_frequencies(const std::vector<double>& a, const std::vector<double>& b);

  // The drive gives way a little; its load is compared there.
  void spring_for_drive(const nlohmann::json& job, const Run& whole);

  // The common edge of the halves does not warp: narrow beams and wires, on fine meshes.
  void cut(const nlohmann::json& job, const Run& whole);

  // The mechanism is of one material, and nothing in it is joined, sprung, held or driven.
  void warm(nlohmann::json job);
  void heavy(nlohmann::json job);
  void state_space(const nlohmann::json& job);
  void beam_and_plate(const Run& whole);

  // With the load at O put on the state is stable and below the stress, or not.
  void capacity(nlohmann::json job, const Run& whole);
  void buckling(nlohmann::json job, const Run& whole);

  nlohmann::json job_;
  RandomNumbers random_;
  std::size_t seed_, number_ = 0;
  Laws laws_;
  bool few_ = false;
  Differences found_;
  LawTolerance same_leaves_;
  double length_ = 1;
  std::vector<double> largest_stiffness_;  // of each drive
};

}  // namespace flexopt
