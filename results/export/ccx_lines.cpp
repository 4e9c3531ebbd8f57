#include <cmath>

#include "results/export/ccx_model.hpp"

namespace flexopt {

std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return text;
}

void write_equation(const std::vector<CcxTerm>& terms, CcxLines& deck) {
  std::vector<std::string> lines;
  for (const CcxTerm& term : terms)
    lines.push_back(fmt::format("{}, {}, {:.12g}", term.node, term.dof, term.factor));
  deck.line("*EQUATION\n{}\n{}", lines.size(), fmt::join(lines, ",\n"));
}

std::vector<CcxTerm> terms_along(int node, const Vector3d& axis) {
  std::array<int, 3> order{0, 1, 2};
  std::ranges::sort(order, {}, [&](int c) { return -std::abs(axis[c]); });
  std::vector<CcxTerm> terms;
  for (const int c : order)
    if (std::abs(axis[c]) > 1e-12) terms.push_back({node, c + 1, axis[c]});
  return terms;
}

}  // namespace flexopt
