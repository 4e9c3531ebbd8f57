#include <catch2/catch.hpp>
#include <numbers>

#include "core/spec/spec_error.hpp"
#include "results/export/exported.hpp"
#include "results/export/parts.hpp"
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

TEST_CASE("Without Open CASCADE the package is named") {
  CHECK_THROWS_WITH(step_file(test::gallery("parallel_guide"), nullptr),
                    Contains("libocct-data-exchange-dev"));
}

#else

namespace {

/// Volumes of the valid solids that a reader finds [mm³].
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

std::size_t count_of(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; ++at) ++count;
  return count;
}

/// Leaves come first, in their order; then the bodies, the ground last.
void check_leaves(const Exported& exported, const PathPoint* point) {
  const std::vector<double> found = volumes(step_file(exported, point));
  const std::vector<LeafSpring>& leaves = exported.mechanism.leaves;
  REQUIRE(found.size() > leaves.size() + 1);  // at least one body, and the ground
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    CAPTURE(leaves[i].name);
    const double expected = point
                                ? closed_leaf(drawn_surface(exported.mechanism, point, i)).volume()
                                : test::leaf_volume(leaves[i]);
    CHECK(found[i] == Approx(1e9 * expected).epsilon(1e-3));
  }
}

}  // namespace

TEST_CASE("Leaves that are read back have their volumes") {
  for (const char* name : {"parallel_guide", "cross_hinge", "curved_leaf", "tapered_leaf",
                           "notch_beam", "wire_flexure"}) {
    CAPTURE(name);
    check_leaves(test::gallery(name), nullptr);
  }
  check_leaves(test::folded_leaf(), nullptr);
}

TEST_CASE("A reinforced leaf is one solid whose steps are rounded by the fillet") {
  Exported guide = test::gallery("reinforced_guide");  // two parts of 20 mm around a box of 60 mm
  const double plain = 6 * (40 * 0.5 + 60 * 4), corner = 6 * (1 - std::numbers::pi / 4);
  REQUIRE(volumes(step_file(guide, nullptr)).size() == 4);  // two leaves, end-effector, ground
  CHECK(volumes(step_file(guide, nullptr))[0] == Approx(plain).epsilon(1e-9));
  guide.request.stress.fillet = 0.5e-3;
  CHECK(volumes(step_file(guide, nullptr))[0] == Approx(plain + 8 * 0.25 * corner).epsilon(1e-9));
}

TEST_CASE("Elastic bodies that are read back have their volumes, and faces that hold them a note") {
  const StepFile file = step_file(test::elastic_guide(), nullptr);
  const std::vector<double> found = volumes(file);
  REQUIRE(found.size() > 4);  // two leaves, the ground, two elastic bodies
  CHECK(found[found.size() - 2] == Approx((10 * 80 - 4 * 10) * 20).epsilon(1e-6));
  CHECK(found.back() == Approx(10 * 20 * 20).epsilon(1e-6));
  REQUIRE(file.notes.size() == 1);
  CHECK_THAT(file.notes[0], Contains("face floor of elastic body foot") && Contains("ground"));
}

TEST_CASE("One solid is made of all parts, or what it cannot be is named") {
  for (const char* name : {"parallel_guide", "double_parallelogram", "cross_hinge"}) {
    CAPTURE(name);
    const Exported exported = test::gallery(name);
    double sum = 0;
    for (const double part : volumes(step_file(exported, nullptr))) sum += part;
    const StepFile one = step_file(exported, nullptr, true);
    const std::vector<double> found = volumes(one);
    REQUIRE(found.size() == 1);
    CHECK(found[0] == Approx(sum).epsilon(1e-6));
    CHECK(count_of(one.content, "=PRODUCT(") + count_of(one.content, "= PRODUCT(") == 1);
  }
  CHECK_THROWS_WITH(step_file(test::gallery("hinged_leaf"), nullptr, true),
                    Contains("--monolithic") && Contains("no joints"));
}

TEST_CASE("Every part has its name and its colour") {
  const StepFile file = step_file(test::gallery("parallel_guide"), nullptr);
  CHECK(count_of(file.content, "STYLED_ITEM(") == 4);
  for (const char* name : {"'leaf +y", "'leaf -y", "'end_effector", "'ground"})
    CHECK_THAT(file.content, Contains("PRODUCT(" + std::string(name)));
}

TEST_CASE("So have those of a bent mechanism") {
  test::each_bent({{"parallel_guide", "20 mm"},
                   {"cross_hinge", "20 deg"},
                   {"curved_leaf", "10 deg"},
                   {"wire_flexure", "10 mm"},
                   {"notch_beam", "2 deg"}},
                  check_leaves);
}

TEST_CASE("Flat leaves have their fillets, others a note") {
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

TEST_CASE("The same job makes the same file, with the names of its parts") {
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
