// What a job leaves open of its search is filled in; what is wrong is in tests/jobs/wrong.
#include "optim/job/job_sections.hpp"
#include "support/guide.hpp"
#include "tests/optim/optim_tests.hpp"

TEST_CASE("without a word a search begins at the job's own design") {
  const Job job = parse_job(guide::stiff_guide());
  CHECK(job.optimise->search == SearchKind::starts);
  CHECK(job.optimise->screened_designs == 0);
  const json& read = document_of(job)["optimise"];
  CHECK(read["search"] == "starts");
  CHECK(read["starts"] == job.optimise->starts);
  CHECK_FALSE(read.contains("screened_designs"));
}

TEST_CASE("a global search screens more designs of more variables") {
  json document = guide::stiff_guide();
  document["optimise"]["search"] = "global";
  document["optimise"].erase("starts");
  const Job two = parse_job(document);
  CHECK(two.optimise->screened_designs == 4096);
  CHECK(two.optimise->starts == 8);
  CHECK(document_of(two)["optimise"]["screened_designs"] == 4096);
  CHECK(document_of(two)["optimise"]["starts"] == 8);
  document["optimise"]["variables"].push_back(
      {{"parameter", "width"}, {"min", "20 mm"}, {"max", "40 mm"}});
  CHECK(parse_job(document).optimise->screened_designs == 8192);
  document["optimise"]["screened_designs"] = 300;
  document["optimise"]["starts"] = 3;
  CHECK(parse_job(document).optimise->screened_designs == 300);
  CHECK(parse_job(document).optimise->starts == 3);
  // what is read once is read again
  CHECK(document_of(parse_job(document_of(two))) == document_of(two));
}
