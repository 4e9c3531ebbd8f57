#include "results/python/interruptible.hpp"

#include <pthread.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "optim/solvers/parallel.hpp"

namespace flexopt {

namespace py = pybind11;

namespace {

std::atomic<int> computations = 0;
std::atomic<bool> ending = false;
std::thread::id ended_by;

}  // namespace

Computation::Computation() {
  // A fork has the threads of none but the one that forked.
  static const int known = ::pthread_atfork(nullptr, nullptr, [] { computations = 0; });
  static_cast<void>(known);
  if (ending && std::this_thread::get_id() != ended_by) {
    PyErr_SetNone(PyExc_SystemExit);
    throw py::error_already_set();
  }
  ++computations;
}

Computation::~Computation() { --computations; }

void end_computations() {
  ended_by = std::this_thread::get_id();
  ending = true;
  while (computations > 0) {
    {
      const py::gil_scoped_release released;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
}

void PythonListener::stop(py::error_already_set error) {
  if (!error_) error_.emplace(std::move(error));
  stopped_ = true;
}

void PythonListener::rethrow() {
  if (error_) throw *std::exchange(error_, std::nullopt);
}

void PythonListener::tell(int done, int total, const std::string& text) {
  if (stopped_ || ending) throw Interrupted{};
  if (callback_.is_none()) return;
  const py::gil_scoped_acquire gil;
  try {
    callback_(done, total, text);
  } catch (py::error_already_set& error) {
    stop(std::move(error));
  }
  if (stopped_) throw Interrupted{};
}

void run_interruptibly(PythonListener& listener, const std::function<void()>& work) {
  std::mutex mutex;
  std::condition_variable ended;
  bool done = false;
  std::exception_ptr failure;
  std::thread thread([&] {
    try {
      work();
    } catch (...) {
      failure = std::current_exception();
    }
    const std::scoped_lock lock(mutex);
    done = true;
    ended.notify_one();
  });
  for (bool waiting = true; waiting;) {
    {
      const py::gil_scoped_release released;
      std::unique_lock lock(mutex);
      waiting = !ended.wait_for(lock, std::chrono::milliseconds(50), [&] { return done; });
    }
    if (PyErr_CheckSignals() != 0) listener.stop(py::error_already_set());
  }
  {
    const py::gil_scoped_release released;
    thread.join();
  }
  listener.rethrow();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace flexopt
