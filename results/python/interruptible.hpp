#pragma once
// C++ work that Python waits for: it may call back, and Ctrl-C or an error of the callback ends it.
#include <pybind11/pybind11.h>

#include <atomic>
#include <functional>
#include <optional>

#include "results/run/progress.hpp"

namespace flexopt {

/// Tells a Python function (done, total, text) how far a run is; a line of its own comes with 0 of
/// 0.
class PythonListener : public RunListener {
 public:
  /// `callback`: None if nobody is to be told.
  explicit PythonListener(pybind11::object callback) : callback_(std::move(callback)) {}
  void say(const std::string& text) override { tell(0, 0, text); }
  void step(const RunStep& step) override {
    tell(step.done, step.total, step.text.empty() ? step.what : step.text);
  }

  /// From now on, every call throws Interrupted, with the error that Python sees. Needs the GIL.
  void stop(pybind11::error_already_set error);
  bool stopped() const { return stopped_; }
  /// Throws the error that stopped it, if one did. With the GIL.
  void rethrow();

 private:
  void tell(int done, int total, const std::string& text);

  pybind11::object callback_;
  std::atomic<bool> stopped_ = false;
  std::optional<pybind11::error_already_set> error_;
};

/// Lives while C++ computes without the GIL, from before it is given up until it is back. Python
/// waits for all of them before it ends: a thread that came back later would end the process.
class Computation {
 public:
  /// Begins a computation; needs the GIL. Throws SystemExit, which ends a thread silently, where
  /// Python is ending already.
  Computation();
  ~Computation();
  Computation(const Computation&) = delete;
  Computation& operator=(const Computation&) = delete;
};

/// Called when Python ends: runs end at their next step, and all computations are waited for.
/// Ctrl-C ends the waiting.
void end_computations();

/// Runs `work` on a thread of its own, without the GIL, and looks for signals meanwhile. Throws
/// what stopped the listener, or what work throws.
void run_interruptibly(PythonListener& listener, const std::function<void()>& work);

}  // namespace flexopt
