#include "results/files/result_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/reduction/atlas/tube_atlas.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_parts.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

/// Deformed leaves at the smallest, the unmoved and the largest converged stroke, for drawing.
Json shapes_json(const StrokeResponse& response, const Mechanism& mechanism) {
  std::vector<std::size_t> drawable;
  for (std::size_t i = 0; i < response.path.size(); ++i)
    if (!response.path[i].shapes.empty()) drawable.push_back(i);
  if (drawable.empty()) return Json::array();
  const auto stroke = [&](std::size_t i) { return response.path[i].stroke; };
  const auto [low, high] = std::ranges::minmax_element(drawable, {}, stroke);
  const auto rest =
      std::ranges::min_element(drawable, {}, [&](std::size_t i) { return std::abs(stroke(i)); });
  std::vector<std::size_t> chosen{*low, *rest, *high};
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());

  Json shapes = Json::array();
  for (const std::size_t i : chosen) {
    Json leaves = Json::array();
    for (std::size_t k = 0; k < response.path[i].shapes.size(); ++k) {
      const LeafShape& shape = response.path[i].shapes[k];
      leaves.push_back({{"name", mechanism.leaves[k].name},
                        {"points_along", shape.points_along},
                        {"points_across", shape.points_across},
                        {"deflected", list_json(shape.deflected, vector_json)},
                        {"von_mises", shape.von_mises}});
    }
    Json shape = {{"path_index", i}, {"stroke", stroke(i)}, {"leaves", std::move(leaves)}};
    const auto end_effector = static_cast<std::size_t>(mechanism.end_effector);
    if (end_effector < mechanism.bodies.size())
      shape["reference"] =
          vector_json(mechanism.bodies[end_effector].reference + response.path[i].displacement);
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

void flag_non_finite(Json& result) {
  const auto places = remove_non_finite(result);
  if (places.empty()) return;
  if (result["status"] == "ok") result["status"] = "not_finite";
  const std::string text = fmt::format(" {} number{} not finite, first at {}.", places.size(),
                                       places.size() == 1 ? " is" : "s are", places.front());
  result["message"] = result["message"].get<std::string>() + text;
}

Json mode_derivatives_json(const FrequencyDerivatives& d) {
  return {{"mode", d.index},
          {"kind", name_of(d.mode.kind)},
          {"drive", "free"},
          {"frequency", d.mode.frequency},
          {"d_omega2", d.d_omega2},
          {"d2_omega2", d.d2_omega2},
          {"d_compliance", d.d_compliance},
          {"d2_compliance", d.d2_compliance},
          {"valid_to",
           {{"omega2", optional_json(d.omega2_valid_to)},
            {"compliance", optional_json(d.compliance_valid_to)}}}};
}

Json frequency_derivatives_json(const StrokeResponse& response, const Mechanism& mechanism) {
  Json list = Json::array();
  const bool named = DriveList(mechanism).named();
  for (const FrequencyDerivatives& d : response.frequency_derivatives) {
    list.push_back(mode_derivatives_json(d));
    if (named) list.back()["stroke"] = mechanism.drives[d.drive].name;
  }
  return list;
}

Json frequency_ways_json(const StrokeResponse& response, const Mechanism& mechanism) {
  return list_json(response.frequency_ways, [&](const FrequencyWay& way) -> Json {
    return {{"strokes", strokes_json(way.strokes, mechanism.drives)},
            {"modes", list_json(way.modes, mode_derivatives_json)}};
  });
}

void add_frequency_derivatives(const StrokeResponse& response, const Mechanism& mechanism,
                               Json& json) {
  json["frequency_derivatives"] = frequency_derivatives_json(response, mechanism);
  if (!response.frequency_ways.empty())
    json["frequency_derivatives_along_ways"] = frequency_ways_json(response, mechanism);
}

const StrokeErrors* errors_of_case(const RunRecord& record, std::size_t k) {
  return k < record.errors.size() ? &record.errors[k] : nullptr;
}

/// Results of all load cases, each with the keys of the result of a single one.
Json cases_json(const RunRecord& record) {
  Json cases = Json::object();
  const auto responses = responses_of(record);
  for (std::size_t k = 0; k < responses.size(); ++k) {
    const auto& [name, request] = record.job.cases[k];
    const auto [status, message] = conclusion_of_case(record, k);
    Json& json = cases[name] = {
        {"status", status},
        {"message", message},
        {"units", units_json(record.job, record.mechanism, request)},
        {"quantities", quantities_json(DriveList(record.mechanism, record.job.request), request)},
        {"path", path_json(*responses[k], record.mechanism, request, errors_of_case(record, k))}};
    if (request.wants_frequency_derivatives())
      add_frequency_derivatives(*responses[k], record.mechanism, json);
    json["shapes"] = shapes_json(*responses[k], record.mechanism);
  }
  return cases;
}

/// The least and the largest value of each quantity over all load cases, and where they are.
Json extremes_json(const RunRecord& record) {
  Json extremes = Json::object();
  const auto responses = responses_of(record);
  for (const Quantity& q : quantities(DriveList(record.mechanism, record.job.request))) {
    if (!q.row->in_report) continue;
    std::optional<double> least, largest;
    GoalPlace at_least, at_largest;
    for (std::size_t k = 0; k < responses.size(); ++k) {
      const bool driven = record.job.cases[k].request.loads.driven();
      if (q.row->name == "drive_load" && !driven) continue;  // nothing is
      for (std::size_t i = 0; i < responses[k]->path.size(); ++i) {
        const std::optional<double> value = q.value(responses[k]->path[i]);
        if (!value) continue;
        if (!least || *value < *least) least = value, at_least = {k, i};
        if (!largest || *value > *largest) largest = value, at_largest = {k, i};
      }
    }
    if (!least) continue;
    const auto entry = [&](double value, const GoalPlace& place) {
      Json json = {{"value", value}};
      json.update(place_json(record.job, record.mechanism, place));
      return json;
    };
    extremes[q.name] = {{"least", entry(*least, at_least)},
                        {"largest", entry(*largest, at_largest)}};
  }
  return extremes;
}

/// The number at the pointer, or why there is none.
Answer<double> number_at(const OrderedJson& result, const std::string& pointer) try {
  const OrderedJson& found = result.at(OrderedJson::json_pointer(pointer));
  if (found.is_number()) return found.get<double>();
  return Because(
      fmt::format("{} is {}, not a number", pointer, found.is_null() ? "null" : found.type_name()));
} catch (const OrderedJson::exception&) {
  return Because(fmt::format("{} is not in the result", pointer));
}

const StateSpace* first_model(const StrokeResponse& response) {
  for (const PathPoint& point : response.path)
    if (point.state_space) return &*point.state_space;
  return nullptr;
}

Json named_json(const std::vector<Signal>& signals) {
  Json list = Json::array();
  for (const Signal& signal : signals)
    list.push_back({{"name", signal.name}, {"unit", signal.unit}});
  return list;
}

std::string matrix_text(const MatrixXd& matrix) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    if (i > 0) text += ";\n    ";
    for (Eigen::Index j = 0; j < matrix.cols(); ++j)
      text += (j > 0 ? " " : "") + csv::number_cell(matrix(i, j));
  }
  return text + "]";
}

