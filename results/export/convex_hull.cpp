#include <cstdio>
#include <memory>

#include "results/export/parts.hpp"

// This file is compiled alone because of the macros of qhull.
extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace flexopt {

namespace {

/// One run of Qhull, which keeps its own memory.
class Qhull {
 public:
  explicit Qhull(std::vector<double>& coordinates) {
    qh_zero(&state_, said_.get());
    const int points = static_cast<int>(coordinates.size() / 3);
    char command[] = "qhull Qt Pp";
    failed_ = qh_new_qhull(&state_, 3, points, coordinates.data(), False, command, nullptr,
                           said_.get()) != 0;
  }
  ~Qhull() {
    qh_freeqhull(&state_, !qh_ALL);
    int current = 0, total = 0;
    qh_memfreeshort(&state_, &current, &total);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;

  bool failed() const { return failed_; }

  std::vector<std::array<int, 3>> triangles() {
    std::vector<std::array<int, 3>> all;
    qhT* qh = &state_;
    facetT* facet = nullptr;
    FORALLfacets {
      std::array<int, 3> corners{};
      std::size_t count = 0;
      setT* vertices = qh_facet3vertex(qh, facet);
      vertexT *vertex = nullptr, **vertexp = nullptr;
      FOREACHvertex_(vertices) {
        if (count < 3) corners[count] = qh_pointid(qh, vertex->point);
        ++count;
      }
      qh_settempfree(qh, &vertices);
      if (count == 3) all.push_back(corners);
    }
    return all;
  }

 private:
  // Qhull has much to say of points in a plane, which the caller tells from the answer
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> said_{std::tmpfile(), &std::fclose};
  qhT state_{};
  bool failed_ = false;
};

}  // namespace

TriangleMesh convex_hull(const std::vector<Vector3d>& points) {
  TriangleMesh mesh;
  if (points.size() < 4) return mesh;
  std::vector<double> coordinates;
  for (const Vector3d& p : points) coordinates.insert(coordinates.end(), p.data(), p.data() + 3);
  Qhull hull(coordinates);
  if (hull.failed()) return mesh;
  std::vector<int> number(points.size(), -1);
  for (auto triangle : hull.triangles()) {
    for (int& corner : triangle) {
      int& own = number[corner];
      if (own < 0) {
        own = static_cast<int>(mesh.points.size());
        mesh.points.push_back(points[corner]);
      }
      corner = own;
    }
    mesh.triangles.push_back(triangle);
  }
  mesh.face_outwards();
  return mesh;
}

}  // namespace flexopt
