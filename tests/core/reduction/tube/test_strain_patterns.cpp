#include <catch2/catch.hpp>

#include "core/reduction/tube/strain_patterns.hpp"

using namespace flexopt;

namespace {

constexpr std::array<int, 2> mesh{4, 2};

StressPlaces places_of_leaf() {
  PlateShape shape{.mesh = mesh};
  return StressPlaces(shape);
}

// As many patterns as there are rows: they leave nothing out.
std::array<MatrixXd, StrainPatterns::families> whole_patterns() {
  const StressPlaces places = places_of_leaf();
  std::array<MatrixXd, StrainPatterns::families> P;
  for (int f = 0; f < StrainPatterns::families; ++f) {
    const Eigen::Index rows =
        StrainPatterns::folded(places, f, MatrixXd::Zero(places.rows(), 1)).rows();
    const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(MatrixXd::Random(rows, rows)).householderQ();
    P[static_cast<std::size_t>(f)] = (f == StrainPatterns::places_family ? 1 : std::sqrt(0.5)) * Q;
  }
  return P;
}

}  // namespace

TEST_CASE("patterns of strains and places give back what their coefficients were made of") {
  std::srand(4);
  const StrainPatterns patterns(mesh, whole_patterns());
  const StressPlaces places = places_of_leaf();
  StateTable node{0.1, MatrixXd::Random(places.rows(), StateTable::even_monomials),
                  MatrixXd::Random(places.rows(), StateTable::odd_monomials)};
  constexpr double thickness = 0.02;
  const StateTable a = patterns.coefficients(node, thickness);
  for (const auto part : {&StateTable::even, &StateTable::odd}) {
    const MatrixXd &rows = node.*part, &c = a.*part;
    CHECK(c.rows() == patterns.all());
    const MatrixXd strains = patterns.strains_of(c.topRows(patterns.strains()), thickness);
    CHECK((strains - rows.topRows(places.strain_rows())).norm() < 1e-6 * rows.norm());
    const MatrixXd found = patterns.places_of(6, 5, c.bottomRows(patterns.count(4)));
    CHECK((found - rows.middleRows(places.strain_rows() + 6, 5)).norm() < 1e-6 * rows.norm());

    // station by station the same
    const Eigen::Index stretching = patterns.stretching();
    for (const bool bending : {false, true}) {
      MatrixXd terms = (bending ? 2 : thickness) *
                       (bending ? c.middleRows(stretching, patterns.strains() - stretching)
                                : c.topRows(stretching))
                           .leftCols(2)
                           .transpose();
      for (const int along : {0, 3, 5, 7})
        for (const int across : {0, 1}) {
          const auto station = patterns.at<2>(along, across, bending, terms);
          for (int component = 0; component < 3; ++component) {
            const Eigen::Index row =
                along + places.stations_along() *
                            (across + places.half_across() * (component + (bending ? 3 : 0)));
            for (int column = 0; column < 2; ++column)
              CHECK(station(column, component) == Approx(strains(row, column)).margin(1e-6));
          }
        }
    }
  }
}

TEST_CASE("no strain of patterns is larger than the norm of its coefficients times that of a row") {
  std::srand(5);
  const std::array<MatrixXd, StrainPatterns::families> P = whole_patterns();
  std::array<MatrixXd, StrainPatterns::families> some;
  for (std::size_t f = 0; f < P.size(); ++f) some[f] = P[f].leftCols(9);
  const StrainPatterns patterns(mesh, some);
  const Eigen::Index half = places_of_leaf().strain_rows() / 2;
  for (const bool bending : {false, true}) {
    double closest = 0;
    for (int k = 0; k < 200; ++k) {
      VectorXd a = VectorXd::Zero(patterns.strains());
      a.segment(bending ? 18 : 0, 18).setRandom();
      const double
          most =
              patterns.strains_of(a, 1).middleRows(bending ? half : 0, half).cwiseAbs().maxCoeff() /
              (bending ? 2 : 1),
          bound = patterns.largest_norm(bending) * a.norm();
      CHECK(most <= bound * (1 + 1e-6));
      closest = std::max(closest, most / bound);
    }
    CHECK(closest > 0.5);
  }
}
