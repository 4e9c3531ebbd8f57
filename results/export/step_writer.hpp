#pragma once
// Solids in plain numbers, and what writes them as STEP: a library of its own, flexopt_step.so,
// because Open CASCADE takes longer to load than many a job to run.
#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace flexopt::step {

using Point = std::array<double, 3>;  ///< [mm]; a direction has length 1

/// Body between two faces that are splines through a grid of points, those along first.
struct Sheet {
  int along = 0, across = 0;
  std::vector<double> places;  ///< places of the points along: part of the length
  std::vector<int> folds;      ///< points along at which the faces have an edge
  std::vector<Point> top, bottom;
};

struct Cylinder {
  Point base, direction;
  double radius = 0, length = 0;
};

/// Body through circles, one after the other.
struct Pipe {
  struct Circle {
    Point centre, normal, side;
    double radius = 0;
  };
  std::vector<Circle> circles;
};

/// A plane outline of lines and arcs, one after the other, moved over a way.
struct Prism {
  struct Edge {
    Point from, to;
    std::optional<Point> by;  ///< a point between the ends of an arc
  };
  std::vector<Edge> outline;
  Point over;
};

/// Triangles, counter-clockwise seen from outside; those in one plane become one face.
struct Polyhedron {
  std::vector<Point> points;
  std::vector<std::array<int, 3>> triangles;
};

using Shape = std::variant<Sheet, Cylinder, Pipe, Prism, Polyhedron>;

/// One product: shapes ∪ (cut shapes − rooms).
struct Product {
  std::string name;
  std::array<double, 3> colour{};  ///< red, green, blue in [0, 1]
  std::vector<Shape> shapes, cut;
  std::vector<Polyhedron> rooms;
  int solids = 1;                ///< solids that it must become; 0: one or more
  std::optional<double> volume;  ///< that it must have within 0.1 % [mm³]
};

struct Document {
  std::string name, origin;  ///< origin: the program that wrote it
  std::vector<Product> products;
  bool monolithic = false;  ///< all products are joined into one solid
};

}  // namespace flexopt::step

/// Text of a STEP file (AP214), the same at any time. Throws std::runtime_error where Open CASCADE
/// cannot make it, and where a solid is not closed or valid, or has not the volume or the number of
/// solids that it must have.
extern "C" void flexopt_write_step(const flexopt::step::Document& document, std::string& text);
