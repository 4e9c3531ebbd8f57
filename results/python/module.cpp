// flexopt._core: the C++ side of the Python package, which gives it a face.
#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/spec/spec_error.hpp"
#include "designs/family.hpp"
#include "optim/solvers/parallel.hpp"
#include "results/files/result_json.hpp"
#include "results/files/scene.hpp"
#include "results/files/version.hpp"
#include "results/python/interruptible.hpp"
#include "results/python/path_arrays.hpp"
#include "results/report/report.hpp"

namespace flexopt {
namespace {

namespace py = pybind11;
using namespace py::literals;
using Released = py::call_guard<Computation, py::gil_scoped_release>;

// Python's dicts, lists and numbers ↔ JSON documents, value by value.

using nlohmann::json;

constexpr int deepest = 32;  // as of a file

json json_within(py::handle value, const std::string& pointer, int depth);

std::string text_of(py::handle value, const std::string& pointer) try {
  return value.cast<std::string>();
} catch (const std::exception&) {  // half of a surrogate pair
  PyErr_Clear();
  throw SpecError(pointer, py::repr(value), "expected a text that UTF-8 can hold");
}

json object_of(const py::dict& dict, const std::string& pointer, int depth) {
  json object = json::object();
  for (const auto& [key, value] : dict) {
    if (!py::isinstance<py::str>(key))
      throw SpecError(pointer, py::repr(key), "keys of a job are texts");
    const std::string name = text_of(key, pointer);
    object[name] = json_within(value, fmt::format("{}/{}", pointer, name), depth + 1);
  }
  return object;
}

json array_of(const py::sequence& list, const std::string& pointer, int depth) {
  json array = json::array();
  for (const py::handle value : list)
    array.push_back(json_within(value, fmt::format("{}/{}", pointer, array.size()), depth + 1));
  return array;
}

double number_of(py::handle value, const std::string& pointer) {
  const double number = value.cast<double>();
  if (!std::isfinite(number)) throw SpecError(pointer, py::repr(value), "expected a finite number");
  return number;
}

std::int64_t whole_of(py::handle value, const std::string& pointer) try {
  return value.cast<std::int64_t>();
} catch (const py::cast_error&) {
  throw SpecError(pointer, py::repr(value), "expected a number of at most 63 bits");
}

/// What numpy's arrays and numbers are in Python's own types. Those that have no such type, of more
/// than 64 bits, stay as they are: then the nearest double.
json of_numpy(py::handle value, const std::string& pointer, int depth) {
  const py::object plain = value.attr("tolist")();
  if (!py::type::of(plain).is(py::type::of(value))) return json_within(plain, pointer, depth + 1);
  if (py::hasattr(value, "__float__") && !PyObject_IsTrue(value.attr("imag").ptr()))
    return number_of(py::float_(value.attr("real")), pointer);
  throw SpecError(pointer, py::repr(value), "expected a real number");
}

json json_within(py::handle value, const std::string& pointer, int depth) {
  if (depth > deepest)
    throw SpecError(pointer, "…", fmt::format("nested deeper than {} levels", deepest));
  if (value.is_none()) return nullptr;
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::str>(value)) return text_of(value, pointer);
  if (py::isinstance<py::float_>(value)) return number_of(value, pointer);
  if (py::isinstance<py::int_>(value)) return whole_of(value, pointer);
  if (py::isinstance<py::dict>(value))
    return object_of(py::reinterpret_borrow<py::dict>(value), pointer, depth);
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value))
    return array_of(py::reinterpret_borrow<py::sequence>(value), pointer, depth);
  if (py::hasattr(value, "tolist") && py::hasattr(value, "imag"))
    return of_numpy(value, pointer, depth);
  if (py::hasattr(value, "tolist"))
    return json_within(value.attr("tolist")(), pointer, depth + 1);  // a series of pandas
  if (py::hasattr(value, "__fspath__"))
    return json_within(value.attr("__fspath__")(), pointer, depth + 1);
  throw SpecError(pointer, py::repr(value),
                  "expected what JSON has: a dict, list, text, number, bool or None");
}

