#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <numbers>

#include "core/mechanism/profile.hpp"
#include "results/export/exported.hpp"
#include "results/export/planar_contour.hpp"

namespace flexopt {

namespace {

using Point = Eigen::Vector2d;  ///< [mm]

/// Layers of R12 are words of capitals, digits, - and _.
std::string layer_name(std::size_t number, const std::string& name) {
  std::string layer = fmt::format("L{}_", number + 1);
  for (const char c : name) {
    if (c == '+')
      layer += 'P';
    else if (c == '-')
      layer += 'M';
    else if (std::isalnum(static_cast<unsigned char>(c)))
      layer += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    else
      layer += '_';
  }
  return layer.substr(0, 31);
}

std::string ascii(const std::string& text) {
  std::string plain;
  for (const char c : text) plain += c >= ' ' && c < 127 ? c : '_';
  return plain;
}

/// Entities by layers, then the whole file.
class Drawing {
 public:
  void layer(const std::string& name, int color) { layers_.push_back({name, color}); }

  void outline(const std::string& layer, const std::vector<Point>& points, bool closed = true) {
    write("0\nPOLYLINE\n8\n{}\n66\n1\n10\n0.0\n20\n0.0\n30\n0.0\n70\n{}\n", layer, closed ? 1 : 0);
    for (const Point& p : points) {
      write("0\nVERTEX\n8\n{}\n10\n{:.9g}\n20\n{:.9g}\n30\n0.0\n", layer, p[0], p[1]);
      box_.extend(p);
    }
    write("0\nSEQEND\n8\n{}\n", layer);
  }

  void point(const std::string& layer, const Point& at) {
    write("0\nPOINT\n8\n{}\n10\n{:.9g}\n20\n{:.9g}\n30\n0.0\n", layer, at[0], at[1]);
    box_.extend(at);
  }

  void text(const std::string& layer, const Point& at, double height, const std::string& words) {
    write("0\nTEXT\n8\n{}\n10\n{:.9g}\n20\n{:.9g}\n30\n0.0\n40\n{:.9g}\n1\n{}\n", layer, at[0],
          at[1], height, ascii(words));
  }

  std::string file() const {
    std::string all = fmt::format(
        "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n4\n"
        "9\n$EXTMIN\n10\n{:.9g}\n20\n{:.9g}\n30\n0.0\n9\n$EXTMAX\n10\n{:.9g}\n20\n{:.9g}\n30\n0.0\n"
        "0\nENDSEC\n0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLTYPE\n70\n1\n0\nLTYPE\n2\nCONTINUOUS\n70\n"
        "64\n3\nSolid\n72\n65\n73\n0\n40\n0.0\n0\nENDTAB\n0\nTABLE\n2\nLAYER\n70\n{}\n",
        box_.min()[0], box_.min()[1], box_.max()[0], box_.max()[1], layers_.size());
    for (const auto& [name, color] : layers_)
      fmt::format_to(std::back_inserter(all), "0\nLAYER\n2\n{}\n70\n64\n62\n{}\n6\nCONTINUOUS\n",
                     name, color);
    return all + "0\nENDTAB\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n" + entities_ +
           "0\nENDSEC\n0\nEOF\n";
  }

 private:
  template <class... T>
  void write(fmt::format_string<T...> format, T&&... values) {
    fmt::format_to(std::back_inserter(entities_), format, std::forward<T>(values)...);
  }

