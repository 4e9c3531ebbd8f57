#pragma once
// A mechanism as CalculiX sees it: nodes of solid leaves and elastic bodies, rigid bodies, springs.
// Node numbers count from one.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "core/math/types.hpp"
#include "results/export/exported.hpp"
#include "results/export/parts.hpp"

namespace flexopt {

/// Nodes that move as one rigid body: bodies that rigid joints tie together, or a clamped edge that
/// sits elsewhere than designed.
struct CcxRigid {
  std::string name;
  int body = ground;  ///< whose reference point the reference node is; ground of an edge
  int reference = 0, rotation = 0;  ///< nodes: displacement, rotation vector
  std::vector<int> nodes;           ///< that it carries
};

struct CcxMass {
  int node = 0;
  double mass = 0;  ///< [kg]
};

struct CcxSpring {
  int node = 0, other = 0;
  const Spring* spring = nullptr;
};

/// Nodes of two bodies that stay in one place.
struct CcxPin {
  int node = 0, other = 0;
  const Joint* joint = nullptr;
};

/// Nodes at the place of a bushing and those of the rotation vectors; zeros: the ground.
struct CcxBushing {
  int node = 0, rotation = 0, other = 0, other_rotation = 0;
  const Spring* spring = nullptr;
};

struct CcxModel {
  /// Throws SpecError with all items that a deck cannot carry. `exported` must outlive this.
  CcxModel(const Exported& exported, const SolidMeshSize& size);

  const Exported& exported;
  const Mechanism& mechanism = exported.mechanism;
  std::vector<Vector3d> nodes;
  std::vector<CcxRigid> rigids;
  std::vector<CcxMass> masses;
  std::vector<CcxSpring> springs;
  std::vector<CcxPin> pins;
  std::vector<CcxBushing> bushings;
  std::vector<int> fixed;
  std::vector<std::vector<std::array<int, 20>>> elements;  ///< of each leaf
  std::vector<std::pair<int, int>> nodes_of;               ///< first and last node of each leaf
  std::vector<int> nodes_before;  ///< of each elastic body: how many nodes are before its own
  int at_O = 0;  ///< node of the end-effector at O beside the reference node, for loads
  /// For each dead load of the case, growing ones after constant ones: the node on which it acts.
  std::vector<int> load_nodes;
  /// For each drive, the node of the body `other` from which the stroke is measured: where the
  /// reference point is undeflected, or for a rotation the node of the rotation vector; 0: the
  /// ground.
  std::vector<int> drive_nodes;
  std::vector<int> placed_edges;  ///< for each assembly error, the rigid body of its edge

  /// The rigid body that a body belongs to; none of a body that is tied to the ground.
  const CcxRigid* rigid_of(int body) const;
  /// Node and degree of freedom of a direction of a body that has a reference node of its own.
  std::pair<int, int> freedom(int body, Direction direction) const;

 private:
  int add(const Vector3d& place);
  /// A new node that moves with the body; fixed where that is the ground.
  int add_on(int body, const Vector3d& place);
  /// The nodes that move with the body; those that are fixed where that is the ground.
  std::vector<int>& nodes_on(int body);
  void add_bodies();
  void add_masses(int body);
  void add_leaves(const SolidMeshSize& size);
  void add_elastic_bodies();
  void clamp(std::size_t leaf, int end, const std::vector<int>& edge);
  void add_ties();
  void add_joint(const Joint& joint);
  void add_bushing(const Spring& spring);
  int rotation_of(int body) const;  ///< node; 0: the ground

  std::vector<int> rigid_of_;  ///< rigid body of each body, −1: tied to the ground
};

// What a deck of CalculiX cannot carry.

/// Throws SpecError that names every such item of the mechanism and of its loads.
void check_carried_by_ccx(const Exported& exported);

/// Checks what a deck carries about axes that stay fixed, while those of flexopt turn with bodies.
/// Throws SpecError where this matters at this point of the stroke.
void check_near_in_ccx(const Exported& exported, const PathPoint& point);

// Lines of a deck of CalculiX.

/// CalculiX reads 20 characters of a number: 12 digits with sign and exponent.
class CcxLines {
 public:
  template <class... T>
  void line(fmt::format_string<T...> format, T&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<T>(values)...);
    text_ += '\n';
  }
  void numbers(const std::vector<int>& list) {
    for (std::size_t k = 0; k < list.size(); k += 12) {
      const auto begin = list.begin() + static_cast<std::ptrdiff_t>(k);
      const auto end = list.begin() + static_cast<std::ptrdiff_t>(std::min(k + 12, list.size()));
      line("{},", fmt::join(begin, end, ", "));
    }
  }
  std::string text() && { return std::move(text_); }

 private:
  std::string text_;
};

/// Writes the elements of elastic bodies, in sets ELASTIC1, …; returns the number of elements,
/// which was `number` before.
int write_cells(const CcxModel& model, int number, CcxLines& deck);

/// One term of an equation: factor times a degree of freedom of a node.
struct CcxTerm {
  int node = 0, dof = 0;
  double factor = 0;
};
/// The sum of the terms is zero; the first depends on the others.
void write_equation(const std::vector<CcxTerm>& terms, CcxLines& deck);

/// Terms of a · u of a node; a unit vector, the largest component first.
std::vector<CcxTerm> terms_along(int node, const Vector3d& axis);

// What ties rigid bodies in a deck of CalculiX: springs, bushings, joints; and their point masses.

/// Writes the elements; `number`: of elements so far.
///
/// Joints are stiff linear springs between nodes that lie in one place, as many times as stiff as
/// the stiffest leaf along itself as `pin_stiffness` says (without leaves, as E times the size of
/// an elastic body): one such pin lets bodies turn about it, two on an axis let them turn about
/// that. A bushing with the matrix K, energy ½ eᵀ K e in e = q − q′, becomes linear springs −S_ij
/// between each two of its degrees of freedom, S = [K −K; −K K], and against the ground Σ_j K_ij
/// besides; its axes stay where they are.
void write_ties(const CcxModel& model, int number, CcxLines& deck);

/// What joints hold that CalculiX takes as equations: slides on the ground.
void write_slides(const CcxModel& model, CcxLines& deck);

inline constexpr double pin_stiffness = 1e4;

}  // namespace flexopt
