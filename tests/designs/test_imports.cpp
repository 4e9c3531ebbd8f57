// Bodies of whole or reduced matrices of other programs, and their checks.
#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/elements/solid/elastic_model.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/mechanism.hpp"
#include "designs/solids/import_matrices.hpp"
#include "designs/solids/import_mesh.hpp"
#include "support/refusals.hpp"
#include "support/temporary_folder.hpp"

using namespace flexopt;
using nlohmann::json;

namespace {

/// Two C3D20R of 20 x 3 x 4 mm, aluminium, with the matrices that CalculiX 2.20 made of this deck;
/// mm, N, t. LEFT and RIGHT are its faces across x.
const std::string data = FLEXOPT_SOURCE_DIR "/tests/designs/data/";

const double mass_of_box = 20 * 6 * 4 * 2.7e-9;  // [t]

json box_document() {
  return {{"flexopt_elastic", 1},
          {"name", "box"},
          {"units", {{"length", "mm"}, {"force", "N"}, {"mass", "t"}}},
          {"interfaces",
           {{{"name", "left"}, {"at", {-10, 0, 0}}, {"nodes", "Left"}},
            {{"name", "right"}, {"at", {10, 0, 0}}, {"nodes", "Right"}}}},
          {"matrix_storage", {{"files", data + "box"}, {"mesh", data + "box.inp"}}},
          {"expected",
           {{"mass", mass_of_box},
            {"center_of_mass", {0, 0, 0}},
            {"inertia",
             {mass_of_box * (36 + 16) / 12, mass_of_box * (400 + 16) / 12,
              mass_of_box * (400 + 36) / 12}}}}};
}

ImportedBody read_document(const json& document, const std::string& market = "") {
  const test::TemporaryFolder folder;
  test::put(folder / "body.json", document.dump(1));
  if (!market.empty()) test::put(folder / "k.mtx", market);
  return read_elastic_body((folder / "body.json").string());
}

const ImportedBody& box() {
  static const ImportedBody body = read_document(box_document());
  return body;
}

json lower_of(const MatrixXd& A) {
  json rows = json::array();
  for (int i = 0; i < A.rows(); ++i) {
    rows.push_back(json::array());
    for (int j = 0; j <= i; ++j) rows.back().push_back(A(i, j));
  }
  return {{"lower", rows}};
}

/// The box by its reduced matrices, SI.
json reduced_document() {
  const ImportFigures& figures = box().figures;
  json document = box_document();
  document.erase("matrix_storage");
  document["units"] = {{"length", "m"}, {"force", "N"}, {"mass", "kg"}};
  document["interfaces"] = {{{"name", "left"}, {"at", {-0.01, 0, 0}}},
                            {{"name", "right"}, {"at", {0.01, 0, 0}}}};
  document["stiffness"] = lower_of(box().matrices->stiffness);
  document["mass"] = lower_of(box().matrices->mass);
  document["expected"] = {
      {"mass", figures.mass},
      {"center_of_mass", {0, 0, 0}},
      {"inertia", {figures.inertia(0, 0), figures.inertia(1, 1), figures.inertia(2, 2)}},
      {"free_frequencies", figures.free_frequencies}};
  return document;
}

/// The same with two modes of 3 and 4 kHz that nothing couples to.
json document_with_modes() {
  MatrixXd K = MatrixXd::Zero(14, 14), M = MatrixXd::Identity(14, 14);
  K.topLeftCorner(12, 12) = box().matrices->stiffness;
  M.topLeftCorner(12, 12) = box().matrices->mass;
  for (int k = 0; k < 2; ++k) K(12 + k, 12 + k) = std::pow(2 * std::numbers::pi * 1e3 * (3 + k), 2);
  json document = reduced_document();
  document["modes"] = 2;
  document["stiffness"] = lower_of(K);
  document["mass"] = lower_of(M);
  document["expected"]["free_frequencies"] = {3000, 4000, box().figures.free_frequencies[0]};
  return document;
}

std::string complaint(const json& document) {
  return test::complaint_of([&] { read_document(document); });
}

double difference(const MatrixXd& A, const MatrixXd& B) {
  const VectorXd s = B.diagonal().cwiseAbs().cwiseSqrt().cwiseInverse();
  return (s.asDiagonal() * (A - B) * s.asDiagonal()).cwiseAbs().maxCoeff();
}

}  // namespace