// Text between quotes of MATLAB; names of the user may have some.
std::string quoted(const std::string& text) {
  std::string doubled;
  for (const char c : text) doubled += c == '\'' ? "''" : std::string(1, c);
  return "'" + doubled + "'";
}

std::string list_text(const std::vector<Signal>& signals, std::string Signal::*what) {
  std::vector<std::string> all;
  for (const Signal& signal : signals) all.push_back(quoted(signal.*what));
  return fmt::format("{{{}}}", fmt::join(all, ", "));
}

// A comment has one line.
std::string one_line(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

}  // namespace

Json path_json(const StrokeResponse& response, const Mechanism& mechanism,
               const StrokeRequest& request, const StrokeErrors* errors) {
  Json path = Json::array();
  for (std::size_t k = 0; k < response.path.size(); ++k) {
    path.push_back(make_path_point(response.path[k], mechanism, request));
    if (errors)
      path.back()["estimated_error"] =
          errors->path[k].empty() ? Json() : point_errors_json(errors->path[k]);
  }
  return path;
}

OrderedJson place_json(const Job& job, const Mechanism& mechanism, const GoalPlace& place) {
  const auto& [name, request] = job.cases[place.load_case];
  Json stroke = request.points[place.point];
  if (!request.strokes.empty() && DriveList(mechanism).named())
    stroke = strokes_json(request.strokes[place.point], mechanism.drives);
  return {{"case", name}, {"point", place.point}, {"stroke", std::move(stroke)}};
}

