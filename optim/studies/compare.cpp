#include "optim/studies/compare.hpp"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/spec/spec_error.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/problem/evaluation_log.hpp"
#include "optim/problem/goals.hpp"
#include "optim/problem/line_log.hpp"
#include "optim/solvers/parallel.hpp"

namespace flexopt {

using nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

namespace {

/// evaluations.jsonl → evaluations.seconds.jsonl
std::filesystem::path seconds_log(const std::filesystem::path& log) {
  std::filesystem::path beside = log;
  return beside.replace_extension(".seconds.jsonl");
}

using Quantities = std::vector<ComparedQuantity>;

OrderedJson point_json(const Quantities& quantities, const ComparedPoint& p) {
  if (!p.converged) return {{"stroke", p.stroke}};
  OrderedJson numbers = OrderedJson::object(), reasons = OrderedJson::object();
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    OrderedJson& list = numbers[quantities[q].name] = OrderedJson::array();
    for (const auto& value : p.numbers[q]) list.push_back(value ? OrderedJson(*value) : nullptr);
    if (std::ranges::any_of(p.reasons[q], [](const std::string& r) { return !r.empty(); }))
      reasons[quantities[q].name] = p.reasons[q];
  }
  OrderedJson json{{"stroke", p.stroke},
                   {"numbers", std::move(numbers)},
                   {"stable", p.stable},
                   {"fallback", p.fallback}};
  if (!reasons.empty()) json["reasons"] = std::move(reasons);
  return json;
}

ComparedPoint read_point(const Quantities& quantities, const json& j) {
  ComparedPoint p;
  j.at("stroke").get_to(p.stroke);
  p.converged = j.contains("numbers");
  if (!p.converged) return p;
  for (const ComparedQuantity& quantity : quantities) {
    auto& numbers = p.numbers.emplace_back();
    for (const json& value : j.at("numbers").at(quantity.name))
      numbers.push_back(value.is_null() ? std::nullopt : std::optional(value.get<double>()));
    if (numbers.size() != quantity.numbers.size())
      throw std::out_of_range("other numbers of " + quantity.name);
    auto& reasons = p.reasons.emplace_back(numbers.size());
    if (j.contains("reasons") && j["reasons"].contains(quantity.name))
      reasons = j["reasons"][quantity.name].get<std::vector<std::string>>();
    if (reasons.size() != numbers.size())
      throw std::out_of_range("other reasons of " + quantity.name);
  }
  j.at("stable").get_to(p.stable);
  j.at("fallback").get_to(p.fallback);
  return p;
}

std::string line_of(const Quantities& quantities, const ComparedPath& path) {
  OrderedJson points = OrderedJson::array();
  for (const ComparedPoint& p : path.points) points.push_back(point_json(quantities, p));
  return log_line({{"design", path.design},
                   {"model", path.model},
                   {"message", path.message},
                   {"fallback_reason", path.fallback_reason},
                   {"points", std::move(points)}});
}

ComparedPath parse_line(const Quantities& quantities, const std::string& line) {
  const json j = json::parse(line);
  ComparedPath path;
  j.at("design").get_to(path.design);
  j.at("model").get_to(path.model);
  j.at("message").get_to(path.message);
  j.at("fallback_reason").get_to(path.fallback_reason);
  for (const json& point : j.at("points")) path.points.push_back(read_point(quantities, point));
  return path;
}

/// All design and model pairs of a job, known or not: design × (models + 1) + model.
struct Book {
  Quantities quantities;
  std::size_t width = 0;
  std::vector<std::optional<ComparedPath>> paths;
  std::vector<std::optional<EvaluationSeconds>> seconds;
  LineLog values_log, times_log;

  Book(const Job& job, std::size_t designs)
      : quantities(compared_quantities(job)),
        width(job.compare->models.size() + 1),
        paths(designs * width),
        seconds(designs * width) {}

