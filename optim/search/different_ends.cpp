#include <algorithm>
#include <cmath>

#include "optim/search/stages.hpp"

namespace flexopt {

bool objectives_agree(double a, double b) {
  constexpr double near = 1e-3;
  return std::abs(a - b) <= near * std::abs(b);
}

std::vector<std::vector<int>> different_ends(const std::vector<const Candidate*>& ends,
                                             bool maximise, double feasible_within) {
  constexpr double near = 0.05;
  const auto end = [&](int i) -> const Candidate& { return *ends[static_cast<std::size_t>(i)]; };
  const auto feasible = [&](int i) { return end(i).violation <= feasible_within; };
  std::vector<int> order;
  for (int i = 0; i < static_cast<int>(ends.size()); ++i)
    if (ends[static_cast<std::size_t>(i)]) order.push_back(i);
  std::ranges::stable_sort(order, [&](int i, int j) {
    return better({end(i).objective, end(i).violation}, {end(j).objective, end(j).violation},
                  maximise, feasible_within);
  });
  std::vector<std::vector<int>> groups;
  for (const int i : order) {
    const auto same = std::ranges::find_if(groups, [&](const std::vector<int>& group) {
      const int best = group.front();
      return feasible(i) == feasible(best) &&
             objectives_agree(end(i).objective, end(best).objective) &&
             (end(i).x - end(best).x).lpNorm<Eigen::Infinity>() <= near;
    });
    if (same != groups.end())
      same->push_back(i);
    else
      groups.push_back({i});
  }
  return groups;
}

}  // namespace flexopt
