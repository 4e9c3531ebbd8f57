#pragma once
// "elastic" of a body of a design file, as read.
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "designs/design_plan.hpp"
#include "designs/solids/import_matrices.hpp"
#include "designs/solids/import_mesh.hpp"
#include "designs/solids/solid_shape.hpp"

namespace flexopt {

using DesignPoint = std::array<DesignNumber, 2>;

struct ElasticItem {
  struct Box {
    DesignVector lengths, center;  ///< the centre relative to the place of the body
  };
  struct Corner {
    DesignPoint at;
    std::optional<DesignNumber> fillet;
    std::optional<DesignPoint> through;
  };
  using Contour = std::vector<Corner>;  ///< of two corners: a rectangle
  struct Hole {
    DesignPoint at;
    DesignNumber radius;
  };
  struct Plate {
    Contour outline;
    std::vector<Contour> windows;
    std::vector<Hole> holes;
    DesignNumber thickness;
    DesignVector normal, at;
    std::optional<DesignVector> along;
  };
  struct Notch {
    NotchContour contour = NotchContour::circular;
    DesignNumber half_length, depth, thickness, width, ends;
    DesignNumber fillet, exponent{2, nullptr};
    DesignVector axis, across;
    bool two_axes = false;
  };

  /// A mesh or matrices of another program.
  struct Imported {
    std::string file;
    double unit = 1;  ///< of a mesh [m]
    std::shared_ptr<const ImportedMesh> mesh;
    std::shared_ptr<const ImportedBody> body;  ///< or this
    DesignVector axis, across;                 ///< own x and y
  };

  struct Interface {
    std::string key;   ///< behind the pointer of "elastic"
    std::string name;  ///< as of other items, with formulas in braces
    std::string body;  ///< what carries it; empty: a body of its own
    std::optional<DesignVector> at, normal;
    std::optional<DesignVector> along;  ///< direction of the first size
    std::optional<DesignPoint> size;
  };

  std::variant<Box, Plate, Notch, Imported> shape;
  std::optional<Material> material;
  std::vector<Interface> interfaces;    ///< of a notch: base and tip, without places
  std::string payload;                  ///< empty: not said
  bool rigid = false;                   ///< it weighs as it would and does not bend
  std::optional<ElasticDegree> degree;  ///< nothing: by the number of interfaces
  DesignNumber size, root;              ///< of its elements
  MeshDensity density;                  ///< without these two

  bool is_imported() const { return std::holds_alternative<Imported>(shape); }
  bool is_notch() const { return std::holds_alternative<Notch>(shape); }
  /// Whether it moves by bending, so that no choice makes it rigid: a notch, or a part with
  /// several.
  bool is_hinge() const { return is_notch() || degree == ElasticDegree::quartic; }
  /// Whether a rigid frame has its name: unless other bodies have all of its interfaces.
  bool has_frame() const {
    return interfaces.empty() || std::ranges::any_of(interfaces, [](const Interface& interface) {
             return interface.body.empty();
           });
  }
};

}  // namespace flexopt
