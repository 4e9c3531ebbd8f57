#include "designs/solids/triangles.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <queue>

namespace flexopt {

namespace {

using Place = Point2<double>;
using Grid = std::array<std::int64_t, 2>;

double cross_at(const Place& o, const Place& a, const Place& b) {
  return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
}

/// The least sine of an angle of a triangle; not positive where it is turned over.
double least_sine(const Place& a, const Place& b, const Place& c) {
  const double area = cross_at(a, b, c);
  const double l[] = {(b - c).norm(), (c - a).norm(), (a - b).norm()};
  return area / std::max({l[0] * l[1], l[1] * l[2], l[2] * l[0]});
}

/// Delaunay triangulation in a square that holds all points. Points are rounded to a grid, on which
/// determinants are exact.
class Delaunay {
 public:
  struct Triangle {
    std::array<int, 3> point, next;  ///< next[i]: the triangle beyond the side that point i faces
    std::array<bool, 3> held;        ///< that side is an edge that stays
    bool alive, inside;
  };

  /// The square about these points is 4 times as large as they are.
  explicit Delaunay(const std::vector<Place>& points) {
    low_ = high_ = points[0];
    for (const Place& p : points) {
      low_ = low_.cwiseMin(p);
      high_ = high_.cwiseMax(p);
    }
    scale_ = double(1 << 26) / (high_ - low_).maxCoeff();
    const std::int64_t far = std::int64_t(1) << 28;
    grid_ = {{-far, -far}, {far, -far}, {far, far}, {-far, far}};
    triangles_ = {{{0, 1, 2}, {-1, 1, -1}, {}, true, false},
                  {{0, 2, 3}, {-1, -1, 0}, {}, true, false}};
    of_point_ = {0, 0, 0, 1};
  }

  const std::vector<Triangle>& triangles() const { return triangles_; }

  /// Adds a point; false where it is on another, or where an edge that stays hides it. With
  /// `keeps_clear`, also where it lies within the circle over such an edge. `start`: a triangle to
  /// search from, or −1.
  bool insert(const Place& place, int start, bool keeps_clear) {
    const Place on = (place - (low_ + high_) / 2) * scale_;
    const Grid p = {std::llround(on[0]), std::llround(on[1])};
    const int first = find(p, start < 0 ? of_point_.back() : start);
    if (first < 0) return false;
    for (const int v : triangles_[first].point)
      if (grid_[v] == p) return false;
    collect(p, first);
    if (keeps_clear)
      for (const auto& [t, i] : rim_)
        if (triangles_[t].held[i] && is_close(t, i, p)) {
          for (const int k : cavity_) triangles_[k].alive = true;
          return false;
        }
    fill(p, triangles_[first].inside);
    return true;
  }

  /// The triangle to the left of a → b, and the corner of it that faces the edge.
  std::pair<int, int> beside(int a, int b) const {
    a += 4, b += 4;
    const int first = of_point_[a];
    for (int t = first, turn = 0; t >= 0 && turn < 2 * static_cast<int>(grid_.size()); ++turn) {
      const auto& [point, next, held, alive, inside] = triangles_[t];
      const int i = corner(t, a);
      if (point[(i + 1) % 3] == b) return {t, (i + 2) % 3};
      t = next[(i + 1) % 3];
      if (t == first) break;
    }
    return {-1, -1};
  }

  void hold(int t, int i) { triangles_[t].held[i] = true; }
  /// Marks as inside what an odd number of the boundary edges, each from its left and right
  /// triangle, separates from the square.
  void mark_inside(const std::vector<std::array<int, 2>>& boundary) {
    std::vector<int> state(triangles_.size(), -1), open = {of_point_[0]};
    state[open[0]] = 0;
    while (!open.empty()) {
      const int t = open.back();
      open.pop_back();
      for (int i = 0; i < 3; ++i) {
        const int n = triangles_[t].next[i];
        if (n < 0 || state[n] >= 0) continue;
        const std::array<int, 2> sides = {std::min(t, n), std::max(t, n)};
        const bool crossed =
            triangles_[t].held[i] && std::binary_search(boundary.begin(), boundary.end(), sides);
        state[n] = state[t] ^ int(crossed);
        open.push_back(n);
      }
    }
    for (std::size_t t = 0; t < state.size(); ++t) triangles_[t].inside = state[t] == 1;
  }

