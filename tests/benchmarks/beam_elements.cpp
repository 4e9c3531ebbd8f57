// Errors of beam leaves by the number of elements, and of superelements, per leaf.
//
// Full beam leaves, 40 elements the reference: parallel guide to
// 0.2 L and cross hinge to 30°, the undeflected state included. Largest over the stroke in %:
// drive load / support stiffness in z / worst support stiffness (direction). Prints the tables of
// core/elements/plate/beams.md; the second one is of superelements per leaf, with linear local
// strains and with second-order ones (modal derivatives), ends and cuts free to warp.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "support/models.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

struct Errors {
  double drive = 0, support = 0, lateral = 0;  ///< lateral: uz
  int direction = 0;
};

Errors errors(const StrokeResponse& coarse, const StrokeResponse& fine) {
  Errors e;
  for (std::size_t k = 0; k < fine.path.size(); ++k) {
    const PathPoint &a = coarse.path[k], &b = fine.path[k];
    if (b.stroke != 0) e.drive = std::max(e.drive, std::abs(a.drive_load / b.drive_load - 1));
    for (int d = 0; d < 6; ++d)
      if (b.support_stiffness[d]) {
        const double error = std::abs(*a.support_stiffness[d] / *b.support_stiffness[d] - 1);
        if (error > e.support) e.support = error, e.direction = d;
        if (d == index(Direction::uz)) e.lateral = std::max(e.lateral, error);
      }
  }
  return e;
}

StrokeResponse evaluate(const Mechanism& m, double end, const ModelOptions& model) {
  StrokeRequest request;
  request.points = {0, end / 4, end / 2, 0.75 * end, end};
  request.outputs.remove(Output::stress);
  return evaluate_stroke(m, model, request);
}

ModelOptions full(int elements, Warping warping = Warping::clamped) {
  return {.accuracy = Accuracy::full,
          .flexure = Flexure::beam,
          .warping = warping,
          .mesh = {elements, 1}};
}

ModelOptions cut(Reduction method, int superelements) {
  return {.flexure = Flexure::beam,
          .warping = Warping::free,
          .mesh = {10, 1},
          .method = method,
          .superelements = {superelements, 0}};
}

struct Column {
  std::string name;
  ModelOptions model;
};

void print_table(const std::vector<Column>& columns, const ModelOptions& reference) {
  const double L = 0.1;
  fmt::print("| | L/w | L/t |");
  for (const Column& c : columns) fmt::print(" {} |", c.name);
  fmt::print("\n|---|---|---|");
  for (std::size_t k = 0; k < columns.size(); ++k) fmt::print("---|");
  fmt::print("\n");
  for (const bool guided : {true, false})
    for (const double thinness : {100.0, 200.0, 500.0})
      for (const double aspect : {10.0, 3.3, 1.0}) {
        const double w = L / aspect, t = L / thinness;
        const Mechanism m = guided ? models::guide(L, w, t)
                                   : models::hinge(L, t, {{1, 0.55 * w, w}, {-1, -0.55 * w, w}});
        const double end = guided ? 0.2 * L : std::numbers::pi / 6;
        const StrokeResponse fine = evaluate(m, end, reference);
        fmt::print("| {} | {:g} | {:g} |", guided ? "guide" : "cross hinge", aspect, thinness);
        for (const Column& c : columns) {
          const StrokeResponse coarse = evaluate(m, end, c.model);
          if (coarse.status != Status::ok || fine.status != Status::ok) {
            fmt::print(" no equilibrium |");
            continue;
          }
          const Errors e = errors(coarse, fine);
          fmt::print(" {:.2g} / {:.2g} / {:.2g} ({}) |", 100 * e.drive, 100 * e.lateral,
                     100 * e.support, direction_names[static_cast<std::size_t>(e.direction)]);
        }
        fmt::print("\n");
        std::fflush(stdout);
      }
}

}  // namespace

int main() {
  std::vector<Column> elements;
  for (const int n : {2, 4, 8, 10, 16})
    elements.push_back({fmt::format("{} elements", n), full(n)});
  {
    const PageTable page("beam_elements elements");
    print_table(elements, full(40));
  }
  std::vector<Column> cuts;
  for (const int n : {2, 4, 8, 16})
    cuts.push_back({fmt::format("{} linear", n), cut(Reduction::linear_craig_bampton, n)});
  for (const int n : {1, 2, 4})
    cuts.push_back({fmt::format("{} second-order", n), cut(Reduction::modal_derivatives, n)});
  for (const int n : {1, 2, 4}) {
    ModelOptions model = cut(Reduction::modal_derivatives, n);
    model.modal_derivatives = ModalDerivativeSet::third_order;
    cuts.push_back({fmt::format("{} third-order", n), model});
  }
  const PageTable page("beam_elements superelements");
  print_table(cuts, full(40, Warping::free));
}
