#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "optim/problem/goals.hpp"
#include "optim/problem/stroke_sensitivity.hpp"
#include "optim/solvers/parallel.hpp"
#include "results/files/result_json.hpp"
#include "results/files/scene.hpp"
#include "results/library/translated.hpp"
#include "results/report/report.hpp"

namespace flexopt::v0 {

struct Path::Impl {
  std::shared_ptr<const Result::Impl> run;
  std::size_t load_case = 0;
  std::vector<flexopt::Quantity> quantities;

  const RunRecord& record() const { return *run->run.record; }
  const StrokeResponse& response() const { return *responses_of(record())[load_case]; }
  const PathPoint& point(std::size_t k) const { return response().path.at(k); }
  const flexopt::Quantity& quantity(const std::string& name) const;
};

namespace {

Table table(const StrokeResponse& response, Vector3d PathPoint::*of) {
  Table all{response.path.size(), 3, {}};
  for (const PathPoint& point : response.path)
    all.numbers.insert(all.numbers.end(), (point.*of).begin(), (point.*of).end());
  return all;
}

/// Hands on what a run tells; throws Interrupted where it shall end.
class Listener : public RunListener {
 public:
  explicit Listener(const std::function<bool(const Progress&)>& told) : told_(told) {}
  void say(const std::string& text) override { tell({0, 0, text}); }
  void step(const RunStep& step) override {
    tell({step.done, step.total, step.text.empty() ? step.what : step.text});
  }