// Expected numbers: dense condensation of the same mesh in numpy, 2 x 2 x 2 points for both.
TEST_CASE("whole matrices of CalculiX are condensed to interfaces", "[imports]") {
  const ImportedMatrices& matrices = *box().matrices;
  const std::array<double, 6> stiffness{8.4440140564e+07, 8.2683913431e+06, 4.3003851091e+06,
                                        1.1859110897e+02, 5.6172103771e+02, 1.0941750726e+03},
      mass{4.3348215887e-04, 4.3729634457e-04, 4.3522352766e-04,
           1.8735584230e-09, 3.7552075289e-09, 3.9926421575e-09};
  for (int i = 0; i < 6; ++i) {
    CHECK(matrices.stiffness(6 + i, 6 + i) == Approx(stiffness[i]).epsilon(1e-9));
    CHECK(matrices.mass(6 + i, 6 + i) == Approx(mass[i]).epsilon(1e-9));
  }
  CHECK(matrices.stiffness(8, 10) == Approx(43003.85109114).epsilon(1e-9));
  CHECK(matrices.mass(0, 6) == Approx(2.1451784113e-4).epsilon(1e-9));
  const ImportFigures& figures = box().figures;
  CHECK(figures.rigid_residual < 1e-9);
  CHECK(figures.sixth < 1e-9);
  CHECK(figures.seventh > 1e-3);
  CHECK(figures.mass == Approx(1e3 * mass_of_box).epsilon(1e-9));
  CHECK(figures.free_frequencies[0] == Approx(7.99836795e+04).epsilon(1e-7));
  CHECK(box().interfaces[1].place[0] == Approx(0.01));
}

TEST_CASE("whole matrices of CalculiX and the same mesh give the same body", "[imports]") {
  const ImportedMesh mesh = read_mesh(data + "box.inp", 1e-3);
  ElasticBody meshed, imported;
  meshed.cells = std::make_shared<SolidCells>(mesh.cells);
  meshed.nodes = mesh.nodes;
  meshed.material.youngs_modulus = 70e9;
  meshed.material.poissons_ratio = 0.33;
  meshed.material.density = 2700;
  imported.imported = box().matrices;
  for (const char* name : {"left", "right"}) {
    const double x = name == std::string("left") ? -0.01 : 0.01;
    imported.interfaces.push_back({.name = name, .origin = {x, 0, 0}});
    meshed.interfaces.push_back(
        {.name = name, .origin = {x, 0, 0}, .patch = nodes_of_set(mesh, name, JsonPointer())});
  }
  REQUIRE(why_not(check_solid(meshed)) == "");
  REQUIRE(why_not(check_solid(imported)) == "");
  const ElasticModel &ours = condensed(meshed)->model, &theirs = condensed(imported)->model;
  CHECK(difference(theirs.stiffness, ours.stiffness) < 1e-9);
  CHECK(difference(theirs.mass, ours.mass) < 1e-9);
  CHECK((theirs.moments - ours.moments).norm() < 1e-9 * ours.moments.norm());
  CHECK(theirs.total_mass == Approx(ours.total_mass).epsilon(1e-9));
}

