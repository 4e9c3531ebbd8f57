#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <optional>

#include "designs/solids/mesh_gatherer.hpp"

namespace flexopt {
namespace {

using Labels = std::vector<int>;

/// Cards that change the mesh and are not read, and those that join what is not joined by nodes.
const std::map<std::string, std::string, std::less<>> refused_cards{
    {"INCLUDE", "put the included file in its place: one file is read"},
    {"PART", "write the file without parts and assemblies (Abaqus/CAE: Model, Edit attributes)"},
    {"SYSTEM", "write nodes in global coordinates"},
    {"NGEN", "write all nodes out"},
    {"NFILL", "write all nodes out"},
    {"NCOPY", "write all nodes out"},
    {"ELGEN", "write all elements out"},
    {"ELCOPY", "write all elements out"}};
constexpr std::array<std::string_view, 6> joining_cards{"TIE",        "EQUATION", "MPC",
                                                        "RIGID BODY", "COUPLING", "KINEMATIC"};

/// An element by its name: a solid, or something that its sets alone are wanted of.
struct InpType {
  std::optional<SolidCell> cell;
  int nodes = 0;
};

InpType inp_type(const NumberedLines& lines, const std::string& name) {
  static const std::map<std::string, SolidCell, std::less<>> solids{
      {"C3D20", SolidCell::hexahedron},
      {"C3D20R", SolidCell::hexahedron},
      {"C3D15", SolidCell::wedge},
      {"C3D10", SolidCell::tetrahedron}};
  if (const auto solid = solids.find(name); solid != solids.end())
    return {solid->second, nodes_of(solid->second)};
  for (const std::string_view prefix : {"S", "CPS", "CPE", "CAX", "M3D", "SFM3D", "T3D"})
    if (name.starts_with(prefix))
      if (const int nodes = std::atoi(name.c_str() + prefix.size()); nodes > 1 && nodes < 10)
        return {std::nullopt, nodes};
  if (name.starts_with("C3D4") || name.starts_with("C3D6") || name.starts_with("C3D8"))
    lines.fail(name + " is linear; mesh with quadratic elements: C3D20R, C3D15, C3D10");
  lines.fail(name + " is no solid element that is read: C3D20, C3D20R, C3D15, C3D10");
}

class InpReader {
 public:
  InpReader(NumberedLines lines, double unit) : lines_(std::move(lines)), mesh_(unit) {}

  ImportedMesh read() {
    while (lines_.next()) {
      const std::string_view text = lines_.text();
      if (text.empty() || text.starts_with("**")) continue;
      if (text.starts_with('*'))
        begin_card(text.substr(1));
      else if (card_ == "NODE")
        read_node();
      else if (card_ == "ELEMENT")
        read_element();
      else if (set_ != nullptr)
        read_set(text);
      else
        read_material();
    }
    expect_whole_element();
    for (const auto& [name, labels] : node_sets_) mesh_.add_to_set(name, labels);
    for (const auto& [name, labels] : element_sets_) add_surface(name, labels);
    for (const auto& [type, count] : surfaces_)
      mesh_.skip(
          fmt::format("elements {} ({}) are no solids; their sets are sets of nodes", type, count));
    return mesh_.finish(lines_);
  }

 private:
  using Sets = std::map<std::string, Labels>;  ///< by their names in capitals

  /// A line of a keyword and its parameters, which goes on where it ends with a comma.
  void begin_card(std::string_view text) {
    expect_whole_element();
    std::string whole(text);
    while (whole.ends_with(',') && lines_.next()) whole += lines_.text();
    options_.clear();
    std::string_view rest = whole;
    for (bool first = true; !rest.empty(); first = false) {
      const std::string_view item = rest.substr(0, rest.find(','));
      rest.remove_prefix(std::min(item.size() + 1, rest.size()));
      const std::size_t equals = std::min(item.find('='), item.size());
      const std::string key = capitals(trimmed(item.substr(0, equals)));
      if (first)
        card_ = key;
      else
        options_[key] = capitals(trimmed(item.substr(std::min(equals + 1, item.size()))));
    }
    if (const auto refused = refused_cards.find(card_); refused != refused_cards.end())
      lines_.fail(fmt::format("*{} is not read; {}", card_, refused->second));
    if (std::ranges::find(joining_cards, card_) != joining_cards.end())
      mesh_.skip(fmt::format("*{} joins nodes; it is not taken over", card_));
    open_sets();
  }

