#include "core/math/bordered_pencil.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "core/math/decompositions.hpp"
#include "core/math/symmetric_factor.hpp"
#include "core/math/work_limit.hpp"

namespace flexopt {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
// Tolerances relative to an eigenvalue: distance of values that count as neighbours; largest
// residual of a pair; distance beyond the last value at which the others are counted.
constexpr double next_to = 1e-3, largest_residual = 1e-12, beyond = 1e-7;

// Number of values that are among the first `count` or next to the last of these.
Eigen::Index with_neighbours(const VectorXd& values, int count) {
  Eigen::Index n = std::min<Eigen::Index>(count, values.size());
  while (n > 0 && n < values.size() && values[n] - values[n - 1] <= next_to * std::abs(values[n]))
    ++n;
  return n;
}

struct Pair {
  double value = 0;
  VectorXd border, inside;            ///< x, of unit mass
  VectorXd mass_border, mass_inside;  ///< M x

  void scale(double by) {
    for (VectorXd* part : {&border, &inside, &mass_border, &mass_inside}) *part *= by;
  }
};

double product(const Pair& a, const Pair& b) {
  return a.border.dot(b.mass_border) + a.inside.dot(b.mass_inside);
}

// The pencil with a border of unit stiffnesses.
class Iteration {
 public:
  explicit Iteration(const BorderedPencil& pencil)
      : unit_(pencil.K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse()),
        K_(unit_.asDiagonal() * pencil.K * unit_.asDiagonal()),
        M_(unit_.asDiagonal() * pencil.M * unit_.asDiagonal()),
        C_(pencil.C.transpose() * unit_.asDiagonal()),
        modes_(pencil.modes) {}

  int below(double sigma) {
    shift(sigma);
    return factor_.negative() + static_cast<int>((modes_.array() < sigma).count());
  }

  // Pairs from which an iteration begins: whole clusters of the border with these modes.
  std::vector<Pair> begin(const EigenPairs& pairs, const std::vector<Eigen::Index>& modes,
                          int wanted) const;
  // Makes a pair exact to rounding.
  bool refine(Pair& pair);
  // What of λ is rounding.
  double rounding(const Pair& pair) const {
    return epsilon * (pair.border.squaredNorm() +
                      pair.inside.cwiseAbs2().dot(modes_.cwiseAbs().cwiseMax(0.0)));
  }
  const VectorXd& unit() const { return unit_; }

 private:
  void shift(double sigma);
  void set_mass(Pair& pair) const {
    pair.mass_border.noalias() = M_ * pair.border;
    pair.mass_border.noalias() += C_.transpose() * pair.inside;
    pair.mass_inside = pair.inside;
    pair.mass_inside.noalias() += C_ * pair.border;
  }

