#include "core/math/work_limit.hpp"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "core/math/work_count.hpp"

namespace flexopt {
namespace {

thread_local LimitedWork* present = nullptr;
thread_local long long counted = 0;

}  // namespace

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

LimitedWork::LimitedWork(const WorkLimits& limits, std::function<void(int)> told)
    : limits_(limits), told_(std::move(told)), outer_(present) {
  if (limits_.seconds) begin_ = limits_.clock();
  present = this;
}

LimitedWork::~LimitedWork() { present = outer_; }

// What was needed is not said: it differs from run to run.
void LimitedWork::check(int iterations) {
  iterations_ += iterations;
  if (told_ && iterations > 0) told_(iterations_);
  if (limits_.iterations && iterations_ > *limits_.iterations)
    throw WorkLimitReached(
        fmt::format("iteration limit: more than {} Newton iterations", *limits_.iterations));
  if (limits_.seconds && limits_.clock() - begin_ > *limits_.seconds)
    throw WorkLimitReached(fmt::format("time limit: more than {:g} s", *limits_.seconds));
}

void count_iteration() {
  ++counted;
  if (present) present->check(1);
}

long long counted_iterations() { return counted; }

void check_work() {
  if (present) present->check(0);
}

}  // namespace flexopt