OrderedJson verdict_json(const Verdict& verdict) {
  return {{"tone", verdict.tone}, {"word", verdict.word}, {"text", verdict.text}};
}

OrderedJson make_result(const RunRecord& record) {
  const StrokeResponse& response = response_of(record);
  Json result = {
      {"flexopt", {{"format", result_format}, {"version", version()}, {"commit", commit()}}},
      {"job", Json(document_of(record.job))},
      {"status", record.status},
      {"message", record.message},
      {"verdict", verdict_json(verdict_of(record))},
      {"notes", record.job.notes},
      {"units", units_json(record.job, record.mechanism, record.job.request)},
      {"quantities",
       quantities_json(DriveList(record.mechanism, record.job.request), record.job.request)},
      {"conventions", conventions_json(record)},
      {"material", material_json(record.job.design.material)},
      {"stress_checks", stress_checks_json(record)},
      {"leaves", leaf_geometry_json(record.mechanism, record.job.model)},
      {"constraints", constraints_json(record.mechanism)},
      {"path",
       path_json(response, record.mechanism, record.job.request, errors_of_case(record, 0))}};
  if (std::string refined = refined_leaves(record.mechanism, record.job.model); !refined.empty())
    result["notes"].push_back(std::move(refined));
  if (record.job.request.state_space) result["state_space"] = signals_json(response);
  if (record.job.request.wants_frequency_derivatives())
    add_frequency_derivatives(response, record.mechanism, result);
  if (record.optimum)
    result["optimum"] = make_optimum(record.job, *record.optimum, record.mechanism);
  if (!record.errors.empty()) result["accuracy"] = accuracy_json(record);
  if (const auto& atlas = record.job.search_model.value_or(record.job.model).atlas)
    result["atlas"] = {{"contents", atlas->fingerprint()}, {"mesh", atlas->settings().mesh}};
  if (record.comparison)
    result["comparison"] = make_comparison_json(*record.comparison, record.mechanism);
  result["shapes"] = shapes_json(response, record.mechanism);
  if (!record.job.cases.empty() && !responses_of(record).empty()) {
    result["case"] = record.job.cases.front().name;  // the case of "path"
    result["extremes"] = extremes_json(record);
    result["cases"] = cases_json(record);
  }
  if (record.tolerances) result["tolerances"] = make_tolerances(record);
  if (record.assembly) result["assembly_tolerances"] = make_assembly(record);
  if (!record.maps.empty()) result["maps"] = make_maps(record);
  flag_non_finite(result);
  return result;
}

void write_timings(const std::filesystem::path& folder,
                   const std::map<std::string, double>& seconds) {
  write_file(folder / "timings.json", json_text({{"unit", "s"}, {"seconds", seconds}}));
}

bool usable(const OrderedJson& result) { return result.at("status") == "ok"; }

std::vector<std::string> check_expectations(const std::vector<Expectation>& expectations,
                                            OrderedJson& result) {
  OrderedJson list = OrderedJson::array();
  std::vector<std::string> failures;
  for (const Expectation& expected : expectations) {
    const Answer<double> value = number_at(result, expected.pointer);
    const bool ok = value && std::abs(*value - expected.value) <= expected.tolerance;
    if (!ok)
      failures.push_back(value ? fmt::format("{} = {}, expected {} ± {} ({})", expected.pointer,
                                             *value, expected.value, expected.tolerance,
                                             expected.source)
                               : value.error());
    list.push_back({{"pointer", expected.pointer},
                    {"expected", expected.value},
                    {"tolerance", expected.tolerance},
                    {"value", value ? Json(*value) : Json()},
                    {"ok", ok},
                    {"source", expected.source}});
  }
  if (expectations.empty()) return failures;
  result["expectations"] = std::move(list);
  if (!failures.empty() && result["status"] == "ok") {
    result["status"] = "expectation_failed";
    result["message"] = fmt::format("{} of {} expected numbers differ; first: {}.", failures.size(),
                                    expectations.size(), failures.front());
  }
  return failures;
}