TEST_CASE("a body is the same in other units, axes, order and files", "[imports]") {
  const ImportedMatrices& matrices = *box().matrices;
  json document = reduced_document();
  CHECK(difference(read_document(document).matrices->stiffness, matrices.stiffness) < 1e-13);
  // mm, N, t; the axes of the second interface turned, the first interface behind it
  const Matrix3d turn = rotation_exp({0.3, -0.5, 0.9});
  MatrixXd toward = MatrixXd::Zero(12, 12);  // of the file's coordinates, from those of the body
  toward.block<3, 3>(0, 6) = 1e3 * turn;
  toward.block<3, 3>(3, 9) = turn;
  toward.block<3, 3>(6, 0) = 1e3 * Matrix3d::Identity();
  toward.block<3, 3>(9, 3).setIdentity();
  const MatrixXd back = toward.inverse();
  const MatrixXd K = 1e3 * back.transpose() * matrices.stiffness * back,
                 M = 1e3 * back.transpose() * matrices.mass * back;
  document["units"] = {{"length", "mm"}, {"force", "N"}, {"mass", "t"}};
  document["expected"] = box_document()["expected"];
  document["interfaces"][0]["at"] = {-10, 0, 0};
  document["interfaces"][1]["at"] = {10, 0, 0};
  for (int i = 0; i < 3; ++i)
    document["interfaces"][1]["axes"].push_back({turn(i, 0), turn(i, 1), turn(i, 2)});
  for (const char* name : {"right", "left"})
    for (const std::string_view direction : direction_names)
      document["order"].push_back(fmt::format("{}.{}", name, direction));
  document["mass"] = lower_of(M);
  document["stiffness"] = {{"file", "k.mtx"}, {"format", "matrix_market"}};
  std::string array = "%%MatrixMarket matrix array real symmetric\n% of a test\n12 12\n",
              general = "%%MatrixMarket matrix coordinate real general\n12 12 144\n";
  for (int j = 0; j < 12; ++j)
    for (int i = 0; i < 12; ++i) {
      if (i >= j) array += fmt::format("{}\n", K(i, j));
      general += fmt::format("{} {} {}\n", i + 1, j + 1, K(i, j));
    }
  for (const std::string& market : {array, general}) {
    const ImportedBody body = read_document(document, market);
    CHECK(difference(body.matrices->stiffness, matrices.stiffness) < 1e-11);
    CHECK(difference(body.matrices->mass, matrices.mass) < 1e-11);
  }
  general.replace(general.find("12 12 144"), 9, "13 13 144");
  CHECK_THAT(test::complaint_of([&] { read_document(document, general); }),
             Catch::Contains("k.mtx:2:1: 13 x 13 entries; the interfaces and modes have 12"));
}

TEST_CASE("check 1: matrices that are not symmetric, coordinates that are not there once",
          "[imports]") {
  json document = reduced_document();
  document["stiffness"] = {{"file", "k.mtx"}, {"format", "matrix_market"}};
  MatrixXd K = box().matrices->stiffness;
  K(0, 1) += 1e-6 * K(0, 0);
  std::string market = "%%MatrixMarket matrix array real general\n12 12\n";
  for (int j = 0; j < 12; ++j)
    for (int i = 0; i < 12; ++i) market += fmt::format("{}\n", K(i, j));
  CHECK_THAT(test::complaint_of([&] { read_document(document, market); }),
             Catch::Contains("/stiffness = asymmetry ") && Catch::Contains("check 1"));
  document = reduced_document();
  document["interfaces"][1]["name"] = "left";
  CHECK_THAT(complaint(document), Catch::Contains("/interfaces/1/name = left; check 1: every"));
  document = reduced_document();
  for (int i = 0; i < 12; ++i) document["order"].push_back("left.ux");
  CHECK_THAT(complaint(document),
             Catch::Contains("/order/1 = left.ux; check 1: every coordinate once"));
}

