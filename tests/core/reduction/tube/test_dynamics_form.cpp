#include "core/reduction/tube/dynamics_form.hpp"

#include <catch2/catch.hpp>

#include "core/math/ridders.hpp"
#include "core/reduction/tube/tube_leaf.hpp"
#include "support/models.hpp"
#include "support/synthetic_leaf.hpp"

using namespace flexopt;
using flexopt::synthetic::Random;

namespace {

constexpr int P = TubeDynamics::amplitudes, R = TubeDynamics::rates;

// Tables of a leaf, each number of which changes with the shape at a slope of its own.
struct ChangingTables {
  std::vector<DynamicsNode> nodes;
  DynamicsRates rates = DynamicsRates(3);

  ChangingTables() {
    TubeModel model(std::make_shared<PlateMesh>(PlateShape{0.3, 0.005, 0.3, {6, 2}, true}), {});
    model.make_dynamics();
    REQUIRE(model.dynamics());
    Random random(5);
    for (std::size_t n = 0; n == 0 || nodes.back().table.sigma != model.dynamics()->last_sigma();
         ++n) {
      const DynamicsNode& node = nodes.emplace_back(model.dynamics()->node(n));
      for (auto& by : rates) {
        const auto changed = [&](const MatrixXd& part) {
          return MatrixXd(part.unaryExpr([&](double x) { return x * random(0.5); }));
        };
        by.push_back({node.table.sigma, changed(node.table.even), changed(node.table.odd)});
      }
    }
  }
  TubeDynamics at(const Vector3d& shape) const {
    TubeDynamics tables(0);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      DynamicsNode node = nodes[n];
      for (std::size_t p = 0; p < 3; ++p) {
        node.table.even += shape[static_cast<Eigen::Index>(p)] * rates[p][n].even;
        node.table.odd += shape[static_cast<Eigen::Index>(p)] * rates[p][n].odd;
      }
      tables.add(std::move(node));
    }
    return tables;
  }
};

}  // namespace

TEST_CASE("a form of looked-up dynamics is that of their matrices, and so are its derivatives") {
  const ChangingTables changing;
  Random random(9);
  const double mu = 40;
  for (const double sigma : {0.04, 0.15, -0.12}) {
    Vector6d place;
    place << sigma, random(0.02), random(0.01), random.vector<3>(0.3);
    DynamicsForm::Rates r;
    r << random.vector<12>(1.0), random.vector<P>(1.0);
    // of the state and the shape
    const auto matrices = [&](const Eigen::Matrix<double, 9, 1>& x) {
      const TubeDynamics::Answer answer =
          changing.at(x.tail<3>()).evaluate({x[0], x[1], x[2], x.segment<3>(3)});
      REQUIRE(answer.reason.empty());
      return answer;
    };
    Eigen::Matrix<double, 9, 1> here;
    here << place, Vector3d::Zero();
    const TubeDynamics::Answer answer = matrices(here);
    const DynamicsForm form(changing.at(Vector3d::Zero()),
                            {place[0], place[1], place[2], place.tail<3>()}, changing.rates);
    const DynamicsForm::Value value = form.at(r, mu);
    const auto eta = r.tail<P>();
    CHECK(value.stiffness == Approx(eta.dot(answer.stiffness * eta)).epsilon(1e-12));
    CHECK(value.mass == Approx(r.dot(answer.mass * r)).epsilon(1e-12));
    CHECK((value.along_mass - answer.mass * r).norm() < 1e-12 * value.along_mass.norm());
    Eigen::Matrix<double, 9, 1> exact;
    exact << value.state, value.shape;
    REQUIRE(exact.norm() > 0);
    for (int d = 0; d < 9; ++d) {
      const Derivatives differences = ridders(
          [&](double h) {
            Eigen::Matrix<double, 9, 1> x = here;
            x[d] += h;
            const TubeDynamics::Answer a = matrices(x);
            const DynamicsForm::Value v{eta.dot(a.stiffness * eta), r.dot(a.mass * r), {}, {}, {}};
            return std::vector<double>{v.stiffness - mu * v.mass};
          },
          0, 0.005, 5);
      INFO(sigma << ", " << d << ": " << exact[d] << " not " << differences.value[0] << " ± "
                 << differences.error[0]);
      const double size = std::abs(exact[d]) + std::abs(value.stiffness) + mu * value.mass;
      CHECK(std::abs(exact[d] - differences.value[0]) < 1e-10 * size + 10 * differences.error[0]);
      CHECK(differences.error[0] < 1e-7 * size);
    }
  }
}
