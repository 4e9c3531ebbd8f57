// Leaves of a design file, in global axes; a reinforced one as what it consists of.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <type_traits>

#include "core/math/decompositions.hpp"
#include "core/math/dual.hpp"
#include "core/mechanism/profile.hpp"
#include "designs/design_reader.hpp"
#include "designs/flattener.hpp"

namespace flexopt {
namespace {

/// Throws where a profile with these numbers, each at one of profile_stations(), is not the
/// formula: where it has more than 1 % less or more bending compliance ∫ t⁻³ (1 − s, s)(1 − s, s)ᵀ
/// ds under some pair of moments at the edges, or steps by a tenth from one polynomial to the next.
void expect_followed(std::span<const double> numbers, const std::function<double(double)>& formula,
                     const std::string& pointer) {
  constexpr double small = 0.01;
  constexpr double large_step = 0.1;  // kinks leave less between polynomials
  constexpr const char* advice = "make a leaf of each part, or let the size vary more gently";
  constexpr int samples = 83 * profile_pieces;  // a narrow notch falls between fewer
  const auto compliance = [](double t) { return 1 / (t * t * t); };
  Eigen::Matrix2d apart = Eigen::Matrix2d::Zero(), whole = apart;
  for (int k = 0; k < samples; ++k) {
    const double s = (k + 0.5) / samples, own = compliance(formula(s));
    const Eigen::Vector2d moment(1 - s, s);
    apart += (compliance(profile_at(numbers, s)) - own) * moment * moment.transpose();
    whole += own * moment * moment.transpose();
  }
  const double off = SymmetricEigen(apart, whole).eigenvalues().cwiseAbs().maxCoeff();
  if (!(off <= small))
    throw SpecError(
        pointer, fmt::format("{:.2g} %", 100 * off),
        fmt::format("the size varies so steeply that {} polynomials along the leaf miss "
                    "more than {:g} % of its bending compliance: {}",
                    profile_pieces, 100 * small, advice));
  for (int k = 1; k < profile_pieces; ++k) {
    const double border = static_cast<double>(k) / profile_pieces;
    const ProfileWeights weights = profile_weights(numbers.size(), border);
    std::array<double, 2> side{};  // the mean of both is the value
    for (int i = 0; i < weights.count; ++i)
      side[2 * i / weights.count] += 2 * weights.weight[i] * numbers[weights.first + i];
    const double step = std::abs(side[1] - side[0]);
    if (!(step <= large_step * std::min(side[0], side[1])))
      throw SpecError(pointer, fmt::format("a step of {:.3g} m", step),
                      fmt::format("the size steps at s = {:.3g}: {}", border, advice));
  }
}

}  // namespace

template <class S>
FlatSize<S> Flattener<S>::size_along(const DesignSize& size, const std::string& pointer,
                                     const char* what) {
  FlatSize<S> result;
  if (!size.profile) {
    result.values.push_back(positive(size.base, pointer, what));
    if (size.tip) result.values.push_back(positive(*size.tip, pointer, what));
    return result;
  }
  slots_.push_back(S(0));
  const auto at = [&](double s) {
    slots_.back() = S(s);
    return positive({0, size.profile}, pointer + "/profile", what);
  };
  for (const double s : profile_stations()) result.values.push_back(at(s));
  if constexpr (std::is_same_v<S, double>) expect_followed(result.values, at, pointer + "/profile");
  slots_.pop_back();
  std::vector<double> numbers;
  for (const S& x : slots_) numbers.push_back(value_of(x));
  result.formula = with_numbers(*size.profile, numbers);
  return result;
}

template <class S>
FlatLeaf<S> Flattener<S>::leaf_of(const LeafItem& item) {
  const Placement<S> at = frame(item.frame, item);
  FlatLeaf<S> leaf;
  leaf.name = leaf.whole = scope_.prefix + instance_name(item, item.name);
  leaf.source = source_of(item);
  leaf.base = named(item, item.base.body, "/base/body").body;
  leaf.tip = item.tip.body.empty() ? free_edge : named(item, item.tip.body, "/tip/body").body;
  leaf.base_at = at.place(vector(item.base.at));
  leaf.tip_at = at.place(vector(item.tip.at));
  leaf.across = at.across(vector(item.across));
  leaf.wire = item.wire;
  leaf.may_cross = item.may_cross;
  if (leaf.wire && value_of(S(leaf.across.squaredNorm())) == 0) {
    // any direction will do: one that turns with the frame
    const Vector3<S> line = vector(item.tip.at) - vector(item.base.at);
    int axis = 0;
    for (int i = 1; i < 3; ++i)
      if (std::abs(value_of(line[i])) <= std::abs(value_of(line[axis]))) axis = i;
    Vector3<S> across(S(0), S(0), S(0));
    across[axis] = S(1);
    leaf.across = at.across(across);
  }
  const std::string thick = item.pointer + (item.wire ? "/diameter" : "/thickness");
  if (item.curve) {
    leaf.curve = number(*item.curve);
    const double degrees = value_of(*leaf.curve) * 180 / std::numbers::pi;
    if (!(std::abs(degrees) <= 180))
      throw SpecError(item.pointer + "/curve/angle", fmt::format("{:g} deg", degrees),
                      "an arc subtends at most half a turn, to either side");
  }
  if (item.fold) leaf.fold = at.place(vector(*item.fold));
  if (item.fold_radius) {
    leaf.fold_radius = number(*item.fold_radius);
    if (!(value_of(leaf.fold_radius) >= 0))
      throw SpecError(item.pointer + "/fold/radius",
                      fmt::format("{:g} m", value_of(leaf.fold_radius)),
                      "the inner radius of a bend is 0 or more");
  }
  leaf.thickness = size_along(item.thickness, thick, item.wire ? "a diameter" : "a thickness");
  leaf.width =
      item.wire ? leaf.thickness : size_along(item.width, item.pointer + "/width", "a width");
  leaf.material = item.material;
  return leaf;
}

template <class S>
void Flattener<S>::add_leaf(const LeafItem& item) {
  FlatLeaf<S> leaf = leaf_of(item);
  if (std::ranges::find(out_.leaves, leaf.name, &FlatLeaf<S>::name) != out_.leaves.end())
    throw SpecError(item.pointer + "/name", "\"" + leaf.name + "\"", "another leaf has this name");
  hold_edges(item, leaf);
  if (item.reinforcement)
    add_reinforced(leaf, item);
  else
    out_.leaves.push_back(std::move(leaf));
}

/// A box of the leaf's material between the places, its middle the body's reference point.
template <class S>
FlatBody<S> Flattener<S>::box_between(const FlatLeaf<S>& leaf, const Vector3<S>& from,
                                      const Vector3<S>& to, const S& thickness) const {
  const S density = leaf.material ? S(leaf.material->density) : input_.material.density;
  const Vector3<S> line = to - from;
  const std::array<S, 3> l{line.norm(), leaf.width.values.front(), thickness};
  Matrix3<S> axes;
  axes.col(0) = line / l[0];
  const S along = axes.col(0).dot(leaf.across);
  axes.col(1) = leaf.across - axes.col(0) * along;
  axes.col(1) /= S(axes.col(1).norm());
  axes.col(2) = Vector3<S>(axes.col(0)).cross(Vector3<S>(axes.col(1)));
  FlatBody<S> box;
  box.source = leaf.source;
  box.at = (from + to) * S(0.5);
  box.has_mass = true;
  box.mass = density * l[0] * l[1] * l[2];
  Matrix3<S> inertia = Matrix3<S>::Zero();
  for (int i = 0; i < 3; ++i) {
    const S &a = l[static_cast<std::size_t>((i + 1) % 3)],
            &b = l[static_cast<std::size_t>((i + 2) % 3)];
    inertia(i, i) = box.mass * (a * a + b * b) / 12.0;
  }
  const Matrix3<S> left = axes.lazyProduct(inertia);
  box.inertia = left.lazyProduct(axes.transpose());
  box.box_half_edges = axes;
  for (int i = 0; i < 3; ++i) box.box_half_edges->col(i) *= S(0.5 * l[static_cast<std::size_t>(i)]);
  return box;
}

/// Adds a reinforced leaf: two leaves and a rigid box between them, or three leaves between rigid
/// lines without mass.
template <class S>
void Flattener<S>::add_reinforced(const FlatLeaf<S>& leaf, const LeafItem& item) {
  const std::string pointer = item.pointer + "/reinforcement";
  const LeafItem::Reinforcement& middle = *item.reinforcement;
  const S fraction = number(middle.fraction);
  const S thickness =
      positive(middle.thickness, pointer + "/thickness", "the thickness of a reinforcement");
  if (!(value_of(fraction) > 0 && value_of(fraction) < 1))
    throw SpecError(pointer + "/fraction", fmt::format("{:g}", value_of(fraction)),
                    "it is a part of the length: 0 < fraction < 1");
  if (leaf.width.values.size() > 1 || leaf.thickness.values.size() > 1)
    throw SpecError(pointer, "\"" + leaf.name + "\"", "only a uniform leaf is reinforced");
  const Vector3<S> line = leaf.tip_at - leaf.base_at;
  const S part = (S(1) - fraction) * 0.5;
  FlatLeaf<S> first = leaf, second = leaf;
  first.held_by[1].clear();
  first.clamps[1].reset();
  second.held_by[0].clear();
  second.clamps[0].reset();
  first.name += "/base";
  first.tip_at = leaf.base_at + line * part;
  second.name += "/tip";
  second.base_at = leaf.tip_at - line * part;
  const auto add = [&](FlatBody<S> body, const char* name) {
    body.name = leaf.name + name;
    out_.bodies.push_back(std::move(body));
    return static_cast<int>(out_.bodies.size()) - 1;
  };
  if (middle.rigid) {
    first.tip = second.base =
        add(box_between(leaf, first.tip_at, second.base_at, thickness), "/reinforcement");
    out_.leaves.push_back(std::move(first));
  } else {
    FlatBody<S> step;
    step.source = leaf.source;
    step.at = first.tip_at;
    first.tip = add(step, "/step at base");
    step.at = second.base_at;
    second.base = add(step, "/step at tip");
    FlatLeaf<S> plate = leaf;
    plate.held_by = {};
    plate.clamps = {};
    plate.name += "/reinforcement";
    plate.base = first.tip;
    plate.base_at = first.tip_at;
    plate.tip = second.base;
    plate.tip_at = second.base_at;
    plate.thickness.values.front() = thickness;
    out_.leaves.push_back(std::move(first));
    out_.leaves.push_back(std::move(plate));
  }
  out_.leaves.push_back(std::move(second));
}

template void Flattener<double>::add_leaf(const LeafItem&);
template void Flattener<Dual1>::add_leaf(const LeafItem&);

}  // namespace flexopt
