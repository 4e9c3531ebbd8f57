#pragma once
// A mechanism as nodes and beam elements. Numbers count from one.
#include <array>
#include <map>
#include <string>
#include <vector>

#include "results/export/exported.hpp"

namespace flexopt {

/// Elements of one section.
struct SpacarSet {
  std::string name;
  std::vector<int> elements;
  const Material* material = nullptr;  ///< none: rigid
  double width = 0, thickness = 0;     ///< [m]; of a circle the diameter twice
  bool round = false;
  Vector3d across = Vector3d::UnitZ();  ///< along the width
  int beams = 1;                        ///< in each element
};

class SpacarModel {
 public:
  /// Throws SpecError with all items that cannot be carried. `exported` must outlive this.
  explicit SpacarModel(const Exported& exported);
  /// Adds what acts: strokes, or the factor of the loads that grow, and constant loads.
  void drive(const VectorXd& strokes);

  const std::vector<Vector3d>& nodes() const { return nodes_; }
  const std::vector<std::array<int, 2>>& elements() const { return elements_; }
  const std::vector<SpacarSet>& sets() const { return sets_; }
  /// Properties by node: lines such as "fix = true", in their order.
  const std::map<int, std::vector<std::string>>& properties() const { return properties_; }
  /// The node of a body's reference point.
  int reference_of(int body) const;

 private:
  void check() const;
  int node_on(int group, const Vector3d& place);
  int add_element(int p, int q);
  void add_leaf(const LeafSpring& leaf);
  void add_masses();
  void add_holds();

  const Exported* exported_;
  std::vector<int> group_;  ///< group of each body; ground
  std::vector<Vector3d> nodes_;
  std::map<int, std::vector<int>> of_group_;  ///< nodes
  std::vector<std::array<int, 2>> elements_;
  std::vector<SpacarSet> sets_;
  std::map<int, std::vector<std::string>> properties_;
};

}  // namespace flexopt
