// Which atlas a job gets, and what is said where it gets none.
#include "core/reduction/atlas/atlas_file.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/problem/evaluation_log.hpp"
#include "support/base_jobs.hpp"
#include "support/small_atlas.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

json job_with(const json& model) {
  json document = base_job("evaluate");
  document["model"] = model;
  return document;
}

std::string refusal(const json& model) {
  const SpecError error = test::refusal_of([&] { (void)parse_job(job_with(model)); });
  CHECK(error.pointer() == "/model/atlas");
  return error.rule();
}

}  // namespace

TEST_CASE("a job has the atlas that comes along, or the one that is named") {
  const Job plain = parse_job(job_with(json::object()));
  CHECK(plain.model.atlas_use == AtlasUse::automatic);
  CHECK(plain.model.atlas == shipped_atlas());
  CHECK(plain.notes.empty());
  CHECK((*plain.as_read)["model"]["atlas"] == "auto");
  const Job without = parse_job(job_with({{"atlas", "off"}}));
  CHECK_FALSE(without.model.atlas);
  CHECK_FALSE(parse_job(job_with({{"accuracy", "full"}})).model.atlas);

  // what it does not have
  const Job otherwise = parse_job(job_with({{"degree", 7}}));
  CHECK_FALSE(otherwise.model.atlas);
  CHECK(otherwise.notes.empty());

  // no file yet
  const test::AtlasPlace place;
  CHECK_THAT(refusal({{"atlas", "required"}}),
             Contains(place.file().string()) && Contains("flexopt atlas --mesh 12 5"));
  const Job automatic = parse_job(job_with({{"atlas", "auto"}}));
  CHECK_FALSE(automatic.model.atlas);
  REQUIRE(automatic.notes.size() == 1);
  CHECK_THAT(automatic.notes[0], Contains("there is none"));

  AtlasSettings settings = test::small_settings();
  settings.points = {2, 2};
  settings.width = {0.25, 0.3};
  settings.thickness = {1.0 / 220, 1.0 / 200};
  settings.poissons_ratios = {0.3};
  settings.rays = {-1, 1};
  settings.sigmas = {0, 0.1};
  settings.dynamics = true;
  settings.stress_samples = 8;
  const auto made = make_atlas(settings, test::unchecked());
  REQUIRE(made);
  REQUIRE(write_atlas(**made, place.file()));
  const json model{{"atlas", "required"}, {"mesh", {4, 2}}};
  const Job job = parse_job(job_with(model));
  REQUIRE(job.model.atlas);
  CHECK(job.model.atlas->settings() == settings);
  CHECK(job.notes.empty());
  CHECK(parse_job(job_with({{"mesh", {4, 2}}})).model.atlas == job.model.atlas);
  CHECK_FALSE(parse_job(job_with({{"atlas", "off"}, {"mesh", {4, 2}}})).model.atlas);

  // a run that was interrupted does not go on with leaves from elsewhere
  CHECK(log_identity(job, "1").contains("looked_up_in"));
  CHECK(log_identity(job, "1") != log_identity(automatic, "1"));
  CHECK(log_identity(plain, "1").contains("looked_up_in"));
  CHECK_FALSE(log_identity(without, "1").contains("looked_up_in"));

  // what an atlas does not have
  const auto with = [&](const char* key, const json& value) {
    json other = model;
    other[key] = value;
    return refusal(other);
  };
  CHECK_THAT(with("mesh", {10, 4}), Contains("4 x 2 elements, not 10 x 4"));
  CHECK_THAT(with("degree", 7), Contains("degree 5"));
  CHECK_THAT(with("flexure", "beam"), Contains("plates, not beams"));
  CHECK_THAT(with("free_edge_torsion", false), Contains("free_edge_torsion"));
  CHECK_THAT(with("method", "linear_craig_bampton"), Contains("mixed_potential"));

  // a file that is not whole any more is not used, and the reader notices
  const auto before = fs::last_write_time(place.file());
  fs::resize_file(place.file(), fs::file_size(place.file()) - 100);
  fs::last_write_time(place.file(), before + std::chrono::seconds(2));
  CHECK_THAT(refusal(model), Contains("it is not whole"));
}
