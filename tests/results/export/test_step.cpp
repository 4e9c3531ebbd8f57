#include <catch2/catch.hpp>
#include <numbers>

#include "core/spec/spec_error.hpp"
#include "results/export/parts.hpp"
#include "results/export/exported.hpp"
#include "support/leaf_volume.hpp"
#include "tests/results/export/gallery.hpp"

#ifdef FLEXOPT_WITH_OCCT
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <GProp_GProps.hxx>
#include <STEPControl_Reader.hxx>
#include <TopExp_Explorer.hxx>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "support/binary.hpp"
#include "support/temporary_folder.hpp"
#endif

using namespace flexopt;
using Catch::Matchers::Contains;

#ifndef FLEXOPT_WITH_OCCT

TEST_CASE("Without Open CASCADE the package is named", "[results][export]") {
  CHECK_THROWS_WITH(step_file(test::gallery("parallel_guide"), nullptr),
                    Contains("libocct-data-exchange-dev"));
}

#else

namespace {

/// Volumes of the solids that a reader finds [mm³].
std::vector<double> volumes(const StepFile& file) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "part.step").string();
  std::ofstream(path) << file.content;
  STEPControl_Reader reader;
  REQUIRE(reader.ReadFile(path.c_str()) == IFSelect_RetDone);
  reader.TransferRoots();
  std::vector<double> found;
  for (TopExp_Explorer solids(reader.OneShape(), TopAbs_SOLID); solids.More(); solids.Next()) {
    CHECK(BRepCheck_Analyzer(solids.Current()).IsValid());
    GProp_GProps properties;
    BRepGProp::VolumeProperties(solids.Current(), properties);
    found.push_back(properties.Mass());
  }
  return found;
}

void check_volumes(const Exported& exported, const PathPoint* point) {
  const std::vector<double> found = volumes(step_file(exported, point));
  const std::vector<TriangleMesh> parts = drawn_parts(exported.mechanism, point);
  REQUIRE(found.size() == parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    CAPTURE(parts[i].name);
    const bool is_leaf = i < exported.mechanism.leaves.size();
    const double expected =
        is_leaf && !point ? test::leaf_volume(exported.mechanism.leaves[i]) : parts[i].volume();
    CHECK(found[i] == Approx(1e9 * expected).epsilon(1e-3));
  }
}

}  // namespace

TEST_CASE("Solids that are read back have the volumes of leaves and bodies", "[results][export]") {
  for (const char* name : {"parallel_guide", "cross_hinge", "curved_leaf", "tapered_leaf",
                           "notch_hinge", "wire_flexure", "reinforced_guide"}) {
    CAPTURE(name);
    check_volumes(test::gallery(name), nullptr);
  }
  check_volumes(test::folded_leaf(), nullptr);
}

TEST_CASE("So have those of a bent mechanism", "[results][export]") {
  const std::vector<std::pair<const char*, const char*> > jobs{{"parallel_guide", "20 mm"},
                                                               {"cross_hinge", "20 deg"},
                                                               {"curved_leaf", "10 deg"},
                                                               {"wire_flexure", "10 mm"},
                                                               {"notch_hinge", "2 deg"}};
  for (const auto& [name, at] : jobs) {
    CAPTURE(name);
    const Exported exported = test::gallery(name, {at});
    const PathPoint point = exported.equilibria({exported.strokes}).front();
    check_volumes(exported, &point);
  }
  const Exported folded = test::folded_leaf({"1 mm"});
  const PathPoint point = folded.equilibria({folded.strokes}).front();
  check_volumes(folded, &point);
}

TEST_CASE("Flat leaves have their fillets, others a note", "[results][export]") {
  Exported guide = test::gallery("guide_with_fillets");
  const double radius = guide.request.stress.fillet.value();
  const StepFile flat = step_file(guide, nullptr);
  CHECK(flat.notes.empty());
  const std::vector<double> found = volumes(flat);
  for (std::size_t i = 0; i < guide.mechanism.leaves.size(); ++i) {
    const LeafSpring& leaf = guide.mechanism.leaves[i];
    const double corners = 4 * (1 - std::numbers::pi / 4) * radius * radius * leaf.width;
    CHECK(corners > 5e-4 * test::leaf_volume(leaf));
    CHECK(found[i] == Approx(1e9 * (test::leaf_volume(leaf) + corners)).epsilon(1e-6));
  }
  guide.undeflected = false;
  guide.strokes = guide.largest_strokes();
  const PathPoint point = guide.equilibria({guide.strokes}).front();
  const StepFile bent = step_file(guide, &point);
  REQUIRE(bent.notes.size() == guide.mechanism.leaves.size());
  CHECK_THAT(bent.notes.front(), Contains("leaf +y") && Contains("no fillets"));
}

TEST_CASE("The same job makes the same file, with the names of its parts", "[results][export]") {
  const test::TemporaryFolder folder;
  std::vector<std::string> files;
  for (const char* run : {"first", "second"}) {  // of the program: parts are counted in a process
    const std::string out = (folder.path() / run).string();
    REQUIRE(
        std::system((test::binary() + " export " + FLEXOPT_SOURCE_DIR +
                     "/designs/jobs/cross_hinge.json --format step --out " + out + " > /dev/null")
                        .c_str()) == 0);
    files.push_back(test::content_of(out + "/cross_hinge.step"));
  }
  CHECK((files[0] == files[1]));
  CHECK_THAT(files[0].substr(0, 400), Contains("'1970-01-01T00:00:00'"));
  for (const char* name : {"'leaf 1 ", "'leaf 2 ", "'end_effector "})
    CHECK((files[0].find("PRODUCT(" + std::string(name)) != std::string::npos));
}

#endif
