#include "results/files/json_text.hpp"

#include <zlib.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace flexopt {

std::string compact_text(const OrderedJson& value) {
  return value.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

namespace {

constexpr std::size_t line_width = 100;

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
  if (std::ranges::all_of(value, [](const auto& v) { return v.is_primitive(); })) {
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

/// Byte b of all numbers before byte b + 1 of any: numbers of like size compress better.
template <class Number>
std::string bytes_by_place(const std::vector<Number>& values) {
  const std::size_t n = values.size();
  std::string bytes(n * sizeof(Number), '\0');
  for (std::size_t i = 0; i < n; ++i) {
    unsigned char own[sizeof(Number)];
    std::memcpy(own, &values[i], sizeof(Number));  // the supported processors are little-endian
    for (std::size_t b = 0; b < sizeof(Number); ++b) bytes[b * n + i] = static_cast<char>(own[b]);
  }
  return bytes;
}

std::string compressed(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string out(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), 6) != Z_OK)
    throw std::runtime_error("zlib could not compress an array");
  out.resize(size);
  return out;
}

OrderedJson packed(const char* type, const std::string& bytes,
                   const std::vector<std::size_t>& shape) {
  return {{"type", type}, {"shape", shape}, {"data", base64(compressed(bytes))}};
}

[[maybe_unused]] std::size_t product(const std::vector<std::size_t>& shape) {
  std::size_t n = 1;
  for (const std::size_t s : shape) n *= s;
  return n;
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

std::string base64(const std::string& bytes) {
  constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  const auto byte = [&](std::size_t i) {
    return i < bytes.size() ? static_cast<unsigned>(static_cast<unsigned char>(bytes[i])) : 0u;
  };
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const unsigned group = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    text += letters[group >> 18];
    text += letters[group >> 12 & 63];
    text += i + 1 < bytes.size() ? letters[group >> 6 & 63] : '=';
    text += i + 2 < bytes.size() ? letters[group & 63] : '=';
  }
  return text;
}

OrderedJson packed_floats(const std::vector<float>& values, const std::vector<std::size_t>& shape) {
  assert(product(shape) == values.size());
  return packed("float32", bytes_by_place(values), shape);
}

OrderedJson packed_rows(const std::vector<std::int16_t>& values,
                        const std::vector<std::size_t>& shape) {
  assert(product(shape) == values.size());
  const std::size_t rows = shape.empty() ? 0 : shape.front();
  const std::size_t row = rows == 0 ? 0 : values.size() / rows;
  std::vector<std::int16_t> differences = values;
  for (std::size_t i = row; i < values.size(); ++i)  // modulo 2^16
    differences[i] = static_cast<std::int16_t>(static_cast<std::uint16_t>(values[i]) -
                                               static_cast<std::uint16_t>(values[i - row]));
  return packed("int16", bytes_by_place(differences), shape);
}

}  // namespace flexopt
