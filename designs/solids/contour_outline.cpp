#include "designs/solids/contour_outline.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace flexopt {

namespace {

using Patches = std::vector<PatchT<double>>;

/// Place on the line of a curve, of its length, and distance from it.
std::array<double, 2> on_line(const CurveT<double>& line, const Point2<double>& place) {
  const Point2<double> t = line.tangent(0), d = place - line.from;
  return {t.dot(d), std::abs(t[0] * d[1] - t[1] * d[0])};
}

class OutlinePlanner {
 public:
  OutlinePlanner(const PlateShapeT<double>& plate, const ContoursT<double>& contours,
                 const Patches& patches, double tolerance)
      : plate_(plate),
        contours_(contours),
        patches_(patches),
        tolerance_(tolerance),
        chords_(chords_of(contours)) {
    for (std::size_t c = 0; c < contours.curves.size(); ++c) {
      plan_.keys.push_back({static_cast<int>(c)});
      places_.push_back(contours.curves[c].from);
    }
  }

  Answer<PlaneOutline> plan() {
    for (std::size_t p = 0; p < patches_.size(); ++p) {
      const auto& [center, u, v, name] = patches_[p];
      const Vector3d normal = u.cross(v).normalized();
      const double small = 1e-6;
      const bool is_flat = std::abs(normal[2]) > 1 - small * small;
      plan_.faces.push_back(is_flat                           ? PatchFace::flat
                            : std::abs(u[2]) > std::abs(v[2]) ? PatchFace::u_along_z
                                                              : PatchFace::v_along_z);
      const Vector3d &high = std::abs(u[2]) > std::abs(v[2]) ? u : v, &wide = &high == &u ? v : u;
      if (!is_flat &&
          (high.head<2>().norm() > small * high.norm() || std::abs(wide[2]) > small * wide.norm()))
        return refused(p, "is inclined to the faces of the plate");
      if (const Check check = is_flat ? take_flat(p) : take_side(p); !check)
        return Because(check.error());
    }
    add_contours();
    if (const Check check = check_sides(); !check) return Because(check.error());
    return plan_;
  }

 private:
  tl::unexpected<std::string> refused(std::size_t p, const char* why) const {
    return Because(fmt::format("the patch of {} {}", patches_[p].name, why));
  }

  /// The key at a corner of a patch, on a line where `curve` or any line holds it.
  int key_at(int patch, int corner, const Point2<double>& place, int curve) {
    for (std::size_t k = 0; k < places_.size(); ++k)
      if ((places_[k] - place).norm() < tolerance_) return static_cast<int>(k);
    for (std::size_t c = 0; c < contours_.curves.size() && curve < 0; ++c)
      if (!contours_.curves[c].is_arc && holds(static_cast<int>(c), place))
        curve = static_cast<int>(c);
    plan_.keys.push_back({curve, patch, corner});
    places_.push_back(place);
    return static_cast<int>(places_.size()) - 1;
  }
  bool holds(int c, const Point2<double>& place) const {
    const auto [along, off] = on_line(contours_.curves[c], place);
    return off < tolerance_ && along > -tolerance_ &&
           along < contours_.curves[c].length() + tolerance_;
  }

  Check take_side(std::size_t p) {
    const auto ends = plan_.corners<double>(static_cast<int>(p), patches_[p]);
    if (std::abs(patches_[p].center[2]) +
            plan_.half_height<double>(static_cast<int>(p), patches_[p]) >
        plate_.thickness / 2 + tolerance_)
      return refused(p, "reaches beyond the thickness of the plate");
    for (std::size_t c = 0; c < contours_.curves.size(); ++c) {
      if (contours_.curves[c].is_arc || !holds(c, ends[0]) || !holds(c, ends[1])) continue;
      for (int e = 0; e < 2; ++e) key_at(p, e, ends[e], c);
      return {};
    }
    return refused(p, "lies on no straight side of the plate");
  }

  Check take_flat(std::size_t p) {
    if (std::abs(std::abs(patches_[p].center[2]) - plate_.thickness / 2) > tolerance_)
      return refused(p, "lies on no face of the plate");
    const auto corners = plan_.corners<double>(static_cast<int>(p), patches_[p]);
    std::array<int, 4> keys;
    for (int e = 0; e < 4; ++e) {
      keys[e] = key_at(p, e, corners[e], -1);
      if (plan_.keys[keys[e]].curve < 0 && !is_inside(chords_, corners[e]))
        return refused(p, "reaches beyond the contour of the plate");
    }
    for (int e = 0; e < 4; ++e) {
      const std::array<int, 2> side = {keys[e], keys[(e + 1) % 4]};
      const auto known = [&](const auto& has) {
        return has.keys == side || (has.keys[0] == side[1] && has.keys[1] == side[0]);
      };
      bool is_there = std::any_of(plan_.pieces.begin(), plan_.pieces.end(), known);
      for (std::size_t c = 0; c < contours_.curves.size(); ++c)
        is_there = is_there || (!contours_.curves[c].is_arc && holds(c, places_[side[0]]) &&
                                holds(c, places_[side[1]]));
      if (!is_there) plan_.pieces.push_back({-1, side});
    }
    return {};
  }

