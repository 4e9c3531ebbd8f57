#include "core/reduction/superelement/superelement_rule.hpp"

#include <fmt/format.h>

#include <cmath>

namespace flexopt {

std::optional<int> node_at(double place, int intervals) {
  const double node = place * intervals;
  if (std::abs(node - std::round(node)) > 1e-6) return std::nullopt;
  return static_cast<int>(std::round(node));
}

Check check_rules(const LeafSpring& leaf, const ModelOptions& model) {
  if (leaf.curve)
    return Because(
        "it is curved, and this method takes flat leaves alone: expected \"mixed_potential\", "
        "or \"accuracy\": \"full\"");
  if (leaf.fold)
    return Because(
        "it is folded, and this method takes flat leaves alone: expected \"mixed_potential\", "
        "or \"accuracy\": \"full\"");
  if (leaf.has_profile())
    return Because(
        "its width or thickness varies, and this method takes leaves of one width and thickness "
        "alone: expected \"mixed_potential\", or \"accuracy\": \"full\"");
  if (model.method != Reduction::linear_craig_bampton) return {};
  if (flexure_of(leaf, model) == Flexure::beam && model.superelements[1] != 0)
    return Because("a beam is cut along only: expected the number of superelements along");
  if (!leaf.point || leaf.point->spread_over_tip) return {};
  const auto [along, across] = model.superelements;
  const bool on_line = node_at(leaf.point->along, along).has_value();
  const bool on_node = across == 0 ? std::abs(leaf.point->across - 0.5) < 1e-6
                                   : node_at(leaf.point->across, across).has_value();
  if (on_line && on_node) return {};
  return Because(fmt::format(
      "the material point at ({:g}, {:g}) of the leaf's length and width is no node of {} "
      "superelements: a multiple of 1/{} along and {} across",
      leaf.point->along, leaf.point->across,
      across == 0 ? fmt::format("{}", along) : fmt::format("[{}, {}]", along, across), along,
      across == 0 ? std::string("the middle") : fmt::format("of 1/{}", across)));
}

}  // namespace flexopt