TEST_CASE("check 2: rigid motions that need forces", "[imports]") {
  json document = reduced_document();
  SECTION("a place") { document["interfaces"][1]["at"] = {0.01, 1e-5, 0}; }
  SECTION("axes") { document["interfaces"][1]["axes"] = {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}; }
  SECTION("a spring to the ground") {
    MatrixXd K = box().matrices->stiffness;
    K(1, 1) *= 1 + 1e-5;
    document["stiffness"] = lower_of(K);
  }
  SECTION("few digits") {
    MatrixXd K = box().matrices->stiffness;
    for (double& entry : K.reshaped()) entry = std::stod(fmt::format("{:.4e}", entry));
    document["stiffness"] = lower_of(K);
  }
  CHECK_THAT(complaint(document),
             Catch::Contains("body.json:") && Catch::Contains("/stiffness = ") &&
                 Catch::Contains("check 2: forces of rigid motions are below 1e-06"));
}

TEST_CASE("check 3: more free motions than six, and negative stiffness", "[imports]") {
  json document = reduced_document();
  const MatrixXd K = box().matrices->stiffness;
  // along a motion of all coordinates, its stiffness taken away or reversed
  VectorXd apart(12);
  for (int i = 0; i < 12; ++i) apart[i] = std::cos(i) / std::sqrt(K(i, i));
  const VectorXd force = K * apart;
  const double factor = GENERATE(1.0, 1.5);
  document["stiffness"] = lower_of(K - factor * force * force.transpose() / apart.dot(force));
  CHECK_THAT(
      complaint(document),
      Catch::Contains("check 3: exactly six eigenvalues") &&
          Catch::Contains(factor == 1 ? "7 of them" : "a negative one is no elastic body's"));
}

TEST_CASE("check 4: mass properties other than told", "[imports]") {
  json document = reduced_document();
  std::string place = "/expected/mass = ";
  SECTION("mass") { document["expected"]["mass"] = box().figures.mass * 1.002; }
  SECTION("the centre") {
    document["expected"]["center_of_mass"] = {0, 3e-5, 0};
    place = "/expected/center_of_mass = ";
  }
  SECTION("inertia") {
    document["expected"]["inertia"][2] = box().figures.inertia(2, 2) * 1.002;
    place = "/expected/inertia = ";
  }
  SECTION("products of inertia") {
    const double j = box().figures.inertia(0, 0);
    document["expected"]["inertia"] = {{j, 0.1 * j, 0},
                                       {0.1 * j, box().figures.inertia(1, 1), 0},
                                       {0, 0, box().figures.inertia(2, 2)}};
    place = "/expected/inertia = ";
  }
  SECTION("nothing told") {
    document.erase("expected");
    place = "/expected = nothing";
  }
  SECTION("lumped along one direction") {
    MatrixXd M = box().matrices->mass;
    M(0, 0) *= 1.001;
    document["mass"] = lower_of(M);
    place = "/mass = least eigenvalue";
  }
  SECTION("negative") {
    document["mass"] = lower_of(-box().matrices->mass);
    place = "/mass = least eigenvalue";
  }
  CHECK_THAT(complaint(document), Catch::Contains(place) && Catch::Contains("check 4"));
}

TEST_CASE("a massless body needs no mass properties", "[imports]") {
  json document = reduced_document();
  document.erase("mass");
  document.erase("expected");
  const ImportedBody body = read_document(document);
  CHECK(body.matrices->mass.isZero(0));
  CHECK(body.figures.mass == 0);
}

TEST_CASE("check 5: modes and free frequencies", "[imports]") {
  CHECK(read_document(document_with_modes()).figures.free_frequencies[1] ==
        Approx(4000).epsilon(1e-6));
  json document = document_with_modes();
  std::string place;
  SECTION("coupled stiffness") {
    document["stiffness"]["lower"][13][12] = 1e3;
    place = "/stiffness = ";
  }
  SECTION("mass") {
    document["mass"]["lower"][12][12] = 1.01;
    place = "/mass = off by 0.01";
  }
  SECTION("frequency") {
    document["expected"]["free_frequencies"][2] = box().figures.free_frequencies[0] * 1.002;
    place = "/expected/free_frequencies = ";
  }
  CHECK_THAT(complaint(document), Catch::Contains(place) && Catch::Contains("check 5"));
}

