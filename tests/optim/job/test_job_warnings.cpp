#include "optim/job/job_warnings.hpp"

#include <fmt/format.h>

#include "tests/optim/job/patched_job.hpp"

using Catch::Matchers::EndsWith, Catch::Matchers::StartsWith;

namespace {

std::vector<std::string> notes(const char* patch) { return read_patched(patch).notes; }

/// The only note.
std::string note(const char* patch) {
  const std::vector<std::string> all = notes(patch);
  REQUIRE(all.size() == 1);
  return all[0];
}

/// A leaf in a file of its own, driven across it, with these members changed.
std::string note_on_own(const char* patch) {
  json document = patched(R"({"loads": null})");
  json mechanism =
      json::parse(R"({"flexopt_design": 1, "name": "leaf", "drive": {"direction": "uy"},
      "bodies": [{"name": "end_effector", "at": [0.08, 0, 0]}],
      "leaves": [{"name": "leaf", "base": {"body": "ground", "at": [0, 0, 0]},
                  "tip": {"body": "end_effector", "at": [0.08, 0, 0]},
                  "across": [0, 0, 1], "width": 0.02, "thickness": 3e-4}]})");
  mechanism.merge_patch(json::parse(patch));
  document["design"].erase("family");
  document["design"]["parameters"] = json::object();
  document["design"]["mechanism"] = std::move(mechanism);
  const Job job = parse_job(document);
  return job.notes.empty() ? "" : job.notes.front();
}

}  // namespace

TEST_CASE("a number of a material in a wrong unit is told with the unit that it fits") {
  const auto material = [](const char* key, const char* value) {
    return note(fmt::format(R"({{"design": {{"material": {{"{}": "{}"}}}}}})", key, value).c_str());
  };
  CHECK(material("youngs_modulus", "210 MPa") ==
        "/design/material/youngs_modulus = 210 MPa: stiff solids have 300 MPa to 1300 GPa; "
        "probably meant: 210 GPa.");
  CHECK_THAT(material("youngs_modulus", "210 Pa"), Contains("meant: 210 GPa"));
  CHECK_THAT(material("density", "7.8 kg/m^3"), Contains("meant: 7800 kg/m^3"));
  CHECK_THAT(material("yield_strength", "1400 Pa"), Contains("meant: 1.4 GPa"));
  CHECK_THAT(material("allowable_stress", "600 GPa"), Contains("meant: 600 MPa"));
  CHECK_THAT(material("endurance_limit", "0.4 kPa"), StartsWith("/design/material/endurance"));
}

TEST_CASE("materials of use are none of the wrong ones") {
  for (
      const char* soft_and_hard :
      {R"({"youngs_modulus": "0.5 GPa", "density": "2200 kg/m^3", "allowable_stress": "3 MPa"})",
       R"({"youngs_modulus": "1150 GPa", "density": "3500 kg/m^3", "allowable_stress": "2 GPa"})",
       R"({"youngs_modulus": "3.5 GPa", "density": "1240 kg/m^3", "allowable_stress": "20 MPa"})"}) {
    json document = base_job("evaluate");
    document["design"]["material"].update(json::parse(soft_and_hard));
    CHECK(parse_job(document).notes.empty());
  }
}

TEST_CASE("a material of a leaf's own is looked at, too") {
  const std::string text = note_on_own(R"({"leaves": [{"name": "leaf",
      "base": {"body": "ground", "at": [0, 0, 0]}, "tip": {"body": "end_effector", "at": [0.08, 0, 0]},
      "across": [0, 0, 1], "width": 0.02, "thickness": 3e-4, "material":
      {"youngs_modulus": "71 MPa", "poissons_ratio": 0.33, "density": 2700}}]})");
  CHECK_THAT(text,
             StartsWith("/design/mechanism/leaves/0/material/youngs_modulus = 71 MPa (leaf)"));
}

