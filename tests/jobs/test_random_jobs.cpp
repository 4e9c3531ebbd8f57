// Random jobs of all families keep the invariants of every evaluation. Many thousands of them are
// counted by the benchmark random_jobs.
#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "designs/family.hpp"
#include "optim/job/job.hpp"
#include "support/job_invariants.hpp"
#include "support/nightly.hpp"
#include "support/random_jobs.hpp"

using namespace flexopt;
using nlohmann::json;

namespace {

// A random job of a former day, by its seed: families that come since change what seeds make.
json kept_job(int seed) {
  return json::parse(std::ifstream(FLEXOPT_SOURCE_DIR "/tests/jobs/frozen/seed_" +
                                   std::to_string(seed) + ".json"));
}

}  // namespace

TEST_CASE("random jobs of all families break no invariant", "[slow]") {
  constexpr int most = 100000;  // Newton iterations: what needs more hangs
  const int count = (test::nightly() ? 8 : 3) * static_cast<int>(families().size());
  int ok = 0, energies = 0, scales = 0, full = 0;
  for (int seed = 0; seed < count; ++seed) {
    json job = random_job(static_cast<unsigned long long>(seed));
    job["limits"] = {{"iterations", most}};
    const JobVerdict verdict = verdict_of(job);
    CAPTURE(seed, job["design"]["family"], verdict.message);
    for (const std::string& broken : verdict.broken) FAIL_CHECK(broken);
    CHECK(verdict.end != JobVerdict::End::limit_reached);
    ok += verdict.end == JobVerdict::End::ok;
    energies += verdict.energy_checked;
    scales += verdict.scale_checked;
    full += verdict.full_checked;
  }
  // the sample is one of working mechanisms as well
  CHECK(ok > count / 3);
  CHECK(energies > count / 8);
  CHECK(scales > count / 3);
  CHECK(full > count / 3);
}

TEST_CASE("notches of micrometres under heavy bodies have derivatives of their frequencies") {
  const int seed = GENERATE(11997, 12402, 12537);
  const Job job = parse_job(kept_job(seed));
  const StrokeResponse response =
      evaluate_stroke(make_mechanism(job, job.design.parameters), job.model, job.request);
  CAPTURE(seed, response.message);
  CHECK(response.frequency_derivatives.size() == 4);
}

TEST_CASE("frequencies of wires of two elements depend on no rounding") {
  const auto at_rest = [](const json& document) {
    Job job = parse_job(document);
    job.model.accuracy = Accuracy::full;
    job.request.points = {0};
    return evaluate_stroke(make_mechanism(job, job.design.parameters), job.model, job.request);
  };
  const json job = kept_job(1010462);
  REQUIRE(job["model"]["mesh"][0] == 2);
  const StrokeResponse one = at_rest(job), other = at_rest(scaled_job(job, 1 + 0x1p-42));
  REQUIRE(one.path[0].frequencies_free.size() == 4);
  for (std::size_t i = 0; i < 4; ++i)
    CHECK(other.path[0].frequencies_free[i] ==
          Approx(one.path[0].frequencies_free[i]).epsilon(1e-9));
}

TEST_CASE("coarse superelements with a free tip have no modes of motions without mass") {
  const int seed = GENERATE(1043010, 1047627, 1048653);
  const json document = kept_job(seed);
  REQUIRE(document["model"]["method"] == "linear_craig_bampton");
  const auto at_rest = [&](double size) {
    Job job = parse_job(scaled_job(document, size));
    job.request.points = {0};
    return evaluate_stroke(make_mechanism(job, job.design.parameters), job.model, job.request);
  };
  const StrokeResponse one = at_rest(1);
  for (const double size : {2.0, 4.0, 8.0, 16.0}) {
    const StrokeResponse other = at_rest(size);
    CAPTURE(seed, size);
    REQUIRE(other.path[0].frequencies_free.size() == 4);
    CHECK(other.path[0].leaves[0].model == "linear_craig_bampton");
    for (std::size_t i = 0; i < 4; ++i)
      CHECK(other.path[0].frequencies_free[i] * size ==
            Approx(one.path[0].frequencies_free[i]).epsilon(1e-9));
  }
}

TEST_CASE("series of frequencies are the same for a mechanism four times as large") {
  // unstable at rest in ways of higher frequency than the lowest modes; a notch of 1.2 µm under a
  // heavy body; a wire of two elements under a heavy body
  const int seed = GENERATE(1020100, 1020474, 1037103);
  const JobVerdict verdict = verdict_of(kept_job(seed));
  CAPTURE(seed);
  CHECK(verdict.scale_checked);
  CHECK(verdict.broken == std::vector<std::string>());
}

TEST_CASE("jobs of which rounding once chose a number keep all invariants", "[slow]") {
  // the furthest place of a bent leaf, three times; the shapes of a thin leaf beside its modes;
  // bent states of reduced leaves that stood too close, twice; a way that needs short steps; one of
  // a pair of equal modes; modes sought in a space that is full
  const int seed =
      GENERATE(1030540, 1056422, 2406866, 1039719, 1053770, 1055320, 1054976, 2610332, 2812351);
  const JobVerdict verdict = verdict_of(kept_job(seed));
  CAPTURE(seed);
  CHECK(verdict.full_checked);
  CHECK(verdict.broken == std::vector<std::string>());
  CHECK(verdict.rounded == std::vector<std::string>());
}

TEST_CASE("numbers of a point do not depend on the other points of its stroke") {
  const int seed = GENERATE(2, 12, 13);
  Job job = parse_job(random_job(static_cast<unsigned long long>(seed)));
  const Mechanism mechanism = make_mechanism(job, job.design.parameters);
  job.model.accuracy = Accuracy::full;
  const StrokeResponse all = evaluate_stroke(mechanism, job.model, job.request);
  int compared = 0;
  for (std::size_t k = 0; k < all.path.size(); ++k) {
    if (all.path[k].status != PointStatus::converged || !all.path[k].stable) continue;
    StrokeRequest one = job.request;
    one.points = {job.request.points[k]};
    const StrokeResponse alone = evaluate_stroke(mechanism, job.model, one);
    REQUIRE(alone.path.size() == 1);
    const PathPoint &a = all.path[k], &b = alone.path[0];
    if (b.status != PointStatus::converged || !b.stable) continue;
    CAPTURE(seed, a.stroke);
    CHECK(b.drive_stiffness == Approx(a.drive_stiffness).epsilon(1e-9));
    REQUIRE(a.frequencies_free.size() == b.frequencies_free.size());
    for (std::size_t i = 0; i < a.frequencies_free.size(); ++i)
      CHECK(b.frequencies_free[i] == Approx(a.frequencies_free[i]).epsilon(1e-9));
    for (std::size_t i = 0; i < a.frequencies_locked.size(); ++i)
      CHECK(b.frequencies_locked[i] == Approx(a.frequencies_locked[i]).epsilon(1e-9));
    compared += a.stroke != 0;
  }
  CHECK(compared > 0);
}
