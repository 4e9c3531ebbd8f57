#include "core/spec/fault_list.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace flexopt {

namespace {

/// Whether the pointer, or one of a place around it, is in the set.
bool holds_or_above(const std::set<std::string>& places, std::string pointer) {
  while (true) {
    if (places.contains(pointer)) return true;
    if (pointer.empty()) return false;
    const std::size_t slash = pointer.rfind('/');
    pointer.resize(slash == std::string::npos ? 0 : slash);
  }
}

bool holds_below(const std::set<std::string>& places, const std::string& pointer) {
  const std::string lead = pointer + "/";
  const auto next = places.lower_bound(lead);
  return next != places.end() && next->starts_with(lead);
}

}  // namespace

void FaultList::add(Fault fault) {
  if (holds_or_above(known_, fault.pointer)) return;
  known_.insert(fault.pointer);
  if (!fault.of_key) unsound_.insert(fault.pointer);
  faults_.push_back(std::move(fault));
}

void FaultList::add(std::string pointer, std::string value, std::string rule) {
  add({.pointer = std::move(pointer), .value = std::move(value), .rule = std::move(rule)});
}

void FaultList::add(const JsonPointer& pointer, std::string value, std::string rule) {
  add(pointer.to_string(), std::move(value), std::move(rule));
}

void FaultList::add(const SpecError& error) {
  for (const Fault& fault : error.faults()) add(fault);
}

bool FaultList::attempt(const std::function<void()>& action) try {
  action();
  return true;
} catch (const SpecError& error) {
  add(error);
  return false;
}

void FaultList::spoil(const std::string& pointer) {
  known_.insert(pointer);
  unsound_.insert(pointer);
}

void FaultList::spoil(const JsonPointer& pointer) { spoil(pointer.to_string()); }

bool FaultList::sound(const JsonPointer& pointer) const { return sound(pointer.to_string()); }

bool FaultList::sound(const std::string& pointer) const {
  return !holds_or_above(unsound_, pointer) && !holds_below(unsound_, pointer);
}

void FaultList::raise() const {
  if (!faults_.empty()) throw SpecError(faults_);
}

}  // namespace flexopt
