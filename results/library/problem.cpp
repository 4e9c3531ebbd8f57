#include "results/library/runs.hpp"
#include "results/library/translated.hpp"

namespace flexopt::v0 {

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
