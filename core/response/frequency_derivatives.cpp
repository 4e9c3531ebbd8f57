#include "core/response/frequency_derivatives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/equilibrium/stroke_path.hpp"
#include "core/math/block_lanczos.hpp"
#include "core/response/exact_modes.hpp"
#include "core/response/leaf_models.hpp"
#include "core/response/mechanism_series.hpp"

namespace flexopt {
namespace {

// Frequencies nearer than this (relative, squared) are one repeated frequency.
constexpr double repeated = 1e-7;
// First derivatives below this share of ω², over a stroke of a leaf length or 1 rad, are zero by
// symmetry: what is left of them is the error of the modes.
constexpr double rounding = 1e-6;

struct Modes {
  VectorXd lambda;
  MatrixXd phi, M_phi;
};

using Range = std::pair<int, int>;  // [first, last)

// Runs of neighbours in `values` [first, last) no further apart than `gap`.
std::vector<Range> clusters(const VectorXd& values, int first, int last, double gap) {
  std::vector<Range> runs;
  for (int i = first; i < last; ++i)
    if (i > first && std::abs(values[i] - values[i - 1]) <= gap)
      runs.back().second = i + 1;
    else
      runs.push_back({i, i + 1});
  return runs;
}

// Enough modes to solve for those asked for: a few above, and whole clusters.
std::optional<Modes> lowest_modes(const MechanismFactor& factor, int count, int width, int& kept) {
  const auto solve = [&](const MatrixXd& B) { return factor.solve(B); };
  const auto mass = [&](const MatrixXd& B) { return factor.mass(B); };
  for (int guard = 3; guard <= 64; guard *= 2) {
    const LowestPairs pairs =
        lowest_pairs_of_blocks(factor.size(), count + guard, width, solve, mass, 1e-6);
    if (!pairs.converged) return std::nullopt;
    const VectorXd& l = pairs.values;
    kept = count;
    while (kept < l.size() && l[kept] - l[kept - 1] <= 10 * repeated * std::abs(l[kept])) ++kept;
    if (kept + 2 <= l.size() && l[l.size() - 1] > 1.05 * l[kept - 1])
      return Modes{l, pairs.vectors, mass(pairs.vectors)};
  }
  return std::nullopt;
}

struct Shifted {
  MatrixXd y, residual;
};

// y_i of (K − λ_i M) y_i = b_i without the modes of i's cluster: the known modes by their
// amplitudes, the rest by conjugate gradients preconditioned with K⁻¹ (all columns in step), until
// b·y + r·y is known to `tolerance`, r being the residual left.
std::optional<Shifted> solve_shifted(const MechanismFactor& factor, const Modes& modes,
                                     const std::vector<Range>& cluster_of, const MatrixXd& B,
                                     const VectorXd& tolerance) {
  const int p = static_cast<int>(B.cols());
  const auto complement = [&](MatrixXd& Y) {
    Y.noalias() -= modes.phi * (modes.M_phi.transpose() * Y).eval();
  };
  const MatrixXd b = modes.phi.transpose() * B;
  MatrixXd amplitude = b;
  for (int i = 0; i < p; ++i)
    for (int j = 0; j < b.rows(); ++j)
      amplitude(j, i) = j >= cluster_of[i].first && j < cluster_of[i].second
                            ? 0
                            : b(j, i) / (modes.lambda[j] - modes.lambda[i]);
  const MatrixXd R0 = B - modes.M_phi * b;
  MatrixXd Y = factor.solve(R0);
  complement(Y);
  const auto shift = modes.lambda.head(p).asDiagonal();
  const VectorXd size = R0.cwiseProduct(Y).colwise().sum().cwiseAbs();
  const VectorXd enough = tolerance.cwiseMax(1e-20 * size);  // or rounding
  MatrixXd R = factor.mass(Y) * shift;                       // K Y = R0
  MatrixXd Z = factor.solve(R), P, KP;
  complement(Z);
  VectorXd rz = R.cwiseProduct(Z).colwise().sum();
  P = Z;
  KP = R;
  for (int it = 0; it < 200; ++it) {
    if ((rz.array().abs() <= enough.array()).all()) return Shifted{Y + modes.phi * amplitude, R};
    const MatrixXd AP = KP - factor.mass(P) * shift;
    VectorXd alpha = VectorXd::Zero(p), beta = VectorXd::Zero(p);
    for (int i = 0; i < p; ++i)
      if (std::abs(rz[i]) > enough[i]) alpha[i] = rz[i] / P.col(i).dot(AP.col(i));
    Y += P * alpha.asDiagonal();
    R -= AP * alpha.asDiagonal();
    Z = factor.solve(R);
    complement(Z);
    const VectorXd next = R.cwiseProduct(Z).colwise().sum();
    for (int i = 0; i < p; ++i)
      if (alpha[i] != 0) beta[i] = next[i] / rz[i];
    for (int i = 0; i < p; ++i)
      if (alpha[i] != 0) rz[i] = next[i];
    P = Z + P * beta.asDiagonal();
    KP = R + KP * beta.asDiagonal();
  }
  return std::nullopt;
}

}  // namespace

FrequencyDerivativesResult frequency_derivatives(System& system, int count) {
  FrequencyDerivativesResult result;
  const MechanismFactor factor(system);
  int p = 0;
  std::optional<Modes> found = lowest_modes(factor, count, std::max(3, system.leaves()), p);
  if (!found) {
    result.message =
        fmt::format("the lowest {} modes of {} unknowns were not found", count, factor.size());
    return result;
  }
  Modes& modes = *found;
  MechanismSeries series(factor);
  series.expand_along_stroke();

  // (23), cluster by cluster
  Series<MatrixXd> K = series.tangent_times(modes.phi.leftCols(p)),
                   M = series.mass_times(modes.phi.leftCols(p));
  const auto lambda = modes.lambda.head(p).asDiagonal();
  MatrixXd B1 = K[1] - M[1] * lambda, B2 = K[2] - M[2] * lambda;
  // a stroke of 1 rad or a leaf length must change ω² by more than rounding
  const double unit = is_rotation(system.mechanism().drive) ? 1.0 : system.length();
  const auto noise = [&](int i) { return rounding * std::abs(modes.lambda[i]) / unit; };
  VectorXd first = VectorXd::Zero(p), second = VectorXd::Zero(p);
  std::vector<Range> cluster_of(p);
  const auto rotate = [&](int a, int size, const MatrixXd& U) {
    for (MatrixXd* m : {&modes.phi, &modes.M_phi, &B1, &B2, &M[1]})
      m->middleCols(a, size) = (m->middleCols(a, size) * U).eval();
  };
  std::vector<Range> families;  // equal frequency and equal first derivative
  for (const Range& c : clusters(modes.lambda, 0, p, repeated * modes.lambda.cwiseAbs()[p - 1])) {
    const int a = c.first, size = c.second - a;
    MatrixXd A = modes.phi.middleCols(a, size).transpose() * B1.middleCols(a, size);
    A = (0.5 * (A + A.transpose())).eval();
    if (size > 1) {
      const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
      rotate(a, size, eigen.eigenvectors());
      first.segment(a, size) = eigen.eigenvalues();
    } else {
      first[a] = A(0, 0);
    }
    for (int i = a; i < c.second; ++i) {
      if (std::abs(first[i]) < noise(i)) first[i] = 0;
      cluster_of[i] = c;
    }
    for (const Range& f : clusters(first, a, c.second, noise(a))) families.push_back(f);
  }

  const MatrixXd B = modes.M_phi.leftCols(p) * first.asDiagonal() - B1;
  std::optional<Shifted> modal = solve_shifted(
      factor, modes, cluster_of, B, 1e-6 / (unit * unit) * modes.lambda.head(p).cwiseAbs());
  if (!modal) {
    result.message = "the modal derivatives of the modes were not found in 200 iterations";
    return result;
  }
  // the residual anew: (24) is a small difference of large terms, and solving costs 8 digits
  modal->residual = B - series.tangent(modal->y) + factor.mass(modal->y) * lambda;
  // (24), family by family
  B2 -= M[1] * first.asDiagonal();
  for (const Range& f : families) {
    const int a = f.first, size = f.second - a;
    const auto phi = modes.phi.middleCols(a, size);
    MatrixXd A = phi.transpose() * B2.middleCols(a, size) +
                 B1.middleCols(a, size).transpose() * modal->y.middleCols(a, size) -
                 modal->residual.middleCols(a, size).transpose() * modal->y.middleCols(a, size);
    A = (0.5 * (A + A.transpose())).eval();
    if (size > 1) {
      const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
      rotate(a, size, eigen.eigenvectors());
      second.segment(a, size) = 2 * eigen.eigenvalues();
    } else {
      second[a] = 2 * A(0, 0);
    }
  }

  const int listed = std::min(count, p);
  std::vector<Mode> classified =
      classified_modes(factor, false, modes.lambda.head(listed), modes.phi.leftCols(listed),
                       modes.M_phi.leftCols(listed));
  for (int i = 0; i < listed; ++i) {
    FrequencyDerivatives d;
    d.index = i;
    d.omega2 = modes.lambda[i];
    d.d_omega2 = first[i];
    d.d2_omega2 = second[i];
    d.compliance = 1 / d.omega2;
    d.d_compliance = -d.d_omega2 / (d.omega2 * d.omega2);
    d.d2_compliance =
        (2 * d.d_omega2 * d.d_omega2 / d.omega2 - d.d2_omega2) / (d.omega2 * d.omega2);
    d.mode = std::move(classified[i]);
    result.modes.push_back(std::move(d));
  }
  result.ok = true;
  return result;
}

FrequencyDerivativesResult frequency_derivatives(const Mechanism& mechanism,
                                                 const ModelOptions& model, const Vector6d& load,
                                                 const NewtonOptions& newton, int count) {
  System system(mechanism, make_full_leaves(mechanism, model));
  system.assemble();
  if (!load.isZero()) {
    const Equilibrium loaded = step_load(system, load, newton);
    if (!loaded.converged) return {.ok = false, .message = loaded.message, .modes = {}};
  }
  return frequency_derivatives(system, count);
}

}  // namespace flexopt