  std::vector<std::pair<std::string, int>> layers_;
  std::string entities_;
  Eigen::AlignedBox2d box_;  ///< of all outlines
};

constexpr int black = 7, red = 1, blue = 5;

/// The direction that all leaves are wide along, if there is one.
std::optional<Vector3d> common_width(const Mechanism& mechanism) {
  std::optional<Vector3d> along;
  for (const LeafSpring& leaf : mechanism.leaves) {
    if (leaf.section == Section::circular) return std::nullopt;
    const Vector3d own = leaf.axes.col(1);
    if (along && own.cross(*along).norm() > 1e-9) return std::nullopt;
    if (!along) along = own;
  }
  if (!along) return along;
  int largest = 0;  // to the positive side of an axis, so that drawings are seen from there
  along->cwiseAbs().maxCoeff(&largest);
  if ((*along)[largest] < 0) *along *= -1;
  return along;
}

/// Right-handed with the direction; of a global axis the two that follow it.
std::array<Vector3d, 2> plane_across(const Vector3d& normal) {
  int largest = 0;
  normal.cwiseAbs().maxCoeff(&largest);
  const Vector3d helper = Vector3d::Unit((largest + 1) % 3);
  const Vector3d u = (helper - normal * normal.dot(helper)).normalized();
  return {u, normal.cross(u)};
}

/// Whether two leaves are cut alike: the same outline, fold, thickness and material.
bool cut_alike(const LeafSpring& a, const LeafSpring& b) {
  const auto near = [](double x, double y) { return std::abs(x - y) <= 1e-9 * std::abs(y); };
  const auto same = [&](const std::vector<double>& x, const std::vector<double>& y) {
    return std::ranges::equal(x, y, near);
  };
  return a.section == b.section && near(a.length, b.length) && near(a.width, b.width) &&
         near(a.thickness, b.thickness) && same(a.width_profile, b.width_profile) &&
         same(a.thickness_profile, b.thickness_profile) &&
         a.fold.has_value() == b.fold.has_value() &&
         (!a.fold || (near(a.fold->place, b.fold->place) && near(a.fold->angle, b.fold->angle) &&
                      near(a.fold->radius, b.fold->radius))) &&
         a.material.name == b.material.name &&
         near(a.material.youngs_modulus, b.material.youngs_modulus);
}

/// A plane of the mechanism as the drawing shows it.
struct Plane {
  std::array<Vector3d, 2> axes;
  Point operator()(const Vector3d& place) const {
    return 1e3 * Point(place.dot(axes[0]), place.dot(axes[1]));
  }
};

Outline hull_of(const TriangleMesh& mesh, const BodyPose& pose, const Plane& plane) {
  std::vector<Point> points;
  for (const Vector3d& p : mesh.points) points.push_back(plane(pose(p)));
  std::ranges::sort(points, [](const Point& a, const Point& b) {
    return std::pair(a[0], a[1]) < std::pair(b[0], b[1]);
  });
  Outline hull;  // the chain below, then the one above (Andrew)
  for (int chain = 0; chain < 2; ++chain) {
    const std::size_t first = hull.size();
    for (const Point& p : points) {
      const auto turns_right = [&] {
        const Point u = hull.back() - hull[hull.size() - 2], v = p - hull.back();
        return u[0] * v[1] - u[1] * v[0] <= 0;
      };
      while (hull.size() > first + 1 && turns_right()) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::ranges::reverse(points);
  }
  return hull;
}

/// Outline of a leaf; held edges reach a micrometre into their bodies, so that both are joined.
Outline leaf_outline(const Exported& exported, const PathPoint* point, std::size_t i,
                     const Plane& plane) {
  constexpr double into = 1e-6;
  const LeafSpring& leaf = exported.mechanism.leaves[i];
  const LeafSection section{.length = leaf.length,
                            .half = 0.5 * leaf.thickness,
                            .radius = exported.request.stress.fillet.value_or(0),
                            .free_tip = leaf.tip == free_edge};
  Outline outline;
  if (!point && !leaf.curve && !leaf.fold && !leaf.has_profile() && section.fits()) {
    for (const OutlineEdge& e : section.outline())
      for (int k = 0; k < (e.by ? 16 : 1); ++k) {
        Eigen::Vector2d p = e.from;
        if (e.by) {  // a quarter circle about the place where both tangents' normals meet
          const Eigen::Vector2d middle = 0.5 * (e.from + e.to), out = (middle - *e.by).normalized(),
                                centre = middle + out * (middle - e.from).norm();
          const double turn = 0.5 * std::numbers::pi * k / 16;
          p = centre + std::cos(turn) * (e.from - centre) + std::sin(turn) * (e.to - centre);
        }
        if (p[0] == 0) p[0] = -into;
        if (p[0] == leaf.length && !section.free_tip) p[0] += into;
        outline.push_back(plane(leaf.origin + p[0] * leaf.axes.col(0) + p[1] * leaf.axes.col(2)));
      }
    return outline;
  }
  for (const Vector3d& p : drawn_surface(exported.mechanism, point, i).contour())
    outline.push_back(plane(p));
  const std::size_t n = outline.size(), half = n / 2;
  const Point base = 1e3 * into * (outline[0] - outline[1]).normalized(),
              tip = 1e3 * into * (outline[half - 1] - outline[half - 2]).normalized();
  for (const std::size_t k : {std::size_t(0), n - 1}) outline[k] += base;
  if (!section.free_tip)
    for (const std::size_t k : {half - 1, half}) outline[k] += tip;
  return outline;
}

/// Why the leaves are not all cut through one plate across their width; empty where they are.
std::string why_not_one_plate(const Mechanism& mechanism, const Vector3d& along) {
  if (mechanism.leaves.empty()) return "there are no leaves";
  const LeafSpring& first = mechanism.leaves.front();
  for (const LeafSpring& leaf : mechanism.leaves) {
    if (!leaf.width_profile.empty()) return "the width of leaf " + leaf.name + " varies";
    if (std::abs(leaf.width - first.width) > 1e-6 * first.width ||
        std::abs((leaf.origin - first.origin).dot(along)) > 1e-6 * first.width)
      return "leaves " + first.name + " and " + leaf.name + " are not in one plate";
  }
  return {};
}

ContourAnswer contour_of(const Exported& exported, const PathPoint* point, const Vector3d& along,
                         const Plane& plane, double beside) {
  const Mechanism& mechanism = exported.mechanism;
  if (!mechanism.elastic_bodies.empty())
    return {{}, "elastic body " + mechanism.elastic_bodies.front().name + " has no contour"};
  if (std::string why = why_not_one_plate(mechanism, along); !why.empty()) return {{}, why};
  if (const auto names = joints_and_springs(mechanism); !names.empty())
    return {{}, fmt::format("{} is no part of one plate", fmt::join(names, ", "))};
  const double fillet = exported.request.stress.fillet.value_or(0);
  std::vector<PlanarPart> parts(1);
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i)
    parts[0].shapes.push_back(leaf_outline(exported, point, i, plane));
  for (const BodyForm& form : body_forms(mechanism, std::max(fillet, 2e-3 * beside))) {
    if (!form.faults.empty()) return {{}, form.faults.front()};
    const BodyPose pose = form.body == ground ? BodyPose{} : body_pose(mechanism, point, form.body);
    PlanarPart& part = parts.emplace_back();
    for (const auto& [from, to] :
         {std::pair(&form.blocks, &part.shapes), std::pair(&form.ribs, &part.cut),
          std::pair(&form.rooms, &part.rooms)})
      for (const TriangleMesh& mesh : *from) to->push_back(hull_of(mesh, pose, plane));
  }
  return planar_contour(parts, beside);
}

void draw(const PlanarContour& contour, double beside, Drawing& drawing) {
  drawing.layer("CONTOUR", black);
  drawing.layer("HOLES", red);
  drawing.layer("START", blue);
  drawing.layer("TEXT", blue);
  drawing.outline("CONTOUR", contour.outer);
  for (const Outline& hole : contour.holes) drawing.outline("HOLES", hole);
  for (const Point& start : contour.starts) drawing.point("START", start);
  for (std::size_t k = 0; k < contour.holes.size(); ++k)
    drawing.text("TEXT", contour.starts[k + 1] + Point(1, 1), 2,
                 fmt::format("room of {:.3g} mm diameter", 2 * contour.clear[k]));
  const Point below = contour.starts.front() - Point(0, 4);
  drawing.text("TEXT", below, 2,
               beside > 0
                   ? fmt::format("path of the wire, {:.6g} mm beside the contour", 1e3 * beside)
                   : std::string("contour of the part"));
}

}  // namespace

std::optional<std::string> dxf_leaves(const Mechanism& mechanism) {
  Drawing drawing;
  drawing.layer("TEXT", blue);
  drawing.layer("FOLDS", red);
  double below = 0;
  bool any = false;
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    const LeafSpring& leaf = mechanism.leaves[i];
    const auto alike = [&](const LeafSpring& other) { return cut_alike(leaf, other); };
    const auto before = mechanism.leaves.begin() + static_cast<std::ptrdiff_t>(i);
    if (leaf.section == Section::circular || std::any_of(mechanism.leaves.begin(), before, alike))
      continue;
    any = true;
    const auto count = std::count_if(before, mechanism.leaves.end(), alike);
    const std::string layer = layer_name(i, leaf.name);
    drawing.layer(layer, black);
    const double length = 1e3 * leaf.length;
    const double widest = 1e3 * leaf.width * profile_range(leaf.width_profile).largest;
    const double middle = below - 0.5 * widest;
    const auto half = [&](double s) {
      return 0.5e3 * leaf.width * profile_at(leaf.width_profile, s);
    };
    const int steps = leaf.width_profile.size() > 2 ? 200 : 1;  // two numbers: straight edges
    std::vector<Point> outline;
    for (int k = 0; k <= steps; ++k)
      outline.push_back({length * k / steps, middle - half(static_cast<double>(k) / steps)});
    for (int k = steps; k >= 0; --k)
      outline.push_back({length * k / steps, middle + half(static_cast<double>(k) / steps)});
    drawing.outline(layer, outline);
    if (leaf.fold) {
      const double x = length * leaf.fold->place, h = half(leaf.fold->place);
      drawing.outline("FOLDS", {{x, middle - h}, {x, middle + h}}, false);
    }
    const ProfileRange thick = profile_range(leaf.thickness_profile);
    std::string words = fmt::format("{} x  {}  t = {:.6g} mm", count, leaf.name,
                                    1e3 * leaf.thickness * thick.smallest);
    if (thick.largest > thick.smallest)
      words += fmt::format(" to {:.6g} mm", 1e3 * leaf.thickness * thick.largest);
    drawing.text("TEXT", {length + 0.05 * widest + 2, middle}, std::max(1.0, 0.08 * widest), words);
    below -= widest + std::max(2.0, 0.1 * widest);
  }
  if (!any) return std::nullopt;
  return drawing.file();
}

DxfContour dxf_contour(const Exported& exported, const PathPoint* point, double kerf) {
  const Mechanism& mechanism = exported.mechanism;
  const std::optional<Vector3d> along = common_width(mechanism);
  if (!along) return {{}, "the leaves have no common direction of width"};
  const Plane plane{plane_across(*along)};
  Drawing drawing;
  ContourAnswer answer = contour_of(exported, point, *along, plane, 0.5e3 * kerf);
  if (answer.contour) {
    draw(*answer.contour, 0.5 * kerf, drawing);
    return {drawing.file(), {}};
  }
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    const std::string layer = layer_name(i, mechanism.leaves[i].name);
    drawing.layer(layer, black);
    std::vector<Point> outline;
    for (const Vector3d& p : drawn_surface(mechanism, point, i).contour())
      outline.push_back(plane(p));
    drawing.outline(layer, outline);
  }
  return {drawing.file(), answer.reason};
}

}  // namespace flexopt