py::object python_of(const OrderedJson& value) {
  return py::module_::import("json").attr("loads")(compact_text(value));
}

JobKind kind_of(const std::string& name) {
  for (const JobKind kind : {JobKind::evaluate, JobKind::optimise, JobKind::compare})
    if (name_of(kind) == name) return kind;
  throw SpecError("/job", name, "expected \"evaluate\", \"optimise\" or \"compare\"");
}

/// Raises a Python exception of flexopt._errors with these arguments.
void raise(const char* type, const py::args& arguments) {
  const py::object error = py::module_::import("flexopt._errors").attr(type);
  PyErr_SetObject(error.ptr(), error(*arguments).ptr());
}

void raise(const SpecError& error) {
  py::list faults;
  for (const Fault& f : error.faults())
    faults.append(py::make_tuple(f.pointer, f.value, f.rule, f.source, f.line, f.column));
  raise("JobError", py::make_tuple(error.what(), faults));
}

void translate(std::exception_ptr failure) {
  try {
    if (failure) std::rethrow_exception(std::move(failure));
  } catch (const SpecError& error) {
    raise(error);
  } catch (const NotConverged& error) {
    raise("NotConverged", py::make_tuple(error.what(), error.reached));
  } catch (const Interrupted&) {  // only the end of Python interrupts here
    PyErr_SetNone(PyExc_SystemExit);
  } catch (const NoGradient& error) {
    raise("NoGradient", py::make_tuple(error.what()));
  }
}

py::object document(const Job& job) { return python_of(OrderedJson(document_of(job))); }

void add_job(py::module_& m) {
  py::class_<Job, std::shared_ptr<Job>>(m, "Job")
      .def_static(
          "read",
          [](const std::string& file, const std::vector<std::string>& overrides) {
            return std::make_shared<Job>(read_job(file, overrides));
          },
          Released())
      .def_static("parse",
                  [](const py::dict& dict) {
                    const json document = json_within(dict, "", 0);
                    std::vector<std::string> case_order;  // a dict has one, a json has none
                    if (dict.contains("cases") && py::isinstance<py::dict>(dict["cases"]))
                      for (const auto& [name, own] : py::dict(dict["cases"]))
                        case_order.push_back(name.cast<std::string>());
                    const Computation computation;
                    const py::gil_scoped_release released;
                    return std::make_shared<Job>(parse_job(document, case_order));
                  })
      .def(
          "as_kind",
          [](const Job& job, const std::string& kind) {
            return std::make_shared<Job>(as_kind(job, kind_of(kind)));
          },
          Released())
      .def_readonly("name", &Job::name)
      .def_property_readonly("kind", [](const Job& job) { return name_of(job.kind); })
      .def_property_readonly("parameters", [](const Job& job) { return job.design.parameters; })
      .def_property_readonly("differentiable", &differentiable_parameters)
      .def_readonly("notes", &Job::notes)
      .def("document", &document);
}

py::object result_of(const RunRecord& record) {
  std::optional<OrderedJson> result;
  {
    const Computation computation;
    const py::gil_scoped_release released;
    result = make_result(record);
  }
  return python_of(*result);
}

std::string report_of(const RunRecord& record) {
  return make_report(make_result(record), make_scene(record));
}

/// Names of the load cases of a run; none where the job has a single case or no design could be
/// evaluated.
std::vector<std::string> case_names(const FinishedRun& run) {
  std::vector<std::string> names;
  if (!responses_of(*run.record).empty())
    for (const JobCase& one : run.record->job.cases) names.push_back(one.name);
  return names;
}

