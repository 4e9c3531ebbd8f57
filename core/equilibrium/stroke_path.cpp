#include "core/equilibrium/stroke_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/equilibrium/free_motions.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {

double present_stroke(const System& system) {
  const Mechanism& m = system.mechanism();
  const BodyPose& pose = system.pose(m.end_effector);
  const int d = index(drive_direction(m));
  if (is_rotation(drive_direction(m))) return rotation_log(pose.rotation)[d - 3];
  return pose.position[d] - m.bodies[m.end_effector].reference[d];
}

Vector6d stroke_gradient(const System& system) {
  const Mechanism& m = system.mechanism();
  const int d = index(drive_direction(m));
  Vector6d h = Vector6d::Zero();
  if (is_rotation(drive_direction(m))) {
    const Vector3d v = rotation_log(system.pose(m.end_effector).rotation);
    h.tail<3>() = rotation_left_tangent_inverse(v).row(d - 3).transpose();
  } else {
    h[d] = 1;
  }
  return h;
}

int negative_pivots(const System& system, bool drive_held) {
  if (system.constraints().count() > 0)
    return system.negative_pivots() + FreeMotions(system, drive_held).negative_pivots();
  const Mechanism& m = system.mechanism();
  const int d = 6 * m.end_effector + index(drive_direction(m));
  const MatrixXd& K = system.tangent_stiffness();
  const VectorXd s = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  MatrixXd H = s.asDiagonal() * K * s.asDiagonal();
  if (drive_held) {  // a decoupled positive one in the drive's place
    H.row(d).setZero();
    H.col(d).setZero();
    H(d, d) = 1;
  }
  return system.negative_pivots() +
         static_cast<int>((symmetric_eigenvalues(H).array() < 0).count());
}

namespace {

constexpr double violation_weight = 1e4;

// What is wrong where the joints' conditions, and the stroke's if one is held, depend on each other
// at this state; empty if they do not.
std::string dependence(const System& system, bool driven) {
  const int wanted = static_cast<int>(system.size() - system.held().size()) -
                     system.constraints().count() - driven;
  const int free = FreeMotions(system, driven).count();
  if (free == wanted) return {};
  return fmt::format("{} of the conditions of joints{} repeat others here (a dead point)",
                     free - wanted, driven ? " and stroke" : "");
}

}  // namespace

Equilibrium solve_equilibrium(System& system, std::optional<double> stroke,
                              const NewtonOptions& options) {
  const Mechanism& m = system.mechanism();
  const int n = system.size(), ee = 6 * m.end_effector, d = ee + index(drive_direction(m));
  const double L = system.length();
  Equilibrium result;
  VectorXd scale = VectorXd::Ones(n);
  for (int b = 0; b < n; b += 6) scale.segment<3>(b).setConstant(L);

  const int m_joints = system.constraints().count();

  double lambda = 0, previous = 0;
  system.assemble();
  if (m_joints > 0) {
    result.message = dependence(system, stroke.has_value());
    if (!result.message.empty()) return result;
  }
  for (int it = 0;; ++it) {
    // [K  −e  Ψ_qᵀ; hᵀ  0  0; Ψ_q  0  0] (dq, λ, dμ) = (load − f, stroke − s, −Ψ), scaled to
    // lengths over L; or λ = 0
    MatrixXd A = MatrixXd::Zero(n + 1 + m_joints, n + 1 + m_joints);
    VectorXd b(n + 1 + m_joints);
    double unit = system.tangent_stiffness()(d, d);
    if (m_joints > 0)  // no leaf may hang on the end-effector itself
      unit = (scale.asDiagonal() * system.tangent_stiffness() * scale.asDiagonal())
                 .diagonal()
                 .cwiseAbs()
                 .maxCoeff() /
             (scale[d] * scale[d]);
    A.topLeftCorner(n, n) = scale.asDiagonal() * system.residual_derivative() * scale.asDiagonal();
    if (stroke) {
      A(d, n) = -scale[d] * unit * scale[d];
      A.block(n, ee, 1, 6) =
          (stroke_gradient(system).cwiseProduct(scale.segment<6>(ee))).transpose();
      b[n] = *stroke - present_stroke(system);
    } else {
      A(n, n) = 1;
      b[n] = 0;
    }
    b.head(n) = scale.cwiseProduct(system.load() - system.internal_force());
    VectorXd reaction;  // joints: multipliers in the unit of the drive's, conditions in their own
    if (m_joints > 0) {
      const Constraints& c = system.constraints();
      reaction = unit * scale[d] * scale[d] * c.units().cwiseInverse();
      A.block(0, n + 1, n, m_joints) =
          scale.asDiagonal() * c.gradient().transpose() * reaction.asDiagonal();
      A.block(n + 1, 0, m_joints, n) =
          c.units().cwiseInverse().asDiagonal() * c.gradient() * scale.asDiagonal();
      b.tail(m_joints) = -c.value().cwiseQuotient(c.units());
    }
    const VectorXd x = Lu(A).solve(b);
    lambda = x[n] * unit * scale[d];
    result.step = x.head(n).cwiseAbs().maxCoeff();
    // steps within the tolerance, conditions far within it: they must not drift
    const double size = std::max(
        {result.step, system.correction(), violation_weight * system.constraints().violation()});
    result.iterations = it;
    if (!std::isfinite(size)) {
      result.message = fmt::format("Newton met a singular tangent in iteration {}", it + 1);
      return result;
    }
    // rounding holds the last digits: a small step that no longer shrinks is the end too
    const bool stalled = it > 1 && size < 1e-6 && size > 0.3 * previous;
    if (it > 0 && (size < options.tolerance || stalled)) {
      result.converged = true;
      result.drive_load = lambda;
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
    if (m_joints > 0) system.add_to_multipliers(reaction.cwiseProduct(x.tail(m_joints)));
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

Equilibrium step_to(System& system, double stroke, const NewtonOptions& options) {
  const double start = present_stroke(system);
  Equilibrium result = step_parameter(system, options, "stroke", true, [&](double s) {
    return solve_equilibrium(system, s == 1 ? stroke : start + s * (stroke - start), options);
  });
  if (!result.converged)
    result.message = fmt::format("stroke {:.6g} to {:.6g}: {}", start, stroke, result.message);
  return result;
}

Equilibrium step_load(System& system, LoadFactors to, const NewtonOptions& options) {
  const LoadFactors from = system.load_factors();
  const bool driven = system.loads().driven();
  const std::optional<double> stroke =
      driven ? std::optional(present_stroke(system)) : std::nullopt;
  return step_parameter(system, options, "load", driven, [&](double s) {
    system.apply(s == 1 ? to
                        : LoadFactors{from.constant + s * (to.constant - from.constant),
                                      from.growing + s * (to.growing - from.growing)});
    return solve_equilibrium(system, stroke, options);
  });
}

}  // namespace flexopt
