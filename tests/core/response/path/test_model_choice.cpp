// Accuracy and mesh chosen by estimated errors.
#include "core/response/path/model_choice.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "support/models.hpp"

using namespace flexopt;

namespace {

StrokeRequest statics(double end) {
  return {.points = {0, end}, .outputs = {Output::equilibrium, Output::stiffness}};
}

}  // namespace

TEST_CASE("a tolerance that the model's own mesh meets is met by reduced leaves on it") {
  const ChosenModel chosen =
      choose_model(models::guide(0.1, 0.03, 5e-4), {}, {statics(0.01)}, 0.05);
  CHECK(chosen.met);
  CHECK(chosen.model.accuracy == Accuracy::reduced);
  CHECK(chosen.model.mesh == ModelOptions{}.mesh);
  REQUIRE(chosen.tried.size() == 1);
  CHECK(chosen.tried[0].largest.relative <= 0.05);
}

TEST_CASE("a smaller tolerance takes a finer mesh, and the error is below it", "[slow]") {
  const Mechanism m = models::guide(0.1, 0.06, 5e-4);
  const StrokeRequest r = statics(0.015);
  const double first = choose_model(m, {}, {r}, 1).tried[0].largest.relative;
  std::vector<std::array<int, 2>> told;
  const ChosenModel chosen = choose_model(
      m, {}, {r}, 0.4 * first, [&](const TriedModel& tried) { told.push_back(tried.mesh); });
  REQUIRE(chosen.met);
  REQUIRE(told.size() == chosen.tried.size());
  for (std::size_t k = 0; k < told.size(); ++k) CHECK(told[k] == chosen.tried[k].mesh);
  CHECK(chosen.tried.size() > 1);
  CHECK(chosen.model.mesh[0] * chosen.model.mesh[1] > 40);
  CHECK(chosen.tried.back().largest.relative <= 0.4 * first);
  CHECK_FALSE(chosen.message.empty());
  // against a mesh finer than any that was tried
  const StrokeResponse own = evaluate_stroke(m, chosen.model, estimate_request(r)),
                       fine = evaluate_stroke(m, {.accuracy = Accuracy::full, .mesh = {36, 16}},
                                              estimate_request(r));
  for (std::size_t k = 0; k < r.points.size(); ++k)
    for (int d = 0; d < 6; ++d)
      if (fine.path[k].support_stiffness[d])
        CHECK(*own.path[k].support_stiffness[d] ==
              Approx(*fine.path[k].support_stiffness[d]).epsilon(0.4 * first));
}

TEST_CASE("full leaves take over where the reduction is what is too large", "[slow]") {
  const Mechanism m = models::three_leaf_hinge(0.1, 0.04, 3.5e-4);
  const StrokeRequest r = statics(0.6);
  const ModelOptions model;
  const LargestError error = choose_model(m, model, {r}, 1).tried[0].largest;
  const double mesh = error.along + error.across;
  REQUIRE(error.reduction > 0);
  const ChosenModel chosen = choose_model(m, model, {r}, mesh + 0.5 * error.reduction);
  CHECK(chosen.model.accuracy == Accuracy::full);
}

TEST_CASE("a tolerance beyond every mesh is not met, and that is said", "[slow]") {
  ModelOptions model;
  model.mesh = {30, 12};  // the next one is larger than any that is tried
  const ChosenModel chosen =
      choose_model(models::guide(0.1, 0.03, 5e-4), model, {statics(0.01)}, 1e-9);
  CHECK_FALSE(chosen.met);
  CHECK_THAT(chosen.message, Catch::Matchers::Contains("no mesh"));
}

TEST_CASE("numbers that more elements do not bring nearer end the choice and are named", "[slow]") {
  // hinges half as thick as they are long: the layer of the free edges is as wide as the elements
  const Mechanism m = models::single_leaf(1.5e-3, 6e-3, 0.75e-3, Direction::rz);
  const ChosenModel chosen = choose_model(m, {}, {statics(0.01)}, 0.01);
  CHECK_FALSE(chosen.met);
  CHECK(chosen.cost <= largest_cost);
  CHECK(chosen.tried.size() <= 3);
  std::vector<StrokeErrors> errors{
      errors_of(evaluate_stroke(m, chosen.model, estimate_request(statics(0.01))), chosen.full[0])};
  const std::vector<LargestError> beyond = errors_beyond(errors, 0.01);
  REQUIRE_FALSE(beyond.empty());
  CHECK_THAT(chosen.message, Catch::Matchers::Contains(beyond[0].name));
  for (std::size_t k = 1; k < beyond.size(); ++k)
    CHECK(beyond[k].relative <= beyond[k - 1].relative);
  for (const std::vector<EstimatedError>& point : errors[0].path)
    for (const EstimatedError& number : point) {
      const bool named =
          std::ranges::find(beyond, number.name, &LargestError::name) != beyond.end();
      CHECK((named || number.kind == ErrorKind::stress || number.relative() <= 0.01));
    }
}

TEST_CASE("a choice costs no more than its limit, whatever the tolerance", "[slow]") {
  const double tolerance = GENERATE(3e-4, 1e-5);
  const ChosenModel chosen =
      choose_model(models::guide(0.1, 0.06, 5e-4), {}, {statics(0.01), statics(0.02)}, tolerance);
  CHECK_FALSE(chosen.met);
  CHECK(chosen.cost <= largest_cost);
  CHECK_THAT(chosen.message, Catch::Matchers::Contains("would cost more"));
}

TEST_CASE("shares are told by two digits") {
  CHECK(percent(0.0021) == "0.21 %");
  CHECK(percent(0.054) == "5.4 %");
  CHECK(percent(0.996) == "100 %");
  CHECK(percent(1.6719) == "170 %");
  CHECK(percent(123.4) == "12000 %");
}
