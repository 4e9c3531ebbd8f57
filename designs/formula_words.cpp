#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>

#include "core/spec/quantity.hpp"
#include "designs/design_reader.hpp"

namespace flexopt {
namespace {

bool is_word_letter(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

}  // namespace

std::size_t word_in(const std::string& text, const std::string& word) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || !is_word_letter(text[at - 1])) &&
        (end == text.size() || !is_word_letter(text[end])))
      return at;
  }
  return std::string::npos;
}

std::string with_numbers(const Formula& profile, std::span<const double> slots) {
  std::string result, word;
  const auto& names = profile.names();
  const std::string& text = profile.text();
  for (std::size_t at = 0; at <= text.size(); ++at) {
    const char c = at < text.size() ? text[at] : ' ';
    if (is_word_letter(c)) {
      word += c;
      continue;
    }
    const auto named = std::ranges::find(names, word);
    if (!word.empty() && named != names.end() && word != "s") {
      const auto i = static_cast<std::size_t>(named - names.begin());
      const std::size_t slot = static_cast<std::size_t>(profile.slots()[i]);
      result += fmt::format("({}{})", slots[slot], profile.units()[i]);
    } else {
      result += word;
    }
    word.clear();
    if (at < text.size()) result += c;
  }
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
  std::string word;
  for (const char c : text + " ") {
    if (is_word_letter(c)) {
      word += c;
    } else {
      if (is_identifier(word)) words.insert(word);
      word.clear();
    }
  }
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
