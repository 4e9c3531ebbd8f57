// The curves of figures 1 to 3 of the modal-derivative paper.
//
// As CSV on standard output: a cantilever of 10 beam elements (w/L = 0.1, t/L = 1/100), its
// vibration modes, its Craig–Bampton modes (right node free), the modal derivatives of both, and
// its shapes under a tip load, full and projected on two modes and three derivatives.
// `modal_derivative_paper/figures.py` draws the figures.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <optional>
#include <string>

#include "core/reduction/modal/modal_derivatives.hpp"

using namespace flexopt;

namespace {

constexpr double width = 0.1, thickness = 0.01;

std::shared_ptr<const PlateMesh> mesh_of(int elements, double t) {
  PlateShape shape;
  shape.width = width;
  shape.thickness = t;
  shape.mesh = {elements, 1};
  shape.flexure = Flexure::beam;
  return std::make_shared<PlateMesh>(shape);
}

const PlateSupport cantilever{.free_tip = true, .point = {}};

/// Axial and transverse part of a field at the nodes, the clamp first.
struct Line {
  std::vector<double> u, v;
};
Line line_of(const PlateLeaf& leaf, const VectorXd& field) {
  Line line{{0}, {0}};
  const int n = leaf.mesh().functions_per_line();
  for (int i = 1; i < leaf.mesh().lines(); ++i) {
    line.u.push_back(field[leaf.block_offset(i)]);
    line.v.push_back(field[leaf.block_offset(i) + 2 * n]);
  }
  return line;
}

void print(const std::string& figure, const std::string& curve, const PlateLeaf& leaf,
           const VectorXd& field) {
  const Line line = line_of(leaf, field);
  for (std::size_t i = 0; i < line.u.size(); ++i)
    fmt::print("{},{},{:.6f},{:.10e},{:.10e}\n", figure, curve, leaf.mesh().x()[i], line.u[i],
               line.v[i]);
}

/// Deflection at x0 + V z under a tip force across, in `steps`; V empty: the full leaf. Nothing if
/// Newton fails.
std::optional<VectorXd> deflection(const std::shared_ptr<const PlateMesh>& mesh, const MatrixXd& V,
                                   double load, int steps) {
  PlateLeaf leaf(mesh, cantilever);
  PlateLeaf::State state = leaf.state();
  const VectorXd rest = state.x;
  VectorXd f = VectorXd::Zero(leaf.unknowns());
  f[leaf.block_offset(mesh->lines() - 1) + 2 * mesh->functions_per_line()] = load;
  const Vector12d held = Vector12d::Zero();
  bool converged = false;
  for (int step = 1; step <= steps; ++step) {
    converged = false;
    for (int it = 0; it < 60 && !converged; ++it) {
      leaf.linearise();
      const VectorXd r = leaf.residual() - f * (double(step) / steps);
      VectorXd dx;
      if (V.cols() > 0) {
        const MatrixXd H = V.transpose() * leaf.tangent_times(V);
        dx = -V * H.ldlt().solve(V.transpose() * r);
      } else {
        leaf.eliminate();
        dx = -r;
        leaf.solve(dx);
      }
      if (!dx.allFinite() || dx.cwiseAbs().maxCoeff() > 1e3) return std::nullopt;
      state.x += dx;
      leaf.step_to(state, dx, held);
      converged = dx.cwiseAbs().maxCoeff() < 1e-10;
    }
    if (!converged) return std::nullopt;
  }
  return state.x - rest;
}

VectorXd unit_energy(const PlateLeaf& linear, const VectorXd& x) {
  return x / std::sqrt(x.dot(linear.tangent_times(x).col(0)));
}

/// Modes and their derivatives, columns of unit energy.
MatrixXd basis(const PlateLeaf& linear, const MatrixXd& modes, const MatrixXd& derivatives) {
  MatrixXd V(modes.rows(), modes.cols() + derivatives.cols());
  for (int k = 0; k < modes.cols(); ++k) V.col(k) = unit_energy(linear, modes.col(k));
  for (int k = 0; k < derivatives.cols(); ++k)
    V.col(modes.cols() + k) = unit_energy(linear, derivatives.col(k));
  return V;
}

}  // namespace

int main() {
  const auto mesh = mesh_of(10, thickness);
  PlateLeaf linear(mesh, cantilever);
  linear.linearise();
  PlateLeaf leaf(mesh, cantilever);
  leaf.assemble();
  const int n = leaf.unknowns(), tip = leaf.block_offset(mesh->lines() - 1);
  const int across = tip + 2 * mesh->functions_per_line();  // tip deflection; the slope follows it

  fmt::print("figure,curve,x,u,v\n");
  // figure 1: vibration modes with unit tip, φ of η a tip deflection
  std::vector<PlateLeaf::Mode> modes = leaf.modes(2);
  MatrixXd vibration(n, 2);
  for (int k = 0; k < 2; ++k) {
    modes[k].shape /= modes[k].shape[across];
    vibration.col(k) = modes[k].shape;
  }
  MatrixXd whole = MatrixXd::Zero(n + 12, 2);
  whole.topRows(n) = vibration;
  const MatrixXd vibration_md = derivatives_edges_held(leaf, second_order_forces(leaf, whole));

  // figure 2: boundary modes of the right node, unit deflection and unit rotation
  MatrixXd unit = MatrixXd::Zero(n, 2);
  unit(across, 0) = unit(across + 1, 1) = 1;
  leaf.solve(unit);
  Eigen::Matrix2d flexibility;
  flexibility << unit.row(across), unit.row(across + 1);
  const MatrixXd boundary = unit * flexibility.inverse();
  whole.topRows(n) = boundary;
  const MatrixXd boundary_md = derivatives_edges_held(leaf, second_order_forces(leaf, whole));

  const char* names[2] = {"1", "2"};
  for (int k = 0; k < 2; ++k) {
    print("1", fmt::format("phi{}", names[k]), leaf, vibration.col(k));
    print("2", k == 0 ? "phi_v" : "phi_phi", leaf, boundary.col(k));
  }
  const char* pairs[2][3] = {{"theta11", "theta12", "theta22"},
                             {"theta_vv", "theta_vphi", "theta_phiphi"}};
  for (int k = 0; k < 3; ++k) {
    print("1", pairs[0][k], leaf, vibration_md.col(k));
    print("2", pairs[1][k], leaf, boundary_md.col(k));
  }

  // figure 3: P L²/EI = 2, and larger ones for the load–deflection curve
  const MatrixXd V1 = basis(linear, vibration, vibration_md),
                 V2 = basis(linear, boundary, boundary_md);
  const MatrixXd none(n, 0);
  for (const double p : {0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0}) {
    const std::pair<const char*, const MatrixXd*> models[] = {
        {"full", &none},
        {"2 modes + 3 derivatives", &V1},
        {"2 boundary modes + 3 derivatives", &V2}};
    for (const auto& [name, V] : models) {
      const auto x = deflection(mesh, *V, p * width, 20);
      if (!x) continue;
      if (p == 2.0) print("3", name, leaf, *x);
      fmt::print("3 load,{},{:g},{:.10e},{:.10e}\n", name, p, (*x)[tip], (*x)[across]);
    }
  }
}
