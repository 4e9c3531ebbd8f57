#include "core/spec/record_table.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <optional>

namespace flexopt {

using nlohmann::json;

namespace {

template <class T>
void assign(const json& read, T& member) {
  member = read.get<T>();
}

template <class T>
void assign(const json& read, std::optional<T>& member) {
  member = read.get<T>();
}

template <class T>
json value_of(const T& member) {
  return member;
}

template <class T>
json value_of(const std::optional<T>& member) {
  return member ? json(*member) : json();
}

json value_of(const std::vector<double>& member) { return member.empty() ? json() : json(member); }

json value_of(const std::string& member) { return member.empty() ? json() : json(member); }

}  // namespace

template <class T>
void read_member(const json& read, T& member) {
  assign(read, member);
}

template <class T>
json written_member(const T& member) {
  return value_of(member);
}

template void read_member(const json&, bool&);
template void read_member(const json&, int&);
template void read_member(const json&, unsigned&);
template void read_member(const json&, double&);
template void read_member(const json&, std::string&);
template void read_member(const json&, std::optional<int>&);
template void read_member(const json&, std::optional<double>&);
template void read_member(const json&, std::array<int, 2>&);
template void read_member(const json&, std::vector<double>&);

template json written_member(const bool&);
template json written_member(const int&);
template json written_member(const unsigned&);
template json written_member(const double&);
template json written_member(const std::string&);
template json written_member(const std::optional<int>&);
template json written_member(const std::optional<double>&);
template json written_member(const std::array<int, 2>&);
template json written_member(const std::vector<double>&);

}  // namespace flexopt