TEST_CASE("parameters and lets of a design that no formula uses are told") {
  CHECK(note_on_own(R"({"parameters": {"lenght": {"unit": "m", "default": 0.08}}})") ==
        "/design/mechanism/parameters/lenght: no formula of the design uses it.");
  CHECK_THAT(note_on_own(R"({"let": {"half": 0.5}})"), StartsWith("/design/mechanism/let/half: "));
  CHECK(note_on_own(R"({"parameters": {"limit": {"unit": "m", "default": 0.08}},
      "let": {"twice": "2*limit"}, "rules": [{"that": "twice > 0", "else": "no"}]})")
            .empty());
}

TEST_CASE("a drive along what the leaves hold names them and the free directions") {
  const std::string text = note_on_own(R"({"drive": {"direction": "ux"}})");
  CHECK_THAT(text, StartsWith("/design/mechanism/drive = ux: held by leaf, "));
  CHECK_THAT(text, EndsWith("free: uy, rx, rz."));
  // a mount holds all directions, and is driven in one of them
  json document = base_job("evaluate");
  document["design"] = {
      {"family", "hexapod"}, {"material", "stavax"}, {"parameters", json::object()}};
  document.erase("model");
  CHECK(parse_job(document).notes.empty());
}

TEST_CASE("strips that are far wider than long, and thin, are told to be notches") {
  const char* strip = R"({"stroke": {"from": null, "to": "0.05 mm"}, "design": {"parameters":
      {"length": "1.8 mm", "width": "20 mm", "thickness": "0.1 mm"}}})";
  const std::string text = note(strip);
  CHECK_THAT(text, StartsWith("/design/parameters/width = 20 mm (leaf +y, leaf -y): 11 times"));
  CHECK_THAT(text, Contains("w^2/(L t) = 2222") && Contains("88 times as stiff"));
  CHECK(notes(R"({"stroke": {"from": null, "to": "0.05 mm"}, "design": {"parameters":
      {"length": "20 mm", "width": "20 mm", "thickness": "0.1 mm"}}})")
            .empty());
}

