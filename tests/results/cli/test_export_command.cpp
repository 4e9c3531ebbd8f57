// flexopt export as a user starts it: exit codes, messages, files.
#include <cstdlib>

#include "results/export/exported.hpp"
#include "tests/results/results_tests.hpp"

namespace {

test::Outcome exported(const fs::path& folder, const std::string& job,
                       const std::string& arguments) {
  return test::run_program(
      folder, "export '" FLEXOPT_SOURCE_DIR "/designs/jobs/" + job + ".json' " + arguments);
}

}  // namespace

TEST_CASE("Every format leaves its files in the folder and names them") {
  const test::Workplace folder;
  const test::Outcome o = exported(folder.path(), "parallel_guide",
                                   "--format stl,gltf,dxf,ccx,spacar,vtu --at '5 mm' --out drawn "
                                   "--solids 4 2 1");
  CHECK_THAT(o.err, Contains("note: ccx: with 4 x 2 x 1 solids") && Contains("not within 0.3 %"));
  CHECK(o.code == 0);
  const std::vector<std::string> expected{"compare_ccx.py",
                                          "parallel_guide.glb",
                                          "parallel_guide.inp",
                                          "parallel_guide.stl",
                                          "parallel_guide.vtu",
                                          "parallel_guide_contour.dxf",
                                          "parallel_guide_leaves.dxf",
                                          "parallel_guide_spacar.m"};
  CHECK(test::names_in(folder / "drawn") == expected);
  for (const std::string& name : expected) CHECK_THAT(o.out, Contains("drawn/" + name + "\n"));
  CHECK_THAT(folder.content("drawn/parallel_guide.inp"), Contains("stroke uy = 0.005 m"));
}

TEST_CASE("The folder is named after the job, decks go to its largest stroke") {
  const test::Workplace folder;
  CHECK(exported(folder.path(), "parallel_guide", "--format ccx --solids 2 1 1").code == 0);
  CHECK_THAT(folder.content("parallel_guide.export/parallel_guide.inp"),
             Contains("stroke uy = 0.02 m"));
}

TEST_CASE("Wrong arguments of export end with code 2 and leave nothing") {
  const test::Workplace folder;
  const auto refused = [&](const std::string& job, const std::string& arguments) {
    const test::Outcome o = exported(folder.path(), job, arguments + " --out new");
    CHECK(o.code == 2);
    CHECK(o.out == "");
    CHECK(folder.names().empty());
    return o.err;
  };
  CHECK_THAT(refused("parallel_guide", "--format obj"),
             Contains("obj") && Contains("step, stl, gltf"));
  CHECK_THAT(refused("parallel_guide", ""), Contains("--format is required"));
  CHECK_THAT(refused("parallel_guide", "--format stl --at '30 mm'"), Contains("from 0 to 0.02 m"));
  CHECK_THAT(refused("parallel_guide", "--format ccx --solids 0 1 1"), Contains("--solids"));
  CHECK_THAT(refused("no_such_job", "--format stl"), Contains("no_such_job.json"));
  CHECK_THAT(refused("cantilever", "--format stl,ccx"), Contains("material point of leaf leaf"));
  CHECK_THAT(refused("hexapod", "--format dxf"), Contains("wires"));
  CHECK_THAT(refused("cross_hinge", "--format dxf --kerf '0.2 mm'"),
             Contains("--kerf") && Contains("not in one plate"));
  CHECK_THAT(refused("parallel_guide", "--format dxf --kerf '-1 mm'"), Contains("above 0"));
  CHECK_THAT(refused("parallel_guide", "--format stl --kerf '1 mm'"), Contains("--format dxf"));
  CHECK_THAT(refused("parallel_guide", "--format stl --monolithic"), Contains("--format step"));
}

TEST_CASE("An export that fails leaves the files of an earlier one") {
  const test::Workplace folder;
  CHECK(exported(folder.path(), "cantilever", "--format stl --out here").code == 0);
  const std::string before = folder.content("here/cantilever.stl");
  CHECK(exported(folder.path(), "cantilever", "--format stl,ccx --at 0 --out here").code == 2);
  CHECK(test::names_in(folder / "here") == std::vector<std::string>{"cantilever.stl"});
  CHECK(folder.content("here/cantilever.stl") == before);
}

TEST_CASE("Where there is no equilibrium the exit code is 1") {
  const test::Workplace folder;
  const test::Outcome o = exported(folder.path(), "parallel_guide",
                                   "--format stl --at '20 mm' --set "
                                   "'/loads=[{\"force\": [\"-1e6 N\", 0, 0]}]'");
  CHECK(o.code == 1);
  CHECK_THAT(o.err, Contains("no equilibrium at uy = 0.02 m"));
  CHECK(folder.names().empty());
}
