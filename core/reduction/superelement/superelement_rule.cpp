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
  const auto takes = [](const char* leaves, const char* is) {
    return Because(
        fmt::format("{}, and this method takes {} alone: expected \"mixed_potential\", or "
                    "\"accuracy\": \"full\"",
                    is, leaves));
  };
  if (leaf.curve) return takes("flat leaves", "it is curved");
  if (leaf.fold) return takes("flat leaves", "it is folded");
  if (leaf.has_profile())
    return takes("leaves of one width and thickness", "its width or thickness varies");
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
