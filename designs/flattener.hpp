#pragma once
// Placement of the items of a design file: frames in frames, mirrored parts.
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/mechanism/mechanism.hpp"
#include "designs/elastic_item.hpp"
#include "designs/flat_design.hpp"

namespace flexopt {

/// Placement of an item's frame: global place = origin + axes · place. The axes are orthonormal,
/// and left-handed where a part is mirrored.
template <class S>
struct Placement {
  Vector3<S> origin = Vector3<S>::Zero();
  Matrix3<S> axes = Matrix3<S>::Identity();
  bool mirrored = false;
  bool plain = true;  ///< that of the file: nothing to compute, nothing to round
  bool fixed = true;  ///< no parameter turns it

  Vector3<S> direction(const Vector3<S>& v) const {
    return plain ? v : Vector3<S>(axes.lazyProduct(v));
  }
  Vector3<S> place(const Vector3<S>& v) const {
    return plain ? v : Vector3<S>(origin + direction(v));
  }
  /// The direction of a leaf's width: its normal is reflected with the leaf, not against it.
  Vector3<S> across(const Vector3<S>& v) const {
    return mirrored ? Vector3<S>(-direction(v)) : direction(v);
  }
  Matrix3<S> tensor(const Matrix3<S>& t) const {
    if (plain) return t;
    const Matrix3<S> left = axes.lazyProduct(t);
    return left.lazyProduct(axes.transpose());
  }
  Placement inside(const Vector3<S>& at, const Matrix3<S>& turned, bool reflects) const {
    Placement inner;
    inner.origin = place(at);
    inner.axes = plain ? turned : Matrix3<S>(axes.lazyProduct(turned));
    inner.mirrored = mirrored != reflects;
    inner.plain = false;
    inner.fixed = fixed;
    return inner;
  }
};

template <class S>
Matrix3<S> turn_about(int axis, const S& angle) {
  using std::cos, std::sin;
  const int j = (axis + 1) % 3, k = (axis + 2) % 3;
  Matrix3<S> turn = Matrix3<S>::Identity();
  turn(j, j) = turn(k, k) = cos(angle);
  turn(k, j) = sin(angle);
  turn(j, k) = -turn(k, j);
  return turn;
}

/// Directions of coordinates in a plane: `along` as far as it lies in the plane; else those of x,
/// y, z that the normal is not, in this order. Zero or nothing where `along` is the normal.
template <class S>
std::array<Vector3<S>, 2> in_plane(const Vector3<S>& normal,
                                   const std::optional<Vector3<S>>& along = std::nullopt) {
  int k = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(value_of(normal[i])) > std::abs(value_of(normal[k])) + 1e-9) k = i;
  Vector3<S> u = Vector3<S>::Zero();
  u[k == 0 ? 1 : 0] = S(1);
  if (along) u = *along;
  const S share = normal.dot(u);
  // what is zero here may not be so elsewhere; of plain numbers no bit changes
  if (!std::is_same_v<S, double> || value_of(share) != 0) u -= normal * share;
  const S length = u.norm();
  if (std::abs(value_of(length) - 1) > 1e-15 || !std::is_same_v<S, double>) u /= length;
  Vector3<S> v = normal.cross(u);
  if (!along && value_of(v[k == 2 ? 1 : 2]) < 0) v = -v;
  return {u, v};
}

/// What a name in a design file means: a body, and the elastic body of that name.
struct NamedBody {
  int body = ground;  ///< no_body: there is only the elastic one
  int elastic = -1;
};
using NamedBodies = std::map<std::string, NamedBody>;

// Private to flatten.cpp and its companions: flatten_elastic.cpp, flatten_items.cpp,
// flatten_leaves.cpp, flatten_shapes.cpp.

/// Evaluates one plan and appends what it holds to the flat design.
template <class S>
class Flattener {
 public:
  /// Placement of a plan within the file that uses it: `prefix` before names, `instance` for
  /// messages, and the bodies that are those of the outer file.
  struct Scope {
    Placement<S> placement;
    std::string prefix, instance;
    NamedBodies joined;
    std::shared_ptr<const ItemSource> part = nullptr;  ///< as of ItemSource
  };

  Flattener(const DesignPlan& plan, const DesignInput<S>& input, Scope scope, FlatDesign<S>& out,
            FaultList& faults)
      : plan_(plan), input_(input), scope_(std::move(scope)), out_(out), faults_(faults) {}

  /// Appends the items of the plan; returns the bodies by their names in it.
  NamedBodies run();

