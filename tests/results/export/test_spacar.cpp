#include <regex>
#include <set>
#include <sstream>

#include "core/spec/spec_error.hpp"
#include "results/export/exported.hpp"
#include "tests/results/export/gallery.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

using Rows = std::vector<std::vector<double>>;

/// A script as MATLAB would have it: matrices, and structures by index and field.
struct Script {
  std::map<std::string, Rows> matrices;
  std::map<std::string, std::map<int, std::map<std::string, std::string>>> structures;
  std::map<std::string, std::string> options;
  bool called = false;
};

std::vector<double> numbers(std::string text) {
  for (char& c : text)
    if (c == '[' || c == ']' || c == ';') c = ' ';
  std::istringstream stream(text);
  std::vector<double> list;
  for (double x = 0; stream >> x;) list.push_back(x);
  REQUIRE(stream.eof());
  return list;
}

/// Fails at every line that is none of the published syntax.
Script parse(const std::string& text) {
  static const std::regex begin(R"((nodes|elements) = \[)"), row(R"(  [-0-9.e+ ]+;)"),
      entry(
          R"((nprops|eprops)\((\d+)\)\.([a-z_]+) = (true|'[a-z]+'|1:6|[-0-9.e+]+|\[[-0-9.e+ ]+\]);)"),
      option(R"(opt\.([a-z]+) = (.+);)"),
      call(R"(out = spacarlight\(nodes, elements, nprops, eprops, opt\);)");
  Script script;
  std::istringstream lines(text);
  Rows* matrix = nullptr;
  for (std::string line; std::getline(lines, line);) {
    CAPTURE(line);
    std::smatch m;
    if (line.empty() || line[0] == '%' || line == "clear") continue;
    if (line == "];") {
      matrix = nullptr;
    } else if (matrix) {
      REQUIRE(std::regex_match(line, row));
      matrix->push_back(numbers(line));
    } else if (std::regex_match(line, m, begin)) {
      matrix = &script.matrices[m[1]];
    } else if (std::regex_match(line, m, entry)) {
      CHECK(script.structures[m[1]][std::stoi(m[2])].emplace(m[3], m[4]).second);
    } else if (std::regex_match(line, m, option)) {
      script.options[m[1]] = m[2];
    } else {
      REQUIRE(std::regex_match(line, call));
      script.called = true;
    }
  }
  return script;
}

Vector3d place(const Script& script, double node) {
  const auto& row = script.matrices.at("nodes").at(static_cast<std::size_t>(node) - 1);
  return {row.at(0), row.at(1), row.at(2)};
}

// Every key that SPACAR Light has, by its page "SPACAR Light full syntax" (spacar.nl), the list of
// allowed fields in spacarlight.m, and the scripts that come with it: what it means, as a test can
// see it.
enum class Value { yes, number, three, six, name, list };
const std::map<Value, std::size_t> count_of{{Value::number, 1}, {Value::three, 3}, {Value::six, 6}};
using Keys = std::map<Value, std::set<std::string>>;
const Keys node_keys{{Value::yes, {"fix", "fix_pos", "fix_orien", "fix_x", "fix_y", "fix_z"}},
                     {Value::number,
                      {"displ_x", "displ_y", "displ_z", "displ_initial_x", "displ_initial_y",
                       "displ_initial_z", "rot_x", "rot_y", "rot_z",  // [rad]; one of a node
                       "mass"}},
                     // applied in the load steps, beside the displacements; before the first
                     {Value::three, {"force", "moment", "force_initial", "moment_initial"}},
                     {Value::six, {"mominertia"}}};  // Ixx Ixy Ixz Iyy Iyz Izz
const Keys element_keys{
    {Value::yes, {"hide", "warping"}},
    {Value::number, {"emod", "smod", "dens", "nbeams", "opacity"}},
    {Value::three, {"orien"}},                 // along the width
    {Value::name, {"cshape", "color"}},        // 'rect', 'circ'
    {Value::list, {"elems", "dim", "flex"}}};  // dim: [width thickness], diameter
const Keys option_keys{{Value::yes, {"silent", "calcbuck", "showinputonly", "calccompl"}},
                       {Value::number, {"loadsteps"}},
                       {Value::three, {"gravity"}},
                       {Value::name, {"filename"}}};
// Fields of out.step(i).node(j): reaction on a driven node, compliance of a node in global axes.
const std::set<std::string> output_keys{"p", "r_axang", "Freac", "Mreac", "CMglob"};

void check_key(const Keys& known, const std::string& key, const std::string& value) {
  INFO(key << " = " << value);
  const auto found =
      std::ranges::find_if(known, [&](const auto& kind) { return kind.second.contains(key); });
  REQUIRE(found != known.end());
  switch (found->first) {
    case Value::yes:
      CHECK(value == "true");
      break;
    case Value::name:
      CHECK((value.size() > 2 && value.front() == '\'' && value.back() == '\''));
      break;
    case Value::list:
      CHECK((value == "1:6" || !numbers(value).empty()));
      break;
    default:
      CHECK(numbers(value).size() == count_of.at(found->first));
  }
}

