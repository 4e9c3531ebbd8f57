#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>

#include "core/spec/quantity.hpp"
#include "designs/design_reader.hpp"

namespace flexopt {
namespace {

bool is_word_letter(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// visit(at, piece) for the words of a text and for what stands between them.
template <class Visit>
void each_piece(const std::string& text, const Visit& visit) {
  for (std::size_t at = 0, end = 0; at < text.size(); at = end) {
    while (end < text.size() && is_word_letter(text[end]) == is_word_letter(text[at])) ++end;
    visit(at, text.substr(at, end - at));
  }
}

}  // namespace

std::size_t word_in(const std::string& text, const std::string& word) {
  std::size_t found = std::string::npos;
  each_piece(text, [&](std::size_t at, const std::string& piece) {
    if (piece == word) found = std::min(found, at);
  });
  return found;
}

std::string with_numbers(const Formula& profile, std::span<const double> slots) {
  std::string result;
  const auto& names = profile.names();
  each_piece(profile.text(), [&](std::size_t, const std::string& piece) {
    const auto named = std::ranges::find(names, piece);
    const auto i = static_cast<std::size_t>(named - names.begin());
    if (named == names.end() || piece == "s")
      result += piece;
    else
      result += fmt::format("({}{})", slots[static_cast<std::size_t>(profile.slots()[i])],
                            profile.units()[i]);
  });
  return result;
}

bool is_identifier(const std::string& name) {
  const auto letter = [](char c) {
    return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
  };
  return !name.empty() && letter(name[0]) && std::ranges::all_of(name, [&](char c) {
    return letter(c) || std::isdigit(static_cast<unsigned char>(c)) != 0;
  });
}

std::set<std::string> words_of(const std::string& text) {
  std::set<std::string> words;
  each_piece(text, [&](std::size_t, const std::string& piece) {
    if (is_identifier(piece)) words.insert(piece);
  });
  return words;
}

bool is_quantity(const std::string& text) {
  std::size_t begin = text.find_first_not_of(" \t+");
  if (begin == std::string::npos) return false;
  double number = 0;
  const auto [end, error] = std::from_chars(text.data() + begin, text.data() + text.size(), number);
  if (error != std::errc()) return false;
  std::string unit(end, text.data() + text.size());
  unit.erase(0, std::min(unit.find_first_not_of(" \t"), unit.size()));
  return unit.find_first_not_of(" \t") == std::string::npos || measured(1, unit).has_value();
}

}  // namespace flexopt
