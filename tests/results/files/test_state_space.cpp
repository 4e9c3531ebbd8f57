// Linear models in files: JSON that has them whole, and a script that reads back to the same bits.
#include "results/files/result_parts.hpp"
#include "tests/results/results_tests.hpp"

namespace {

StrokeResponse modelled() {
  StrokeResponse response;
  response.path.resize(3);
  for (std::size_t k = 0; k < 3; ++k) {
    response.path[k].status = PointStatus::converged;
    response.path[k].stroke = 0.1 * static_cast<double>(k);
    response.path[k].strokes = {response.path[k].stroke};
  }
  StateSpace& model = response.path[1].state_space.emplace();
  model.inputs = {{"drive_load", "N"}, {"ground.ux", "m/s^2"}};
  model.outputs = {{"O.ux", "m"}, {"probe.o'clock.x", "m"}};
  model.omega2 = Eigen::Vector2d(1.0 / 3, 7e5);
  model.damping = Eigen::Vector2d(0.01, 0.02);
  model.forces = (MatrixXd(2, 2) << 1, -2.5e-300, 0.1, 4).finished();
  model.motions = (MatrixXd(2, 2) << -1, 2, 3, 1e-17).finished();
  model.residual = (MatrixXd(2, 2) << 1e-9, 0, 5, -6).finished();
  return response;
}

// The numbers of "models(1).name = [...]".
std::vector<double> numbers_of(const std::string& script, const std::string& name) {
  const std::string head = "models(1)." + name + " = [";
  const std::size_t first = script.find(head);
  REQUIRE(first != std::string::npos);
  std::string body =
      script.substr(first + head.size(), script.find(']', first) - first - head.size());
  for (char& c : body)
    if (c == ';') c = ' ';
  std::vector<double> numbers;
  std::istringstream in(body);
  for (std::string cell; in >> cell;) numbers.push_back(std::stod(cell));
  return numbers;
}

}  // namespace

TEST_CASE("the script has the numbers of the models to the last bit") {
  const StrokeResponse response = modelled();
  const std::string script = state_space_script(response, "two\nlines");
  CHECK_THAT(script, Contains("% two lines: linear models"));
  CHECK_THAT(script, Contains("inputs = {'drive_load', 'ground.ux'};"));
  CHECK_THAT(script, Contains("'probe.o''clock.x'"));
  CHECK_THAT(script, Contains("% point 1 of the path") && Contains("models(1).stroke = [0.1];"));
  CHECK_THAT(script, !Contains("models(2)"));
  const StateSpace& model = *response.path[1].state_space;
  CHECK(numbers_of(script, "omega2") == std::vector<double>{1.0 / 3, 7e5});
  for (const auto& [name, matrix] : {std::pair{"forces", &model.forces},
                                     {"motions", &model.motions},
                                     {"residual", &model.residual}}) {
    const std::vector<double> read = numbers_of(script, name);
    REQUIRE(read.size() == 4);
    for (Eigen::Index i = 0; i < 2; ++i)
      for (Eigen::Index j = 0; j < 2; ++j)
        CHECK(read[static_cast<std::size_t>(2 * i + j)] == (*matrix)(i, j));
  }
}

TEST_CASE("JSON has the models by rows, and a run without models leaves no script") {
  const StrokeResponse response = modelled();
  const OrderedJson json = state_space_json(*response.path[1].state_space);
  CHECK(json["forces"][0][1] == -2.5e-300);
  CHECK(json["motions"][1][0] == 3);
  CHECK(signals_json(response)["outputs"][1]["name"] == "probe.o'clock.x");
  CHECK(signals_json(response)["inputs"][1]["unit"] == "m/s^2");
  const test::TemporaryFolder folder;
  write_state_space(folder.path(), response, "guide");
  CHECK(test::content_of(folder.path() / "state_space.m") == state_space_script(response, "guide"));
  StrokeResponse none = response;
  none.path[1].state_space.reset();
  CHECK(signals_json(none).is_null());
  write_state_space(folder.path(), none, "guide");
  CHECK_FALSE(std::filesystem::exists(folder.path() / "state_space.m"));
}
