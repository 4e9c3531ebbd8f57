#pragma once
// The numbers of a job that may be moved, their ranges, and the job with other values for them.
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "optim/job/job.hpp"
#include "results/files/json_text.hpp"

namespace flexopt {

/// A number of a design that can be moved, SI.
struct Slider {
  std::string name, unit, meaning;
  double value = 0;  ///< the job's
  double min = 0, max = 0;
  bool whole = false;  ///< a number of things
};

/// Sliders of a job: the variables of an optimisation with their bounds, or every parameter of an
/// evaluated design that is a number, from half to twice its value, as far as the design allows it.
/// A parameter that is zero goes to both sides as far as half the largest parameter of its unit,
/// or, where all of these are zero, through its whole range. Throws SpecError for a job that has no
/// single design to show, or nothing to move.
std::vector<Slider> sliders_of(const Job& job);

/// {"parameters": {"length": 0.04, …}}, SI; those that are not named keep the job's value. Throws
/// SpecError for anything else: other names, other values than numbers, numbers out of range.
ParameterValues read_move(const std::string& body, const std::vector<Slider>& sliders);

/// The job's document with these numbers (of sliders_of), and without numbers that are expected of
/// the old ones.
nlohmann::json moved_job(const Job& job, const ParameterValues& values);

// A job as something to try numbers on: a move of its sliders → what the page shows.

class Explorer {
 public:
  /// Throws as sliders_of does.
  explicit Explorer(Job job);

  const Job& job() const { return job_; }
  const std::vector<Slider>& sliders() const { return sliders_; }
  /// What the page needs of them: [{"name", "unit", "meaning", "value", "min", "max", "whole"}].
  OrderedJson slider_table() const;

  /// The design with these numbers, evaluated as a run of a job "evaluate" does it but for maps and
  /// tolerances:
  ///     {"ok": true, "seconds", "result", "scene", "goals"}
  /// `goals` are objective and constraints of an optimisation, without what tolerances do to them:
  /// {"label", "role", "sense" or "min", "max", "met", "value", "unit", "as"}. Where the design
  /// breaks a rule or has no equilibrium: {"ok": false, "seconds", "message"}. Thread-safe.
  OrderedJson evaluate(const ParameterValues& values) const;

  /// The job file with these numbers.
  std::string job_text(const ParameterValues& values) const;

 private:
  Job job_;
  std::vector<Slider> sliders_;
};

/// One evaluation at a time, for the newest who asks: those who wait while another one runs give
/// way to whoever comes after them.
class NewestMove {
 public:
  /// Calls `work` when nothing else runs; returns nothing where a newer caller came before that.
  template <class Work>
  auto run(Work&& work) -> std::optional<decltype(work())> {
    if (!begin()) return std::nullopt;
    const End end{*this};
    return work();
  }

 private:
  struct End {
    NewestMove& of;
    ~End() { of.end(); }
  };
  bool begin();
  void end();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t newest_ = 0;
  bool running_ = false;
};

}  // namespace flexopt