  /// Opens both logs and reads what they hold.
  void open(const Job& job, const std::filesystem::path& log, const std::string& version,
            bool overwrite) {
    const json identity = log_identity(job, version);
    values_log.open(log, identity, overwrite, [&](const std::string& line) { read_path(line); });
    times_log.open(seconds_log(log), identity, overwrite,
                   [&](const std::string& line) { read_seconds(line); });
  }
  std::size_t place(int design, int model) const {
    const auto d = static_cast<std::size_t>(design), m = static_cast<std::size_t>(model);
    if (design < 0 || model < 0 || m >= width || d * width + m >= paths.size())
      throw std::out_of_range("no such design or model");
    return d * width + m;
  }
  void read_path(const std::string& line) {
    ComparedPath path = parse_line(quantities, line);
    paths[place(path.design, path.model)] = std::move(path);
  }
  void read_seconds(const std::string& line) {
    const json j = json::parse(line);
    seconds[place(j.at("design"), j.at("model"))] =
        EvaluationSeconds{j.at("path").get<double>(), j.at("total").get<double>()};
  }
};

/// Adds a load case; what it says is said with its name.
void append(StrokeResponse of_case, const std::string& name, StrokeResponse& whole) {
  std::ranges::move(of_case.path, std::back_inserter(whole.path));
  whole.seconds_path += of_case.seconds_path;
  const bool worse = of_case.status != Status::ok && whole.status == Status::ok;
  if (worse || whole.message.empty()) {
    whole.status = of_case.status;
    whole.message = (name.empty() ? "" : "load case " + name + ": ") + of_case.message;
  }
}

ComparedPath evaluate(const Job& job, const Sample& sample, int design, int model,
                      const Quantities& quantities, const StrokeEvaluator& evaluator,
                      EvaluationSeconds& seconds) {
  if (!sample.refused.empty()) return {design, model, sample.refused};
  const CompareSpec& spec = *job.compare;
  const ModelChoice& choice = model == 0 ? spec.full : spec.models[model - 1];
  const auto begin = std::chrono::steady_clock::now();
  try {
    const Mechanism mechanism = make_mechanism(job, sample.parameters);
    StrokeResponse whole;  // all load cases one after the other
    auto first = sample.stroke.begin();
    for (const JobCase& one : cases_of(job)) {
      StrokeRequest request = one.request;
      const auto last = first + std::ssize(request.points);
      request.points.assign(first, last);
      first = last;
      request.newton = choice.newton;
      request.outputs = needs_of(quantities);
      append(evaluator(mechanism, choice.model, request), one.name, whole);
    }
    add_defined_quantities(job, complete_numbers(job, sample.parameters), whole);
    seconds = {whole.seconds_path, seconds_since(begin)};
    return compared_path(design, model, quantities, whole);
  } catch (const SpecError& error) {
    return {design, model, error.what()};
  }
}

std::string seconds_line(int design, int model, const EvaluationSeconds& seconds) {
  return log_line(
      {{"design", design}, {"model", model}, {"path", seconds.path}, {"total", seconds.total}});
}

/// What all paths say, which are in the logs from then on in the order of the designs.
CompareRun concluded(const Job& job, Book& book) {
  const int width = static_cast<int>(book.width);
  CompareRun run;
  run.seconds.resize(book.width);
  std::vector<std::string> values, seconds;
  for (std::size_t k = 0; k < book.paths.size(); ++k) {
    values.push_back(line_of(book.quantities, *book.paths[k]));
    if (!book.seconds[k]) continue;
    run.seconds[k % book.width] += *book.seconds[k];
    seconds.push_back(
        seconds_line(static_cast<int>(k) / width, static_cast<int>(k) % width, *book.seconds[k]));
  }
  book.times_log.finish(seconds);
  book.values_log.finish(values);
  run.comparison = make_comparison(job, book.paths, book.seconds);
  return run;
}

}  // namespace

void check_compare_log(const Job& job, const std::filesystem::path& log,
                       const std::string& version) {
  Book book(job, make_samples(job).size());
  book.open(job, log, version, false);
}

CompareRun compare(const Job& job, const CompareOptions& options) {
  assert(job.compare);
  const std::vector<Sample> samples = make_samples(job);
  Book book(job, samples.size());
  if (!options.log.empty()) book.open(job, options.log, options.version, options.overwrite_log);
  Sharing nobody;
  Sharing& sharing = options.sharing ? *options.sharing : nobody;
  const int width = static_cast<int>(book.width);
  const auto known = [&](int k) {
    const auto& path = book.paths[k];
    return path ? std::optional(!path->whole()) : std::nullopt;
  };
  const auto work = [&](int k) {
    const int design = k / width, model = k % width;
    EvaluationSeconds seconds;
    const ComparedPath path =
        evaluate(job, samples[design], design, model, book.quantities, options.evaluator, seconds);
    return seconds_line(design, model, seconds) + line_of(book.quantities, path);
  };
  const auto keep = [&](const std::string& lines) {
    const std::size_t second = lines.find('\n') + 1;
    const std::string seconds = lines.substr(0, second), values = lines.substr(second);
    book.times_log.append(seconds);  // first: never without it
    book.values_log.append(values);
    book.read_seconds(seconds);
    book.read_path(values);
  };
  const bool complete = sharing.run({"evaluations", static_cast<int>(book.paths.size()),
                                     options.threads, known, work, keep, options.progress});
  if (sharing.shard()) throw ShardEnds();
  if (!complete) return {};

  return concluded(job, book);
}

Comparison compare_logged(const Job& job, const std::filesystem::path& log) {
  assert(job.compare);
  Book book(job, make_samples(job).size());
  try {
    for (const std::string& line : read_log_lines(log)) book.read_path(line);
    for (const std::string& line : read_log_lines(seconds_log(log))) book.read_seconds(line);
  } catch (const SpecError&) {
    throw;  // a line that does not fit its checksum
  } catch (const std::exception& error) {
    throw SpecError("", log.string(), std::string("expected evaluations: ") + error.what());
  }
  return make_comparison(job, book.paths, book.seconds);
}

}  // namespace flexopt
