#include "core/equilibrium/stroke_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/equilibrium/free_motions.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"
#include "core/math/sparse_solver.hpp"

namespace flexopt {

VectorXd present_strokes(const System& system) {
  const Mechanism& m = system.mechanism();
  VectorXd strokes(static_cast<Eigen::Index>(m.drives.size()));
  for (std::size_t k = 0; k < m.drives.size(); ++k) {
    const Drive& drive = m.drives[k];
    const auto body = [&](int b) -> JointBody {
      if (b < 0) return {};
      return {system.pose(b).position, system.pose(b).rotation, m.bodies[b].reference};
    };
    const int d = index(drive.direction);
    double& stroke = strokes[static_cast<Eigen::Index>(k)];
    if (!system.drives()[k].coordinate)
      stroke =
          drive_stroke<double>(drive, DriveLoad::conjugate, body(drive.body), body(drive.other))
              .value;
    else if (is_rotation(drive.direction))
      stroke = rotation_log(system.pose(drive.body).rotation)[d - 3];
    else
      stroke = system.pose(drive.body).position[d] - m.bodies[drive.body].reference[d];
  }
  return strokes;
}

double present_stroke(const System& system) { return present_strokes(system)[0]; }

MatrixXd stroke_gradients(const System& system) {
  const Mechanism& m = system.mechanism();
  MatrixXd H = MatrixXd::Zero(static_cast<Eigen::Index>(m.drives.size()), system.size());
  for (std::size_t k = 0; k < m.drives.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const Drive& drive = m.drives[k];
    const int d = index(drive.direction);
    if (const System::DriveRow& at = system.drives()[k]; !at.coordinate) {
      const Constraints::Row& of =
          system.constraints().rows()[static_cast<std::size_t>(*at.condition)];
      for (int e = 0; e < 2; ++e)
        if (of.body[e] >= 0)
          H.block<1, 6>(row, 6 * of.body[e]) += of.stroke.segment<6>(6 * e).transpose();
    } else if (is_rotation(drive.direction)) {
      const Vector3d v = rotation_log(system.pose(drive.body).rotation);
      H.block<1, 3>(row, 6 * drive.body + 3) = rotation_left_tangent_inverse(v).row(d - 3);
    } else {
      H(row, *at.coordinate) = 1;
    }
  }
  return H;
}

int negative_pivots(const System& system, bool drives_held) {
  if (system.constraints().count() > 0 || system.analyses())
    return system.negative_pivots() + FreeMotions(system, drives_held).negative_pivots();
  const MatrixXd K = system.tangent_stiffness();
  const VectorXd s = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  MatrixXd H = s.asDiagonal() * K * s.asDiagonal();
  if (drives_held)  // a decoupled positive one in the place of each drive
    for (const int d : system.driven_coordinates()) {
      H.row(d).setZero();
      H.col(d).setZero();
      H(d, d) = 1;
    }
  return system.negative_pivots() +
         static_cast<int>((symmetric_eigenvalues(H).array() < 0).count());
}

namespace {

constexpr double violation_weight = 1e4;

// What is wrong where the joints' conditions, and the strokes' if they are held, depend on each
// other at this state; empty if they do not.
std::string dependence(const System& system, bool driven) {
  const int drives = static_cast<int>(system.drives().size());
  const int wanted = static_cast<int>(system.size() - system.held().size()) -
                     system.constraints().joints() - (driven ? drives : 0);
  const int free = FreeMotions(system, driven).count();
  if (free == wanted) return {};
  return fmt::format("{} of the conditions of joints{} repeat others here (a dead point)",
                     free - wanted, driven ? " and stroke" : "");
}

}  // namespace

Equilibrium solve_equilibrium(System& system, double stroke, const NewtonOptions& options) {
  return solve_equilibrium(system, std::optional<VectorXd>(VectorXd::Constant(1, stroke)), options);
}

Equilibrium solve_equilibrium(System& system, const std::optional<VectorXd>& strokes,
                              const NewtonOptions& options) {
  const int n = system.size(), drives = static_cast<int>(system.drives().size());
  const double L = system.length();
  Equilibrium result;
  VectorXd scale = VectorXd::Ones(n);
  for (int b = 0; b < n; b += 6) scale.segment<3>(b).setConstant(L);

  std::vector<int> owned;  // drives of a coordinate: their loads are unknowns here
  for (int k = 0; k < drives; ++k)
    if (system.drives()[static_cast<std::size_t>(k)].coordinate) owned.push_back(k);
  const int loads = static_cast<int>(owned.size()), conditions = system.constraints().count(),
            first = n + loads;
  const auto coordinate = [&](int j) {
    return *system.drives()[static_cast<std::size_t>(owned[static_cast<std::size_t>(j)])]
                .coordinate;
  };

  VectorXd lambda = VectorXd::Zero(loads);
  double previous = 0;
  system.assemble();
  if (conditions > 0) {
    result.message = dependence(system, strokes.has_value());
    if (!result.message.empty()) return result;
  }
  for (int it = 0;; ++it) {
    // [K  −e  Ψ_qᵀ; hᵀ  0  0; Ψ_q  0  0] (dq, λ, dμ) = (load − f, stroke − s, −Ψ), scaled to
    // lengths over L; or λ = 0
    SparseMatrix A(first + conditions);
    VectorXd b(first + conditions);
    const Constraints& c = system.constraints();
    double energy = 0;  // where there are joints no leaf may hang on the body that is driven
    if (conditions > 0)
      energy = system.tangent().diagonal().cwiseProduct(scale.cwiseAbs2()).cwiseAbs().maxCoeff();
    VectorXd unit(loads);
    A.add(system.residual_tangent(), scale, scale);
    const MatrixXd H = stroke_gradients(system);
    const VectorXd present = present_strokes(system);
    const auto add_stroke = [&](int row, int k, double over) {
      const Drive& drive = system.mechanism().drives[static_cast<std::size_t>(k)];
      for (const int body : {drive.body, drive.other})
        if (body >= 0)
          for (int d = 6 * body; d < 6 * body + 6; ++d) A.add(row, d, H(k, d) * scale[d] / over);
    };
    for (int j = 0; j < loads; ++j) {
      const int d = coordinate(j), k = owned[static_cast<std::size_t>(j)];
      unit[j] = conditions > 0 ? energy / (scale[d] * scale[d]) : system.tangent()(d, d);
      if (strokes) {
        A.add(d, n + j, -scale[d] * unit[j] * scale[d]);
        add_stroke(n + j, k, 1);
        b[n + j] = (*strokes)[k] - present[k];
      } else {
        A.add(n + j, n + j, 1);
        b[n + j] = 0;
      }
    }
    b.head(n) = scale.cwiseProduct(system.load() - system.internal_force());
    VectorXd reaction;      // multipliers in the unit of the drive's, conditions in their own
    double off_stroke = 0;  // of the conditions of drives
    if (conditions > 0) {
      reaction = energy * c.units().cwiseInverse();
      b.tail(conditions) = -c.value().cwiseQuotient(c.units());
      for (int j = 0; j < conditions; ++j) {
        const Constraints::Row& row = c.rows()[static_cast<std::size_t>(j)];
        const bool joint = j < c.joints();
        for (int e = 0; e < 2; ++e)
          for (int i = 0; i < 6 && row.body[e] >= 0; ++i) {
            const int d = 6 * row.body[e] + i;
            const double value = row.gradient[6 * e + i];
            A.add(d, first + j, scale[d] * value * reaction[j]);
            if (joint) A.add(first + j, d, 1 / c.units()[j] * value * scale[d]);
          }
        if (joint) continue;
        const int k = c.drives()[static_cast<std::size_t>(j - c.joints())];
        if (strokes) {
          add_stroke(first + j, k, c.units()[j]);
          b[first + j] = ((*strokes)[k] - c.value()[j]) / c.units()[j];
          off_stroke = std::max(off_stroke, std::abs(b[first + j]));
        } else {  // no load
          A.add(first + j, first + j, 1);
          b[first + j] = -system.multipliers()[j] / reaction[j];
        }
      }
    }
    const VectorXd x = LinearSolver(A, system.analyses()).solve(b);
    for (int j = 0; j < loads; ++j) lambda[j] = x[n + j] * unit[j] * scale[coordinate(j)];
    result.step = x.head(n).cwiseAbs().maxCoeff();
    // steps within the tolerance, conditions far within it: they must not drift
    const double size = std::max({result.step, system.correction(),
                                  violation_weight * c.violation(), violation_weight * off_stroke});
    result.iterations = it;
    if (!std::isfinite(size)) {
      result.message = fmt::format("Newton met a singular tangent in iteration {}", it + 1);
      return result;
    }
    // rounding holds the last digits: a small step that no longer shrinks is the end too
    const bool stalled = it > 1 && size < 1e-6 && size > 0.3 * previous;
    if (it > 0 && (size < options.tolerance || stalled)) {
      result.converged = true;
      result.drive_loads = VectorXd::Zero(drives);
      for (int j = 0; j < loads; ++j)
        result.drive_loads[owned[static_cast<std::size_t>(j)]] = lambda[j];
      for (int k = 0; k < drives; ++k)
        if (const auto& row = system.drives()[static_cast<std::size_t>(k)].condition)
          result.drive_loads[k] = -(system.multipliers()[*row] + reaction[*row] * x[first + *row]);
      if (drives > 0) result.drive_load = result.drive_loads[0];
      return result;
    }
    if (result.step > 2 || it == options.max_iterations) {
      result.message = fmt::format(
          "Newton stopped after {} iterations: step {:.1e} > {:.1e} (lengths / L), leaf correction "
          "{:.1e}",
          it, result.step, options.tolerance, system.correction());
      return result;
    }
    previous = size;
    system.move(scale.cwiseProduct(x.head(n)));
    if (conditions > 0) system.add_to_multipliers(reaction.cwiseProduct(x.tail(conditions)));
    system.assemble();
  }
}

namespace {

// From parameter 0 to 1 with `solve(parameter)`, halving the step when it fails.
template <class Solve>
Equilibrium step_parameter(System& system, const NewtonOptions& options, const char* what,
                           bool drive_held, const Solve& solve) {
  System::Snapshot good = system.save();
  double reached = 0, step = 1;
  int halvings = 0, sub_steps = 0, negative = -1;
  Equilibrium result;
  while (reached < 1) {
    if (negative < 0) {
      system.assemble();
      negative = negative_pivots(system, drive_held);
    }
    const double target = std::min(1.0, reached + step);  // powers of two: 1 is met exactly
    result = solve(target);
    int now = 0;
    if (result.converged) {
      now = negative_pivots(system, drive_held);
      if (system.strain() > largest_strain) {
        result.converged = false;
        result.message = fmt::format("a leaf is stretched by {:.3g} > {:.3g}: beyond its reach",
                                     system.strain(), largest_strain);
      } else if (now > negative && halvings + 2 < options.max_halvings) {
        result.converged = false;  // another branch? believed only if short steps lead there too
      }
    }
    if (result.converged) {
      ++sub_steps;
      reached = target;
      negative = now;
      if (reached < 1) good = system.save();
      continue;
    }
    system.restore(good);
    if (++halvings > options.max_halvings) {
      system.assemble();
      result.message = fmt::format("no equilibrium between {:.4g} and {:.4g} of the {} step: {}",
                                   reached, target, what, result.message);
      break;
    }
    step /= 2;
  }
  result.sub_steps = std::max(sub_steps, 1);
  return result;
}

}  // namespace

namespace {
std::string listed(const VectorXd& strokes) {
  std::string text;
  for (Eigen::Index k = 0; k < strokes.size(); ++k)
    text += fmt::format("{}{:.6g}", k == 0 ? "" : ", ", strokes[k]);
  return strokes.size() == 1 ? text : "(" + text + ")";
}
}  // namespace

Equilibrium step_to(System& system, const VectorXd& strokes, const NewtonOptions& options) {
  const VectorXd start = present_strokes(system);
  Equilibrium result = step_parameter(system, options, "stroke", true, [&](double s) {
    return solve_equilibrium(
        system, std::optional<VectorXd>(s == 1 ? strokes : VectorXd(start + s * (strokes - start))),
        options);
  });
  if (!result.converged)
    result.message =
        fmt::format("stroke {} to {}: {}", listed(start), listed(strokes), result.message);
  return result;
}

Equilibrium step_to(System& system, double stroke, const NewtonOptions& options) {
  return step_to(system, VectorXd::Constant(1, stroke), options);
}

Equilibrium step_load(System& system, LoadFactors to, const NewtonOptions& options) {
  const LoadFactors from = system.load_factors();
  const bool driven = system.loads().driven();
  const std::optional<VectorXd> strokes =
      driven ? std::optional(present_strokes(system)) : std::nullopt;
  return step_parameter(system, options, "load", driven, [&](double s) {
    system.apply(s == 1 ? to
                        : LoadFactors{from.constant + s * (to.constant - from.constant),
                                      from.growing + s * (to.growing - from.growing)});
    return solve_equilibrium(system, strokes, options);
  });
}

}  // namespace flexopt