TEST_CASE("a slender leaf that its drive twists wants a finer mesh, unless the job has a model") {
  const auto told = [](double width, const char* direction, const char* model, double to = 0.3) {
    json document = patched(R"({"loads": null, "model": null, "stroke": {"from": 0}})");
    document["stroke"]["to"] = to;
    document["design"] = {{"material", "stavax"},
                          {"parameters", json::object()},
                          {"mechanism", json::parse(R"({"flexopt_design": 1, "name": "bar",
             "bodies": [{"name": "end_effector", "at": [0.08, 0, 0]}],
             "leaves": [{"name": "leaf", "base": {"body": "ground", "at": [0, 0, 0]},
                         "tip": {"body": "end_effector", "at": [0.08, 0, 0]},
                         "across": [0, 0, 1], "thickness": 3e-4}]})")}};
    document["design"]["mechanism"]["leaves"][0]["width"] = width;
    document["design"]["mechanism"]["drive"] = {{"direction", direction}};
    if (*model) document["model"] = json::parse(model);
    const std::vector<std::string> notes = parse_job(document).notes;
    return notes.empty() ? "" : notes.front();
  };
  CHECK_THAT(told(0.008, "rx", ""), StartsWith("/model = nothing (leaf): rx twists the leaf") &&
                                        Contains("12 x 5") && Contains("[24, 10]"));
  CHECK(told(0.008, "rx", R"({"estimate": true})").empty());
  CHECK(told(0.008, "rz", "").empty());
  CHECK(told(0.03, "rx", "").empty());
  CHECK(told(0.008, "rx", "", 1e-3).empty());  // hardly stressed
}

TEST_CASE(
    "frequencies without any mass but the leaves' are told, unless it is written to be zero") {
  CHECK_THAT(note(R"({"end_effector": null})"), StartsWith("/end_effector/mass = nothing: "));
  CHECK(notes(R"({"end_effector": null, "frequencies": null})").empty());
  CHECK(notes(R"({"end_effector": {"mass": 0, "inertia": null}})").empty());
}

TEST_CASE("a mesh of another material, unit or place than its design is told with figures") {
  json body = json::parse(R"({"name": "end_effector", "at": ["70 mm", "1.5 mm", 0],
      "elastic": {"payload": "RIGHT",
                  "material": {"youngs_modulus": 70e9, "poissons_ratio": 0.33, "density": 2700},
                  "mesh": {"units": "mm"},
                  "interfaces": [{"name": "RIGHT"}, {"name": "LEFT"}]}})");
  body["elastic"]["mesh"]["file"] = FLEXOPT_SOURCE_DIR "/tests/designs/data/box.inp";
  const auto noted = [&](const json& body, const char* end, const char* length) {
    json leaf = {{"name", "leaf"}, {"across", {0, 0, 1}}, {"width", 3e-3}, {"thickness", 2e-4}};
    leaf["base"] = {{"body", "ground"}, {"at", {end, 0, 0}}};
    leaf["tip"] = {{"body", "end_effector.LEFT"}, {"at", {length, 0, 0}}};
    const json patch = {{"bodies", json::array({body})}, {"leaves", json::array({leaf})}};
    return note_on_own(patch.dump().c_str());
  };
  CHECK(noted(body, "20 mm", "60 mm") == "");
  CHECK_THAT(noted(body, "20 mm", "56 mm"),
             Contains("/leaves/0/tip") && Contains("4 mm off the nodes of LEFT"));
  json other = body;
  other["elastic"]["material"]["youngs_modulus"] = 210e9;
  CHECK_THAT(noted(other, "20 mm", "60 mm"),
             Contains("youngs_modulus = 210 GPa") && Contains("the file of the mesh has 70 GPa"));
  CHECK_THAT(noted(body, "-1 m", "60 mm"), Contains("/elastic/mesh/units"));
}

TEST_CASE("a material of an elastic body's own is looked at, too") {
  const std::string text = note_on_own(R"({
      "bodies": [{"name": "end_effector", "at": [0.08, 0, 0],
        "elastic": {"box": ["7 mm", "30 mm", "20 mm"], "center": ["3.5 mm", 0, 0],
                    "material": {"youngs_modulus": "70 GPa", "poissons_ratio": 0.33, "density": 7.8},
                    "elements": {"size": "10 mm"},
                    "interfaces": [{"name": "O", "face": "x+"}]}}]})");
  CHECK_THAT(text, StartsWith("/design/mechanism/bodies/0/elastic/material/density = 7.8 kg/m^3 "
                              "(end_effector)") &&
                       Contains("meant: 7800 kg/m^3"));
}

TEST_CASE("a box that weighs in addition to an elastic body is told") {
  const std::string text = note_on_own(R"({
      "bodies": [{"name": "end_effector", "at": [0.08, 0, 0], "density": "2700 kg/m^3",
        "box": ["7 mm", "30 mm", "20 mm"], "center_of_mass": ["3.5 mm", 0, 0],
        "elastic": {"box": ["7 mm", "30 mm", "20 mm"], "center": ["3.5 mm", 0, 0],
                    "elements": {"size": "10 mm"},
                    "interfaces": [{"name": "O", "face": "x+"}]}}]})");
  CHECK_THAT(text, Contains("/bodies/0/density") && Contains("in addition"));
}

TEST_CASE("warnings of listed designs have pointers into the list") {
  json document = base_job("designs");
  document["material"] = {
      {"youngs_modulus", "210 MPa"}, {"poissons_ratio", 0.3}, {"density", 7800}};
  const Job job = parse_job(document);
  REQUIRE(job.notes.size() == 2);
  CHECK_THAT(job.notes[1], StartsWith("hub: /material/youngs_modulus = 210 MPa"));
}
