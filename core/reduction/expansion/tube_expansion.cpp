#include "core/reduction/expansion/tube_expansion.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/math/rotation.hpp"
#include "core/math/work_limit.hpp"
#include "core/reduction/expansion/tube_series.hpp"

namespace flexopt {

Vector3d tube_force_scale(const PlateShape& shape) {
  const double w = shape.mean_width();
  return {w, w * w, w * w};
}

// ---------------------------------------------------------------------------- leaf in its frame

ChordLeaf::ChordLeaf(std::shared_ptr<const PlateMesh> mesh) : plate_(std::move(mesh)) {
  plate_.assemble();
}

void ChordLeaf::reset() {
  plate_.set_state(PlateLeaf::undeflected(plate_.mesh()));
  plate_.assemble();
  s_.setZero();
  c_.setZero();
  f_.setZero();
}

void ChordLeaf::stand_at(const Vector3d& s, const Vector3d& f, const VectorXd& unknowns) {
  s_ = s;
  f_ = f;
  c_ = unknowns.tail<3>();
  plate_.set_state({edges(s_, c_), unknowns.head(plate_.unknowns())});
  plate_.assemble();
}

EdgePoses ChordLeaf::edges(const Vector3d& s, const Vector3d& c) const {
  const PlateMesh& mesh = plate_.mesh();
  const EdgePose &base = mesh.line_pose(0), &tip = mesh.line_pose(mesh.lines() - 1);
  return {
      EdgePose{Vector3d::Zero(), rotation_exp({-0.5 * s[2], s[0], c[1]}) * base.axes},
      EdgePose{{tip.position[0] + c[0], 0, 0}, rotation_exp({0.5 * s[2], s[1], c[2]}) * tip.axes}};
}

Eigen::Matrix<double, 12, 3> ChordLeaf::stiff_map() const {
  Eigen::Matrix<double, 12, 3> G = Eigen::Matrix<double, 12, 3>::Zero();
  G(6, 0) = 1;
  G.block<3, 1>(3, 1) = rotation_left_tangent({-0.5 * s_[2], s_[0], c_[1]}).col(2);
  G.block<3, 1>(9, 2) = rotation_left_tangent({0.5 * s_[2], s_[1], c_[2]}).col(2);
  return G;
}

Eigen::Matrix<double, 12, 3> ChordLeaf::soft_map() const {
  Eigen::Matrix<double, 12, 3> G = Eigen::Matrix<double, 12, 3>::Zero();
  const Matrix3d J1 = rotation_left_tangent({-0.5 * s_[2], s_[0], c_[1]}),
                 J2 = rotation_left_tangent({0.5 * s_[2], s_[1], c_[2]});
  G.block<3, 1>(3, 0) = J1.col(1);
  G.block<3, 1>(9, 1) = J2.col(1);
  G.block<3, 1>(3, 2) = -0.5 * J1.col(0);
  G.block<3, 1>(9, 2) = 0.5 * J2.col(0);
  return G;
}

Matrix3d ChordLeaf::stiff_tangent() const {
  const auto G = stiff_map();
  Matrix3d S = G.transpose() * plate_.tangent() * G;
  const Vector12d& g = plate_.force();
  S(1, 1) += g.segment<3>(3).dot(spin_rate({-0.5 * s_[2], s_[0], c_[1]}, Vector3d::UnitZ()));
  S(2, 2) += g.segment<3>(9).dot(spin_rate({0.5 * s_[2], s_[1], c_[2]}, Vector3d::UnitZ()));
  return S;
}

ChordLeaf::Solution ChordLeaf::solve(const Vector3d& s, const Vector3d& f, int max_iterations) {
  Solution solution;
  f_ = f;
  for (int it = 1; it <= max_iterations; ++it) {
    count_iteration();
    const auto G = stiff_map();
    const Matrix3d S = stiff_tangent();
    const Vector3d ds = s - s_;
    const Vector12d dq_soft = soft_map() * ds;
    const Vector3d r = G.transpose() * (plate_.force() + plate_.tangent() * dq_soft) - f;
    const Vector3d dc = -Eigen::PartialPivLU<Matrix3d>(S).solve(r);
    const double size =
        std::max({dc.cwiseAbs().maxCoeff(), plate_.correction(), ds.cwiseAbs().maxCoeff()});
    solution.iterations = it;
    if (!std::isfinite(size) || size > 1e3) break;
    const Vector12d dq = dq_soft + G * dc;
    const VectorXd dx = plate_.internal_step(dq);
    s_ = s;
    c_ += dc;
    // Newton squares a step this small; what follows wants the exact tangent, not the mixed one
    const bool last = size < 1e-5;
    if (last) {
      PlateLeaf::State state{edges(s_, c_), plate_.state().x + dx};
      plate_.set_state(state);
    } else {
      plate_.step(edges(s_, c_), dx, dq);
    }
    plate_.assemble();
    solution.correction = plate_.correction();
    if (last && solution.correction < 1e-7) {
      solution.converged = true;
      return solution;
    }
  }
  plate_.set_state(plate_.state());
  plate_.assemble();
  return solution;
}

VectorXd ChordLeaf::unknowns() const {
  VectorXd y(plate_.unknowns() + 3);
  y << plate_.state().x, c_;
  return y;
}

double ChordLeaf::potential() const { return plate_.energy() - f_.dot(c_); }

double bend(ChordLeaf& leaf, const Eigen::Vector2d& ray, double from, double to) {
  constexpr int most_halvings = 6;
  const Vector3d f = leaf.forces();
  const double smallest = std::abs(to - from) / (1 << most_halvings);
  double at = from, step = to - from;
  while (at != to) {
    const Vector3d s = leaf.soft();
    const VectorXd unknowns = leaf.unknowns();
    const double next = std::abs(step) >= std::abs(to - at) ? to : at + step;
    if (leaf.solve({ray[0] * next, ray[1] * next, 0}, f).converged &&
        leaf.plate().negative_pivots() == 0) {
      at = next;
      continue;
    }
    leaf.stand_at(s, f, unknowns);
    step *= 0.5;
    if (std::abs(step) < smallest) break;
  }
  return at;
}

// ---------------------------------------------------------------------------- fields

FieldSolver::FieldSolver(const ChordLeaf& leaf) : plate_(leaf.plate()), S_(leaf.stiff_tangent()) {
  X_ = plate_.coupling() * leaf.stiff_map();  // K_fb G, then K_ff⁻¹ of it
  KcT_ = X_.transpose();
  plate_.solve(X_);
}

MatrixXd FieldSolver::operator()(const MatrixXd& R) const {
  const int n = plate_.unknowns();
  MatrixXd Y(n + 3, R.cols());
  MatrixXd top = -R.topRows(n);
  plate_.solve(top);
  Y.bottomRows<3>() = S_.solve(Eigen::Matrix3Xd(-R.bottomRows(3) - KcT_ * top));
  Y.topRows(n) = top - X_ * Y.bottomRows(3);
  return Y;
}

namespace {

// Field coefficients degree by degree: K y_d = −(degree-d part of the residual without y_d).
template <int ORDER>
MatrixXd perturbation_fields(const ChordLeaf& leaf, const Eigen::Matrix2d& ray) {
  const MonomialTable& table = monomials<6, ORDER>();
  const FieldSolver solve(leaf);
  MatrixXd Y = MatrixXd::Zero(leaf.plate().unknowns() + 3, table.size());
  Y.col(0) = leaf.unknowns();
  auto series = std::make_unique<TubeSeries<ORDER>>(leaf, leaf.plate().mesh(), ray, ORDER);
  for (int d = 1; d <= ORDER; ++d) {
    series->set_fields(Y);
    const MatrixXd R = series->residual(d);
    Y.middleCols(table.count(d - 1), R.cols()) = solve(R);
  }
  return Y;
}

template <int ORDER>
MatrixXd nodal_to(const ChordLeaf& leaf, const Eigen::Matrix2d& ray, const MatrixXd& fields) {
  auto series = std::make_unique<TubeSeries<ORDER>>(leaf, leaf.plate().mesh(), ray, ORDER);
  series->set_fields(fields);
  return series->nodal();
}

template <int ORDER>
TubeExpansion expanded(const ChordLeaf& leaf, double sigma, const Eigen::Matrix2d& ray) {
  auto series = std::make_unique<TubeSeries<2 * ORDER + 1>>(leaf, leaf.plate().mesh(), ray, ORDER);
  MatrixXd fields = perturbation_fields<ORDER>(leaf, ray);
  series->set_fields(fields);
  return {sigma, series->potential(), std::move(fields)};
}

}  // namespace

FieldExpansion expand_fields(const ChordLeaf& leaf, const Eigen::Matrix2d& ray, int order) {
  assert(order == 2 || order == 3);
  MatrixXd fields =
      order == 2 ? perturbation_fields<2>(leaf, ray) : perturbation_fields<3>(leaf, ray);
  MatrixXd nodal = nodal_values(leaf, ray, fields);
  return {std::move(fields), std::move(nodal)};
}

MatrixXd nodal_values(const ChordLeaf& leaf, const Eigen::Matrix2d& ray, const MatrixXd& fields) {
  assert(fields.cols() == monomial_count(6, 2) || fields.cols() == monomial_count(6, 3));
  return fields.cols() == monomial_count(6, 2) ? nodal_to<2>(leaf, ray, fields)
                                               : nodal_to<3>(leaf, ray, fields);
}

FieldExpansion expand_bending_fields(const ChordLeaf& leaf, const Eigen::Matrix2d& ray,
                                     const MatrixXd& fields) {
  constexpr int order = 3;
  const MonomialTable &table = monomials<2, order>(), &all = monomials<6, 2>();
  FieldExpansion result{MatrixXd::Zero(fields.rows(), table.size()), {}};
  for (int m = 0; m < table.count(order - 1); ++m) {
    const auto e = table.exponents(m);
    result.fields.col(m) = fields.col(all.index(std::array<int, 6>{e[0], e[1], 0, 0, 0, 0}));
  }
  auto series =
      std::make_unique<TubeSeries<order, PlateMesh, 2>>(leaf, leaf.plate().mesh(), ray, order);
  series->set_fields(result.fields);
  const MatrixXd R = series->residual(order);
  result.fields.rightCols(R.cols()) = FieldSolver(leaf)(R);
  series->set_fields(result.fields);
  result.nodal = series->nodal();
  return result;
}

TubeExpansion expand(ChordLeaf& leaf, double sigma, const Eigen::Matrix2d& ray, int order) {
  assert(order == 2 || order == 3);
  return order == 2 ? expanded<2>(leaf, sigma, ray) : expanded<3>(leaf, sigma, ray);
}

}  // namespace flexopt
