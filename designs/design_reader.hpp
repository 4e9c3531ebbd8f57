#pragma once
// Design files: JSON → plan.
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/spec/fault_list.hpp"
#include "core/spec/formula.hpp"
#include "designs/design_plan.hpp"

namespace flexopt {

/// Reads a design document. All that is wrong is added to `faults`, with its place. `within`: the
/// files that this one is a part of, outermost first.
std::shared_ptr<const DesignPlan> read_plan(const nlohmann::json& document,
                                            const DesignSource& source, FaultList& faults,
                                            std::vector<std::string> within = {});

/// Source of a family that the program brings along.
DesignSource library_source(const std::string& name);

/// Reads a design file of the user. Throws SpecError.
std::shared_ptr<const DesignPlan> read_design_file(const std::string& file,
                                                   std::vector<std::string> within = {});

// The words of a formula's text, before or without parsing it.

/// Letters, digits and _, no digit first.
bool is_identifier(const std::string& name);

/// The words of a formula: names, functions and units alike.
std::set<std::string> words_of(const std::string& text);

/// Whether the text is a number with or without a unit, and no formula.
bool is_quantity(const std::string& text);

/// Position of a word in a text; npos if the text does not contain it.
std::size_t word_in(const std::string& text, const std::string& word);

/// The profile's text with numbers in the place of its names, s aside. `slots`: values by slot.
std::string with_numbers(const Formula& profile, std::span<const double> slots);

}  // namespace flexopt