Json signals_json(const StrokeResponse& response) {
  const StateSpace* model = first_model(response);
  if (!model) return nullptr;
  return {{"inputs", named_json(model->inputs)}, {"outputs", named_json(model->outputs)}};
}

Json state_space_json(const StateSpace& model) {
  return {{"omega2", std::vector<double>(model.omega2.begin(), model.omega2.end())},
          {"damping", std::vector<double>(model.damping.begin(), model.damping.end())},
          {"forces", rows_json(model.forces)},
          {"motions", rows_json(model.motions)},
          {"residual", rows_json(model.residual)}};
}

std::string state_space_script(const StrokeResponse& response, const std::string& title) {
  const StateSpace* first = first_model(response);
  if (!first) return "";
  std::string text = fmt::format(
      "% {}: linear models of small motions about points of the stroke, SI units.\n"
      "% models(k): stroke, frequencies [Hz], A, B, C, D, and sys where there is a control "
      "toolbox\n"
      "% (Octave: pkg load control). States: modal amplitudes, then their velocities.\n"
      "% ground.*: acceleration of the ground; outputs are relative to the ground.\n"
      "inputs = {};\ninput_units = {};\noutputs = {};\noutput_units = {};\nmodels = struct([]);\n",
      one_line(title), list_text(first->inputs, &Signal::name),
      list_text(first->inputs, &Signal::unit), list_text(first->outputs, &Signal::name),
      list_text(first->outputs, &Signal::unit));
  int count = 0;
  for (const PathPoint& point : response.path) {
    if (!point.state_space) continue;
    const StateSpace& model = *point.state_space;
    const auto add = [&](const char* field, const std::string& value, const char* comment) {
      text += fmt::format("models({}).{} = {};{}\n", count, field, value, comment);
    };
    const VectorXd strokes =
        VectorXd::Map(point.strokes.data(), static_cast<Eigen::Index>(point.strokes.size()));
    ++count;
    text += fmt::format("\n% point {} of the path\n", &point - response.path.data());
    add("stroke",
        strokes.size() > 0 ? matrix_text(strokes.transpose()) : csv::number_cell(point.stroke), "");
    add("omega2", matrix_text(model.omega2.transpose()), "  % squares of the circular frequencies");
    add("damping", matrix_text(model.damping.transpose()), "  % ratios");
    add("forces", matrix_text(model.forces), "  % of the inputs on the modes");
    add("motions", matrix_text(model.motions), "  % of the modes at the outputs");
    add("residual", matrix_text(model.residual),
        "  % static answers of the modes that are left out");
  }
  text +=
      "\nfor k = 1:numel(models)\n"
      "  w2 = models(k).omega2(:);\n  w = sqrt(abs(w2));\n  n = numel(w);\n"
      "  models(k).frequencies = sign(w2)' .* w' / (2*pi);\n"
      "  models(k).A = [zeros(n) eye(n); -diag(w2) -diag(2*models(k).damping(:).*w)];\n"
      "  models(k).B = [zeros(n, numel(inputs)); models(k).forces];\n"
      "  models(k).C = [models(k).motions zeros(numel(outputs), n)];\n"
      "  models(k).D = models(k).residual;\n"
      "  if exist('ss') > 0\n"
      "    models(k).sys = ss(models(k).A, models(k).B, models(k).C, models(k).D, ...\n"
      "                       'InputName', inputs(:), 'OutputName', outputs(:));\n"
      "  end\nend\nclear k n w w2\n";
  return text;
}

void write_state_space(const std::filesystem::path& folder, const StrokeResponse& response,
                       const std::string& title) {
  write_or_remove(folder / "state_space.m", state_space_script(response, title));
}

}  // namespace flexopt
