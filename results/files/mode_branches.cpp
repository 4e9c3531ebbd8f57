#include <algorithm>

#include "results/files/scene.hpp"

namespace flexopt {

namespace {

constexpr double least_likeness = 0.3;

double likeness(const VectorXd& a, const VectorXd& b) {
  const Eigen::Index rows = std::min(a.size(), b.size());
  const double size = a.head(rows).squaredNorm() * b.head(rows).squaredNorm();
  if (size <= 0) return 0;
  const double product = a.head(rows).dot(b.head(rows));
  return product * product / size;
}

struct Pair {
  double likeness;
  std::size_t before, now;
};

}  // namespace

std::vector<std::vector<int>> mode_branches(const std::vector<PathPoint>& path, DriveState drive) {
  std::vector<std::vector<int>> branches(path.size());
  const std::vector<Mode>* before = nullptr;
  const std::vector<int>* known = nullptr;
  int count = 0;
  for (std::size_t p = 0; p < path.size(); ++p) {
    const std::vector<Mode>& now =
        drive == DriveState::locked ? path[p].modes_locked : path[p].modes_free;
    if (now.empty()) continue;
    std::vector<int>& own = branches[p];
    own.assign(now.size(), -1);
    std::vector<Pair> pairs;
    for (std::size_t i = 0; before && i < before->size(); ++i)
      for (std::size_t k = 0; k < now.size(); ++k)
        if (const double c = likeness((*before)[i].motion, now[k].motion); c > least_likeness)
          pairs.push_back({c, i, k});
    std::ranges::stable_sort(pairs, std::greater<>(), &Pair::likeness);
    std::vector<bool> taken(before ? before->size() : 0, false);
    for (const Pair& pair : pairs)
      if (own[pair.now] < 0 && !taken[pair.before]) {
        own[pair.now] = (*known)[pair.before];
        taken[pair.before] = true;
      }
    for (int& branch : own)
      if (branch < 0) branch = count++;
    before = &now;
    known = &own;
  }
  return branches;
}

}  // namespace flexopt