  VectorXd unit_;
  MatrixXd K_, M_, C_;  ///< C: inside × border
  VectorXd modes_;
  double sigma_ = 0;
  VectorXd from_modes_;  ///< 1/(d − σ)
  MatrixXd weighted_, S_;
  SymmetricFactor factor_;
  VectorXd x_;
};

void Iteration::shift(double sigma) {
  sigma_ = sigma;
  from_modes_ = modes_.array() - sigma;
  for (double& x : from_modes_) {
    const double least = epsilon * std::abs(sigma) + std::numeric_limits<double>::min();
    x = 1 / (std::abs(x) < least ? std::copysign(least, x) : x);
  }
  weighted_ = (sigma * sigma * from_modes_).asDiagonal() * C_;
  S_ = K_ - sigma * M_;
  for (Eigen::Index j = 0; j < S_.cols(); ++j)
    for (Eigen::Index i = j; i < S_.rows(); ++i) S_(i, j) -= C_.col(i).dot(weighted_.col(j));
  factor_.compute(S_);
}

std::vector<Pair> Iteration::begin(const EigenPairs& found, const std::vector<Eigen::Index>& modes,
                                   int wanted) const {
  const auto border = K_.rows();
  const Eigen::Index count = with_neighbours(found.values, wanted);
  std::vector<Pair> pairs(static_cast<std::size_t>(count));
  for (Eigen::Index k = 0; k < count; ++k) {
    Pair& pair = pairs[k];
    pair.value = found.values[k];
    pair.border = found.vectors.col(k).head(border).cwiseQuotient(unit_);
    pair.inside = VectorXd::Zero(modes_.size());
    pair.inside(modes) = found.vectors.col(k).tail(modes.size());
    set_mass(pair);
    pair.scale(1 / std::sqrt(product(pair, pair)));
  }
  return pairs;
}

// (K − θ M) y = M x,  λ = θ + yᵀM x / yᵀM y: the residual of y then is sin(x, y) / |y|.
bool Iteration::refine(Pair& pair) {
  constexpr int most = 12;
  double beside = 0;  // of the value: at it the pencil may be singular to the last bit
  for (int k = 0; k < most; ++k) {
    check_work();
    shift(pair.value + beside);
    const VectorXd carried = pair.mass_inside.cwiseProduct(from_modes_);
    x_ = pair.mass_border;
    x_.noalias() += sigma_ * (C_.transpose() * carried);
    factor_.solve(x_);
    Pair next;
    next.border = x_;
    next.inside.noalias() = C_ * x_;
    next.inside = sigma_ * next.inside.cwiseProduct(from_modes_) + carried;
    set_mass(next);
    const double square = product(next, next), along = product(next, pair);
    if (!(square > 0) || !std::isfinite(square)) {
      if (beside != 0) return false;
      beside = 8 * epsilon * std::abs(pair.value) + std::numeric_limits<double>::min();
      continue;
    }
    const double by = 1 / std::sqrt(square), cosine = along * by,
                 residual = by * std::sqrt(std::max(4 * epsilon, 1 - cosine * cosine));
    next.value = sigma_ + along / square;
    next.scale(by);
    pair = std::move(next);
    if (residual <= largest_residual * std::abs(pair.value) + 4 * rounding(pair)) return true;
  }
  return false;
}

// M-orthonormal where values are next to each other; false where one pair was found twice.
bool separate(std::vector<Pair>& pairs) {
  for (std::size_t k = 1; k < pairs.size(); ++k) {
    bool changed = false;
    for (std::size_t j = k; j-- > 0;) {
      if (pairs[k].value - pairs[j].value > next_to * std::abs(pairs[k].value)) continue;
      const double along = product(pairs[k], pairs[j]);
      pairs[k].border -= along * pairs[j].border;
      pairs[k].inside -= along * pairs[j].inside;
      pairs[k].mass_border -= along * pairs[j].mass_border;
      pairs[k].mass_inside -= along * pairs[j].mass_inside;
      changed = true;
    }
    if (!changed) continue;
    const double square = product(pairs[k], pairs[k]);
    if (!(square > 0.25)) return false;
    pairs[k].scale(1 / std::sqrt(square));
  }
  return true;
}

}  // namespace

MatrixXd BorderedPencil::dense_stiffness() const {
  MatrixXd all = MatrixXd::Zero(size(), size());
  all.topLeftCorner(border(), border()) = K;
  all.diagonal().tail(modes.size()) = modes;
  return all;
}

MatrixXd BorderedPencil::dense_mass() const {
  MatrixXd all = MatrixXd::Identity(size(), size());
  all.topLeftCorner(border(), border()) = M;
  all.topRightCorner(border(), modes.size()) = C;
  all.bottomLeftCorner(modes.size(), border()) = C.transpose();
  return all;
}

BorderedPencil BorderedPencil::along(const MatrixXd& Z) const {
  return {Z.transpose() * K * Z, Z.transpose() * M * Z, modes, Z.transpose() * C};
}

BorderedPencil BorderedPencil::kept(const std::vector<int>& border_coordinates) const {
  return {K(border_coordinates, border_coordinates), M(border_coordinates, border_coordinates),
          modes, C(border_coordinates, Eigen::all)};
}

namespace {

// The lowest modes that are needed for `wanted` values, and those next to the last one.
std::vector<Eigen::Index> low_modes(const VectorXd& modes, int wanted) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(modes.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return modes[a] < modes[b]; });
  std::size_t kept = std::min(static_cast<std::size_t>(wanted) + 2, order.size());
  while (kept > 0 && kept < order.size() &&
         modes[order[kept]] - modes[order[kept - 1]] <= next_to * std::abs(modes[order[kept]]))
    ++kept;
  order.resize(kept);
  return order;
}

// All pairs of the border with these modes.
EigenPairs pairs_with(const BorderedPencil& pencil, const std::vector<Eigen::Index>& modes) {
  const BorderedPencil low{pencil.K, pencil.M, pencil.modes(modes), pencil.C(Eigen::all, modes)};
  return lowest_dense_pairs(low.dense_stiffness(), low.dense_mass(), low.size());
}

