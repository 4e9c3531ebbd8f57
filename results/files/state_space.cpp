#include <fmt/format.h>

#include <algorithm>

#include "results/files/csv.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_parts.hpp"

namespace flexopt {
namespace {

using Json = OrderedJson;

const StateSpace* first_model(const StrokeResponse& response) {
  for (const PathPoint& point : response.path)
    if (point.state_space) return &*point.state_space;
  return nullptr;
}

Json list_json(const std::vector<Signal>& signals) {
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

Json signals_json(const StrokeResponse& response) {
  const StateSpace* model = first_model(response);
  if (!model) return nullptr;
  return {{"inputs", list_json(model->inputs)}, {"outputs", list_json(model->outputs)}};
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
    const VectorXd strokes =
        VectorXd::Map(point.strokes.data(), static_cast<Eigen::Index>(point.strokes.size()));
    text += fmt::format(
        "\n% point {} of the path\nmodels({}).stroke = {};\n"
        "models({}).omega2 = {};  % squares of the circular frequencies\n"
        "models({}).damping = {};  % ratios\n"
        "models({}).forces = {};  % of the inputs on the modes\n"
        "models({}).motions = {};  % of the modes at the outputs\n"
        "models({}).residual = {};  % static answers of the modes that are left out\n",
        &point - response.path.data(), ++count,
        strokes.size() > 0 ? matrix_text(strokes.transpose()) : csv::number_cell(point.stroke),
        count, matrix_text(model.omega2.transpose()), count, matrix_text(model.damping.transpose()),
        count, matrix_text(model.forces), count, matrix_text(model.motions), count,
        matrix_text(model.residual));
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
