#include <fmt/format.h>

#include <cctype>
#include <iterator>

#include "core/mechanism/profile.hpp"
#include "results/export/exported.hpp"

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

}  // namespace

std::optional<std::string> dxf_leaves(const Mechanism& mechanism) {
  Drawing drawing;
  drawing.layer("TEXT", blue);
  drawing.layer("FOLDS", red);
  double below = 0;
  bool any = false;
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    const LeafSpring& leaf = mechanism.leaves[i];
    if (leaf.section == Section::circular) continue;
    any = true;
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
    std::string words =
        fmt::format("{}  t = {:.6g} mm", leaf.name, 1e3 * leaf.thickness * thick.smallest);
    if (thick.largest > thick.smallest)
      words += fmt::format(" to {:.6g} mm", 1e3 * leaf.thickness * thick.largest);
    drawing.text("TEXT", {length + 0.05 * widest + 2, middle}, std::max(1.0, 0.08 * widest), words);
    below -= widest + std::max(2.0, 0.1 * widest);
  }
  if (!any) return std::nullopt;
  return drawing.file();
}

std::optional<std::string> dxf_contour(const Mechanism& mechanism, const PathPoint* point) {
  const std::optional<Vector3d> along = common_width(mechanism);
  if (!along) return std::nullopt;
  const std::array<Vector3d, 2> plane = plane_across(*along);
  Drawing drawing;
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    const std::string layer = layer_name(i, mechanism.leaves[i].name);
    drawing.layer(layer, black);
    std::vector<Point> outline;
    for (const Vector3d& p : drawn_surface(mechanism, point, i).contour()) {
      const Vector3d place = 1e3 * p;
      outline.push_back({place.dot(plane[0]), place.dot(plane[1])});
    }
    drawing.outline(layer, outline);
  }
  return drawing.file();
}

}  // namespace flexopt
