// The block-tridiagonal factorisation of a leaf against CHOLMOD of SuiteSparse.
//
// Matrices of the pattern of a leaf: each node of a line couples with its neighbours on three
// lines.
#include <fmt/format.h>

#include <Eigen/CholmodSupport>
#include <algorithm>
#include <chrono>
#include <functional>
#include <vector>

#include "core/math/block_tridiagonal.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

double median_seconds(int runs, const std::function<void()>& call) {
  std::vector<double> times;
  for (int k = 0; k < runs; ++k) {
    const auto start = std::chrono::steady_clock::now();
    call();
    times.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  std::sort(times.begin(), times.end());
  return times[runs / 2];
}

// Random, symmetric, diagonally dominant, with the couplings of a BFS mesh (12 dofs a node).
void fill(int lines, int nodes, BlockTridiagonal& K, Eigen::SparseMatrix<double>& sparse) {
  const int n = 12 * nodes;
  K.resize(std::vector<int>(lines, n));
  std::vector<Eigen::Triplet<double>> entries;
  auto coupled = [](int a, int b) { return std::abs(a / 12 - b / 12) <= 1; };
  for (int i = 0; i < lines; ++i) {
    K.diagonal[i] = MatrixXd::Zero(n, n);
    for (int a = 0; a < n; ++a)
      for (int b = 0; b <= a; ++b) {
        if (!coupled(a, b)) continue;
        const double v = a == b ? 200 : 0.5 * std::sin(a + 3.0 * b + i);
        K.diagonal[i](a, b) = K.diagonal[i](b, a) = v;
        entries.emplace_back(i * n + a, i * n + b, v);
      }
    if (i == 0) continue;
    K.below[i - 1] = MatrixXd::Zero(n, n);
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) {
        if (!coupled(a, b)) continue;
        const double v = 0.5 * std::cos(a - 2.0 * b + i);
        K.below[i - 1](a, b) = v;
        entries.emplace_back(i * n + a, (i - 1) * n + b, v);
      }
  }
  sparse.resize(lines * n, lines * n);
  sparse.setFromTriplets(entries.begin(), entries.end());
}

}  // namespace

int main() {
  const PageTable page("factorisation");
  fmt::print(
      "| mesh | block-tridiagonal | CHOLMOD, supernodal | CHOLMOD, simplicial | difference of the "
      "solutions |\n|---|---|---|---|---|\n");
  for (const auto& [nx, ny] : {std::pair{10, 4}, {16, 4}, {16, 8}, {28, 14}}) {
    BlockTridiagonal pattern;
    Eigen::SparseMatrix<double> sparse;
    fill(nx + 1, ny + 1, pattern, sparse);
    BlockTridiagonal K = pattern;
    const double block = median_seconds(21, [&] {
      K.diagonal = pattern.diagonal;
      K.below = pattern.below;
      K.factorise();
    });
    Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> super;
    super.analyzePattern(sparse);
    const double supernodal = median_seconds(21, [&] { super.factorize(sparse); });
    Eigen::CholmodSimplicialLLT<Eigen::SparseMatrix<double>> simple;
    simple.analyzePattern(sparse);
    const double simplicial = median_seconds(7, [&] { simple.factorize(sparse); });
    MatrixXd b = MatrixXd::Ones(sparse.rows(), 1), x = b;
    K.solve(x);
    const double difference = (x - super.solve(b)).norm() / x.norm();
    fmt::print("| {}×{} | {:.2f} ms | {:.1f} times that | {:.1f} times that | {:.0e} |\n", nx, ny,
               block * 1e3, supernodal / block, simplicial / block, difference);
  }
}
