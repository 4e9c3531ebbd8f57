#include "results/files/scene.hpp"

#include "results/files/result_parts.hpp"
#include "support/models.hpp"
#include "support/solid_box.hpp"
#include "support/vtu.hpp"
#include "tests/results/results_tests.hpp"

namespace {

StrokeResponse evaluated(const Mechanism& mechanism, const ModelOptions& model) {
  StrokeRequest request;
  request.points = {0, 2e-3, 4e-3};
  request.outputs.add(Output::shapes);
  request.frequencies = 4;
  return evaluate_stroke(mechanism, model, request);
}

/// Largest motion of the points of both clamped edges that their body does not make.
double lost_edges(const Mechanism& mechanism, const PathPoint& point, const Mode& mode) {
  double lost = 0;
  for (std::size_t k = 0; k < mechanism.leaves.size(); ++k) {
    const LeafShape& shape = point.shapes[k];
    const VectorXd motion = mode.leaf_motion[k].size() > 0
                                ? mode.leaf_motion[k]
                                : cubic_leaf_motion(mechanism, k, point, mode.body_motion);
    REQUIRE(motion.size() == 3 * static_cast<Eigen::Index>(shape.deflected.size()));
    for (int j = 0; j < shape.points_across; ++j)
      for (const int end : {0, 1}) {
        const int i = j * shape.points_along + (end == 0 ? 0 : shape.points_along - 1);
        Vector3d rigid = Vector3d::Zero();
        if (end == 1)
          rigid = mode.body_motion.head<3>() +
                  mode.body_motion.segment<3>(3).cross(
                      shape.deflected[static_cast<std::size_t>(i)] - mechanism.bodies[0].reference -
                      point.bodies[0].displacement);
        lost = std::max(lost, (motion.segment<3>(3 * i) - rigid).norm());
      }
  }
  return lost;
}

}  // namespace

TEST_CASE("In every mode the clamped edges go with their bodies") {
  const Mechanism mechanism = models::guide(0.1, 0.03, 5e-4);
  ModelOptions plate, beam, chained, constant;
  plate.mesh = {6, 4};
  beam.flexure = Flexure::beam;
  beam.mesh = {8, 1};
  chained = beam;
  chained.method = Reduction::linear_craig_bampton;
  chained.superelements = {4, 0};
  constant = plate;
  constant.mass = LeafMass::constant;
  for (const ModelOptions& model : {plate, beam, chained, constant}) {
    const StrokeResponse response = evaluated(mechanism, model);
    REQUIRE(response.status == Status::ok);
    for (const PathPoint& point : response.path)
      for (const auto* modes : {&point.modes_free, &point.modes_locked}) {
        REQUIRE_FALSE(modes->empty());
        for (const Mode& mode : *modes) {
          REQUIRE(mode.body_motion.size() == 6);
          double largest = mode.body_motion.head<3>().norm();
          for (const VectorXd& leaf : mode.leaf_motion)
            if (leaf.size() > 0) largest = std::max(largest, leaf.cwiseAbs().maxCoeff());
          // With a mass that is turned only, not bent, edges follow to first order of the bending.
          const double tolerance = model.mass == LeafMass::constant ? 0.1 : 1e-6;
          CHECK(lost_edges(mechanism, point, mode) < tolerance * largest);
        }
      }
  }
}

TEST_CASE("The drive's mode bends leaves as cubics") {
  // Of two leaves whose mass is a thousandth of the body's: static shapes of guided beams.
  const Mechanism mechanism = models::guide(0.1, 0.006, 5e-4, 0.06, 10);
  ModelOptions beam;
  beam.flexure = Flexure::beam;
  beam.mesh = {8, 1};
  const StrokeResponse response = evaluated(mechanism, beam);
  const PathPoint& rest = response.path[0];
  const Mode& drive = rest.modes_free[0];
  REQUIRE(drive.kind == ModeKind::drive);
  const VectorXd cubic = cubic_leaf_motion(mechanism, 0, rest, drive.body_motion);
  CHECK((drive.leaf_motion[0] - cubic).cwiseAbs().maxCoeff() < 2e-3 * cubic.cwiseAbs().maxCoeff());
}

TEST_CASE("A scene has every equilibrium once") {
  RunRecord record = test::evaluated_hinge();
  const OrderedJson scene = make_scene(record);
  REQUIRE(scene["designs"].size() == 1);
  const OrderedJson& design = scene["designs"][0];
  CHECK(design["leaves"].size() == 2);
  CHECK(design["leaves"][0]["half_thickness"].size() == 9);
  CHECK(design["leaves"][0]["half_thickness"][4].get<double>() ==
        Approx(0.5 * record.mechanism.leaves[0].thickness));
  CHECK(unlike_text(design, R"({"frames": [0, 1, 2, 3, 4], "rest": {"shape": [72, 3]},
      "displacement": {"shape": [5, 72, 3]}, "von_mises": {"shape": [5, 72]},
      "motion": {"shape": [5, 1, 6]}, "drives": [{"direction": "rz"}]})") ==
        "");  // two leaves of 9 x 4 points
  for (PathPoint& point : record.response.path) point.shapes.clear();
  CHECK(make_scene(record)["designs"].empty());
}

