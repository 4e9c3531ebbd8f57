#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/decompositions.hpp"
#include "core/math/dense_pencil.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/mechanism.hpp"
#include "designs/solids/import_matrices.hpp"

namespace flexopt {
namespace {

constexpr double most_asymmetry = 1e-8, most_residual = 1e-6, most_zero = 1e-6, least_other = 1e-5,
                 least_mass = -1e-6, most_anisotropy = 1e-6, most_off = 1e-3, most_coupling = 1e-6,
                 most_misplaced = 1e-6;
using Faults = std::vector<ImportFault>;

/// d_i⁻¹ᐟ² of the diagonal of A; 1 where it is zero.
VectorXd scale_of(const MatrixXd& A) {
  return A.diagonal().unaryExpr([](double d) { return d == 0 ? 1.0 : 1 / std::sqrt(std::abs(d)); });
}
MatrixXd scaled(const MatrixXd& A) {
  const VectorXd s = scale_of(A);
  return s.asDiagonal() * A * s.asDiagonal();
}

/// Coordinates of rigid motions: unit displacements, then unit rotations about the own origin.
MatrixXd rigid_motions(const std::vector<ImportedInterface>& interfaces, Eigen::Index size) {
  MatrixXd motions = MatrixXd::Zero(size, 6);
  for (std::size_t a = 0; a < interfaces.size(); ++a) {
    motions.block<6, 6>(6 * a, 0).setIdentity();
    motions.block<3, 3>(6 * a, 3) = -hat(interfaces[a].place);
  }
  return motions;
}

/// Largest distance between interfaces [m].
double size_of(const std::vector<ImportedInterface>& interfaces) {
  double size = 0;
  for (const ImportedInterface& a : interfaces)
    for (const ImportedInterface& b : interfaces) size = std::max(size, (a.place - b.place).norm());
  return size;
}

bool check_symmetry(const char* key, const MatrixXd& A, ImportFigures& figures, Faults& faults) {
  if (!A.allFinite()) {
    faults.push_back({key, "not finite", "check 1: every entry is a finite number"});
    return false;
  }
  const MatrixXd unit = scaled(A);
  const double off = (unit - unit.transpose()).norm() / std::max(unit.norm(), 1e-300);
  figures.asymmetry = std::max(figures.asymmetry, off);
  if (off > most_asymmetry)
    faults.push_back({key, fmt::format("asymmetry {:.2g}", off),
                      fmt::format("check 1: a symmetric matrix, to {:g} of its norm where its "
                                  "diagonal is scaled to 1",
                                  most_asymmetry)});
  return off <= most_asymmetry;
}

// Rigid motions of unit size, measured by the diagonal of K: independent of units.
bool check_rigid(const MatrixXd& stiffness, const std::vector<ImportedInterface>& interfaces,
                 ImportFigures& figures, Faults& faults) {
  const Eigen::Index n = 6 * static_cast<Eigen::Index>(interfaces.size());
  const MatrixXd K = stiffness.topLeftCorner(n, n);
  const VectorXd s = scale_of(K);
  const MatrixXd motions = s.cwiseInverse().asDiagonal() * rigid_motions(interfaces, n);
  const MatrixXd unit = motions * motions.colwise().norm().cwiseInverse().asDiagonal();
  const MatrixXd orthonormal =
      Eigen::HouseholderQR<MatrixXd>(unit).householderQ() * MatrixXd::Identity(n, 6);
  Eigen::Index row = 0, column = 0;
  figures.rigid_residual = (scaled(K) * orthonormal).cwiseAbs().maxCoeff(&row, &column);
  if (figures.rigid_residual <= most_residual) return true;
  faults.push_back(
      {"stiffness",
       fmt::format("{:.2g}, largest at {}.{}", figures.rigid_residual, interfaces[row / 6].name,
                   direction_names[row % 6]),
       fmt::format("check 2: forces of rigid motions are below {:g} of the stiffness; they are not "
                   "where places, axes or order of the interfaces are others than those of the "
                   "matrix, turns are not in rad, the body is held, or the matrix is not condensed",
                   most_residual)});
  return false;
}

bool check_positive(const MatrixXd& K, ImportFigures& figures, Faults& faults) {
  const VectorXd values = symmetric_eigenvalues(scaled(K));
  VectorXd sizes = values.cwiseAbs();
  std::ranges::sort(sizes);
  figures.sixth = sizes[5];
  figures.seventh = sizes[6];
  const auto zeros = (sizes.array() < most_zero).count();
  if (values[0] > -most_zero && zeros == 6 && figures.seventh >= least_other) return true;
  const char* cause = values[0] <= -most_zero ? "a negative one is no elastic body's"
                      : zeros < 6             ? "with fewer, the ground holds the body"
                                  : "with more, an interface or a part hangs on nothing";
  faults.push_back(
      {"stiffness",
       fmt::format("{} of them; smallest {:.2g}, sixth {:.2g}, seventh {:.2g}", zeros, values[0],
                   figures.sixth, figures.seventh),
       fmt::format("check 3: exactly six eigenvalues of the scaled matrix are below {:g}, the "
                   "others above {:g}; {}",
                   most_zero, least_other, cause)});
  return false;
}

/// Whether `found` is `expected` to 1e-3 of `unit`; else a fault.
void compare(const std::string& key, double found, double expected, double unit, Faults& faults) {
  const double off = std::abs(found - expected) / unit;
  if (off <= most_off) return;
  faults.push_back({"expected/" + key,
                    fmt::format("{:.7g}, of the matrix {:.7g} (SI)", expected, found),
                    fmt::format("check {}: off by {:.2g}; at most {:g}",
                                key.starts_with("free") ? 5 : 4, off, most_off)});
}

void compare_mass(const ExpectedBody& expected, double size, const ImportFigures& figures,
                  Faults& faults) {
  compare("mass", figures.mass, expected.mass, expected.mass, faults);
  for (int i = 0; i < 3; ++i)
    compare("center_of_mass", figures.center_of_mass[i], expected.center_of_mass[i], size, faults);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j)
      if (i == j || expected.products)
        compare("inertia", figures.inertia(i, j), expected.inertia(i, j),
                std::sqrt(expected.inertia(i, i) * expected.inertia(j, j)), faults);
}

bool check_mass(const MatrixXd& M, const std::vector<ImportedInterface>& interfaces,
                const ExpectedBody* expected, ImportFigures& figures, Faults& faults) {
  const MatrixXd motions = rigid_motions(interfaces, M.rows());
  const Matrix6d rigid = motions.transpose() * M * motions;
  const double mass = rigid.topLeftCorner<3, 3>().trace() / 3, size = size_of(interfaces),
               least = symmetric_eigenvalues(scaled(M))[0];
  const Matrix3d moments = rigid.topRightCorner<3, 3>();  // −m hat(c)
  const double uneven =
      std::max((rigid.topLeftCorner<3, 3>() / mass - Matrix3d::Identity()).cwiseAbs().maxCoeff(),
               (moments + moments.transpose()).cwiseAbs().maxCoeff() / (2 * mass * size));
  if (least < least_mass || !(mass > 0) || uneven > most_anisotropy) {
    faults.push_back({"mass",
                      fmt::format("least eigenvalue {:.2g}, mass {:.7g} kg, uneven by {:.2g}",
                                  least, mass, uneven),
                      fmt::format("check 4: no eigenvalue of the scaled matrix is below {:g}, and "
                                  "its mass is the same in all directions to {:g}",
                                  least_mass, most_anisotropy)});
    return false;
  }
  figures.mass = mass;
  const Matrix3d skew = (moments.transpose() - moments) / (2 * mass);
  figures.center_of_mass = {skew(2, 1), skew(0, 2), skew(1, 0)};
  const Matrix3d arm = hat(figures.center_of_mass);
  figures.inertia = rigid.bottomRightCorner<3, 3>() + mass * arm * arm;
  if (expected == nullptr)
    faults.push_back({"expected", "nothing",
                      "check 4: tell mass, center_of_mass and inertia, which confirm the units"});
  else
    compare_mass(*expected, size, figures, faults);
  return true;
}

void check_modes(const ImportedMatrices& matrices, Faults& faults) {
  const MatrixXd &K = matrices.stiffness, &M = matrices.mass;
  const int modes = matrices.modes;
  const MatrixXd unit = scaled(K);
  const double coupled =
      (unit.bottomRows(modes).cwiseAbs() - MatrixXd::Identity(K.rows(), K.rows()).bottomRows(modes))
          .cwiseAbs()
          .maxCoeff();
  if (coupled > most_coupling)
    faults.push_back(
        {"stiffness", fmt::format("{:.2g}", coupled),
         fmt::format("check 5: fixed-interface modes have no stiffness with each other "
                     "or with interfaces, to {:g} where the diagonal is scaled to 1",
                     most_coupling)});
  const double off =
      (M.bottomRightCorner(modes, modes) - MatrixXd::Identity(modes, modes)).cwiseAbs().maxCoeff();
  if (off > most_coupling)
    faults.push_back({"mass", fmt::format("off by {:.2g}", off),
                      fmt::format("check 5: the mass of the modes is 1 to {:g}", most_coupling)});
}

void check_frequencies(const ImportedMatrices& matrices, const ExpectedBody* expected,
                       ImportFigures& figures, Faults& faults) {
  const std::size_t told = expected == nullptr ? 0 : expected->free_frequencies.size();
  const EigenPairs pairs = lowest_dense_pairs(matrices.stiffness, matrices.mass,
                                              static_cast<int>(6 + std::max<std::size_t>(told, 6)));
  for (Eigen::Index i = 6; i < pairs.values.size(); ++i)
    figures.free_frequencies.push_back(std::sqrt(std::max(pairs.values[i], 0.0)) /
                                       (2 * std::numbers::pi));
  for (std::size_t i = 0; i < told; ++i)
    compare("free_frequencies",
            i < figures.free_frequencies.size() ? figures.free_frequencies[i] : 0,
            expected->free_frequencies[i], expected->free_frequencies[i], faults);
}

}  // namespace

