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

struct Solid {
  std::string name;
  std::variant<Sheet, Cylinder, Pipe, Prism, Polyhedron> shape;
};

struct Document {
  std::string name, origin;  ///< origin: the program that wrote it
  std::vector<Solid> solids;
};

}  // namespace flexopt::step

/// Text of a STEP file (AP214), the same at any time. Throws std::runtime_error where Open CASCADE
/// cannot make it.
extern "C" void flexopt_write_step(const flexopt::step::Document& document, std::string& text);