TEST_CASE("check 6: the place of an interface in the design", "[imports]") {
  CHECK(check_interface_place(box(), "right", {0.01, 0, 1e-9}).has_value());
  CHECK_THAT(why_not(check_interface_place(box(), "right", {0.01, 0, 1e-7})),
             Catch::Contains("check 6: right lies at (0.01, 0, 0) m"));
}

TEST_CASE("forms of a body that do not fit together", "[imports]") {
  json document = reduced_document();
  std::string rule;
  SECTION("units") {
    document["units"]["mass"] = "g";
    rule = "/units = {\"force\":\"N\",\"length\":\"m\",\"mass\":\"g\"}; force = mass length / s^2";
  }
  SECTION("no unit of length") {
    document["units"]["length"] = "N";
    rule = "/units/length = ";
  }
  SECTION("left-handed axes") {
    document["interfaces"][0]["axes"] = {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
    rule = "/interfaces/0/axes = ";
  }
  SECTION("both forms") {
    document["matrix_storage"] = {{"files", "a"}, {"mesh", "a.inp"}};
    rule = "/interfaces/0 = left; with matrix_storage an interface has nodes";
  }
  SECTION("no matrix") {
    document.erase("stiffness");
    rule = "give stiffness and mass, or matrix_storage";
  }
  SECTION("a row too many") {
    document["stiffness"]["lower"].push_back({1, 2});
    rule = "/stiffness/lower = 13 rows; 12 rows";
  }
  SECTION("an unknown coordinate") {
    document["order"] = json::array();
    for (int i = 0; i < 12; ++i) document["order"].push_back("left.uw");
    rule = "/order/0 = left.uw; no coordinate; did you mean";
  }
  CHECK_THAT(complaint(document), Catch::Contains(rule));
}

TEST_CASE("files of MATRIXSTORAGE that are broken", "[imports]") {
  const test::TemporaryFolder folder;
  for (const char* ending : {".sti", ".mas", ".dof", ".inp"})
    test::put(folder / (std::string("b") + ending), test::content_of(data + "box" + ending));
  json document = box_document();
  document["matrix_storage"] = {{"files", (folder / "b").string()},
                                {"mesh", (folder / "b.inp").string()}};
  CHECK(complaint(document) == "accepted");
  const auto append = [&](const char* name, const std::string& text) {
    test::put(folder / name, test::content_of(folder / name) + text);
  };
  std::string rule;
  SECTION("a node that the deck holds") {
    const std::string dof = test::content_of(folder / "b.dof");
    test::put(folder / "b.dof", dof.substr(0, dof.rfind("\n", dof.size() - 2) + 1));
    rule = "is missing: the deck holds this node or ties it to others";
  }
  SECTION("another triangle") {
    append("b.sti", "2 1 1.0\n");
    rule = "b.sti:";
  }
  SECTION("a row that is none") {
    append("b.mas", "97 97 1.0\n");
    rule = "row or column 97 of 96";
  }
  SECTION("nodes in two patches") {
    document["interfaces"][1]["nodes"] = "LEFT";
    rule = "/interfaces/1/nodes = LEFT; node ";
  }
  SECTION("a body that is held by a spring") {
    append("b.sti", "50 50 1e3\n");
    rule = "check 2";
  }
  SECTION("a part that hangs on nothing") {
    std::string sti = test::content_of(folder / "b.sti"), kept;
    for (std::size_t at = 0; at < sti.size();) {
      const std::size_t end = sti.find('\n', at);
      const std::string line = sti.substr(at, end - at);
      const int column = std::stoi(line.substr(line.find(' ')));
      if (column < 94) kept += line + "\n";
      at = end + 1;
    }
    test::put(folder / "b.sti", kept);
    rule = "check ";
  }
  CHECK_THAT(complaint(document), Catch::Contains(rule));
}
