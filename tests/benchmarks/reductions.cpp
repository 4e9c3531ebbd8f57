// Errors of the reductions over the stroke, against full leaves on the same mesh.
//
// Parallel guide to 0.3 L and cross hinge to 30° and 45°, beam leaves of 100 × 30 × 0.5 mm. Prints
// the table of core/reduction/superelement/README.md: 32 elements a leaf, as in the planar
// prototype.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <optional>

#include "core/elements/plate/full_leaf.hpp"
#include "core/elements/plate/full_model.hpp"
#include "core/equilibrium/end_effector_compliance.hpp"
#include "core/reduction/superelement/leaf_chain.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/modes/frequencies.hpp"
#include "support/models.hpp"
#include "support/one_stroke.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

using Leaves = std::vector<std::unique_ptr<LeafElement>>;

struct Point {
  double load = 0, support = 0, frequency = 0;
  Vector3d shift;
};

struct Path {
  std::vector<Point> points;  ///< as far as it got
  int iterations = 0, sub_steps = 0;
};

constexpr double length = 0.1, width = 0.03, thickness = 5e-4;

struct System2 {
  const char* name;
  Mechanism mechanism;
  std::vector<double> strokes;
};

// Shift of O; of the guide along the leaves, of the hinge in its plane.
Path follow(const Mechanism& mechanism, const std::vector<double>& strokes, Leaves leaves) {
  Path path;
  System system(mechanism, std::move(leaves));
  const bool turns = is_rotation(drive_direction(mechanism));
  for (const double stroke : strokes) {
    const Equilibrium e = step_to(system, stroke, {});
    if (!e.converged) return path;
    path.iterations += e.iterations;
    path.sub_steps += e.sub_steps;
    Point p;
    p.load = e.drive_load;
    p.shift = system.pose(0).position - mechanism.bodies[0].reference;
    p.shift.z() = 0;
    if (!turns) p.shift.y() = 0;
    const Matrix6d C = end_effector_compliance(system).drive_locked;
    // guide: along the leaves; hinge: the smallest in the plane
    p.support = turns ? 1 / Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(C.topLeftCorner<2, 2>())
                                .eigenvalues()[1]
                      : 1 / C(0, 0);
    // the lowest planar frequency with the drive locked
    const Frequencies f = natural_frequencies(system, {.count = 8, .leaf_modes = 2}).value();
    for (const Mode& mode : f.locked) {
      const Vector6d motion = mode.motion.head<6>().cwiseAbs();
      if (motion[0] + motion[1] + motion[5] < motion[2] + motion[3] + motion[4]) continue;
      if (mode.kind == ModeKind::leaf) continue;
      p.frequency = mode.frequency;
      break;
    }
    path.points.push_back(p);
  }
  return path;
}

struct Errors {
  double load = 0, shift = 0, support = 0, frequency = 0;
};

Errors errors(const Path& path, const Path& reference, std::size_t count) {
  Errors e;
  for (std::size_t k = 0; k < count; ++k) {
    const Point &a = path.points[k], &b = reference.points[k];
    const auto relative = [](double x, double y) { return std::abs(x / y - 1); };
    e.support = std::max(e.support, relative(a.support, b.support));
    if (a.frequency > 0 && b.frequency > 0)
      e.frequency = std::max(e.frequency, relative(a.frequency, b.frequency));
    if (k == 0) continue;
    e.load = std::max(e.load, relative(a.load, b.load));
    if (k > 1) e.shift = std::max(e.shift, (a.shift - b.shift).norm() / b.shift.norm());
  }
  return e;
}

std::string shown(double error) {
  if (error >= 1) return fmt::format("{:.2g}×", 1 + error);
  return error >= 1e-3 ? fmt::format("{:.2g} %", 100 * error) : fmt::format("{:.0e}", error);
}

Leaves full_segments(const Mechanism& mechanism, const ModelOptions& model) {
  const int n = model.superelements[0];
  if (n == 1) return make_full_leaves(mechanism, model);
  Leaves leaves;
  for (const LeafSpring& leaf : mechanism.leaves) {
    const auto mesh =
        std::make_shared<PlateMesh>(leaf_shape(leaf_segment(leaf, 0, n), segment_options(model)));
    Leaves segments;
    for (int k = 0; k < n; ++k)
      segments.push_back(std::make_unique<FullLeaf>(leaf_segment(leaf, k, n), mesh, 0));
    leaves.push_back(
        std::make_unique<LeafChain>(leaf, std::move(segments), leaf_shape(leaf, model), 0));
  }
  return leaves;
}

}  // namespace

