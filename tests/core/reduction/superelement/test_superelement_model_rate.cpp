#include "core/reduction/superelement/superelement_model_rate.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "core/math/ridders.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

struct Grid {
  std::string name;
  LeafSpring leaf;
  ModelOptions model;
};

LeafSpring plate(double width, double thickness) {
  return models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, width, thickness);
}

std::vector<Grid> grids() {
  ModelOptions model{.method = Reduction::linear_craig_bampton, .leaf_modes = 6};
  std::vector<Grid> all;
  const auto add = [&](std::string name, LeafSpring leaf, std::array<int, 2> superelements) {
    model.superelements = superelements;
    all.push_back({std::move(name), std::move(leaf), model});
  };
  add("one segment", plate(0.03, 5e-4), {1, 0});
  add("segments", plate(0.05, 2e-3), {3, 0});
  add("a row of patches", plate(0.03, 5e-4), {3, 1});
  add("patches", plate(0.06, 1e-3), {2, 3});
  model.free_edge_torsion = false;
  add("thin patches", plate(0.04, 3e-4), {3, 2});
  model.free_edge_torsion = true;
  model.flexure = Flexure::beam;
  add("one beam", plate(0.02, 1e-3), {1, 0});
  model.warping = Warping::free;
  add("beams", plate(0.02, 1e-3), {3, 0});
  LeafSpring wire = plate(1e-3, 1e-3);
  wire.section = Section::circular;
  add("wires", wire, {2, 0});
  return all;
}

// Of a model or its rate along a direction, numbers without the choice of the modes' basis: with
// C of M_CB between boundary and modes, Λ of K_CB, those of K, M, Φ_CB, the nodes, the fields, of
// C Cᵀ and C Λ Cᵀ, and the sums of Λ and Λ².
struct Numbers {
  std::vector<std::pair<std::string, VectorXd>> part;
};
Numbers numbers(const SuperelementModel& m, const SuperelementModel& rate, bool derivative) {
  const int n = m.coordinates(), k = static_cast<int>(m.stiffness.rows()) - n;
  const MatrixXd C = m.mass.topRightCorner(n, k), dC = rate.mass.topRightCorner(n, k),
                 Lambda = m.stiffness.bottomRightCorner(k, k),
                 dLambda = rate.stiffness.bottomRightCorner(k, k);
  const SuperelementModel& of = derivative ? rate : m;
  VectorXd nodes(3 * m.nodes.size());
  for (std::size_t a = 0; a < m.nodes.size(); ++a) nodes.segment<3>(3 * a) = of.nodes[a];
  const auto both = [](const MatrixXd& A) { return MatrixXd(A + A.transpose()); };
  const MatrixXd CC = derivative ? both(dC * C.transpose()) : MatrixXd(C * C.transpose()),
                 CLC =
                     derivative
                         ? MatrixXd(both(dC * Lambda * C.transpose()) + C * dLambda * C.transpose())
                         : MatrixXd(C * Lambda * C.transpose());
  const auto number = [](double x) { return VectorXd(VectorXd::Constant(1, x)); };
  const VectorXd sum = number(of.stiffness.bottomRightCorner(k, k).trace()),
                 squares = number(derivative ? 2 * Lambda.cwiseProduct(dLambda).sum()
                                             : Lambda.squaredNorm());
  const auto flat = [](const MatrixXd& A) { return VectorXd(A.reshaped()); };
  return {{{"nodes", nodes},
           {"stiffness", flat(of.stiffness.topLeftCorner(n, n))},
           {"mass", flat(of.mass.topLeftCorner(n, n))},
           {"frame", flat(of.frame_modes)},
           {"fields", flat(of.recovery)},
           {"coupling", flat(CC)},
           {"coupling by frequencies", flat(CLC)},
           {"frequencies", sum},
           {"squares of them", squares}}};
}

}  // namespace

TEST_CASE("rates of superelements agree with differences of rebuilt ones", "[reduction][slow]") {
  for (const Grid& g : grids()) {
    const SuperelementGrid grid(g.leaf, g.model);
    const SuperelementModelRate rate(grid);
    const bool wire = g.leaf.section == Section::circular;
    const auto built = [&](int direction, double t) {
      LeafSpring leaf = g.leaf;
      const double L = leaf.length;
      if (direction == 0) leaf.width += t * leaf.width;
      if (direction == 1) leaf.thickness += t * leaf.thickness;
      if (direction == 2) leaf.material.poissons_ratio += t;
      if (direction == 3) leaf.length += t * L;
      if (wire && direction == 1) leaf.width = leaf.thickness;
      return SuperelementModelRate(SuperelementGrid(leaf, g.model));
    };
    for (int direction = wire ? 1 : 0; direction < 4; ++direction) {
      std::map<double, SuperelementModelRate> moved;  // the same ones for all rows
      const double w = g.leaf.width / g.leaf.length, t = g.leaf.thickness / g.leaf.length;
      const Vector3d along = direction == 3   ? Vector3d(-w, -t, 0)
                             : direction == 2 ? Vector3d(0, 0, 1)
                             : direction == 1 ? Vector3d(wire ? w : 0, t, 0)
                                              : Vector3d(w, 0, 0);
      for (int row = 0; row < grid.rows(); ++row) {
        const ScaledSuperelement& here = rate[row];
        SuperelementModel sum = here.shape[0];
        for (std::size_t a = 0; a < sum.nodes.size(); ++a) {
          sum.nodes[a].setZero();
          for (int p = 0; p < 3; ++p) sum.nodes[a] += along[p] * here.shape[p].nodes[a];
        }
        for (MatrixXd SuperelementModel::*A :
             {&SuperelementModel::stiffness, &SuperelementModel::mass,
              &SuperelementModel::frame_modes, &SuperelementModel::recovery}) {
          (sum.*A).setZero();
          for (int p = 0; p < 3; ++p) sum.*A += along[p] * (here.shape[p].*A);
        }
        const Numbers exact = numbers(here.model, sum, true),
                      value = numbers(here.model, sum, false);
        const Derivatives d = ridders(
            [&](double s) {
              if (!moved.contains(s)) moved.emplace(s, built(direction, s));
              std::vector<double> all;
              for (const auto& [name, part] : numbers(moved.at(s)[row].model, sum, false).part)
                all.insert(all.end(), part.begin(), part.end());
              return all;
            },
            0, 0.02, 6);
        Eigen::Index o = 0;
        for (std::size_t i = 0; i < exact.part.size(); ++i) {
          const auto& [name, part] = exact.part[i];
          const VectorXd differences = Eigen::Map<const VectorXd>(d.value.data() + o, part.size());
          const double error = (part - differences).norm(), size = value.part[i].second.norm();
          INFO(g.name << ", row " << row << ", direction " << direction << ": " << name);
          CHECK(error <= 1e-9 * size);
          o += part.size();
        }
      }
    }
  }
}
