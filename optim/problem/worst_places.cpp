#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <optional>

#include "core/math/decompositions.hpp"
#include "optim/problem/worst_assembly_goals.hpp"
#include "optim/solvers/problem.hpp"
#include "optim/solvers/unit_points.hpp"

namespace flexopt {
namespace {

// A box of so many sides has few corners: all are looked at.
constexpr int few_sides = 4;
// A slope below that share of the number is none, as far as derivatives are known.
constexpr double flat = 1e-8;
// What a place inside the box is brought to.
constexpr double as_flat_as = 1e-10;
// Places that are nearer than this count as one.
constexpr double same_place = 1e-3;

class Places {
 public:
  Places(const BoxSearch& search, const std::vector<std::size_t>& kinds, const LookInBox& look)
      : search_(search), kinds_(kinds), look_(look) {}

  Answer<WorstPlaces, Why> find();

 private:
  struct Seen {
    VectorXd z;
    BoxLook look;
  };
  /// Evaluates the place z, once; nothing where there are no numbers, after which the search is
  /// over.
  const Seen* at(const VectorXd& z);
  bool look_around();
  std::size_t best(Eigen::Index number) const;
  double unit(Eigen::Index number) const;
  /// Whether no way within the box goes up by more than a share of the number.
  bool is_end(const Seen& seen, Eigen::Index number, double none = flat) const;
  bool climb(Eigen::Index number);
  bool look_at_bounds(Eigen::Index number);
  bool finish_inside(Eigen::Index number);
  std::vector<VectorXd> ends(Eigen::Index number) const;