 private:
  static __int128 wide(std::int64_t x) { return x; }

  /// Twice the area of three points of the grid.
  std::int64_t turn(const Grid& a, const Grid& b, const Grid& c) const {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  }
  bool in_circle(const Triangle& t, const Grid& p) const {
    std::int64_t x[3], y[3];
    for (int i = 0; i < 3; ++i) {
      x[i] = grid_[t.point[i]][0] - p[0];
      y[i] = grid_[t.point[i]][1] - p[1];
    }
    __int128 sum = 0;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      sum += wide(x[i] * x[i] + y[i] * y[i]) * wide(x[j] * y[k] - x[k] * y[j]);
    }
    return sum > 0;
  }
  /// Whether the angle over side i of t is obtuse at p.
  bool is_close(int t, int i, const Grid& p) const {
    const Grid &a = grid_[triangles_[t].point[(i + 1) % 3]],
               &b = grid_[triangles_[t].point[(i + 2) % 3]];
    return (a[0] - p[0]) * (b[0] - p[0]) + (a[1] - p[1]) * (b[1] - p[1]) < 0;
  }
  int corner(int t, int point) const {
    const auto& points = triangles_[t].point;
    return points[0] == point ? 0 : points[1] == point ? 1 : 2;
  }

  /// The triangle that holds p, from t on through sides that are not held; −1: there is none.
  int find(const Grid& p, int t) const {
    for (std::size_t step = 0; step <= triangles_.size(); ++step) {
      const auto& points = triangles_[t].point;
      int out = -1;
      for (int k = 0; k < 3 && out < 0; ++k) {
        const int i = static_cast<int>((step + k) % 3);
        if (turn(grid_[points[(i + 1) % 3]], grid_[points[(i + 2) % 3]], p) < 0) out = i;
      }
      if (out < 0) return t;
      if (triangles_[t].held[out] || triangles_[t].next[out] < 0) return -1;
      t = triangles_[t].next[out];
    }
    return -1;
  }

  /// Takes the triangles away whose circles hold p, up to edges that stay.
  void collect(const Grid& p, int first) {
    cavity_ = {first};
    rim_.clear();
    triangles_[first].alive = false;
    for (std::size_t k = 0; k < cavity_.size(); ++k) {
      const int t = cavity_[k];
      for (int i = 0; i < 3; ++i) {
        const int n = triangles_[t].next[i];
        if (n >= 0 && !triangles_[n].alive) continue;
        if (n >= 0 && !triangles_[t].held[i] && in_circle(triangles_[n], p)) {
          triangles_[n].alive = false;
          cavity_.push_back(n);
        }
      }
    }
    for (const int t : cavity_)
      for (int i = 0; i < 3; ++i) {
        const int n = triangles_[t].next[i];
        if (n < 0 || triangles_[n].alive) rim_.push_back({t, i});
      }
  }

  /// Joins a new point with the rim of what was taken away.
  void fill(const Grid& p, bool inside) {
    const int point = static_cast<int>(grid_.size());
    grid_.push_back(p);
    of_point_.push_back(-1);
    const int begin = static_cast<int>(triangles_.size());
    for (const auto& [t, i] : rim_) {
      const Triangle old = triangles_[t];
      const int a = old.point[(i + 1) % 3], b = old.point[(i + 2) % 3], n = old.next[i];
      const int made = static_cast<int>(triangles_.size());
      triangles_.push_back({{a, b, point}, {-1, -1, n}, {false, false, old.held[i]}, true, inside});
      if (n >= 0)
        for (int k = 0; k < 3; ++k)
          if (triangles_[n].next[k] == t) triangles_[n].next[k] = made;
      of_point_[a] = of_point_[point] = made;
    }
    // a triangle (a, b, p) follows the one that ends at a
    for (int t = begin; t < static_cast<int>(triangles_.size()); ++t) {
      const int f = of_point_[triangles_[t].point[1]];
      triangles_[t].next[0] = f;
      triangles_[f].next[1] = t;
    }
  }

