#include "tests/fuzz/mutations.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>

#include "designs/describe.hpp"
#include "optim/job/job.hpp"

namespace flexopt::fuzz {

using nlohmann::json;

namespace {

void collect(const json& schema, std::set<std::string>& words) {
  if (schema.is_object())
    for (const auto& [key, value] : schema.items()) {
      if (key == "properties")
        for (const auto& [name, of] : value.items()) words.insert(name);
      if (key == "enum" || key == "const")
        for (const json& one : value.is_array() ? value : json::array({value}))
          if (one.is_string()) words.insert(one.get<std::string>());
      collect(value, words);
    }
  else if (schema.is_array())
    for (const json& one : schema) collect(one, words);
}

std::size_t below(std::size_t count, RandomNumbers& random) {
  return static_cast<std::size_t>(random.whole(0, static_cast<int>(count) - 1));
}

const std::string& word(RandomNumbers& random) {
  return dictionary()[below(dictionary().size(), random)];
}

// Values at the edges of what a reader expects.
json odd_value(RandomNumbers& random) {
  static const json odd = [] {
    json values = json::parse(R"([
      null, true, 0, -1, 1, 1e308, -1e308, 1e-308, 0.1, 1e16, 100000, 2147483648, {}, [],
      "", "0 mm", "-1 mm", "1e9 km", "nan m", "1 N", "2*length", "5 deg", "inf", "/", "..", "{i}"])");
    values.push_back("\xff");
    return values;
  }();
  if (random.chance(0.3)) return word(random);
  return odd[below(odd.size(), random)];
}

// All values below one, itself included.
void places_in(json& value, std::vector<json*>& places) {
  places.push_back(&value);
  if (value.is_structured())
    for (json& one : value) places_in(one, places);
}

void change_value(json& document, RandomNumbers& random) {
  std::vector<json*> places;
  places_in(document, places);
  json& place = *places[below(places.size(), random)];
  const json other = *places[below(places.size(), random)];
  switch (random.whole(0, 6)) {
    case 0:
      place = odd_value(random);
      return;
    case 1:
      place = other;
      return;
    case 2:
      if (place.is_object()) place[word(random)] = random.chance(0.5) ? other : odd_value(random);
      return;
    case 3:
      if (place.is_structured() && !place.empty())
        place.erase(
            std::next(place.begin(), static_cast<std::ptrdiff_t>(below(place.size(), random))));
      return;
    case 4:
      if (place.is_array()) place.push_back(place.empty() ? odd_value(random) : place.front());
      return;
    case 5:
      if (place.is_number()) place = place.get<double>() * (random.chance(0.5) ? -1 : 1e3);
      return;
    default:
      if (place.is_array())
        for (int k = 0; k < 30; ++k) place.push_back(other);
  }
}

void change_bytes(std::string& text, const std::vector<std::string>& texts, RandomNumbers& random) {
  const std::size_t at = text.empty() ? 0 : below(text.size(), random);
  const auto some = [&] { return std::min(text.size() - at, below(40, random) + 1); };
  switch (random.whole(0, 5)) {
    case 0:
      if (!text.empty()) text[at] = static_cast<char>(random.whole(0, 255));
      return;
    case 1:
      text.insert(at, 1, static_cast<char>(random.whole(0, 255)));
      return;
    case 2:
      text.erase(at, some());
      return;
    case 3:
      text.insert(at, word(random));
      return;
    case 4:
      text.insert(at, text.substr(at, some()));
      return;
    default: {
      const std::string& other = texts[below(texts.size(), random)];
      const std::size_t from = other.empty() ? 0 : below(other.size(), random);
      text = text.substr(0, at) + other.substr(from, 4000);
    }
  }
}

}  // namespace

const std::vector<std::string>& dictionary() {
  static const std::vector<std::string> all = [] {
    std::set<std::string> words;
    collect(job_schema(), words);
    collect(json_schema(design_file_shape()), words);
    for (const std::string own : json::parse(R"(["mm", "deg", "N/m", "kg m^2", "GPa", "sqrt(",
          "atan2(", "min(", "pi", "? :", "&&", "^", "e308", "Content-Length: ", "Host: ",
          "\r\n\r\n", "POST ", "HTTP/1.1\r\n", "\"ok\":true", "\"gradient\":", "null",
          "{", "}", "[", "]", "\\u0000"])"))
      words.insert(own);
    return std::vector<std::string>(words.begin(), words.end());
  }();
  return all;
}

std::vector<std::string> corpus_of(const std::string& target, const std::filesystem::path& root) {
  std::vector<std::filesystem::path> folders{root / "tests/fuzz/corpus" / target}, files;
  if (target == "job") folders.push_back(root / "designs/jobs");
  if (target == "design") folders.push_back(root / "designs/families");
  for (const auto& folder : folders)
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.is_regular_file()) files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<std::string> texts;
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    texts.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return texts;
}

std::string mutated(const std::vector<std::string>& texts, RandomNumbers& random) {
  std::string text = texts[below(texts.size(), random)];
  const int changes = random.whole(1, 4);
  json document = json::parse(text, nullptr, false);
  if (document.is_structured() && random.chance(0.75)) {
    for (int k = 0; k < changes; ++k) change_value(document, random);
    return document.dump(-1, ' ', false, json::error_handler_t::ignore);
  }
  for (int k = 0; k < changes; ++k) change_bytes(text, texts, random);
  return text;
}

}  // namespace flexopt::fuzz