// What spacarlight() itself checks of its input.
void check_valid(const Script& script) {
  const Rows &nodes = script.matrices.at("nodes"), &elements = script.matrices.at("elements");
  for (const auto& row : nodes) CHECK(row.size() == 3);
  std::set<std::set<double>> pairs;
  std::set<double> used;
  double longest = 0, shortest = 1e300;
  for (const auto& row : elements) {
    REQUIRE(row.size() == 2);
    CHECK(row[0] != row[1]);
    CHECK(pairs.insert({row[0], row[1]}).second);
    used.insert(row.begin(), row.end());
    const double length = (place(script, row[1]) - place(script, row[0])).norm();
    CHECK(length > 1e-5);
    longest = std::max(longest, length);
    shortest = std::min(shortest, length);
  }
  CHECK(longest / shortest <= 1000);
  CHECK(used.size() == nodes.size());  // each is attached
  int conditions = 0;
  for (const auto& [node, fields] : script.structures.at("nprops")) {
    CHECK(node <= static_cast<int>(nodes.size()));
    for (const auto& [name, value] : fields) {
      check_key(node_keys, name, value);
      if (name == "fix") conditions += 6;
    }
  }
  CHECK(conditions >= 6);
  std::set<double> in_sets;
  for (const auto& [number, fields] : script.structures.at("eprops")) {
    for (const auto& [name, value] : fields) check_key(element_keys, name, value);
    const auto orientation = numbers(fields.at("orien"));
    for (const double element : numbers(fields.at("elems"))) {
      CHECK(in_sets.insert(element).second);
      const auto& row = elements.at(static_cast<std::size_t>(element) - 1);
      const Vector3d along = (place(script, row[1]) - place(script, row[0])).normalized();
      CHECK(along.cross(Vector3d(orientation.data())).norm() > 0.1);
    }
    if (fields.contains("flex"))
      for (const char* name : {"emod", "smod", "dens", "cshape", "dim"})
        CHECK(fields.contains(name));
  }
  CHECK(in_sets.size() == elements.size());
  for (const auto& [name, value] : script.options) check_key(option_keys, name, value);
  CHECK(script.options.contains("loadsteps"));
  CHECK(script.called);
}

Script script_of(const std::string& name) {
  const Exported exported = test::gallery(name);
  return parse(spacar_script(exported, exported.largest_strokes()));
}

}  // namespace

TEST_CASE("Scripts for SPACAR Light have its syntax and what it checks") {
  for (const char* name : {"parallel_guide", "cross_hinge", "double_parallelogram", "curved_leaf",
                           "tapered_leaf", "folded_leaf", "folded_guide", "wire_flexure",
                           "cartwheel_hinge", "payload_on_guide", "spherical_joint", "xy_stage"}) {
    CAPTURE(name);
    if (std::string(name) == "xy_stage") {
      CHECK_THROWS_WITH(script_of(name), Contains("it stands on a body that moves"));
      continue;
    }
    check_valid(script_of(name));
  }
}

TEST_CASE("The guide in a script: two leaves, a body, its mass, the stroke") {
  const Script script = script_of("parallel_guide");
  int driven = 0, fixed = 0, massive = 0;
  for (const auto& [node, fields] : script.structures.at("nprops")) {
    fixed += fields.contains("fix");
    if (fields.contains("mass")) {
      ++massive;
      CHECK(fields.at("mass") == "1");
    }
    if (fields.contains("displ_y")) {
      ++driven;
      CHECK(fields.at("displ_y") == "0.02");
      CHECK((place(script, node) - Vector3d(0.1, 0, 0)).norm() < 1e-12);
    }
  }
  CHECK(fixed == 2);
  CHECK(driven == 1);
  CHECK(massive == 1);
  int leaves = 0, links = 0;
  for (const auto& [number, fields] : script.structures.at("eprops")) {
    if (!fields.contains("flex")) {
      links += static_cast<int>(numbers(fields.at("elems")).size());
      continue;
    }
    ++leaves;
    CHECK(numbers(fields.at("dim")) == std::vector<double>{0.03, 0.0005});
    CHECK(fields.at("cshape") == "'rect'");
    CHECK(numbers(fields.at("smod"))[0] == Approx(210e9 / 2.6));
  }
  CHECK(leaves == 2);
  CHECK(links == 2);
}

TEST_CASE("What a script says to look at is what SPACAR Light answers") {
  for (const char* name : {"parallel_guide", "cross_hinge"}) {
    const Exported exported = test::gallery(name);
    const std::string text = spacar_script(exported, exported.largest_strokes());
    static const std::regex answer(R"(out\.step\(end\)\.node\(\d+\)\.([A-Za-z_]+))");
    int named = 0;
    for (auto m = std::sregex_iterator(text.begin(), text.end(), answer);
         m != std::sregex_iterator(); ++m, ++named)
      CHECK(output_keys.contains((*m)[1]));
    CHECK(named == 6);  // the drive load, five supported directions
  }
}

TEST_CASE("What SPACAR Light cannot carry is refused by name") {
  CHECK_THROWS_WITH(script_of("hinged_leaf"), Contains("joint hinge"));
  CHECK_THROWS_WITH(script_of("crooked_guide"), Contains("assembly"));
  CHECK_THROWS_WITH(script_of("flat_blades"), Contains("assembly"));
  CHECK_THROWS_WITH(script_of("clamped_plate"), Contains("material point of leaf plate"));
  CHECK_THROWS_WITH(script_of("tip_tilt_stage"), Contains("one rotation of a node"));
}