  Place low_, high_;
  double scale_;
  std::vector<Grid> grid_;  ///< of the square, then of the points
  std::vector<Triangle> triangles_;
  std::vector<int> of_point_;  ///< a triangle at each point
  std::vector<int> cavity_;
  std::vector<std::array<int, 2>> rim_;  ///< triangles taken away, with their sides that are left
};

/// Triangles of the points in which every edge is one; edges that are none are divided.
Answer<Delaunay> with_all_edges(PlaneMesh& mesh, const std::function<Place(int, double)>& at) {
  for (int pass = 0; pass < 12; ++pass) {
    Delaunay all(mesh.points);
    for (const Place& p : mesh.points)
      if (!all.insert(p, -1, false))
        return Because("two of its points are too close to each other");
    std::vector<PlaneEdge> edges;
    for (const PlaneEdge& edge : mesh.edges) {
      const auto [a, b] = edge.points;
      if (all.beside(a, b).first >= 0) {
        edges.push_back(edge);
        continue;
      }
      const double middle = (edge.u[0] + edge.u[1]) / 2;
      const int point = static_cast<int>(mesh.points.size());
      mesh.points.push_back(at(edge.piece, middle));
      edges.push_back({{a, point}, edge.piece, {edge.u[0], middle}, edge.is_boundary});
      edges.push_back({{point, b}, edge.piece, {middle, edge.u[1]}, edge.is_boundary});
    }
    const bool complete = edges.size() == mesh.edges.size();
    mesh.edges = std::move(edges);
    if (!complete) continue;
    std::vector<std::array<int, 2>> boundary;
    for (const PlaneEdge& edge : mesh.edges) {
      const auto [left, i] = all.beside(edge.points[0], edge.points[1]);
      const auto [right, j] = all.beside(edge.points[1], edge.points[0]);
      all.hold(left, i);
      all.hold(right, j);
      if (edge.is_boundary) boundary.push_back({std::min(left, right), std::max(left, right)});
    }
    std::sort(boundary.begin(), boundary.end());
    all.mark_inside(boundary);
    return all;
  }
  return Because("its walls are too thin for the elements");
}

/// Adds circumcentres of triangles that are too large or too flat, the worst first.
void refine(Delaunay& all, PlaneMesh& mesh, const std::function<double(const Place&)>& size) {
  using Wanted = std::pair<double, int>;
  std::priority_queue<Wanted> queue;
  std::vector<Place> centers;
  int seen = 0;
  const auto take = [&] {
    centers.resize(all.triangles().size());
    for (; seen < static_cast<int>(all.triangles().size()); ++seen) {
      const auto& triangle = all.triangles()[seen];
      if (!triangle.alive || !triangle.inside) continue;
      const Place &a = mesh.points[triangle.point[0] - 4], &b = mesh.points[triangle.point[1] - 4],
                  &c = mesh.points[triangle.point[2] - 4];
      const double area = cross_at(a, b, c);
      if (!(area > 0)) continue;
      const Place u = b - a, v = c - a;
      const double uu = u.squaredNorm(), vv = v.squaredNorm();
      const Place to(v[1] * uu - u[1] * vv, u[0] * vv - v[0] * uu);
      centers[seen] = a + to / (2 * area);
      // radius over that of an equilateral triangle
      const double excess = to.norm() / (2 * area) * std::sqrt(3.0) / size((a + b + c) / 3);
      const bool is_flat = least_sine(a, b, c) < 0.42;  // 25 degrees
      if (excess > (is_flat ? 0.8 : 1.15)) queue.push({excess, seen});
    }
  };
  for (take(); !queue.empty(); take()) {
    const int t = queue.top().second;
    queue.pop();
    if (!all.triangles()[t].alive || !all.insert(centers[t], t, true)) continue;
    mesh.points.push_back(centers[t]);
  }
}

/// Shifts of inner points and swaps of sides, each where it raises the least angle.
class Smoothing {
 public:
  explicit Smoothing(PlaneMesh& mesh) : mesh_(mesh), fixed_(mesh.points.size(), false) {
    for (const PlaneEdge& edge : mesh.edges) {
      held_.push_back(
          {std::min(edge.points[0], edge.points[1]), std::max(edge.points[0], edge.points[1])});
      fixed_[edge.points[0]] = fixed_[edge.points[1]] = true;
    }
    std::sort(held_.begin(), held_.end());
  }

