// The object "comparison" of result.json.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "results/files/result_json.hpp"
#include "results/files/result_parts.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

Json figures_json(const std::optional<ErrorFigures>& figures,
                  const std::vector<ComparedDesign>& designs, const std::vector<Drive>& drives) {
  if (!figures) return {{"worst", nullptr}, {"p99", nullptr}, {"median", nullptr}, {"count", 0}};
  const Sample& sample = designs[figures->worst_design].sample;
  const auto point = static_cast<std::size_t>(figures->worst_point);
  Json at = {{"design", figures->worst_design}, {"stroke", sample.stroke[point]}};
  if (point < sample.strokes.size()) at["strokes"] = strokes_json(sample.strokes[point], drives);
  return {{"worst", figures->worst},
          {"p99", figures->p99},
          {"median", figures->median},
          {"count", figures->count},
          {"worst_at", std::move(at)}};
}

int missing_of(const ModelComparison& model, int quantity, int part = -1) {
  return static_cast<int>(std::ranges::count_if(model.missing, [&](const MissingNumber& m) {
    return m.quantity == quantity && (part < 0 || m.part == part);
  }));
}

Json errors_json(const ModelComparison& model, const Comparison& comparison,
                 const std::vector<Drive>& drives) {
  Json errors = Json::object();
  for (std::size_t k = 0; k < comparison.quantities.size(); ++k) {
    const ComparedQuantity& quantity = comparison.quantities[k];
    const int q = static_cast<int>(k);
    Json& json = errors[quantity.name] =
        figures_json(error_figures(model.errors, q), comparison.designs, drives);
    json["missing"] = missing_of(model, q);
    if (quantity.parts.empty()) continue;
    Json parts = Json::object();
    for (int d = 0; d < static_cast<int>(quantity.parts.size()); ++d) {
      const auto figures = error_figures(model.errors, q, d);
      const int missing = missing_of(model, q, d);
      if (!figures && missing == 0) continue;
      Json& part = parts[quantity.parts[d]] = figures_json(figures, comparison.designs, drives);
      part["missing"] = missing;
    }
    json[quantity.part_key] = std::move(parts);
  }
  return errors;
}

/// Columns with one entry for each design and stroke point: the largest error of each quantity
/// there.
Json points_json(const ModelComparison& model, const Comparison& comparison,
                 const std::vector<Drive>& drives) {
  const std::vector<ComparedDesign>& designs = comparison.designs;
  const std::size_t count = comparison.quantities.size();
  std::vector<std::vector<std::vector<Json>>> worst(designs.size());
  for (std::size_t d = 0; d < designs.size(); ++d)
    worst[d].assign(designs[d].sample.stroke.size(), std::vector<Json>(count));
  for (const PointError& e : model.errors) {
    Json& cell = worst[e.design][e.point][e.quantity];
    if (cell.is_null() || cell.get<double>() < e.value) cell = e.value;
  }
  Json columns = {{"design", Json::array()}, {"stroke", Json::array()}};
  const bool several = drives.size() > 1;
  if (several) columns["strokes"] = Json::array();
  for (const ComparedQuantity& quantity : comparison.quantities)
    columns[quantity.name] = Json::array();
  for (std::size_t d = 0; d < designs.size(); ++d)
    for (std::size_t i = 0; i < worst[d].size(); ++i) {
      if (std::ranges::all_of(worst[d][i], [](const Json& cell) { return cell.is_null(); }))
        continue;
      columns["design"].push_back(d);
      columns["stroke"].push_back(designs[d].sample.stroke[i]);
      if (several) columns["strokes"].push_back(strokes_json(designs[d].sample.strokes[i], drives));
      for (std::size_t q = 0; q < count; ++q)
        columns[comparison.quantities[q].name].push_back(worst[d][i][q]);
    }
  return columns;
}

/// The first number of a design that only one of both has, and how many there are.
std::string missing_text(const ModelComparison& model, const Comparison& comparison, int design) {
  const MissingNumber* first = nullptr;
  int count = 0;
  for (const MissingNumber& m : model.missing) {
    if (m.design != design) continue;
    if (count++ == 0) first = &m;
  }
  if (!first) return "";
  const ComparedQuantity& quantity = comparison.quantities[first->quantity];
  std::string name = quantity.name;
  if (first->part >= 0) name += "." + quantity.parts[first->part];
  std::string text = fmt::format(
      "{} number{} that only one of both has: first {} at point {}, which {} lacks", count,
      count == 1 ? "" : "s", name, first->point, first->in_model ? "the model" : "full accuracy");
  return first->reason.empty() ? text : text + ": " + first->reason;
}

/// The designs where something was not as asked for.
Json exceptions_json(const ModelComparison& model, const Comparison& comparison) {
  Json list = Json::array();
  for (std::size_t d = 0; d < model.designs.size(); ++d) {
    const ModelDesign& design = model.designs[d];
    const std::string missing = missing_text(model, comparison, static_cast<int>(d));
    if (!design.failed && design.fallback_points == 0 && missing.empty()) continue;
    list.push_back({{"design", d},
                    {"status", design.failed     ? "failed"
                               : missing.empty() ? "fallback"
                                                 : "missing_numbers"},
                    {"points", design.points},
                    {"fallback_points", design.fallback_points},
                    {"message", design.message},
                    {"fallback_reason", design.fallback_reason},
                    {"missing", missing}});
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
         {"errors", errors_json(model, comparison, mechanism.drives)},
         {"exceptions", exceptions_json(model, comparison)},
         {"points", points_json(model, comparison, mechanism.drives)}});
  for (std::size_t d = 0; d < comparison.designs.size(); ++d)
    samples.push_back(sample_json(comparison.designs[d], d));
  return {{"designs", comparison.designs.size()}, {"failed_designs", comparison.failed_designs},
          {"evaluated", comparison.evaluated},    {"evaluations", comparison.evaluations},
          {"models", std::move(models)},          {"samples", std::move(samples)}};
}

}  // namespace flexopt
