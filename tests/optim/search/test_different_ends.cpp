#include "optim/search/stages.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

Candidate end(double x, double objective, double violation = 0) {
  return {VectorXd::Constant(2, x), {}, objective, violation};
}

using Groups = std::vector<std::vector<int>>;

}  // namespace

TEST_CASE("ends are the same where objective and design agree") {
  const Candidate a = end(0.5, 100), near = end(0.52, 100.05), elsewhere = end(0.9, 100.05),
                  other = end(0.51, 101);
  CHECK(different_ends({&a, &near, nullptr, &elsewhere, &other}, true, 1e-4) ==
        Groups{{4}, {1, 0}, {3}});
  CHECK(different_ends({&a, &near, &elsewhere, &other}, false, 1e-4) == Groups{{0, 1}, {2}, {3}});
  CHECK(different_ends({nullptr}, true, 1e-4).empty());
}

TEST_CASE("an infeasible end is another one, and comes last") {
  const Candidate a = end(0.5, 100, 1e-2), b = end(0.5, 100, 0), c = end(0.5, 100, 5e-5);
  CHECK(different_ends({&a, &b, &c}, true, 1e-4) == Groups{{1, 2}, {0}});
}

TEST_CASE("objectives agree within 0.1 %, of negative ones too") {
  CHECK(objectives_agree(100.09, 100));
  CHECK_FALSE(objectives_agree(100.11, 100));
  CHECK(objectives_agree(-100.09, -100));
  CHECK_FALSE(objectives_agree(-100, 100));
}