  void open_sets() {
    set_ = nullptr;
    if (card_ == "NODE" || card_ == "NSET") {
      if (options_.contains("SYSTEM") || options_.contains("ELSET"))
        lines_.fail(fmt::format("*{} with SYSTEM or ELSET is not read", card_));
      if (options_.contains("NSET")) set_ = &node_sets_[options_["NSET"]];
    } else if (card_ == "ELEMENT" || card_ == "ELSET") {
      if (options_.contains("ELSET")) set_ = &element_sets_[options_["ELSET"]];
      if (card_ == "ELEMENT") type_ = inp_type(lines_, options_["TYPE"]);
    } else if (card_ == "SOLID SECTION") {
      if (material_.empty()) material_ = options_["MATERIAL"];
      if (material_ != options_["MATERIAL"])
        lines_.fail(fmt::format("materials {} and {}; an elastic body is of one material",
                                material_, options_["MATERIAL"]));
    }
  }

  void read_node() {
    const std::vector<double>& numbers = lines_.numbers(4);
    const int label = lines_.whole(numbers[0]);
    mesh_.add_node(lines_, label, {numbers[1], numbers[2], numbers[3]});
    if (set_ != nullptr) set_->push_back(label);
  }

  void read_element() {
    for (const double number : lines_.numbers(1)) element_.push_back(lines_.whole(number));
    const std::size_t wanted = 1 + type_.nodes;
    if (element_.size() < wanted) return;
    if (element_.size() > wanted)
      lines_.fail(fmt::format("an element {} of {} nodes", options_["TYPE"], element_.size() - 1));
    const Labels nodes(element_.begin() + 1, element_.end());
    if (set_ != nullptr) set_->push_back(element_[0]);
    if (type_.cell) {
      mesh_.add_cell(lines_, *type_.cell, nodes);
    } else {
      ++surfaces_[options_["TYPE"]];
      surface_nodes_[element_[0]] = nodes;
    }
    element_.clear();
  }

  /// The first line of a constant of the material.
  void read_material() {
    if (card_ == "ELASTIC" && !options_.contains("TYPE")) {
      const std::vector<double>& numbers = lines_.numbers(2);
      mesh_.set_elastic(numbers[0], numbers[1]);
    } else if (card_ == "DENSITY") {
      mesh_.set_density(lines_.numbers(1)[0]);
    }
    card_.clear();
  }

  void expect_whole_element() {
    if (!element_.empty())
      lines_.fail(fmt::format("element {} before it lacks nodes", element_[0]));
  }

  /// Numbers and names of sets above, or first, last and step.
  void read_set(std::string_view rest) {
    if (options_.contains("GENERATE")) {
      const std::vector<double>& range = lines_.numbers(2);
      const int first = lines_.whole(range[0]), last = lines_.whole(range[1]),
                step = range.size() > 2 ? lines_.whole(range[2]) : 1;
      if (step < 1) lines_.fail("the step of a generated set is 1 or more");
      for (std::int64_t label = first; label <= last; label += step)
        set_->push_back(static_cast<int>(label));
      return;
    }
    const Sets& sets = card_ == "NSET" ? node_sets_ : element_sets_;
    while (!rest.empty()) {
      const std::string_view item = rest.substr(0, rest.find(','));
      rest.remove_prefix(std::min(item.size() + 1, rest.size()));
      const std::string name = capitals(trimmed(item));
      if (name.empty()) continue;
      const auto other = sets.find(name);
      const bool number = name.find_first_not_of("0123456789") == std::string::npos;
      if (!number && other == sets.end())
        lines_.fail(fmt::format("there is no set {} above", name));
      const Labels labels =
          number ? Labels{lines_.whole(std::strtod(name.c_str(), nullptr))} : other->second;
      set_->insert(set_->end(), labels.begin(), labels.end());
    }
  }

  /// A set of surface elements is the set of their nodes, unless a node set has its name.
  void add_surface(const std::string& name, const Labels& elements) {
    if (node_sets_.contains(name)) return;
    for (const int element : elements)
      if (const auto nodes = surface_nodes_.find(element); nodes != surface_nodes_.end())
        mesh_.add_to_set(name, nodes->second);
  }

  NumberedLines lines_;
  MeshGatherer mesh_;
  std::string card_, material_;
  std::map<std::string, std::string> options_;  ///< of the card, in capitals
  Sets node_sets_, element_sets_;
  Labels* set_ = nullptr;  ///< that the lines of the card go to
  InpType type_;
  Labels element_;  ///< its number and nodes, as far as they are read
  std::map<std::string, int> surfaces_;
  std::unordered_map<int, Labels> surface_nodes_;
};

}  // namespace

ImportedMesh read_inp(NumberedLines lines, double unit) {
  return InpReader(std::move(lines), unit).read();
}

}  // namespace flexopt