  void run() {
    for (int sweep = 0; sweep < 12; ++sweep) {
      swap_sides();
      shift_points();
    }
  }

 private:
  double worst(const std::array<int, 3>& t) const {
    return least_sine(mesh_.points[t[0]], mesh_.points[t[1]], mesh_.points[t[2]]);
  }

  void swap_sides() {
    struct Side {
      std::array<int, 2> ends;
      int triangle, across;
    };
    std::vector<Side> sides;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (int i = 0; i < 3; ++i) {
        const int a = mesh_.triangles[t][i], b = mesh_.triangles[t][(i + 1) % 3];
        sides.push_back({{std::min(a, b), std::max(a, b)},
                         static_cast<int>(t),
                         mesh_.triangles[t][(i + 2) % 3]});
      }
    std::stable_sort(sides.begin(), sides.end(),
                     [](const Side& a, const Side& b) { return a.ends < b.ends; });
    std::vector<bool> changed(mesh_.triangles.size(), false);
    for (std::size_t k = 0; k + 1 < sides.size(); ++k) {
      const auto& [ends, s, p] = sides[k];
      const auto& [ends_of_next, t, q] = sides[k + 1];
      if (ends != ends_of_next || changed[s] || changed[t] ||
          std::binary_search(held_.begin(), held_.end(), ends))
        continue;
      const auto [a, b] = ends;
      // a → b runs along one of the two
      const int left = cross_at(mesh_.points[a], mesh_.points[b], mesh_.points[p]) > 0 ? p : q;
      const int right = left == p ? q : p;
      const std::array<int, 3> one = {left, right, b}, two = {right, left, a};
      const double now = std::min(worst(mesh_.triangles[s]), worst(mesh_.triangles[t]));
      if (std::min(worst(one), worst(two)) <= now * (1 + 1e-9)) continue;
      mesh_.triangles[s] = one;
      mesh_.triangles[t] = two;
      changed[s] = changed[t] = true;
    }
  }

  void shift_points() {
    std::vector<std::vector<int>> around(mesh_.points.size());
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (const int p : mesh_.triangles[t]) around[p].push_back(static_cast<int>(t));
    for (std::size_t p = 0; p < mesh_.points.size(); ++p) {
      if (fixed_[p] || around[p].empty()) continue;
      Place middle(0, 0);
      for (const int t : around[p])
        for (const int q : mesh_.triangles[t])
          if (q != static_cast<int>(p)) middle += mesh_.points[q];
      middle /= 2.0 * static_cast<double>(around[p].size());
      const auto least = [&] {
        double sine = 1;
        for (const int t : around[p]) sine = std::min(sine, worst(mesh_.triangles[t]));
        return sine;
      };
      const Place before = mesh_.points[p], way = middle - before;
      double best = least(), share = 0;
      for (const double s : {1.0, 0.5, 0.2}) {
        mesh_.points[p] = before + s * way;
        if (const double sine = least(); sine > best) best = sine, share = s;
      }
      mesh_.points[p] = before + share * way;
    }
  }

  PlaneMesh& mesh_;
  std::vector<bool> fixed_;
  std::vector<std::array<int, 2>> held_;
};

}  // namespace

Check triangulate(PlaneMesh& mesh, const std::function<Place(int, double)>& at,
                  const std::function<double(const Place&)>& size) {
  Answer<Delaunay> all = with_all_edges(mesh, at);
  if (!all) return Because(all.error());
  refine(*all, mesh, size);
  mesh.triangles.clear();
  for (const auto& t : all->triangles())
    if (t.alive && t.inside)
      mesh.triangles.push_back({t.point[0] - 4, t.point[1] - 4, t.point[2] - 4});
  Smoothing(mesh).run();
  return {};
}

}  // namespace flexopt