  void add_contours() {
    for (int k = 0; k < contours_.contours(); ++k)
      for (int c = contours_.first[k]; c < contours_.first[k + 1]; ++c) {
        std::vector<int> cuts;
        for (std::size_t i = contours_.curves.size(); i < plan_.keys.size(); ++i)
          if (plan_.keys[i].curve == c) cuts.push_back(static_cast<int>(i));
        const auto along = [&](int i) { return on_line(contours_.curves[c], places_[i])[0]; };
        std::sort(cuts.begin(), cuts.end(), [&](int a, int b) { return along(a) < along(b); });
        cuts.push_back(contours_.after(k, c));
        for (int from = c; const int to : cuts) {
          plan_.pieces.push_back({c, {from, to}});
          from = to;
        }
      }
  }

  /// Sides of flat patches meet each other and contours at their ends only, within the plate.
  Check check_sides() const {
    for (std::size_t i = 0; i < plan_.pieces.size(); ++i) {
      if (plan_.pieces[i].curve >= 0) continue;
      const auto [a, b] = plan_.pieces[i].keys;
      // shorter by the tolerance: ends may lie on contours
      const Point2<double> t = (places_[b] - places_[a]).normalized() * (10 * tolerance_);
      const Chord side{places_[a] + t, places_[b] - t, -1};
      bool is_free = is_inside(chords_, (side.from + side.to) / 2);
      for (const Chord& chord : chords_) is_free = is_free && !touch(side, chord);
      for (std::size_t j = 0; j < plan_.pieces.size(); ++j) {
        const auto [c, d] = plan_.pieces[j].keys;
        if (j != i && plan_.pieces[j].curve < 0)
          is_free = is_free && !touch(side, {places_[c], places_[d], -1});
      }
      if (is_free) continue;
      const int p = std::max(plan_.keys[a].patch, plan_.keys[b].patch);
      return p < 0 ? Because("the outline of a patch crosses a contour of the plate")
                   : refused(p, "has an outline that crosses a contour or another patch");
    }
    return {};
  }

  const PlateShapeT<double>& plate_;
  const ContoursT<double>& contours_;
  const Patches& patches_;
  double tolerance_;
  std::vector<Chord> chords_;
  PlaneOutline plan_;
  std::vector<Point2<double>> places_;  ///< of keys
};

}  // namespace

template <class S>
std::array<Point2<S>, 4> PlaneOutline::corners(int patch, const PatchT<S>& of) const {
  const Point2<S> c = of.center.template head<2>(), u = of.half_u.template head<2>(),
                  v = of.half_v.template head<2>();
  if (faces[patch] == PatchFace::flat) return {c - u - v, c + u - v, c + u + v, c - u + v};
  const Point2<S>& along = faces[patch] == PatchFace::u_along_z ? v : u;
  return {c - along, c + along, c - along, c + along};
}

template <class S>
S PlaneOutline::half_height(int patch, const PatchT<S>& of) const {
  const S half = (faces[patch] == PatchFace::u_along_z ? of.half_u : of.half_v)[2];
  return value_of(half) < 0 ? -half : half;
}

template <class S>
std::vector<Point2<S>> PlaneOutline::places(const ContoursT<S>& contours,
                                            const std::vector<PatchT<S>>& patches) const {
  std::vector<Point2<S>> all;
  for (const auto& [curve, patch, corner] : keys) {
    if (patch < 0) {
      all.push_back(contours.curves[curve].from);
      continue;
    }
    Point2<S> place = corners<S>(patch, patches[patch])[corner];
    if (curve >= 0) {
      const auto& line = contours.curves[curve];
      const Point2<S> t = line.tangent(0), d = place - line.from;
      const S along = t[0] * d[0] + t[1] * d[1];
      place = {line.from[0] + along * t[0], line.from[1] + along * t[1]};
    }
    all.push_back(place);
  }
  return all;
}

template <class S>
CurveT<S> PlaneOutline::curve(int piece, const ContoursT<S>& contours,
                              const std::vector<Point2<S>>& places) const {
  const auto& [of, ends] = pieces[piece];
  if (of >= 0 && contours.curves[of].is_arc) return contours.curves[of];
  return {places[ends[0]], places[ends[1]]};
}

#define FLEXOPT_OUTLINE_OF(S)                                                                     \
  template std::array<Point2<S>, 4> PlaneOutline::corners(int, const PatchT<S>&) const;           \
  template S PlaneOutline::half_height(int, const PatchT<S>&) const;                              \
  template std::vector<Point2<S>> PlaneOutline::places(const ContoursT<S>&,                       \
                                                       const std::vector<PatchT<S>>&) const;      \
  template CurveT<S> PlaneOutline::curve(int, const ContoursT<S>&, const std::vector<Point2<S>>&) \
      const;
FLEXOPT_OUTLINE_OF(double)
FLEXOPT_OUTLINE_OF(Dual1)
#undef FLEXOPT_OUTLINE_OF

Answer<PlaneOutline> outline_of(const PlateShapeT<double>& plate, const ContoursT<double>& contours,
                                const Patches& patches, double tolerance) {
  return OutlinePlanner(plate, contours, patches, tolerance).plan();
}

}  // namespace flexopt
