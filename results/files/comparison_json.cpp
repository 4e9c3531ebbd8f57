// The object "comparison" of result.json.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "results/files/result_json.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

/// Strokes of several drives by their names.
Json strokes_json(const VectorXd& strokes, const std::vector<Drive>& drives) {
  Json json = Json::object();
  for (std::size_t k = 0; k < drives.size(); ++k)
    json[drives[k].name] = strokes[static_cast<Eigen::Index>(k)];
  return json;
}

Json figures_json(const std::optional<ErrorFigures>& figures,
                  const std::vector<ComparedDesign>& designs, const std::vector<Drive>& drives) {
  if (!figures) return {{"worst", nullptr}, {"p99", nullptr}, {"median", nullptr}, {"count", 0}};
  const Sample& sample = designs[static_cast<std::size_t>(figures->worst_design)].sample;
  const auto point = static_cast<std::size_t>(figures->worst_point);
  Json at = {{"design", figures->worst_design}, {"stroke", sample.stroke[point]}};
  if (point < sample.strokes.size()) at["strokes"] = strokes_json(sample.strokes[point], drives);
  return {{"worst", figures->worst},
          {"p99", figures->p99},
          {"median", figures->median},
          {"count", figures->count},
          {"worst_at", std::move(at)}};
}

Json errors_json(const ModelComparison& model, const std::vector<ComparedDesign>& designs,
                 const std::vector<Drive>& drives) {
  Json errors = Json::object();
  for (int q = 0; q < static_cast<int>(compared_names.size()); ++q) {
    const auto quantity = static_cast<Compared>(q);
    Json& json = errors[compared_names[static_cast<std::size_t>(q)]] =
        figures_json(error_figures(model.errors, quantity), designs, drives);
    if (quantity != Compared::support_stiffness) continue;
    Json by_direction = Json::object();
    for (int d = 0; d < 6; ++d)
      if (const auto figures = error_figures(model.errors, quantity, d))
        by_direction[std::string(direction_names[static_cast<std::size_t>(d)])] =
            figures_json(figures, designs, drives);
    json["by_direction"] = std::move(by_direction);
  }
  return errors;
}

/// One column each, one entry a design and stroke point: the largest error of each quantity there.
Json points_json(const ModelComparison& model, const std::vector<ComparedDesign>& designs,
                 const std::vector<Drive>& drives) {
  std::vector<std::vector<std::array<Json, compared_names.size()>>> worst(designs.size());
  for (std::size_t d = 0; d < designs.size(); ++d) worst[d].resize(designs[d].sample.stroke.size());
  for (const PointError& e : model.errors) {
    Json& cell = worst[static_cast<std::size_t>(e.design)][static_cast<std::size_t>(e.point)]
                      [static_cast<std::size_t>(index(e.quantity))];
    if (cell.is_null() || cell.get<double>() < e.value) cell = e.value;
  }
  Json columns = {{"design", Json::array()}, {"stroke", Json::array()}};
  const bool several = drives.size() > 1;
  if (several) columns["strokes"] = Json::array();
  for (const char* name : compared_names) columns[name] = Json::array();
  for (std::size_t d = 0; d < designs.size(); ++d)
    for (std::size_t i = 0; i < worst[d].size(); ++i) {
      if (std::ranges::all_of(worst[d][i], [](const Json& cell) { return cell.is_null(); }))
        continue;
      columns["design"].push_back(d);
      columns["stroke"].push_back(designs[d].sample.stroke[i]);
      if (several) columns["strokes"].push_back(strokes_json(designs[d].sample.strokes[i], drives));
      for (std::size_t q = 0; q < compared_names.size(); ++q)
        columns[compared_names[q]].push_back(worst[d][i][q]);
    }
  return columns;
}

/// The designs where something was not as asked for.
Json exceptions_json(const ModelComparison& model) {
  Json list = Json::array();
  for (std::size_t d = 0; d < model.designs.size(); ++d) {
    const ModelDesign& design = model.designs[d];
    if (!design.failed && design.fallback_points == 0) continue;
    list.push_back({{"design", d},
                    {"status", design.failed ? "failed" : "fallback"},
                    {"points", design.points},
                    {"fallback_points", design.fallback_points},
                    {"message", design.message},
                    {"fallback_reason", design.fallback_reason}});
  }
  return list;
}

Json sample_json(const ComparedDesign& design, std::size_t number) {
  const auto& stroke = design.sample.stroke;
  const auto furthest = std::ranges::max_element(stroke, {}, [](double s) { return std::abs(s); });
  return {{"design", number},
          {"status", design.failed ? "failed" : "ok"},
          {"message", design.message},
          {"parameters", design.sample.parameters},
          {"symbols", design.sample.symbols},
          {"largest_stroke", furthest == stroke.end() ? Json() : Json(*furthest)},
          {"points", design.points},
          {"unstable_points", design.unstable_points},
          {"length_over_width", design.length_over_width},
          {"thickness_over_length", design.thickness_over_length},
          {"width2_over_length_thickness", design.width2_over_length_thickness}};
}

}  // namespace

OrderedJson make_comparison_json(const Comparison& comparison, const Mechanism& mechanism) {
  Json models = Json::array(), samples = Json::array();
  for (const ModelComparison& model : comparison.models)
    models.push_back(
        {{"name", model.name},
         {"failures", model.failures},
         {"fallbacks", {{"designs", model.fallback_designs}, {"points", model.fallback_points}}},
         {"speed_up", optional_json(model.speed_up)},
         {"speed_up_with_reduction", optional_json(model.speed_up_with_reduction)},
         {"errors", errors_json(model, comparison.designs, mechanism.drives)},
         {"exceptions", exceptions_json(model)},
         {"points", points_json(model, comparison.designs, mechanism.drives)}});
  for (std::size_t d = 0; d < comparison.designs.size(); ++d)
    samples.push_back(sample_json(comparison.designs[d], d));
  return {{"designs", comparison.designs.size()}, {"failed_designs", comparison.failed_designs},
          {"evaluated", comparison.evaluated},    {"evaluations", comparison.evaluations},
          {"models", std::move(models)},          {"samples", std::move(samples)}};
}

}  // namespace flexopt
