#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "results/cli/printed.hpp"

namespace flexopt {
namespace {

/// What a row costs beside the equilibrium, which every number needs.
std::string cost_of(const QuantityRow& row) {
  constexpr std::pair<Output, const char*> words[] = {
      {Output::stiffness, "stiffness"},
      {Output::stress, "stress"},
      {Output::frequencies_free, "frequencies"},
      {Output::frequencies_locked, "frequencies"},
      {Output::parasitic_frequency, "frequencies"},
      {Output::frequency_derivatives, "one expansion at rest"},
      {Output::envelope, "surfaces at rest"},
      {Output::moving_envelope, "surfaces"},
      {Output::clearance, "surfaces"},
      {Output::buckling, "buckling, full leaves"},
      {Output::load_capacity, "growing loads, full leaves"},
      {Output::dynamics, "harmonic motion, full leaves"}};
  for (const auto& [output, word] : words)
    if (row.needs.has(output)) return word;
  return row.needs.has(Output::equilibrium) ? "equilibrium" : "the design";
}

/// How the errors of a quantity are estimated.
const char* estimate_of(const QuantityRow& row) {
  return row.error == ErrorKind::none     ? "-"
         : row.error == ErrorKind::motion ? "of path"
         : row.error == ErrorKind::stress ? "coarse"
                                          : "yes";
}

/// The units of these quantities, each once.
std::string units_of(const std::vector<const Quantity*>& quantities) {
  std::vector<std::string> all;
  for (const Quantity* q : quantities)
    if (std::ranges::find(all, q->unit) == all.end()) all.push_back(q->unit);
  return fmt::format("{}", fmt::join(all, ", "));
}

}  // namespace

std::string describe_quantities(const DriveList& drives) {
  // rows whose components are offered for these drives, in the order of the table
  std::string text = fmt::format("{:<46} {:<13} {:<22} {:<9} {}\n", "quantity", "unit", "needs",
                                 "estimate", "meaning");
  const std::vector<Quantity> all = quantities(drives);
  for (const QuantityRow& row : quantity_rows()) {
    std::vector<const Quantity*> own;
    for (const Quantity& q : all)
      if (q.row == &row) own.push_back(&q);
    if (own.empty()) continue;
    std::string name = own.front()->name;
    if (own.size() > 1) {
      const std::string& last = own.back()->name;
      name += fmt::format(" … {}", last.substr(last.rfind('.')));
    }
    std::string meaning = row.meaning.empty() ? row.label : row.meaning;
    if (meaning.ends_with(',')) meaning.pop_back();  // a label that its components complete
    const std::string unit = units_of(own);
    text += fmt::format("{:<46} {:<13} {:<22} {:<9} {}\n", name, unit == "1" ? "-" : unit,
                        cost_of(row), estimate_of(row), meaning);
  }
  return text;
}

}  // namespace flexopt