 private:
  bool take_numbers();
  void check_rules();
  std::string with_values(std::string text, const std::vector<double>& values) const;
  void collect_frames();
  /// `key`: where the item names it.
  Placement<S> frame(const std::string& name, const DesignItem& item, const char* key = "/frame");
  void add_body(const BodyItem& item);
  void add_rigid(const BodyItem& item, const Placement<S>& at, FlatBody<S>& body) const;
  bool is_rigid(const ElasticItem& item) const;  ///< of this choice
  void add_elastic(const BodyItem& item, const Placement<S>& at, NamedBody& named);
  void set_shape(const ElasticItem::Box& box, const BodyItem& item, const Placement<S>& at,
                 FlatElastic<S>& elastic) const;
  void set_shape(const ElasticItem::Plate& plate, const BodyItem& item, const Placement<S>& at,
                 FlatElastic<S>& elastic) const;
  void set_shape(const ElasticItem::Notch& notch, const BodyItem& item, const Placement<S>& at,
                 FlatElastic<S>& elastic) const;
  void set_shape(const ElasticItem::Imported& file, const BodyItem& item, const Placement<S>& at,
                 FlatElastic<S>& elastic) const;
  void set_axes(const Vector3<S>& x, Vector3<S> y, const std::string& pointer,
                FlatElastic<S>& elastic) const;
  ContourT<S> contour_of(const ElasticItem::Contour& contour) const;
  FlatInterface<S> interface_of(const BodyItem& item, const ElasticItem::Interface& interface,
                                const Placement<S>& at, const FlatElastic<S>& elastic) const;
  /// Interfaces that are parts of other bodies, which all exist.
  void tie_interfaces(const BodyItem& item);
  /// Holds a patch by a rigid frame: `carrier`, the frame of the body's own name where it holds
  /// nothing yet, or a new one. `local`: name of the elastic body in this file.
  int hold(int elastic, const std::string& local, FlatInterface<S> interface,
           std::optional<int> carrier = std::nullopt);
  /// Puts the edges of a leaf that are held by elastic bodies on their faces.
  void hold_edges(const LeafItem& item, FlatLeaf<S>& leaf);
  void add_part(const PartItem& item);
  void add_leaf(const LeafItem& item);
  void add_reinforced(const FlatLeaf<S>& leaf, const LeafItem& item);
  FlatBody<S> box_between(const FlatLeaf<S>& leaf, const Vector3<S>& from, const Vector3<S>& to,
                          const S& thickness) const;
  void add_joint(const JointItem& item);
  void add_spring(const SpringItem& item);
  void add_drive(const DriveItem& item);
  FlatLeaf<S> leaf_of(const LeafItem& item);
  FlatSize<S> size_along(const DesignSize& size, const std::string& pointer, const char* what);
  void add_held(const HeldDirection& held, const std::string& pointer, const Placement<S>& at,
                FlatBody<S>& body) const;
  bool is_fixed(const DesignNumber& n) const;
  Vector3<S> unit(const Vector3<S>& v, const std::string& pointer) const;

  /// Runs `action`; what it throws is taken in with the place of the item.
  template <class Action>
  bool attempt(const DesignItem& item, const Action& action) {
    return faults_.attempt([&] {
      try {
        action();
      } catch (const SpecError& error) {
        throw located(source_of(item), error);
      }
    });
  }
  template <class Item, class Add>
  void each(const std::vector<Item>& items, Add add);
  template <class Item, class Add>
  void each_copy(const Item& item, std::size_t index, Add add);

  S number(const DesignNumber& n) const;
  Vector3<S> vector(const DesignVector& v) const {
    return {number(v[0]), number(v[1]), number(v[2])};
  }
  S positive(const DesignNumber& n, const std::string& pointer, const char* what) const;
  void not_negative(const DesignNumber& n, const std::string& pointer, const char* what) const;
  long whole(const DesignNumber& n, const std::string& pointer, const char* what) const;
  Matrix3<S> inertia_of(const BodyItem& item) const;
  void check_mass(const BodyItem& item) const;  ///< throws SpecError for what no body has
  /// Throws SpecError for what a body of this part would lose to the one that it is joined to.
  void check_joined(const BodyItem& item, const NamedBody& to) const;
  std::string instance_name(const DesignItem& item, const std::string& text) const;
  NamedBody named(const DesignItem& item, const std::string& name, const std::string& key) const;
  int body(const DesignItem& item, const std::string& name, const char* key) const;
  ItemSource source_of(const DesignItem& item) const;

  const DesignPlan& plan_;
  const DesignInput<S>& input_;
  Scope scope_;
  FlatDesign<S>& out_;
  FaultList& faults_;
  std::vector<S> slots_;
  std::vector<std::pair<std::string, long>> copy_;  ///< indices of the copy at hand
  NamedBodies bodies_;
  struct Frame {
    const FrameItem* item;
    std::vector<S> slots;
    std::vector<std::pair<std::string, long>> copy;
  };
  std::map<std::string, Frame> frames_;
  std::vector<std::string> inside_;  ///< frames that are being resolved
};

}  // namespace flexopt