int main() {
  const double L = length, degree = std::numbers::pi / 180;
  std::vector<System2> systems;
  systems.push_back(
      {"guide",
       models::guide(L, width, thickness, 0.06, 30, 30 * 2 * 0.08 * 0.08 / 12),
       {0, 0.01 * L, 0.02 * L, 0.05 * L, 0.1 * L, 0.15 * L, 0.2 * L, 0.25 * L, 0.3 * L}});
  std::vector<double> angles;
  for (const double a : {0.0, 1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 37.5, 45.0})
    angles.push_back(a * degree);
  systems.push_back(
      {"hinge",
       models::hinge(L, thickness, {{1, 0, width}, {-1, 0, width}}, 20, 20 * 0.1 * 0.1 / 6),
       angles});

  struct Variant {
    std::string name;
    ModelOptions model;
    std::vector<int> cuts;
  };
  ModelOptions base{.flexure = Flexure::beam, .mesh = {32, 1}};
  std::vector<Variant> variants;
  const auto add = [&](const char* name, Reduction method, ModalDerivativeSet set,
                       std::vector<int> cuts, int order = 5) {
    ModelOptions m = base;
    m.method = method;
    m.modal_derivatives = set;
    m.degree = order;
    variants.push_back({name, m, std::move(cuts)});
  };
  using enum ModalDerivativeSet;
  add("linear Craig–Bampton", Reduction::linear_craig_bampton, all, {1, 2, 4});
  add("bending derivatives", Reduction::modal_derivatives, bending, {1, 2, 4});
  add("all derivatives", Reduction::modal_derivatives, all, {1, 2, 4});
  add("and third order", Reduction::modal_derivatives, third_order, {1, 2, 4});
  add("quadratic manifold", Reduction::quadratic_manifold, all, {1, 2, 4});
  add("tube, degree 5", Reduction::mixed_potential, all, {1}, 5);
  add("tube, degree 7", Reduction::mixed_potential, all, {1}, 7);

  const PageTable page("reductions");
  fmt::print(
      "| | n | load guide | shift | support stiffness | frequency | load hinge 30° / 45° | "
      "shift | support stiffness | frequency | iterations |\n|");
  for (int k = 0; k < 11; ++k) fmt::print("---|");
  fmt::print("\n");
  std::vector<std::vector<std::optional<Path>>> references(systems.size());
  for (auto& r : references) r.resize(5);
  for (const Variant& variant : variants)
    for (const int n : variant.cuts) {
      fmt::print("| {} | {} |", variant.name, n);
      std::string iterations;
      for (std::size_t s = 0; s < systems.size(); ++s) {
        const System2& system = systems[s];
        ModelOptions model = variant.model;
        model.superelements = {n, 0};
        auto& reference = references[s][n];
        if (!reference)
          reference =
              follow(system.mechanism, system.strokes, full_segments(system.mechanism, model));
        Leaves leaves = make_reduced_leaves(system.mechanism, model, system.strokes.back());
        const Path path = follow(system.mechanism, system.strokes, std::move(leaves));
        const std::size_t reached = path.points.size();
        const bool whole = reached == system.strokes.size();
        std::string cells[4];
        for (const std::size_t count :
             s == 0 ? std::vector<std::size_t>{9} : std::vector<std::size_t>{9, 11}) {
          const Errors e = errors(path, *reference, std::min(count, reached));
          const double values[4] = {e.load, e.shift, e.support, e.frequency};
          for (int k = 0; k < 4; ++k)
            cells[k] +=
                (cells[k].empty() ? "" : " / ") + (reached < count ? "–" : shown(values[k]));
        }
        for (const std::string& cell : cells) fmt::print(" {} |", cell);
        iterations += fmt::format("{}{}", s > 0 ? " / " : "", path.iterations);
        if (path.sub_steps > static_cast<int>(reached))
          iterations += fmt::format(" ({} steps)", path.sub_steps);
        if (!whole) iterations += fmt::format(" to {:.3g}", system.strokes[reached]);
      }
      fmt::print(" {} |\n", iterations);
      std::fflush(stdout);
    }
}
