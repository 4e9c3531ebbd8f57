#include "results/files/json_text.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace flexopt {

std::string compact_text(const OrderedJson& value) {
  return value.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

namespace {

constexpr std::size_t line_width = 100;

bool all_primitive(const OrderedJson& value) {
  return std::all_of(value.begin(), value.end(), [](const auto& v) { return v.is_primitive(); });
}

// Text on one line of values without members of their own. Written at once, since one by one they
// cost several times as much. Blanks follow the separators outside of strings.
std::string one_line(const OrderedJson& value) {
  std::string text;
  bool in_string = false, escaped = false;
  for (const char c : compact_text(value)) {
    text += c;
    if (in_string) {
      in_string = escaped || c != '"';
      escaped = !escaped && c == '\\';
    } else {
      in_string = c == '"';
      if (c == ',' || c == ':') text += ' ';
    }
  }
  return text;
}

void print(std::string& out, const OrderedJson& value, std::size_t indent) {
  if (value.is_primitive()) {
    out += compact_text(value);
    return;
  }
  if (all_primitive(value)) {
    const std::string line = one_line(value);
    if (value.is_array() || indent + line.size() <= line_width) {
      out += line;
      return;
    }
  }
  const std::string margin(indent + 2, ' ');
  out += value.is_object() ? "{" : "[";
  bool first = true;
  for (const auto& item : value.items()) {
    out += first ? "\n" : ",\n";
    first = false;
    out += margin;
    if (value.is_object()) out += compact_text(item.key()) + ": ";
    print(out, item.value(), indent + 2);
  }
  out += "\n" + std::string(indent, ' ') + (value.is_object() ? "}" : "]");
}

}  // namespace

std::string json_text(const OrderedJson& document) {
  std::string text;
  print(text, document, 0);
  return text + "\n";
}

std::vector<std::string> remove_non_finite(OrderedJson& document, const std::string& pointer) {
  if (document.is_number_float() && !std::isfinite(document.get<double>())) {
    document = nullptr;
    return {pointer};
  }
  std::vector<std::string> found;
  if (!document.is_structured()) return found;
  for (auto& item : document.items()) {
    auto below = remove_non_finite(item.value(), pointer + "/" + item.key());
    found.insert(found.end(), below.begin(), below.end());
  }
  return found;
}

OrderedJson optional_json(const std::optional<double>& value) {
  return value ? OrderedJson(*value) : OrderedJson();
}

}  // namespace flexopt
