#pragma once
// The words of a formula's text, before or without parsing it.
#include <set>
#include <span>
#include <string>

#include "core/spec/formula.hpp"

namespace flexopt {

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
