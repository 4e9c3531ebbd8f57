#include "tests/benchmarks/estimates/drawn_designs.hpp"

#include <algorithm>
#include <numbers>

namespace flexopt {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double L = 0.1;  ///< [m] of most leaves

/// Width and thickness of a leaf: L/w 0.4 … 10, L/t 50 … 700.
struct Sizes {
  double width = 0, thickness = 0;
};
Sizes leaf_sizes(Random& random, double length, double thinnest = 5) {
  const double width = length / random.even_in_logarithm(0.4, 10);
  const double thickness = length / random.even_in_logarithm(50, 700);
  return {width, std::min(thickness, width / thinnest)};
}

/// The values of a family whose leaves have one length, width and thickness.
ParameterValues of_leaves(const Sizes& s, double length, ParameterValues more = {}) {
  more.insert({{"length", length}, {"width", s.width}, {"thickness", s.thickness}});
  return more;
}

}  // namespace

const std::vector<Draw>& draws() {
  static const std::vector<Draw> all{
      [](Random& r) -> Drawn {
        const Sizes s = leaf_sizes(r, L);
        return {"leaf_spring",
                of_leaves(s, L),
                {{"tip", r.coin() ? "rigid" : "guided"}},
                L * r.between(0.05, 0.25)};
      },
      [](Random& r) -> Drawn {
        const Sizes s = leaf_sizes(r, L);
        return {"parallel_guide",
                of_leaves(s, L, {{"spacing", L * r.between(0.3, 2)}}),
                {},
                L * r.between(0.05, 0.3)};
      },
      [](Random& r) -> Drawn {
        const Sizes s = leaf_sizes(r, L);
        return {"cross_hinge",
                of_leaves(s, L,
                          {{"half_angle", degree * r.between(25, 65)},
                           {"crossing_fraction", r.between(0.1, 0.9)},
                           {"gap", 0.005}}),
                {},
                degree * r.between(5, 40)};
      },
      [](Random& r) -> Drawn {
        const Sizes s = leaf_sizes(r, L, 10);
        return {"three_flexure_cross_hinge",
                {{"length", L},
                 {"outer_width", s.width / 2 * r.between(0.8, 1.5)},
                 {"inner_width", s.width},
                 {"thickness", s.thickness},
                 {"half_angle", degree * r.between(25, 65)},
                 {"crossing_fraction", r.between(0.2, 0.8)},
                 {"gap", 0.005}},
                {},
                degree * r.between(5, 40)};
      },
      [](Random& r) -> Drawn {
        const Sizes s = leaf_sizes(r, L, 10);
        return {"tapered_leaf",
                {{"length", L},
                 {"base_width", s.width},
                 {"tip_width", s.width * r.between(0.4, 1.2)},
                 {"thickness", s.thickness}},
                {},
                L * r.between(0.05, 0.25)};
      },
      [](Random& r) -> Drawn {
        const Sizes s = leaf_sizes(r, L);
        return {"curved_leaf",
                {{"chord", L},
                 {"angle", degree * r.between(15, 120)},
                 {"width", s.width},
                 {"thickness", s.thickness}},
                {},
                degree * r.between(5, 30)};
      },
      [](Random& r) -> Drawn {
        const Sizes s = leaf_sizes(r, L);
        return {"folded_leaf",
                of_leaves(s, L),
                {{"fold", r.coin() ? "rigid" : "elastic"}},
                L * r.between(0.02, 0.15)};
      },
      [](Random& r) -> Drawn {
        const Sizes s = leaf_sizes(r, L);
        const double outer = L * r.between(0.6, 1.5);
        return {"double_parallelogram",
                of_leaves(s, L,
                          {{"outer_spacing", outer},
                           {"inner_spacing", outer * r.between(0.4, 0.8)},
                           {"stage_mass", 0.1}}),
                {},
                L * r.between(0.05, 0.3)};
      },
      [](Random& r) -> Drawn {
        const Sizes s = leaf_sizes(r, 0.05);
        return {
            "cartwheel_hinge",
            of_leaves(s, 0.05, {{"half_angle", degree * r.between(25, 65)}, {"hub_mass", 0.05}}),
            {},
            degree * r.between(3, 25)};
      },
      [](Random& r) -> Drawn {
        const double fraction = r.between(0.2, 0.6);
        const Sizes s = leaf_sizes(r, L * (1 - fraction) / 2);
        return {"reinforced_guide",
                of_leaves(s, L,
                          {{"spacing", L * r.between(0.4, 1.5)},
                           {"fraction", fraction},
                           {"reinforcement_thickness", 8 * s.thickness}}),
                {},
                L * r.between(0.05, 0.2)};
      }};
  return all;
}

Mechanism mechanism_of(const Drawn& drawn) {
  const Family& family = find_family(drawn.family, "");
  FamilyChoices choices = default_choices(family);
  for (const auto& [name, value] : drawn.choices) choices[name] = value;
  const Material material{"steel", 200e9, 0.3, 7800, {}};
  EndEffector payload;
  payload.mass = drawn.mass;
  payload.inertia = 4e-4 * drawn.mass * Matrix3d::Identity();
  ParameterValues values = drawn.values;
  for (const Parameter& p : family.parameters)
    if (!values.contains(p.name) && p.default_value) values[p.name] = *p.default_value;
  return family.make(values, choices, material, payload);
}

}  // namespace flexopt
