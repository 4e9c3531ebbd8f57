#include "core/elements/plate/plate_mesh.hpp"

#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/elements/plate/element_numbers.hpp"
#include "core/mechanism/profile.hpp"

namespace flexopt {

GaussRule gauss_rule(int n) {
  if (n == 2) {
    const double a = 0.5 / std::sqrt(3.0);
    return {{0.5 - a, 0.5 + a}, {0.5, 0.5}};
  }
  assert(n == 4);
  const double r = std::sqrt(1.2), s = std::sqrt(30.0);
  const double a = 0.5 * std::sqrt((3 + 2 * r) / 7), b = 0.5 * std::sqrt((3 - 2 * r) / 7);
  const double wa = (18 - s) / 72, wb = (18 + s) / 72;
  return {{0.5 - a, 0.5 - b, 0.5 + b, 0.5 + a}, {wa, wb, wb, wa}};
}

std::vector<double> graded_points(double a, double b, int intervals, double g) {
  std::vector<double> points(intervals + 1);
  for (int i = 0; i <= intervals; ++i) {
    const double xi = -1 + 2.0 * i / intervals;
    const double z = (1 - g) * xi - g * std::cos(std::numbers::pi * (xi + 1) / 2);
    points[i] = a + (b - a) * (z + 1) / 2;
  }
  points.front() = a;
  points.back() = b;
  return points;
}

double PlateShape::width_at(double x) const { return width * profile_at(width_profile, x); }
double PlateShape::thickness_at(double x) const {
  return thickness * profile_at(thickness_profile, x);
}
double PlateShape::mean_thickness() const { return thickness * profile_mean(thickness_profile); }
double PlateShape::mean_width() const { return width * profile_mean(width_profile); }

bool alike(const PlateShape& a, PlateShape b) {
  const auto take = [](double from, double& to) {
    if (alike(from, to)) to = from;
  };
  take(a.width, b.width);
  take(a.thickness, b.thickness);
  if (a.curve && b.curve) take(*a.curve, *b.curve);
  if (a.fold && b.fold) {
    take(a.fold->place, b.fold->place);
    take(a.fold->angle, b.fold->angle);
    take(a.fold->radius, b.fold->radius);
  }
  return a == b;
}

namespace {

PlateShape one_across(PlateShape shape) {
  if (shape.is_beam()) shape.mesh[1] = 1;
  return shape;
}

}  // namespace

PlateMesh::PlateMesh(const PlateShape& shape)
    : numbers_(one_across(shape)), membrane_(numbers_.membrane()) {
  assert(shape.mesh[0] >= 2 && shape.mesh[1] >= 1);
  assert(shape.poissons_ratio > -1);
  assert(!shape.fold || !(shape.is_beam() || shape.curve || shape.has_profile()));
  const ElementNumbers<double> operators(numbers_);
  edge_slopes_ = {{1, 0}, {1, 1}, {3, 0}, {3, 1}};
  if (shape.is_beam()) {
    assert(shape.section != Section::circular ||
           std::abs(shape.width - shape.thickness) < 1e-12 * shape.thickness);
    // A wire is free of shear in both planes and of restrained warping at its ends.
    if (shape.section == Section::circular)
      edge_slopes_ = {{1, 0}, {3, 0}, {3, 2}};
    else if (shape.warping == Warping::free)
      edge_slopes_ = {{1, 0}, {1, 1}, {3, 0}, {3, 1}, {3, 2}};
  } else {
    assert(shape.poissons_ratio <= 0.5 && shape.section == Section::rectangular);
  }
  for (int i = 0; i < elements_along(); ++i)
    for (int j = 0; j < elements_across(); ++j) elements_.push_back(operators.element(i, j));
  for (int i = 0; i < lines(); ++i) {
    MatrixXd& nodes = undeflected_.emplace_back(functions_per_line(), 3);
    for (int j = 0; j < nodes_per_line(); ++j) {
      const auto node = numbers_.undeflected_node(i, j);
      for (int k = 0; k < 4; ++k) nodes.row(4 * j + k) = node[k].transpose();
    }
  }
  assemble_mass();
}

void PlateMesh::assemble_mass() {
  const int nx = elements_along(), ny = elements_across();
  const int n = functions_per_line(), side = functions_per_side();
  mass_diagonal_.assign(lines(), MatrixXd::Zero(n, n));
  mass_below_.assign(nx, MatrixXd::Zero(n, n));
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      const Matrix16& m = element(i, j).mass;
      mass_diagonal_[i].block(4 * j, 4 * j, side, side) += m.block(0, 0, side, side);
      mass_diagonal_[i + 1].block(4 * j, 4 * j, side, side) += m.block(side, side, side, side);
      mass_below_[i].block(4 * j, 4 * j, side, side) += m.block(side, 0, side, side);
    }
  VectorXd one = VectorXd::Zero(n);  // the nodal values of the constant 1
  for (int s = 0; s < n; s += 4) one[s] = 1;
  for (int i = 0; i < lines(); ++i) {
    VectorXd& moment = mass_moment_.emplace_back(mass_diagonal_[i] * one);
    if (i > 0) moment += mass_below_[i - 1] * one;
    if (i < nx) moment += mass_below_[i].transpose() * one;
  }
}

std::vector<NodalWeight> point_weight_rates(const PlateMesh& mesh, const ShapeRate& rate,
                                            double along, double across) {
  const MeshNumbers<Dual1> numbers(mesh.shape(), rate);
  std::vector<NodalWeight> rates;
  for (const auto& w : numbers.point_weights(along, across))
    if (w.weight.derivatives[0] != 0)
      rates.push_back({w.line, w.function, w.weight.derivatives[0]});
  return rates;
}

std::vector<NodalWeight> tip_mean_weight_rates(const PlateMesh& mesh, const ShapeRate& rate) {
  std::vector<NodalWeight> rates = tip_mean_weights(mesh);
  for (NodalWeight& w : rates) w.weight = width_slope(mesh, w) * rate.size[0];
  return rates;
}

std::vector<NodalWeight> tip_mean_weights(const PlateMesh& mesh) {
  const auto& y = mesh.y();
  const int last = mesh.lines() - 1;
  if (mesh.shape().is_beam()) return {{last, 0, 1.0}};
  const double width = y.back() - y.front();
  std::vector<NodalWeight> weights;
  for (int j = 0; j + 1 < static_cast<int>(y.size()); ++j) {
    const double h = y[j + 1] - y[j];
    // ∫ of the cubic Hermite functions; k = 2 is ∂y
    weights.push_back({last, 4 * j, 0.5 * h / width});
    weights.push_back({last, 4 * j + 2, h * h / 12 / width});
    weights.push_back({last, 4 * (j + 1), 0.5 * h / width});
    weights.push_back({last, 4 * (j + 1) + 2, -h * h / 12 / width});
  }
  return weights;
}

}  // namespace flexopt