std::vector<ImportFault> check_imported(const ImportedMatrices& matrices,
                                        const std::vector<ImportedInterface>& interfaces,
                                        const ExpectedBody* expected, ImportFigures& figures) {
  Faults faults;
  const bool stiff = check_symmetry("stiffness", matrices.stiffness, figures, faults) &&
                     check_rigid(matrices.stiffness, interfaces, figures, faults) &&
                     check_positive(matrices.stiffness, figures, faults);
  const bool massless = matrices.mass.isZero(0);
  const bool heavy = !massless && check_symmetry("mass", matrices.mass, figures, faults) &&
                     check_mass(matrices.mass, interfaces, expected, figures, faults);
  if (matrices.modes > 0 && stiff && (massless || heavy)) check_modes(matrices, faults);
  if (stiff && heavy && faults.empty()) check_frequencies(matrices, expected, figures, faults);
  return faults;
}

Check check_interface_place(const ImportedBody& body, const std::string& interface_name,
                            const Vector3d& place) {
  const auto found = std::ranges::find(body.interfaces, interface_name, &ImportedInterface::name);
  if (found == body.interfaces.end()) return Because("no interface of the body " + body.name);
  const double off = (found->place - place).norm() / size_of(body.interfaces);
  if (off <= most_misplaced) return {};
  return Because(fmt::format(
      "check 6: {} lies at ({:.9g}, {:.9g}, {:.9g}) m in the body's file, the design has it at "
      "({:.9g}, {:.9g}, {:.9g}) m: off by {:.2g} of the body's size, at most {:g}",
      interface_name, found->place[0], found->place[1], found->place[2], place[0], place[1],
      place[2], off, most_misplaced));
}

}  // namespace flexopt
