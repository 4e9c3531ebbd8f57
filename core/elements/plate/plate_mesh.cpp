#include "core/elements/plate/plate_mesh.hpp"

#include <cassert>
#include <cmath>
#include <numbers>

namespace flexopt {
using Row16 = Eigen::Matrix<double, 16, 1>;

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

PlateMesh::PlateMesh(const PlateShape& shape) : shape_(shape) {
  if (shape.is_beam()) shape_.mesh[1] = 1;
  assert(shape.mesh[0] >= 2 && shape.mesh[1] >= 1);
  x_ = graded_points(0, 1, shape.mesh[0], 0.5);
  elements_.resize(shape_.mesh[0] * shape_.mesh[1]);
  if (shape.is_beam())
    make_beam_elements();
  else
    make_plate_elements();
  assemble_mass();
}

void PlateMesh::make_plate_elements() {
  const int nx = shape_.mesh[0], ny = shape_.mesh[1];
  const double nu = shape_.poissons_ratio;
  assert(nu > -1 && nu <= 0.5 && shape_.section == Section::rectangular);
  y_ = graded_points(-shape_.width / 2, shape_.width / 2, ny, 0.7);
  const double A11 = 12 / (shape_.thickness * shape_.thickness);
  membrane_ = {A11, nu * A11, 0.5 * (1 - nu) * A11};
  bending_stiffness_ = shape_.width;
  edge_slopes_ = {{1, 0}, {1, 1}, {3, 0}, {3, 1}};

  const GaussRule full = gauss_rule(4), membrane_x = gauss_rule(2);
  // −½ G c t⁴ ∫ |r,xy|² ds with c = 0.105 for each free edge, over D.
  const double edge = shape_.free_edge_torsion ? 0.105 * 6 * (1 - nu) * shape_.thickness : 0.0;

  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      Element& element = elements_[i * ny + j];
      const double hx = x_[i + 1] - x_[i], hy = y_[j + 1] - y_[j];
      element.bending.setZero();
      element.mass.setZero();
      for (int a = 0; a < 4; ++a) {
        const HermiteValues X = hermite(full.point[a], hx);
        for (int b = 0; b < 4; ++b) {
          const HermiteValues Y = hermite(full.point[b], hy);
          const double w = full.weight[a] * full.weight[b] * hx * hy;
          const Row16 N = hermite_products(X.value, Y.value),
                      Nxx = hermite_products(X.curvature, Y.value),
                      Nyy = hermite_products(X.value, Y.curvature),
                      Nxy = hermite_products(X.slope, Y.slope);
          const Row16 laplace = Nxx + Nyy;
          element.bending += w * ((1 - nu) * (Nxx * Nxx.transpose() + Nyy * Nyy.transpose() +
                                              2 * Nxy * Nxy.transpose()) +
                                  nu * laplace * laplace.transpose());
          element.mass += w * N * N.transpose();
        }
        for (int side = 0; side < 2; ++side) {
          if (side == 0 ? j != 0 : j != ny - 1) continue;
          const Row16 Nxy = hermite_products(X.slope, hermite(side, hy).slope);
          element.bending -= edge * full.weight[a] * hx * Nxy * Nxy.transpose();
        }
      }
      for (int a = 0; a < 2; ++a) {
        const HermiteValues X = hermite(membrane_x.point[a], hx);
        for (int b = 0; b < 4; ++b) {
          const HermiteValues Y = hermite(full.point[b], hy);
          const int g = 4 * a + b;
          element.gradient.row(g) = hermite_products(X.slope, Y.value).transpose();
          element.gradient.row(points + g) = hermite_products(X.value, Y.slope).transpose();
          element.weight[g] = membrane_x.weight[a] * full.weight[b] * hx * hy;
        }
      }
    }
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
}

std::vector<NodalWeight> point_weights(const PlateMesh& mesh, double along, double across,
                                       std::array<int, 2> derivative) {
  assert(derivative[0] <= 1 && derivative[1] <= 1);
  const auto &x = mesh.x(), &y = mesh.y();
  auto locate = [](const std::vector<double>& points, double s) {
    int i = 0;
    while (i + 2 < static_cast<int>(points.size()) && s > points[i + 1]) ++i;
    return i;
  };
  const double sx = x.front() + along * (x.back() - x.front());
  const double sy = y.front() + across * (y.back() - y.front());
  const int i = locate(x, sx);
  const double hx = x[i + 1] - x[i], length = x.back() - x.front();
  std::vector<NodalWeight> weights;
  const auto functions = [](double s, double h, int derivative, double size) {
    const HermiteValues values = hermite(s, h);
    std::array<double, 4> f = derivative == 0 ? values.value : values.slope;
    for (double& v : f) v *= derivative == 0 ? 1 : size;
    return f;
  };
  const std::array<double, 4> X = functions((sx - x[i]) / hx, hx, derivative[0], length);
  if (mesh.shape().is_beam()) {  // r0 + y d
    const double width = mesh.shape().width, middle = derivative[1] == 0 ? 1 : 0,
                 beside = derivative[1] == 0 ? (across - 0.5) * width : width;
    for (int p = 0; p < 2; ++p)
      for (int k = 0; k < 2; ++k)
        for (const auto& [function, factor] : {std::pair{k, middle}, {2 + k, beside}})
          if (std::abs(factor * X[2 * p + k]) > 1e-14)
            weights.push_back({i + p, function, factor * X[2 * p + k]});
    return weights;
  }
  const int j = locate(y, sy);
  const double hy = y[j + 1] - y[j];
  const auto N =
      hermite_products(X, functions((sy - y[j]) / hy, hy, derivative[1], y.back() - y.front()));
  for (int f = 0; f < 16; ++f)
    if (std::abs(N[f]) > 1e-14) weights.push_back({i + f / 8, 4 * j + f % 8, N[f]});
  return weights;
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
