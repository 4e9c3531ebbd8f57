#pragma once
// A record of the input, declared once: every row has a key, what it may hold, what it means, and
// the member that it goes to. The rows drive reading, defaults, ranges, messages, the JSON Schema
// and writing back.
#include <algorithm>
#include <concepts>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/spec/field_table.hpp"

namespace flexopt {

/// A member from what its shape read, and back (null, also of an empty text or list: nothing to
/// write). For what JSON converts by itself; other rooms specialise them for their own types.
template <class T>
void read_member(const nlohmann::json& read, T& member) {
  read.get_to(member);
}
template <class T>
void read_member(const nlohmann::json& read, std::optional<T>& member) {
  read_member(read, member.emplace());
}
template <class T>
nlohmann::json written_member(const T& member) {
  if constexpr (requires { member.empty(); })
    return member.empty() ? nlohmann::json() : nlohmann::json(member);
  else
    return member;
}
template <class T>
nlohmann::json written_member(const std::optional<T>& member) {
  return member ? written_member(*member) : nlohmann::json();
}

/// The names of an enum's values, as the input writes them.
template <class Enum>
using EnumNames = std::vector<std::pair<const char*, Enum>>;

/// The name of a value that has one.
template <class Enum>
std::string name_of(const EnumNames<Enum>& names, Enum wanted) {
  return std::ranges::find(names, wanted, &std::pair<const char*, Enum>::second)->first;
}

/// `Where` is a pointer to a member of Record, or a function that gives a reference into a record,
/// constant or not: [](auto& record) -> auto& { return record.part.member; }.
template <class Record>
class RecordTable {
 public:
  using Read = std::function<void(const nlohmann::json&, Record&)>;
  using Write = std::function<nlohmann::json(const Record&)>;

  /// Adds a row for a key that must be present.
  template <class Where>
  RecordTable& required(std::string name, Shape shape, Where where, std::string meaning) {
    return row(shape::required(std::move(name), std::move(shape), std::move(meaning)), where);
  }

  // NOLINTBEGIN(performance-unnecessary-value-param): moved on, where the template is filled in
  /// A key whose default is what a new Record holds.
  template <class Where>
  RecordTable& with_default(std::string name, Shape shape, Where where, std::string meaning) {
    const Record fresh{};
    return row(shape::with_default(std::move(name), std::move(shape),
                                   written_member(std::invoke(where, fresh)), std::move(meaning)),
               where);
  }

  /// A key that may be left out; the member then keeps its value.
  template <class Where>
  RecordTable& optional(std::string name, Shape shape, Where where, std::string meaning) {
    return row(shape::optional(std::move(name), std::move(shape), std::move(meaning)), where);
  }

  /// Adds a row for the names of an enumeration; the default is the value in a new Record.
  template <class Enum, class Where>
  RecordTable& choice(std::string name, const EnumNames<Enum>& names, Where where,
                      std::string meaning) {
    const Record fresh{};
    return enum_row(
        shape::with_default(std::move(name), shape_of(names),
                            name_of(names, std::invoke(where, fresh)), std::move(meaning)),
        names, where);
  }

  /// Adds a row for the names of an enumeration whose key may be left out.
  template <class Enum, class Where>
  RecordTable& optional_choice(std::string name, const EnumNames<Enum>& names, Where where,
                               std::string meaning) {
    return enum_row(shape::optional(std::move(name), shape_of(names), std::move(meaning)), names,
                    where);
  }
  // NOLINTEND(performance-unnecessary-value-param)

  /// Adds a row for a key with its own conversions into a record and back. `write` gives null for
  /// nothing; without it the key is never written.
  RecordTable& row(
      Field field, Read read, Write write = [](const Record&) { return nullptr; }) {
    fields_.push_back(std::move(field));
    reads_.push_back(std::move(read));
    writes_.push_back(std::move(write));
    return *this;
  }

  template <class Where>
  requires std::invocable<Where, Record&> RecordTable& row(Field field, Where where) {
    return row(
        std::move(field),
        [where](const nlohmann::json& read, Record& record) {
          read_member(read, std::invoke(where, record));
        },
        [where](const Record& record) { return written_member(std::invoke(where, record)); });
  }

  /// A key that no member takes: code reads it, because other keys decide what it means.
  RecordTable& other(Field field) {
    return row(std::move(field), [](const nlohmann::json&, Record&) {});
  }

  const std::vector<Field>& fields() const { return fields_; }
  Shape shape() const { return shape::record(fields_); }

  /// Fills in the members whose keys are present. `section` has passed the schema.
  void read(const nlohmann::json& section, Record& record) const {
    for (std::size_t i = 0; i < fields_.size(); ++i)
      if (const auto item = section.find(fields_[i].name); item != section.end())
        reads_[i](*item, record);
  }

  Record read(const nlohmann::json& section) const {
    Record record{};
    read(section, record);
    return record;
  }

  /// All members under their keys, in the form that reading accepts.
  nlohmann::json write(const Record& record) const {
    nlohmann::json section = nlohmann::json::object();
    for (std::size_t i = 0; i < fields_.size(); ++i)
      if (nlohmann::json item = writes_[i](record); !item.is_null())
        section[fields_[i].name] = std::move(item);
    return section;
  }

 private:
  template <class Enum, class Where>
  RecordTable& enum_row(Field field, const EnumNames<Enum>& names, Where where) {
    return row(
        std::move(field),
        [names, where](const nlohmann::json& read, Record& record) {
          std::string text;
          read_member(read, text);
          for (const auto& [name, value] : names)
            if (text == name) std::invoke(where, record) = value;
        },
        [names, where](const Record& record) {
          return name_of(names, std::invoke(where, record));
        });
  }

  template <class Enum>
  static Shape shape_of(const EnumNames<Enum>& names) {
    std::vector<std::string> choices;
    for (const auto& [name, value] : names) choices.emplace_back(name);
    return shape::choice(std::move(choices));
  }

  std::vector<Field> fields_;
  std::vector<Read> reads_;  ///< in the order of the fields
  std::vector<Write> writes_;
};

}  // namespace flexopt