TEST_CASE("A long path is drawn at fewer points, its ends among them") {
  RunRecord record = test::evaluated_hinge();
  const PathPoint last = record.response.path.back();
  for (int k = 0; k < 9000; ++k) record.response.path.push_back(last);
  const OrderedJson frames = make_scene(record)["designs"][0]["frames"];
  CHECK(frames.size() < 8000);
  CHECK(frames.size() > 6000);
  CHECK(frames.front() == 0);
  CHECK(frames.back() == 9004);
  CHECK(std::ranges::find(frames, OrderedJson(2)) != frames.end());
}

TEST_CASE("A scene of several designs leaves out what would not fit, and says so") {
  const OrderedJson one = make_scene(test::evaluated_hinge());
  OrderedJson huge = one;
  huge["designs"][0]["rest"]["data"] = std::string(8'000'000, 'A');
  const OrderedJson all = merged_scene({huge, one, one}, {"huge", "b", "c"}, {2, 0, 1});
  CHECK(unlike_text(all, R"({"designs": [{"label": "c"}, {"label": "b", "kind": "listed"}],
                             "left_out": ["huge"]})") == "");
}

TEST_CASE("An optimisation's scene has its start and all evaluated designs") {
  RunRecord record = test::optimised_hinge();
  record.others = {
      {"start", "start", record.optimum->parameters, record.mechanism, record.optimum->response}};
  const OrderedJson scene = make_scene(record);
  REQUIRE(scene["designs"].size() == 2);
  CHECK(scene["designs"][1]["kind"] == "start");
  CHECK(scene["designs"][1]["path"].size() == 5);
  CHECK(unlike_text(scene["evaluations"], R"({"variables": ["thickness", "half_angle"],
                                              "values": {"shape": [32, 6]}})") == "");
  CHECK(scene["evaluations"]["start"].size() == 32);
  const test::TemporaryFolder folder;
  write_scene(folder.path(), scene);
  CHECK(read_scene(folder.path()) == scene);
  write_scene(folder.path(), OrderedJson({{"designs", OrderedJson::array()}}));
  CHECK(read_scene(folder.path()).is_null());
}

TEST_CASE("An elastic body is in the scene, the shape files and the result") {
  RunRecord record = test::evaluated_hinge();
  Mechanism& m = record.mechanism;
  ElasticBody box = models::box({0.1, 0.01, 0.01}, {6, 2, 2});
  box.name = "bar";
  box.material.allowable_stress = 200e6;
  box.place = {0.05, 0, 0};
  models::hold_end(box, "base", ground, -1);
  models::hold_end(box, "tip", 0, 1);
  m = {};
  m.bodies = {models::body({0.1, 0, 0}, 0.1, 1e-5)};
  m.elastic_bodies = {box};
  m.drives = {make_drive(Direction::uy)};
  record.job.request.points = {0, 1e-3};
  StrokeRequest request = record.job.request;
  request.outputs.add(Output::shapes);
  request.frequencies = 2;
  record.response = evaluate_stroke(m, {}, request);
  REQUIRE(record.response.status == Status::ok);
  const OrderedJson scene = make_scene(record);
  REQUIRE(scene["designs"].size() == 1);
  // 7 x 3 x 3 corners but 5 inside; two triangles for each of 6 x 8 + 2 x 4 faces
  CHECK(unlike_text(scene["designs"][0],
                    R"({"leaves": [], "rest": {"shape": [58, 3]}, "von_mises": {"shape": [2, 58]},
      "elastic_bodies": [{"name": "bar", "points": 58, "bodies": [-1, 0],
                          "grounds": [{"low": [0, -0.005, -0.005], "high": [0, 0.005, 0.005]}],
                          "triangles": {"shape": [112, 3]}}]})") == "");
  CHECK(scene["designs"][0]["modes"]["leaves"]["shape"][2] == 58);
  const std::string xml = point_vtu(m, record.response.path[1]);
  CHECK(test::data_array(xml, "Points").size() == 3 * 58);
  CHECK(test::data_array(xml, "types") == std::vector<double>(112, 5));
  CHECK(test::data_array(xml, "connectivity").size() == 3 * 112);
  CHECK(test::data_array(xml, "offsets").back() == 3 * 112);
  CHECK(xml.find("mode 1") != std::string::npos);
  const OrderedJson point = make_path_point(record.response.path[1], m, request);
  const double stress = point["max_stress"];
  CHECK(stress > 1e6);
  CHECK(point["elastic_bodies"][0]["max_stress"] == stress);
  CHECK(point["elastic_bodies"][0]["max_stress_jump"].get<double>() > 0);
  CHECK(point["max_stress_place"]["elastic_body"] == "bar");
  CHECK(point["max_stress_place"]["allowable_stress"] == 200e6);
  CHECK(point["allowable_stress_place"]["elastic_body"] == "bar");
  CHECK(point["allowable_stress_place"]["stress"] == stress);
  CHECK(point["max_stress_place"]["position"] == point["elastic_bodies"][0]["max_stress_position"]);
}