// Pairs by iteration from `start`; nothing where a pair is missing.
std::optional<EigenPairs> iterated(const BorderedPencil& pencil, const EigenPairs& start,
                                   const std::vector<Eigen::Index>& modes, int count) {
  Iteration iteration(pencil);
  std::vector<Pair> pairs = iteration.begin(start, modes, count);
  if (pairs.empty()) return std::nullopt;
  for (Pair& pair : pairs)
    if (!iteration.refine(pair)) return std::nullopt;
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.value < b.value; });
  if (!separate(pairs)) return std::nullopt;
  const Pair& last = pairs.back();
  const double sigma =
      last.value + beyond * std::abs(last.value) + iteration.rounding(last) / beyond;
  if (iteration.below(sigma) != static_cast<int>(pairs.size())) return std::nullopt;
  EigenPairs found{VectorXd(pairs.size()), MatrixXd(pencil.size(), pairs.size())};
  for (Eigen::Index k = 0; k < found.values.size(); ++k) {
    const Pair& pair = pairs[k];
    found.values[k] = pair.value;
    found.vectors.col(k) << pair.border.cwiseProduct(iteration.unit()), pair.inside;
  }
  return found;
}

// Pairs by the Cholesky factor of M: all values to the rounding of the largest, none lost below a
// soft one.
std::optional<EigenPairs> pairs_by_mass(const BorderedPencil& pencil) {
  const MatrixXd K = pencil.dense_stiffness(), M = pencil.dense_mass();
  const VectorXd s = M.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd Ms = s.asDiagonal() * M * s.asDiagonal();
  if (!Cholesky(Ms).positive_definite()) return std::nullopt;
  const SymmetricEigen eigen(s.asDiagonal() * K * s.asDiagonal(), Ms);
  return EigenPairs{eigen.eigenvalues(), s.asDiagonal() * eigen.eigenvectors()};
}

// A decomposition knows values to the rounding of the smallest or of the largest alone: each pair
// is made exact, and counted. Nothing where the count says that some are missing.
std::optional<EigenPairs> whole(const BorderedPencil& pencil, int count) {
  const EigenPairs all =
      lowest_dense_pairs(pencil.dense_stiffness(), pencil.dense_mass(), pencil.size());
  if (pencil.size() == 0) return all;
  std::vector<Eigen::Index> every(static_cast<std::size_t>(pencil.modes.size()));
  std::iota(every.begin(), every.end(), 0);
  if (auto exact = iterated(pencil, all, every, count)) return exact;
  if (auto start = pairs_by_mass(pencil)) return iterated(pencil, *start, every, count);
  return std::nullopt;
}

// Whether the pencil has so few more coordinates that an iteration does not pay.
bool is_small(const BorderedPencil& pencil, const std::vector<Eigen::Index>& modes) {
  return pencil.size() <= pencil.border() + static_cast<int>(modes.size()) + 2;
}

}  // namespace

std::optional<FreeAndHeldPairs> lowest_pairs(const BorderedPencil& pencil,
                                             const std::vector<int>& held, PairCounts counts) {
  if (held.empty()) {
    counts.free = std::max(counts.free, counts.held);
    counts.held = 0;
  }
  std::vector<int> kept;  // rows of the pairs with the others held
  for (int k = 0; k < pencil.size(); ++k)
    if (std::find(held.begin(), held.end(), k) == held.end()) kept.push_back(k);
  const std::vector<int> border(kept.begin(), kept.end() - pencil.modes.size());
  const BorderedPencil rest = counts.held > 0 ? pencil.kept(border) : BorderedPencil{};
  const std::vector<Eigen::Index> modes =
      low_modes(pencil.modes, std::max(counts.free, counts.held));
  std::optional<EigenPairs> free, at_rest;
  if (!is_small(pencil, modes)) {
    if (counts.free == 0) {
      at_rest = iterated(rest, pairs_with(rest, modes), modes, counts.held);
    } else {
      EigenPairs start = pairs_with(pencil, modes);
      free = iterated(pencil, start, modes, counts.free);
      if (counts.held > 0) {
        for (std::size_t k = 0; k < held.size(); ++k)
          start =
              held_pairs(start, held[k], k + 1 == held.size() ? counts.held + 2 : pencil.size());
        std::vector<int> rows = border;  // of the vectors that lead to those of the rest
        for (std::size_t k = 0; k < modes.size(); ++k)
          rows.push_back(pencil.border() + static_cast<int>(k));
        const EigenPairs left{start.values, start.vectors(rows, Eigen::all)};
        at_rest = iterated(rest, left, modes, counts.held);
      }
    }
  }
  FreeAndHeldPairs found;
  if (counts.free > 0) {
    if (!free) free = whole(pencil, counts.free);
    if (!free) return std::nullopt;
    found.free = std::move(*free);
  }
  if (held.empty()) found.held = found.free;
  if (counts.held > 0) {
    if (!at_rest) at_rest = whole(rest, counts.held);
    if (!at_rest) return std::nullopt;
    found.held = {at_rest->values, MatrixXd::Zero(pencil.size(), at_rest->vectors.cols())};
    found.held.vectors(kept, Eigen::all) = at_rest->vectors;
  }
  return found;
}

}  // namespace flexopt