  const BoxSearch& search_;
  const std::vector<std::size_t>& kinds_;
  const LookInBox& look_;
  std::vector<Seen> seen_;
  std::map<Eigen::Index, std::size_t> chosen_;  ///< the best place of a number, known better
  std::optional<Why> failed_;
};

const Places::Seen* Places::at(const VectorXd& z) {
  if (failed_) return nullptr;
  const auto known = std::ranges::find_if(seen_, [&](const Seen& s) { return s.z == z; });
  if (known != seen_.end()) return &*known;
  Answer<BoxLook, Why> look = look_(z);
  if (!look) {
    failed_ = std::move(look.error());
    return nullptr;
  }
  return &seen_.emplace_back(Seen{z, std::move(*look)});
}

bool Places::look_around() {
  const int n = search_.size;
  std::vector<VectorXd> starts{VectorXd::Zero(n)};
  for (const VectorXd& u : sobol_points(n, search_.starts, search_.seed))
    if (static_cast<int>(starts.size()) < search_.starts)
      starts.push_back((2 * u.array() - 1).matrix());
  for (const VectorXd& z : starts)
    if (!at(z)) return false;
  std::vector<VectorXd> corners;
  if (n <= few_sides) {
    for (int k = 0; k < 1 << n; ++k) {
      VectorXd& z = corners.emplace_back(n);
      for (int i = 0; i < n; ++i) z[i] = k >> i & 1 ? 1 : -1;
    }
  } else {
    for (std::size_t s = 0; s < starts.size(); ++s)
      for (std::size_t k = 0; k < kinds_.size(); ++k) {
        VectorXd z = seen_[s].z;
        const auto rate = seen_[s].look.rates.row(k);
        for (int i = 0; i < n; ++i)
          if (rate[i] != 0) z[i] = rate[i] > 0 ? 1 : -1;
        corners.push_back(std::move(z));
      }
  }
  return std::ranges::all_of(corners, [&](const VectorXd& z) { return at(z) != nullptr; });
}

std::size_t Places::best(Eigen::Index number) const {
  if (const auto known = chosen_.find(number); known != chosen_.end()) return known->second;
  std::size_t best = 0;
  for (std::size_t k = 1; k < seen_.size(); ++k)
    if (seen_[k].look.values[number] > seen_[best].look.values[number]) best = k;
  return best;
}

double Places::unit(Eigen::Index number) const {
  double largest = 1e-300;
  for (std::size_t k = 0; k < kinds_.size(); ++k)
    for (const Seen& s : seen_)
      if (kinds_[k] == kinds_[number]) largest = std::max(largest, std::abs(s.look.values[k]));
  return largest;
}

bool Places::is_end(const Seen& seen, Eigen::Index number, double none) const {
  none *= unit(number);
  for (Eigen::Index i = 0; i < seen.z.size(); ++i) {
    const double rate = seen.look.rates(number, i);
    if ((rate > none && seen.z[i] < 1) || (rate < -none && seen.z[i] > -1)) return false;
  }
  return true;
}

bool Places::climb(Eigen::Index number) {
  const double by = unit(number);
  Problem problem;
  problem.lower = VectorXd::Constant(search_.size, -1);
  problem.upper = VectorXd::Constant(search_.size, 1);
  problem.evaluate = [&](const VectorXd& z, bool) {
    Problem::Value value;
    const Seen* const here = at(z);
    value.ok = here != nullptr;
    if (!here) return value;
    value.f = -here->look.values[number] / by;
    value.df = -here->look.rates.row(number).transpose() / by;
    return value;
  };
  OptimiserOptions options;
  options.name = "LD_SLSQP";
  options.max_evaluations = 40;
  options.tolerance = 1e-6;
  minimise(problem, VectorXd(seen_[best(number)].z), options);
  return !failed_;
}

// A search may end where the number is hardly bent along a side, and least there: every side that
// is between its bounds is brought to them, the others kept.
bool Places::look_at_bounds(Eigen::Index number) {
  const VectorXd z = seen_[best(number)].z;
  for (Eigen::Index i = 0; i < z.size(); ++i)
    for (const double bound : {-1.0, 1.0}) {
      if (std::abs(z[i]) == 1) continue;
      VectorXd moved = z;
      moved[i] = bound;
      if (!at(moved)) return false;
    }
  return true;
}

// Newton's method along the sides that the best place lies between, its second derivatives from
// differences of the rates. A maximum is flat: where it ends the rates count, not the value.
bool Places::finish_inside(Eigen::Index number) {
  constexpr double h = 1e-4, rounding = 1e-8, level = 1e-6;
  std::size_t here = best(number);
  for (int step = 0; step < 4; ++step) {
    const VectorXd z = seen_[here].z;
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < z.size(); ++i)
      if (std::abs(z[i]) < 1) free.push_back(i);
    const VectorXd slope = seen_[here].look.rates.row(number).transpose()(free);
    if (free.empty() || slope.cwiseAbs().maxCoeff() < as_flat_as * unit(number)) break;
    const auto m = std::ssize(free);
    MatrixXd H(m, m);
    for (Eigen::Index j = 0; j < m; ++j) {
      VectorXd up = z, down = z;
      up[free[j]] += h;
      down[free[j]] -= h;
      const auto above = look_(up), below = look_(down);
      if (!above || !below) return true;
      H.col(j) = (above->rates.row(number) - below->rates.row(number)).transpose()(free) / (2 * h);
    }
    // Steps only along directions with a maximum; directions that are flat but for rounding have
    // none.
    const SymmetricEigen bent(-0.5 * (H + H.transpose()));
    VectorXd way = VectorXd::Zero(m);
    for (Eigen::Index j = 0; j < m; ++j)
      if (const double by = bent.eigenvalues()[j]; by > level * bent.eigenvalues().maxCoeff())
        way += bent.eigenvectors().col(j) * (bent.eigenvectors().col(j).dot(slope) / by);
    if (way.isZero(0)) break;
    VectorXd next = z;
    next(free) += way;
    const Seen* const there = at(next.cwiseMax(-1).cwiseMin(1));
    if (!there) return false;
    if (there->look.values[number] <
        seen_[best(number)].look.values[number] - rounding * unit(number))
      break;
    here = static_cast<std::size_t>(there - seen_.data());
    chosen_[number] = here;
  }
  return true;
}

std::vector<VectorXd> Places::ends(Eigen::Index number) const {
  const std::size_t first = best(number);
  std::vector<std::size_t> order{first};
  for (std::size_t k = 0; k < seen_.size(); ++k)
    if (k != first && is_end(seen_[k], number, as_flat_as)) order.push_back(k);
  std::stable_sort(order.begin() + 1, order.end(), [&](std::size_t a, std::size_t b) {
    return seen_[a].look.values[number] > seen_[b].look.values[number];
  });
  std::vector<VectorXd> places;
  for (const std::size_t k : order) {
    if (static_cast<int>(places.size()) == search_.places) break;
    if (std::ranges::all_of(places, [&](const VectorXd& z) {
          return (z - seen_[k].z).cwiseAbs().maxCoeff() > same_place;
        }))
      places.push_back(seen_[k].z);
  }
  return places;
}

Answer<WorstPlaces, Why> Places::find() {
  WorstPlaces found;
  bool whole = look_around();
  const auto count = std::ssize(kinds_);
  for (Eigen::Index k = 0; k < count && whole; ++k)
    for (std::size_t last = seen_.size(); whole && best(k) != last;) {
      whole = is_end(seen_[best(k)], k) || climb(k);
      last = best(k);
      whole = whole && look_at_bounds(k);
    }
  for (Eigen::Index k = 0; k < count && whole; ++k) whole = finish_inside(k);
  if (!whole) return BecauseOf(*failed_);
  for (Eigen::Index k = 0; k < count; ++k) found.places.push_back(ends(k));
  return found;
}

}  // namespace

Answer<WorstPlaces, Why> worst_places(const BoxSearch& search,
                                      const std::vector<std::size_t>& kinds,
                                      const LookInBox& look) {
  assert(search.size > 0 && search.places > 0);
  return Places(search, kinds, look).find();
}

}  // namespace flexopt
