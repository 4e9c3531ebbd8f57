#include "designs/parametric_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/mechanism/each_number.hpp"
#include "core/spec/spec_error.hpp"

namespace flexopt {
namespace {

std::string parameter_pointer(const std::string& parameter) {
  return "/design/parameters/" + parameter + "/expression";
}

/// The number of a leaf that an EdgeSize gives.
double& place_of(const EdgeSize& size, Mechanism& mechanism) {
  LeafSpring& leaf = mechanism.leaves[static_cast<std::size_t>(size.leaf)];
  const auto end = static_cast<std::size_t>(size.end);
  return size.axis < 3 ? leaf.assembly_move[end][size.axis]
                       : leaf.assembly_turn[end][size.axis - 3];
}

}  // namespace

ParametricDesign::ParametricDesign(std::shared_ptr<const Family> of, FamilyChoices choices,
                                   const std::map<std::string, std::string>& formulas,
                                   ParameterValues nominal)
    : family_(std::move(of)), choices_(std::move(choices)), nominal_(std::move(nominal)) {
  const Family& family = *family_;
  std::vector<FormulaName> given;
  std::vector<int> slot_of;  // slots of the given ones
  for (std::size_t i = 0; i < family.parameters.size(); ++i)
    if (const Parameter& p = family.parameters[i]; !formulas.contains(p.name)) {
      given.push_back({p.name, p.unit});
      slot_of.push_back(static_cast<int>(i));
    }
  for (const auto& [name, text] : formulas) {
    Formula formula(text, given, parameter_pointer(name), BareNumbers::may_be_si);
    if (formula.slots().empty()) throw SpecError(formula.pointer(), text, uses_no_name(given));
    formula.move_to(slot_of);
    dependents_.push_back({slot(name), std::move(formula)});
  }
}

bool ParametricDesign::is_dependent(int slot) const {
  return std::ranges::any_of(dependents_,
                             [&](const DependentParameter& d) { return d.slot == slot; });
}

int ParametricDesign::slot(const std::string& name) const {
  const auto found = std::ranges::find(family_->parameters, name, &Parameter::name);
  return found == family_->parameters.end() ? -1
                                            : static_cast<int>(found - family_->parameters.begin());
}

std::vector<double> ParametricDesign::slots(const ParameterValues& parameters) const {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < family_->parameters.size(); ++i) {
    const auto found = parameters.find(family_->parameters[i].name);
    if (found == parameters.end() && !is_dependent(static_cast<int>(i)))
      throw std::invalid_argument("no value of the parameter " + family_->parameters[i].name);
    numbers.push_back(found == parameters.end() ? 0 : found->second);
  }
  return numbers;
}

void ParametricDesign::complete(std::span<double> slots) const {
  for (const DependentParameter& d : dependents_) {
    const std::optional<double> value = d.formula.value(slots);
    if (!value)
      throw SpecError(d.formula.pointer(), d.formula.text(),
                      "it has no finite value at these parameters");
    slots[static_cast<std::size_t>(d.slot)] = *value;
  }
}

std::optional<MatrixXd> ParametricDesign::derivatives(std::span<const double> slots) const {
  const auto n = static_cast<Eigen::Index>(slots.size());
  MatrixXd derivatives = MatrixXd::Identity(n, n);
  for (const DependentParameter& d : dependents_) {
    std::vector<double> slopes(d.formula.slots().size());
    if (!d.formula.gradient(slots, slopes)) return std::nullopt;
    derivatives(d.slot, d.slot) = 0;
    for (std::size_t i = 0; i < slopes.size(); ++i)
      derivatives(d.slot, d.formula.slots()[i]) = slopes[i];
  }
  return derivatives;
}

ParametricDesign ParametricDesign::with_edges(std::vector<EdgeSize> edges) const {
  ParametricDesign design = *this;
  design.edges_ = std::move(edges);
  return design;
}

Mechanism ParametricDesign::build(const ParameterValues& parameters, const Material& material,
                                  const EndEffector& payload) const {
  Mechanism mechanism = family_->make(parameters, choices_, material, payload, nominal_);
  if (edges_.empty()) return mechanism;
  const std::vector<double> numbers = slots(parameters);
  for (const EdgeSize& size : edges_) {
    const std::optional<double> value = size.formula.value(numbers);
    if (!value || std::abs(*value) > largest_edge_size)
      throw SpecError(size.formula.pointer(), size.formula.text(),
                      value ? fmt::format("at these parameters it is {:g}; expected at most {:g}",
                                          *value, largest_edge_size)
                            : "it has no finite value at these parameters");
    place_of(size, mechanism) = *value;
  }
  return mechanism;
}

std::vector<MechanismDirection> ParametricDesign::directions(
    const ParameterValues& parameters, const Material& material, const EndEffector& payload,
    const std::vector<std::string>& names) const {
  std::vector<MechanismDirection> along =
      family_->directions(parameters, choices_, material, payload, names, nominal_);
  if (edges_.empty()) return along;
  const std::vector<double> numbers = slots(parameters);
  for (const EdgeSize& size : edges_) {
    const std::vector<int>& own = size.formula.slots();
    std::vector<double> slopes(own.size());
    if (!size.formula.gradient(numbers, slopes))
      throw SpecError(size.formula.pointer(), size.formula.text(),
                      "its slope is not finite at these parameters");
    for (MechanismDirection& direction : along)
      if (const auto found = std::ranges::find(own, slot(direction.parameter)); found != own.end())
        place_of(size, direction.rate) = slopes[static_cast<std::size_t>(found - own.begin())];
  }
  return along;
}

std::vector<std::string> ParametricDesign::independent_names() const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < family_->parameters.size(); ++i)
    if (!is_dependent(static_cast<int>(i))) names.push_back(family_->parameters[i].name);
  const auto add = [&](const char* section) {
    return [&names, section](std::string_view name, double) {
      const std::string full = section + std::string(name);
      if (std::ranges::find(names, full) == names.end()) names.push_back(full);
    };
  };
  Material material;
  EndEffector payload;
  each_material_number(material, add("material."));
  if (has_end_effector()) each_payload_number(payload, add("end_effector."));
  return names;
}

}  // namespace flexopt
