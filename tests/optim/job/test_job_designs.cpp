// A job that lists designs is as many jobs of one design each.
#include "optim/job/job_sections.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

json hinges() {
  return json::parse(R"({
    "flexopt": 1, "name": "which hinge", "job": "optimise",
    "designs": [
      {"family": "cross_hinge",
       "parameters": {"length": "80 mm", "width": "20 mm", "thickness": "0.3 mm", "gap": "1 mm"},
       "variables": [{"parameter": "length", "min": "40 mm", "max": "100 mm"}]},
      {"name": "hub", "family": "cartwheel_hinge", "material": "stavax",
       "parameters": {"length": "40 mm", "width": "40 mm", "thickness": "0.3 mm"},
       "variables": [{"parameter": "thickness", "min": "0.1 mm", "max": "1 mm"},
                     {"parameter": "width", "min": "10 mm", "max": "80 mm"}]},
      {"family": "cross_hinge",
       "parameters": {"length": "60 mm", "width": "20 mm", "thickness": "0.3 mm", "gap": "1 mm"},
       "variables": [{"parameter": "thickness", "min": "0.1 mm", "max": "1 mm"}]}],
    "material": {"youngs_modulus": "200 GPa", "poissons_ratio": 0.3, "density": 7800},
    "end_effector": {"mass": "1 kg", "inertia": [1e-3, 1e-3, 1e-3]},
    "stroke": {"to": "20 deg", "points": 3}, "frequencies": 2,
    "optimise": {"objective": {"maximise": "parasitic_frequency"},
      "constraints": [{"quantity": "envelope.cylinder", "max": "100 mm"},
                      {"quantity": "max_stress", "max": "600 MPa"}],
      "algorithm": {"library": "ipopt"}}
  })");
}

std::string check_cycle(const json& document) {
  const SpecError error = test::refusal_of([&] { (void)parse_job(document); });
  return error.pointer() + ": " + error.what();
}

}  // namespace

TEST_CASE("each listed design is the job that it would be alone") {
  const json document = hinges();
  const Job all = parse_job(document);
  REQUIRE(all.designs.size() == 3);
  CHECK(all.name == "which hinge");
  CHECK(all.designs[0].label == "cross_hinge");
  CHECK(all.designs[1].label == "hub");
  CHECK(all.designs[2].label == "cross_hinge_2");
  CHECK(all.designs[2].folder == "designs/cross_hinge_2");
  for (std::size_t k = 0; k < 3; ++k) {
    json alone = document;
    alone.erase("designs");
    alone.erase("material");
    alone["name"] = all.designs[k].label;
    json design = document["designs"][k];
    alone["optimise"]["variables"] = design["variables"];
    design.erase("variables");
    design.erase("name");
    if (!design.contains("material")) design["material"] = document["material"];
    alone["design"] = design;
    CHECK(document_of(*all.designs[k].job) == document_of(parse_job(alone)));
  }
}

TEST_CASE("the job as read lists every design with all its numbers, and reads back to itself") {
  const Job all = parse_job(hinges());
  const json& read = document_of(all);
  CHECK_FALSE(read.contains("design"));
  CHECK_FALSE(read["optimise"].contains("variables"));
  CHECK(read["designs"][1]["material"].is_object());
  CHECK(read["designs"][0]["parameters"]["half_angle"].is_number());
  CHECK(read["designs"][2]["variables"][0]["min"] == 1e-4);
  const Job again = parse_job(read);
  CHECK(document_of(again) == read);
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(document_of(*again.designs[k].job) == document_of(*all.designs[k].job));
    CHECK(again.designs[k].folder == all.designs[k].folder);
  }
}

TEST_CASE("what is wrong with a listed design stands where the job has it") {
  json document = hinges();
  document["designs"][2]["parameters"]["length"] = "5 N";
  CHECK(check_cycle(document).starts_with("/designs/2/parameters/length: "));
  document = hinges();
  document["designs"][1]["variables"][0]["parameter"] = "gap";
  CHECK(check_cycle(document).starts_with("/designs/1/variables/0/parameter: "));
  document = hinges();
  document["material"]["density"] = "3 m";
  CHECK(check_cycle(document).starts_with("/material/density: "));
  document = hinges();
  document["stroke"]["to"] = "5 N";
  const std::string stroke = check_cycle(document);
  CHECK(stroke.starts_with("/stroke/to: "));
  CHECK(stroke.find("so says") == std::string::npos);  // they all do
}

TEST_CASE("a requirement that only some designs can name says which cannot") {
  json document = hinges();
  document["designs"][1] = {
      {"name", "guide"},
      {"family", "parallel_guide"},
      {"parameters", {{"length", 0.1}, {"width", 0.03}, {"thickness", 5e-4}, {"spacing", 0.05}}},
      {"variables", {{{"parameter", "length"}, {"min", 0.05}, {"max", 0.1}}}}};
  const std::string fault = check_cycle(document);
  CHECK(fault.starts_with("/stroke/to: "));
  CHECK(fault.find("so says the design \"guide\"") != std::string::npos);
}
