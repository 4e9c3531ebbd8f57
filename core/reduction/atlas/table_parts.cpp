#include "core/reduction/atlas/table_parts.hpp"

namespace flexopt {
namespace {

// The parts in their order.
template <class Table, class Part>
void each_part(Table& table, const Part& part) {
  const auto numbers = static_cast<std::uint64_t>(table.numbers),
             directions = static_cast<std::uint64_t>(table.directions),
             shapes = static_cast<std::uint64_t>(table.shapes),
             rows = static_cast<std::uint64_t>(CompressedTable::block) *
                    static_cast<std::uint64_t>(CompressedTable::blocks(table.numbers));
  part(table.places, numbers);
  part(table.exponents, 2 * numbers);
  part(table.sizes, numbers);
  part(table.basis, rows * directions);
  part(table.coordinates, directions * shapes);
}

}  // namespace

void append_table(std::string& block, const CompressedTable& table) {
  each_part(table, [&](const auto* part, std::uint64_t count) { append_part(block, part, count); });
}

bool read_table(PartReader& reader, CompressedTable& table) {
  if (table.numbers < 0 || table.numbers > table.all || table.directions < 1 || table.shapes < 1)
    return false;
  bool whole = true;
  each_part(table, [&](const auto*& part, std::uint64_t count) {
    using Number =
        std::remove_const_t<std::remove_pointer_t<std::remove_reference_t<decltype(part)>>>;
    part = reader.next<Number>(count);
    whole = whole && part;
  });
  return whole;
}

}  // namespace flexopt
