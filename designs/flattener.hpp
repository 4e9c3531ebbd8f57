#pragma once
// Placement of the items of a design file: frames in frames, mirrored parts.
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/mechanism/mechanism.hpp"
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

// Private to flatten.cpp and its companions: flatten_items.cpp, flatten_leaves.cpp.

/// Evaluates one plan and appends what it holds to the flat design.
template <class S>
class Flattener {
 public:
  /// Placement of a plan within the file that uses it: `prefix` before names, `instance` for
  /// messages, and the bodies that are those of the outer file.
  struct Scope {
    Placement<S> placement;
    std::string prefix, instance;
    std::map<std::string, int> joined;
    std::shared_ptr<const ItemSource> part = nullptr;  ///< as of ItemSource
  };

  Flattener(const DesignPlan& plan, const DesignInput<S>& input, Scope scope, FlatDesign<S>& out,
            FaultList& faults)
      : plan_(plan), input_(input), scope_(std::move(scope)), out_(out), faults_(faults) {}

  /// Appends the items of the plan; returns the bodies by their names in it.
  std::map<std::string, int> run();

 private:
  bool take_numbers();
  void check_rules();
  std::string with_values(std::string text, const std::vector<double>& values) const;
  void collect_frames();
  /// `key`: where the item names it.
  Placement<S> frame(const std::string& name, const DesignItem& item, const char* key = "/frame");
  void add_body(const BodyItem& item);
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
  std::string instance_name(const DesignItem& item, const std::string& text) const;
  int body(const DesignItem& item, const std::string& name, const char* key) const;
  ItemSource source_of(const DesignItem& item) const;

  const DesignPlan& plan_;
  const DesignInput<S>& input_;
  Scope scope_;
  FlatDesign<S>& out_;
  FaultList& faults_;
  std::vector<S> slots_;
  std::vector<std::pair<std::string, long>> copy_;  ///< indices of the copy at hand
  std::map<std::string, int> bodies_;
  struct Frame {
    const FrameItem* item;
    std::vector<S> slots;
    std::vector<std::pair<std::string, long>> copy;
  };
  std::map<std::string, Frame> frames_;
  std::vector<std::string> inside_;  ///< frames that are being resolved
};

}  // namespace flexopt
