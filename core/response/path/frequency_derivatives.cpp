#include "core/response/path/frequency_derivatives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "core/equilibrium/stroke_path.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/work_limit.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/modes/full_modes.hpp"
#include "core/response/path/mechanism_series.hpp"

namespace flexopt {
namespace {

// First derivatives of ω² that differ by less than this share of ω² over a stroke of a leaf length
// or 1 rad are equal; smaller ones are zero by symmetry, and what is computed is the error of the
// modes.
constexpr double rounding = 1e-6;

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

// y_i of (K − λ_i M) y_i = b_i without the modes of i's cluster: the known modes by their
// amplitudes, the rest by conjugate gradients preconditioned with K⁻¹ (all columns in step), until
// b·y + r·y, r being the residual left, is known to `tolerance` or to the share `relative` of the
// energy.
std::optional<MatrixXd> solve_shifted(const MechanismFactor& factor, const LowModes& modes,
                                      const std::vector<Range>& cluster_of, const MatrixXd& B,
                                      const VectorXd& tolerance, double relative) {
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
  const VectorXd enough = tolerance.cwiseMax(relative * size);
  MatrixXd R = factor.mass(Y) * shift;  // K Y = R0
  MatrixXd Z = factor.solve(R), P, KP;
  complement(Z);
  VectorXd rz = R.cwiseProduct(Z).colwise().sum();
  P = Z;
  KP = R;
  for (int it = 0; it < 200; ++it) {
    check_work();
    if ((rz.array().abs() <= enough.array()).all()) return Y + modes.phi * amplitude;
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

// B_i − (K − λ_i M) y_i, with K multiplied out: solving costs it 8 digits.
MatrixXd shifted_residual(const MechanismFactor& factor, const MechanismSeries& series,
                          const VectorXd& lambda, const MatrixXd& B, const MatrixXd& y) {
  return B - series.tangent_times(y, 1)[0] + factor.mass(y) * lambda.head(y.cols()).asDiagonal();
}

// Solves the shifted system to rounding, in two rounds that gain 7 digits each.
std::optional<MatrixXd> solve_shifted_exactly(const MechanismFactor& factor,
                                              const MechanismSeries& series, const LowModes& modes,
                                              const std::vector<Range>& cluster_of,
                                              const MatrixXd& B) {
  MatrixXd y = MatrixXd::Zero(B.rows(), B.cols());
  for (int round = 0; round < 2; ++round) {
    const auto more = solve_shifted(factor, modes, cluster_of,
                                    shifted_residual(factor, series, modes.lambda, B, y),
                                    VectorXd::Zero(B.cols()), 1e-14);
    if (!more) return std::nullopt;
    y += *more;
  }
  return y;
}

// The lowest modes along the stroke: coefficients of λ(s) and φ(s), M-orthonormal at the start.
struct ModeSeries {
  LowModes modes;
  std::vector<Range> cluster_of;  ///< equal frequencies, mode by mode
  VectorXd first, second;         ///< λ1, λ2
  MatrixXd rate;                  ///< φ1, without the modes of the cluster
  Series<MatrixXd> K_phi, M_phi;  ///< K(s) φ0, M(s) φ0
  // (K1 − λ0 M1) φ0 of some modes.
  MatrixXd first_forces(int a, int size) const {
    return K_phi[1].middleCols(a, size) -
           M_phi[1].middleCols(a, size) * modes.lambda.segment(a, size).asDiagonal();
  }
  VectorXd diagonalise(const Range& range, const MatrixXd& A);
};

// Turns the modes of a range to the eigenvectors of A, which is symmetric but for rounding; its
// eigenvalues.
VectorXd ModeSeries::diagonalise(const Range& range, const MatrixXd& A) {
  const int a = range.first, size = range.second - a;
  const MatrixXd symmetric = 0.5 * (A + A.transpose());
  if (size == 1) return symmetric.col(0);
  const SymmetricEigen eigen(symmetric);
  const auto turn = [&](MatrixXd& m) {
    if (m.cols() > a) m.middleCols(a, size) = (m.middleCols(a, size) * eigen.eigenvectors()).eval();
  };
  for (MatrixXd* m : {&modes.phi, &modes.M_phi, &rate}) turn(*m);
  for (int o = 0; o < 3; ++o) {
    turn(K_phi[o]);
    turn(M_phi[o]);
  }
  return eigen.eigenvalues();
}

// (S3), cluster by cluster. Returns the families: modes of equal frequency and equal first
// derivative.
std::vector<Range> set_first(double unit, bool for_gradients, ModeSeries& path) {
  const VectorXd& lambda = path.modes.lambda;
  const int p = path.modes.kept;
  // a stroke of 1 rad or a leaf length must change ω² by more than rounding
  const auto noise = [&](int i) { return rounding * std::abs(lambda[i]) / unit; };
  std::vector<Range> families;
  for (const Range& c : clusters(lambda, 0, p, repeated_frequency * lambda.cwiseAbs()[p - 1])) {
    const int a = c.first, size = c.second - a;
    path.first.segment(a, size) = path.diagonalise(
        c, path.modes.phi.middleCols(a, size).transpose() * path.first_forces(a, size));
    for (int i = a; i < c.second; ++i) {
      if (!for_gradients && std::abs(path.first[i]) < noise(i)) path.first[i] = 0;
      path.cluster_of[i] = c;
    }
    for (const Range& f : clusters(path.first, a, c.second, noise(a))) families.push_back(f);
  }
  return families;
}

// (S3), (S4)
Answer<ModeSeries> mode_series(const MechanismFactor& factor, const MechanismSeries& series,
                               double unit, LowModes found, bool for_gradients) {
  ModeSeries result{std::move(found), {}, {}, {}, {}, {}, {}};
  const LowModes& modes = result.modes;
  const int p = modes.kept;
  Series<MatrixXd>&K = result.K_phi, &M = result.M_phi;
  K = series.tangent_times(modes.phi.leftCols(p));
  M = series.mass_times(modes.phi.leftCols(p));
  result.first = result.second = VectorXd::Zero(p);
  result.cluster_of.resize(p);
  const std::vector<Range> families = set_first(unit, for_gradients, result);

  const auto lambda = modes.lambda.head(p).asDiagonal();
  const MatrixXd B =
      modes.M_phi.leftCols(p) * result.first.asDiagonal() - result.first_forces(0, p);
  std::optional<MatrixXd> modal =
      for_gradients ? solve_shifted_exactly(factor, series, modes, result.cluster_of, B)
                    : solve_shifted(factor, modes, result.cluster_of, B,
                                    1e-6 / (unit * unit) * modes.lambda.head(p).cwiseAbs(), 1e-20);
  if (!modal) return Because("the modal derivatives of the modes were not found in 200 iterations");
  result.rate = std::move(*modal);
  // (S4), family by family: a small difference of large terms
  const MatrixXd B2 = K[2] - M[2] * lambda - M[1] * result.first.asDiagonal(),
                 beside = result.first_forces(0, p) -
                          shifted_residual(factor, series, modes.lambda, B, result.rate),
                 phi = modes.phi.leftCols(p), rate = result.rate;
  for (const Range& f : families) {
    const int a = f.first, size = f.second - a;
    result.second.segment(a, size) = result.diagonalise(
        f, phi.middleCols(a, size).transpose() * B2.middleCols(a, size) +
               beside.middleCols(a, size).transpose() * rate.middleCols(a, size));
  }
  return result;
}

// φ2: (K − λ0 M) φ2 = −(K1 − λ0 M1 − λ1 M) φ1 − (K2 − λ0 M2 − λ1 M1 − λ2 M) φ0
std::optional<MatrixXd> second_rates(const MechanismFactor& factor, const MechanismSeries& series,
                                     const ModeSeries& path, const Series<MatrixXd>& K_rate,
                                     const Series<MatrixXd>& M_rate) {
  const int p = path.modes.kept;
  const auto l0 = path.modes.lambda.head(p).asDiagonal();
  const auto l1 = path.first.asDiagonal(), l2 = path.second.asDiagonal();
  const MatrixXd B = -(K_rate[1] - M_rate[1] * l0 - M_rate[0] * l1) -
                     (path.K_phi[2] - path.M_phi[2] * l0 - path.M_phi[1] * l1 - path.M_phi[0] * l2);
  return solve_shifted_exactly(factor, series, path.modes, path.cluster_of, B);
}

// Derivatives along the design: (S8)–(S10) of the modes φ(s), over φᵀMφ(s), in powers of s.
std::optional<std::vector<FrequencyDerivativeGradients>> gradients_of(const MechanismFactor& factor,
                                                                      const MechanismSeries& series,
                                                                      const ModeSeries& path,
                                                                      const ExactDerivatives& exact,
                                                                      int listed) {
  const int p = path.modes.kept;
  const Series<MatrixXd> K_rate = series.tangent_times(path.rate, 2),
                         M_rate = series.mass_times(path.rate, 2);
  const auto second = second_rates(factor, series, path, K_rate, M_rate);
  if (!second) return std::nullopt;
  const auto phi = path.modes.phi.leftCols(p);
  const Eigen::MatrixX<Jet> Y = jets(Series<MatrixXd>{phi, path.rate, *second}).leftCols(listed);
  Eigen::VectorX<Jet> lambda(listed), size(listed);
  for (int i = 0; i < listed; ++i) {
    const VectorXd f0 = phi.col(i), f1 = path.rate.col(i), f2 = second->col(i);
    lambda[i] = {path.modes.lambda[i], path.first[i], path.second[i]};
    size[i] = {f0.dot(path.M_phi[0].col(i)),
               f0.dot(path.M_phi[1].col(i)) + 2 * f1.dot(path.M_phi[0].col(i)),
               f0.dot(path.M_phi[2].col(i)) + 2 * f1.dot(path.M_phi[1].col(i)) +
                   f1.dot(M_rate[0].col(i)) + 2 * f2.dot(path.M_phi[0].col(i))};
  }
  const DesignRates<Jet> design(factor, series.leaf_gradients(exact.design->rates), series.path(),
                                exact.design->list, exact.model);
  const Eigen::MatrixX<Jet> state_rates = series.balance(-design.residual()),
                            rates = design.quadratic(Y, lambda, state_rates);
  std::vector<FrequencyDerivativeGradients> gradients;
  for (int i = 0; i < listed; ++i) {
    FrequencyDerivativeGradients& g = gradients.emplace_back();
    g.omega2 = g.d_omega2 = g.d2_omega2 = VectorXd::Zero(rates.cols());
    for (Eigen::Index k = 0; k < rates.cols(); ++k) {
      const Jet rate = rates(i, k) / size[i];
      g.omega2[k] = rate.c[0];
      g.d_omega2[k] = rate.c[1];
      g.d2_omega2[k] = 2 * rate.c[2];
    }
  }
  return gradients;
}

// Share of these strokes at which the first of them is 1 rad or a leaf length.
double unit_of(const System& system, const VectorXd& strokes) {
  double largest = 0;
  for (Eigen::Index k = 0; k < strokes.size(); ++k) {
    const Drive& drive = system.mechanism().drives[k];
    largest = std::max(
        largest, std::abs(strokes[k]) / (is_rotation(drive.direction) ? 1.0 : system.length()));
  }
  return 1 / largest;
}

struct AlongStrokes {
  std::vector<FrequencyDerivatives> modes;
  std::vector<FrequencyDerivativeGradients> gradients;
};

// Derivatives along strokes that grow in proportion, from rest to `strokes` at 1.
Answer<AlongStrokes> along_strokes(const MechanismFactor& factor, const VectorXd& strokes,
                                   int count, const ExactDerivatives* exact, LowModes found) {
  Answer<MechanismSeries> made = MechanismSeries::of(factor);
  if (!made) return Because(made.error());
  MechanismSeries& series = *made;
  AlongStrokes result;
  series.expand_along_strokes(strokes);
  const auto path = mode_series(factor, series, unit_of(factor.system(), strokes), std::move(found),
                                exact != nullptr);
  if (!path) return Because(path.error());
  const int listed = std::min(count, path->modes.kept);
  std::vector<Mode> classified =
      classified_modes(factor, false, path->modes.lambda.head(listed),
                       path->modes.phi.leftCols(listed), path->modes.M_phi.leftCols(listed));
  for (int i = 0; i < listed; ++i) {
    FrequencyDerivatives& d = result.modes.emplace_back();
    d.index = i;
    d.omega2 = path->modes.lambda[i];
    d.d_omega2 = path->first[i];
    d.d2_omega2 = 2 * path->second[i];
    d.compliance = 1 / d.omega2;
    d.d_compliance = -d.d_omega2 / (d.omega2 * d.omega2);
    d.d2_compliance =
        (2 * d.d_omega2 * d.d_omega2 / d.omega2 - d.d2_omega2) / (d.omega2 * d.omega2);
    d.mode = std::move(classified[i]);
  }
  if (exact && !exact->design->list.empty()) {
    auto gradients = gradients_of(factor, series, *path, *exact, listed);
    if (!gradients)
      return Because("the second derivatives of the modes were not found in 200 iterations");
    result.gradients = std::move(*gradients);
  }
  return result;
}

// The only drive that moves along a way.
std::optional<Eigen::Index> only_drive(const VectorXd& way) {
  if ((way.array() != 0).count() != 1) return std::nullopt;
  Eigen::Index drive = 0;
  way.cwiseAbs().maxCoeff(&drive);
  return drive;
}

// Rescales the derivatives to a parameter that is 1 at a stroke of `unit`.
void rescale(double unit, AlongStrokes& along) {
  for (FrequencyDerivatives& d : along.modes) {
    d.d_omega2 *= unit;
    d.d_compliance *= unit;
    d.d2_omega2 *= unit * unit;
    d.d2_compliance *= unit * unit;
  }
  for (FrequencyDerivativeGradients& g : along.gradients) {
    g.d_omega2 *= unit;
    g.d2_omega2 *= unit * unit;
  }
}

}  // namespace

Answer<FrequencyDerivativesResult> frequency_derivatives(const MechanismFactor& factor, int count,
                                                         const std::vector<VectorXd>& ways,
                                                         const ExactDerivatives* exact,
                                                         const FullModes* known) {
  if (factor.drives() == 0) return Because("nothing is driven");
  const Answer<LowModes> low = low_modes(factor, count, exact != nullptr, known);
  if (!low) return Because(low.error());
  FrequencyDerivativesResult result;
  if (low->kept < count)
    result.note = fmt::format(
        "frequency derivatives of the lowest {} alone: the next {} are too near each "
        "other to be told apart",
        low->kept, low->lambda.size() - low->kept);
  std::vector<AlongStrokes> of_drives;
  for (int drive = 0; drive < factor.drives(); ++drive) {
    const VectorXd strokes = VectorXd::Unit(factor.drives(), drive);
    auto along = along_strokes(factor, strokes, count, exact, *low);
    if (!along) return Because(along.error());
    for (FrequencyDerivatives& d : along->modes) d.drive = drive;
    std::ranges::copy(along->modes, std::back_inserter(result.modes));
    std::ranges::copy(along->gradients, std::back_inserter(result.gradients));
    of_drives.push_back(std::move(*along));
  }
  for (const VectorXd& way : ways) {
    Answer<AlongStrokes> along;
    if (const auto drive = only_drive(way)) {
      along = of_drives[*drive];
      rescale(way[*drive], *along);
    } else {
      along = along_strokes(factor, way, count, exact, *low);
    }
    if (!along) return Because(along.error());
    result.ways.push_back({way, std::move(along->modes)});
    if (exact && !exact->design->list.empty())
      result.way_gradients.push_back(std::move(along->gradients));
  }
  return result;
}

Answer<FrequencyDerivativesResult> frequency_derivatives(const Mechanism& mechanism,
                                                         const ModelOptions& model,
                                                         const LoadCase& loads,
                                                         const NewtonOptions& newton, int count,
                                                         const std::vector<VectorXd>& ways,
                                                         const ExactDerivatives* exact) {
  System system(mechanism, make_full_leaves(mechanism, model), loads);
  system.assemble();
  if (system.loaded_at_rest()) {
    Equilibrium loaded = mount(system, newton);
    if (loaded.converged && loads.driven() && !loads.mounting.empty())  // drives may have moved
      loaded = step_to(system, VectorXd::Zero(mechanism.drives.size()), newton);
    if (!loaded.converged) return Because(loaded.message);
  }
  const Answer<MechanismFactor> factor = MechanismFactor::of(system, count);
  if (!factor) return Because(factor.error());
  return frequency_derivatives(*factor, count, ways, exact);
}

}  // namespace flexopt