 private:
  void tell(const Progress& progress) {
    if (told_ && !told_(progress)) throw Interrupted{};
  }
  const std::function<bool(const Progress&)>& told_;
};

std::shared_ptr<const Result::Impl> finished(const Job& job, JobKind kind, const Options& options,
                                             const std::vector<std::string>& gradients) {
  return translated([&] {
    Listener listener(options.progress);
    const RunOptions how{options.folder, options.threads, gradients};
    try {
      return std::make_shared<const Result::Impl>(
          Result::Impl{run(as_kind(job.impl()->job, kind), how, listener), gradients});
    } catch (const Interrupted&) {
      throw Stopped("the progress function ended the run");
    }
  });
}

const flexopt::Optimum& optimum_of(const Result::Impl& impl) { return *impl.run.record->optimum; }

bool failed(const flexopt::Optimum& optimum) { return optimum.status == OptimumStatus::failed; }

}  // namespace

const flexopt::Quantity& Path::Impl::quantity(const std::string& name) const {
  const auto found = std::ranges::find(quantities, name, &flexopt::Quantity::name);
  if (found == quantities.end()) throw std::out_of_range("no quantity is called " + name);
  return *found;
}

std::string Path::name() const {
  return impl_->record().job.cases.empty() ? "" : impl_->record().job.cases[impl_->load_case].name;
}
std::size_t Path::size() const { return impl_->response().path.size(); }
std::string Path::status() const {
  return conclusion_of_case(impl_->record(), impl_->load_case).first;
}
std::string Path::message() const {
  return conclusion_of_case(impl_->record(), impl_->load_case).second;
}
bool Path::converged(std::size_t point) const {
  return impl_->point(point).status == PointStatus::converged;
}

std::vector<double> Path::stroke() const {
  std::vector<double> all;
  for (const PathPoint& point : impl_->response().path) all.push_back(point.stroke);
  return all;
}
Table Path::displacement() const { return table(impl_->response(), &PathPoint::displacement); }
Table Path::rotation() const { return table(impl_->response(), &PathPoint::rotation); }

std::array<double, 36> Path::compliance(std::size_t point, Drive drive) const {
  const PathPoint& at = impl_->point(point);
  const Matrix6d& matrix = drive == Drive::held ? at.compliance_locked : at.compliance_free;
  std::array<double, 36> rows{};
  for (std::size_t k = 0; k < rows.size(); ++k)
    rows[k] = matrix(static_cast<Eigen::Index>(k / 6), static_cast<Eigen::Index>(k % 6));
  return rows;
}

std::vector<double> Path::frequencies(std::size_t point, Drive drive) const {
  const PathPoint& at = impl_->point(point);
  return drive == Drive::held ? at.frequencies_locked : at.frequencies_free;
}

std::vector<std::string> Path::names() const {
  std::vector<std::string> all;
  for (const flexopt::Quantity& q : impl_->quantities)
    if (std::ranges::any_of(impl_->response().path,
                            [&](const PathPoint& point) { return q.value(point).has_value(); }))
      all.push_back(q.name);
  return all;
}

std::string Path::unit(const std::string& quantity) const { return impl_->quantity(quantity).unit; }

std::vector<std::optional<double>> Path::values(const std::string& quantity) const {
  const flexopt::Quantity& q = impl_->quantity(quantity);
  std::vector<std::optional<double>> all;
  for (const PathPoint& point : impl_->response().path) all.push_back(q.value(point));
  return all;
}

Table Path::gradient(const std::string& quantity) const {
  const flexopt::Quantity& q = impl_->quantity(quantity);
  const RunRecord& record = impl_->record();
  if (impl_->load_case >= record.gradients.size())
    throw NoGradient("none were asked for: Options::gradients");
  const StrokeGradients& gradients = record.gradients[impl_->load_case];
  const MatrixXd& through = impl_->run->run.through->by;
  Table all{size(), static_cast<std::size_t>(through.cols()), {}};
  for (std::size_t k = 0; k < size(); ++k) {
    const PathPoint& point = impl_->point(k);
    const auto along = q.value(point) ? q.gradient(point, gradients.path[k]) : std::nullopt;
    if (!along) throw NoGradient(quantity + " has no derivatives at point " + std::to_string(k));
    const VectorXd row = through.transpose() * *along;
    all.numbers.insert(all.numbers.end(), row.begin(), row.end());
  }
  return all;
}

std::string Result::status() const { return impl_->run.record->status; }
std::string Result::message() const { return impl_->run.record->message; }
std::string Result::json() const { return json_text(make_result(*impl_->run.record)); }
std::string Result::html() const {
  const RunRecord& record = *impl_->run.record;
  return make_report(make_result(record), make_scene(record));
}

std::vector<Path> Evaluation::paths() const {
  const RunRecord& record = *impl_->run.record;
  const auto quantities = flexopt::quantities(DriveList(record.mechanism, record.job.request));
  std::vector<Path> all;
  for (std::size_t k = 0; k < responses_of(record).size(); ++k)
    all.emplace_back(std::make_shared<const Path::Impl>(Path::Impl{impl_, k, quantities}));
  return all;
}

Path Evaluation::path() const {
  const std::vector<Path> all = paths();
  if (all.empty()) throw std::out_of_range("no design was found, so there is no path");
  return all.front();
}

std::vector<std::string> Evaluation::gradients_by() const { return impl_->gradients; }

std::optional<double> Optimum::objective() const {
  const flexopt::Optimum& optimum = optimum_of(*impl_);
  return failed(optimum) ? std::nullopt : std::optional(optimum.objective);
}

std::map<std::string, double> Optimum::parameters() const {
  const flexopt::Optimum& optimum = optimum_of(*impl_);
  return failed(optimum) ? std::map<std::string, double>{} : optimum.parameters;
}

std::vector<ConstraintAtOptimum> Optimum::constraints() const {
  std::vector<ConstraintAtOptimum> all;
  for (const ConstraintState& c : optimum_of(*impl_).constraints)
    all.push_back({c.label, c.value, c.min, c.max, c.margin, c.active});
  return all;
}

int Optimum::evaluations() const { return optimum_of(*impl_).evaluations; }

Evaluation evaluate(const Job& job, const Options& options) {
  Evaluation result(finished(job, JobKind::evaluate, options, options.gradients));
  const RunRecord& record = *result.impl()->run.record;
  if (!options.gradients.empty() && !record.no_gradients.empty() && result.usable())
    throw NoGradient(record.no_gradients);
  return result;
}

Optimum optimise(const Job& job, const Options& options) {
  return Optimum(finished(job, JobKind::optimise, options, {}));
}

Result compare(const Job& job, const Options& options) {
  return Result(finished(job, JobKind::compare, options, {}));
}

struct Problem::Impl {
  PosedGoals goals;
};

namespace {

VectorXd vector_of(const std::vector<double>& numbers) {
  return Eigen::Map<const VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

std::vector<double> numbers_of(const VectorXd& vector) { return {vector.begin(), vector.end()}; }

Goals goals_of(const PosedValues& values, bool gradient) {
  Goals goals;
  goals.ok = true;
  goals.f = values.f;
  goals.g = numbers_of(values.g);
  if (!gradient) return goals;
  goals.df = numbers_of(values.df);
  goals.dg = {goals.g.size(), goals.df.size(), {}};
  for (const auto& row : values.dg.rowwise())
    goals.dg.numbers.insert(goals.dg.numbers.end(), row.begin(), row.end());
  return goals;
}

}  // namespace

Problem::Problem(const Job& job, const Posing& posing)
    : impl_(translated([&] {
        return std::shared_ptr<const Impl>(
            new Impl{PosedGoals(job.impl()->job, posing.scaled, posing.pointwise)});
      })) {}

std::vector<std::string> Problem::names() const { return impl_->goals.names(); }
std::vector<double> Problem::start() const { return numbers_of(impl_->goals.start()); }
std::vector<double> Problem::lower() const { return numbers_of(impl_->goals.lower()); }
std::vector<double> Problem::upper() const { return numbers_of(impl_->goals.upper()); }
std::vector<std::string> Problem::constraint_names() const {
  return impl_->goals.constraint_names();
}
std::vector<double> Problem::constraint_lower() const {
  return numbers_of(impl_->goals.constraint_lower());
}
std::vector<double> Problem::constraint_upper() const {
  return numbers_of(impl_->goals.constraint_upper());
}

Goals Problem::at(const std::vector<double>& x, bool gradient) const {
  return translated([&] {
    try {
      return goals_of(*impl_->goals.at(vector_of(x), gradient), gradient);
    } catch (const NotConverged& error) {
      return Goals{false, error.what(), error.reached, 0, {}, {}, {}};
    } catch (const flexopt::NoGradient& error) {
      throw NoGradient(error.what());
    }
  });
}

std::map<std::string, double> Problem::parameters(const std::vector<double>& x) const {
  return translated([&] { return impl_->goals.parameters(vector_of(x)); });
}

}  // namespace flexopt::v0
