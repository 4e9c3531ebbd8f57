#pragma once
// The mixed potential W*(s, f) of a leaf along its bending ray: Taylor expansions about a few bent
// states, every coefficient joined by two-point Hermite interpolation along the ray.
#include <array>
#include <vector>

#include "core/math/types.hpp"
#include "core/math/wide.hpp"

namespace flexopt {

/// What a tube is built for.
struct TubeRange {
  Eigen::Vector2d ray{1, 1};  ///< (θ1y, θ2y) of the drive, the larger one 1
  double sigma_max = 0.3;     ///< along the ray [rad]
  double force_centre = 0;    ///< N about which to expand, over the force scale
  Eigen::Vector2d moment_centre = Eigen::Vector2d::Zero();  ///< (M1, M2) about which to expand
  int order = 2;  ///< of the fields: potential of degree 2 order + 1
  /// A dead load gives the leaf more than 1 % of its buckling load: stricter tests of belief.
  bool loaded = false;

  Vector3d centre() const { return {force_centre, moment_centre[0], moment_centre[1]}; }
  bool under_load() const { return loaded || !centre().isZero(0); }
};

/// Expansion of W* about one bent state of the ray.
struct TubeNode {
  double sigma = 0;
  /// Taylor coefficients over the monomials (polynomial.hpp, 6 variables, total degree ≤ degree of
  /// the potential; further ones are ignored) in (σ − sigma, τ, φ, N, M1, M2); forces over their
  /// scale, counted from the force centre.
  std::vector<double> W;
};

/// What the coefficients of all bent states change by with w/L, t/L, ν, one after the other; of a
/// last one that does not move nothing is there.
using TubeNodeRates = std::vector<std::vector<TubeNode>>;

/// Value and derivatives in (θ1y, θ2y, φx, N, M1, M2), forces over their scale.
template <class T>
struct PotentialOf {
  T value = 0;
  Eigen::Matrix<T, 6, 1> gradient;
  Eigen::Matrix<T, 6, 6> hessian;
};
using PotentialValue = PotentialOf<double>;

/// Place of a state in the tube.
struct TubeLocation {
  double sigma = 0;   ///< along the ray, signed
  double tau = 0;     ///< off the ray, signed
  double beyond = 0;  ///< sigma outside of the nodes, or of their mirror images; ≤ 0 inside
  int interval = 0;   ///< its nodes are interval, interval + 1
};

/// Mixed potential with (θ1y, θ2y)ᵀ = D (σ, τ), x = (τ, N) and y = (φ, M1, M2), for σ_i ≤ σ ≤ σ_i+1
///
///     W*(σ, x, y) = Σ_m c_m(t) (x, y)^m,   |m| ≤ d − 1,   t = (σ − σ_i)/(σ_i+1 − σ_i)
///
/// where c_m takes d + 1 − |m| Taylor coefficients from *each* node (degree 2 (d + 1 − |m|) − 1).
/// So node states are reproduced exactly, and c_m is C^(d−|m|) across nodes.
/// Mirror symmetry in the width: only even total powers of y, unless the nodes were expanded about
/// moments, which break it. Mirror symmetry in the thickness of a
/// flat leaf: W*(σ, τ, φ, N, M) = W*(−σ, −τ, −φ, N, M), so nodes stand at σ ≥ 0. A curved leaf has
/// none: its nodes stand on both sides. Terms are dropped by these parities only, never by size.
class TubePotential {
 public:
  /// `ray`: D. `force_scale`: units of (N, M1, M2). `force_centre`: scaled forces about which the
  /// nodes were expanded.
  /// `degree`: 3 to 7, with moments from 4. Nodes ascend, where `mirrored` (in the thickness) from
  /// sigma = 0 or above.
  TubePotential(const Eigen::Matrix2d& ray, const Vector3d& force_scale, int degree,
                std::vector<TubeNode> nodes, const Vector3d& force_centre = Vector3d::Zero(),
                bool mirrored = true);

  /// Adds a bent state, beyond the others or between two.
  void add_node(TubeNode node);

  /// s = (θ1y, θ2y, φx) [rad], f = (N, M1, M2) over their scale. Beyond the last node the last
  /// interval is continued.
  PotentialValue evaluate(const Vector3d& s, const Vector3d& f) const;
  /// ∂hessian/∂z_k of evaluate(), z = (s, f), of a potential of degree 5 without moments in its
  /// centre.
  std::array<Matrix6d, 6> third(const Vector3d& s, const Vector3d& f) const;

  TubeLocation locate(const Vector3d& s) const;

  int degree() const { return degree_; }
  bool mirrored() const { return mirrored_; }
  const Eigen::Matrix2d& ray() const { return ray_; }
  const Vector3d& force_scale() const { return force_scale_; }
  const Vector3d& force_centre() const { return force_centre_; }
  const std::vector<TubeNode>& nodes() const { return nodes_; }
  double last_sigma() const { return nodes_.back().sigma; }

  /// Eight numbers that the processor treats at once.
  using Lanes = Eight;

 private:
  struct Interval {
    double start, width;
    std::vector<Lanes> coefficients;  ///< in the order in which evaluate() reads them
  };
  /// A state on its interval, mirrored to σ ≥ 0.
  struct Local {
    const Interval* interval;
    double mirror;  ///< −1: mirrored
    double sigma;
    std::array<double, 5> z;  ///< (τ, φ, N, M1, M2) from the centre
  };
  Local local(const Vector3d& s, const Vector3d& f) const;
  void make_intervals();

  Eigen::Matrix2d ray_, ray_inverse_;
  Vector3d force_scale_, force_centre_;
  int degree_;
  bool mirrored_;
  bool odd_;  ///< odd powers of y too
  std::vector<TubeNode> nodes_;
  std::vector<Interval> intervals_;
};

/// What exact derivatives of a tube leaf need of its potential: third derivatives along the state,
/// and the gradient and the Hessian of what the potential changes by with the leaf's shape.
class TubeRates {
 public:
  /// `rates`: at the nodes of the potential, which must outlive this. Its degree is 5.
  TubeRates(const TubePotential& potential, const TubeNodeRates& rates);

  struct Answer {
    PotentialValue potential;
    std::array<Matrix6d, 6> third;           ///< ∂hessian/∂z_k of it
    std::array<PotentialValue, 3> by_shape;  ///< derivatives of it by w/L, t/L and ν
  };
  /// z = (s, f): as of TubePotential::evaluate.
  Answer evaluate(const Vector3d& s, const Vector3d& f) const;

 private:
  const TubePotential* potential_;
  std::vector<TubePotential> by_shape_;  ///< the interpolant is linear in the nodes
};

}  // namespace flexopt
