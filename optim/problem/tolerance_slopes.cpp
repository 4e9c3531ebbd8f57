#include <algorithm>
#include <cmath>

#include "optim/problem/robust_goals.hpp"

namespace flexopt {
namespace {

VectorXd variances(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes) {
  VectorXd list(slopes.size());
  for (Eigen::Index e = 0; e < slopes.size(); ++e) {
    const double deviation = slopes[e] * entries[static_cast<std::size_t>(e)].standard_deviation();
    list[e] = deviation * deviation;
  }
  return list;
}

}  // namespace

MatrixXd tolerance_changes(const std::vector<Tolerance>& entries,
                           const std::vector<std::string>& names,
                           const ParameterValues& parameters) {
  MatrixXd changes = MatrixXd::Zero(static_cast<Eigen::Index>(names.size()),
                                    static_cast<Eigen::Index>(entries.size()));
  for (std::size_t e = 0; e < entries.size(); ++e)
    for (const ToleranceTerm& term : entries[e].terms)
      if (const auto found = std::ranges::find(names, term.parameter); found != names.end())
        changes(found - names.begin(), static_cast<Eigen::Index>(e)) +=
            term.change_of(parameters.at(term.parameter));
  return changes;
}

double farthest(const ToleranceSlopes& slopes) { return slopes.cwiseAbs().sum(); }

double standard_deviation(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes) {
  return std::sqrt(variances(entries, slopes).sum());
}

VectorXd variance_shares(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes) {
  const VectorXd list = variances(entries, slopes);
  const double all = list.sum();
  return all > 0 ? VectorXd(list / all) : VectorXd::Zero(list.size());
}

}  // namespace flexopt
