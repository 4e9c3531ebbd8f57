#include "designs/design_plan.hpp"

#include <algorithm>
#include <set>

#include "designs/elastic_item.hpp"

namespace flexopt {

bool ChoiceCondition::holds(const FamilyChoices& choices) const {
  const auto chosen = [&](const Term& term) {
    return (choices.at(term.option) == term.choice) == term.equal;
  };
  return alternatives.empty() ||
         std::ranges::any_of(alternatives, [&](const std::vector<Term>& terms) {
           return std::ranges::all_of(terms, chosen);
         });
}

bool DesignPlan::has_elastic_bodies() const {
  return std::ranges::any_of(
             bodies,
             [](const BodyItem& body) { return body.elastic && !body.elastic->is_hinge(); }) ||
         std::ranges::any_of(
             parts, [](const PartItem& part) { return part.design->has_elastic_bodies(); });
}

const BodyItem* DesignPlan::end_effector(const FamilyChoices& choices) const {
  for (const BodyItem& body : bodies)
    if (body.name == "end_effector" && body.when.holds(choices)) return &body;
  return nullptr;
}

bool DesignPlan::has_leaves(bool wires, const FamilyChoices& choices) const {
  const auto is_such = [&](const LeafItem& leaf) {
    return leaf.wire == wires && leaf.when.holds(choices);
  };
  const auto has_such = [&](const PartItem& part) {
    return part.when.holds(choices) && part.design->has_leaves(wires, part.choices);
  };
  return std::ranges::any_of(leaves, is_such) || std::ranges::any_of(parts, has_such);
}

std::vector<std::string> DesignPlan::counts() const {
  std::set<int> slots;
  const auto add = [&](const DesignNumber& n) {
    if (n.formula) slots.insert(n.formula->slots().begin(), n.formula->slots().end());
  };
  const auto look = [&](const auto& items) {
    for (const auto& item : items) {
      for (const RepeatIndex& index : item.repeat) {
        add(index.first);
        add(index.last);
      }
      for (const auto& [text, number] : item.braces) add(number);
    }
  };
  look(frames);
  look(bodies);
  look(leaves);
  look(joints);
  look(springs);
  look(parts);
  look(drives);
  const int first = static_cast<int>(parameters.size());
  for (int k = static_cast<int>(lets.size()) - 1; k >= 0; --k)  // later ones use earlier ones
    if (slots.contains(first + k)) add(let_numbers[static_cast<std::size_t>(k)]);
  std::vector<std::string> names;
  for (const int slot : slots)
    if (slot < first) names.push_back(parameters[static_cast<std::size_t>(slot)].name);
  return names;
}

bool is_of_job(const Fault& fault) { return fault.pointer.starts_with("/design/"); }

void show_at(const std::string& pointer, const DesignSource& family, Fault& fault) {
  fault.rule += " (" + fault.pointer + " of the family " + family.text.origin + ")";
  fault.pointer = pointer;
}

SpecError located(const DesignSource& source, const SpecError& error) {
  std::vector<Fault> faults = error.faults();
  for (Fault& fault : faults) {
    if (!fault.source.empty() || is_of_job(fault)) continue;
    if (source.kind == DesignSource::Kind::job)
      fault.pointer = source.lead + fault.pointer;
    else if (source.kind == DesignSource::Kind::library)
      show_at("/design/parameters", source, fault);
  }
  if (source.kind == DesignSource::Kind::file) {
    // those that are of the job stay without a place: its reader knows it
    const auto of_job = std::stable_partition(faults.begin(), faults.end(), [](const Fault& fault) {
      return !fault.source.empty() || !is_of_job(fault);
    });
    std::vector<Fault> in_file(faults.begin(), of_job);
    locate(in_file, source.text, {});
    std::copy(in_file.begin(), in_file.end(), faults.begin());
  }
  return SpecError(std::move(faults));
}

}  // namespace flexopt
