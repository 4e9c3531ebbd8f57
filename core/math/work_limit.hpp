#pragma once
// How much work one evaluation may do, and its end where that is used up.
#include <exception>
#include <functional>
#include <optional>
#include <string>

namespace flexopt {

/// Time of a monotonic clock [s].
double steady_seconds();

/// What one evaluation may take. Plain data.
struct WorkLimits {
  /// Limit of wall-clock time [s]; what exceeds it depends on the machine.
  std::optional<double> seconds;
  /// Newton iterations, of the mechanism and of the leaves that reduced ones are made from: the
  /// same on every machine.
  std::optional<int> iterations;
  double (*clock)() = steady_seconds;  ///< tests bring their own
};

/// Ends an evaluation that has used up its limits. Whoever opened the scope catches it and makes a
/// status of it.
class WorkLimitReached : public std::exception {
 public:
  explicit WorkLimitReached(std::string text) : text_(std::move(text)) {}
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  std::string text_;
};

/// Scope in which work of this thread counts against these limits. A nested scope replaces the
/// outer one until it ends.
class LimitedWork {
 public:
  /// `told`: of the number of Newton iterations so far, at each.
  explicit LimitedWork(const WorkLimits& limits, std::function<void(int)> told = {});
  ~LimitedWork();
  LimitedWork(const LimitedWork&) = delete;
  LimitedWork& operator=(const LimitedWork&) = delete;

  /// Throws WorkLimitReached.
  void check(int iterations);
  /// Newton iterations counted so far.
  int iterations() const { return iterations_; }

 private:
  WorkLimits limits_;
  double begin_ = 0;
  int iterations_ = 0;
  std::function<void(int)> told_;
  LimitedWork* outer_;
};

/// Counts one Newton iteration. Throws WorkLimitReached where the limits of this thread are used
/// up; without limits, it only counts.
void count_iteration();

/// Looks at the clock alone, in long work that is no Newton iteration. Throws WorkLimitReached.
void check_work();

}  // namespace flexopt