void add_run(py::module_& m) {
  py::class_<FinishedRun> finished(m, "Run");
  finished
      .def_property_readonly("message", [](const FinishedRun& run) { return run.record->message; })
      .def_property_readonly("no_gradients",
                             [](const FinishedRun& run) { return run.record->no_gradients; })
      .def_property_readonly("seconds",
                             [](const FinishedRun& run) { return run.record->timings.at("total"); })
      .def_readonly("failed_expectations", &FinishedRun::failed_expectations)
      .def_property_readonly("case_names", [](const FinishedRun& run) { return case_names(run); })
      .def("result", [](const FinishedRun& run) { return result_of(*run.record); })
      .def(
          "report", [](const FinishedRun& run) { return report_of(*run.record); }, Released());
  add_path(m, finished);
  m.def(
      "run",
      [](const std::shared_ptr<Job>& job, const std::vector<std::string>& along,
         const std::string& folder, int threads, py::object progress) {
        const Computation computation;
        const RunOptions options{folder, threads, along};
        PythonListener listener(std::move(progress));
        std::optional<FinishedRun> finished;
        if (job->kind == JobKind::evaluate && !job->tolerances && job->maps.empty()) {
          const py::gil_scoped_release released;  // soon over: no thread of its own
          try {
            finished = run(*job, options, listener);
          } catch (const std::exception&) {
            if (!listener.stopped()) throw;
          }
        } else {
          run_interruptibly(listener, [&] { finished = run(*job, options, listener); });
        }
        listener.rethrow();
        std::string status = finished->record->status;  // asking for it takes longer than this
        return std::pair(std::move(*finished), std::move(status));
      },
      "job"_a, "along"_a, "folder"_a, "threads"_a, "progress"_a);
}

void add_problem(py::module_& m) {
  py::class_<PosedGoals>(m, "PosedGoals")
      .def(py::init([](const std::shared_ptr<Job>& job, bool scaled, bool pointwise) {
             return std::make_unique<PosedGoals>(*job, scaled, pointwise);
           }),
           "job"_a, "scaled"_a, "pointwise"_a, Released())
      .def_property_readonly("names", &PosedGoals::names)
      .def_property_readonly("start", &PosedGoals::start)
      .def_property_readonly("lower", &PosedGoals::lower)
      .def_property_readonly("upper", &PosedGoals::upper)
      .def_property_readonly("constraint_names", &PosedGoals::constraint_names)
      .def_property_readonly("constraint_lower", &PosedGoals::constraint_lower)
      .def_property_readonly("constraint_upper", &PosedGoals::constraint_upper)
      .def(
          "f", [](const PosedGoals& p, const VectorXd& x) { return p.at(x, false)->f; }, Released())
      .def(
          "g", [](const PosedGoals& p, const VectorXd& x) { return p.at(x, false)->g; }, Released())
      .def(
          "df", [](const PosedGoals& p, const VectorXd& x) { return p.at(x, true)->df; },
          Released())
      .def(
          "dg", [](const PosedGoals& p, const VectorXd& x) { return p.at(x, true)->dg; },
          Released())
      .def("objective", &PosedGoals::objective, Released())
      .def("parameters", &PosedGoals::parameters, Released());
}

}  // namespace
}  // namespace flexopt

PYBIND11_MODULE(_core, m) {
  using namespace flexopt;
  py::register_exception_translator(&translate);
  m.attr("version") = version();
  m.attr("commit") = commit();
  py::module_::import("atexit").attr("register")(py::cpp_function(&end_computations));
  m.def("family_names", [] {
    std::vector<std::string> names;
    for (const Family& family : families()) names.push_back(family.name);
    return names;
  });
  m.def("option_names", [](const std::string& family) {
    std::vector<std::string> names;
    for (const FamilyOption& option : find_family(family, "/design/family").options)
      names.push_back(option.name);
    return names;
  });
  m.def("check_names",
        [](const py::dict& design) { check_names(json_within(design, "/design", 0)); });
  add_job(m);
  add_run(m);
  add_problem(m);
}
